"""What an orientation does to the state: gate, jumps of the motion, and correction."""

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.mixture import reweigh
from peg_on_hole_ros.estimator.motion import add_process_noise
from peg_on_hole_ros.estimator.orientation import (
    fill_orientation_jacobian,
    fill_orientation_residual,
)
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.estimator.sigma_points import draw_sigma_points, update_by_sigma_points
from peg_on_hole_ros.estimator.state import FRICTION, State
from peg_on_hole_ros.estimator.tuned import STILL_TURN
from peg_on_hole_ros.estimator.update import copy_component, update
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.linear_algebra import factor_cholesky, whiten
from peg_on_hole_ros.typed_record import Floats


@compiled
def pass_time(state: State, dt: float) -> None:
    """Count a time that has been predicted [s]."""
    state.time_since_start += dt
    state.time_since_wrench += dt
    state.time_since_orientation += dt
    state.time_since_jump += dt


@compiled
def release_still_turns(kalman: FilterRecord) -> None:
    """Make an angle that does not move as wide as an orientation needs, to put it anywhere."""
    state, settings = kalman.state, kalman.settings
    for i, moves in ((1, settings.psi_moves), (2, settings.phi_moves)):
        if moves > 0.0:
            continue
        _release(state.mixture_covariance, i, state.width)
        for j in range(state.components):
            _release(state.P[j], i, state.width)


@compiled
def _release(P: Floats, place: int, w: int) -> None:
    for j in range(w):
        P[place, j] = 0.0
        P[j, place] = 0.0
    P[place, place] = STILL_TURN.stddev * STILL_TURN.stddev


@compiled
def orientation_nis(kalman: FilterRecord, q: Floats, R: Floats) -> float:
    """
    Return the normalised innovation squared of an orientation; nothing is corrected.

    The whitened innovation is left in the state.
    """
    state = kalman.state
    state.nis_orientation = _innovation(
        kalman, state.mixture_mean, state.mixture_covariance, q, R, state.innovation
    )
    return state.nis_orientation


@compiled
def note_departure(kalman: FilterRecord, R: Floats) -> bool:
    """
    Keep how far off a refused orientation is; return whether it is farther than the one before.

    Returns whether it is further off than the one noted before, and the same way: one motion makes
    that of both, while outliers do not agree.
    """
    state, factor, now = kalman.state, R.copy(), kalman.scratch.white
    factor_cholesky(factor, 3)
    whiten(factor, 3, kalman.scratch.residual, now)
    grown = 0.0
    for i in range(3):
        grown += (now[i] - state.refused_innovation[i]) * state.refused_innovation[i]
        state.refused_innovation[i] = now[i]
    return grown >= 0.0


