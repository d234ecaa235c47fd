"""Which wrenches and orientations are news, where drivers repeat values under fresh stamps."""

from math import cos, sin, sqrt

import numpy as np

from peg_on_hole_ros.estimation.repeats import SINCE, VALUES, held, notice, said
from peg_on_hole_ros.mechanics.kernel import compiled

# Standard deviations by which the peg has turned away from a value that is repeated.
TURNED = 5.0
# A value that is repeated for so long while the peg turns is told [s].
TOLD = 0.05
# Places in `turning`.
LEFT, STILL, STUCK = range(3)


# Tells values that are news from those that a driver repeats: of `repeats`, and LEFT, 1: the peg
# has turned away from the orientation that is repeated; STILL, 1: that has lasted longer than
# TOLD; STUCK: for how long it has, at most [s].
FRESHNESS = np.dtype(
    [("wrench", float, (VALUES + 6,)), ("joints", float, (VALUES + 3,)), ("turning", float, (3,))]
)


@compiled
def is_news(fresh, t_ns, q, stddev2, x, variance):
    """
    Take an orientation; return whether it is news.

    Encoders at rest, and coarse ones, repeat what is true. So a repeated value is none where each
    comes several times as a rule, or where the peg has turned away from it.

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
        gamma, psi, phi as predicted [rad].
    variance : float
        Of the prediction's tilt [rad^2].

    """
    turning, t = fresh.turning, t_ns * 1e-9
    if notice(fresh.joints, t, q) == 1:
        turning[LEFT] = turning[STILL] = 0.0
        return True
    if held(fresh.joints) > 1:
        return False
    gamma, psi, phi = x[0] - q[0], x[1] - q[1], x[2] - q[2]
    s, c = sin(q[0]), cos(q[0])
    turned = sqrt(gamma * gamma + (s * psi) ** 2 + (phi + c * psi) ** 2)
    # The prediction's spread grows without news: what has left a value does not come back.
    if turned > TURNED * sqrt(stddev2 + max(variance, 0.0)):
        turning[LEFT] = 1.0
    if turning[LEFT] == 1.0:
        seconds = t - fresh.joints[SINCE]
        turning[STILL] = 1.0 if seconds > TOLD else 0.0
        turning[STUCK] = max(turning[STUCK], seconds)
    return turning[LEFT] == 0.0


def causes(fresh: np.void) -> list[str]:
    """Return what there is to say, a line for each source."""
    held_wrench, held_joints = said(fresh["wrench"]), said(fresh["joints"])
    told = [f"wrench: {held_wrench}"] if held_wrench else []
    stuck = fresh["turning"].item(STUCK)
    if held_joints:
        told.append(f"joints: {held_joints}")
    elif stuck > TOLD:
        told.append(
            f"joints: joint states that do not change for {stuck:.2f} s while the peg "
            "turns: the encoders or their driver stand still; they are not used"
        )
    return told
