"""Which wrenches and orientations are news, where drivers repeat values under fresh stamps."""

from math import cos, pi, sin, sqrt

import numpy as np

from peg_on_hole_ros.measurements.repeats import Repeats, held, notice, said
from peg_on_hole_ros.measurements.tuned import REPEATED_VALUES
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats, Record, Vector3, Vector6


class Oriented(Record):
    """
    An orientation as it was measured.

    Attributes
    ----------
    q : shape (3,)
        gamma, psi, phi [rad].
    variance
        Of gamma [rad^2]; 0: none was measured.

    """

    q: Vector3
    variance: float


class Freshness(Record):
    """
    What tells values that are news from those that a driver repeats.

    Attributes
    ----------
    wrench, joints : Repeats
    values, angles : shape (6,), (3,)
        The latest wrench [N], [N m] and the latest gamma, psi, phi [rad], as they came.
    left : bool
        Whether the peg has turned away from the orientation that is repeated.
    still, stuck : bool, float
        Whether that has lasted long enough to be reported, and for how long it has, at most [s].
    wrench_still, wrench_stuck : bool, float
        The same of a wrench that is repeated.
    oriented : Oriented
        The latest orientation.
    held_since : Oriented
        That of when the present wrench came first.

    """

    wrench: Repeats
    joints: Repeats
    values: Vector6
    angles: Vector3
    left: bool
    still: bool
    stuck: float
    wrench_still: bool
    wrench_stuck: float
    oriented: Oriented
    held_since: Oriented


@compiled
def is_news(
    fresh: Freshness,
    t_ns: int,
    q: Floats,
    stddev2: float,
    x: Floats,
    variance: float,
) -> bool:
    """
    Take an orientation; return whether it is news.

    Encoders at rest, and coarse ones, repeat what is true. So a repeated value is none where each
    comes several times as a rule, or where the peg has turned away from it; of a peg that moves it
    is left out until it would be reported, when that shows.

    Parameters
    ----------
    fresh : Freshness
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
    t = t_ns * 1e-9
    for i in range(3):
        fresh.oriented.q[i] = q[i]
    fresh.oriented.variance = stddev2
    if notice(fresh.joints, t, q, fresh.angles) == 1:
        fresh.left = fresh.still = False
        return True
    if held(fresh.joints) > 1:
        return False
    noise = REPEATED_VALUES.turned * sqrt(stddev2 + max(variance, 0.0))
    seconds = t - fresh.joints.since
    # The prediction's spread grows without news: what has left a value does not come back.
    if _turned(q, x) > noise:
        fresh.left = True
    if fresh.left:
        fresh.still = seconds > REPEATED_VALUES.reported
        fresh.stuck = max(fresh.stuck, seconds)
    # Believed at once, it would bring the prediction to rest that is to tell.
    moves = REPEATED_VALUES.reported * _size(q[0], x[3], x[4], x[5]) > noise
    return not fresh.left and (seconds > REPEATED_VALUES.reported or not moves)


@compiled
def is_new_wrench(fresh: Freshness, t_ns: int, values: Floats) -> bool:
    """
    Take a wrench; return whether its values are news.

    At rest, and without noise, one value is true for long; while the peg turns it is not.
    """
    t = t_ns * 1e-9
    news = notice(fresh.wrench, t, values, fresh.values) == 1
    if news:
        fresh.held_since = fresh.oriented
        fresh.wrench_still = False
    elif not fresh.wrench_still and t - fresh.wrench.since > REPEATED_VALUES.reported:
        now, then = fresh.oriented, fresh.held_since
        noise = REPEATED_VALUES.turned * sqrt(now.variance + then.variance)
        if held(fresh.wrench) == 1 and then.variance > 0.0 and _turned(now.q, then.q) > noise:
            fresh.wrench_still = True
    if fresh.wrench_still:
        fresh.wrench_stuck = max(fresh.wrench_stuck, t - fresh.wrench.since)
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


def causes(fresh: Freshness) -> list[str]:
    """Return what there is to say, a line for each source."""
    held_wrench, held_joints = said(fresh.wrench), said(fresh.joints)
    told = [f"wrench: {held_wrench}"] if held_wrench else []
    if not held_wrench and fresh.wrench_stuck > REPEATED_VALUES.reported:
        told.append(
            f"wrench: wrenches that do not change for {fresh.wrench_stuck:.2f} s while the peg "
            "turns: the sensor or its driver stands still; they are not used"
        )
    if held_joints:
        told.append(f"joints: {held_joints}")
    elif fresh.stuck > REPEATED_VALUES.reported:
        told.append(
            f"joints: joint states that do not change for {fresh.stuck:.2f} s while the peg "
            "turns: the encoders or their driver stand still; they are not used"
        )
    return told
