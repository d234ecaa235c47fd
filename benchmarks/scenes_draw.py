"""Insertion scenes with drawn parameters: what is commanded, what the estimator is told."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.options import Configuration, JointInput, MonitorOptions, WrenchInput
from peg_on_hole_ros.simulation.plan import Plan, plan_from_tree

FAMILIES = (
    "insertion",
    "wedge",
    "stall",
    "overpress",
    "tipped",
    "friction_jump",
    "clearance",
    "contact_loss",
    "retry",
)
# First of the two numbers that a draw is seeded with: no scene is of both sets.
SEEDS = {"scoring": 7_100, "tuning": 3_900}
D = 0.050
LEAD_IN = 0.05
FRICTION_OFF = 0.30
CLEARANCE_OFF = 0.20


class Case(NamedTuple):
    """One scene: its family, its number in it, and whether it is for tuning or for scoring."""

    family: str
    number: int
    set: str = "scoring"

    def __str__(self):
        """Return a name for files and tables."""
        return f"{self.family}_{self.number:03d}_{self.set}"

    @property
    def seed(self) -> list[int]:
        """Return what the draw, and with one more number the noise, is seeded with."""
        return [SEEDS[self.set], FAMILIES.index(self.family), self.number]


class Draw:
    """Draws that read like ranges."""

    def __init__(self, seed):
        self._rng = np.random.default_rng(seed)

    def even(self, low, high) -> float:
        """Return a number of a range, each as likely."""
        return float(self._rng.uniform(low, high))

    def log(self, low, high) -> float:
        """Return a number of a range, each order of magnitude as likely."""
        return float(np.exp(self._rng.uniform(np.log(low), np.log(high))))

    def sign(self) -> float:
        """Return 1 or -1."""
        return float(self._rng.choice((-1.0, 1.0)))

    def chance(self, share) -> bool:
        """Return True with a probability."""
        return bool(self._rng.random() < share)


class Setting(NamedTuple):
    """What every family draws; a family replaces what it is about."""

    clearance: float
    friction: float
    mass: float
    speed: float  # of closing [rad/s]
    slide: float  # psi' [rad/s]
    slip: float  # phi' [rad/s]
    press: float  # commanded into the hole [m]
    stiffness: float
    rotational_stiffness: float
    noise: float
    max_normal: float

    @property
    def scene(self) -> Scene:
        """Return the true scene."""
        return Scene(
            hole_diameter=D,
            peg_diameter=D - self.clearance,
            friction=self.friction,
            peg_mass=self.mass,
        )


def setting_of(draw: Draw, **given) -> Setting:
    """Return a setting with what is given in place of what would be drawn."""
    drawn = Setting(
        clearance=draw.log(5e-5, 4e-4),
        friction=draw.even(0.1, 0.3),
        mass=draw.even(0.3, 1.0),
        speed=draw.log(0.06, 0.4),
        slide=draw.even(-0.3, 0.3),
        slip=draw.sign() * draw.even(1.0, 3.0),
        press=draw.even(0.5e-3, 1.5e-3),
        stiffness=2e4 * draw.log(0.6, 1.6),
        rotational_stiffness=2e3 * draw.log(0.6, 1.6),
        noise=draw.log(0.5, 2.0),
        max_normal=1000.0,
    )
    drawn = drawn._replace(**given)
    # Not more than the hole's tilt left to go on after the transition.
    return drawn._replace(speed=min(drawn.speed, 3.0 * drawn.scene.gamma0))


def plan_of(case: Case) -> Plan:
    """Return what is simulated; the same case gives the same plan."""
    setting, start, phases = _FAMILY[case.family](Draw(case.seed))
    s = setting
    configuration = Configuration(
        scene=s.scene,
        wrench=WrenchInput(force_stddev=0.2 * s.noise, torque_stddev=0.005 * s.noise),
        joints=JointInput(position_stddev=1e-4 * s.noise),
        monitor=MonitorOptions(max_normal=(s.max_normal,) * 3),
    )
    tree = {
        "lead_in": LEAD_IN,
        "settle": 0.04,
        "holder": {
            "stiffness": s.stiffness,
            "rotational_stiffness": s.rotational_stiffness,
            "force_limit": 1500.0,
            "torque_limit": 40.0,
        },
        "start": start,
        "phases": phases,
    }
    return plan_from_tree(configuration, tree)


def estimator_of(case: Case, plan: Plan, mismatch: bool) -> Configuration:
    """
    Return what the estimator is told.

    With a mismatch friction is 30 % off, and clearance 20 % with `clearance_stddev` as large:
    up or down, each drawn. `friction_stddev` is the default in both.

    """
    if not mismatch:
        return plan.configuration
    draw, scene = Draw([*case.seed, 2]), plan.configuration.scene
    friction = scene.friction * (1 + draw.sign() * FRICTION_OFF)
    clearance = scene.hole_diameter - scene.peg_diameter
    told = clearance * (1 + draw.sign() * CLEARANCE_OFF)
    scene = replace(
        scene,
        friction=friction,
        peg_diameter=scene.hole_diameter - told,
        clearance_stddev=CLEARANCE_OFF * told,
    )
    return replace(plan.configuration, scene=scene)


def noise_seed(case: Case) -> list[int]:
    """Return the seed of the sensors' noise."""
    return [*case.seed, 1]


