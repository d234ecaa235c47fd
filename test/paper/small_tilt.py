"""
Close to gamma0: the stages of alignment (29) and the small-angle expressions (30)-(39), corrected.

Each function keeps the leading order in gamma and says what it leaves out; the exact forms are in
`geometry`, `velocities` and `reference`. The expressions as printed are in `printed`.
"""

from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.checks import require_finite
from peg_on_hole_ros.mechanics.geometry import contact_geometry_above
from peg_on_hole_ros.mechanics.scene import Scene


class Stage(Enum):
    """The four stages of alignment by e = gamma - gamma0."""

    SMALL = "i: e << gamma0 << 1"
    MEDIUM = "ii: e ~ gamma0 << 1"
    LARGER = "iii: gamma0 << e << 1"
    LARGE = "iv: e ~ 1"


class SmallTiltReactions(NamedTuple):
    """
    Reactions under a pure couple with constant rates, to leading order in gamma [N].

    Attributes
    ----------
    K : ndarray
    B_sum, B_difference : ndarray
        N_B1 + N_B2, and N_B1 - N_B2, which grows as 1/b towards gamma0 when the peg slips.

    """

    K: np.ndarray
    B_sum: np.ndarray
    B_difference: np.ndarray


def stage(scene: Scene, excess: float | np.ndarray) -> Stage:
    """
    Return the stage of alignment; "much less" is a factor of 10, and 1 starts at 0.3 rad.

    Source: eq. (29) and the text below it.

    """
    e = _positive(excess)
    if e >= 0.3:
        return Stage.LARGE
    if e < scene.gamma0 / 10:
        return Stage.SMALL
    return Stage.MEDIUM if e <= 10 * scene.gamma0 else Stage.LARGER


def axis_offset(scene: Scene, excess: float | np.ndarray, stage: Stage) -> np.ndarray:
    """
    Return a1 [m] by a stage's expression.

    Parameters
    ----------
    scene : Scene
    excess : float or ndarray
        e = gamma - gamma0 [rad].
    stage : Stage
        (i) D e/2; (ii) D e (2 gamma0 + e)/(4 (gamma0 + e)); (iii) D e/4; (iv) exact.

    Source: eq. (29), corrected.

    """
    e, D, gamma0 = np.asarray(excess, float)[()], scene.hole_diameter, scene.gamma0
    if stage is Stage.SMALL:
        return D * e / 2
    if stage is Stage.MEDIUM:
        return D * e * (2 * gamma0 + e) / (4 * (gamma0 + e))
    if stage is Stage.LARGER:
        return D * e / 4
    return contact_geometry_above(scene, e).a1


def geometry_at_gamma0(scene: Scene) -> dict[str, float]:
    """
    Return the lengths [m] at gamma0 to leading order in gamma0.

    Left out: terms smaller by gamma0 (z_c'' also by gamma0 H_c/D).

    Source: eq. (30), corrected in the signs of ddh_c and ddz_c.

    """
    D, H_c = scene.hole_diameter, scene.mass_center_height
    return {
        "a1": 0.0,
        "a2": 0.0,
        "S1": D / 2,
        "S2": D / 2,
        "b": 0.0,
        "h_c": 0.0,
        "dh_c": -H_c,
        "dz_c": D / 2,
        "ddh_c": D / 2,
        "ddz_c": -D / scene.gamma0,
    }


def velocities(scene: Scene, psi: float | np.ndarray, rates: ArrayLike) -> np.ndarray:
    """
    Return the velocities at K and at the merged B in hole axes, to leading order.

    Left out: terms of the order of gamma and of b.

    Parameters
    ----------
    scene : Scene
    psi : float or ndarray
        [rad].
    rates : array_like, shape (3, ...)
        [rad/s].

    Returns
    -------
    ndarray, shape (2, 3, ...)
        [K or B, component] [m/s].

    Source: eqs. (32)-(35), gamma' = +dgamma/dt.

    """
    dgamma, dpsi, dphi = np.asarray(rates, float)
    s, c = np.sin(psi), np.cos(psi)
    turn, D = dpsi + dphi, scene.hole_diameter
    around = np.array([D / 2 * s * turn, -D / 2 * c * turn, 0 * s * turn])
    rise = np.array([0 * s * turn, 0 * s * turn, D * dgamma + 0 * s * turn])
    return np.array([around, -around + rise])


