"""A wrench on three contacts, weighed at points in place of tangents: sigma points, particles."""

from math import exp, isfinite, log, sqrt

import numpy as np

from peg_on_hole_ros.estimator.contact_sets import three_on_rim
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.scene_at_mean import scene_at
from peg_on_hole_ros.estimator.scratch import Scratch
from peg_on_hole_ros.estimator.sigma_points import draw_sigma_points, update_by_sigma_points
from peg_on_hole_ros.estimator.state import FRICTION
from peg_on_hole_ros.estimator.tuned import PARTICLE_DRAWS, SLIP_FLOOR
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled, scene_of
from peg_on_hole_ros.mechanics.linear_algebra import factor_cholesky, whiten
from peg_on_hole_ros.typed_record import Floats


@compiled
def correct_by_sigma_points(kalman: FilterRecord, j: int, wider: float) -> tuple[float, float]:
    """
    Correct a component by a wrench at sigma points; return its log likelihood and NIS.

    Friction points against the slip of each point: what is not known of its direction is what the
    points differ by.

    Parameters
    ----------
    kalman : FilterRecord
        With reactions begun anew.
    j : int
        Number of the component.
    wider : float
        Of the variance of the wrench's noise.

    """
    state, scratch = kalman.state, kalman.scratch
    scene, w, x, P = scene_of(kalman.scene), kalman.places.reactions + 3, state.x[j], state.P[j]
    points = scratch.points
    draw_sigma_points(points, x, P, w)
    _fill_noise_at(kalman, scene, x, wider)
    for k in range(2 * w + 1):
        _fill_residual_at(kalman, scene, points.x[k])
        for a in range(6):
            points.residual[k, a] = scratch.residual[a]
    state.friction_floor[j] = 0.0
    log_likelihood, nis = update_by_sigma_points(kalman, scratch.estimated, P, w, 6)
    for a in range(w):
        x[a] += scratch.step[a]
    x[FRICTION] = max(x[FRICTION], 0.0)
    return log_likelihood, nis


@compiled
def _fill_noise_at(kalman: FilterRecord, scene: SceneScalars, x: Floats, wider: float) -> None:
    """Fill in the wrench's noise at a mean, for friction whose direction is that of the slip."""
    scratch, sharp = kalman.scratch, sqrt(SLIP_FLOOR.least_scale_square)
    for i in range(3):
        scratch.velocity_scale[i] = sharp
    _fill_residual_at(kalman, scene, x)
    at_mean = scene_at(scene, x, kalman.places, kalman.state.load)
    geo = three_on_rim.rim_forms(at_mean, x, kalman.settings.small_tilt)
    three_on_rim.fill_noise(kalman, geo)
    for a in range(6):
        for b in range(6):
            scratch.noise[a, b] *= wider


@compiled
def _fill_residual_at(kalman: FilterRecord, scene: SceneScalars, x: Floats) -> None:
    own = scene_at(scene, x, kalman.places, kalman.state.load)
    geo = three_on_rim.rim_forms(own, x, kalman.settings.small_tilt)
    three_on_rim.fill_residual(kalman, own, geo, x)


@compiled
def correct_by_particles(kalman: FilterRecord, j: int, wider: float) -> None:
    """
    Correct a component at particles: a Gaussian particle filter (Kotecha, Djuric 2003).

    Particles are drawn from what tangents have made of a wrench, a little wider, and weighed by
    its true likelihood times the prior; their mean and covariance go on. Each has its own best
    reactions, in closed form (Rao and Blackwell). None is kept: sums are. What is only considered
    counts as estimated.

    Parameters
    ----------
    kalman : FilterRecord
        Of the component, `state` is corrected by tangents, and `scratch` has it as before.
    j : int
        Number of the component.
    wider : float
        Of the variance of the wrench's noise.

    """
    state, scratch, points = kalman.state, kalman.scratch, kalman.scratch.points
    scene, n, x, P = scene_of(kalman.scene), kalman.places.reactions, state.x[j], state.P[j]
    w, point, before = n + 3, points.x[0], scratch.x[j]
    for a in range(n):
        for b in range(a + 1):
            points.root[a, b] = PARTICLE_DRAWS.wider * P[a, b]
            points.prior_root[a, b] = scratch.P[j, a, b]
    factor_cholesky(points.root, n)
    factor_cholesky(points.prior_root, n)
    _fill_noise_at(kalman, scene, x, wider)
    scratch.cholesky[:, :] = scratch.noise
    factor_cholesky(scratch.cholesky, 6)
    prior_variance: float = scratch.P[j, n, n]
    _forget_sums(scratch, w)
    total, top = 0.0, -np.inf
    np.random.seed(state.wrenches_drawn)  # noqa: NPY002
    state.wrenches_drawn += 1
    for _ in range(kalman.settings.particles):
        log_weight = _draw(kalman, j)
        for a in range(n):
            points.off[a] = point[a] - before[a]
        log_weight -= 0.5 * whiten(points.prior_root, n, points.off, points.off)
        for a in range(3):
            point[n + a] = before[n + a]
        _fill_residual_at(kalman, scene, point)
        log_weight += _solve_reactions(scratch, n, prior_variance)
        if not isfinite(log_weight):
            continue
        if log_weight > top:
            _scale_sums(scratch, w, exp(top - log_weight))
            total, top = total * exp(top - log_weight), log_weight
        weight = exp(log_weight - top)
        total += weight
        _add_to_sums(scratch, x, w, weight)
    if total > 0.0:
        _use_sums(scratch, x, P, n, total)


