"""Where each method holds, errs, diverges or refuses: one prediction at each place of a map."""

from collections.abc import Iterator
from dataclasses import replace
from enum import Enum
from math import ceil
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimation.filters.contact import ContactFilter
from peg_on_hole_ros.estimation.filters.outcomes import NO_STEP, Prediction
from peg_on_hole_ros.estimation.kernel.memory import part
from peg_on_hole_ros.estimation.measurement import WrenchReduction, angle_covariance
from peg_on_hole_ros.mechanics.kernel import accelerate, scene_scalars, workspace
from peg_on_hole_ros.mechanics.reference import solve_contact
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.study.problems import (
    FAILED,
    Solution,
    balancing_wrench,
    by_scipy,
    held,
    reactions,
    solve,
)
from peg_on_hole_ros.study.steps import CONVERGED, HALVED, METHODS

DEFAULT = "filter's prediction"
# The filter is what halves steps.
ALL_METHODS = (*METHODS[:HALVED], DEFAULT)
# One standard deviation of a measured orientation [rad], and half of what counts as slow [m/s].
ANGLE_TOLERANCE, SPEED_TOLERANCE = 1e-4, 1e-3
# Beyond these no correction that follows is near enough to bring it back [rad], [m/s].
ANGLE_LOST, SPEED_LOST = 0.1, 0.1
# How well the rates are known under way [rad/s].
RATE_STDDEV = 0.005
# What each contact carries at the start [N], and how hard the motion is braked [rad/s^2].
LOAD, BRAKING = 20.0, 20.0
# 99.7 % of squared normal errors in six dimensions lie below it.
WITHIN_BOUNDS = 20.0


class Verdict(Enum):
    """What became of a prediction."""

    STABLE = "stable"
    STATED = "inaccurate, within its stated bounds"
    INACCURATE = "inaccurate"
    DIVERGED = "diverged"
    REFUSED = "refused"


class Truth(Enum):
    """What is true at a place of the map."""

    CONTACT = "three-point contact all along"
    OPENS = "a contact lets go before the end"
    ENDS = "gamma0 is reached before the end"
    NONE = "rigid sliding has no solution there"


SOLVED = (Truth.CONTACT, Truth.OPENS)


class Place(NamedTuple):
    """
    One place of the map.

    Attributes
    ----------
    excess : float
        gamma - gamma0 [rad].
    slip : float
        Speed of the contacts at the start [m/s].
    friction : float
    step : float
        Of the integrator, and time between two wrenches of the filter [s].
    gap : float
        Time without a measured orientation [s].
    clearance : float
        D - d [m].
    turning : bool
        The peg turns about its axis while it closes; else it only closes.

    """

    excess: float = 0.05
    slip: float = 0.01
    friction: float = 0.2
    step: float = 1e-3
    gap: float = 0.01
    clearance: float = 1e-4
    turning: bool = True


class Axis(NamedTuple):
    """A quantity of the map: its field in `Place`, its label, its range on a log scale."""

    name: str
    label: str
    low: float
    high: float

    def values(self, count: int) -> np.ndarray:
        """Return places on the axis."""
        return np.geomspace(self.low, self.high, count)


EXCESS = Axis("excess", "gamma - gamma0 [rad]", 1e-5, 0.5)
SLIP = Axis("slip", "slip speed [m/s]", 1e-6, 1.0)
FRICTION = Axis("friction", "friction f", 0.02, 1.0)
STEP = Axis("step", "step [s]", 5e-5, 0.05)
GAP = Axis("gap", "gap [s]", 1e-3, 0.3)
CLEARANCE = Axis("clearance", "clearance D - d [m]", 5e-6, 5e-3)


class Map(NamedTuple):
    """A plane through the map: two axes, and what the other quantities are."""

    name: str
    title: str
    x: Axis
    y: Axis
    base: Place


MAPS = (
    Map("slip_step", "slow slip, long steps", SLIP, STEP, Place()),
    Map("excess_slip", "near gamma0, slow slip", EXCESS, SLIP, Place(gap=0.004)),
    Map(
        "excess_friction", "closing without turning: wedging", EXCESS, FRICTION,
        Place(gap=0.004, turning=False),
    ),
    Map("gap_step", "gaps", GAP, STEP, Place()),
    Map("clearance_excess", "small clearance", CLEARANCE, EXCESS, Place(gap=0.004)),
)  # fmt: skip
COLUMNS = (
    "map", "excess", "slip", "friction", "step", "gap", "clearance", "truth", "method", "verdict",
    "angle_error", "speed_error", "reaction_error", "evaluations",
)  # fmt: skip


class Result(NamedTuple):
    """
    One method at one place.

    Attributes
    ----------
    method : str
    verdict : Verdict
    angle_error, speed_error, reaction_error : float
        Rotation between the ends [rad], fastest contact's difference [m/s], largest difference of
        a reaction over the mean load; NaN where there is nothing to compare.
    evaluations : int

    """

    method: str
    verdict: Verdict
    angle_error: float
    speed_error: float
    reaction_error: float
    evaluations: int


def places(map_: Map, count: int) -> Iterator[list[Place]]:
    """Yield the map row by row (along x at one y), count by count places."""
    for y in map_.y.values(count):
        row = []
        for x in map_.x.values(count):
            row.append(map_.base._replace(**{map_.x.name: float(x), map_.y.name: float(y)}))
        yield row


