"""
What truly happened in an insertion: read off motion, loads and contacts, and off nothing else.

Stuck is a peg that is pushed and does not move along the hole. Whether the push is to blame, or
forces that are locked in between two contacts, is told by Whitney's diagram, of the true wrench.
"""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.whitney import jamming_margin

# Slower along the hole [m/s]: at rest. Strains of the contacts alone are a tenth of it.
STILL = 5e-5
# Pushed into the hole by more [N], the weight counted in.
PUSHED = 5.0
# Shorter stops [s] are none, and shorter interruptions of one do not end it.
SHORTEST, INTERRUPTED = 0.03, 0.01
# Farther on [m] behind a stop: freed.
FREED = 2e-4


class Stop(NamedTuple):
    """
    A peg stuck in the hole.

    Attributes
    ----------
    cause : str
        `jammed`: the push lies outside of Whitney's diagram. `wedged`: inside, and the peg rests.
    begin, end : float
        [s]
    freed : bool
        Whether it went on into the hole.

    """

    cause: str
    begin: float
    end: float
    freed: bool


class Labels(NamedTuple):
    """
    The truth of an insertion as it is scored.

    Attributes
    ----------
    t : ndarray, shape (n,)
        [s]
    mode : ndarray of str, shape (n,)
    stuck : ndarray of bool, shape (n,)
    push, margin : ndarray, shape (n,)
        Along the hole, the weight counted in; what is left of it by Whitney, NaN where the lower
        end is not in the hole [N].
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


def labels_of(truth) -> Labels:
    """Return the labels of a truth."""
    t, scene = truth.t_ns * 1e-9, truth.plan.configuration.scene
    push, margin = _whitney(truth)
    touches = truth.closed.any(axis=1)
    still = touches & (np.abs(truth.place_rate[:, 2]) < STILL) & (push > PUSHED)
    stuck = np.zeros(len(t), bool)
    events = []
    for first, last in _joined(_stretches(still), t):
        if t[last] - t[first] < SHORTEST:
            continue
        stuck[first : last + 1] = True
        inside = np.nanmedian(margin[first : last + 1]) > 0
        went_on = truth.place[last:, 2].max() - truth.place[last, 2] > FREED
        events.append(Stop("wedged" if inside else "jammed", t[first], t[last], bool(went_on)))
    below = (truth.q[:, 0] < scene.gamma0) & touches
    transition = float(t[below.argmax()]) if below.any() else None
    return Labels(t, truth.mode, stuck, push, margin, transition, tuple(events))


def _whitney(truth):
    """Return push and margin [N], in the plane of the side load and the moment."""
    scene = truth.plan.configuration.scene
    load = truth.force + scene.peg_mass * np.asarray(scene.gravity)
    # About the centre of the lower end.
    moment = truth.moment + np.cross(truth.centre[:, 0] - truth.position, load)
    push, friction = -load[:, 2], friction_of(truth)
    length = truth.place[:, 2] + scene.peg_diameter / 2 * np.sin(truth.q[:, 0])
    margin = np.full(len(push), np.nan)
    for k in np.flatnonzero(length > 0):
        tilt = truth.q[k, 1]
        h = np.array([np.cos(tilt), np.sin(tilt)])
        # Of the diagram: x along h, and the moment that tilts towards it.
        F_x = load[k, :2] @ h
        M = moment[k, 0] * h[1] - moment[k, 1] * h[0]
        margin[k] = jamming_margin(
            scene.peg_diameter / 2, length[k], friction[k], F_x, push[k], M
        )
    return push, margin


def friction_of(truth) -> np.ndarray:
    """Return the true friction coefficient at every sample, shape (n,)."""
    now, of = truth.plan.configuration.scene.friction, {}
    for phase in truth.plan.phases:
        now = now if phase.friction is None else phase.friction
        of[phase.name] = now
    return np.array([of[name] for name in truth.phase])


def _stretches(chosen):
    padded = np.concatenate([[False], chosen, [False]]).astype(int)
    edges = np.flatnonzero(np.diff(padded))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _joined(spans, t):
    out = []
    for first, last in spans:
        if out and t[first] - t[out[-1][1]] < INTERRUPTED:
            out[-1] = (out[-1][0], last)
        else:
            out.append((first, last))
    return out
