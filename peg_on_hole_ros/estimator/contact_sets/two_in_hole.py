"""
Two contacts in the hole, K on the rim and B on the wall, as a measurement of the wrench.

Newton's and Euler's equations about the mass centre in (h, e, z): rows F_h, F_e, F_z, M_h, M_e,
M_z. Unknown are N_K and N_B; the force along e that holds B in the plane of the tilt (T4) is a
noise as wide as the load, so that its evidence of friction is not counted twice.
"""

from math import cos, sin

from peg_on_hole_ros.estimator.applied_wrench import (
    Column,
    add_turn,
    applied_wrench,
    fill_wrench_noise,
    six_of,
    subtract_applied_jacobian,
)
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.friction_direction import along_slip, slip_statistics
from peg_on_hole_ros.estimator.hole_geometry import (
    Arm,
    two_point_arms,
    two_point_slip,
    two_point_tilt,
)
from peg_on_hole_ros.estimator.scene_at_mean import fill_clearance_jacobian, scene_at
from peg_on_hole_ros.estimator.scratch import Scratch
from peg_on_hole_ros.estimator.state import ACCELERATION, FRICTION, RATE
from peg_on_hole_ros.estimator.update import reset_three
from peg_on_hole_ros.mechanics.kernel import SceneScalars, Wrench, compiled
from peg_on_hole_ros.typed_record import Floats

SOLVED_REACTIONS = 2  # N_K, N_B
WRENCH_MAY_DRIVE = False
IN_HOLE = True


@compiled
def begin_reactions(x: Floats, P: Floats, first: int, variance: float) -> None:
    """Give N_K its prior variance [N^2], and N_B, which stands as two halves for N_B1, N_B2."""
    reset_three(P, first, first + 3, variance)
    x[first + 1] = x[first + 2] = 0.5 * (x[first + 1] + x[first + 2])
    for i in range(first + 1, first + 3):
        P[i, first + 1] = P[i, first + 2] = 0.25 * variance


@compiled
def linearise(
    kalman: FilterRecord, scene: SceneScalars, x: Floats, P: Floats, mode_stddev: float
) -> float:
    """
    Linearise the balance of two-point contact at the mean of a component.

    N_B stands in the mean as two halves, in the places of N_B1 and N_B2. The direction of the slip
    is that at the mean tilt.

    Parameters
    ----------
    kalman, scene, x, P
        As for `three_on_rim.linearise`.
    mode_stddev : float
        Of accelerations [rad/s^2]: along the hole the peg speeds up by as much over its height,
        twice that of the mass centre.

    Returns
    -------
    turned : float
        See `direction.friction_direction_statistics`.

    """
    state, settings, places, scratch = (
        kalman.state, kalman.settings, kalman.places, kalman.scratch,
    )  # fmt: skip
    n, load, share = places.reactions, state.load, settings.direction_share
    # Contacts that give act as a wider hole; above gamma0 they act as a thicker peg.
    scene = scene_at(scene, x, places, -load)
    E, residual, noise = scratch.jacobian, scratch.residual, scratch.direction_noise
    gamma = two_point_tilt(scene, x[0])
    s, c = sin(gamma), cos(gamma)
    wrench = applied_wrench(kalman, scene, x, s, c)
    for i in range(6):
        residual[i] = -wrench[i]
        scratch.by_diameter[i] = 0.0
        for j in range(n + 3):
            E[i, j] = 0.0
        for j in range(6):
            noise[i, j] = 0.0
    _subtract_inertia(scene, x, gamma, settings.inertia, scratch)
    K, B = two_point_arms(scene, gamma)
    turned, left_K, scale2_K = slip_statistics(two_point_slip(scene, gamma, 0), x, P, share)
    other, left_B, scale2_B = slip_statistics(two_point_slip(scene, gamma, 1), x, P, share)
    _subtract_contact(kalman, scene, x, 0, K, scale2_K)
    _subtract_contact(kalman, scene, x, 1, B, scale2_B)
    # What the residual lacks is no part of the Jacobian, see `three_on_rim`.
    F_h, F_e, F_z, M_h, M_e, M_z = six_of(residual)
    add_turn(scratch.applied_jacobian, s, c, Wrench(F_h, F_e, F_z, M_h, M_e, M_z))
    subtract_applied_jacobian(scratch, places, kalman.bias_map)
    fill_wrench_noise(scratch, kalman.noise)
    scratch.noise[2, 2] += (2.0 * scene.m * scene.H_c * mode_stddev) ** 2
    friction2 = state.friction_force2
    amount_K = 0.5 * left_K * friction2[0]
    amount_B = 0.5 * left_B * (friction2[1] + friction2[2]) * 2.0
    _add_noise(noise, amount_K, (0.0, 1.0, 0.0, -K[1], 0.0, K[0]))
    _add_noise(noise, amount_K, (-s, 0.0, c, 0.0, -K[1] * s - K[0] * c, 0.0))
    _add_noise(noise, amount_B, (0.0, 1.0, 0.0, -B[1], 0.0, B[0]))
    _add_noise(noise, amount_B, (0.0, 0.0, 1.0, 0.0, -B[0], 0.0))
    # The axes cross in the middle between K and B, seen along e.
    O_h, O_z = 0.5 * (K[0] + B[0]), 0.5 * (K[1] + B[1])
    _add_noise(scratch.noise, load * load, (0.0, 1.0, 0.0, -O_z, 0.0, O_h))
    return 0.5 * (turned + other)


