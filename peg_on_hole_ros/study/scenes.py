"""Motions that methods are compared on, by kind of scene, and what the sensors say of them."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.sim.measure import measure, measured_angles
from peg_on_hole_ros.sim.plan import Holder, plan_from_tree
from peg_on_hole_ros.sim.truth import Truth, integrate
from peg_on_hole_ros.study.bound import (
    Bound,
    Meaning,
    Sensors,
    Smoothness,
    TrueMotion,
    posterior_bound,
    smoothness,
)

LEAD_IN = 0.05
# Accelerations of the calmest holder, as of the default's lowest level [rad/s^2], [s].
CALMEST, FADES = 3.0, 0.05
# Rates at the ends of legs of LEG [s]; tilt over gamma0 at the end, and start offset [m].
_MOTIONS: dict[str, Any] = {
    "closing with slip": (1.25, (0.0, 0.0, -0.001), [(-0.16, 0, 2)] * 4),
    "closing without slip": (1.25, (-0.0005, 0.0, -0.001), [(-0.16, 0, 0)] * 4),
    "reversals": (
        1.4,
        (0.0, 0.0, -0.001),
        [(-0.16, 0.6, 2), (-0.08, -0.6, -2), (0.03, 0.6, 2), (-0.16, 0.6, -2)],
    ),
}
LEG = 0.15
MOTION_NAMES = (*_MOTIONS, "in the hole")
# Of the hole that the holder's stiffness is that of [m].
_USUAL_HOLE = 0.05
# Waves of three gears along the motion [Hz]: two a turn of a fast shaft, at some 0.05 rad/s.
# Commanded in the hole, of the tilt that the play leaves: the holder bends by the rest.
_FORCED = 2.0
_WAVES = (1.3, 2.9, 4.7)


class Case(NamedTuple):
    """
    A motion in a scene that differs from the configuration's, most of it by factors.

    Attributes
    ----------
    name : str
    motion : str
        Of MOTION_NAMES.
    clearance, friction, speed : float
        Factors of the clearance, the friction coefficient and the rates.
    size, lever, press : float
        Factors of the parts, of the sensor's distance from the peg's end over theirs, and of how
        far the holder presses; the clearance keeps its share of the diameter.
    wrench_noise, joint_noise : float
        Factors of the sensors' noise.
    gears : float
        By how much each of three gears turns the orientation to and fro along its motion [rad].
    frictions : tuple of float
        True friction during each leg, over the stated one; empty: as stated.

    """

    name: str
    motion: str
    clearance: float = 1.0
    friction: float = 1.0
    speed: float = 1.0
    size: float = 1.0
    lever: float = 1.0
    press: float = 1.0
    wrench_noise: float = 1.0
    joint_noise: float = 1.0
    gears: float = 0.0
    frictions: tuple[float, ...] = ()

    @property
    def told(self) -> bool:
        """Whether an estimator is told that the peg is on three contacts; else it judges."""
        return self.motion != "in the hole"


_SLIP, _STRAIGHT, _TURNS, _HOLE = MOTION_NAMES
# A peg of 8 mm 0.22 m below the sensor; an arm with gears, and a friction that is none stated.
_SMALL = Case("small peg", _SLIP, size=0.16, lever=20.0, press=0.5)
_ROBOT = Case(
    "robot cell", _SLIP, speed=1 / 4, wrench_noise=7.5, joint_noise=2.0, gears=2e-4,
    frictions=(1.2, 1.2, 1.2),
)  # fmt: skip
# What is charted by itself: a cell has one of these, and methods differ from one to the next.
SCENE_KINDS: dict[str, tuple[Case, ...]] = {
    "closing": (
        Case("closing with slip", _SLIP),
        Case("closing without slip", _STRAIGHT),
        Case("narrow", _SLIP, clearance=0.2),
        Case("wide", _SLIP, clearance=5.0),
        Case("slippery", _SLIP, friction=0.25),
        Case("rough", _SLIP, friction=2.5),
        Case("noisy", _SLIP, wrench_noise=5.0, joint_noise=5.0),
    ),
    "slow closing": (
        Case("slow with slip", _SLIP, speed=1 / 16),
        Case("slow without slip", _STRAIGHT, speed=1 / 16),
    ),
    "reversals": (
        Case("reversals", _TURNS),
        Case("reversals, wide", _TURNS, clearance=5.0),
        Case("reversals, slow", _TURNS, speed=1 / 4),
    ),
    "begins fast": (Case("fast", _SLIP, speed=4.0),),
    "small peg, long lever": (
        _SMALL,
        _SMALL._replace(name="small peg, reversals", motion=_TURNS, speed=0.5),
    ),
    "robot cell": (
        _ROBOT,
        _ROBOT._replace(name="robot cell, reversals", motion=_TURNS),
    ),
    "in the hole": (
        Case("in the hole", _HOLE),
        Case("in the hole, narrow", _HOLE, clearance=0.5),
    ),
    "changing friction": (
        Case("friction steps up", _SLIP, frictions=(1.0, 1.0, 1.5)),
        Case(
            "friction steps down",
            _SLIP,
            speed=1 / 4,
            frictions=(1.0, 0.75, 0.75),
        ),
    ),
}
CASES = tuple(case for cases in SCENE_KINDS.values() for case in cases)


def case_configuration(case: Case, configuration: Configuration) -> Configuration:
    """Return the configuration of a case: what is there, and what the estimator is told."""
    scene, wrench, joints = configuration.scene, configuration.wrench, configuration.joints
    D = scene.hole_diameter * case.size
    clearance = (scene.hole_diameter - scene.peg_diameter) * case.clearance * case.size
    x, y, z = (part * case.size * case.lever for part in wrench.sensor_xyz)
    return replace(
        configuration,
        scene=replace(
            scene,
            hole_diameter=D,
            peg_diameter=D - clearance,
            peg_height=scene.peg_height * case.size,
            mass_center_height=scene.mass_center_height * case.size,
            transverse_inertia=scene.transverse_inertia * case.size**2,
            axial_inertia=scene.axial_inertia * case.size**2,
            friction=scene.friction * case.friction,
        ),
        wrench=replace(
            wrench,
            sensor_xyz=(x, y, z),
            force_stddev=wrench.force_stddev * case.wrench_noise,
            torque_stddev=wrench.torque_stddev * case.wrench_noise,
        ),
        joints=replace(joints, position_stddev=joints.position_stddev * case.joint_noise),
    )


def truth_of(case: Case, configuration: Configuration) -> Truth:
    """Return the motion of a case, as long as it keeps three contacts; in the hole all of it."""
    configuration = case_configuration(case, configuration)
    holder = {"rotational_stiffness": Holder.rotational_stiffness * case.size**2}
    if case.motion == "in the hole":
        return integrate(
            plan_from_tree(configuration, _into_the_hole(configuration.scene, holder))
        )
    end, offset, rates = _MOTIONS[case.motion]
    rates = [[case.speed * float(value) for value in rate] for rate in rates]
    travel = LEG * sum((a[0] + b[0]) / 2 for a, b in zip(rates, rates[1:]))
    start = end * configuration.scene.gamma0 - travel - LEAD_IN * rates[0][0]
    contact: dict[str, Any] = {"kind": "contact", "duration": LEG}
    phases = {f"leg{i}": {**contact, "rates": rate} for i, rate in enumerate(rates[1:])}
    phases = {"lead": {**contact, "duration": LEAD_IN, "rates": rates[0]}, **phases}
    for phase, factor in zip(phases.values(), (*case.frictions[:1], *case.frictions)):
        phase["friction"] = configuration.scene.friction * factor
    tree = {
        "lead_in": LEAD_IN,
        "holder": holder,
        "start": {
            "angles": [start, 0.0, 0.0],
            "rates": rates[0],
            "offset": [case.press * part for part in offset],
        },
        "phases": phases,
    }
    truth = integrate(plan_from_tree(configuration, tree))
    good = (truth.mode == "three_point") & truth.known
    return first_samples(truth, len(good) if good.all() else int(np.argmin(good)))


def _into_the_hole(scene, holder):
    """Return a plan that sets the peg down with a twist and slides on, forced to the walls."""
    D, clearance = scene.hole_diameter, scene.hole_diameter - scene.peg_diameter
    insert = {"kind": "insert", "rates": [0.0, 0.0, 0.0]}

    def at(depth):
        return {"angles": [_FORCED * clearance / (depth * D), 0.0, 0.0], "depth": depth * D}

    return {
        "lead_in": LEAD_IN,
        "holder": {"stiffness": 1e4, **holder, "rotational_stiffness": 80.0},
        "start": {
            "angles": [scene.gamma0 + 0.03, 0.0, 0.0],
            "rates": [-0.2, 0.0, 1.5],
            "offset": [0.0, 0.0, -1e-3],
        },
        "phases": {
            "close": {"kind": "insert", "duration": 0.1, "rates": [-0.2, 0.0, 1.5]},
            "through": {**insert, "duration": 0.2, **at(0.2)},
            "go_in": {**insert, "duration": 0.4, **at(0.45), "depth_rate": 0.03},
            "down": {**insert, "duration": 0.4, **at(0.85)},
        },
    }


def working_cycle(configuration: Configuration) -> Truth:
    """Return a whole cycle: approach, closing, rest, lift-off, again, and into the hole."""
    still, turn = [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]
    gamma0 = configuration.scene.gamma0
    phases = {
        "approach": {"kind": "free", "duration": 0.6, "rates": turn, "offset": still},
        "touch": {"kind": "contact", "duration": 0.3, "rates": turn,
                  "offset": [-5e-4, 0.0, -1.5e-3]},
        "close": {"kind": "contact", "duration": 1.0, "rates": [-0.12, 0.6, 1.2]},
        "reverse": {"kind": "contact", "duration": 1.0, "rates": [-0.02, -0.6, -1.2]},
        "come_to_rest": {"kind": "contact", "duration": 0.5},
        "rest": {"kind": "contact", "duration": 0.6},
        "turn": {"kind": "contact", "duration": 0.3, "rates": [0.0, 0.0, 1.0],
                 "offset": [0.0, 0.0, -1e-3]},
        "let_go": {"kind": "lift_off", "duration": 0.4, "rates": [0.0, 0.0, 0.5],
                   "offset": [0.0, 0.0, 4e-3]},
        "in_the_air": {"kind": "free", "duration": 0.6, "angles": [gamma0 + 0.13, 0.2, 0.8],
                       "rates": turn, "offset": still},
        "touch_again": {"kind": "contact", "duration": 0.3, "rates": turn,
                        "offset": [0.0, 0.0, -1e-3]},
        "close_again": {"kind": "contact", "duration": 0.5, "rates": [-0.16, 0.3, 1.5]},
        "go_in": {"kind": "two_point", "duration": 0.8, "rates": [-0.06, 0.3, 1.5],
                  "load": [60.0, 60.0]},
        "insert": {"kind": "two_point", "duration": 0.5, "angles": [0.3 * gamma0, 0.8, 3.0],
                   "load": [20.0, 20.0]},
    }  # fmt: skip
    start = {"angles": [gamma0 + 0.25, 0.4, 0.0], "offset": [0.0, 0.0, 0.01]}
    holder = {"force_limit": 2000.0, "torque_limit": 200.0}
    tree = {"settle": 0.06, "start": start, "holder": holder, "phases": phases}
    return integrate(plan_from_tree(configuration, tree))


def measured(case: Case, truth: Truth, seed: int) -> list[WrenchSample | JointSample]:
    """Return what the sensors say of a truth, with noise of a seed and the case's gears."""
    samples = list(measure(truth, seed))
    if case.gears == 0.0:
        return samples
    phase = np.random.default_rng([seed, 1]).uniform(0.0, 2.0 * np.pi, 3)
    joints = {k: sample for k, sample in enumerate(samples) if isinstance(sample, JointSample)}
    t = np.array([sample.t_ns for sample in joints.values()]) * 1e-9
    turned = case.gears * np.sin(2.0 * np.pi * np.outer(t, _WAVES) + phase)
    angles = measured_angles(np.array([sample.position for sample in joints.values()]), turned)
    for k, row in zip(joints, angles):
        samples[k] = JointSample(samples[k].t_ns, joints[k].names, tuple(row.tolist()))
    return samples


