"""The compliant holder: a spring and damper of six directions between commanded and true pose."""

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.command import evaluate
from peg_on_hole_ros.sim.dynamics import (
    angular_velocity,
    motion,
    rotation,
    three_points,
)


def holder_numbers(
    scene: Scene,
    attachment: ArrayLike,
    stiffness: float,
    rotational_stiffness: float,
    damping_ratio: float,
) -> np.ndarray:
    """
    Return the holder as numbers for the compiled functions.

    Parameters
    ----------
    scene : Scene
    attachment : array_like, shape (3,)
        Where the holder grips, in the peg frame [m].
    stiffness, rotational_stiffness : float
        [N/m], [N m/rad]
    damping_ratio : float
        Of the peg on the free holder.

    Returns
    -------
    ndarray, shape (7,)
        Attachment from the mass centre (3), stiffness, damping [N s/m], rotational stiffness,
        rotational damping [N m s/rad].

    """
    damping = 2 * damping_ratio * np.sqrt(stiffness * scene.peg_mass)
    rotational_damping = (
        2 * damping_ratio * np.sqrt(rotational_stiffness * scene.transverse_inertia)
    )
    lever = np.asarray(attachment, float) - [0.0, 0.0, scene.mass_center_height]
    return np.array([*lever, stiffness, damping, rotational_stiffness, rotational_damping])


