"""
Forces on a peg in a hole: contacts that give a little and hold by dry friction, and the holder.

A contact is a spring and a damper along its normal, and along the surfaces a spring that slides
where it would carry more than the friction coefficient times the normal force. So a peg at rest
rests, without creep, and forces can be locked in between two contacts.
"""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.sim.command import evaluate
from peg_on_hole_ros.sim.dynamics import angular_velocity, rotation
from peg_on_hole_ros.sim.holder import cross, rotation_vector
from peg_on_hole_ros.sim.hole_places import SLOTS, touching_places

# Of the surfaces along each other over that along the normal: Mindlin, 2 (1 - nu)/(2 - nu).
TANGENTIAL_STIFFNESS_RATIO = 0.82
# Share of the critical damping of the peg's mass on one contact.
DAMPING = 0.7


class Surface(NamedTuple):
    """Stiffness and damping of one contact, along its normal and along the surfaces."""

    normal: float
    along: float
    normal_damping: float
    along_damping: float


def surface_of(mass: float, stiffness: float) -> Surface:
    """Return the contacts of a peg of some mass [kg]; N/m and N s/m."""
    damping = 2 * DAMPING * np.sqrt(stiffness * mass)
    return Surface(
        stiffness,
        TANGENTIAL_STIFFNESS_RATIO * stiffness,
        damping,
        np.sqrt(TANGENTIAL_STIFFNESS_RATIO) * damping,
    )


class HoleModel(NamedTuple):
    """
    What moves a peg in a hole.

    Attributes
    ----------
    p : ndarray
        Scene, from `dynamics.scene_numbers`.
    height : float
        Of the peg [m].
    surface : Surface
        Of the contacts.
    holder : ndarray
        From `holder.holder_numbers`.

    """

    p: np.ndarray
    height: float
    surface: Surface
    holder: np.ndarray


class HoleContacts(NamedTuple):
    """
    What the contacts do: a row for each slot of `hole_places`.

    Attributes
    ----------
    points, forces, strained, slips : ndarray, shape (4, 3)
        [m]; on the peg [N]; the springs' new strain [m]; velocity along the surfaces [m/s].
    normal, azimuth, gaps : ndarray, shape (4,)
        [N], [rad], [m]

    """

    points: np.ndarray
    forces: np.ndarray
    strained: np.ndarray
    slips: np.ndarray
    normal: np.ndarray
    azimuth: np.ndarray
    gaps: np.ndarray


@compiled
def contact_forces(
    model: HoleModel,
    C: np.ndarray,
    R: np.ndarray,
    V: np.ndarray,
    shift: np.ndarray,
    lasts: float,
    before: np.ndarray,
) -> HoleContacts:
    """
    Return what the contacts do at a pose and velocity.

    Parameters
    ----------
    model : HoleModel
    C, R : ndarray, shape (3,), (3, 3)
        Mass centre [m] and axes of the peg, hole axes.
    V : ndarray, shape (6,)
        Velocity of the mass centre and angular velocity, hole axes [m/s], [rad/s].
    shift : ndarray, shape (4, 3)
        How far the springs along the surfaces were strained before, hole axes [m].
    lasts : float
        Time for which the velocity strains them further [s].
    before : ndarray, shape (4,)
        Azimuth of the slots lately [rad].

    """
    surface = model.surface
    points, normals, gaps, azimuth, share = touching_places(model.p, model.height, C, R, before)
    forces, strained, slips = np.zeros((SLOTS, 3)), np.zeros((SLOTS, 3)), np.zeros((SLOTS, 3))
    normal = np.zeros(SLOTS)
    for i in range(SLOTS):
        if gaps[i] >= 0:
            continue
        n = normals[i]
        ax, ay, az = points[i, 0] - C[0], points[i, 1] - C[1], points[i, 2] - C[2]
        vx = V[0] + V[4] * az - V[5] * ay
        vy = V[1] + V[5] * ax - V[3] * az
        vz = V[2] + V[3] * ay - V[4] * ax
        away = vx * n[0] + vy * n[1] + vz * n[2]
        N = -share[i] * (surface.normal * gaps[i] + surface.normal_damping * away)
        if N <= 0:
            continue
        slips[i, 0], slips[i, 1] = vx - away * n[0], vy - away * n[1]
        slips[i, 2] = vz - away * n[2]
        out = shift[i, 0] * n[0] + shift[i, 1] * n[1] + shift[i, 2] * n[2]
        pulled = 0.0
        length = 0.0
        for j in range(3):
            strained[i, j] = shift[i, j] - out * n[j] + lasts * slips[i, j]
            forces[i, j] = -share[i] * (
                surface.along * strained[i, j] + surface.along_damping * slips[i, j]
            )
            pulled += forces[i, j] ** 2
            length += strained[i, j] ** 2
        pulled, length = np.sqrt(pulled), share[i] * surface.along * np.sqrt(length)
        most = model.p[6] * N
        if pulled > most:
            for j in range(3):
                # Sliding: the spring keeps what friction carries.
                strained[i, j] = -forces[i, j] / pulled * most / (share[i] * surface.along)
                forces[i, j] *= most / pulled
        elif length > most:
            for j in range(3):
                strained[i, j] *= most / length
        for j in range(3):
            forces[i, j] += N * n[j]
        normal[i] = N
    return HoleContacts(points, forces, strained, slips, normal, azimuth, gaps)


