"""How a peg slips at the three contacts on the rim."""

from math import sqrt

from peg_on_hole_ros.mechanics.geometry import ClosedForms
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled

# Rows h, e, z of three: derivatives of a slip velocity by the rates of gamma, psi, phi [m/rad].
Rows = tuple[
    tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]
]  # fmt: skip


@compiled
def rim_slip(scene: SceneScalars, geo: ClosedForms, contact: int) -> Rows:
    """
    Return the slip's components by the rates at a contact, three rows of three.

    Parameters
    ----------
    scene : SceneScalars
    geo : ClosedForms
    contact : int
        0, 1, 2 for K, B1, B2.

    """
    s, c, a1, S1, S2, b = geo.s, geo.c, geo.a1, geo.S1, geo.S2, geo.b
    if contact == 0:
        return (
            (2.0 * a1, 0.0, 0.0),
            (0.0, -0.5 * scene.D, -0.5 * scene.d),
            (-2.0 * a1 * c / s, 0.0, 0.0),
        )
    e = b if contact == 1 else -b
    return (2.0 * a1, e, e * c), (0.0, S1, S2), (2.0 * S1, 0.0, e * s)


@compiled
def rim_normal(geo: ClosedForms, contact: int) -> tuple[float, float, float]:
    """Return the direction (h, e, z) in which a contact pushes the peg; parameters as above."""
    a1, S1, b = geo.a1, geo.S1, geo.b
    over = 1.0 / sqrt(S1 * S1 + b * b + a1 * a1)
    if contact == 0:
        return geo.c, 0.0, geo.s
    return -S1 * over, (b if contact == 1 else -b) * over, a1 * over
