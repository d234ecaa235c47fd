"""The phases of a plan in which the peg is inserted: what the holder does, and the samples."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from peg_on_hole_ros.sim.blocks import empty_block
from peg_on_hole_ros.sim.command import evaluate, quintic
from peg_on_hole_ros.sim.contact_run import contact_samples
from peg_on_hole_ros.sim.dynamics import (
    angular_acceleration,
    angular_velocity,
    rotation,
)
from peg_on_hole_ros.sim.holder import mass_centre
from peg_on_hole_ros.sim.hole_forces import surface_of
from peg_on_hole_ros.sim.hole_places import EDGE_SLOTS, RIM_SLOTS
from peg_on_hole_ros.sim.insertion import Insertion, InsertionRows
from peg_on_hole_ros.sim.plan import PlanPhase

if TYPE_CHECKING:
    from peg_on_hole_ros.sim.run import Run

# An edge this near below the rim, of the hole's diameter, and the rim beside it are one contact.
_AT_RIM = 0.005
# Of sin(gamma): psi and phi of an upright peg are one angle, and their rates have no bound.
_UPRIGHT_SINE = 1e-9


def insert(run: Run) -> None:
    """
    Go into the hole and down it; only insert phases follow.

    Parameters
    ----------
    run : run.Run
        Simulated up to here; it gets the samples, and what ended them.

    """
    plan, begin = run.plan, run.t
    first = run.phase_index(begin)
    start = begin_of(run.knots, run.coefficients, run.model.p, begin - 1e-12)
    knots, pieces = place_program(plan.phases[first:], start, run.coefficients[first:, :3])
    run.take_friction()
    p = run.model.p
    insertion = Insertion(
        p,
        plan.configuration.scene.peg_height,
        run.model.holder,
        knots + begin,
        pieces,
        surface_of(p[3], plan.contact_stiffness),
    )
    x = np.zeros((3, 6))
    normal = None
    if run.state is None:
        x[:2] = evaluate(run.knots, run.coefficients, begin)[:2]
        x[:2, 3:] = 0
    else:
        x[0, :3], x[1, :3] = run.state[:3], run.state[3:]
        normal = contact_samples(run.model, np.array([begin]), run.state[None])[1][0]
    C, v, _ = mass_centre(p, x)
    V = np.concatenate([v, angular_velocity(x[0, :3], x[1, :3])])
    body = insertion.body(begin, C, rotation(x[0, :3]), V, normal)
    limits = plan.holder.force_limit, plan.holder.torque_limit
    passed, total = False, run.knots[-1]
    told = (lambda t: run.progress(t / total)) if run.progress else None  # type: ignore[misc]
    while not run.done():
        run.take_friction()
        insertion.take(run.model.p)
        end = run.stretch_end(("insert",))
        rows, body, run.t, ended = insertion.run(run.t, body, run.until(end), end, limits, told)
        if rows is not None:
            block = insertion_block(run.model.p, rows)
            run.blocks.append(block)
            below = (block["q"][:, 0] < run.model.p[7]) & block["closed"].any(axis=1)
            if not passed and below.any():
                passed = True
                k = int(below.argmax())
                run.events.append((float(rows.t[k]), "transition: the tilt is below gamma0"))
        if ended != "end":
            run.event(f"{ended} of the holder reached in the hole")
            run.ended_by = ended
    run.ended_by = run.ended_by or "end"


def place_program(
    phases: Sequence[PlanPhase], begin: np.ndarray, angles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the commanded angles and place of phases in the hole, as knots and quintics.

    Parameters
    ----------
    phases : sequence of PlanPhase
        All of kind `insert`.
    begin : ndarray, shape (3, 3)
        Place x, y and depth of the lower end's centre when they begin [m], with rates and
        accelerations.
    angles : ndarray, shape (n, 3, 6)
        Quintics of gamma, psi, phi in these phases.

    Returns
    -------
    knots : ndarray, shape (n + 1,)
        From the begin of the first [s].
    coefficients : ndarray, shape (n, 6, 6)

    """
    now, knots, pieces = begin.copy(), [0.0], []
    for phase, turning in zip(phases, angles, strict=True):
        end = np.zeros((3, 3))
        end[1, 2] = phase.depth_rate
        end[0, :2] = now[0, :2] if phase.place is None else phase.place
        mean = (now[1, 2] + end[1, 2]) / 2
        end[0, 2] = now[0, 2] + mean * phase.duration if phase.depth is None else phase.depth
        pieces.append(np.concatenate([turning, quintic(now, end, phase.duration)]))
        knots.append(knots[-1] + phase.duration)
        now = end
    return np.array(knots), np.array(pieces)