@compiled
def _subtract_inertia(
    scene: SceneScalars, x: Floats, gamma: float, inertia: float, scratch: Scratch
) -> None:
    """Add the inertia of accelerations; those of the place along the hole are noise."""
    s, c, E = sin(gamma), cos(gamma), scratch.jacobian
    h_c = 0.5 * (scene.D - scene.d * c) - scene.H_c * s
    rows = (
        (0, 0, scene.m * (0.5 * scene.d * s - scene.H_c * c)),
        (1, 1, scene.m * h_c),
        (3, 2, -s * scene.Iz),
        (4, 0, -scene.Ie),
        (5, 1, scene.Ie * s * s + scene.Iz * c * c),
        (5, 2, scene.Iz * c),
        (3, 1, (scene.Ie - scene.Iz) * s * c),
    )
    for i, j, amount in rows:
        E[i, ACCELERATION + j] = inertia * amount
        scratch.residual[i] += inertia * amount * x[ACCELERATION + j]


@compiled
def _subtract_contact(
    kalman: FilterRecord, scene: SceneScalars, x: Floats, contact: int, arm: Arm, scale2: float
) -> None:
    """
    Subtract the force of K (0) or B (1) from the residual, and fill in its Jacobian.

    Parameters
    ----------
    kalman : FilterRecord
    scene : SceneScalars
        The scene at the mean.
    x : ndarray
        Mean of the component.
    contact : int
    arm : tuple
        From `two_point_arms`.
    scale2 : float
        Square of the velocity scale of friction's mean direction [m^2/s^2].

    """
    places, scratch, load = kalman.places, kalman.scratch, kalman.state.load
    E, residual, first = scratch.jacobian, scratch.residual, places.reactions + contact
    gamma = two_point_tilt(scene, x[0])
    s, c = sin(gamma), cos(gamma)
    N, f = x[first], x[FRICTION]
    n_h, n_z, turned_h, turned_z = c, s, -s, c
    if contact == 1:
        N = x[first] + x[first + 1]
        n_h, n_z, turned_h, turned_z = -1.0, 0.0, 0.0, 0.0
    elif places.friction_k >= 0:
        f += x[places.friction_k]
    rows = two_point_slip(scene, gamma, contact)
    v_h, v_e, v_z = along_slip(rows[0], x), along_slip(rows[1], x), along_slip(rows[2], x)
    over = 1.0 / (v_h * v_h + v_e * v_e + v_z * v_z + scale2) ** 0.5
    d_h, d_e, d_z = v_h * over, v_e * over, v_z * over
    r_h, r_z, by_h, by_z = arm
    w = _wrench_of(n_h - f * d_h, -f * d_e, n_z - f * d_z, r_h, r_z)
    by_f = _wrench_of(-d_h, -d_e, -d_z, r_h, r_z)
    # Force turned with the tilt, and arm moved by it.
    by_tilt = _wrench_of(turned_h, 0.0, turned_z, r_h, r_z)
    moved = _moved(w, by_h, by_z)
    for i in range(6):
        residual[i] -= N * w[i]
        E[i, first] = -w[i]
        if contact == 1:
            E[i, first + 1] = -w[i]
        E[i, 0] -= N * (by_tilt[i] + moved[i])
        E[i, FRICTION] -= N * by_f[i]
        scratch.by_friction[i, contact] = by_f[i]
        # N_B is two halves.
        if contact == 1:
            scratch.by_friction[i, 2] = by_f[i]
        if contact == 0 and places.friction_k >= 0:
            E[i, places.friction_k] = -N * by_f[i]
    for j in range(3):
        g_h, g_e, g_z = rows[0][j] * over, rows[1][j] * over, rows[2][j] * over
        with_v = g_h * d_h + g_e * d_e + g_z * d_z
        by_rate = _wrench_of(g_h - with_v * d_h, g_e - with_v * d_e, g_z - with_v * d_z, r_h, r_z)
        for i in range(6):
            E[i, RATE + j] += N * f * by_rate[i]
    # By the diameter: the peg's radius moves both, its length in the hole moves K.
    thicker = _moved(w, 0.5 * c, 0.5 * s - (1.0 / s if contact == 0 else 0.0))
    for i in range(6):
        scratch.by_diameter[i] -= N * thicker[i]
        fill_clearance_jacobian(scene, x, places, -load, -N * thicker[i], E[i])


@compiled
def _wrench_of(F_h: float, F_e: float, F_z: float, r_h: float, r_z: float) -> Column:
    """Return a force with its moment, at an arm in the plane of the tilt."""
    return F_h, F_e, F_z, -r_z * F_e, r_z * F_h - r_h * F_z, r_h * F_e


@compiled
def _moved(w: Column, by_h: float, by_z: float) -> Column:
    """Return how a wrench changes where its force stays and its arm moves."""
    return 0.0, 0.0, 0.0, -by_z * w[1], by_z * w[0] - by_h * w[2], by_h * w[1]


@compiled
def _add_noise(noise: Floats, amount: float, w: Column) -> None:
    """Add the covariance of a wrench along one direction, of a variance."""
    for i in range(6):
        for j in range(6):
            noise[i, j] += amount * w[i] * w[j]
