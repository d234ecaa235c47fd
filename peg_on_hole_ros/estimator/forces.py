"""Forces at the contacts that go with given reactions, and what a rim has to carry at all."""

from math import cos, sin, sqrt

from peg_on_hole_ros.estimator.estimate import Estimate, scene_of
from peg_on_hole_ros.estimator.hole_geometry import (
    two_point_arms,
    two_point_slip,
    two_point_tilt,
)
from peg_on_hole_ros.estimator.tuned import SCENE_AT_MEAN_BOUNDS
from peg_on_hole_ros.mechanics.kernel import (
    W_AT,
    SceneScalars,
    Wrench,
    closed_forms,
    compiled,
    equations,
)
from peg_on_hole_ros.mechanics.linear_algebra import TORQUE, in_peg_axes, length, peg_turns
from peg_on_hole_ros.outputs import Row


@compiled
def tilt_on_contacts(p: SceneScalars, gamma: float) -> float:
    """Return the tilt, kept where the closed forms of the geometry exist [rad]."""
    return min(max(gamma, p.gamma0 * (1.0 + 1e-9)), SCENE_AT_MEAN_BOUNDS.steepest_tilt)


@compiled
def contact_forces(
    p: SceneScalars,
    estimate: Estimate,
    gamma: float,
    row: Row,
) -> None:
    """
    Fill in force on the peg (normal and friction) and place of each contact, hole axes.

    Parameters
    ----------
    p : SceneScalars
    estimate : Estimate
        Its azimuth and rates are used.
    gamma : float
        Tilt at which the contacts are taken [rad].
    row : Row
        Its reactions are given; its contact wrenches are filled but for the torque, and its
        contact points.

    """
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, gamma)
    wrench = Wrench(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    motion, scales, work = estimate.motion, estimate.friction_scales, estimate.work
    rates = (motion.gamma_rate, motion.psi_rate, motion.phi_rate)
    equations(p, scales, geo, rates, wrench, work)
    s, c = sin(motion.psi), cos(motion.psi)
    force, point = row.contact_wrench, row.contact_point
    for i in range(3):
        # Normal plus friction direction, rows h, e, z.
        f_h, f_e, f_z = work[W_AT + i], work[W_AT + 3 + i], work[W_AT + 6 + i]
        N = row.normal[i]
        if N == 0.0:
            # No force has no direction, and is none also where friction's is no number.
            force[i, 0] = force[i, 1] = force[i, 2] = 0.0
        else:
            force[i, 0], force[i, 1], force[i, 2] = (
                N * (c * f_h - s * f_e),
                N * (s * f_h + c * f_e),
                N * f_z,
            )
        r_h = -0.5 * p.D if i == 0 else geo.S1
        r_e = 0.0 if i == 0 else (-geo.b if i == 1 else geo.b)
        point[i, 0], point[i, 1], point[i, 2] = c * r_h - s * r_e, s * r_h + c * r_e, 0.0


@compiled
def two_point_forces(p: SceneScalars, estimate: Estimate, row: Row) -> None:
    """Fill in force and place of K and of B, half of it in each row of B1 and B2, hole axes."""
    motion = estimate.motion
    rates = (motion.gamma_rate, motion.psi_rate, motion.phi_rate)
    gamma = two_point_tilt(p, motion.gamma)
    s, c = sin(motion.psi), cos(motion.psi)
    sg, cg = sin(gamma), cos(gamma)
    K, B = two_point_arms(p, gamma)
    force, point = row.contact_wrench, row.contact_point
    for i in range(3):
        rows = two_point_slip(p, gamma, min(i, 1))
        v = (0.0, 0.0, 0.0)
        for j in range(3):
            rate = rates[j]
            v = (v[0] + rows[0][j] * rate, v[1] + rows[1][j] * rate, v[2] + rows[2][j] * rate)
        scale = estimate.friction_scales[i]
        f = p.f / sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + scale * scale)
        n_h, n_z = (cg, sg) if i == 0 else (-1.0, 0.0)
        f_h, f_e, f_z = n_h - f * v[0], -f * v[1], n_z - f * v[2]
        N = row.normal[i]
        force[i, 0], force[i, 1], force[i, 2] = (
            N * (c * f_h - s * f_e),
            N * (s * f_h + c * f_e),
            N * f_z,
        )
        side, depth = (-0.5 if i == 0 else 0.5) * p.D, 0.0 if i == 0 else B[1] - K[1]
        point[i, 0], point[i, 1], point[i, 2] = c * side, s * side, depth


@compiled
def rim_load(estimate: Estimate) -> tuple[float, float]:
    """Return the sizes of the force [N] and of the couple [N m] that a rim has to carry."""
    p, motion, u = scene_of(estimate), estimate.motion, estimate.wrench
    turns = peg_turns(motion.gamma, motion.psi, motion.phi)
    weight = in_peg_axes(turns, (p.m * p.g_x, p.m * p.g_y, p.m * p.g_z))
    F_x, F_y, F_z = u[0] + weight[0], u[1] + weight[1], u[2] + weight[2]
    return sqrt(F_x * F_x + F_y * F_y + F_z * F_z), length(u, TORQUE)
