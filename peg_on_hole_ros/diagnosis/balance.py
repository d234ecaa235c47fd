"""How well a wrench is explained by a peg in free air or on three contacts, as a likelihood."""

from math import cos, fabs, hypot, log, pi, sin, sqrt
from typing import Annotated

import numpy as np

from peg_on_hole_ros.diagnosis.tuned import WRENCH_BALANCE
from peg_on_hole_ros.mechanics.kernel import SceneScalars, closed_forms, compiled
from peg_on_hole_ros.mechanics.linear_algebra import (
    hez_rotation,
    peg_rotation,
    peg_turns,
)
from peg_on_hole_ros.typed_record import Floats, Matrix3, Record

# Columns of forces that a model leaves open: of the holder's acceleration in the air, of K, B1, B2
# on the rim. Models: free, and three contacts at frictions about the stated one.
MODELS = 1 + WRENCH_BALANCE.frictions
LOG_TWO_PI = log(2.0 * pi)


class BalanceModel(Record):
    """
    What the likelihood of any wrench needs, of one model.

    Attributes
    ----------
    over_noise : shape (3, 6)
        Its columns over the variances of the wrench.
    inverse : shape (3, 3)
        Of the normal matrix.
    constant : float

    """

    over_noise: Annotated[Floats, (3, 6)]
    inverse: Matrix3
    constant: float


@compiled
def fill_peg_axes(q: np.ndarray, R: np.ndarray) -> None:
    """Fill R_HP, peg axes in hole axes, shape (3, 3)."""
    rotation = peg_rotation(peg_turns(q[0], q[1], q[2]))
    for i in range(3):
        for j in range(3):
            R[i, j] = rotation[3 * i + j]


@compiled
def fill_moment(columns: np.ndarray, j: int, r: np.ndarray) -> None:
    """Fill the lower half of a column with the moment of its force at r."""
    F0, F1, F2 = columns[0, j], columns[1, j], columns[2, j]
    columns[3, j] = r[1] * F2 - r[2] * F1
    columns[4, j] = r[2] * F0 - r[0] * F2
    columns[5, j] = r[0] * F1 - r[1] * F0


@compiled
def fill_free_air_columns(center: np.ndarray, columns: np.ndarray) -> None:
    """Fill in the forces at the mass centre that a holder's acceleration needs, (6, 3)."""
    columns[:] = 0.0
    for j in range(3):
        columns[j, j] = 1.0
        fill_moment(columns, j, center)


@compiled
def contact_columns(
    p: SceneScalars,
    sensor: np.ndarray,
    q: np.ndarray,
    rates: np.ndarray,
    slowest: float,
    friction: float,
    columns: np.ndarray,
) -> bool:
    """
    Fill in what one newton at K, B1, B2 exerts on the peg, peg axes, about the sensor, (6, 3).

    Parameters
    ----------
    p : SceneScalars
    sensor : ndarray, shape (3,)
        Its origin in the peg frame [m].
    q, rates : ndarray, shape (3,)
        [rad], [rad/s].
    slowest : float
        Below it the rates determine no direction of a slip [m/s].
    friction : float
    columns : ndarray, shape (6, 3)
        Filled.

    Returns
    -------
    bool
        Whether every contact slides, and so has a direction of friction.

    """
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, q[0])
    s, c, a1, a2, S1, S2, b = geo.s, geo.c, geo.a1, geo.a2, geo.S1, geo.S2, geo.b
    sp, cp = sin(q[2]), cos(q[2])
    slides = True
    force, arm = np.empty(3), np.empty(3)
    to_O = sqrt(S1 * S1 + b * b + a1 * a1)
    for i in range(3):
        dg, dpsi, dphi = rates[0], rates[1], rates[2]
        if i == 0:
            n_h, n_e, n_z = c, 0.0, s
            r_h, r_e, r_z = -0.5 * p.D, 0.0, 0.0
            v_h, v_e = 2.0 * a1 * dg, -0.5 * p.D * dpsi - 0.5 * p.d * dphi
            v_z = -2.0 * a1 * c / s * dg
        else:
            e = b if i == 1 else -b
            n_h, n_e, n_z = -S1 / to_O, e / to_O, a1 / to_O
            r_h, r_e, r_z = S1, -e, 0.0
            v_h, v_e = 2.0 * a1 * dg + e * (dpsi + c * dphi), S1 * dpsi + S2 * dphi
            v_z = 2.0 * S1 * dg + e * s * dphi
        speed = sqrt(v_h * v_h + v_e * v_e + v_z * v_z)
        if speed < slowest:
            slides = False
            speed = slowest
        share = friction / speed
        f_h, f_e, f_z = n_h - share * v_h, n_e - share * v_e, n_z - share * v_z
        # From the peg frame's origin, where O is a2 up the axis and a1 above the rim.
        o_h, o_e, o_z = r_h - a2 * s, r_e, r_z - (a1 - a2 * c)
        _to_peg(f_h, f_e, f_z, s, c, sp, cp, force)
        _to_peg(o_h, o_e, o_z, s, c, sp, cp, arm)
        for k in range(3):
            columns[k, i] = force[k]
            arm[k] -= sensor[k]
        fill_moment(columns, i, arm)
    return slides


