"""Where friction makes the six equations singular: all critical coefficients, and their onset."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.checks import require_finite
from peg_on_hole_ros.mechanics.reference import friction_cubic
from peg_on_hole_ros.mechanics.scene import Scene


class Wedging(NamedTuple):
    """
    How far a state is from where rigid motion ends.

    Attributes
    ----------
    determinant : float
        Of the reactions' matrix over its frictionless value: 1 without friction, 0 where rigid
        motion ends, negative beyond.
    roots : tuple of float
        All friction coefficients above 0 at which the determinant vanishes, ascending; none to
        three. A double root is listed twice.
    discriminant : float
        Of the cubic; negative: one real root. Where it turns positive, a pair of roots appears at
        once, away from all others: the smallest root then jumps, and is no early warning.

    """

    determinant: float
    roots: tuple[float, ...]
    discriminant: float


def wedging(scene: Scene, q, rates, slip_velocity_scale=0.0) -> Wedging:
    """
    Return determinant and critical friction coefficients of a state.

    Parameters
    ----------
    scene : Scene
    q, rates : array_like, shape (3,)
        gamma, psi, phi [rad] and their rates [rad/s]. Only the direction of the rates matters
        under Coulomb's law.
    slip_velocity_scale : float
        Of the regularised friction law [m/s].

    Returns
    -------
    Wedging

    Source: L5, L6.

    """
    q = require_finite("state", "rad", q, 3)
    rates = require_finite("rates", "rad/s", rates, 3)
    cubic = friction_cubic(scene, q, rates, slip_velocity_scale)
    determinant = float(np.polyval(cubic[::-1], scene.friction))
    return Wedging(determinant, critical_frictions(cubic), discriminant(cubic))


def critical_frictions(cubic) -> tuple[float, ...]:
    """
    Return all positive real roots of the determinant's cubic, ascending.

    Parameters
    ----------
    cubic : array_like, shape (4,)
        From `reference.friction_cubic`: coefficients of f^0 .. f^3.

    Returns
    -------
    tuple of float

    Raises
    ------
    PegOnHoleError
        Where a coefficient is not finite.

    """
    cubic = np.asarray(cubic, float)
    if cubic.shape != (4,) or not np.all(np.isfinite(cubic)):
        raise PegOnHoleError(f"cubic = {cubic} is not four finite coefficients of f^0 .. f^3")
    # Coefficients that are rounding beside the others would give roots near infinity.
    high = np.where(np.abs(cubic) < 1e-12 * np.max(np.abs(cubic)), 0, cubic)[::-1]
    roots = np.roots(np.trim_zeros(high, "f"))
    # A double root comes out of the eigenvalues with an imaginary part of about sqrt(1e-16).
    real = roots.real[(np.abs(roots.imag) < 1e-7 * np.abs(roots)) & (roots.real > 0)]
    return tuple(float(x) for x in np.sort(real))


def discriminant(cubic) -> float:
    """Return the discriminant of the determinant's cubic; its sign tells 1 or 3 real roots."""
    d, c, b, a = np.asarray(cubic, float)
    return float(
        18 * a * b * c * d - 4 * b**3 * d + (b * c) ** 2 - 4 * a * c**3 - 27 * (a * d) ** 2
    )
