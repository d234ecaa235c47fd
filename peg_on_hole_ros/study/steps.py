"""One step of each integrator on the three-degree-of-freedom motion, compiled."""

from math import sqrt

from peg_on_hole_ros.estimation.steps.implicit_euler import CONVERGED, FAILED, implicit_euler
from peg_on_hole_ros.mechanics.kernel import (
    WIDTH,
    accelerate,
    accelerate_with_derivatives,
    compiled,
    inlined,
    workspace,
)

METHODS = (
    "explicit Euler",
    "semi-implicit Euler",
    "RK4",
    "linearly implicit Euler",
    "ROS2",
    "ROS3P",
    "implicit Euler",
    "implicit Euler, halved",
)
EXPLICIT_EULER, SEMI_IMPLICIT, RK4, LINEARLY_IMPLICIT, ROS2, ROS3P, IMPLICIT, HALVED = range(8)
# A refused step is taken in halves so many times, as the filter does.
MAX_HALVINGS = 7
# A step that ends where the equations have no finite value: below gamma0, or blown up.
NOT_FINITE = 2

# Places in the scratch memory: wrench, its rate, stages, accelerations, their derivatives.
_U, _DU, _TRIAL, _A, _B, _C, _Y = 0, 6, 12, 18, 24, 30, 36
_DY = 42
_SLOPES = _DY + 6 * WIDTH
_WORK = _SLOPES + 3 * WIDTH
SCRATCH = _WORK + len(workspace())

# Verwer et al., SIAM J. Sci. Comput. 20 (1999) 1456: L-stable for either root; order 2 with any J.
_ROS2_GAMMA = 1.0 - sqrt(0.5)
# Lang and Verwer, BIT 41 (2001) 731: A-stable, order 3, without order reduction.
_ROS3P_GAMMA = 0.5 + sqrt(3.0) / 6.0
_A21 = 1.267949192431123
_C21, _C31, _C32 = -1.607695154586736, -3.464101615137755, -1.732050807568877
_M1, _M2, _M3 = 2.0, 0.5773502691896258, 0.4226497308103742
_G1, _G2, _G3 = _ROS3P_GAMMA, -0.2113248654051871, -1.077350269189626


@inlined
def _wrench(coefficients, interval, t, out, at):
    """Put the wrench at time t [s] and its rate (6 places later): cubics, `interval` [s] each."""
    k = min(max(int(t / interval), 0), coefficients.shape[0] - 1)
    r = t - k * interval
    for i in range(6):
        c0, c1, c2, c3 = (
            coefficients[k, 0, i],
            coefficients[k, 1, i],
            coefficients[k, 2, i],
            coefficients[k, 3, i],
        )
        out[at + i] = c0 + r * (c1 + r * (c2 + r * c3))
        out[at + 6 + i] = c1 + r * (2.0 * c2 + 3.0 * r * c3)


@inlined
def _evaluate(p, scales, m, coefficients, interval, t, x, out):
    """Put the rate of change of a state at `out`: rates, then accelerations."""
    _wrench(coefficients, interval, t, m, _U)
    accelerate(p, scales, x, m[_U : _U + 6], m[_WORK:], m[_Y : _Y + 6])
    for i in range(3):
        m[out + i], m[out + 3 + i] = x[3 + i], m[_Y + i]


@inlined
def _linearise(p, scales, m, coefficients, interval, t, x, out):
    """As `_evaluate`, and leave the exact derivatives at _DY."""
    _wrench(coefficients, interval, t, m, _U)
    dy = m[_DY:_SLOPES].reshape(6, WIDTH)
    accelerate_with_derivatives(p, scales, x, m[_U : _U + 6], m[_WORK:], m[_Y : _Y + 6], dy)
    for i in range(3):
        m[out + i], m[out + 3 + i] = x[3 + i], m[_Y + i]


@inlined
def _by_time(m, i):
    """Return the explicit derivative of an acceleration by time, through the wrench."""
    total = 0.0
    for j in range(6):
        total += m[_DY + WIDTH * i + 6 + j] * m[_DU + j]
    return total