@compiled
def _to_peg(h, e, z, s, c, sp, cp, out):
    """Turn a vector from (h, e, z) to peg axes."""
    r00, r01, r02, r10, r11, r20, r21, r22 = hez_rotation(s, c, sp, cp)
    out[0] = r00 * h + r10 * e + r20 * z
    out[1] = r01 * h + r11 * e + r21 * z
    out[2] = r02 * h + r22 * z


@compiled
def prepare(columns: np.ndarray, prior: float, noise: np.ndarray, model: BalanceModel) -> None:
    """
    Fill in what the likelihood of any wrench needs, of one model.

    Parameters
    ----------
    columns : ndarray, shape (6, 3)
    prior : float
        Variance of what each column is multiplied with [N^2].
    noise : ndarray, shape (6,)
        Variances of the wrench.
    model : BalanceModel
        Filled.

    """
    K, over_noise, inverse = np.zeros((3, 3)), model.over_noise, model.inverse
    for j in range(3):
        for i in range(6):
            over_noise[j, i] = columns[i, j] / noise[i]
        for k in range(j + 1):
            t = 1.0 / prior if j == k else 0.0
            for i in range(6):
                t += over_noise[j, i] * columns[i, k]
            K[j, k] = t
            K[k, j] = t
    c00 = K[1, 1] * K[2, 2] - K[1, 2] * K[1, 2]
    c01 = K[0, 2] * K[1, 2] - K[0, 1] * K[2, 2]
    c02 = K[0, 1] * K[1, 2] - K[0, 2] * K[1, 1]
    determinant = K[0, 0] * c00 + K[0, 1] * c01 + K[0, 2] * c02
    over = 1.0 / determinant
    inverse[0, 0], inverse[0, 1], inverse[0, 2] = c00 * over, c01 * over, c02 * over
    inverse[1, 0], inverse[1, 1] = c01 * over, (K[0, 0] * K[2, 2] - K[0, 2] * K[0, 2]) * over
    inverse[1, 2] = (K[0, 1] * K[0, 2] - K[0, 0] * K[1, 2]) * over
    inverse[2, 0], inverse[2, 1] = c02 * over, inverse[1, 2]
    inverse[2, 2] = (K[0, 0] * K[1, 1] - K[0, 1] * K[0, 1]) * over
    t = log(determinant) + 3.0 * log(prior) + 6.0 * LOG_TWO_PI
    for i in range(6):
        t += log(noise[i])
    model.constant = -0.5 * t


