"""Which wrenches and orientations are news, where drivers repeat values under fresh stamps."""

from math import cos, pi, sin, sqrt

import numpy as np

from peg_on_hole_ros.measurements.repeats import SINCE, VALUES, held, notice, said
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.record_types import FreshnessRecord

# Standard deviations by which the peg has turned away from a value that is repeated.
TURNED = 5.0
# A value that is repeated for so long while the peg turns is told [s].
TOLD = 0.05
# Places in `turning`.
LEFT, STILL, STUCK, WRENCH_STILL, WRENCH_STUCK = range(5)


# Tells values that are news from those that a driver repeats: of `repeats`, and LEFT, 1: the peg
# has turned away from the orientation that is repeated; STILL, 1: that has lasted longer than
# TOLD; STUCK: for how long it has, at most [s]; and the same of a wrench. Last come the latest
# orientation with its variance, and that of when the present wrench came first; 0: none.
FRESHNESS = np.dtype(
    [
        ("wrench", float, (VALUES + 6,)),
        ("joints", float, (VALUES + 3,)),
        ("turning", float, (5,)),
        ("oriented", float, (4,)),
        ("held_since", float, (4,)),
    ]
)


@compiled
def is_news(
    fresh: FreshnessRecord,
    t_ns: int,
    q: np.ndarray,
    stddev2: float,
    x: np.ndarray,
    variance: float,
) -> bool:
    """
    Take an orientation; return whether it is news.

    Encoders at rest, and coarse ones, repeat what is true. So a repeated value is none where each
    comes several times as a rule, or where the peg has turned away from it; of a peg that moves it
    is left out for TOLD, until that shows.

    Parameters
    ----------
    fresh : record of FRESHNESS
        Changed.
    t_ns : int
        Stamp [ns].
    q : ndarray, shape (3,)
        gamma, psi, phi as measured [rad].
    stddev2 : float
        Variance of gamma [rad^2].
    x : ndarray
        gamma, psi, phi as predicted, and their rates [rad], [rad/s].
    variance : float
        Of the prediction's tilt [rad^2].

    """
    turning, t = fresh.turning, t_ns * 1e-9
    for i in range(3):
        fresh.oriented[i] = q[i]
    fresh.oriented[3] = stddev2
    if notice(fresh.joints, t, q) == 1:
        turning[LEFT] = turning[STILL] = 0.0
        return True
    if held(fresh.joints) > 1:
        return False
    noise, seconds = TURNED * sqrt(stddev2 + max(variance, 0.0)), t - fresh.joints[SINCE]
    # The prediction's spread grows without news: what has left a value does not come back.
    if _turned(q, x) > noise:
        turning[LEFT] = 1.0
    if turning[LEFT] == 1.0:
        turning[STILL] = 1.0 if seconds > TOLD else 0.0
        turning[STUCK] = max(turning[STUCK], seconds)
    # Believed at once, it would bring the prediction to rest that is to tell.
    moves = TOLD * _size(q[0], x[3], x[4], x[5]) > noise
    return turning[LEFT] == 0.0 and (seconds > TOLD or not moves)


@compiled
def is_new_wrench(fresh: FreshnessRecord, t_ns: int, values: np.ndarray) -> bool:
    """
    Take a wrench; return whether its values are news.

    At rest, and without noise, one value is true for long; while the peg turns it is not.
    """
    turning, t = fresh.turning, t_ns * 1e-9
    news = notice(fresh.wrench, t, values) == 1
    if news:
        for i in range(4):
            fresh.held_since[i] = fresh.oriented[i]
        turning[WRENCH_STILL] = 0.0
    elif turning[WRENCH_STILL] == 0.0 and t - fresh.wrench[SINCE] > TOLD:
        now, then = fresh.oriented, fresh.held_since
        noise = TURNED * sqrt(now[3] + then[3])
        if held(fresh.wrench) == 1 and then[3] > 0.0 and _turned(now, then) > noise:
            turning[WRENCH_STILL] = 1.0
    if turning[WRENCH_STILL] == 1.0:
        turning[WRENCH_STUCK] = max(turning[WRENCH_STUCK], t - fresh.wrench[SINCE])
    return news


@compiled
def _turned(q, x):
    """Return the angle of the turn from one orientation to another near it [rad]."""
    psi, phi = x[1] - q[1], x[2] - q[2]
    psi -= 2.0 * pi * np.round(psi / (2.0 * pi))
    phi -= 2.0 * pi * np.round(phi / (2.0 * pi))
    return _size(q[0], x[0] - q[0], psi, phi)


@compiled
def _size(gamma, by_gamma, by_psi, by_phi):
    """Return the size of a small turn, or of a rate of turning, from those of the angles."""
    s, c = sin(gamma), cos(gamma)
    return sqrt(by_gamma * by_gamma + (s * by_psi) ** 2 + (by_phi + c * by_psi) ** 2)


def causes(fresh: np.void) -> list[str]:
    """Return what there is to say, a line for each source."""
    held_wrench, held_joints = said(fresh["wrench"]), said(fresh["joints"])
    told = [f"wrench: {held_wrench}"] if held_wrench else []
    stuck, wrench_stuck = (fresh["turning"].item(place) for place in (STUCK, WRENCH_STUCK))
    if not held_wrench and wrench_stuck > TOLD:
        told.append(
            f"wrench: wrenches that do not change for {wrench_stuck:.2f} s while the peg "
            "turns: the sensor or its driver stands still; they are not used"
        )
    if held_joints:
        told.append(f"joints: {held_joints}")
    elif stuck > TOLD:
        told.append(
            f"joints: joint states that do not change for {stuck:.2f} s while the peg "
            "turns: the encoders or their driver stand still; they are not used"
        )
    return told
