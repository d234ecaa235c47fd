"""What an estimate says, as one flat array that monitor and messages read."""

from math import sqrt

import numpy as np

from peg_on_hole_ros.estimator.contact import NEAREST, scene_at
from peg_on_hole_ros.estimator.direction import (
    direction_moments,
    slip_jacobian,
    slip_moments,
)
from peg_on_hole_ros.estimator.state import ACCELERATION, BIAS, CLEARANCE, FRICTION, RATE
from peg_on_hole_ros.estimator.two_points import two_point_slip, two_point_tilt
from peg_on_hole_ros.mechanics.kernel import (
    SceneScalars,
    closed_forms,
    compiled,
    determinant_at,
    workspace,
)
from peg_on_hole_ros.record_types import StateRecord

# An array that is handed to compiled code costs as much as 50 multiplications: it is one.
_SIZES = {
    "SCENE": len(SceneScalars._fields),  # with friction and diameter as they are estimated
    "NOISE": 36,  # covariance of a wrench on the peg, (6, 6)
    "X": 6,  # gamma, psi, phi [rad], rates [rad/s]
    "U": 6,  # the last wrench on the peg, peg axes, bias taken off [N], [N m]
    "P": 36,  # covariance of X, (6, 6)
    "Y": 6,  # accelerations [rad/s^2], N_K, N_B1, N_B2 [N]
    "REACTIONS": 36,  # covariance of Y, (6, 6)
    "SPREAD": 4,  # covariance of friction and peg diameter [m], (2, 2)
    "LASTING": 12,  # what friction and peg diameter make of Y, a standard deviation, (2, 6)
    "SCALES": 3,  # velocity scales of friction's mean direction [m/s]
    "SPEEDS": 6,  # slip speed and its variance at K, B1, B2
    "CONTACTS": 1,  # how many the last wrench was weighed with: 3, 2 (K and B in the hole), or 0
    "BIAS_LOAD": 1,  # variance of a carried load by what is not known of the bias [N^2]
    "DETERMINANT": 1,  # of the six equations, over its frictionless value
    "WORK": len(workspace()),
}
_ENDS = dict(zip(_SIZES, np.cumsum(list(_SIZES.values())).tolist()))
_AT = {name: _ENDS[name] - size for name, size in _SIZES.items()}
SIZE = _ENDS["WORK"]
SCENE, NOISE, X, U, P, Y, REACTIONS = (
    _AT[name] for name in ("SCENE", "NOISE", "X", "U", "P", "Y", "REACTIONS")
)
SPREAD, LASTING, SCALES, SPEEDS, CONTACTS = (
    _AT[name] for name in ("SPREAD", "LASTING", "SCALES", "SPEEDS", "CONTACTS")
)
BIAS_LOAD, DETERMINANT, WORK = (_AT[name] for name in ("BIAS_LOAD", "DETERMINANT", "WORK"))
# The rates' covariance: entry (i, j) at RATES + 6 i + j.
RATES = P + 21


def part(record: np.ndarray, name: str, shape: int | tuple[int, ...] | None = None) -> np.ndarray:
    """Return a view of one part of the record by its name, in a shape."""
    view = record[_AT[name] : _ENDS[name]]
    return view if shape is None else view.reshape(shape)