@compiled
def jump_to(kalman: FilterRecord, q: Floats, R: Floats, most: float) -> bool:
    """
    Widen the motion as by the top mode since the last orientation, if that explains one.

    Wrenches in between have taken a lower mode for granted, and closed the top one. What departs
    more often than the top mode comes is no jump: something is stated wrongly.

    Parameters
    ----------
    kalman : FilterRecord
        Every component is widened, where the motion jumps.
    q : ndarray, shape (3,)
        The orientation [rad].
    R : ndarray, shape (3, 3)
        Its covariance [rad^2].
    most : float
        Normalised innovation squared up to which the orientation is explained.

    """
    state, scratch, settings = kalman.state, kalman.scratch, kalman.settings
    top, x, P = settings.modes - 1, scratch.x[0], scratch.P[0]
    if settings.mode_rate[top] == 0.0 or jumped_lately(state, settings):
        return False
    copy_component(x, P, state.mixture_mean, state.mixture_covariance, state.width)
    dt = state.time_since_orientation
    add_process_noise(x, P, settings, top, dt)
    if _innovation(kalman, x, P, q, R, scratch.white) > most:
        return False
    for j in range(state.components):
        if state.alive[j // settings.modes] > 0.0:
            add_process_noise(state.x[j], state.P[j], settings, top, dt)
    state.time_since_jump = 0.0
    return True


@compiled
def jumped_lately(state: State, settings: Settings) -> bool:
    """Return whether the motion has jumped within the time in which the top mode comes once."""
    often: float = settings.mode_rate[settings.modes - 1]
    return often > 0.0 and state.time_since_jump * often < 1.0


@compiled
def _innovation(
    kalman: FilterRecord, x: Floats, P: Floats, q: Floats, R: Floats, white: Floats
) -> float:
    """Fill in the whitened innovation of an orientation at a mean; return its square."""
    scratch, places, w = kalman.scratch, kalman.places, kalman.state.width
    E, factor = scratch.jacobian, scratch.cholesky
    fill_orientation_jacobian(x, places, w, E)
    fill_orientation_residual(x, places, q, E, scratch.residual)
    for i in range(3):
        for k in range(w):
            t = 0.0
            for l in range(w):
                t += E[i, l] * P[l, k]
            scratch.gain[i, k] = t
        for k in range(i + 1):
            v = kalman.state.noise_ratio * R[i, k]
            for l in range(w):
                v += scratch.gain[i, l] * E[k, l]
            factor[i, k] = v
    factor_cholesky(factor, 3)
    return whiten(factor, 3, scratch.residual, white)


@compiled
def update_from_orientation(kalman: FilterRecord, q: Floats, R: Floats) -> None:
    """
    Correct every component by an orientation q [rad] with covariance R [rad^2].

    A tilt of the hole is considered unless three contacts carry the peg: orientations alone
    contain nothing of it. Their Jacobian changes with the noise of the estimate, and each change
    would count as information: of a peg that hangs still, the tilt would drift by milliradians.
    """
    state, scratch, places = kalman.state, kalman.scratch, kalman.places
    modes, n = kalman.settings.modes, places.reactions
    state.time_since_orientation = 0.0
    for i in range(n):
        scratch.estimated[i] = kalman.estimated[i]
    if places.tilt >= 0 and state.contact_set != ContactSet.THREE:
        scratch.estimated[places.tilt] = scratch.estimated[places.tilt + 1] = 0.0
    for i in range(3):
        for k in range(3):
            scratch.noise[i, k] = state.noise_ratio * R[i, k]
    for j in range(state.components):
        scratch.log_likelihood[j] = 0.0
        if state.alive[j // modes] == 0.0:
            continue
        x, P, least = state.x[j], state.P[j], state.friction_floor[j]
        if kalman.settings.sigma_points > 0.0:
            scratch.log_likelihood[j] = _update_by_points(kalman, j, q)
        else:
            fill_orientation_jacobian(x, places, n, scratch.jacobian)
            fill_orientation_residual(x, places, q, scratch.jacobian, scratch.residual)
            scratch.log_likelihood[j], _ = update(kalman, scratch.estimated, P, n, 3, least)
        for i in range(n):
            x[i] += scratch.step[i]
        x[FRICTION] = max(x[FRICTION], 0.0)
    reweigh(kalman)


@compiled
def _update_by_points(kalman: FilterRecord, j: int, q: Floats) -> float:
    """Update the covariance of a component by an orientation at sigma points; see `update`."""
    state, scratch, places = kalman.state, kalman.scratch, kalman.places
    n, points = places.reactions, scratch.points
    draw_sigma_points(points, state.x[j], state.P[j], n)
    for k in range(2 * n + 1):
        x = points.x[k]
        fill_orientation_jacobian(x, places, n, scratch.jacobian)
        fill_orientation_residual(x, places, q, scratch.jacobian, scratch.residual)
        for i in range(3):
            points.residual[k, i] = -scratch.residual[i]
    likelihood, _ = update_by_sigma_points(kalman, scratch.estimated, state.P[j], n, 3)
    return likelihood
