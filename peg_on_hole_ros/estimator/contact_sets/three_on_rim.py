"""Three contacts on the rim, K, B1 and B2: the six equations as a measurement of the wrench."""

from math import cos, sin

from peg_on_hole_ros.estimator.applied_wrench import (
    add_turn,
    applied_wrench,
    fill_wrench_noise,
    put_column,
    six_of,
    subtract_applied_jacobian,
)
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.friction_direction import (
    fill_direction_noise,
    friction_direction_statistics,
)
from peg_on_hole_ros.estimator.scene_at_mean import (
    fill_clearance_jacobian,
    scene_at,
    within_closed_forms,
)
from peg_on_hole_ros.estimator.scratch import Scratch
from peg_on_hole_ros.estimator.state import ACCELERATION, FRICTION, RATE
from peg_on_hole_ros.estimator.update import reset_three
from peg_on_hole_ros.mechanics.geometry import ClosedForms
from peg_on_hole_ros.mechanics.kernel import (
    BY_FRICTION,
    BY_GAMMA,
    BY_PEG_DIAMETER,
    BY_RATES,
    DERIVATIVES_AT,
    G_AT,
    R_AT,
    SceneScalars,
    Wrench,
    closed_forms,
    compiled,
    derivatives,
    equations,
    small_forms,
    with_friction,
)
from peg_on_hole_ros.typed_record import Floats

# Accelerations and reactions.
Solution = tuple[float, float, float, float, float, float]
SOLVED_REACTIONS = 3  # N_K, N_B1, N_B2
WRENCH_MAY_DRIVE = True
IN_HOLE = False


@compiled
def begin_reactions(x: Floats, P: Floats, first: int, variance: float) -> None:
    """Give each reaction its prior variance [N^2], about what it was."""
    reset_three(P, first, first + 3, variance)


@compiled
def linearise(
    kalman: FilterRecord, scene: SceneScalars, x: Floats, P: Floats, mode_stddev: float
) -> float:
    """
    Linearise the six equations at the mean of a component.

    Parameters
    ----------
    kalman : FilterRecord
        With the wrench and its noise; of `scratch` are filled: residual, jacobian, noise,
        direction_noise, by_friction and by_diameter.
    scene : SceneScalars
        The scene as stated.
    x, P : ndarray
        Mean and covariance of the component.
    mode_stddev : float
        Not used: accelerations are values that are estimated.

    Returns
    -------
    turned : float
        See `direction.friction_direction_statistics`.

    """
    state, settings, places, scratch = (
        kalman.state, kalman.settings, kalman.places, kalman.scratch,
    )  # fmt: skip
    n, load, inertia = places.reactions, state.load, settings.inertia
    scene = scene_at(scene, x, places, load)
    work, E = scratch.work, scratch.jacobian
    geo = rim_forms(scene, x, settings.small_tilt)
    turned = friction_direction_statistics(
        scene, geo, x, P, settings.direction_share, scratch.velocity_scale, scratch.unexplained
    )
    rates = (x[RATE], x[RATE + 1], x[RATE + 2])
    scale = scratch.velocity_scale
    scales = (scale[0], scale[1], scale[2])
    wrench = fill_residual(kalman, scene, geo, x)
    wrench = _expected_wrench(geo, wrench, scratch)
    f, f_K = x[FRICTION], x[FRICTION]
    if places.friction_k >= 0:
        f_K += x[places.friction_k]
    a = ACCELERATION
    y = (inertia * x[a], inertia * x[a + 1], inertia * x[a + 2], x[n], x[n + 1], x[n + 2])
    slopes = work[DERIVATIVES_AT : DERIVATIVES_AT + 36]
    if places.friction_k >= 0:
        _differentiate_apart(kalman, scene, geo, rates, wrench, y, (f, f_K))
    else:
        derivatives(with_friction(scene, f), scales, geo, rates, wrench, y, slopes)
    for i in range(6):
        row = 6 * i
        E[i, FRICTION] = slopes[row + BY_FRICTION]
        for j in range(3):
            E[i, RATE + j] = slopes[row + BY_RATES + j]
        E[i, 0], E[i, 1], E[i, 2] = slopes[row + BY_GAMMA], 0.0, 0.0
        scratch.by_diameter[i] = slopes[row + BY_PEG_DIAMETER]
        fill_clearance_jacobian(scene, x, places, load, scratch.by_diameter[i], E[i])
    fill_noise(kalman, geo)
    subtract_applied_jacobian(scratch, places, kalman.bias_map)
    fill_direction_noise(scene, geo, x, state.friction_force2, scratch)
    return turned


