"""
Whitney's quasi-static jamming and wedging of a peg in two-point contact.

D. E. Whitney, Quasi-static assembly of compliantly supported rigid parts, ASME J. Dyn. Syst. Meas.
Control 104 (1982) 65-77. Planar, no inertia, the tilt small against friction's angle; radius r,
length l of peg in the hole, friction mu, lambda = l/(2 r mu). F_x, F_z, M act at the centre of the
peg's lower end, F_z > 0 into the hole.
"""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.kernel import compiled


class JammingDiagram(NamedTuple):
    """
    The parallelogram inside of which a load inserts the peg.

    Attributes
    ----------
    vertices : ndarray, shape (4, 2)
        F_x/F_z and M/(r F_z), counter-clockwise from the upper left.
    ratio : float
        lambda = l/(2 r mu).
    can_wedge : bool
        lambda < 1, that is l < 2 r mu: both friction cones hold the other contact, and forces of
        any size can be locked between the two.

    """

    vertices: np.ndarray
    ratio: float
    can_wedge: bool


def jamming_diagram(radius: float, length: float, friction: float) -> JammingDiagram:
    """
    Return Whitney's jamming diagram.

    Parameters
    ----------
    radius, length : float
        Of the peg, and of what is in the hole, above 0 [m].
    friction : float
        Above 0; without friction nothing jams, and the parallelogram is endless.

    Raises
    ------
    PegOnHoleError
        A value that is not above 0.

    Source: Whitney 1982, fig. 8 and eq. 21 to 24.

    """
    for name, value in (("radius", radius), ("length", length), ("friction", friction)):
        if not value > 0 or not np.isfinite(value):
            raise PegOnHoleError(
                f"{name} = {value:g} has no jamming diagram: it must be above 0 and finite"
            )
    ratio = length / (2 * radius * friction)
    across = 1 / friction
    high, low = 1 + 2 * ratio, 1.0
    vertices = [[-across, high], [-across, low], [across, -high], [across, -low]]
    return JammingDiagram(np.array(vertices), ratio, bool(ratio < 1))


@compiled
def jamming_margin(
    radius: float, length: float, friction: float, F_x: float, F_z: float, M: float
) -> float:
    """
    Return the push that is left beyond what keeps the peg, as a force along the hole [N].

    The smallest of F_z - friction |F_x| and of F_z - |M/r + mu (1 + lambda) F_x| / lambda: both
    are above 0 inside the parallelogram, 0 on its edges, and need no F_z to divide by.

    Parameters
    ----------
    radius, length, friction : float
        As for `jamming_diagram`.
    F_x, F_z, M : float
        [N], [N], [N m].

    """
    ratio = length / (2.0 * radius * friction)
    sides = F_z - friction * abs(F_x)
    couple = abs(M / radius + friction * (1.0 + ratio) * F_x) / ratio
    return min(sides, F_z - couple)
