"""Where estimators hold, err or diverge: one quantity of the cell at a time, over its range."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from enum import Enum
from functools import partial
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.sim.measure import measure, sensor_wrench
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import Truth, integrate
from peg_on_hole_ros.study.chart import LEAST_DETERMINED
from peg_on_hole_ros.study.estimators import DDE_DRIVEN, by_method
from peg_on_hole_ros.study.runs import always_in_contact, errors, run
from peg_on_hole_ros.study.scenes import LEAD_IN, LEG, first_samples

COMPARED_METHODS = {
    "mixture": partial(by_method, "mixture"),
    "balance": partial(by_method, "balance"),
    "one_level": partial(by_method, "one_level"),
    "dde_driven": DDE_DRIVEN.make,
    "unscented": partial(by_method, "unscented"),
    "particles_1000": partial(by_method, "particles_1000"),
}
# Of 95 % bounds, of the least covered quantity.
LEAST_COVERAGE = 0.85
# Turns as fast as the paper's go with its closing: 2 rad/s with 0.16 rad/s.
_TURN = 12.5
# Rates at the ends of the legs, in the speed of closing: turns that reverse, and tilt once too.
_LEGS = ((-1.0, 0.3, 1.0), (-0.5, -0.3, -1.0), (0.2, 0.3, 1.0), (-1.0, 0.3, -1.0))
_HOLE, _STIFF, _ROTATIONAL = 0.05, 2e4, 2e3
_SHORTEST = 100


class Verdict(Enum):
    """What became of an estimator."""

    HOLDS = "holds"
    UNTOLD = "says that it does not know"
    ERRS = "errs: sure and wrong"
    DIVERGED = "diverged"
    NONE = "no motion on three contacts"


class MapPlace(NamedTuple):
    """
    A cell and a motion in it.

    Attributes
    ----------
    rate : float
        Of the wrench [Hz]; orientations at 500 Hz at most.
    size : float
        Diameter of the hole [m]; height, clearance and holder go with it.
    lever : float
        From the lower end of the peg to the sensor [m].
    speed : float
        Of closing [rad/s].
    friction : float
    clearance : float
        [% of the diameter].

    """

    rate: float = 1000.0
    size: float = _HOLE
    lever: float = 0.07
    speed: float = 0.16
    friction: float = 0.2
    clearance: float = 0.2


class Axis(NamedTuple):
    """
    A quantity of the map: its field in `MapPlace`, a label, and its range in the units there.

    Where there are values that sensors have, the nearest of them are taken.
    """

    name: str
    label: str
    low: float
    high: float
    usual: tuple[float, ...] = ()

    def places(self, count: int) -> Iterator[MapPlace]:
        """Yield places along the axis, all else as usual."""
        for value in np.geomspace(self.low, self.high, count).tolist():
            near = min(self.usual, key=lambda one: abs(np.log(one / value)), default=value)
            yield MapPlace(**{self.name: near})


# Those of force-torque sensors [Hz].
SENSOR_RATES = (100.0, 200.0, 250.0, 500.0, 1000.0, 2000.0, 2500.0, 4000.0, 5000.0)
MAP_AXES = (
    Axis("rate", "wrench, 100–5000 Hz", 100.0, 5000.0, SENSOR_RATES),
    Axis("size", "diameter, 4–100 mm", 0.004, 0.1),
    Axis("lever", "sensor lever, 20–400 mm", 0.02, 0.4),
    Axis("speed", "closing, 0.01–0.64 rad/s", 0.01, 0.64),
    Axis("friction", "friction, 0.05–0.6", 0.05, 0.6),
    Axis("clearance", "clearance, 0.04–4 %", 0.04, 4.0),
)
MAP_COLUMNS = (
    "axis", *MapPlace._fields,
    "method", "verdict", "reactions", "states_inside", "reactions_inside", "determined",
)  # fmt: skip


class Result(NamedTuple):
    """
    One method at one place, the worst of its seeds.

    Attributes
    ----------
    method : str
    verdict : Verdict
    reactions : float
        Root mean square of the error over the mean reaction.
    states_inside, reactions_inside : float
        Least share of a quantity within the stated 95 %; of reactions where they are determined.
    determined : float
        Share of samples.

    """

    method: str
    verdict: Verdict
    reactions: float
    states_inside: float
    reactions_inside: float
    determined: float


def truth_at(place: MapPlace, configuration: Configuration) -> Truth | None:
    """Return the motion at a place as far as it keeps three contacts; None: it does not begin."""
    D, scaled = place.size, place.size / _HOLE
    scene = replace(
        configuration.scene, hole_diameter=D, peg_diameter=D * (1.0 - 0.01 * place.clearance),
        peg_height=1.4 * D, friction=place.friction, mass_center_height=0.0,
        transverse_inertia=0.0, axial_inertia=0.0,
    )  # fmt: skip
    wrench = replace(configuration.wrench, sensor_xyz=(0.0, 0.0, place.lever))
    rate = round(place.rate)
    # Each orientation comes with a wrench.
    joint_rate = rate // -(-rate // 500)
    v, w = place.speed, min(_TURN * place.speed, 5.0)
    legs = [[v * a, w * b, w * c] for a, b, c in _LEGS]
    travel = LEG * sum((a[0] + b[0]) / 2 for a, b in zip(legs, legs[1:]))
    start = 1.4 * scene.gamma0 - travel - LEAD_IN * legs[0][0]
    phases = {"lead": {"kind": "contact", "duration": LEAD_IN, "rates": legs[0]}}
    for i, leg in enumerate(legs[1:]):
        phases[f"leg{i}"] = {"kind": "contact", "duration": LEG, "rates": leg}
    tree = {
        "lead_in": LEAD_IN,
        "wrench_rate": rate,
        "joint_rate": joint_rate,
        "holder": {
            "stiffness": _STIFF, "rotational_stiffness": _ROTATIONAL * scaled**2,
            "force_limit": 1000.0, "torque_limit": 200.0,
        },
        "start": {"angles": [start, 0.0, 0.0], "rates": legs[0], "offset": [0.0, 0.0, -1e-3]},
        "phases": phases,
    }  # fmt: skip
    plan = plan_from_tree(replace(configuration, scene=scene, wrench=wrench), tree)
    try:
        truth = integrate(plan)
    except PegOnHoleError:
        return None
    good = (truth.mode == "three_point") & truth.known
    count = len(good) if good.all() else int(np.argmin(good))
    return first_samples(truth, count) if count * 1000 >= _SHORTEST * rate else None


def examine(place: MapPlace, configuration: Configuration, seeds: Iterable[int]) -> list[Result]:
    """Return what becomes of each method at a place."""
    truth = truth_at(place, configuration)
    if truth is None:
        return [Result(name, Verdict.NONE, *(float("nan"),) * 4) for name in COMPARED_METHODS]
    exact = sensor_wrench(truth)
    measured = [list(measure(truth, seed, exact=exact)) for seed in seeds]
    found = []
    for name, make in COMPARED_METHODS.items():
        results = [_judged(name, truth, samples, make) for samples in measured]
        found.append(max(results, key=lambda result: _BADNESS[result.verdict]))
    return found


_BADNESS = {verdict: k for k, verdict in enumerate(Verdict)}


def _judged(name, truth, samples, make):
    with np.errstate(invalid="ignore", over="ignore"):
        track = run(always_in_contact(truth.plan.configuration), samples, _no_clock, make)
        off = errors(truth, track)
    verdict = Verdict.HOLDS
    if off.lost:
        verdict = Verdict.DIVERGED
    elif off.states_inside < LEAST_COVERAGE or off.reactions_inside < LEAST_COVERAGE:
        verdict = Verdict.ERRS
    elif off.determined < LEAST_DETERMINED:
        verdict = Verdict.UNTOLD
    return Result(
        name, verdict, off.reactions, off.states_inside, off.reactions_inside, off.determined
    )


def _no_clock():
    return 0.0
