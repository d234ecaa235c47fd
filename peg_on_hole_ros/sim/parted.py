"""
A peg of which a contact has opened: six degrees of freedom on contacts that give a little.

How far the peg is off each of its three touching points follows from the shapes of peg and rim; a
contact pushes back by a spring and a damper while it is pressed in. So contacts open, touch again
and jam by themselves: nothing here solves for reactions.
"""

from typing import NamedTuple

import numpy as np
from scipy.integrate import Radau

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.sim.command import evaluate
from peg_on_hole_ros.sim.contact_run import MAX_STEP, Model
from peg_on_hole_ros.sim.dynamics import angular_velocity, solve6
from peg_on_hole_ros.sim.gaps import contact_gaps
from peg_on_hole_ros.sim.guided import hole_axes, newton_euler
from peg_on_hole_ros.sim.holder import cross, holder_pull, mass_centre
from peg_on_hole_ros.sim.plan import CONTACT_STIFFNESS

# Share of the critical damping of the peg's mass on one contact.
CONTACT_DAMPING = 0.3
# A peg this far off the rim has lost more than a contact [m].
LARGEST_GAP = 5e-4
# Newton's steps to the offset that presses the contacts in by given depths.
_PRESSING_STEPS = 3
# The geometry of three points ends at gamma0 [rad].
LEAST_TILT_ABOVE_GAMMA0 = 1e-5


class PartedRun(NamedTuple):
    """
    Motion with contacts that come and go.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Of the samples asked for that were reached [s].
    states : ndarray, shape (n, 12)
        gamma, psi, phi, offset along h, e, z from the touching pose, and their rates.
    ended_by : str
        `gap`, `transition`, `force limit`, `torque limit`, or `end`.

    """

    t: np.ndarray
    states: np.ndarray
    ended_by: str


def parted_state(
    model: Model, state: np.ndarray, normal: np.ndarray, stiffness: float = CONTACT_STIFFNESS
) -> np.ndarray:
    """
    Return the state in which contacts that give carry what rigid ones did, shape (12,).

    Parameters
    ----------
    model : Model
    state : ndarray, shape (6,)
        gamma, psi, phi and rates on three rigid contacts.
    normal : ndarray, shape (3,)
        Reactions there [N].
    stiffness : float
        Of the contacts [N/m].

    """
    out = np.zeros(12)
    out[:3], out[6:9] = state[:3], state[3:]
    pressed = -np.maximum(normal, 0.0) / stiffness
    for _ in range(_PRESSING_STEPS):
        _, normals, gaps = contact_gaps(model.p, state[0], out[3:6].copy())
        # Near gamma0 two normals are all but one: the smallest offset that fits.
        out[3:6] += np.linalg.lstsq(normals, pressed - gaps, rcond=1e-6)[0]
    return out


