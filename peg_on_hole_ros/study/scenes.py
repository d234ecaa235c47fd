"""Motions on three contacts that methods are compared on, and what the sensors say of them."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.bound import Bound, Meaning, Sensors, posterior_bound
from peg_on_hole_ros.estimation.measurement import PegJoints, WrenchReduction
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.simulation.measure import measure, sensor_wrench
from peg_on_hole_ros.simulation.plan import plan_from_tree
from peg_on_hole_ros.simulation.truth import Truth, integrate

LEAD_IN = 0.05
# Tilt over gamma0 at the end, start offset [m], and rates [rad/s] at the ends of legs of LEG [s].
_MOTIONS = {
    "closing with slip": (1.25, (0.0, 0.0, -0.001), [(-0.16, 0, 2)] * 4),
    "closing without slip": (1.25, (-0.0005, 0.0, -0.001), [(-0.16, 0, 0)] * 4),
    "reversals": (
        1.4,
        (0.0, 0.0, -0.001),
        [(-0.16, 0.6, 2), (-0.08, -0.6, -2), (0.03, 0.6, 2), (-0.16, 0.6, -2)],
    ),
}
LEG = 0.15
NAMES = tuple(_MOTIONS)


class Case(NamedTuple):
    """
    A motion in a scene that differs from the configuration's by factors.

    Attributes
    ----------
    name : str
    motion : str
        Of NAMES.
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
    *(Case(name, name) for name in NAMES),
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


class Recording(NamedTuple):
    """
    A measured motion as a filter takes it, a row a wrench; every row has an orientation or none.

    Attributes
    ----------
    dt : float
        Between two wrenches [s].
    wrench : ndarray, shape (n, 6)
        On the peg about its mass centre, peg axes [N], [N m].
    angles : ndarray, shape (n, 3)
        gamma, psi, phi [rad]; NaN where none was measured.
    covariances : ndarray, shape (n, 3, 3)
        [rad^2].

    """

    dt: float
    wrench: np.ndarray
    angles: np.ndarray
    covariances: np.ndarray


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
    return replace(truth, **cut)


def true_wrench(truth: Truth) -> np.ndarray:
    """Return the wrench about the mass centre in peg axes [N], [N m], shape (n, 6)."""
    R_HP = np.array([peg_axes(q) for q in truth.q])
    parts = [np.einsum("nji,nj->ni", R_HP, value) for value in (truth.force, truth.moment)]
    return np.hstack(parts)


def recorded(truth: Truth, seed: int) -> Recording:
    """Return what the sensors say of a truth, reduced to the mass centre."""
    configuration = truth.plan.configuration
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    orientation = PegJoints(configuration.joints)
    n = len(truth.t_ns)
    wrench, angles = np.empty((n, 6)), np.full((n, 3), np.nan)
    covariances = np.full((n, 3, 3), np.nan)
    row, q = 0, None
    for sample in measure(truth, seed, exact=sensor_wrench(truth)):
        if isinstance(sample, JointSample):
            q = orientation(sample)
            continue
        if q is not None:
            angles[row], covariances[row] = q.q, q.covariance
        wrench[row] = reduction.on_peg(sample.force, sample.torque, None if q is None else q.q)
        row, q = row + 1, None
    return Recording(1.0 / truth.plan.wrench_rate, wrench, angles, covariances)


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
    return posterior_bound(
        scene, truth.t_ns * 1e-9, np.hstack([truth.q, truth.rates]), true_wrench(truth), sensors,
        options.initial_rate_stddev, truth.plan.slip_velocity_scale, None,
        options.friction_noise if learnt else 0.0,
    )  # fmt: skip


def rotation_bound(truth: Truth, bound: Bound) -> float | None:
    """Return the bound on the rotation error's size [rad]: median over sound samples, if any."""
    sound = bound.meaning == Meaning.SOUND
    if not sound.any():
        return None
    P, c = bound.state[sound], np.cos(truth.q[sound, 0])
    square = P[:, 0, 0] + P[:, 1, 1] + P[:, 2, 2] + 2 * c * P[:, 1, 2]
    return float(np.median(np.sqrt(square)))


def typical_bound(motions: list[tuple[Truth, Bound]]) -> float | None:
    """
    Return the median of the motions' rotation bounds [rad]; None where none has any.

    A slow slip may leave a motion without a sound bound, as closing without friction or slip does.
    """
    bounds = [rotation_bound(*motion) for motion in motions]
    bounds = [bound for bound in bounds if bound is not None]
    return float(np.median(bounds)) if bounds else None