def initial(
    place: Place, configuration: Configuration, scale=None
) -> tuple[Scene, np.ndarray, np.ndarray]:
    """Return scene, state and wrench of a place; every contact carries LOAD at the start."""
    D = configuration.scene.hole_diameter
    scene = replace(
        configuration.scene, peg_diameter=D - place.clearance, friction=place.friction,
        mass_center_height=0.0, transverse_inertia=0.0, axial_inertia=0.0,
    )  # fmt: skip
    # With these every contact slips at about the same speed.
    direction = np.array([-1.0, 0.0, 2.0 if place.turning else 0.0]) / D
    state = np.concatenate([[scene.gamma0 + place.excess, 0.3, 0.0], place.slip * direction])
    braking = -BRAKING * direction / np.linalg.norm(direction)
    scale = scale or configuration.filter.slip_velocity_scale
    return scene, state, balancing_wrench(scene, state, (LOAD,) * 3, braking, scale)


def examine(place: Place, configuration: Configuration) -> tuple[Truth, list[Result]]:
    """Return what is true at a place, and what each method makes of it."""
    scene, state, wrench = initial(place, configuration)
    scale = configuration.filter.slip_velocity_scale
    problem = held(scene, state, wrench, place.gap, scale)
    end = by_scipy(problem)
    truth = Truth.CONTACT
    if not _regular(scene, state):
        truth = Truth.NONE
    elif end.status != CONVERGED:
        truth = Truth.ENDS if end.lowest < scene.gamma0 * (1 + 1e-6) else Truth.NONE
    elif (reactions(problem, end.state) < 0).any():
        truth = Truth.OPENS
    results = []
    for method in ALL_METHODS:
        covariance = None
        if method == DEFAULT:
            found, covariance = predicted(scene, state, wrench, place, configuration)
        else:
            found = solve(problem, method, min(place.step, place.gap))
        known = end if truth in SOLVED else None
        results.append(_judge(method, problem, found, known, covariance))
    return truth, results


def _regular(scene, state):
    """Return whether rigid sliding has a solution at the start, friction being Coulomb's."""
    try:
        zero = np.zeros(3)
        return solve_contact(scene, state[:3], state[3:], zero, zero).determinant > 0
    except PegOnHoleError:
        return False


def predicted(scene, state, wrench, place, configuration: Configuration):
    """
    Predict by the filter as it is by default, well on its way, one wrench a step.

    Returns
    -------
    solution : Solution
    covariance : ndarray, shape (6, 6)
        What the filter says of the error of the state.

    """
    noise = WrenchReduction(configuration.wrench, scene).covariance
    kalman = ContactFilter(scene, configuration.filter, noise)
    stddev = configuration.joints.position_stddev / 3
    kalman.start(state[:3], angle_covariance(state[0], stddev))
    kalman.x[3:] = state[3:]
    kalman.Z[range(3, 6), range(3, 6)] = RATE_STDDEV**2
    # Under way it has followed how the motion is braked.
    y, scales = np.empty(6), np.full(3, configuration.filter.slip_velocity_scale)
    accelerate(scene_scalars(scene), scales, state, wrench, workspace(), y)
    followed = np.clip(np.nan_to_num(y[:3]), -BRAKING, BRAKING)
    part(kalman.memory, "ACCELERATION")[:] = followed
    part(kalman.memory, "RATES_BEFORE")[:] = state[3:]
    count, evaluations = max(1, ceil(place.gap / place.step - 1e-9)), 0
    for _ in range(count):
        kalman.hold(wrench)
        outcome = kalman.predict(place.gap / count, in_contact=True)
        evaluations += kalman.evaluations
        if outcome in (*NO_STEP, Prediction.RUNAWAY):
            return Solution(FAILED, kalman.x.copy(), evaluations), kalman.P.copy()
    return Solution(CONVERGED, kalman.x.copy(), evaluations), kalman.P.copy()


def _judge(method, problem, found, end, covariance):
    nothing = (float("nan"),) * 3
    if found.status == FAILED:
        return Result(method, Verdict.REFUSED, *nothing, found.evaluations)
    if not np.isfinite(found.state).all():
        return Result(method, Verdict.DIVERGED, *nothing, found.evaluations)
    if end is None:
        # Nothing is true here: whoever goes on invents it.
        return Result(method, Verdict.DIVERGED, *nothing, found.evaluations)
    angle, speed = differences(problem, found.state, end.state)
    verdict = Verdict.STABLE
    if not (angle <= ANGLE_LOST and speed <= SPEED_LOST):
        verdict = Verdict.DIVERGED
    elif angle > ANGLE_TOLERANCE or speed > SPEED_TOLERANCE:
        verdict = Verdict.INACCURATE
        error = found.state - end.state
        if covariance is not None and error @ np.linalg.solve(covariance, error) < WITHIN_BOUNDS:
            verdict = Verdict.STATED
    normal = reactions(problem, found.state) - reactions(problem, end.state)
    reaction = float(np.abs(normal).max() / LOAD)
    return Result(method, verdict, angle, speed, reaction, found.evaluations)


def differences(problem, state, other) -> tuple[float, float]:
    """Return the rotation [rad] and the fastest contact's difference [m/s] between two states."""
    p = problem.p
    d_gamma, d_psi, d_phi, w_gamma, w_psi, w_phi = (float(v) for v in state - other)
    c = float(np.cos(other[0]))
    square = d_gamma**2 + d_psi**2 + d_phi**2 + 2 * c * d_psi * d_phi
    speed = max(p.D * abs(w_gamma), 0.5 * abs(p.D * w_psi + p.d * w_phi))
    return max(square, 0.0) ** 0.5, speed
