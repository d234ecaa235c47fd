"""Samples of one stretch of the truth, each kind of motion in the same columns."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import nnls

from peg_on_hole_ros.sim.command import evaluate
from peg_on_hole_ros.sim.contact_run import Model, contact_samples
from peg_on_hole_ros.sim.dynamics import (
    angular_acceleration,
    angular_velocity,
    contacts,
    rotation,
)
from peg_on_hole_ros.sim.guided import (
    Guidance,
    guided_contacts,
    guided_state,
    hole_axes,
    newton_euler,
)
from peg_on_hole_ros.sim.holder import holder_wrench, mass_centre
from peg_on_hole_ros.sim.parted import parted_motion, pushes

# Share of the load that may stay unbalanced: rounding.
REST_TOLERANCE = 1e-6
# Edges of the pyramid inside each friction cone; it holds up to 1 % less than the cone.
_EDGES = 24
# Reactions that fade are called contact above it [N].
FREE_LOAD = 0.1

_SHAPES = {
    "t": (),
    "q": (3,),
    "rates": (3,),
    "acceleration": (3,),
    "position": (3,),
    "centre": (3, 3),
    "normal": (3,),
    "slip_speed": (3,),
    "closed": (3,),
    "known": (),
    "contact_point": (3, 3),
    "contact_force": (3, 3),
    "force": (3,),
    "moment": (3,),
    "mode": (),
    "gap": (3,),
    "turning": (2, 3),
    "hole_normal": (4,),
    "hole_azimuth": (4,),
    "hole_slip": (4,),
}


def empty_block(t: np.ndarray, mode: str) -> dict:
    """Return samples at times [s] in one mode, whose columns are zero."""
    block = {name: np.zeros((len(t), *shape)) for name, shape in _SHAPES.items()}
    block["t"] = np.asarray(t, float)
    block["closed"] = np.zeros((len(t), 3), bool)
    block["known"] = np.ones(len(t), bool)
    block["mode"] = np.full(len(t), mode, dtype="U12")
    return block


def _pose(p, block, i, x):
    centre = mass_centre(p, x)
    block["q"][i], block["rates"][i], block["acceleration"][i] = x[:, :3]
    q, rates, acceleration = x[0, :3].copy(), x[1, :3].copy(), x[2, :3].copy()
    block["turning"][i] = angular_velocity(q, rates), angular_acceleration(q, rates, acceleration)
    block["centre"][i] = centre
    block["position"][i] = centre[0] - p[2] * rotation(x[0, :3])[:, 2]


def _gaps(p, x):
    """
    Return how far a guided peg is off its three touching points, to first order, shape (3,) [m].

    Far above the rim that underrates the distance at K only, which is positive there.

    """
    if x[0, 0] <= p[7]:
        return np.zeros(3)
    _, _, normals, _ = contacts(p, x[0, :3], np.zeros(3), 1.0)
    return normals @ x[0, 3:]


def joined(blocks: list[dict]) -> dict:
    """Return one block of several; K, B1 and B2 stand among the places of the hole, too."""
    for block in blocks:
        if block["hole_normal"].any():
            continue
        points = block["contact_point"]
        for slot, contact in ((0, 0), (2, 1), (3, 2)):
            block["hole_normal"][:, slot] = block["normal"][:, contact]
            block["hole_slip"][:, slot] = block["slip_speed"][:, contact]
            block["hole_azimuth"][:, slot] = np.arctan2(
                points[:, contact, 1], points[:, contact, 0]
            )
    return {name: np.concatenate([block[name] for block in blocks]) for name in _SHAPES}


def contact_block(model: Model, t: np.ndarray, states: np.ndarray) -> dict:
    """Return the samples of a motion on three contacts."""
    block = empty_block(t, "three_point")
    acceleration, normal, force, moment = contact_samples(model, t, states)
    block["normal"], block["force"], block["moment"] = normal, force, moment
    block["closed"][:] = True
    for i, state in enumerate(states):
        x = np.zeros((3, 6))
        x[0, :3], x[1, :3], x[2, :3] = state[:3], state[3:], acceleration[i]
        _pose(model.p, block, i, x)
        points, velocity, direction, _ = contacts(model.p, state[:3], state[3:], model.scale)
        block["slip_speed"][i] = np.linalg.norm(velocity, axis=1)
        for k in range(3):
            block["contact_point"][i, k] = hole_axes(state[1], points[k])
            block["contact_force"][i, k] = hole_axes(state[1], normal[i, k] * direction[k])
    return block


def parted_block(model: Model, t: np.ndarray, states: np.ndarray, stiffness: float) -> dict:
    """Return the samples of a motion in which contacts come and go."""
    block = empty_block(t, "unknown")
    for i, y in enumerate(states):
        x = np.zeros((3, 6))
        x[0], x[1] = y[:6], y[6:]
        motion = parted_motion(t[i], y, *model, stiffness)
        x[2] = motion[:6]
        _pose(model.p, block, i, x)
        block["gap"][i] = _gaps(model.p, x)
        block["force"][i], block["moment"][i] = motion[6:9], motion[9:]
        points, forces, normal, slip = pushes(model.p, x, model.scale, stiffness)
        block["contact_point"][i], block["contact_force"][i] = points, forces
        block["normal"][i], block["closed"][i], block["slip_speed"][i] = normal, normal > 0, slip
    block["mode"][block["closed"].all(axis=1)] = "three_point"
    block["mode"][~block["closed"].any(axis=1)] = "open"
    return block


def guided_block(
    model: Model,
    t: np.ndarray,
    guidance: Guidance | None,
    load: tuple | None,
    mode: str,
    fade_time: float,
    begin: float,
) -> dict:
    """
    Return the samples of a guided motion.

    Parameters
    ----------
    model : Model
    t : ndarray
        [s]
    guidance : Guidance or None
    load : tuple or None
        None: nothing touches. (normal, 0, None): reactions that fade within `fade_time` at the
        three contacts. (None, 1 or 2, quintics): reactions at K and at B1 or B2.
    mode : str
    fade_time, begin : float
        [s]

    """
    block = empty_block(t, mode)
    p = model.p
    for i, ti in enumerate(t):
        x = guided_state(model.knots, model.coefficients, guidance, ti)
        _pose(p, block, i, x)
        block["gap"][i] = _gaps(p, x)
        points, forces = np.zeros((3, 3)), np.zeros((3, 3))
        if load is not None and load[2] is None:
            u = min((ti - begin) / fade_time, 1.0)
            normal = load[0] * (1 - u**3 * (10 - 15 * u + 6 * u * u))
            points, velocity, direction, _ = contacts(p, x[0, :3], x[1, :3], model.scale)
            for k in range(3):
                points[k] = hole_axes(x[0, 1], points[k])
                forces[k] = hole_axes(x[0, 1], normal[k] * direction[k])
            block["slip_speed"][i] = np.linalg.norm(velocity, axis=1)
            block["normal"][i], block["closed"][i] = normal, normal > 0
            if normal.sum() < FREE_LOAD:
                block["mode"][i] = "open"
        elif load is not None:
            normal = np.zeros(3)
            normal[[0, load[1]]] = evaluate(np.zeros(1), load[2][None], ti - begin)[0]
            points, forces, slip = guided_contacts(p, x, load[1], normal, model.scale)
            block["slip_speed"][i] = slip
            block["normal"][i], block["closed"][i] = normal, normal > 0
        block["contact_point"][i], block["contact_force"][i] = points, forces
        block["force"][i], block["moment"][i] = newton_euler(p, x, points, forces)
    return block


def wedged_block(
    model: Model, t: np.ndarray, state: np.ndarray, limits: Sequence[float]
) -> tuple[dict, bool, str]:
    """
    Return the samples of a wedged peg at rest under the holder, if it stays, and what ended them.

    The peg stays as long as forces inside the friction cones can balance the holder; which of
    them act is not determined, so they are not given.

    """
    p = model.p
    x = np.zeros((3, 6))
    x[0, :3] = state[:3]
    still = np.zeros(6)
    still[:3] = state[:3]
    force, moment = [], []
    stays, reason = True, "still carried the load when the program was over"
    for ti in t:
        F, M = holder_wrench(p, model.holder, evaluate(model.knots, model.coefficients, ti), still)
        if np.linalg.norm(F) > limits[0] or np.linalg.norm(M) > limits[1]:
            reason = (
                f"stayed until the holder's limit: {np.linalg.norm(F):.1f} N, "
                f"{np.linalg.norm(M):.2f} N m"
            )
            break
        if _rest_residual(p, state[:3], F, M) > REST_TOLERANCE:
            stays, reason = (
                False,
                (
                    f"cannot stay under {np.linalg.norm(F):.1f} N, {np.linalg.norm(M):.2f} N m: "
                    "the simulation ends"
                ),
            )
            break
        force.append(F)
        moment.append(M)
    block = empty_block(t[: len(force)], "unknown")
    block["known"][:] = False
    points, _, _, _ = contacts(p, still[:3], still[3:], model.scale)
    for i in range(len(force)):
        _pose(p, block, i, x)
        block["force"][i], block["moment"][i] = force[i], moment[i]
        for k in range(3):
            block["contact_point"][i, k] = hole_axes(state[1], points[k])
    return block, stays, reason


def _rest_residual(p, q, F, M):
    """
    Return how much of a load three contacts at rest cannot balance, as a share of it.

    Zero: there are forces inside the friction cones that balance it, so rest is a solution (they
    are not unique: nine components, six equations). F and M are the holder's, about the mass
    centre, hole axes [N], [N m].
    """
    points, _, normals, _ = contacts(p, np.asarray(q, float), np.zeros(3), 1.0)
    at_rest = np.zeros((3, 6))
    at_rest[0, :3] = q
    centre = mass_centre(p, at_rest)[0]
    columns = []
    # Metres become comparable with the force rows by the hole's radius.
    radius = p[1] / 2
    for point, normal in zip(points, normals, strict=True):
        point, normal = hole_axes(q[1], point), hole_axes(q[1], normal)
        a = np.cross(normal, [0.0, 0.0, 1.0])
        a /= np.linalg.norm(a)
        b = np.cross(normal, a)
        for angle in np.arange(_EDGES) * (2 * np.pi / _EDGES):
            force = normal + p[6] * (np.cos(angle) * a + np.sin(angle) * b)
            columns.append([*force, *np.cross(point - centre, force) / radius])
    load = np.concatenate([F + p[3] * p[8:11], M / radius])
    _, residual = nnls(np.array(columns).T, -load)
    return float(residual / max(np.linalg.norm(load), 1e-12))
