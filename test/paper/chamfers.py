"""
Which edges carry a peg with a chamfer in a hole with one: bore's and shank's, up to a tilt.

A chamfer is a cone between a cylinder and a flat face. Where bore and cone meet is the throat, a
circle of the bore's diameter; where shank and cone meet is the shoulder, a circle of the shank's.
A convex edge takes any normal between those of the two surfaces that meet there. With a sharp rim
these are the bore's, along a radius, and the plate's, along the axis: all from 0 to 90 degrees
above the radial direction. With a chamfer they end at the normal of its cone, whose elevation is
the cone's half angle: 45 degrees of a chamfer of 45 degrees. docs/mechanics.md, "Chamfers".
"""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.geometry import contact_geometry
from peg_on_hole_ros.mechanics.scene import Scene


class Elevations(NamedTuple):
    """
    How far contact normals rise from the radial direction of the circle that carries [rad].

    Attributes
    ----------
    K : float
        Of n_K above the radius of the throat. On the shank K has a smooth surface.
    B_throat : float
        Of n_B1 and n_B2 above the radius of the throat; below gamma0 B lies on the bore: 0.
    B_shoulder : float
        Of the same against the radius of the shoulder.

    """

    K: float
    B_throat: float
    B_shoulder: float


def elevations(scene: Scene, gamma: float) -> Elevations:
    """
    Return the elevations at a tilt, 0 < gamma < pi/2, on three points or on two.

    n_B1 and n_B2 point to where the axes meet: a1 above the throat's plane, a2 above that of the
    shoulder.
    """
    if gamma <= scene.gamma0:
        return Elevations(gamma, 0.0, gamma)
    g = contact_geometry(scene, gamma)
    at_throat = float(np.arctan(2 * g.a1 / scene.hole_diameter))
    return Elevations(gamma, at_throat, float(np.arctan(2 * g.a2 / scene.peg_diameter)))


def edges_carry(gamma: float, hole_angle: float, peg_angle: float) -> bool:
    """
    Return whether throat and shoulder surely carry at a tilt, as a sharp rim and edge would.

    On the throat that is exact, and below gamma0 on the shoulder. Above it the shoulder of a very
    small chamfer carries up to the elevation of B; of a wide one less, for the rim between B1 and
    B2 runs down the cone, ever steeper, up to the tilt. So the tilt holds for any width.

    Parameters
    ----------
    gamma : float
        [rad].
    hole_angle, peg_angle : float
        Half angles of the cones, from the axis [rad]; pi/2: sharp.

    """
    return gamma < min(hole_angle, peg_angle)