@compiled
def likelihood(
    model: BalanceModel, prior: float, pushes: bool, y: np.ndarray, noise: np.ndarray, load: float
) -> tuple[float, float]:
    """
    Return the log likelihood of a wrench that a model has to balance, and what is left of it.

    Parameters
    ----------
    model : BalanceModel
        From `prepare`.
    prior : float
        As it was there.
    pushes : bool
        Whether the columns are those of contacts, which cannot pull.
    y : ndarray, shape (6,)
        Wrench on the peg with its weight, peg axes, about the sensor [N], [N m].
    noise : ndarray, shape (6,)
    load : float
        [N]; a share of it may stay unexplained.

    Returns
    -------
    value : float
    left : float
        Squares of what is left over the noise, over what may be.

    """
    b0 = b1 = b2 = square = 0.0
    over_noise, inverse = model.over_noise, model.inverse
    for i in range(6):
        b0 += over_noise[0, i] * y[i]
        b1 += over_noise[1, i] * y[i]
        b2 += over_noise[2, i] * y[i]
        square += y[i] * y[i] / noise[i]
    N0 = -(inverse[0, 0] * b0 + inverse[0, 1] * b1 + inverse[0, 2] * b2)
    N1 = -(inverse[1, 0] * b0 + inverse[1, 1] * b1 + inverse[1, 2] * b2)
    N2 = -(inverse[2, 0] * b0 + inverse[2, 1] * b1 + inverse[2, 2] * b2)
    large = (N0 * N0 + N1 * N1 + N2 * N2) / prior
    square = max(square + b0 * N0 + b1 * N1 + b2 * N2 - large, 0.0)
    share = WRENCH_BALANCE.unexplained
    wider = 1.0 + share * share * load * load / noise[0]
    left = square / wider
    if pushes:
        spare = (0.1 * max(fabs(N0), fabs(N1), fabs(N2))) ** 2
        for k in range(3):
            N = N0 if k == 0 else N1 if k == 1 else N2
            if N < 0.0:
                left += N * N / (inverse[k, k] * wider + spare)
    return model.constant - 0.5 * (left + large) - 3.0 * log(wider), left


@compiled
def friction_increment(
    model: BalanceModel, slope: np.ndarray, y: np.ndarray, noise: np.ndarray
) -> float:
    """
    Return by how much friction is to change so that least is left (Gauss and Newton).

    The reactions that follow it are eliminated: near gamma0 they change a lot with friction.

    Parameters
    ----------
    model : BalanceModel
        From `prepare`, of contacts.
    slope : ndarray, shape (6, 3)
        How its columns change with friction.
    y, noise : ndarray, shape (6,)
        As for `likelihood`.

    """
    b, N, along, moved = np.zeros(3), np.empty(3), np.empty(6), np.zeros(3)
    over_noise, inverse = model.over_noise, model.inverse
    for j in range(3):
        for i in range(6):
            b[j] += over_noise[j, i] * y[i]
    for j in range(3):
        N[j] = -(inverse[j, 0] * b[0] + inverse[j, 1] * b[1] + inverse[j, 2] * b[2])
    down = steep = 0.0
    for i in range(6):
        along[i] = slope[i, 0] * N[0] + slope[i, 1] * N[1] + slope[i, 2] * N[2]
        left = y[i]
        for j in range(3):
            left += over_noise[j, i] * noise[i] * N[j]
            moved[j] += over_noise[j, i] * along[i]
        down += left * along[i] / noise[i]
        steep += along[i] * along[i] / noise[i]
    for j in range(3):
        for k in range(3):
            steep -= moved[j] * inverse[j, k] * moved[k]
    return -down / steep if steep > 0.0 else 0.0


@compiled
def unexplained(y: np.ndarray, weight: float, noise: np.ndarray, lever: float) -> float:
    """
    Return the log likelihood of a wrench under no model, or of a couple alone.

    A peg in a hole that nothing pushes carries a couple beside its weight, and no force.

    Parameters
    ----------
    y : ndarray, shape (6,)
        As measured [N], [N m].
    weight : float
        [N].
    noise : ndarray, shape (6,)
    lever : float
        Of torques [m].

    """
    force = hypot(hypot(y[0], y[1]), y[2])
    torque = hypot(hypot(y[3], y[4]), y[5]) / (WRENCH_BALANCE.anything * lever)
    # As likely as noise makes it where the force is that of the weight, measured or taken off,
    # whatever its direction.
    over = min(fabs(force - weight), force)
    couple = -0.5 * over * over / noise[0] - 1.5 * (log(noise[0]) + LOG_TWO_PI)
    # Torques far beyond what such forces have on such a lever are of another unit.
    beyond = log(WRENCH_BALANCE.anything * lever) + log(1.0 + torque * torque)
    return max(-3.0 * log(max(WRENCH_BALANCE.anything, force)), couple) - 3.0 * beyond
