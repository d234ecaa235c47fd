"""Whether the push that closes a peg on three contacts grows, is more than usual, and stops it."""

from math import fabs, sqrt

import numpy as np

from peg_on_hole_ros.estimator.record import Estimate
from peg_on_hole_ros.mechanics.kernel import SceneScalars, closed_forms, compiled, pose_of
from peg_on_hole_ros.monitor import stall_ahead
from peg_on_hole_ros.monitor.contacts import below
from peg_on_hole_ros.monitor.stall_ahead import follow_push, follow_tilt, stops_ahead
from peg_on_hole_ros.monitor.trend import MEASURED, is_number

# docs/jamming.md, "Stall", has the definition.

# Two running means tell whether the push grows at all: slower than its trend, and steadier [s].
_QUICK, _SLOW = 0.01, 0.04
# A push grows, or is more than usual, by this share of what friction can hold, known to that.
_MORE, _MORE_STDDEV = 0.15, 0.03
# What push is usual for a motion is its mean over this time [s].
_USUAL = 0.2
# A push is compared with that of a motion that has lasted this long [s].
_MOVED = 0.03
# Above gamma0 by this share: the closed forms end at gamma0.
EDGE = 1e-4

# Memory: quick and slow mean of the push, its mean while closing; the same of the share of
# friction that is against the closing; for how long the peg has closed; that of `stall_ahead`.
PUSH, PUSH_SLOW, USUAL, AGAINST, AGAINST_SLOW, AGAINST_USUAL, MOVED = range(7)
STALL = MOVED + 1
SIZE = STALL + stall_ahead.SIZE
_forget_stall = stall_ahead.forget


@compiled
def forget(m: np.ndarray, at: int) -> None:
    """Begin anew with the next push."""
    m[at + MOVED] = 0.0
    _forget_stall(m, at + STALL)


@compiled
def _push(p, estimate):
    """
    Return the generalised force that closes the peg, without contacts, its variance, and a lever.

    The lever is by how much the contacts slip, in their mean, where the tilt changes by one.
    """
    motion, R = estimate.motion, estimate.wrench_noise
    angles = (motion.gamma, motion.psi, motion.phi)
    tilt = max(motion.gamma, p.gamma0 * (1.0 + EDGE))
    geo, wrench = pose_of(p, angles, estimate.wrench, estimate.work)
    if not motion.gamma > p.gamma0:
        geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, tilt)
    dh_c, dz_c = geo[10], geo[11]
    push = wrench[4] - wrench[0] * dh_c - wrench[2] * dz_c
    s, a1, S1 = geo[0], geo[2], geo[4]
    lever = 2.0 / 3.0 * (a1 / s + 2.0 * sqrt(a1 * a1 + S1 * S1))
    return push, R[0, 0] * (dh_c * dh_c + dz_c * dz_c) + R[4, 4], lever


@compiled
def pushed_on(
    p: SceneScalars,
    estimate: Estimate,
    motion: np.ndarray,
    m: np.ndarray,
    at: int,
    total: float,
    horizon: float,
    rest_rate: float,
    dt: float,
    since: float,
    closing: float,
    rate: float,
    turn: float,
) -> tuple[float, float, float]:
    """
    Return the probabilities that the peg stops, that the push grows, that it is more than usual.

    A peg that its holder brings to rest feels a push that changes little, one that stalls is
    pushed ever more; both beside what friction can hold. Nothing is said before the peg has moved
    in contact: nobody knows what would move it.

    Parameters
    ----------
    p : SceneScalars
    estimate : Estimate
    motion : ndarray
        Memory of `trend`, whose orientation is taken.
    m : ndarray
        Memory, of which SIZE places from `at` on.
    at : int
    total : float
        Sum of the reactions [N]; 0: never seen.
    horizon, dt, since : float
        Ahead, since the last wrench, since the last orientation [s].
    rest_rate : float
        That counts as none [rad/s].
    closing : float
        Probability that the peg surely closes.
    rate, turn : float
        Of the tilt, and about the axis [rad/s].

    """
    a, ahead = at, at + STALL
    push, variance, lever = _push(p, estimate)
    if not (is_number(push) and is_number(variance)):
        # Nothing is taken from it.
        return 0.0, 0.0, 0.0
    held = max(0.5 * p.d * p.f * total, 3.0 * sqrt(variance))
    follow_push(m, ahead, push, variance, held, dt)
    if motion[MEASURED + 2] != 0.0:
        tilt, tilt_variance = motion[MEASURED], motion[MEASURED + 1]
        follow_tilt(m, ahead, tilt, tilt_variance, held, motion[MEASURED + 2], since)
        motion[MEASURED + 2] = 0.0
    # Friction is against closing and turning in their shares of the slip.
    against = lever * fabs(rate) / (lever * fabs(rate) + 0.5 * p.d * fabs(turn) + 1e-9)
    if m[a + MOVED] == 0.0:
        m[a + PUSH] = m[a + PUSH_SLOW] = m[a + USUAL] = push
        m[a + AGAINST] = m[a + AGAINST_SLOW] = m[a + AGAINST_USUAL] = against
    m[a + AGAINST] += min(dt / _QUICK, 1.0) * (against - m[a + AGAINST])
    m[a + AGAINST_SLOW] += min(dt / _SLOW, 1.0) * (against - m[a + AGAINST_SLOW])
    m[a + PUSH] += min(dt / _QUICK, 1.0) * (push - m[a + PUSH])
    m[a + PUSH_SLOW] += min(dt / _SLOW, 1.0) * (push - m[a + PUSH_SLOW])
    m[a + MOVED] += dt * closing
    m[a + USUAL] += min(dt / _USUAL, 1.0) * closing * (push - m[a + USUAL])
    m[a + AGAINST_USUAL] += min(dt / _USUAL, 1.0) * closing * (against - m[a + AGAINST_USUAL])
    if m[a + MOVED] < _MOVED or total == 0.0:
        return 0.0, 0.0, 0.0
    scatter = (_MORE_STDDEV * held) ** 2
    noise = variance * min(0.5 * dt / _QUICK, 1.0)
    slope = horizon / (_SLOW - _QUICK)
    # A slip or slide that ends, or reverses, turns friction against the closing: that is no press.
    now = max(m[a + AGAINST], 1e-9)
    turned = max(1.0 - m[a + AGAINST_SLOW] / now, 0.0) * fabs(m[a + PUSH])
    growth = slope * (m[a + PUSH] - m[a + PUSH_SLOW] - turned) - _MORE * held
    grows = below(growth / sqrt(slope * slope * noise + scatter))
    usual = m[a + USUAL] + max(now / max(m[a + AGAINST_USUAL], 1e-9) - 1.0, 0.0) * fabs(
        m[a + USUAL]
    )
    more = below((m[a + PUSH] - usual - _MORE * held) / sqrt(noise + scatter))
    return stops_ahead(m, ahead, horizon, rest_rate), grows, more