def first_samples(truth: Truth, count: int) -> Truth:
    """Return a truth of which only the first samples are left."""
    n = len(truth.t_ns)
    cut = {
        name: value[:count]
        for name, value in vars(truth).items()
        if isinstance(value, np.ndarray) and len(value) == n
    }
    return replace(truth, **cut)  # type: ignore[arg-type]


def true_wrench(truth: Truth) -> np.ndarray:
    """Return the wrench about the mass centre in peg axes [N], [N m], shape (n, 6)."""
    R_HP = np.array([peg_axes(q) for q in truth.q])
    parts = [np.einsum("nji,nj->ni", R_HP, value) for value in (truth.force, truth.moment)]
    return np.hstack(parts)


def holder_of(t: np.ndarray, rates: np.ndarray) -> Smoothness:
    """
    Return how smoothly a holder moves a peg that moves so: its own level, and the calmest's.

    A motion of constant rates has no accelerations, but nobody knows that before it is over.

    Parameters
    ----------
    t : ndarray, shape (n,)
        [s].
    rates : ndarray, shape (n, 3)
        [rad/s].

    """
    own = smoothness(t, np.gradient(rates, t, axis=0))
    calm = own.level < CALMEST
    return Smoothness(np.where(calm, CALMEST, own.level), np.where(calm, FADES, own.time))