@compiled
def commanded(
    p: np.ndarray, knots: np.ndarray, coefficients: np.ndarray, t: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """
    Return the commanded mass centre, axes, velocity and angular velocity, hole axes.

    Channels: gamma, psi, phi [rad], place x, y and depth of the lower end's centre [m].
    """
    x = evaluate(knots, coefficients, t)
    R = rotation(x[0, :3].copy())
    w = angular_velocity(x[0, :3].copy(), x[1, :3].copy())
    lever = p[2] * R[:, 2].copy()
    C, v = x[0, 3:].copy(), x[1, 3:].copy()
    C[2], v[2] = -C[2], -v[2]
    return C + lever, R, v + cross(w, lever), w


@compiled
def pull(
    p: np.ndarray,
    holder: np.ndarray,
    command: np.ndarray,
    C: np.ndarray,
    R: np.ndarray,
    V: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return force and moment about the mass centre of the holder on the peg, hole axes.

    As `holder.holder_pull`, of a pose in hole axes; `command` is what `commanded` returns.
    """
    C_command, R_command, v_command, w_command = command
    lever, lever_command = R @ holder[:3], R_command @ holder[:3]
    stretch = C_command + lever_command - C - lever
    w = V[3:].copy()
    speed = v_command + cross(w_command, lever_command) - V[:3] - cross(w, lever)
    F = holder[3] * stretch + holder[4] * speed
    M = holder[5] * rotation_vector(R_command @ R.T) + holder[6] * (w_command - w)
    M = M + cross(lever, F)
    F = F - p[3] * p[8:11]
    return F, M


@compiled
def acceleration(
    p: np.ndarray,
    F: np.ndarray,
    M: np.ndarray,
    C: np.ndarray,
    R: np.ndarray,
    V: np.ndarray,
    points: np.ndarray,
    forces: np.ndarray,
) -> np.ndarray:
    """Return what the holder's wrench, gravity and contacts do, shape (6,) [m/s^2], [rad/s^2]."""
    m, Ie, Iz = p[3], p[4], p[5]
    total, moment = F + m * p[8:11], M.copy()
    for i in range(SLOTS):
        total = total + forces[i]
        moment = moment + cross(points[i] - C, forces[i])
    zeta, w = R[:, 2].copy(), V[3:].copy()
    spin = np.sum(w * zeta)
    # Euler's equations of a body of revolution.
    moment = moment - (Iz - Ie) * spin * cross(w, zeta)
    out = np.empty(6)
    out[:3] = total / m
    out[3:] = moment / Ie + (1 / Iz - 1 / Ie) * np.sum(zeta * moment) * zeta
    return out
