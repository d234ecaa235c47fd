"""
A contact beside the hole before a cycle: the peg hangs, comes down, presses, slides and lifts off.

It touches with one point of its lower edge, and nothing else touches: on the plate in a search,
or on the cone of a chamfer in an upright landing. The contact has a normal force, and friction
against the slide.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from benchmarks.harness.draw import Draw
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitor.states import Mode
from peg_on_hole_ros.sim.dynamics import rotation
from peg_on_hole_ros.sim.truth import Truth

SEED = 36_000
# A program's steps [s]: at rest for the tare, down, pressed, up, over the hole.
HANGS, COMES, LIFTS, TURNS = 2.0, 1.0, 0.6, 1.4
HIGH = 0.02  # [m]
FIRST, LAST = (0.005, 0.008), 0.002  # from the hole's centre [m]
# The lowest point leads outwards, so that it is on the plate and not over the hole.
ASIDE = 0.8  # [rad]
PUSH = (8.0, 20.0)  # [N]
FRICTION = (0.1, 0.3)
# Of an upright landing: how far the axis is from the hole's at first [m].
BESIDE_THROAT = (2e-4, 5e-4)
# What of that it slides down the cone before it lifts off.
SLIDES = 0.7
PLATE, PHASE = "elsewhere", "search"

# Peg axes at all stamps, shape (n, 3, 3), and where the lower end's centre is, (n, 3) [m].
Path = Callable[[Draw, Scene, np.ndarray, np.ndarray, float], np.ndarray]
# Normals, and edge points from the lower end's centre, each (n, 3), of a scene and the two above.
Contact = Callable[[Scene, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


class Beside(NamedTuple):
    """
    A kind of contact beside the hole.

    Attributes
    ----------
    lasts : tuple of float
        Range of how long it presses [s].
    tilt : tuple of float
        Range of the tilt [rad].
    path : callable
        Where the lower end's centre is while it touches [m].
    contact : callable
        Where and against what it touches.
    settles : float
        How long after the first touch a mode may be another one [s].
    right : tuple of Mode
        Modes that may be published while it touches.

    """

    lasts: tuple[float, float]
    tilt: tuple[float, float]
    path: Path
    contact: Contact
    settles: float
    right: tuple[Mode, ...]


def with_contact(truth: Truth, number: int, kind: Beside) -> Truth:
    """Return a cycle that begins with a contact beside the hole, the same of a number."""
    draw, scene = Draw([SEED, number]), truth.plan.configuration.scene
    tilt, psi = draw.even(*kind.tilt), draw.even(-3.0, 3.0)
    searched = np.array([tilt, psi, draw.even(-0.5, 0.5)])
    pressed = draw.even(*kind.lasts)
    step = float(np.median(np.diff(truth.t_ns))) * 1e-9
    ends = np.cumsum([HANGS, COMES, pressed, LIFTS, TURNS])
    t = np.arange(0.0, ends[-1] - 0.5 * step, step)
    comes, _, lifts, turns = (
        smooth((t - begin) / (end - begin)) for begin, end in zip(ends, ends[1:])
    )
    first, last = searched, truth.q[0].copy()
    last[1:] = first[1:] + (last[1:] - first[1:] + np.pi) % (2 * np.pi) - np.pi
    q = first + turns[:, None] * (last - first)
    peg = np.array([rotation(each) for each in q])
    place = kind.path(draw, scene, peg, t - ends[1], pressed)
    normal, edge = kind.contact(scene, peg, place)
    place[:, 2] += HIGH * (1.0 - comes + lifts)
    place += turns[:, None] * (truth.position[0] - place)
    touches = (t > ends[1]) & (t <= ends[2])
    # A push is there and gone within 50 ms.
    push = draw.even(*PUSH) * touches * smooth((t - ends[1]) / 0.05) * smooth((ends[2] - t) / 0.05)
    before = _rows(truth, t, q, peg, place)
    force = _force(place, t, push, normal, draw.even(*FRICTION))
    before["force"] -= force
    before["moment"] -= np.cross(edge - scene.mass_center_height * peg[:, :, 2], force)
    before["mode"] = np.where(push > 0.0, PLATE, "open")
    return _joined(before, truth, round((t[-1] + step) * 1e9))


def smooth(share: np.ndarray) -> np.ndarray:
    """Return a share of a way from 0 to 1 that begins and ends at rest."""
    s = np.clip(share, 0.0, 1.0)
    result: np.ndarray = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    return result


def _on_plate(draw, scene, peg, t, pressed):
    """Return where the lower end's centre is so that the lowest point touches the plate."""
    outwards = np.arctan2(-peg[0, 2, 1], -peg[0, 2, 0])
    lowest = peg[0] @ [np.cos(outwards), np.sin(outwards), 0.0]
    about, swings = np.arctan2(lowest[1], lowest[0]), draw.even(0.3, 0.8)
    share = smooth(t / pressed)
    away = draw.even(*FIRST) * (1.0 - share) + LAST * share
    way = about + ASIDE * np.sin(2 * np.pi * swings * np.clip(t, 0.0, pressed)) * smooth(t / 0.5)
    height = 0.5 * scene.peg_diameter * np.hypot(peg[0, 2, 0], peg[0, 2, 1])
    return np.column_stack([away * np.cos(way), away * np.sin(way), np.full(len(t), height)])


