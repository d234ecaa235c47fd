"""The scene at a mean: clearance, compliance and the hole's tilt as they are estimated."""

from math import atan2, exp, sqrt

from peg_on_hole_ros.estimator.state import StatePlaces
from peg_on_hole_ros.estimator.tuned import SCENE_AT_MEAN_BOUNDS
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled
from peg_on_hole_ros.typed_record import Floats


@compiled
def within_closed_forms(scene: SceneScalars, gamma: float) -> float:
    """Return the tilt, kept where the closed forms of three contacts exist [rad]."""
    bounds = SCENE_AT_MEAN_BOUNDS
    return min(max(gamma, scene.gamma0 + bounds.nearest_tilt), bounds.steepest_tilt)


@compiled
def scene_at(scene: SceneScalars, x: Floats, places: StatePlaces, load: float) -> SceneScalars:
    """Return the scene with the clearance of a mean: as estimated, less the give under load."""
    if places.clearance < 0 and places.compliance < 0:
        return scene
    clearance = scene.D - scene.d
    if places.clearance >= 0:
        most_log = SCENE_AT_MEAN_BOUNDS.most_log_clearance
        clearance *= exp(min(max(x[places.clearance], -most_log), most_log))
    if places.compliance >= 0:
        left = max(clearance - x[places.compliance] * load, SCENE_AT_MEAN_BOUNDS.least_clearance)
        # A load that no peg carries must not open the hole.
        clearance = min(left, clearance * exp(SCENE_AT_MEAN_BOUNDS.most_log_clearance))
    d = scene.D - clearance
    gamma0 = atan2(sqrt(clearance * (scene.D + d)), d)
    return SceneScalars(
        d,
        scene.D,
        scene.H_c,
        gamma0,
        scene.m,
        scene.Ie,
        scene.Iz,
        scene.f,
        scene.g_x,
        scene.g_y,
        scene.g_z,
    )


@compiled
def tilted_gravity(
    scene: SceneScalars, x: Floats, places: StatePlaces
) -> tuple[float, float, float]:
    """Return gravity in the axes of the hole at its estimated tilt [m/s^2], three values."""
    if places.tilt < 0:
        return scene.g_x, scene.g_y, scene.g_z
    t_x, t_y = x[places.tilt], x[places.tilt + 1]
    return (
        scene.g_x - t_y * scene.g_z,
        scene.g_y + t_x * scene.g_z,
        scene.g_z + t_y * scene.g_x - t_x * scene.g_y,
    )


@compiled
def fill_clearance_jacobian(
    scene: SceneScalars,
    x: Floats,
    places: StatePlaces,
    load: float,
    by_diameter: float,
    row: Floats,
) -> None:
    """
    Add the derivatives by clearance and compliance to a row of a Jacobian.

    Parameters
    ----------
    scene : SceneScalars
        The scene at the mean.
    x : ndarray
        The mean.
    places : StatePlaces
    load : float
        [N].
    by_diameter : float
        Derivative by the peg's diameter.
    row : ndarray
        Changed.

    """
    if places.clearance >= 0:
        # To the diameter, of which the clearance is what is left.
        grown = (scene.D - scene.d) + (
            x[places.compliance] * load if places.compliance >= 0 else 0.0
        )
        row[places.clearance] -= by_diameter * grown
    if places.compliance >= 0:
        row[places.compliance] += by_diameter * load
