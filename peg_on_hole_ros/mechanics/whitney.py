"""
Whitney's quasi-static jamming of a peg in two-point contact.

D. E. Whitney, Quasi-static assembly of compliantly supported rigid parts, ASME J. Dyn. Syst. Meas.
Control 104 (1982) 65-77. Planar, no inertia, the tilt small against friction's angle; radius r,
length l of peg in the hole, friction mu, lambda = l/(2 r mu). F_x, F_z, M act at the centre of the
peg's lower end, F_z > 0 into the hole. Inside a parallelogram of F_x/F_z and M/(r F_z) a load
inserts the peg.
"""

from peg_on_hole_ros.mechanics.kernel import compiled


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
    radius, length : float
        Of the peg, and of what is in the hole, above 0 [m].
    friction : float
        Above 0.
    F_x, F_z, M : float
        [N], [N], [N m].

    Source: Whitney 1982, fig. 8 and eq. 21 to 24.

    """
    ratio = length / (2.0 * radius * friction)
    sides = F_z - friction * abs(F_x)
    couple = abs(M / radius + friction * (1.0 + ratio) * F_x) / ratio
    return min(sides, F_z - couple)
