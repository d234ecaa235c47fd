"""
A bias of the sensor in the air, where gravity is all that a peg's wrench has to carry.

What a sensor reads of a peg that hangs free is its weight, its bias, and what moves it. How it is
moved nobody measures, but a peg that goes at speeds v is accelerated by no more than their
difference over the time, in the mean: over a time T the mean of its readings is off by the mass
times sqrt(2) v / T, whatever it did meanwhile. So it is one mean that tells, over all of the time
in the air so far, and not one reading after another. What goes one way for longer than speeds
explain is a peg that is being pressed on: the mean tells nothing more then.
"""

from math import cos, sin

from peg_on_hole_ros.estimation.kernel.memory import (
    AIR,
    AIR_TOLD,
    GAINS,
    GIVEN,
    HANGING,
    OFFSET,
    OFFSET_CROSS,
    OFFSET_SPREAD,
    UNLOAD,
    X,
)
from peg_on_hole_ros.estimation.kernel.offsets import BIAS, COUNT
from peg_on_hole_ros.mechanics.kernel import compiled, inlined, scene_of

# Readings are taken in blocks of so long [s], and a block once the next one has ended in the air
# as well: contact that begins is not declared before it has been felt for some 50 ms.
BLOCK = 0.1
# A robot brings a peg over its hole no faster than the reduced speed of ISO 10218-1, a standard
# deviation [m/s].
SPEED = 0.25
# Longer than this [s] a zero drifts, and the same mean tells no more of it.
LONGEST = 10.0
# Nor is a bias known better than by the mean of so many readings, as a tare takes it.
READINGS = 100.0
_END = BIAS.stop
# Places of a block at AIR + 15 n, of all readings that were taken (0), of those that wait for the
# next block to end (1), and of that (2): number, time [s], its turning [rad^2/s], sum of biases,
# and of their products with the time since the begin.
_TIME, _TURNED, _SUM, _MOMENT, _WIDE = 1, 2, 3, 9, 15
_TAKEN, _WAITING, _NEW = AIR, AIR + _WIDE, AIR + 2 * _WIDE


@compiled
def touched(m):
    """Forget the time in the air so far, when it ends: what it has told stays."""
    for i in range(3 * _WIDE):
        m[AIR + i] = 0.0
    for i in range(2 * _END):
        m[AIR_TOLD + i] = 0.0


@compiled
def hang(m, dt):
    """
    Take the wrench that is held as a reading of a peg that hangs free, and learn from it.

    Parameters
    ----------
    m : ndarray
        Memory, with the wrench at GIVEN.
    dt : float
        For which it was held [s].

    """
    p = scene_of(m)
    s, c, spsi, cpsi = sin(m[X]), cos(m[X]), sin(m[X + 1]), cos(m[X + 1])
    sphi, cphi = sin(m[X + 2]), cos(m[X + 2])
    h, e = cpsi * p.g_x + spsi * p.g_y, cpsi * p.g_y - spsi * p.g_x
    across, along = c * h + s * p.g_z, c * p.g_z - s * h
    # What would hold the peg, less what is read of it, in peg axes.
    l0 = -p.m * (cphi * across + sphi * e) - m[GIVEN]
    l1 = -p.m * (cphi * e - sphi * across) - m[GIVEN + 1]
    l2 = -p.m * along - m[GIVEN + 2]
    l3, l4, l5 = -m[GIVEN + 3], -m[GIVEN + 4], -m[GIVEN + 5]
    since = m[_TAKEN + _TIME] + m[_WAITING + _TIME] + m[_NEW + _TIME] + 0.5 * dt
    for i in range(_END):
        u = UNLOAD + 6 * i
        read = (
            m[u] * l0 + m[u + 1] * l1 + m[u + 2] * l2
            + m[u + 3] * l3 + m[u + 4] * l4 + m[u + 5] * l5
        )  # fmt: skip
        m[_NEW + _SUM + i] += read
        m[_NEW + _MOMENT + i] += since * read
    r0, r1, r2 = m[X + 3], m[X + 4], m[X + 5]
    m[_NEW] += 1.0
    m[_NEW + _TIME] += dt
    m[_NEW + _TURNED] += dt * (r0 * r0 + r1 * r1 + r2 * r2 + 2.0 * c * r1 * r2)
    if m[_NEW + _TIME] < BLOCK:
        return
    for i in range(_WIDE):
        m[_TAKEN + i] += m[_WAITING + i]
        m[_WAITING + i] = m[_NEW + i]
        m[_NEW + i] = 0.0
    time = m[_TAKEN + _TIME]
    if time > 0.0 and time < LONGEST and not _leans(m):
        _learn(m)