@compiled
def _draw(kalman: FilterRecord, j: int) -> float:
    """Draw a particle, but for its reactions; return its log density, negative, but a constant."""
    points, x, n = kalman.scratch.points, kalman.state.x[j], kalman.places.reactions
    normal, point, square = points.off, points.x[0], 0.0
    for a in range(n):
        normal[a] = np.random.standard_normal()  # noqa: NPY002
        square += normal[a] * normal[a]
    for a in range(n):
        t = x[a]
        for b in range(a + 1):
            t += points.root[a, b] * normal[b]
        point[a] = t
    point[FRICTION] = max(point[FRICTION], 0.0)
    return 0.5 * square


@compiled
def _solve_reactions(scratch: Scratch, n: int, prior_variance: float) -> float:
    """
    Add the reactions that fit best to a particle's prior ones; return its log likelihood.

    Parameters
    ----------
    scratch : Scratch
        With residual and Jacobian at the particle, and the Cholesky factor of the noise; `gram`
        becomes the root of the information on the reactions.
    n : int
        How many values stand before the reactions.
    prior_variance : float
        Of each reaction [N^2].

    """
    rows, gram, column, white = scratch.whitened, scratch.gram, scratch.step, scratch.white
    misfit = whiten(scratch.cholesky, 6, scratch.residual, white)
    told, log_root = scratch.points.best, 0.0
    for k in range(3):
        for a in range(6):
            column[a] = scratch.jacobian[a, n + k]
        whiten(scratch.cholesky, 6, column, rows[k])
        told[k] = 0.0
        for a in range(6):
            told[k] -= rows[k, a] * white[a]
        for m in range(k + 1):
            gram[k, m] = 1.0 / prior_variance if m == k else 0.0
            for a in range(6):
                gram[k, m] += rows[m, a] * rows[k, a]
    factor_cholesky(gram, 3)
    misfit -= whiten(gram, 3, told, told)
    for k in range(3):
        log_root += log(gram[k, k])
    for k in range(2, -1, -1):
        for m in range(k + 1, 3):
            told[k] -= gram[m, k] * told[m]
        told[k] /= gram[k, k]
        scratch.points.x[0, n + k] += told[k]
    return -0.5 * misfit - log_root


@compiled
def _forget_sums(scratch: Scratch, w: int) -> None:
    points = scratch.points
    points.reactions[:, :] = 0.0
    for a in range(w):
        points.total[a] = 0.0
        for b in range(w):
            points.squares[a, b] = 0.0


@compiled
def _scale_sums(scratch: Scratch, w: int, by: float) -> None:
    """Let what was summed up count less: a likelier particle has come."""
    points = scratch.points
    points.reactions *= by
    for a in range(w):
        points.total[a] *= by
        for b in range(a + 1):
            points.squares[a, b] *= by


@compiled
def _add_to_sums(scratch: Scratch, x: Floats, w: int, weight: float) -> None:
    """Add a particle with its weight."""
    points, root = scratch.points, scratch.gram
    off = points.off
    for a in range(w):
        off[a] = points.x[0, a] - x[a]
        part = weight * off[a]
        points.total[a] += part
        for b in range(a + 1):
            points.squares[a, b] += part * off[b]
    # The covariance of its reactions, by the inverse of their root.
    i00, i11, i22 = 1.0 / root[0, 0], 1.0 / root[1, 1], 1.0 / root[2, 2]
    i10 = -root[1, 0] * i00 * i11
    i21 = -root[2, 1] * i11 * i22
    i20 = -(root[2, 0] * i00 + root[2, 1] * i10) * i22
    spread = points.reactions
    spread[0, 0] += weight * (i00 * i00 + i10 * i10 + i20 * i20)
    spread[1, 0] += weight * (i10 * i11 + i20 * i21)
    spread[1, 1] += weight * (i11 * i11 + i21 * i21)
    spread[2, 0] += weight * i20 * i22
    spread[2, 1] += weight * i21 * i22
    spread[2, 2] += weight * i22 * i22


@compiled
def _use_sums(scratch: Scratch, x: Floats, P: Floats, n: int, total: float) -> None:
    """Turn the sums into mean and covariance of a component, in place of the tangents'."""
    points, w = scratch.points, n + 3
    for a in range(w):
        points.total[a] /= total
    for a in range(w):
        for b in range(a + 1):
            t = points.squares[a, b] / total - points.total[a] * points.total[b]
            if b >= n:
                t += points.reactions[a - n, b - n] / total
            P[a, b] = t
            P[b, a] = t
    for a in range(w):
        x[a] += points.total[a]
