"""
A search on the plate before a cycle: the peg hangs, comes down beside the hole, presses, slides.

It touches with the lowest point of its lower edge, on the plate beside the hole, and nothing else
touches. The contact is a plane's: a normal force along the hole, and friction against the slide.
"""

from dataclasses import replace

import numpy as np

from benchmarks.harness.draw import Draw
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.dynamics import rotation
from peg_on_hole_ros.sim.truth import Truth

SEED = 36_000
# A program's steps [s]: at rest for the tare, down, pressed, up, over the hole.
HANGS, COMES, LIFTS, TURNS = 2.0, 1.0, 0.6, 1.4
LASTS = (4.0, 7.0)
HIGH = 0.02  # [m]
FIRST, LAST = (0.005, 0.008), 0.002  # from the hole's centre [m]
# The lowest point leads outwards, so that it is on the plate and not over the hole.
ASIDE = 0.8  # [rad]
PUSH = (8.0, 20.0)  # [N]
FRICTION = (0.1, 0.3)
TILT = (0.01, 0.2)  # [rad]
PLATE, PHASE = "elsewhere", "search"


def with_search(truth: Truth, number: int) -> Truth:
    """Return a cycle that begins with a search; the same number gives the same one."""
    draw, scene = Draw([SEED, number]), truth.plan.configuration.scene
    tilt, psi = draw.even(*TILT), draw.even(-3.0, 3.0)
    searched = np.array([tilt, psi, draw.even(-0.5, 0.5)])
    pressed = draw.even(*LASTS)
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
    place = _path(draw, scene, peg, t - ends[1], pressed)
    place[:, 2] += HIGH * (1.0 - comes + lifts)
    place += turns[:, None] * (truth.position[0] - place)
    touches = (t > ends[1]) & (t <= ends[2])
    # A push is there and gone within 50 ms.
    push = draw.even(*PUSH) * touches * smooth((t - ends[1]) / 0.05) * smooth((ends[2] - t) / 0.05)
    before = _rows(truth, t, q, peg, place, push, draw.even(*FRICTION))
    return _joined(before, truth, round((t[-1] + step) * 1e9))


def smooth(share: np.ndarray) -> np.ndarray:
    """Return a share of a way from 0 to 1 that begins and ends at rest."""
    s = np.clip(share, 0.0, 1.0)
    result: np.ndarray = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    return result


def _path(draw, scene, peg, t, pressed):
    """Return where the lower end's centre is so that the lowest point touches the plate."""
    outwards = np.arctan2(-peg[0, 2, 1], -peg[0, 2, 0])
    lowest = peg[0] @ [np.cos(outwards), np.sin(outwards), 0.0]
    about, swings = np.arctan2(lowest[1], lowest[0]), draw.even(0.3, 0.8)
    share = smooth(t / pressed)
    away = draw.even(*FIRST) * (1.0 - share) + LAST * share
    way = about + ASIDE * np.sin(2 * np.pi * swings * np.clip(t, 0.0, pressed)) * smooth(t / 0.5)
    height = 0.5 * scene.peg_diameter * np.hypot(peg[0, 2, 0], peg[0, 2, 1])
    return np.column_stack([away * np.cos(way), away * np.sin(way), np.full(len(t), height)])


def _rows(truth, t, q, peg, place, push, friction):
    """Return the samples of the search, with what the holder has to do for it."""
    scene: Scene = truth.plan.configuration.scene
    rates = np.gradient(q, t, axis=0)
    axis = peg[:, :, 2]
    up = scene.mass_center_height * axis
    centre = place + up
    velocity = np.gradient(centre, t, axis=0)
    acceleration = np.gradient(velocity, t, axis=0)
    slid = np.gradient(place, t, axis=0)[:, :2]
    # Friction is that of a slide from a fraction of a millimetre a second on.
    speed = np.sqrt((slid**2).sum(axis=1) + 1e-8)
    force = np.column_stack([-friction * push[:, None] * slid / speed[:, None], push])
    # Downwards in the plane of the lower end.
    along = axis * axis[:, 2:] - [0.0, 0.0, 1.0]
    size = np.maximum(np.linalg.norm(along, axis=1), 1e-9)
    arm = -up + 0.5 * scene.peg_diameter * along / size[:, None]
    n = len(t)
    return {
        "t_ns": np.round(t * 1e9).astype(np.int64),
        "q": q,
        "rates": rates,
        "acceleration": np.gradient(rates, t, axis=0),
        "position": place,
        "centre": np.stack([centre, velocity, acceleration], axis=1),
        # The turn towards the cycle is slow: its inertia is left out.
        "force": scene.peg_mass * (acceleration - np.asarray(scene.gravity)) - force,
        "moment": -np.cross(arm, force),
        "known": np.zeros(n, bool),
        "closed": np.zeros((n, 3), bool),
        "mode": np.where(push > 0.0, PLATE, "open"),
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
