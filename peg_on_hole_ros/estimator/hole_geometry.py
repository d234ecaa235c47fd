"""A peg on two points in the hole, K on the rim and B on the wall: tilt, slip, arms, depth."""

from math import cos, fabs, sin

from peg_on_hole_ros.estimator.rim_geometry import Rows
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled

# A contact from the mass centre and its derivative by the tilt: h, z each [m], [m/rad].
Arm = tuple[float, float, float, float]


@compiled
def length_by_tilt(scene: SceneScalars, gamma: float) -> float:
    """Return dl/dgamma, the length in the hole by the tilt [m/rad]. Source: T1."""
    s = sin(gamma)
    return (scene.d - scene.D * cos(gamma)) / (s * s)


@compiled
def two_point_tilt(scene: SceneScalars, gamma: float) -> float:
    """Return the tilt, kept where two points touch: below gamma0, l no longer than the peg."""
    return min(max(fabs(gamma), 0.5 * (scene.D - scene.d) / scene.H_c), scene.gamma0)


@compiled
def two_point_slip(scene: SceneScalars, gamma: float, contact: int) -> Rows:
    """
    Return the slip's components (h, e, z) by the rates at K (0) or B (1), three rows of three.

    The tilt alone determines how fast the peg goes in, by l(gamma).
    """
    s, c = sin(gamma), cos(gamma)
    way = length_by_tilt(scene, gamma)
    if contact == 0:
        return (s * way, 0.0, 0.0), (0.0, -0.5 * scene.D, -0.5 * scene.d), (-c * way, 0.0, 0.0)
    return (0.0, 0.0, 0.0), (0.0, 0.5 * scene.D, 0.5 * scene.d), (scene.D - c * way, 0.0, 0.0)


@compiled
def two_point_arms(scene: SceneScalars, gamma: float) -> tuple[Arm, Arm]:
    """
    Return K and B from the mass centre, and both by the tilt: h, z each [m], [m/rad].

    Source: T1; B lies l cos(gamma) - d sin(gamma) below the rim.
    """
    s, c = sin(gamma), cos(gamma)
    length = (scene.D - scene.d * c) / s
    deep, deeper = (
        length * c - scene.d * s,
        length_by_tilt(scene, gamma) * c - length * s - scene.d * c,
    )
    B_h, B_z = 0.5 * scene.d * c + scene.H_c * s, 0.5 * scene.d * s - scene.H_c * c
    by_h, by_z = scene.H_c * c - 0.5 * scene.d * s, 0.5 * scene.d * c + scene.H_c * s
    return (B_h - scene.D, B_z + deep, by_h, by_z + deeper), (B_h, B_z, by_h, by_z)


@compiled
def depth_at(d: float, D: float, gamma: float) -> tuple[float, float, float]:
    """
    Return how deep the lower end's centre may be on two points, with its derivatives.

    Source: T1, l cos(gamma) - d sin(gamma) / 2.

    Parameters
    ----------
    d, D : float
        Diameters [m].
    gamma : float
        Tilt, above 0 [rad].

    Returns
    -------
    depth : float
        Below the rim [m].
    by_tilt, by_diameter : float
        Its derivatives by gamma [m/rad] and by d [-].

    """
    s, c = sin(gamma), cos(gamma)
    room = D - d * c
    by_tilt = 0.5 * d * c - room - room * c * c / (s * s)
    return room * c / s - 0.5 * d * s, by_tilt, -c * c / s - 0.5 * s