def _touching(setting, tilt, rates, offset=None):
    """Return the begin on three contacts, and the lead-in at constant rates."""
    offset = offset or [0.0, 0.0, -setting.press]
    lead = {"kind": "contact", "duration": LEAD_IN, "rates": rates}
    start = {
        "angles": [setting.scene.gamma0 + tilt - LEAD_IN * rates[0], 0.0, 0.0],
        "rates": rates,
        "offset": offset,
    }
    return start, {"lead": lead}


def _rates(setting):
    return [-setting.speed, setting.slide, setting.slip]


def _enter(draw, setting):
    """Return the phase in which the holder goes on in the hole, and comes to rest."""
    return {
        "kind": "two_point",
        "duration": 0.2,
        "rates": [0.0, 0.0, setting.slip],
        "load": [draw.even(10.0, 50.0)] * 2,
    }


def _close(draw, setting, **more):
    """Return a begin in contact and the way through gamma0 into the hole."""
    rates, closing = _rates(setting), draw.even(0.25, 0.45)
    start, phases = _touching(setting, setting.speed * closing, rates)
    phases["close"] = {"kind": "two_point", "duration": closing + 0.03, "rates": rates, **more}
    phases["enter"] = _enter(draw, setting)
    return setting, start, phases


def _insertion(draw):
    setting = setting_of(draw)
    if draw.chance(0.7):
        return _close(draw, setting)
    # From free air: a lead-in and 0.1 s free, landing, then as above.
    closing = draw.even(0.2, 0.3)
    tilt = setting.speed * (closing + 0.06)
    start = {
        "angles": [setting.scene.gamma0 + tilt, 0.0, 0.0],
        "rates": [0.0, 0.0, setting.slip],
        "offset": [0.0, 0.0, 0.003],
    }
    rates = [0.0, 0.0, setting.slip]
    phases = {
        "approach": {"kind": "free", "duration": 0.15, "rates": rates, "offset": [0.0, 0.0, 0.0]},
        "press": {
            "kind": "contact", "duration": 0.12, "rates": _rates(setting),
            "offset": [0.0, 0.0, -setting.press],
        },
        "close": {"kind": "two_point", "duration": closing + 0.03, "rates": _rates(setting)},
        "enter": _enter(draw, setting),
    }  # fmt: skip
    return setting, start, phases


def _wedge(draw):
    slip = draw.sign() * draw.log(0.03, 0.5) if draw.chance(0.25) else 0.0
    setting = setting_of(
        draw,
        clearance=draw.log(5e-5, 2.5e-4),
        friction=draw.even(0.12, 0.4),
        speed=draw.log(0.06, 0.3),
        slide=0.0,
        slip=slip,
        press=draw.even(1e-3, 2e-3),
    )
    return _close(draw, setting)


def _stall(draw):
    """Return a soft holder whose press rises faster than its pull on the tilt."""
    setting = setting_of(
        draw,
        clearance=draw.log(1e-4, 5e-4),
        friction=draw.even(0.2, 0.45),
        speed=draw.log(0.06, 0.2),
        slide=0.0,
        slip=0.0 if draw.chance(0.7) else draw.sign() * draw.log(0.02, 0.2),
        press=draw.even(0.5e-3, 1.0e-3),
        rotational_stiffness=draw.log(80.0, 300.0),
    )
    rates, before = _rates(setting), draw.even(0.1, 0.2)
    start, phases = _touching(setting, setting.speed * draw.even(0.45, 0.7), rates)
    phases["close"] = {"kind": "contact", "duration": before, "rates": rates}
    phases["press"] = {
        "kind": "two_point",
        "duration": draw.even(0.2, 0.35),
        "rates": rates,
        "offset": [0.0, 0.0, -draw.even(4e-3, 14e-3)],
    }
    phases["hold"] = {"kind": "two_point", "duration": 0.2, "rates": rates}
    return setting, start, phases


def _overpress(draw):
    setting = setting_of(draw, max_normal=draw.log(200.0, 800.0))
    rates, before = _rates(setting), draw.even(0.1, 0.2)
    start, phases = _touching(setting, setting.speed * 0.75, rates)
    phases["close"] = {"kind": "contact", "duration": before, "rates": rates}
    phases["press"] = {
        "kind": "contact",
        "duration": draw.even(0.2, 0.4),
        "rates": rates,
        "offset": [0.0, 0.0, -draw.log(3e-3, 12e-3)],
    }
    phases["hold"] = {"kind": "contact", "duration": 0.1, "rates": rates}
    return setting, start, phases


