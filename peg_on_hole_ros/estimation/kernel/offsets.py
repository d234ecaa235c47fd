"""
Constant errors of a cell beside the state: bias of the wrench, tilt of the hole's axis.

Both act through the wrench that is held. A bias b (6, sensor axes) is part of it, and a tilt t (2,
about x and y of the configured hole) turns gravity: a held wrench is in error by its own noise
and by L (b, t), with L taken at the estimate. A prediction thus needs no derivatives by them. A
tilt turns the measured orientation as well: measured angles are the true ones plus T t.
"""

from math import cos, floor, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.kernel.correction import white_innovation
from peg_on_hole_ros.estimation.kernel.memory import (
    CROSS,
    GAINS,
    GRAVITY,
    JOINT,
    LEARNT,
    LOAD,
    MASSES,
    OFFSET,
    OFFSET_CROSS,
    OFFSET_SPREAD,
    OFFSETS,
    RESIDUAL,
    SCENE,
    SEEN,
    SLIDING,
    SPREAD,
    TURN,
    WEIGHT,
    R,
    S,
    X,
    Z,
)
from peg_on_hole_ros.estimation.kernel.parameters import move_parameters
from peg_on_hole_ros.mechanics.kernel import compiled, inlined

BIAS, TILT, COUNT = slice(0, 6), slice(6, 8), 8
# Row length of the joint covariance: state, wrench, friction, peg diameter, offsets.
_WIDE = 22
_SMALLEST_SINE = 1e-6
# Share of the optimal gain with which offsets, and friction beside them, are learnt. At first only
# products of theirs are seen, but to a thousandth: learnt at once, along tangents that then turn,
# they would be taken to be known where they are not. Joseph's form is right for any gain.
CAREFUL = 0.1
# Offsets are small whose variance in a held wrench is below this share of its noise's, a mean
# over six. Beside greater ones what seems another friction is as likely theirs.
SMALL = 0.5
# A tilt nearer to gamma0 than so many standard deviations teaches nothing.
SPREADS = 3.0


class Offsets(NamedTuple):
    """
    What is not known of the sensor's zero and of the hole's direction.

    Attributes
    ----------
    variance : ndarray, shape (8,)
        Of force bias [N^2], torque bias [N^2 m^2], as the sensor reports them, and of the tilt of
        the hole about its configured x and y [rad^2]; 0: known.
    load : ndarray, shape (6, 6)
        From a bias to the wrench about the mass centre, peg axes.
    weight : ndarray, shape (6, 3)
        From gravity in peg axes to the wrench that it makes on peg and payload [kg], [kg m].
    noise : ndarray, shape (6,)
        Variance of one reading of the sensor [N^2], [N^2 m^2].
    moved : ndarray, shape (6,)
        Square of what an acceleration makes of a reading: the mass below the sensor [kg^2], and
        that times its distance [kg^2 m^2].
    bias_learnt, tilt_learnt : bool
        Whether they are estimated, or only widen the bounds.

    """

    variance: np.ndarray
    load: np.ndarray
    weight: np.ndarray
    noise: np.ndarray
    moved: np.ndarray
    bias_learnt: bool = True
    tilt_learnt: bool = True

    @property
    def active(self) -> slice:
        """The offsets that are carried: none, six, two or all eight."""
        bias, tilt = self.variance[BIAS].any(), self.variance[TILT].any()
        return slice(0 if bias else 6, 8 if tilt else 6)


@inlined
def _turn_back(tx, ty, x, y, z):
    """Return a vector in the axes of a hole tilted by (tx, ty, 0) [rad], by Rodrigues' formula."""
    angle = sqrt(tx * tx + ty * ty)
    if angle == 0.0:
        return x, y, z
    kx, ky = tx / angle, ty / angle
    s, c = sin(angle), cos(angle)
    along = (kx * x + ky * y) * (1.0 - c)
    return (
        c * x - s * ky * z + kx * along,
        c * y + s * kx * z + ky * along,
        c * z - s * (kx * y - ky * x),
    )


@compiled
def turn_gravity(m):
    """Put gravity, in the axes of the hole as it is now taken to lie, into the scene."""
    m[SCENE + 8], m[SCENE + 9], m[SCENE + 10] = _turn_back(
        m[OFFSET + 6], m[OFFSET + 7], m[GRAVITY], m[GRAVITY + 1], m[GRAVITY + 2]
    )


@compiled
def _fill_load(m):
    """Fill the columns of LOAD for a tilt: gravity turns by minus it, seen from the hole."""
    s, c = sin(m[X]), cos(m[X])
    spsi, cpsi, sphi, cphi = sin(m[X + 1]), cos(m[X + 1]), sin(m[X + 2]), cos(m[X + 2])
    gx, gy, gz = m[SCENE + 8], m[SCENE + 9], m[SCENE + 10]
    for t in range(2):
        # gravity x e_x, gravity x e_y
        vx, vy, vz = (0.0, gz, -gy) if t == 0 else (-gz, 0.0, gx)
        h, e = cpsi * vx + spsi * vy, cpsi * vy - spsi * vx
        across, along = c * h + s * vz, c * vz - s * h
        px, py = cphi * across + sphi * e, cphi * e - sphi * across
        for i in range(6):
            w = MASSES + 3 * i
            m[LOAD + 8 * i + 6 + t] = m[w] * px + m[w + 1] * py + m[w + 2] * along


