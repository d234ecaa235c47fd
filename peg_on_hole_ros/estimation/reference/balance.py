"""What the balance of forces tells the reference filter before a prediction; see `balance`."""

import numpy as np

from peg_on_hole_ros.estimation.kernel.acceleration import LEAST_AVERAGED
from peg_on_hole_ros.estimation.kernel.balance import (
    ACCELERATION_TIME,
    DIRECTED,
    LAGS,
    LEAST_DETERMINANT,
    LEAST_DIRECTED,
    ROUGHLY,
    STEADY,
    SURE,
    WIDE_CLEARANCE,
)
from peg_on_hole_ros.estimation.kernel.diameter_by_balance import OUTWEIGHS
from peg_on_hole_ros.estimation.kernel.offsets import CAREFUL
from peg_on_hole_ros.estimation.kernel.parameters import LEAST_FRICTION, MOST_FRICTION
from peg_on_hole_ros.estimation.kernel.prediction import SELECTED
from peg_on_hole_ros.estimation.reference.slip import slip_all_ways, turned_scales
from peg_on_hole_ros.estimation.reference.steps import (
    BIAS,
    DIAMETER,
    FRICTION,
    RATES,
    SIZE,
    STATE,
    WRENCH,
    solve_with_slopes,
    with_parameters,
)
from peg_on_hole_ros.estimation.steps.choice import LONG_STEP
from peg_on_hole_ros.mechanics.reference import six_equations


def correct_by_balance(kalman, dt, acceleration_stddev):
    """
    Correct where the balance of forces tells of friction, or of how a bridged peg slides.

    Parameters
    ----------
    kalman : ReferenceFilter
        Its angles are where the wrench was measured, at the end of the interval.
    dt : float
        [s].
    acceleration_stddev : float
        How a held peg may accelerate [rad/s^2].

    """
    speed, variance, across = slip_all_ways(kalman)
    known = kalman.P[FRICTION, FRICTION]
    kalman.unbalance = None
    if not kalman.stopped > SELECTED:
        return
    clearance = kalman.scene.hole_diameter - kalman.x[DIAMETER]
    wide = kalman.P[DIAMETER, DIAMETER] > (WIDE_CLEARANCE * clearance) ** 2
    steady = (np.abs(kalman.acceleration.mean) <= STEADY * acceleration_stddev).all()
    if wide and known < (ROUGHLY * kalman.x[FRICTION]) ** 2 and not steady:
        return
    if (speed <= SURE * np.sqrt(variance)).any():
        return
    turned, scales = (across / speed**2).max(), turned_scales(across)
    learns = known > 0 and kalman.offsets_are_small and known >= (turned * kalman.x[FRICTION]) ** 2
    directed = turned < DIRECTED
    if not (learns or directed or kalman.learns_bias):
        return
    y, dy = solve_with_slopes(kalman.scene, kalman.x[:SIZE], scales)
    determinant = [
        np.linalg.det(
            six_equations(
                with_parameters(kalman.scene, friction, kalman.x[DIAMETER]),
                kalman.x[:3], kalman.x[RATES], kalman.x[WRENCH], scales,
            )[0]
        )
        for friction in (kalman.x[FRICTION], 0.0)
    ]  # fmt: skip
    if not (determinant[0] / determinant[1] > LEAST_DETERMINANT and (y[3:] > 0).all()):
        return
    dy[:, RATES] += dt * dy[:, :3]
    shared = dy[:3] @ kalman.P[:SIZE]
    short = dt <= LONG_STEP
    exact = shared[:, :SIZE] @ dy[:3].T
    S = exact + _noise(kalman, acceleration_stddev, LEAST_AVERAGED if short else 1.0, dt)
    T = exact + _noise(kalman, acceleration_stddev, LEAST_DIRECTED if short else 1.0, dt)
    off = y[:3] - kalman.acceleration.mean
    kalman.unbalance = np.linalg.solve(np.linalg.cholesky(T), off)
    directed = directed and kalman.slow
    by_diameter = dy[:3, DIAMETER] @ np.linalg.solve(S, dy[:3, DIAMETER])
    outweighs = kalman.P[DIAMETER, DIAMETER] * by_diameter > OUTWEIGHS
    resized = learns and outweighs and not kalman.learns_bias
    learns = learns and not resized
    if not (learns or directed or kalman.learns_bias or resized):
        return
    gain = np.zeros((kalman.dim_x, 3))
    if directed:
        gain[STATE] = np.linalg.solve(T, shared[:, STATE]).T
    if learns:
        gain[FRICTION] = _gain_of_friction(kalman, S, shared[:, FRICTION], known)
    if kalman.learns_bias:
        gain[BIAS] = CAREFUL * np.linalg.solve(S, shared[:, BIAS]).T
    if resized:
        gain[DIAMETER] = CAREFUL * np.linalg.solve(S, shared[:, DIAMETER])
    told = 2 * gain[FRICTION] @ shared[:, FRICTION] - gain[FRICTION] @ S @ gain[FRICTION]
    if not told > 0:
        gain[FRICTION] = 0.0
    with kalman.bent_friction():
        kalman.x -= gain @ off
        kalman.x[FRICTION] = np.clip(kalman.x[FRICTION], LEAST_FRICTION, MOST_FRICTION)
        P = kalman.P + gain @ T @ gain.T - gain @ shared - shared.T @ gain.T
        # What is one number all along is left with what the accelerations at many instants share.
        P[FRICTION:, FRICTION:] += gain[FRICTION:] @ (S - T) @ gain[FRICTION:].T
        # What rounding makes of it on one side of the diagonal only would grow.
        kalman.P = (P + P.T) / 2


def _noise(kalman, stddev, least, dt):
    # Of a held peg's accelerations, as if they were independent after ACCELERATION_TIME.
    held = kalman.acceleration.covariance(stddev, least, kalman.since_correction)
    held = held + np.diag((LAGS * kalman.acceleration.mean) ** 2)
    return held * max(1.0, ACCELERATION_TIME / dt)


def _gain_of_friction(kalman, S, shared, known):
    # Of one wrench the noise is in the accelerations and in the gain, unless that is the last.
    gain, before = np.linalg.solve(S, shared), kalman.balance
    share = gain @ shared / known
    kalman.balance = gain / (1 - share) / known, share / (1 - share) / known
    return gain if before is None else before[0] * known / (1 + before[1] * known)