def _tipped(draw):
    setting = setting_of(draw, slide=0.0, slip=0.0, press=draw.even(0.4e-3, 1e-3))
    rates, before = _rates(setting), draw.even(0.1, 0.25)
    tilt = setting.speed * (before + 0.25) + draw.even(0.05, 0.12)
    start, phases = _touching(setting, tilt, rates, [-5e-4, 0.0, -setting.press])
    phases["close"] = {"kind": "parted", "duration": before, "rates": rates}
    phases["tip"] = {
        "kind": "parted",
        "duration": draw.even(0.15, 0.3),
        "rates": rates,
        "offset": [draw.even(0.5e-3, 2e-3), draw.even(-1e-3, 1e-3), -draw.even(0.0, 5e-4)],
    }
    phases["hold"] = {"kind": "parted", "duration": 0.1, "rates": rates}
    return setting, start, phases


def _friction_jump(draw):
    up = draw.chance(0.75)
    setting = setting_of(draw, slip=draw.sign() * draw.log(0.2, 2.0))
    factor = draw.even(1.5, 3.0) if up else draw.even(0.3, 0.6)
    rates, before = _rates(setting), draw.even(0.1, 0.2)
    after = draw.even(0.15, 0.3)
    start, phases = _touching(setting, setting.speed * (before + after), rates)
    phases["close"] = {"kind": "two_point", "duration": before, "rates": rates}
    phases["jump"] = {
        "kind": "two_point",
        "duration": after + 0.03,
        "rates": rates,
        "friction": setting.friction * factor,
    }
    phases["enter"] = _enter(draw, setting)
    return setting, start, phases


def _clearance(draw):
    tight = draw.chance(0.5)
    clearance = draw.log(2e-5, 5e-5) if tight else draw.log(5e-4, 2e-3)
    return _close(draw, setting_of(draw, clearance=clearance))


def _leave(draw, setting):
    """Return the way off the rim and into the air."""
    height = draw.even(2e-3, 4e-3)
    return {
        "let_go": {
            "kind": "lift_off", "duration": draw.even(0.12, 0.2),
            "rates": [0.0, 0.0, setting.slip], "offset": [0.0, 0.0, height],
        },
        "away": {
            "kind": "free", "duration": 0.12, "rates": [0.0, 0.0, setting.slip],
            "offset": [0.0, 0.0, height + 2e-3],
        },
    }  # fmt: skip


def _contact_loss(draw):
    setting = setting_of(draw)
    before = draw.even(0.15, 0.35)
    tilt = setting.speed * (before + 0.1) + draw.even(0.03, 0.1)
    start, phases = _touching(setting, tilt, _rates(setting))
    phases["close"] = {"kind": "contact", "duration": before, "rates": _rates(setting)}
    return setting, start, phases | _leave(draw, setting)


def _retry(draw):
    """Return a try that is broken off, and in two of three draws a second that goes in."""
    setting = setting_of(draw, press=draw.even(0.5e-3, 1e-3))
    rates, closing = _rates(setting), draw.even(0.15, 0.2)
    back = [0.5 * setting.speed, 0.0, setting.slip]
    tilt = setting.speed * closing + draw.even(0.01, 0.03)
    start, phases = _touching(setting, tilt, rates)
    phases["close"] = {"kind": "contact", "duration": 0.12, "rates": rates}
    phases["reverse"] = {"kind": "contact", "duration": 0.06, "rates": back}
    phases |= _leave(draw, setting)
    phases["let_go"]["duration"] = 0.12
    if draw.chance(1 / 3):
        return setting, start, phases
    spin = [0.0, 0.0, setting.slip]
    tilt = setting.speed * (closing + 0.05)
    angles = [setting.scene.gamma0 + tilt, 0.0, 0.0]
    phases["away"] = {
        "kind": "free", "duration": 0.15, "rates": spin, "angles": angles,
        "offset": [0.0, 0.0, 0.0],
    }  # fmt: skip
    phases["press"] = {
        "kind": "contact", "duration": 0.1, "rates": rates,
        "offset": [0.0, 0.0, -setting.press],
    }  # fmt: skip
    phases["close_again"] = {"kind": "two_point", "duration": closing + 0.03, "rates": rates}
    phases["enter"] = _enter(draw, setting) | {"duration": 0.15}
    return setting, start, phases


_FAMILY = {
    "insertion": _insertion,
    "wedge": _wedge,
    "stall": _stall,
    "overpress": _overpress,
    "tipped": _tipped,
    "friction_jump": _friction_jump,
    "clearance": _clearance,
    "contact_loss": _contact_loss,
    "retry": _retry,
}