@compiled
def pushes(
    p: np.ndarray, x: np.ndarray, scale: float, stiffness: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """
    Return where the contacts are, how hard they push, and how fast they slip.

    Parameters
    ----------
    p : ndarray
        Scene.
    x : ndarray, shape (3, 6)
        Angles and offset with rates.
    scale : float
        Of the regularised friction law [m/s].
    stiffness : float
        Of the contacts [N/m].

    Returns
    -------
    points, forces : ndarray, shape (3, 3)
        Rows K, B1, B2, hole axes [m], [N].
    normal, slip_speed : ndarray, shape (3,)
        [N], [m/s]

    """
    q = x[0, :3].copy()
    points, normals, gaps = contact_gaps(p, q[0], x[0, 3:])
    centre = mass_centre(p, x)
    w = angular_velocity(q, x[1, :3].copy())
    damping = CONTACT_DAMPING * 2 * np.sqrt(stiffness * p[3])
    forces, normal, slip = np.zeros((3, 3)), np.zeros(3), np.zeros(3)
    for i in range(3):
        gap = gaps[i]
        n = hole_axes(q[1], normals[i])
        points[i] = hole_axes(q[1], points[i])
        v = centre[1] + cross(w, points[i] - centre[0])
        approach = np.sum(v * n)
        v = v - approach * n
        slip[i] = np.sqrt(np.sum(v * v))
        if gap < 0:
            normal[i] = max(0.0, -stiffness * gap - damping * approach)
        forces[i] = normal[i] * (n - p[6] * v / np.sqrt(slip[i] ** 2 + scale * scale))
    return points, forces, normal, slip


@compiled
def parted_motion(
    t: float,
    y: np.ndarray,
    p: np.ndarray,
    holder: np.ndarray,
    knots: np.ndarray,
    coefficients: np.ndarray,
    scale: float,
    stiffness: float,
) -> np.ndarray:
    """Return accelerations of angles and offset, and the holder's F and M, shape (12,)."""
    x = np.zeros((3, 6))
    x[0], x[1] = y[:6], y[6:]
    F, M = holder_pull(p, holder, evaluate(knots, coefficients, t), x)
    points, forces, _, _ = pushes(p, x, scale, stiffness)
    # What has to be exerted is affine in the accelerations.
    F0, M0 = newton_euler(p, x, points, forces)
    A, r = np.empty((6, 6)), np.empty(6)
    r[:3], r[3:] = F - F0, M - M0
    for j in range(6):
        x[2, j] = 1.0
        F1, M1 = newton_euler(p, x, points, forces)
        x[2, j] = 0.0
        A[:3, j], A[3:, j] = F1 - F0, M1 - M0
    out = np.empty(12)
    out[:6] = solve6(A, r)
    out[6:9], out[9:] = F, M
    return out


@compiled
def parted_rate(
    t: float,
    y: np.ndarray,
    p: np.ndarray,
    holder: np.ndarray,
    knots: np.ndarray,
    coefficients: np.ndarray,
    scale: float,
    stiffness: float,
) -> np.ndarray:
    """Return the time derivative of the state, shape (12,)."""
    out = np.empty(12)
    out[:6] = y[6:]
    out[6:] = parted_motion(t, y, p, holder, knots, coefficients, scale, stiffness)[:6]
    return out


@compiled
def parted_jacobian(
    t: float,
    y: np.ndarray,
    p: np.ndarray,
    holder: np.ndarray,
    knots: np.ndarray,
    coefficients: np.ndarray,
    scale: float,
    stiffness: float,
) -> np.ndarray:
    """Return the derivative of `parted_rate` by the state, central differences, (12, 12)."""
    J = np.empty((12, 12))
    for j in range(12):
        h = 1e-9 if j < 6 else 1e-8
        x = y.copy()
        x[j] += h
        up = parted_rate(t, x, p, holder, knots, coefficients, scale, stiffness)
        x[j] -= 2 * h
        J[:, j] = (up - parted_rate(t, x, p, holder, knots, coefficients, scale, stiffness)) / (
            2 * h
        )
    return J


def run_parted(
    model: Model,
    t0: float,
    y: np.ndarray,
    samples: np.ndarray,
    t_end: float,
    limits: tuple[float, float],
    rtol: float,
    stiffness: float = CONTACT_STIFFNESS,
) -> PartedRun:
    """
    Integrate by Radau IIA; it ends at a sample, not at the event itself.

    Parameters
    ----------
    model : Model
    t0, t_end : float
        [s]
    y : ndarray, shape (12,)
    samples : ndarray
        Times wanted, rising, t0 <= t [s].
    limits : tuple of 2 float
        Force [N] and torque [N m] of the holder that end the run.
    rtol : float
        The absolute tolerance is a hundredth of it, and of a nanometre's order for offsets.
    stiffness : float
        Of the contacts [N/m].

    """
    atol = np.full(12, rtol / 100)
    atol[3:6] = rtol / 1e5
    solver = Radau(
        lambda t, x: parted_rate(t, x, *model, stiffness), t0, np.asarray(y, float), t_end,
        max_step=MAX_STEP, rtol=rtol, atol=atol,
        jac=lambda t, x: parted_jacobian(t, x, *model, stiffness),
    )  # fmt: skip
    taken, states, k, ended = [], [], 0, ""
    while solver.status == "running" and not ended:
        solver.step()
        if solver.status == "failed":
            raise PegOnHoleError(
                f"no step of the integrator meets rtol = {rtol:g} at {solver.t:.6f} s, after a "
                f"contact opened; gamma, psi, phi = {solver.y[:3]} rad: loosen simulation.rtol"
            )
        dense = solver.dense_output()
        while k < len(samples) and samples[k] <= solver.t and not ended:
            state = dense(samples[k]) if samples[k] > t0 else np.array(y, float)
            ended = _ends(model, samples[k], state, limits, stiffness)
            if not ended:
                taken.append(samples[k])
                states.append(state)
                k += 1
    return PartedRun(np.array(taken), np.array(states).reshape(-1, 12), ended or "end")


def _ends(model, t, y, limits, stiffness):
    if y[0] < model.p[7] + LEAST_TILT_ABOVE_GAMMA0:
        return "transition"
    if contact_gaps(model.p, y[0], y[3:6].copy())[2].max() > LARGEST_GAP:
        return "gap"
    load = parted_motion(t, y, *model, stiffness)[6:]  # type: ignore[call-arg]
    if np.linalg.norm(load[:3]) > limits[0]:
        return "force limit"
    return "torque limit" if np.linalg.norm(load[3:]) > limits[1] else ""