@inlined
def squared_acceleration(time, turned):
    """
    Return by how much a mean over the time in the air is accelerated, squared [m^2/s^4].

    Parameters
    ----------
    time : float
        [s], above zero.
    turned : float
        How fast the peg turned meanwhile, squared, times the time [rad^2/s].

    """
    # In the axes of a sensor that turns by w a velocity v changes by w v all the time.
    return SPEED * SPEED * (2.0 / (time * time) + turned / time)


@inlined
def _leans(m):
    """Return whether readings go one way by more than noise and speeds explain."""
    number, time, turned = m[_TAKEN], m[_TAKEN + _TIME], m[_TAKEN + _TURNED]
    # With the mean speed V (12 / T^2) ((v_0 + v_T) / 2 - V) is their slope: over half of the time.
    moved = SPEED * SPEED * (36.0 / (time * time) + 3.0 * turned / time)
    for k in range(_END):
        mean = m[_TAKEN + _SUM + k] / number
        lean = (m[_TAKEN + _MOMENT + k] / number - 0.5 * time * mean) * 6.0 / time
        if lean * lean > 3.0 * m[HANGING + k] / number + m[HANGING + 6 + k] * moved:
            return True
    return False


@inlined
def _learn(m):
    """Correct the bias by what the mean tells beyond what it had told before."""
    number = m[_TAKEN]
    moved = squared_acceleration(m[_TAKEN + _TIME], m[_TAKEN + _TURNED])
    for k in range(_END):
        noise, mass2, tilted = m[HANGING + k], m[HANGING + 6 + k], m[HANGING + 12 + k]
        told = 1.0 / (noise / number + mass2 * moved + tilted)
        total, news = told * m[_TAKEN + _SUM + k] / number, told - m[AIR_TOLD + k]
        if news > 0.0 and m[OFFSET_SPREAD + 11 * k + 2] > noise / READINGS:
            _correct(m, k, (total - m[AIR_TOLD + 6 + k]) / news, 1.0 / news)
            m[AIR_TOLD + k], m[AIR_TOLD + 6 + k] = told, total


@inlined
def _correct(m, k, value, variance):
    """Correct the bias with one component of it that was measured; all else keeps its place."""
    for j in range(12):
        m[GAINS + j] = m[OFFSET_CROSS + 12 * k + j]
    for j in range(10):
        m[GAINS + 12 + j] = m[OFFSET_SPREAD + 10 * k + j]
    row, over = GAINS + 14, 1.0 / (m[GAINS + 14 + k] + variance)
    off = over * (value - m[OFFSET + k])
    for i in range(_END):
        share = over * m[row + i]
        m[OFFSET + i] += m[row + i] * off
        for j in range(12):
            m[OFFSET_CROSS + 12 * i + j] -= share * m[GAINS + j]
        for j in range(2):
            m[OFFSET_SPREAD + 10 * i + j] -= share * m[GAINS + 12 + j]
        for j in range(COUNT):
            if j <= i or j >= _END:
                left = m[OFFSET_SPREAD + 10 * i + 2 + j] - share * m[row + j]
                m[OFFSET_SPREAD + 10 * i + 2 + j] = left
                m[OFFSET_SPREAD + 10 * j + 2 + i] = left