@compiled
def hold_offsets(m):
    """Give a wrench that was just held the covariance that the offsets make; turn gravity."""
    begin, end = int(m[OFFSETS]), int(m[OFFSETS + 1])
    turn_gravity(m)
    _fill_load(m)
    for i in range(6):
        load = LOAD + 8 * i
        for j in range(6):
            total = 0.0
            for a in range(begin, end):
                total += m[load + a] * m[OFFSET_CROSS + 12 * a + j]
            m[Z + 12 * (6 + i) + j] = m[Z + 12 * j + 6 + i] = total
        for k in range(2):
            total = 0.0
            for a in range(begin, end):
                total += m[load + a] * m[OFFSET_SPREAD + 10 * a + k]
            m[CROSS + 12 * k + 6 + i] = total
        for b in range(begin, end):
            total = 0.0
            for a in range(begin, end):
                total += m[load + a] * m[OFFSET_SPREAD + 10 * a + 2 + b]
            m[OFFSET_CROSS + 12 * b + 6 + i] = total
    for i in range(6):
        for j in range(i + 1):
            total = 0.0
            for a in range(begin, end):
                total += m[LOAD + 8 * i + a] * m[OFFSET_CROSS + 12 * a + 6 + j]
            m[Z + 12 * (6 + i) + 6 + j] += total
            if i != j:
                m[Z + 12 * (6 + j) + 6 + i] += total


@compiled
def offsets_are_small(m):
    """Return whether what offsets make of the held wrench is small beside its noise."""
    if not m[OFFSETS + 1] > m[OFFSETS]:
        return True
    over = 0.0
    for i in range(6):
        for j in range(6):
            over += m[WEIGHT + 6 * i + j] * m[Z + 12 * (6 + i) + 6 + j]
    return over < 6.0 * (1.0 + SMALL)


@compiled
def fill_turn(m):
    """Fill TURN at the estimate; see `orientation.angle_errors`, of which it is two columns."""
    s, c = sin(m[X]), cos(m[X])
    spsi, cpsi = sin(m[X + 1]), cos(m[X + 1])
    # An estimate can be a little below zero, where the axis leans to the other side.
    over = 1.0 / (max(s, _SMALLEST_SINE) if s >= 0.0 else min(s, -_SMALLEST_SINE))
    cotangent = c * over
    m[TURN], m[TURN + 1] = spsi, -cpsi
    m[TURN + 2], m[TURN + 3] = cpsi * cotangent, spsi * cotangent
    m[TURN + 4], m[TURN + 5] = -cpsi * over, -spsi * over


@compiled
def _gather(m, P):
    """Fill the joint covariance with all parameters, and return its size."""
    begin, end = int(m[OFFSETS]), int(m[OFFSETS + 1])
    for i in range(12):
        for j in range(12):
            P[i, j] = m[Z + 12 * i + j]
    for k in range(2):
        for j in range(12):
            P[12 + k, j] = P[j, 12 + k] = m[CROSS + 12 * k + j]
        for l in range(2):
            P[12 + k, 12 + l] = m[SPREAD + 2 * k + l]
    for a in range(begin, end):
        n = 14 + a - begin
        for j in range(12):
            P[n, j] = P[j, n] = m[OFFSET_CROSS + 12 * a + j]
        for k in range(2):
            P[n, 12 + k] = P[12 + k, n] = m[OFFSET_SPREAD + 10 * a + k]
        for b in range(begin, end):
            P[n, 14 + b - begin] = m[OFFSET_SPREAD + 10 * a + 2 + b]
    return 14 + end - begin


@compiled
def _scatter(m, P):
    """Put the lower triangle of the joint covariance back, on both sides of the diagonal."""
    begin, end = int(m[OFFSETS]), int(m[OFFSETS + 1])
    for i in range(12):
        for j in range(i + 1):
            m[Z + 12 * i + j] = m[Z + 12 * j + i] = P[i, j]
    for k in range(2):
        for j in range(12):
            m[CROSS + 12 * k + j] = P[12 + k, j]
        for l in range(k + 1):
            m[SPREAD + 2 * k + l] = m[SPREAD + 2 * l + k] = P[12 + k, 12 + l]
    for a in range(begin, end):
        n = 14 + a - begin
        for j in range(12):
            m[OFFSET_CROSS + 12 * a + j] = P[n, j]
        for k in range(2):
            m[OFFSET_SPREAD + 10 * a + k] = P[n, 12 + k]
        for b in range(begin, a + 1):
            m[OFFSET_SPREAD + 10 * a + 2 + b] = P[n, 14 + b - begin]
            m[OFFSET_SPREAD + 10 * b + 2 + a] = P[n, 14 + b - begin]


