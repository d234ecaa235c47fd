"""How the joint covariance goes with a step, given the step's derivatives."""

from peg_on_hole_ros.estimation.kernel.memory import (
    CROSS,
    OFFSET_CROSS,
    OFFSET_SPREAD,
    OFFSETS,
    RATES,
    ROWS,
    WITH,
    Z,
    covariance_entry,
    times_covariance,
)
from peg_on_hole_ros.mechanics.kernel import compiled, inlined


@compiled
def carry(m, slopes, h, rate_noise):
    """
    Carry the joint covariance through one step, given G = d(rates)/d(state, wrench).

    The angles move by h times the rates at the end, and the wrench stays: with W = G Z and
    B = G Z G.T all of F Z F.T is made of Z, W and B.
    """
    uncertain = times_covariance(m, slopes, 3)
    if m[OFFSETS + 1] > 0.0:
        _carry_offsets(m, slopes, h, False)
    for i in range(3):
        for j in range(i + 1):
            total = covariance_entry(m, slopes, i, j, uncertain)
            if i == j:
                total += rate_noise * h
            # Noise too: the implicit step moves the angle with the rate at its end.
            corner = Z + 12 * i + j
            m[corner + 39] = total
            m[corner] += h * (m[ROWS + 12 * i + j] + m[ROWS + 12 * j + i] + h * total)
            m[Z + 12 * i + 3 + j] = m[ROWS + 12 * j + i] + h * total
            m[Z + 12 * j + 3 + i] = m[ROWS + 12 * i + j] + h * total
    for i in range(3):
        for j in range(6, 12):
            m[Z + 12 * i + j] += h * m[ROWS + 12 * i + j]
            m[Z + 12 * (3 + i) + j] = m[ROWS + 12 * i + j]
    _mirror(m)
    if uncertain:
        for i in range(3):
            for k in range(2):
                m[CROSS + 12 * k + i] += h * m[WITH + 2 * i + k]
                m[CROSS + 12 * k + 3 + i] = m[WITH + 2 * i + k]


@inlined
def _mirror(m):
    """Copy what is on the other side of the diagonal of Z, from where `carry` has written."""
    for i in range(3):
        for j in range(i):
            m[Z + 12 * j + i] = m[Z + 12 * i + j]
            m[RATES + 12 * j + i] = m[RATES + 12 * i + j]
        for j in range(3, 12):
            m[Z + 12 * j + i] = m[Z + 12 * i + j]
        for j in range(6, 12):
            m[Z + 12 * j + 3 + i] = m[Z + 12 * (3 + i) + j]


@compiled
def carry_all(m, slopes, h, rate_noise):
    """Carry the joint covariance through a step whose angles have slopes of their own."""
    uncertain = times_covariance(m, slopes, 6)
    if m[OFFSETS + 1] > 0.0:
        _carry_offsets(m, slopes, h, True)
    for i in range(6):
        # Rates come first in the slopes, angles in the state.
        n = (i + 3) % 6
        for j in range(i + 1):
            l = (j + 3) % 6
            total = covariance_entry(m, slopes, n, l, uncertain)
            m[Z + 12 * i + j] = total
            m[Z + 12 * j + i] = total
        for j in range(6, 12):
            m[Z + 12 * i + j] = m[ROWS + 12 * n + j]
            m[Z + 12 * j + i] = m[ROWS + 12 * n + j]
        if uncertain:
            m[CROSS + i] = m[WITH + 2 * n]
            m[CROSS + 12 + i] = m[WITH + 2 * n + 1]
    for i in range(3):
        add_walk(m, i, rate_noise, h)


@inlined
def add_walk(m, i, density, h):
    """Add the random walk of one rate [rad^2/s^3] over a time, and what it makes of its angle."""
    m[Z + 13 * i] += density * h * h * h / 3.0
    m[Z + 13 * i + 3] += 0.5 * density * h * h
    m[Z + 13 * i + 36] += 0.5 * density * h * h
    m[RATES + 13 * i] += density * h


@inlined
def _carry_offsets(m, slopes, h, second_order):
    """Carry what the offsets share with the state; they move it by the wrench alone."""
    for k in range(int(m[OFFSETS]), int(m[OFFSETS + 1])):
        at, spread = OFFSET_CROSS + 12 * k, OFFSET_SPREAD + 10 * k
        rate = angle = (0.0, 0.0, 0.0)
        for i in range(6 if second_order else 3):
            total = slopes[i, 12] * m[spread] + slopes[i, 13] * m[spread + 1]
            for j in range(12):
                total += slopes[i, j] * m[at + j]
            if i < 3:
                rate = (rate[1], rate[2], total)
            else:
                angle = (angle[1], angle[2], total)
        for i in range(3):
            m[at + i] = angle[i] if second_order else m[at + i] + h * rate[i]
            m[at + 3 + i] = rate[i]
