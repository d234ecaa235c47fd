"""A measured insertion depth as a measurement of the clearance, on two points in the hole."""

from math import sqrt

from peg_on_hole_ros.estimator.contact_sets.registry import is_in_hole
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.hole_geometry import depth_at
from peg_on_hole_ros.estimator.mixture import reweigh
from peg_on_hole_ros.estimator.scene_at_mean import fill_clearance_jacobian, scene_at
from peg_on_hole_ros.estimator.update import update
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled, scene_of


@compiled
def update_from_depth(kalman: FilterRecord, depth: float, variance: float, since: float) -> bool:
    """
    Correct every component by a measured depth, where two points certainly carry; return if so.

    Parameters
    ----------
    kalman : FilterRecord
        A combination of the mixture is left to do.
    depth, variance : float
        Of the lower end's centre below the rim [m], and of the place that it is known by [m^2].
    since : float
        After the depth before [s].

    """
    state, settings, scratch = kalman.state, kalman.settings, kalman.scratch
    n = kalman.places.reactions
    if kalman.places.clearance < 0 or not is_in_hole(state.contact_set):
        return False
    if not 0.0 < since < settings.place_time or not _carries(kalman):
        return False
    scene = scene_of(kalman.scene)
    for j in range(state.components):
        scratch.log_likelihood[j] = 0.0
        if state.alive[j // settings.modes] == 0.0 or state.x[j, 0] <= 0.0:
            continue
        if not _linearise_depth(kalman, scene, j, depth, variance):
            continue
        scratch.noise[0, 0] = variance * settings.place_time / since
        update(kalman, kalman.estimated, state.P[j], n, 1, state.friction_floor[j])
        for i in range(n):
            state.x[j, i] += scratch.step[i]
    reweigh(kalman)
    return True


@compiled
def _carries(kalman: FilterRecord) -> bool:
    """Return whether tilt and reactions are significantly above zero."""
    C, mean, n = (
        kalman.state.mixture_covariance,
        kalman.state.mixture_mean,
        kalman.places.reactions,
    )
    sigmas = kalman.settings.significance
    two = mean[n + 1] + mean[n + 2]
    spread = C[n + 1, n + 1] + C[n + 2, n + 2] + 2.0 * C[n + 1, n + 2]
    carries: bool = (
        mean[0] > sigmas * sqrt(max(C[0, 0], 0.0))
        and mean[n] > sigmas * sqrt(max(C[n, n], 0.0))
        and two > sigmas * sqrt(max(spread, 0.0))
    )
    return carries


@compiled
def _linearise_depth(
    kalman: FilterRecord, scene: SceneScalars, j: int, depth: float, variance: float
) -> bool:
    """Linearise the depth at a component; return whether it is plausible there."""
    state, places, scratch = kalman.state, kalman.places, kalman.scratch
    E, x, P = scratch.jacobian, state.x[j], state.P[j]
    q = scene_at(scene, x, places, -state.load)
    expected, by_tilt, by_diameter = depth_at(q.d, q.D, x[0])
    scratch.residual[0] = depth - expected
    for i in range(places.reactions):
        E[0, i] = 0.0
    E[0, 0] = by_tilt
    fill_clearance_jacobian(q, x, places, -state.load, by_diameter, E[0])
    off = by_tilt * by_tilt * P[0, 0] + variance
    by_clearance = E[0, places.clearance]
    off += by_clearance * by_clearance * P[places.clearance, places.clearance]
    square: float = scratch.residual[0] * scratch.residual[0]
    return not square > kalman.settings.outlier * off