def bound_along(truth: Truth) -> Bound:
    """Return the bound of any estimator along a truth, for what the configuration states."""
    configuration = truth.plan.configuration
    scene, options = configuration.scene, configuration.filter
    every = truth.plan.wrench_rate // truth.plan.joint_rate
    sensors = Sensors(
        WrenchReduction(configuration.wrench, scene).covariance,
        configuration.joints.position_stddev,
        np.arange(len(truth.t_ns)) % every == 0,
    )
    learnt = scene.friction_stddev > 0.0 and options.friction == "estimated"
    t = truth.t_ns * 1e-9
    return posterior_bound(
        scene, TrueMotion(t, np.hstack([truth.q, truth.rates]), true_wrench(truth)), sensors,
        options.initial_rate_stddev, truth.plan.slip_velocity_scale,
        holder_of(t, truth.rates),
        options.friction_noise if learnt else 0.0,
    )  # fmt: skip


class Least(NamedTuple):
    """The bound on errors as of `runs.Errors`, over where it is sound; NaN: nowhere."""

    reactions: float
    tilt_rate: float


def least_errors(truth: Truth, bound: Bound) -> Least:
    """Return the bound on the errors over a motion."""
    sound = bound.meaning == Meaning.SOUND
    if not sound.any():
        return Least(float("nan"), float("nan"))
    variance = np.diagonal(bound.reactions[sound], axis1=1, axis2=2)
    return Least(
        float(np.sqrt(variance.mean()) / truth.normal.mean()),
        float(np.sqrt(bound.state[sound, 3, 3].mean())),
    )