def end_motion(p: np.ndarray, x: np.ndarray) -> np.ndarray:
    """
    Return place x, y and depth of the lower end's centre, with rates and accelerations.

    Parameters
    ----------
    p : ndarray
        Scene.
    x : ndarray, shape (3, 6)
        Angles and offset from the touching pose with rates and accelerations.

    Returns
    -------
    ndarray, shape (3, 3)
        [m], [m/s], [m/s^2] as rows.

    """
    q, rates = x[0, :3].copy(), x[1, :3].copy()
    w, zeta = angular_velocity(q, rates), rotation(q)[:, 2]
    alpha = angular_acceleration(q, rates, x[2, :3].copy())
    lever = -p[2] * np.array(
        [zeta, np.cross(w, zeta), np.cross(alpha, zeta) + np.cross(w, np.cross(w, zeta))]
    )
    return (mass_centre(p, x) + lever) * [1.0, 1.0, -1.0]


def begin_of(knots: np.ndarray, coefficients: np.ndarray, p: np.ndarray, t: float) -> np.ndarray:
    """Return what `end_motion` does, of where a program of angles and offsets is at t [s]."""
    return end_motion(p, evaluate(knots, coefficients, t))


def euler_angles(R: np.ndarray) -> np.ndarray:
    """Return gamma, psi, phi of axes, shape (n, 3), psi and phi without jumps [rad]."""
    gamma = np.arctan2(np.hypot(R[:, 0, 2], R[:, 1, 2]), R[:, 2, 2])
    psi, phi = np.arctan2(-R[:, 1, 2], -R[:, 0, 2]), np.arctan2(-R[:, 2, 1], R[:, 2, 0])
    return np.column_stack([gamma, np.unwrap(psi), np.unwrap(phi)])


