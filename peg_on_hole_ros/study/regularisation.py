"""What the velocity scale of regularised friction costs and what it spoils."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.kernel import WIDTH, accelerate_with_derivatives, workspace
from peg_on_hole_ros.mechanics.reference import solve_contact
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.study.problems import CONVERGED, by_scipy, held, solve
from peg_on_hole_ros.study.stability import Place, differences, initial

SCALES = np.geomspace(1e-6, 1e-2, 13)
# As good as dry: a thousandth of the smallest speed that a sensor could tell here [m/s].
DRY = 1e-7
# Slips at 5 mm/s and is braked to a stop after 11 ms; then it sticks.
STOP = Place(excess=0.1, slip=0.005, gap=0.02)
# Closing near gamma0 without slip, where K slides slowest: tilt over gamma0, and rate [rad/s].
SLOW_TILT, SLOW_RATE = 1.1, -0.16
STEP = 1e-3
COLUMNS = (
    "scale", "slow_reaction_error", "stop_angle_error", "creep_speed", "stiffness",
    "evaluations_per_step", "implicit_error", "linearly_implicit_error", "explicit_error",
)  # fmt: skip


class Effect(NamedTuple):
    """
    The effect of one velocity scale.

    Attributes
    ----------
    scale : float
        [m/s].
    slow_reaction_error : float
        Of N_K over its dry value, closing without slip near gamma0.
    stop_angle_error : float
        Rotation from where dry friction has stopped the peg [rad].
    creep_speed : float
        Of the contacts of the stopped peg, which dry friction holds [m/s].
    stiffness : float
        Fastest rate of the linearised motion of the stopped peg [1/s].
    evaluations_per_step : float
        Of the six equations in a step of 1 ms of the filter's implicit Euler.
    implicit_error, linearly_implicit_error, explicit_error : float
        Contact speed at the end against the solution at the same scale, steps of 1 ms [m/s]; inf
        where a step was refused or is not finite.

    """

    scale: float
    slow_reaction_error: float
    stop_angle_error: float
    creep_speed: float
    stiffness: float
    evaluations_per_step: float
    implicit_error: float
    linearly_implicit_error: float
    explicit_error: float


def effects(configuration: Configuration, scales=SCALES) -> list[Effect]:
    """Return the effect of each velocity scale [m/s] in the configuration's scene."""
    scene, state, wrench = initial(STOP, configuration, DRY)
    dry = by_scipy(held(scene, state, wrench, STOP.gap, DRY), rtol=1e-9)
    dry_K = _slow_reaction(configuration.scene, 0.0)
    found = []
    for scale in scales:
        problem = held(scene, state, wrench, STOP.gap, scale)
        end = by_scipy(problem)
        angle, _ = differences(problem, end.state, dry.state)
        still = end.state.copy()
        still[3:] = 0.0
        _, creep = differences(problem, end.state, still)
        errors = []
        for method in ("implicit Euler", "linearly implicit Euler", "explicit Euler"):
            solution = solve(problem, method, STEP)
            good = solution.status == CONVERGED
            errors.append(differences(problem, solution.state, end.state)[1] if good else np.inf)
            if method == "implicit Euler":
                per_step = solution.evaluations * STEP / STOP.gap
        slow = abs(_slow_reaction(configuration.scene, scale) / dry_K - 1.0)
        stiff = _stiffness(problem, end.state)
        found.append(Effect(float(scale), slow, angle, creep, stiff, per_step, *errors))
    return found


def _slow_reaction(scene, scale):
    q, rates = [SLOW_TILT * scene.gamma0, 0.0, 0.0], [SLOW_RATE, 0.0, 0.0]
    zero = np.zeros(3)
    return float(solve_contact(scene, q, rates, zero, zero, scale).normal[0])


def _stiffness(problem, state):
    y, dy = np.empty(6), np.empty((6, WIDTH))
    u = problem.coefficients[0, 0]
    accelerate_with_derivatives(problem.p, problem.scales, state, u, workspace(), y, dy)
    return float(np.abs(np.linalg.eigvals(dy[:3, 3:6])).max())