@compiled
def fill_record(
    record: np.ndarray,
    s: StateRecord,
    at: np.ndarray,
    n: int,
    p: SceneScalars,
    u: np.ndarray,
    bias_map: np.ndarray,
    share: float,
    left: np.ndarray,
) -> None:
    """
    Fill in the record by the mean of the mixture.

    Parameters
    ----------
    record : ndarray, shape (SIZE,)
        Filled, but for NOISE.
    s : record of STATE
    at : ndarray, shape (6,)
    n : int
    p : SceneScalars
        The scene as stated.
    u : ndarray, shape (6,)
        The last wrench.
    bias_map : ndarray, shape (6, 6)
    share : float
        `direction_share`.
    left : ndarray, shape (3,)
        Scratch.

    """
    m, x, C = record, s.mean, s.covariance
    q = scene_at(p, x, at, s.load[0])
    q = SceneScalars(q.d, q.D, q.H_c, q.gamma0, q.m, q.Ie, q.Iz, x[FRICTION], q.g_x, q.g_y, q.g_z)
    for i in range(len(q)):
        m[SCENE + i] = q[i]
    for i in range(6):
        m[X + i] = x[i]
        m[U + i] = u[i]
        for j in range(6):
            m[P + 6 * i + j] = C[i, j]
            a = ACCELERATION + i if i < 3 else n + i - 3
            b = ACCELERATION + j if j < 3 else n + j - 3
            m[REACTIONS + 6 * i + j] = C[a, b]
        m[Y + i] = x[ACCELERATION + i] if i < 3 else x[n + i - 3]
    m[BIAS_LOAD] = 0.0
    if at[BIAS] >= 0:
        _take_bias_off(m, x, C, at[BIAS], bias_map, 2.0 / p.d)
    # The diameter is what the clearance leaves of the hole's.
    by_log = -(q.D - q.d) if at[CLEARANCE] >= 0 else 0.0
    k = max(at[CLEARANCE], 0)
    m[SPREAD] = C[FRICTION, FRICTION]
    m[SPREAD + 1] = m[SPREAD + 2] = by_log * C[FRICTION, k]
    m[SPREAD + 3] = by_log * by_log * C[k, k]
    for row in range(2):
        variance = m[SPREAD + 3 * row]
        over = 1.0 / sqrt(variance) if variance > 0.0 else 0.0
        of, scale = (FRICTION, 1.0) if row == 0 else (k, by_log)
        for i in range(6):
            a = ACCELERATION + i if i < 3 else n + i - 3
            m[LASTING + 6 * row + i] = scale * C[of, a] * over
    tilt = min(max(x[0], q.gamma0 + NEAREST), 1.5)
    geo = closed_forms(q.d, q.D, q.H_c, q.gamma0, tilt)
    scales = m[SCALES : SCALES + 3]
    direction_moments(q, geo, x, C, share, scales, left)
    m[CONTACTS] = s.contacts[0]
    for i in range(3):
        if m[CONTACTS] == 2.0:
            rows = two_point_slip(q, two_point_tilt(q, x[0]), min(i, 1))
            m[SCALES + i] = sqrt(slip_moments(rows, x, C, share)[2])
        else:
            rows = slip_jacobian(q, geo, i)
        _slip(m, rows, x, C, i)
    rates = (x[RATE], x[RATE + 1], x[RATE + 2])
    if m[CONTACTS] != 2.0:
        m[DETERMINANT] = determinant_at(q, scales, tilt, rates, m[WORK:])


@compiled
def _take_bias_off(m, x, C, first, bias_map, over_radius):
    for i in range(6):
        weight = 1.0 if i < 3 else over_radius * over_radius
        for j in range(6):
            m[U + i] -= bias_map[i, j] * x[first + j]
            for k in range(6):
                m[BIAS_LOAD] += weight * bias_map[i, j] * C[first + j, first + k] * bias_map[i, k]


@compiled
def _slip(m, rows, x, C, i):
    """Fill in speed and variance of the peg's material point at one contact, by its Jacobian."""
    speed2, d0, d1, d2 = 0.0, 0.0, 0.0, 0.0
    for a, b, c in rows:
        v = a * x[RATE] + b * x[RATE + 1] + c * x[RATE + 2]
        speed2 += v * v
        d0 += v * a
        d1 += v * b
        d2 += v * c
    speed = sqrt(speed2)
    over = 1.0 / (speed + 1e-300)
    d0, d1, d2 = d0 * over, d1 * over, d2 * over
    k = RATE
    variance = d0 * d0 * C[k, k] + d1 * d1 * C[k + 1, k + 1] + d2 * d2 * C[k + 2, k + 2]
    variance += 2.0 * (d0 * d1 * C[k, k + 1] + d0 * d2 * C[k, k + 2] + d1 * d2 * C[k + 1, k + 2])
    m[SPEEDS + 2 * i], m[SPEEDS + 2 * i + 1] = speed, max(variance, 0.0)
