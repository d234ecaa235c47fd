"""The places of the map of estimators: cells, and the motion that is made in each."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.dynamics import scene_numbers
from peg_on_hole_ros.sim.insertion_phases import end_motion
from peg_on_hole_ros.sim.plan import Plan, plan_from_tree
from peg_on_hole_ros.sim.truth import Truth, integrate
from peg_on_hole_ros.study.scenes import LEAD_IN, LEG, first_samples

# Turns as fast as the paper's go with its closing: 2 rad/s with 0.16; at most so fast [rad/s].
_TURN, _FASTEST_TURN = 12.5, 5.0
# Rates at the ends of the legs, in the speed of closing: turns that reverse, and tilt once too.
_LEGS = ((-1.0, 0.3, 1.0), (-0.5, -0.3, -1.0), (0.2, 0.3, 1.0), (-1.0, 0.3, -1.0))
# Legs are as long as this speed may take [rad/s]: further up K opens; and for so many samples.
_LEG_SPEED, _LEG_SAMPLES = 0.64, 15
_STEPS_IN = "leg1"
# Of the holder [N/m], [N m/rad]; how far it presses [m].
_STIFF, _ROTATIONAL, _PRESS = 2e4, 2e3, 1e-3
_USUAL_SIZE = 0.05
# Orientations come with every n-th wrench, at most so often [Hz].
_JOINT_RATE = 500
# A motion on three contacts lasts so long [s], or there is none.
_SHORTEST = 0.1
_RIGID = float("inf")


class MapPlace(NamedTuple):
    """
    A cell and a motion in it.

    Attributes
    ----------
    rate : float
        Of the wrench [Hz]; orientations at 500 Hz at most.
    size : float
        Diameter of the hole [m]; height, clearance and the holder's turning go with it.
    lever : float
        From the lower end of the peg to the sensor, where the holder is too [m].
    speed : float
        Of closing [rad/s].
    friction : float
    clearance : float
        [% of the diameter].
    wrench_noise, angle_noise : float
        Factors of the wrench's noise and of the orientations', stated and true alike.
    delay : float
        By which stamps of orientations are late [s]; not stated to the estimator.
    holder : float
        Factor of the holder's stiffness, under the same press.
    contact : float
        Stiffness of a contact [N/m]; contacts are stated as rigid.
    friction_step : float
        By which friction rises in mid-motion; not stated to the estimator.

    """

    rate: float = 1000.0
    size: float = _USUAL_SIZE
    lever: float = 0.07
    speed: float = 0.16
    friction: float = 0.2
    clearance: float = 0.2
    wrench_noise: float = 1.0
    angle_noise: float = 1.0
    delay: float = 0.0
    holder: float = 1.0
    contact: float = _RIGID
    friction_step: float = 0.0


USUAL = MapPlace()


class Axis(NamedTuple):
    """
    A quantity of the map.

    Attributes
    ----------
    name : str
        Of the field of `MapPlace`.
    label, unit : str
    scale : float
        Units in one of the field's.
    values : tuple of float
        That estimators are compared at, rising, in the field's unit; the usual one is among them.
    halved : bool
        Its edges are found by halving. Not where some values between take minutes to simulate.

    """

    name: str
    label: str
    unit: str
    scale: float
    values: tuple[float, ...]
    halved: bool = True

    @property
    def usual(self) -> float:
        """Return the usual value."""
        return float(getattr(USUAL, self.name))

    def place(self, value: float) -> MapPlace:
        """Return the place with a value, all else as usual."""
        return USUAL._replace(**{self.name: value})

    def rounded(self, value: float) -> float:
        """Return the nearest value that can be simulated, in three digits."""
        return float(sensor_rates(value)[0]) if self.name == "rate" else float(f"{value:.3g}")

    def text(self, value: float) -> str:
        """Return a value in its unit, in two digits."""
        if value == _RIGID:
            return "rigid"
        number = f"{float(f'{value * self.scale:.2g}'):.12g}"
        return f"{number} {self.unit}".rstrip()


MAP_AXES = (
    Axis("rate", "wrench rate", "Hz", 1.0,
         (10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10000.0, 20000.0)),
    Axis("size", "diameter", "mm", 1e3,
         (0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3)),
    Axis("lever", "sensor lever", "mm", 1e3, (0.005, 0.02, 0.07, 0.2, 0.5, 1.0, 2.0)),
    Axis("speed", "closing speed", "mrad/s", 1e3,
         (0.001, 0.003, 0.01, 0.04, 0.16, 0.64, 2.0, 5.0)),
    Axis("friction", "friction", "", 1.0, (0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.2)),
    Axis("clearance", "clearance", "%", 1.0,
         (0.002, 0.005, 0.01, 0.02, 0.05, 0.2, 1.0, 3.0, 10.0)),
    Axis("wrench_noise", "wrench noise", "times", 1.0, (0.1, 0.3, 1.0, 3.0, 10.0, 30.0)),
    Axis("angle_noise", "orientation noise", "times", 1.0, (0.1, 0.3, 1.0, 3.0, 10.0, 30.0)),
    Axis("delay", "unstated delay of joints", "ms", 1e3,
         (0.0, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02)),
    Axis("holder", "holder stiffness", "times", 1.0,
         (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0)),
    Axis("contact", "contact stiffness", "N/um", 1e-6,
         (1e6, 3e6, 1e7, 3e7, 1e8, 3e8, 1e9, 1e10, _RIGID), halved=False),
    Axis("friction_step", "unstated rise of friction", "", 1.0,
         (0.0, 0.01, 0.02, 0.05, 0.1, 0.2)),
)  # fmt: skip
_BY_NAME = {axis.name: axis for axis in MAP_AXES}


class Pair(NamedTuple):
    """Two quantities that are mapped together: across and up."""

    across: Axis
    up: Axis

    def place(self, across: float, up: float) -> MapPlace:
        """Return the place with two values, all else as usual."""
        return USUAL._replace(**{self.across.name: across, self.up.name: up})


PAIRS = (
    Pair(
        _BY_NAME["speed"]._replace(values=(0.001, 0.003, 0.01, 0.04, 0.16, 0.64, 2.0)),
        _BY_NAME["wrench_noise"]._replace(values=(0.1, 0.3, 1.0, 3.0, 10.0, 30.0)),
    ),
    Pair(
        _BY_NAME["clearance"]._replace(values=(0.005, 0.02, 0.05, 0.2, 1.0, 3.0, 10.0)),
        _BY_NAME["friction"]._replace(values=(0.0, 0.05, 0.1, 0.2, 0.4, 0.8, 1.2)),
    ),
)


def sensor_rates(rate: float) -> tuple[int, int]:
    """Return the nearest rate of wrenches that is a multiple of orientations', and theirs [Hz]."""
    every = max(1, -(-round(rate) // _JOINT_RATE))
    joint_rate = max(1, round(rate / every))
    return every * joint_rate, joint_rate


def truth_at(place: MapPlace, configuration: Configuration) -> Truth | None:
    """Return the motion at a place as far as it keeps three contacts; None: it does not begin."""
    try:
        truth = integrate(plan_at(place, configuration))
    except PegOnHoleError:
        return None
    good = (truth.mode == "three_point") & truth.known
    count = len(good) if good.all() else int(np.argmin(good))
    return first_samples(truth, count) if count >= _SHORTEST * truth.plan.wrench_rate else None


def plan_at(place: MapPlace, configuration: Configuration) -> Plan:
    """Return the plan of the motion at a place."""
    settings = _configuration_at(place, configuration)
    scene = settings.scene
    rate, joint_rate = sensor_rates(place.rate)
    # Not below a rate's samples, not above what the way allows.
    longest = LEG * _LEG_SPEED / place.speed
    leg = min(max(LEG, _LEG_SAMPLES / rate), longest)
    turn = min(_TURN * place.speed, _FASTEST_TURN)
    rates = np.array(_LEGS) * [place.speed, turn, turn]
    way = np.cumsum([LEAD_IN * rates[0], *(leg * (rates[:-1] + rates[1:]) / 2)], axis=0)
    start = 1.4 * scene.gamma0 - float(way[-1, 0])
    press = _PRESS / place.holder
    phases: dict[str, dict] = {
        "lead": {"kind": "contact", "duration": LEAD_IN, "rates": rates[0].tolist()}
    }
    for i, (to, rate_there) in enumerate(zip(way[1:], rates[1:])):
        phases[f"leg{i}"] = {"kind": "contact", "duration": leg, "rates": rate_there.tolist()}
        if place.contact != _RIGID:
            angles = to + [start, 0.0, 0.0]
            phases[f"leg{i}"] |= _into_giving_contacts(scene, angles, rate_there, press)
    if place.friction_step:
        phases[_STEPS_IN]["friction"] = place.friction + place.friction_step
    scaled = place.size / _USUAL_SIZE
    tree = {
        "lead_in": LEAD_IN,
        "holder": {
            "stiffness": _STIFF * place.holder,
            "rotational_stiffness": _ROTATIONAL * scaled**2 * place.holder,
            "force_limit": 1000.0, "torque_limit": 200.0,
        },
        "start": {
            "angles": [start, 0.0, 0.0], "rates": rates[0].tolist(), "offset": [0.0, 0.0, -press],
        },
        "phases": phases,
    }  # fmt: skip
    plan = plan_from_tree(settings, tree)
    # Beyond what a parameters file may state.
    stiffness = plan.contact_stiffness if place.contact == _RIGID else place.contact
    return replace(plan, wrench_rate=rate, joint_rate=joint_rate, contact_stiffness=stiffness)


def _configuration_at(place: MapPlace, configuration: Configuration) -> Configuration:
    """Return the true configuration; what the estimator gets leaves out what is not stated."""
    scene, wrench, joints = configuration.scene, configuration.wrench, configuration.joints
    D = place.size
    return replace(
        configuration,
        scene=replace(
            scene, hole_diameter=D, peg_diameter=D * (1.0 - 0.01 * place.clearance),
            peg_height=1.4 * D, friction=place.friction, mass_center_height=0.0,
            transverse_inertia=0.0, axial_inertia=0.0,
        ),
        wrench=replace(
            wrench, sensor_xyz=(0.0, 0.0, place.lever),
            force_stddev=wrench.force_stddev * place.wrench_noise,
            torque_stddev=wrench.torque_stddev * place.wrench_noise,
        ),
        joints=replace(
            joints, position_stddev=joints.position_stddev * place.angle_noise, delay=place.delay
        ),
    )  # fmt: skip


def _into_giving_contacts(
    scene: Scene, angles: np.ndarray, rates: np.ndarray, press: float
) -> dict:
    """Return what a leg states in place of its kind where contacts give: the same way's end."""
    x = np.zeros((3, 6))
    x[0, :3], x[0, 5], x[1, :3] = angles, -press, rates
    motion = end_motion(scene_numbers(scene), x)
    return {
        "kind": "insert", "place": motion[0, :2].tolist(),
        "depth": float(motion[0, 2]), "depth_rate": float(motion[1, 2]),
    }  # fmt: skip