@compiled
def innovation_with_offsets(m, q):
    """As `correction.innovation`, with what a tilt makes of the measured angles; fills SEEN."""
    P, seen = m[JOINT : JOINT + 484].reshape(_WIDE, _WIDE), m[SEEN : SEEN + 66].reshape(_WIDE, 3)
    fill_turn(m)
    n = _gather(m, P)
    tilted = int(m[OFFSETS + 1]) == COUNT
    for i in range(n):
        for r in range(3):
            seen[i, r] = P[i, r]
            if tilted:
                seen[i, r] += P[i, n - 2] * m[TURN + 2 * r] + P[i, n - 1] * m[TURN + 2 * r + 1]
    for i in range(3):
        residual = q[i] - m[X + i]
        turns = 0.0 if i == 0 else floor(residual / (2.0 * pi) + 0.5)
        m[RESIDUAL + i] = residual - 2.0 * pi * turns
        for j in range(i + 1):
            total = seen[i, j] + m[R + 3 * i + j]
            if tilted:
                total += m[TURN + 2 * i] * seen[n - 2, j] + m[TURN + 2 * i + 1] * seen[n - 1, j]
            for k in range(j):
                total -= m[S + 3 * i + k] * m[S + 3 * j + k]
            m[S + 3 * i + j] = sqrt(total) if i == j else total / m[S + 4 * j]
    w0, w1, w2 = white_innovation(m)
    return w0 * w0 + w1 * w1 + w2 * w2


@compiled
def correct_with_offsets(m):
    """
    Correct state, held wrench and all parameters with an orientation, in Joseph's form.

    What is only considered has no gain, and the same form holds (Schmidt's filter). Nothing but
    the state is learnt where a contact may not slide: friction may point anywhere there.
    """
    P, seen = m[JOINT : JOINT + 484].reshape(_WIDE, _WIDE), m[SEEN : SEEN + 66].reshape(_WIDE, 3)
    gain = m[GAINS : GAINS + 66].reshape(_WIDE, 3)
    begin, n = int(m[OFFSETS]), 14 + int(m[OFFSETS + 1]) - int(m[OFFSETS])
    l00, l10, l11 = m[S], m[S + 3], m[S + 4]
    l20, l21, l22 = m[S + 6], m[S + 7], m[S + 8]
    # Near gamma0 a tangent says nothing of how a tilt would act.
    sure = m[SLIDING] if m[X] - m[SCENE + 3] > SPREADS * sqrt(m[Z]) else 0.0
    for i in range(n):
        learnt = 1.0
        if 12 <= i < 14:
            learnt = CAREFUL * sure * m[LEARNT + i - 12]
        elif i >= 14:
            learnt = CAREFUL * sure * m[OFFSETS + 2 + (1 if begin + i - 14 >= 6 else 0)]
        g0 = seen[i, 0] / l00
        g1 = (seen[i, 1] - l10 * g0) / l11
        g2 = (seen[i, 2] - l20 * g0 - l21 * g1) / (l22 * l22)
        g1 = (g1 - l21 * g2) / l11
        g0 = (g0 - l10 * g1 - l20 * g2) / l00
        gain[i, 0], gain[i, 1], gain[i, 2] = learnt * g0, learnt * g1, learnt * g2
    e0, e1, e2 = m[RESIDUAL], m[RESIDUAL + 1], m[RESIDUAL + 2]
    for i in range(12):
        m[X + i] += gain[i, 0] * e0 + gain[i, 1] * e1 + gain[i, 2] * e2
    move_parameters(
        m,
        gain[12, 0] * e0 + gain[12, 1] * e1 + gain[12, 2] * e2,
        gain[13, 0] * e0 + gain[13, 1] * e1 + gain[13, 2] * e2,
    )
    for i in range(14, n):
        m[OFFSET + begin + i - 14] += gain[i, 0] * e0 + gain[i, 1] * e1 + gain[i, 2] * e2
    for i in range(n):
        for j in range(n):
            P[i, j] -= gain[i, 0] * seen[j, 0] + gain[i, 1] * seen[j, 1] + gain[i, 2] * seen[j, 2]
    for i in range(n):
        # (K S - s), zero but for rounding where K is the optimal gain.
        a0 = gain[i, 0] * l00 + gain[i, 1] * l10 + gain[i, 2] * l20
        a1 = gain[i, 1] * l11 + gain[i, 2] * l21
        a2 = gain[i, 2] * l22
        k0 = a0 * l00 - seen[i, 0]
        k1 = a0 * l10 + a1 * l11 - seen[i, 1]
        k2 = a0 * l20 + a1 * l21 + a2 * l22 - seen[i, 2]
        for j in range(n):
            P[i, j] += k0 * gain[j, 0] + k1 * gain[j, 1] + k2 * gain[j, 2]
    _scatter(m, P)