@inlined
def _solve(m, g, at):
    """
    Solve (I - g J) k = r in place at six places, J = [[0, I], [a_q, a_v]] of the motion.

    The angles are eliminated: what is left is 3x3, solved by cofactors.
    """
    w0, w1, w2 = m[at], m[at + 1], m[at + 2]
    e = _DY
    r0 = m[at + 3] + g * (m[e] * w0 + m[e + 1] * w1 + m[e + 2] * w2)
    e = _DY + WIDTH
    r1 = m[at + 4] + g * (m[e] * w0 + m[e + 1] * w1 + m[e + 2] * w2)
    e = _DY + 2 * WIDTH
    r2 = m[at + 5] + g * (m[e] * w0 + m[e + 1] * w1 + m[e + 2] * w2)
    e = _DY
    a00 = 1.0 - g * (m[e + 3] + g * m[e])
    a01, a02 = -g * (m[e + 4] + g * m[e + 1]), -g * (m[e + 5] + g * m[e + 2])
    e = _DY + WIDTH
    a10, a12 = -g * (m[e + 3] + g * m[e]), -g * (m[e + 5] + g * m[e + 2])
    a11 = 1.0 - g * (m[e + 4] + g * m[e + 1])
    e = _DY + 2 * WIDTH
    a20, a21 = -g * (m[e + 3] + g * m[e]), -g * (m[e + 4] + g * m[e + 1])
    a22 = 1.0 - g * (m[e + 5] + g * m[e + 2])
    c0, c1, c2 = a11 * a22 - a12 * a21, a12 * a20 - a10 * a22, a10 * a21 - a11 * a20
    over = 1.0 / (a00 * c0 + a01 * c1 + a02 * c2)
    k0 = over * (c0 * r0 + (a02 * a21 - a01 * a22) * r1 + (a01 * a12 - a02 * a11) * r2)
    k1 = over * (c1 * r0 + (a00 * a22 - a02 * a20) * r1 + (a02 * a10 - a00 * a12) * r2)
    k2 = over * (c2 * r0 + (a01 * a20 - a00 * a21) * r1 + (a00 * a11 - a01 * a10) * r2)
    m[at], m[at + 1], m[at + 2] = w0 + g * k0, w1 + g * k1, w2 + g * k2
    m[at + 3], m[at + 4], m[at + 5] = k0, k1, k2


@compiled
def explicit_step(method, p, scales, coefficients, interval, t, h, x, x1, m):
    """Fill x1 by explicit Euler, semi-implicit Euler or RK4; arguments as of `advance`."""
    _evaluate(p, scales, m, coefficients, interval, t, x, _A)
    if method != RK4:
        for i in range(3):
            x1[3 + i] = x[3 + i] + h * m[_A + 3 + i]
            x1[i] = x[i] + h * (x1[3 + i] if method == SEMI_IMPLICIT else x[3 + i])
        return 1
    trial = m[_TRIAL : _TRIAL + 6]
    for i in range(6):
        x1[i] = x[i] + h / 6.0 * m[_A + i]
    for stage in range(3):
        part = h if stage == 2 else 0.5 * h
        weight = h / 6.0 if stage == 2 else h / 3.0
        for i in range(6):
            trial[i] = x[i] + part * m[_A + i]
        _evaluate(p, scales, m, coefficients, interval, t + part, trial, _A)
        for i in range(6):
            x1[i] += weight * m[_A + i]
    return 4


