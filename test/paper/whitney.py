"""Whitney's jamming diagram, fig. 8 of his paper; `mechanics.whitney` has the margin to it."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError


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
