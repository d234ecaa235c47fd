"""The paper's angles of a rotation, and what an error of the rotation makes of them."""

from collections.abc import Sequence
from math import atan2, copysign, cos, hypot, pi, sin, sqrt, tan

import numpy as np

from peg_on_hole_ros.measurements.tuned import ANGLE_FLOOR
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats


def angles_of(rotation: np.ndarray) -> np.ndarray:
    """
    Return gamma, psi, phi of R_HP = Rz(psi) Ry(-gamma) Rz(phi).

    Parameters
    ----------
    rotation : ndarray, shape (3, 3)
        Peg axes in hole axes.

    Returns
    -------
    ndarray, shape (3,)
        gamma in [0, pi], psi and phi in [-pi, pi] [rad].

    Notes
    -----
    gamma comes from an arctangent, as an arccosine loses half the digits near zero. psi is the
    direction in which the axis leans, of little meaning near zero and 0 where it leans nowhere;
    phi is what remains once psi is turned back, so their sum is exact for any psi.

    """
    return np.array(angles_of_rows(*map(tuple, np.asarray(rotation, float).tolist())))


@compiled
def angles_of_rows(
    x: tuple[float, float, float], y: tuple[float, float, float], z: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return what `angles_of` does, as a tuple, from the rows of the rotation."""
    lean = hypot(x[2], y[2])
    gamma = atan2(lean, z[2])
    psi = atan2(-y[2], -x[2]) if lean else 0.0
    s, c = sin(psi), cos(psi)
    return gamma, psi, atan2(c * y[0] - s * x[0], c * y[1] - s * x[1])


def angle_covariance(gamma: float, orientation_stddev: float) -> np.ndarray:
    """
    Return the covariance of (gamma, psi, phi) for an isotropic error of the orientation.

    Parameters
    ----------
    gamma : float
        [rad].
    orientation_stddev : float
        Of the rotation vector between true and measured orientation, each component [rad].

    Returns
    -------
    ndarray, shape (3, 3)
        [rad^2]; psi and phi grow like 1/sin(gamma), their sum stays.

    Notes
    -----
    A rotation by (gamma, psi, phi) errors is J = [eps, z, zeta] times them; J.T J has the cosine
    of gamma between psi and phi as its only other entry.

    """
    R = np.empty(9)
    fill_covariance(float(gamma), float(orientation_stddev), R)
    return R.reshape(3, 3)


@compiled
def fill_covariance(gamma: float, orientation_stddev: float, R: np.ndarray) -> None:
    """Fill in what `angle_covariance` returns, by rows, shape (9,)."""
    variance = orientation_stddev * orientation_stddev
    c, sine = cos(gamma), abs(sin(gamma))
    least = ANGLE_FLOOR.least_sine
    if sine < least:
        # With its cosine: the variance of the sum of psi and phi is what the two leave.
        c, sine = copysign(sqrt(1.0 - least * least), c), least
    over = variance / (sine * sine)
    R[:] = 0.0
    R[0] = variance
    R[4] = R[8] = over
    R[5] = R[7] = -c * over


def angle_errors(q: Sequence[float] | np.ndarray) -> np.ndarray:
    """
    Return the matrix from a small rotation, as a vector in hole axes, to errors of the angles.

    Parameters
    ----------
    q : sequence of 3 float
        gamma, psi, phi [rad].

    Returns
    -------
    ndarray, shape (3, 3)
        Rows gamma, psi, phi. It is the inverse of [eps, z, zeta], the axes of the three angles.

    Notes
    -----
    With h the horizontal direction of psi: eps, z + h cot(gamma), -h / sin(gamma). Where the sine
    vanishes it is held at `ANGLE_FLOOR.least_sine`; psi + phi, the difference of two large rows,
    is kept by writing the cotangent as 1/sin(gamma) - tan(gamma/2).

    """
    T = np.empty((3, 3))
    fill_angle_errors(float(q[0]), float(q[1]), T)
    return T


@compiled
def fill_angle_errors(gamma: float, psi: float, T: np.ndarray) -> None:
    """Fill in what `angle_errors` returns."""
    s, c = sin(psi), cos(psi)
    over_sine, half = 1.0 / max(sin(gamma), ANGLE_FLOOR.least_sine), tan(0.5 * gamma)
    cotangent = over_sine - half
    T[0, 0], T[0, 1], T[0, 2] = s, -c, 0.0
    T[1, 0], T[1, 1], T[1, 2] = c * cotangent, s * cotangent, 1.0
    T[2, 0], T[2, 1], T[2, 2] = -c * over_sine, -s * over_sine, 0.0


@compiled
def turn_between(q: Floats, x: Floats) -> float:
    """Return the angle of the turn from one orientation to another near it, each (3,) [rad]."""
    psi, phi = x[1] - q[1], x[2] - q[2]
    psi -= 2.0 * pi * np.round(psi / (2.0 * pi))
    phi -= 2.0 * pi * np.round(phi / (2.0 * pi))
    return turn_size(q[0], x[0] - q[0], psi, phi)


@compiled
def turn_size(gamma: float, by_gamma: float, by_psi: float, by_phi: float) -> float:
    """Return the size of a small turn, or of a rate of turning, from those of the angles."""
    s, c = sin(gamma), cos(gamma)
    return sqrt(by_gamma * by_gamma + (s * by_psi) ** 2 + (by_phi + c * by_psi) ** 2)