@compiled
def rosenbrock_step(method, p, scales, coefficients, interval, t, h, x, x1, m):
    """Fill x1 by linearly implicit Euler, ROS2 or ROS3P; arguments as of `advance`."""
    if method == LINEARLY_IMPLICIT:
        # Newton's first iteration towards implicit Euler, which takes the wrench at the end.
        _linearise(p, scales, m, coefficients, interval, t + h, x, _A)
        _solve(m, h, _A)
        for i in range(6):
            x1[i] = x[i] + h * m[_A + i]
        return 1
    _linearise(p, scales, m, coefficients, interval, t, x, _A)
    trial = m[_TRIAL : _TRIAL + 6]
    if method == ROS2:
        g = _ROS2_GAMMA * h
        turn0, turn1, turn2 = g * _by_time(m, 0), g * _by_time(m, 1), g * _by_time(m, 2)
        m[_A + 3] += turn0
        m[_A + 4] += turn1
        m[_A + 5] += turn2
        _solve(m, g, _A)
        for i in range(6):
            trial[i] = x[i] + h * m[_A + i]
        _evaluate(p, scales, m, coefficients, interval, t + h, trial, _B)
        for i in range(6):
            m[_B + i] -= 2.0 * m[_A + i]
        m[_B + 3] -= turn0
        m[_B + 4] -= turn1
        m[_B + 5] -= turn2
        _solve(m, g, _B)
        for i in range(6):
            x1[i] = x[i] + h * (1.5 * m[_A + i] + 0.5 * m[_B + i])
        return 2
    # ROS3P in the form without products with J: (I/(g h) - J) U_i = F(x_i) + sum c_ij U_j / h + ..
    g = _ROS3P_GAMMA * h
    turn0, turn1, turn2 = h * _by_time(m, 0), h * _by_time(m, 1), h * _by_time(m, 2)
    m[_A + 3] += _G1 * turn0
    m[_A + 4] += _G1 * turn1
    m[_A + 5] += _G1 * turn2
    for i in range(6):
        m[_A + i] *= g
    _solve(m, g, _A)
    for i in range(6):
        trial[i] = x[i] + _A21 * m[_A + i]
    _evaluate(p, scales, m, coefficients, interval, t + h, trial, _B)
    # The third stage is at the same place: a32 = 0.
    for i in range(6):
        m[_C + i] = m[_B + i] + _C31 / h * m[_A + i]
        m[_B + i] += _C21 / h * m[_A + i]
    m[_B + 3] += _G2 * turn0
    m[_B + 4] += _G2 * turn1
    m[_B + 5] += _G2 * turn2
    m[_C + 3] += _G3 * turn0
    m[_C + 4] += _G3 * turn1
    m[_C + 5] += _G3 * turn2
    for i in range(6):
        m[_B + i] *= g
    _solve(m, g, _B)
    for i in range(6):
        m[_C + i] = g * (m[_C + i] + _C32 / h * m[_B + i])
    _solve(m, g, _C)
    for i in range(6):
        x1[i] = x[i] + _M1 * m[_A + i] + _M2 * m[_B + i] + _M3 * m[_C + i]
    return 2


@compiled
def implicit_step(p, scales, coefficients, interval, t, h, x, x1, m, halvings):
    """Fill x1 by implicit Euler, in up to 2^halvings parts where it is refused otherwise."""
    dy = m[_DY:_SLOPES].reshape(6, WIDTH)
    slopes = m[_SLOPES:_WORK].reshape(3, WIDTH)
    start = m[_A : _A + 6]
    evaluations, pieces = 0, 1
    for _ in range(halvings + 1):
        part = h / pieces
        for i in range(6):
            start[i] = x[i]
        status = CONVERGED
        for n in range(pieces):
            _wrench(coefficients, interval, t + (n + 1) * part, m, _U)
            status, more = implicit_euler(
                p, scales, start, m[_U : _U + 6], part, x1, m[_Y : _Y + 6], dy, slopes, m[_WORK:]
            )
            evaluations += more
            if status != CONVERGED:
                break
            for i in range(6):
                start[i] = x1[i]
        if status == CONVERGED:
            return CONVERGED, evaluations
        pieces *= 2
    return FAILED, evaluations


@compiled
def advance(method, p, scales, coefficients, interval, t, h, count, x, x1, m):
    """
    Advance a state by equal steps of one method.

    Parameters
    ----------
    method : int
        Index in METHODS.
    p : SceneScalars
    scales : ndarray, shape (3,)
        Velocity scales of friction at K, B1, B2 [m/s].
    coefficients : ndarray, shape (n, 4, 6)
        Cubics of the wrench about the mass centre in peg axes [N], [N m], from time 0 on; those
        of the last go on.
    interval : float
        Time of one cubic [s].
    t, h : float
        Time at the start, and step [s].
    count : int
        Steps.
    x, x1 : ndarray, shape (6,)
        State at the start (overwritten) and at the end [rad], [rad/s].
    m : ndarray, shape (SCRATCH,)

    Returns
    -------
    status : int
        CONVERGED; FAILED, where the method says so by itself; NOT_FINITE.
    evaluations : int
        Of the six equations.

    """
    evaluations = 0
    for n in range(count):
        now = t + n * h
        if method <= RK4:
            evaluations += explicit_step(
                method, p, scales, coefficients, interval, now, h, x, x1, m
            )
        elif method < IMPLICIT:
            evaluations += rosenbrock_step(
                method, p, scales, coefficients, interval, now, h, x, x1, m
            )
        else:
            halvings = MAX_HALVINGS if method == HALVED else 0
            status, more = implicit_step(
                p, scales, coefficients, interval, now, h, x, x1, m, halvings
            )
            evaluations += more
            if status != CONVERGED:
                return FAILED, evaluations
        total = 0.0
        for i in range(6):
            x[i] = x1[i]
            total += x1[i]
        if total - total != 0.0:
            return NOT_FINITE, evaluations
    return CONVERGED, evaluations