@compiled
def rim_forms(scene: SceneScalars, x: Floats, small_tilt: float) -> ClosedForms:
    """Return the geometry at a mean or at another point, or that of a small tilt."""
    gamma = within_closed_forms(scene, x[0])
    if small_tilt > 0.0:
        return small_forms(scene.d, scene.D, scene.H_c, scene.gamma0, gamma)
    return closed_forms(scene.d, scene.D, scene.H_c, scene.gamma0, gamma)


@compiled
def fill_residual(
    kalman: FilterRecord, scene: SceneScalars, geo: ClosedForms, x: Floats
) -> Wrench:
    """
    Fill in by how much the six equations do not hold, left side minus right side.

    Parameters
    ----------
    kalman : FilterRecord
        With the wrench, and of `scratch` with the `velocity_scale` of friction; filled are
        `residual`, `applied_jacobian`, and of `jacobian` the columns of accelerations and
        reactions, beside which it is zero.
    scene : SceneScalars
        The scene at the point.
    geo : ClosedForms
    x : ndarray
        The point: a component's mean, or another.

    Returns
    -------
    wrench : Wrench
        The applied one.

    """
    settings, places, scratch = kalman.settings, kalman.places, kalman.scratch
    n, work, E, residual = places.reactions, scratch.work, scratch.jacobian, scratch.residual
    s, c = geo.s, geo.c
    if settings.small_tilt > 0.0:
        # The wrench is measured, and turned as it is.
        s, c = sin(geo.s), cos(geo.s)
    wrench = applied_wrench(kalman, scene, x, s, c)
    rates = (x[RATE], x[RATE + 1], x[RATE + 2])
    scale = scratch.velocity_scale
    scales = (scale[0], scale[1], scale[2])
    for i in range(6):
        for j in range(n):
            E[i, j] = 0.0
    _fill_inertia(scene, geo, settings.inertia, E)
    f = x[FRICTION]
    if places.friction_k >= 0:
        # They are linear in each reaction.
        f_K = f + x[places.friction_k]
        equations(with_friction(scene, f_K), scales, geo, rates, wrench, work)
        for i in range(6):
            scratch.column_K[i] = work[G_AT + 3 * i]
    equations(with_friction(scene, f), scales, geo, rates, wrench, work)
    for i in range(6):
        if places.friction_k >= 0:
            work[G_AT + 3 * i] = scratch.column_K[i]
        residual[i] = -work[R_AT + i]
        for j in range(3):
            E[i, n + j] = -work[G_AT + 3 * i + j]
            residual[i] += E[i, ACCELERATION + j] * x[ACCELERATION + j]
            residual[i] += E[i, n + j] * x[n + j]
    return wrench


@compiled
def fill_noise(kalman: FilterRecord, geo: ClosedForms) -> None:
    """Fill in what the wrench's noise is in the equations, after `fill_residual`."""
    scratch = kalman.scratch
    _reduce(geo, scratch.applied_jacobian)
    fill_wrench_noise(scratch, kalman.noise)