@compiled
def touching(p: np.ndarray, gamma: float) -> np.ndarray:
    """
    Return the mass centre of the touching pose in the plane (h, z), and derivatives by gamma.

    Above gamma0 the peg touches in three points. Below, in two: its side at K, the lower edge at
    the far wall. Pose and slope are continuous at gamma0, the curvature is not.

    Returns
    -------
    ndarray, shape (3, 2)
        Rows: position [m], first derivative [m/rad], second [m/rad^2]; columns h, z.

    """
    out = np.empty((3, 2))
    if gamma >= p[7]:
        g = three_points(p, gamma)
        for i in range(6):
            out[i // 2, i % 2] = g[7 + i]
        return out
    d, D, height = p[0], p[1], p[2]
    s, c = np.sin(gamma), np.cos(gamma)
    end = (d * (1 + c * c) / 2 - D * c) / s
    slope = D - d * c - end * c / s
    out[0, 0], out[0, 1] = (D - d * c) / 2 - height * s, end + height * c
    out[1, 0], out[1, 1] = d * s / 2 - height * c, slope - height * s
    out[2, 0] = d * c / 2 + height * s
    out[2, 1] = d * s - slope * c / s + end / (s * s) - height * c
    return out


@compiled
def mass_centre(p: np.ndarray, x: np.ndarray) -> np.ndarray:
    """
    Return the mass centre's position, velocity and acceleration in hole axes.

    Parameters
    ----------
    p : ndarray
        Scene.
    x : ndarray, shape (3, 6)
        Value, rate and acceleration of gamma, psi, phi and of the offset along h, e, z from the
        touching pose.

    Returns
    -------
    ndarray, shape (3, 3)
        [m], [m/s], [m/s^2] as rows.

    """
    T = touching(p, x[0, 0])
    dg, ddg = x[1, 0], x[2, 0]
    u = np.empty((3, 3))
    for j in range(2):
        k = 2 * j
        u[0, k] = T[0, j] + x[0, 3 + k]
        u[1, k] = T[1, j] * dg + x[1, 3 + k]
        u[2, k] = T[1, j] * ddg + T[2, j] * dg * dg + x[2, 3 + k]
    u[:, 1] = x[:, 4]
    dp, ddp = x[1, 1], x[2, 1]
    out = np.empty((3, 3))
    # In the turning frame: v = u' + psi' z x u, and once more for the acceleration.
    v_h, v_e = u[1, 0] - dp * u[0, 1], u[1, 1] + dp * u[0, 0]
    a_h = u[2, 0] - 2 * dp * u[1, 1] - ddp * u[0, 1] - dp * dp * u[0, 0]
    a_e = u[2, 1] + 2 * dp * u[1, 0] + ddp * u[0, 0] - dp * dp * u[0, 1]
    s, c = np.sin(x[0, 1]), np.cos(x[0, 1])
    out[0, 0], out[0, 1] = c * u[0, 0] - s * u[0, 1], s * u[0, 0] + c * u[0, 1]
    out[1, 0], out[1, 1] = c * v_h - s * v_e, s * v_h + c * v_e
    out[2, 0], out[2, 1] = c * a_h - s * a_e, s * a_h + c * a_e
    out[:, 2] = u[:, 2]
    return out


@compiled
def rotation_vector(R: np.ndarray) -> np.ndarray:
    """Return the rotation vector of R [rad], for angles below about 3 rad, shape (3,)."""
    w = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    sine = np.sqrt(np.sum(w * w))
    angle = np.arctan2(sine, (R[0, 0] + R[1, 1] + R[2, 2] - 1) / 2)
    return w * (angle / sine) if sine > 1e-12 else w


@compiled
def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a x b, shape (3,)."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


@compiled
def holder_pull(
    p: np.ndarray, holder: np.ndarray, command: np.ndarray, true: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the force and the moment about the mass centre of the holder on the peg, hole axes.

    The holder's program knows the peg's weight: it lifts its command by what the weight takes,
    so that at the commanded pose it carries the peg.

    Parameters
    ----------
    p, holder : ndarray
        From `scene_numbers`, `holder_numbers`.
    command, true : ndarray, shape (3, 6)
        Angles and offset with rates, as from `command.evaluate`.

    Returns
    -------
    F, M : ndarray, shape (3,)
        [N], [N m]

    """
    C, C_command = mass_centre(p, true), mass_centre(p, command)
    R, R_command = rotation(true[0, :3]), rotation(command[0, :3])
    w, w_command = (
        angular_velocity(true[0, :3], true[1, :3]),
        angular_velocity(command[0, :3], command[1, :3]),
    )
    lever, lever_command = R @ holder[:3], R_command @ holder[:3]
    stretch = C_command[0] + lever_command - C[0] - lever
    speed = C_command[1] + cross(w_command, lever_command) - C[1] - cross(w, lever)
    F = holder[3] * stretch + holder[4] * speed
    M = holder[5] * rotation_vector(R_command @ R.T) + holder[6] * (w_command - w)
    M = M + cross(lever, F)
    F = F - p[3] * p[8:11]
    return F, M


@compiled
def holder_wrench(
    p: np.ndarray, holder: np.ndarray, command: np.ndarray, state: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return `holder_pull` on a peg in three-point contact, of gamma, psi, phi and rates."""
    true = np.zeros((3, 6))
    true[0, :3], true[1, :3] = state[:3], state[3:]
    return holder_pull(p, holder, command, true)


@compiled
def contact_motion(
    p: np.ndarray,
    holder: np.ndarray,
    knots: np.ndarray,
    coefficients: np.ndarray,
    scale: float,
    t: float,
    state: np.ndarray,
) -> np.ndarray:
    """Return gamma'', psi'', phi'', N_K, N_B1, N_B2 and the holder's F, M, shape (12,)."""
    command = evaluate(knots, coefficients, t)
    F, M = holder_wrench(p, holder, command, state)
    out = np.empty(12)
    out[:6] = motion(p, state[:3], state[3:], F, M, scale)
    out[6:9], out[9:] = F, M
    return out


@compiled
def state_rate(
    t: float,
    state: np.ndarray,
    p: np.ndarray,
    holder: np.ndarray,
    knots: np.ndarray,
    coefficients: np.ndarray,
    scale: float,
) -> np.ndarray:
    """Return the time derivative of gamma, psi, phi and their rates, shape (6,)."""
    out = np.empty(6)
    out[:3] = state[3:]
    out[3:] = contact_motion(p, holder, knots, coefficients, scale, t, state)[:3]
    return out


@compiled
def state_rate_jacobian(
    t: float,
    state: np.ndarray,
    p: np.ndarray,
    holder: np.ndarray,
    knots: np.ndarray,
    coefficients: np.ndarray,
    scale: float,
) -> np.ndarray:
    """
    Return the derivative of `state_rate` by the state, by central differences, shape (6, 6).

    It steers the Newton iteration of an implicit integrator only; the result does not rest on it.
    The steps stay far below the scales on which friction (4e-4 rad/s) and geometry change.
    """
    J = np.empty((6, 6))
    for j in range(6):
        h = 1e-9 if j < 3 else 1e-8
        x = state.copy()
        x[j] += h
        up = state_rate(t, x, p, holder, knots, coefficients, scale)
        x[j] -= 2 * h
        J[:, j] = (up - state_rate(t, x, p, holder, knots, coefficients, scale)) / (2 * h)
    return J
