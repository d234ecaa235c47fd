"""Small linear algebra for compiled code: Cholesky factor, whitened residual, rotations."""

from math import cos, log, sin, sqrt

from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.typed_record import Floats

_LEAST_PIVOT = 1e-300
# Sines and cosines: of gamma, of psi, of phi.
Turns = tuple[float, float, float, float, float, float]
Rotation = tuple[float, float, float, float, float, float, float, float, float]
# Where force and torque begin in a wrench.
FORCE, TORQUE = 0, 3
# A variance that a subtraction leaves below this share of what it was is rounding.
ROUNDING = 1e-15


@compiled
def factor_cholesky(S: Floats, k: int) -> None:
    """Turn a covariance (k, k), whose lower half is read, into its lower Cholesky factor."""
    for a in range(k):
        least = max(ROUNDING * S[a, a], _LEAST_PIVOT)
        for c in range(a + 1):
            t = S[a, c]
            for q in range(c):
                t -= S[a, q] * S[c, q]
            S[a, c] = sqrt(max(t, least)) if a == c else t / S[c, c]


@compiled
def whiten(factor: Floats, k: int, residual: Floats, white: Floats) -> float:
    """
    Whiten a residual (k,): solve with the lower Cholesky factor of its covariance.

    Returns the square of the length of the whitened residual, which is filled in.
    """
    square = 0.0
    for a in range(k):
        t = residual[a]
        for q in range(a):
            t -= factor[a, q] * white[q]
        white[a] = t / factor[a, a]
        square += white[a] * white[a]
    return square


@compiled
def surprise(S: Floats, k: int, residual: Floats, white: Floats) -> tuple[float, float]:
    """
    Return the terms of -2 log p(residual) but for a constant: its square, and log det S.

    S is the covariance (k, k), which becomes its factor; the whitened residual is filled in.
    """
    factor_cholesky(S, k)
    square, log_determinant = whiten(S, k, residual, white), 0.0
    for i in range(k):
        log_determinant += 2.0 * log(S[i, i])
    return square, log_determinant


@compiled
def length(values: Floats, first: int) -> float:
    """Return the length of the vector of three values from a place on."""
    x, y, z = values[first], values[first + 1], values[first + 2]
    return sqrt(x * x + y * y + z * z)


@compiled
def rotated(r: Rotation, values: Floats, first: int) -> tuple[float, float, float]:
    """Return the vector of three values from a place on, rotated by a matrix in rows."""
    x, y, z = values[first], values[first + 1], values[first + 2]
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = r
    return r00 * x + r01 * y + r02 * z, r10 * x + r11 * y + r12 * z, r20 * x + r21 * y + r22 * z


@compiled
def peg_turns(gamma: float, psi: float, phi: float) -> Turns:
    """Return sines and cosines of the angles of a peg [rad], as all rotations take them."""
    return sin(gamma), cos(gamma), sin(psi), cos(psi), sin(phi), cos(phi)


@compiled
def hez_rotation(
    s: float, c: float, sp: float, cp: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """
    Return the rotation from peg axes to (h, e, z), by sines and cosines of gamma and phi.

    Rows h, e, z; that of e has two entries, for its third is zero.
    """
    return c * cp, -c * sp, -s, sp, cp, s * cp, -s * sp, c


@compiled
def peg_rotation(turns: Turns) -> Rotation:
    """Return R_HP, the peg's axes in those of the hole, by rows: Rz(psi) Ry(-gamma) Rz(phi)."""
    s, c, sps, cps, sp, cp = turns
    return (
        cps * c * cp - sps * sp, -cps * c * sp - sps * cp, -cps * s,
        sps * c * cp + cps * sp, -sps * c * sp + cps * cp, -sps * s,
        s * cp, -s * sp, c,
    )  # fmt: skip


@compiled
def in_peg_axes(turns: Turns, vector: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return a vector of the hole's axes in those of the peg."""
    s, c, sps, cps, sp, cp = turns
    x, y, z = vector
    h, e = cps * x + sps * y, cps * y - sps * x
    across = c * h + s * z
    return cp * across + sp * e, cp * e - sp * across, c * z - s * h