def _plate(scene, peg, place):
    """Return normals along the hole, and the lowest points of the lower edge."""
    axis = peg[:, :, 2]
    # Downwards in the plane of the lower end.
    along = axis * axis[:, 2:] - [0.0, 0.0, 1.0]
    size = np.maximum(np.linalg.norm(along, axis=1), 1e-9)
    edge = 0.5 * scene.peg_diameter * along / size[:, None]
    return np.tile([0.0, 0.0, 1.0], (len(peg), 1)), edge


def _down_a_cone(draw, scene, peg, t, pressed):
    """Return where the lower end's centre is as the edge slides down a cone of 45 degrees."""
    way, gap = draw.even(-3.0, 3.0), 0.5 * (scene.hole_diameter - scene.peg_diameter)
    first = draw.even(*BESIDE_THROAT)
    away = first - SLIDES * (first - gap) * np.clip(t / pressed, 0.0, 1.0)
    across = away[:, None] * [np.cos(way), np.sin(way)]
    height = np.linalg.norm(_towards_cone(scene, peg, across), axis=1) - gap
    return np.column_stack([across, height])


def _towards_cone(scene, peg, across):
    """Return the direction of the edge point that is deepest in a cone, times its depth [m]."""
    return across - 0.5 * scene.peg_diameter * peg[:, 2, :2]


def _cone(scene, peg, place):
    """Return normals of a cone of 45 degrees about the hole, and the points that touch it."""
    towards = _towards_cone(scene, peg, place[:, :2])
    towards = towards / np.linalg.norm(towards, axis=1)[:, None]
    normal = np.column_stack([-towards, np.ones(len(peg))]) / np.sqrt(2.0)
    # The point of the lower edge that leads that way.
    turned = np.einsum("nji,nj->ni", peg[:, :2, :], towards)[:, :2]
    turned = turned / np.linalg.norm(turned, axis=1)[:, None]
    return normal, 0.5 * scene.peg_diameter * np.einsum("nij,nj->ni", peg[:, :, :2], turned)


# A push is there after 50 ms, and a mode is declared 50 ms later.
SEARCH = Beside((4.0, 7.0), (0.01, 0.2), _on_plate, _plate, 0.1, (Mode.ELSEWHERE, Mode.UNKNOWN))
# A peg rests on a cone for 20 to 110 ms; 50 ms more belong to the rise and fall of the push.
LANDING = Beside(
    (0.07, 0.16), (0.001, 0.03), _down_a_cone, _cone,
    0.0, (Mode.OPEN, Mode.ELSEWHERE, Mode.UNKNOWN),
)  # fmt: skip


def _force(place, t, push, normal, friction):
    """Return the force on the peg, shape (n, 3) [N]."""
    slid = np.gradient(place, t, axis=0)
    slid = slid - (slid * normal).sum(axis=1)[:, None] * normal
    # Friction is that of a slide from a fraction of a millimetre a second on.
    speed = np.sqrt((slid**2).sum(axis=1) + 1e-8)
    force: np.ndarray = push[:, None] * (normal - friction * slid / speed[:, None])
    return force


def _rows(truth, t, q, peg, place):
    """Return the samples before a cycle, with what the holder has to do where nothing touches."""
    scene: Scene = truth.plan.configuration.scene
    rates = np.gradient(q, t, axis=0)
    centre = place + scene.mass_center_height * peg[:, :, 2]
    velocity = np.gradient(centre, t, axis=0)
    acceleration = np.gradient(velocity, t, axis=0)
    n = len(t)
    return {
        "t_ns": np.round(t * 1e9).astype(np.int64),
        "q": q,
        "rates": rates,
        "acceleration": np.gradient(rates, t, axis=0),
        "position": place,
        "centre": np.stack([centre, velocity, acceleration], axis=1),
        # The turn towards the cycle is slow: its inertia is left out.
        "force": scene.peg_mass * (acceleration - np.asarray(scene.gravity)),
        "moment": np.zeros((n, 3)),
        "known": np.zeros(n, bool),
        "closed": np.zeros((n, 3), bool),
        "phase": np.full(n, PHASE),
    }


def _joined(before, truth, later_ns):
    n = len(before["t_ns"])
    columns = {}
    for name, values in vars(truth).items():
        if not isinstance(values, np.ndarray):
            continue
        rows = before.get(name)
        if rows is None:
            rows = np.zeros((n, *values.shape[1:]), values.dtype)
        after = values + later_ns if name == "t_ns" else values
        columns[name] = np.concatenate([rows, after])
    events = tuple((t + later_ns, text) for t, text in truth.events)
    return replace(truth, events=events, **columns)


def rows_of(truth: Truth, first: int, end: int | None = None) -> Truth:
    """Return a part of the truth, with stamps from zero."""
    begin = int(truth.t_ns[first])
    columns = {k: v[first:end] for k, v in vars(truth).items() if isinstance(v, np.ndarray)}
    columns["t_ns"] = columns["t_ns"] - begin
    events = tuple((t - begin, text) for t, text in truth.events)
    return replace(truth, events=events, **columns)
