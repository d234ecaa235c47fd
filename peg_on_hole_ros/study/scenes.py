"""Motions on three contacts that methods are compared on, and what the sensors say of them."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.sim.plan import plan_from_tree
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
# Tilt over gamma0 at the end, start offset [m], and rates [rad/s] at the ends of legs of LEG [s].
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
MOTION_NAMES = tuple(_MOTIONS)


class Case(NamedTuple):
    """
    A motion in a scene that differs from the configuration's by factors.

    Attributes
    ----------
    name : str
    motion : str
        Of MOTION_NAMES.
    clearance, friction, speed, noise : float
        Factors of the clearance, the friction coefficient, the rates and all sensors' noise.

    """

    name: str
    motion: str
    clearance: float = 1.0
    friction: float = 1.0
    speed: float = 1.0
    noise: float = 1.0


CASES = (
    *(Case(name, name) for name in MOTION_NAMES),
    Case("slow", "closing with slip", speed=1 / 16),
    Case("fast", "closing with slip", speed=4.0),
    Case("narrow", "closing with slip", clearance=0.2),
    Case("wide", "closing with slip", clearance=5.0),
    Case("slippery", "closing with slip", friction=0.25),
    Case("rough", "closing with slip", friction=2.5),
    Case("noisy", "closing with slip", noise=5.0),
    Case("quiet", "closing without slip", noise=0.2),
    Case("wide, reversals", "reversals", clearance=5.0),
)


def case_configuration(case: Case, configuration: Configuration) -> Configuration:
    """Return the configuration of a case: what is there, and what the estimator is told."""
    scene, wrench, joints = configuration.scene, configuration.wrench, configuration.joints
    clearance = (scene.hole_diameter - scene.peg_diameter) * case.clearance
    return replace(
        configuration,
        scene=replace(
            scene,
            peg_diameter=scene.hole_diameter - clearance,
            friction=scene.friction * case.friction,
        ),
        wrench=replace(
            wrench,
            force_stddev=wrench.force_stddev * case.noise,
            torque_stddev=wrench.torque_stddev * case.noise,
        ),
        joints=replace(joints, position_stddev=joints.position_stddev * case.noise),
    )


def truth_of(case: Case, configuration: Configuration) -> Truth:
    """Return the motion of a case, as long as it keeps three contacts."""
    configuration = case_configuration(case, configuration)
    end, offset, rates = _MOTIONS[case.motion]
    rates = [[case.speed * float(value) for value in rate] for rate in rates]
    travel = LEG * sum((a[0] + b[0]) / 2 for a, b in zip(rates, rates[1:]))
    start = end * configuration.scene.gamma0 - travel - LEAD_IN * rates[0][0]
    phases = {"lead": {"kind": "contact", "duration": LEAD_IN, "rates": rates[0]}}
    for i, rate in enumerate(rates[1:]):
        phases[f"leg{i}"] = {"kind": "contact", "duration": LEG, "rates": rate}
    tree = {
        "lead_in": LEAD_IN,
        "start": {"angles": [start, 0.0, 0.0], "rates": rates[0], "offset": list(offset)},
        "phases": phases,
    }
    truth = integrate(plan_from_tree(configuration, tree))
    good = (truth.mode == "three_point") & truth.known
    return first_samples(truth, len(good) if good.all() else int(np.argmin(good)))


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