@compiled
def _fill_inertia(scene: SceneScalars, geo: ClosedForms, inertia: float, E: Floats) -> None:
    """Fill in the derivatives by the accelerations."""
    s, c, h_c, dh_c, dz_c = geo.s, geo.c, geo.h_c, geo.dh_c, geo.dz_c
    E[0, 6] = inertia * (scene.m * (dh_c * dh_c + dz_c * dz_c) + scene.Ie)
    E[1, 7] = inertia * (scene.m * h_c * h_c + scene.Ie * s * s + scene.Iz * c * c)
    E[1, 8] = E[2, 7] = inertia * scene.Iz * c
    E[2, 8] = inertia * scene.Iz
    E[3, 6] = inertia * scene.m * dh_c
    E[4, 7] = inertia * scene.m * h_c
    E[5, 6] = inertia * scene.m * dz_c


@compiled
def _reduce(geo: ClosedForms, columns: Floats) -> None:
    """Turn wrenches into the right side of the six equations, column by column."""
    s, c, h_c, dh_c, dz_c = geo.s, geo.c, geo.h_c, geo.dh_c, geo.dz_c
    for j in range(columns.shape[1]):
        F_h, F_e, F_z = columns[0, j], columns[1, j], columns[2, j]
        M_h, M_e, M_z = columns[3, j], columns[4, j], columns[5, j]
        along_gamma = F_h * dh_c + F_z * dz_c - M_e
        put_column(columns, j, (along_gamma, F_e * h_c + M_z, c * M_z - s * M_h, F_h, F_e, F_z))


@compiled
def _expected_wrench(geo: ClosedForms, wrench: Wrench, scratch: Scratch) -> Wrench:
    """
    Return the wrench with which the equations hold, at which the Jacobian is evaluated.

    At the measured wrench, sensor noise would enter the Jacobian and act like information.
    """
    s, c, h_c, dh_c, dz_c = geo.s, geo.c, geo.h_c, geo.dh_c, geo.dz_c
    by_gamma, by_psi, by_phi, F_h, F_e, F_z = six_of(scratch.residual)
    M_e = F_h * dh_c + F_z * dz_c - by_gamma
    M_z = by_psi - F_e * h_c
    M_h = (c * M_z - by_phi) / s
    add_turn(scratch.applied_jacobian, s, c, Wrench(F_h, F_e, F_z, M_h, M_e, M_z))
    w = wrench
    return Wrench(w.F_h + F_h, w.F_e + F_e, w.F_z + F_z, w.M_h + M_h, w.M_e + M_e, w.M_z + M_z)


@compiled
def _differentiate_apart(
    kalman: FilterRecord, scene: SceneScalars, geo: ClosedForms,
    rates: tuple[float, float, float], wrench: Wrench, y: Solution, frictions: tuple[float, float],
) -> None:  # fmt: skip
    """
    Fill in the derivatives where friction at K differs: they are linear in each reaction.

    Parameters
    ----------
    kalman : FilterRecord
        `scratch.work` is filled as by `derivatives`, and the column of friction at K.
    scene : SceneScalars
    geo : ClosedForms
    rates, wrench, y : tuple
        Parameters of `derivatives`.
    frictions : tuple
        At B1 and B2, and at K.

    """
    scratch, (f, f_K) = kalman.scratch, frictions
    scale = scratch.velocity_scale
    scales = (scale[0], scale[1], scale[2])
    found = scratch.work[DERIVATIVES_AT : DERIVATIVES_AT + 36]
    total = scratch.gain.reshape(scratch.gain.size)
    total[:36] = 0.0
    # K alone with its friction, less what does not depend on K, and both others.
    ddgamma, ddpsi, ddphi, K, B1, B2 = y
    parts = ((f_K, K, 0.0, 0.0, 1.0), (f_K, 0.0, 0.0, 0.0, -1.0), (f, 0.0, B1, B2, 1.0))
    for friction, N_K, N_B1, N_B2, sign in parts:
        answer = (ddgamma, ddpsi, ddphi, N_K, N_B1, N_B2)
        derivatives(with_friction(scene, friction), scales, geo, rates, wrench, answer, found)
        for i in range(36):
            total[i] += sign * found[i]
        if N_K != 0.0:
            for i in range(6):
                scratch.jacobian[i, kalman.places.friction_k] = found[6 * i + BY_FRICTION]
    for i in range(36):
        found[i] = total[i]
