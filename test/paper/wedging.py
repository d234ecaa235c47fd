"""How near a state is to where friction makes the six equations singular."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.mechanics.checks import require_finite
from peg_on_hole_ros.mechanics.reference import critical_frictions, friction_cubic
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


def wedging(
    scene: Scene, q: ArrayLike, rates: ArrayLike, slip_velocity_scale: float = 0.0
) -> Wedging:
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


def discriminant(cubic: np.ndarray) -> float:
    """Return the discriminant of the determinant's cubic; its sign tells 1 or 3 real roots."""
    d, c, b, a = np.asarray(cubic, float)
    return float(
        18 * a * b * c * d - 4 * b**3 * d + (b * c) ** 2 - 4 * a * c**3 - 27 * (a * d) ** 2
    )
