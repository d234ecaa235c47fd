"""
What truly happened in an insertion: read off motion, loads and contacts, and off nothing else.

Stuck is a peg that is pushed and does not move along the hole. Whether the push is to blame, or
forces that are locked in between two contacts, is told by Whitney's diagram, of the true wrench,
and by how much of the true load on the rim that wrench asks for.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog

from benchmarks.harness.events import stretches
from peg_on_hole_ros.mechanics.whitney import jamming_margin

# Slower along the hole [m/s]: at rest. Strains of the contacts alone are a tenth of it.
STILL = 5e-5
# Pushed into the hole by more [N], the weight counted in.
PUSHED = 5.0
# Shorter stops [s] are none, and shorter interruptions of one do not end it.
SHORTEST, INTERRUPTED = 0.03, 0.01
# Farther on [m] behind a stop: freed.
FREED = 2e-4
# So many times the load on the rim that the wrench asks for is locked in.
LOCKED = 1.5


class Stop(NamedTuple):
    """
    A peg stuck in the hole.

    Attributes
    ----------
    cause : str
        `wedged`: the push lies inside of Whitney's diagram, or rim and edge squeeze the peg by
        more than LOCKED times what balances the wrench. `jammed`: else.
    begin, end : float
        [s]
    freed : bool
        Whether it went on into the hole.

    """

    cause: str
    begin: float
    end: float
    freed: bool


class InsertionLabels(NamedTuple):
    """
    The truth of an insertion as it is scored.

    Attributes
    ----------
    t : ndarray, shape (n,)
        [s]
    mode : ndarray of str, shape (n,)
    stuck : ndarray of bool, shape (n,)
    push, margin : ndarray, shape (n,)
        Along the hole, the weight counted in; what is left of it by Whitney, and by friction of
        the side load where not two points touch; NaN where the lower end is not in the hole [N].
    transition : float or None
        When the tilt first fell below gamma0 in contact [s].
    events : tuple of Stop

    """

    t: np.ndarray
    mode: np.ndarray
    stuck: np.ndarray
    push: np.ndarray
    margin: np.ndarray
    transition: float | None
    events: tuple[Stop, ...]


def labels_of(truth) -> InsertionLabels:
    """Return the labels of a truth."""
    t, scene = truth.t_ns * 1e-9, truth.plan.configuration.scene
    push, margin = _whitney(truth)
    touches = truth.closed.any(axis=1)
    still = touches & (np.abs(truth.place_rate[:, 2]) < STILL) & (push > PUSHED)
    stuck = np.zeros(len(t), bool)
    events = []
    for first, last in _joined(stretches(still), t):
        if t[last] - t[first] < SHORTEST:
            continue
        stuck[first : last + 1] = True
        wedged = np.nanmedian(margin[first : last + 1]) > 0 or _locked(truth, (first + last) // 2)
        went_on = truth.place[last:, 2].max() - truth.place[last, 2] > FREED
        events.append(Stop("wedged" if wedged else "jammed", t[first], t[last], bool(went_on)))
    below = (truth.q[:, 0] < scene.gamma0) & touches
    transition = float(t[below.argmax()]) if below.any() else None
    return InsertionLabels(t, truth.mode, stuck, push, margin, transition, tuple(events))


def _load(truth):
    """Return force and moment about the lower end's centre, the weight counted in, (n, 3) each."""
    scene = truth.plan.configuration.scene
    load = truth.force + scene.peg_mass * np.asarray(scene.gravity)
    return load, truth.moment + np.cross(truth.centre[:, 0] - truth.position, load)


def _locked(truth, k):
    """Return whether the rim carries more than the wrench asks for, in the plane of the tilt."""
    f, psi = friction_of(truth)[k], truth.q[k, 1]
    h, z = np.array([np.cos(psi), np.sin(psi), 0.0]), np.array([0.0, 0.0, 1.0])
    load, moment = (part[k] for part in _load(truth))
    across = np.cross(h, z)
    columns = []
    for contact in (0, 1):
        arm = truth.contact_point[k, contact] - truth.position[k]
        normal = truth.contact_force[k, contact] @ h
        for along in (f, -f):
            force = np.sign(normal) * h + along * z
            columns.append([force @ h, force @ z, np.cross(arm, force) @ across])
    rows = np.array(columns).T
    wanted = -np.array([load @ h, load @ z, moment @ across])
    scale = np.array([1.0, 1.0, 2.0 / truth.plan.configuration.scene.peg_diameter])
    # Along the normal of both cone edges the rim carries the sum of their shares.
    least = linprog([1, 1, 0, 0], A_eq=rows * scale[:, None], b_eq=wanted * scale)
    return least.status == 0 and truth.normal[k, 0] > LOCKED * least.fun


def _whitney(truth):
    """Return push and margin [N], in the plane of the tilt."""
    scene = truth.plan.configuration.scene
    load, moment = _load(truth)
    push, friction = -load[:, 2], friction_of(truth)
    length = truth.place[:, 2] + scene.peg_diameter / 2 * np.sin(truth.q[:, 0])
    margin = np.full(len(push), np.nan)
    for k in np.flatnonzero(length > 0):
        if truth.mode[k] != "two_point":
            # A side load in any direction, and nothing that a moment could press.
            margin[k] = push[k] - friction[k] * np.hypot(load[k, 0], load[k, 1])
            continue
        tilt = truth.q[k, 1]
        h = np.array([np.cos(tilt), np.sin(tilt)])
        # Of the diagram: x along h, and the moment that tilts towards it.
        F_x = load[k, :2] @ h
        M = moment[k, 0] * h[1] - moment[k, 1] * h[0]
        margin[k] = jamming_margin(scene.peg_diameter / 2, length[k], friction[k], F_x, push[k], M)
    return push, margin


def friction_of(truth) -> np.ndarray:
    """Return the true friction coefficient at every sample, shape (n,)."""
    now, of = truth.plan.configuration.scene.friction, {}
    for phase in truth.plan.phases:
        now = now if phase.friction is None else phase.friction
        of[phase.name] = now
    return np.array([of[name] for name in truth.phase])


def _joined(spans, t):
    out = []
    for first, last in spans:
        if out and t[first] - t[out[-1][1]] < INTERRUPTED:
            out[-1] = (out[-1][0], last)
        else:
            out.append((first, last))
    return out