def euler_rates(q: np.ndarray, w: np.ndarray, alpha: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return rates and accelerations of gamma, psi, phi [rad/s], [rad/s^2], shape (n, 3) each.

    Parameters
    ----------
    q, w, alpha : ndarray, shape (n, 3)
        Angles, angular velocity and acceleration in hole axes.

    """
    s, c = np.maximum(np.sin(q[:, 0]), _UPRIGHT_SINE), np.cos(q[:, 0])
    sp, cp = np.sin(q[:, 1]), np.cos(q[:, 1])
    zero = np.zeros(len(q))
    h, eps = np.column_stack([cp, sp, zero]), np.column_stack([sp, -cp, zero])
    zeta = np.column_stack([-np.sin(q[:, 0]) * cp, -np.sin(q[:, 0]) * sp, c])

    def parts(v):
        slip = -(v * h).sum(axis=1) / s
        return np.column_stack([(v * eps).sum(axis=1), v[:, 2] - slip * c, slip])

    rates = parts(w)
    gyro = rates[:, :1] * rates[:, 1:2] * h + rates[:, 2:] * np.cross(w, zeta)
    return rates, parts(alpha - gyro)


def modes_of(
    normal: np.ndarray, azimuth: np.ndarray, above: np.ndarray, at_rim: np.ndarray
) -> np.ndarray:
    """
    Return the contact set of each sample.

    Parameters
    ----------
    normal, azimuth : ndarray, shape (n, 4)
        Load and azimuth of the slots of `hole_places` [N], [rad].
    above : ndarray of bool, shape (n,)
        Tilt above gamma0.
    at_rim : ndarray of bool, shape (n,)
        The edge touches so near below the rim that both are one contact.

    Returns
    -------
    ndarray of str, shape (n,)
        `open`; `one_point`; `two_point`: rim and edge on opposite sides, the edge perhaps at two
        neighbouring places; `line`: rim and edge on one side, what lies between touches as
        well; `three_point`: two places of the edge above gamma0; `unknown`: any other set.

    """
    loaded = normal > 0
    place = normal[:, :, None] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=2)
    edge = place[:, EDGE_SLOTS].sum(axis=1)
    every, K = np.arange(len(normal)), normal[:, RIM_SLOTS].argmax(axis=1)
    rim, other = place[every, K], place[every, 1 - K]
    with_edge = at_rim & ((other * edge).sum(axis=1) > 0) & ((other * rim).sum(axis=1) < 0)
    loaded[every, 1 - K] &= ~with_edge
    rims, edges = loaded[:, RIM_SLOTS].sum(axis=1), loaded[:, EDGE_SLOTS].sum(axis=1)
    one_edge = (edges == 1) | ((edges == 2) & (np.cos(azimuth[:, 2] - azimuth[:, 3]) > 0))
    opposite = (rim * edge).sum(axis=1) < 0
    mode = np.full(len(normal), "unknown", dtype="U12")
    mode[(rims == 0) & (edges == 0)] = "open"
    mode[((rims == 1) & (edges == 0)) | ((rims == 0) & one_edge)] = "one_point"
    both = (rims == 1) & one_edge
    mode[both & opposite] = "two_point"
    mode[both & ~opposite] = "line"
    mode[(rims == 1) & (edges == 2) & opposite & above] = "three_point"
    return mode


def insertion_block(p: np.ndarray, rows: InsertionRows) -> dict:
    """Return the samples; in the hole B1 and B2 carry half of what the edge does each."""
    n = len(rows.t)
    block = empty_block(rows.t, "unknown")
    q = euler_angles(rows.R)
    w, alpha = rows.V[:, 3:], rows.acceleration[:, 3:]
    block["q"] = q
    block["rates"], block["acceleration"] = euler_rates(q, w, alpha)
    block["turning"] = np.stack([w, alpha], axis=1)
    block["centre"] = np.stack([rows.C, rows.V[:, :3], rows.acceleration[:, :3]], axis=1)
    block["position"] = rows.C - p[2] * rows.R[:, :, 2]
    block["force"], block["moment"] = rows.force, rows.moment
    speed = np.linalg.norm(rows.slips, axis=2)
    block["hole_normal"], block["hole_azimuth"], block["hole_slip"] = (
        rows.normal,
        np.arctan2(np.sin(rows.azimuth), np.cos(rows.azimuth)),
        speed,
    )
    above = q[:, 0] > p[7]
    every = np.arange(n)
    K = rows.normal[:, RIM_SLOTS].argmax(axis=1)
    B = 2 + rows.normal[:, EDGE_SLOTS].argmax(axis=1)
    at_rim = rows.points[every, B, 2] > -_AT_RIM * p[1]
    block["mode"] = modes_of(rows.normal, rows.azimuth, above, at_rim)
    # Above gamma0 the edge meets the rim in B1 and B2: e is negative at B1.
    first = 2 + (np.sin(rows.azimuth[:, EDGE_SLOTS] - q[:, 1:2])).argmin(axis=1)
    of = {0: (K, K), 1: (first, B), 2: (5 - first, B)}
    for contact, (upper, lower) in of.items():
        slot = np.where(above, upper, lower)
        block["contact_point"][:, contact] = rows.points[every, slot]
        block["slip_speed"][:, contact] = speed[every, slot]
    total, loads = _by_side(rows, K)
    block["normal"][:, 0], block["contact_force"][:, 0] = loads[0], total[0]
    for contact, slot in ((1, first), (2, 5 - first)):
        block["normal"][:, contact] = np.where(above, rows.normal[every, slot], loads[1] / 2)
        block["contact_force"][:, contact] = np.where(
            above[:, None], rows.forces[every, slot], total[1] / 2
        )
    block["closed"] = block["normal"] > 0
    return block


def _by_side(rows, K):
    """Return forces and loads of K, and of B: the edge, and the rim across from K."""
    every = np.arange(len(K))
    across = np.cos(rows.azimuth[:, 0] - rows.azimuth[:, 1]) < 0
    total, loads = [], []
    for values, found in ((rows.forces, total), (rows.normal, loads)):
        other = values[every, 1 - K]
        apart = across.reshape(-1, *[1] * (other.ndim - 1))
        found.append(values[every, K] + np.where(apart, 0, other))
        found.append(values[:, EDGE_SLOTS].sum(axis=1) + np.where(apart, other, 0))
    return total, loads