def speeds(scene: Scene, rates: ArrayLike) -> np.ndarray:
    """Return V_K and V_B, shape (2, ...) [m/s]. Source: eq. (36), with the modulus."""
    dgamma, dpsi, dphi = np.asarray(rates, float)
    D, turn = scene.hole_diameter, dpsi + dphi
    return np.array([D / 2 * np.abs(turn), D / 2 * np.sqrt((2 * dgamma) ** 2 + turn**2)])


def reactions(scene: Scene, excess: float | np.ndarray, rates: ArrayLike) -> SmallTiltReactions:
    """
    Return the reactions of imposed uniform motion under a pure couple, to leading order.

    Parameters
    ----------
    scene : Scene
        Gravity must be along -z.
    excess : float or ndarray
        e = gamma - gamma0 [rad], above 0 and well under 1.
    rates : array_like, shape (3, ...)
        [rad/s], constant in time.

    Returns
    -------
    SmallTiltReactions

    Notes
    -----
    Unlike (39), the friction at K keeps its direction along the peg's axis as its speed goes to
    zero with a1. The limit is therefore not uniform: for a pure alignment it is
    m g / (sin(gamma0) (1 + f^2)) for every e > 0 (closing), and another value at e = 0, where K
    stands still.

    Left out: terms smaller by gamma0, and by excess/gamma0^2 (the reactions are as large as
    1/gamma0, and sin(gamma) grows with the excess).

    Source: eqs. (37)-(39), corrected.

    """
    if scene.gravity[0] or scene.gravity[1]:
        raise PegOnHoleError(
            f"gravity = {scene.gravity} m/s^2 is not along -z: the small-angle formula is for a "
            "vertical hole; use reference.six_equations"
        )
    dgamma, dpsi, dphi = require_finite("rates", "rad/s", rates, 3)
    D, m, f, H_c = scene.hole_diameter, scene.peg_mass, scene.friction, scene.mass_center_height
    g = contact_geometry_above(scene, excess)
    turn = dpsi + dphi
    along = 2 * g.a1 * dgamma / g.s
    speed_K = np.sqrt(along**2 + (D / 2 * turn) ** 2)
    _, speed_B = speeds(scene, rates)
    speed_K = np.where(speed_K == 0, 1, speed_K)
    speed_B = np.where(speed_B == 0, 1, speed_B)
    # Directions of sliding: at K along -zeta (gamma' > 0) and -e, at B up (gamma' > 0) and e.
    K_axial, K_e = along / speed_K, -D / 2 * turn / speed_K
    B_z, B_e = D * dgamma / speed_B, D / 2 * turn / speed_B
    weight = -m * scene.gravity[2]
    lift = weight + m * (-D / scene.gamma0 - H_c) * dgamma**2
    sideways = m * D / 2 * dgamma**2
    # h: N_K (c - f K_axial s) - N_S = sideways; z: N_K (s + f K_axial c) - f B_z N_S = lift.
    per_K = g.c - f * K_axial * g.s
    K = (lift - f * B_z * sideways) / (g.s + f * K_axial * g.c - f * B_z * per_K)
    B_sum = per_K * K - sideways
    # e: (N_B1 - N_B2) 2 b/D - f K_e N_K - f B_e N_S = -2 m H_c gamma' psi'.
    e_force = -2 * m * H_c * dgamma * dpsi + f * (K_e * K + B_e * B_sum)
    return SmallTiltReactions(K, B_sum, e_force * D / (2 * g.b))


def _positive(excess):
    if not np.isfinite(excess) or excess <= 0:
        raise PegOnHoleError(
            f"gamma - gamma0 = {excess:g} rad is not above 0 rad: three-point contact is there"
        )
    return float(excess)
