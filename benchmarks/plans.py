"""
Hold plans, and what they say of plain closing, against simulation in drawn cells.

Each cell draws peg, clearance, friction with its spread, holder, limits and rates. The plan is
made of what is stated; friction and clearance that hold in the simulation are drawn from their
spread. Plain closing and the plan are then simulated, led by the same holder, and told apart by
what came first: a wedge, a load beyond its limit, a contact that parts, or nothing.
"""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.harness.draw import Draw
from benchmarks.harness.family import ESTIMATE, Family, Report
from benchmarks.harness.tables import table
from peg_on_hole_ros.config.options import Configuration, WrenchInput
from peg_on_hole_ros.mechanics.planning.cell import Cell
from peg_on_hole_ros.mechanics.planning.search import judge, plan_motion
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.command import evaluate
from peg_on_hole_ros.sim.contact_run import Start, contact_samples, run_contact
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.run import NEAR_TRANSITION, Run

# Before the recording [s], in which the simulated peg comes to lie on its contacts.
LEAD_IN = 0.15
# Simulated at a time [s].
PIECE = 0.03
# Of the integrator.
RTOL = 1e-6
# The last stage is led on below gamma0 [rad].
BEYOND = 0.02
OUTCOMES = ("through", "wedge", "overload", "parts", "holder", "chatters")
# Steps of the integrator per second of motion beyond which the peg chatters on its contacts, and
# a number that every motion may have.
STEPS, STEPS_FREE = 2000, 8000
_CAUSES = {
    "K": "overload",
    "B1": "overload",
    "B2": "overload",
    "PARTS": "parts",
    "CHATTERS": "chatters",
}


class Drawn(NamedTuple):
    """A cell: what is stated, limits, and what is true."""

    scene: Scene
    cell: Cell
    max_normal: tuple[float, float, float]
    true: Scene


def cell_of(number: int, seed: int = 0, looser: float = 1.0, bare: bool = False) -> Drawn:
    """
    Return a cell; the same numbers give the same cell.

    Parameters
    ----------
    number, seed : int
    looser : float
        Factor on the load limits.
    bare : bool
        Whether the peg is a cylinder of 30 mm at least that no tool makes heavier: such wedge.

    """
    draw = Draw([8_200, seed, number])
    D = draw.log(0.030 if bare else 0.010, 0.100)
    clearance = D * draw.log(5e-4, 1e-2)
    # With the tool that grips it the peg is no cylinder.
    mass, height = draw.log(0.3, 3.0), D * draw.even(1.0, 2.0)
    scene = Scene(
        hole_diameter=D,
        peg_diameter=D - clearance,
        peg_height=height,
        peg_mass=mass,
        # Zero is a solid cylinder's.
        mass_center_height=0.0 if bare else height,
        transverse_inertia=0.0 if bare else mass * (0.03**2 + height**2 / 3),
        axial_inertia=0.0 if bare else mass * (0.02**2 + D**2 / 8),
        friction=draw.even(0.08, 0.35),
        friction_stddev=draw.even(0.005, 0.03),
        clearance_stddev=clearance * draw.even(0.0, 0.05),
    )
    push, fastest = draw.log(5.0, 80.0), draw.log(0.05, 0.5)
    cell = Cell(
        aim="time" if draw.chance(0.5) else "turning",
        start_tilt=scene.gamma0 + draw.even(0.08, 0.2),
        press=(-push * draw.even(0.4, 1.0), 0.0, -push),
        grip_height=height * draw.even(0.8, 1.2),
        stiffness=draw.log(5e3, 5e4),
        rotational_stiffness=push * D * draw.log(300.0, 3000.0),
        force_limit=1e4,
        torque_limit=1e3,
        min_closing_rate=fastest / 10,
        max_closing_rate=fastest,
        max_slip_rate=draw.log(0.2, 3.0),
        max_slide_rate=draw.even(0.2, 1.0) if draw.chance(0.3) else 0.0,
    )
    limit = looser * push * draw.log(3.0, 20.0)
    rng = np.random.default_rng([8_200, seed, number, 1])
    friction = max(scene.friction + scene.friction_stddev * rng.standard_normal(), 0.0)
    gap = max(clearance + scene.clearance_stddev * rng.standard_normal(), 0.05 * clearance)
    true = replace(scene, friction=friction, peg_diameter=D - gap)
    return Drawn(scene, cell, (limit,) * 3, true)


class Came(NamedTuple):
    """What came first in a simulation, at which tilt [rad], and the largest reactions [N]."""

    outcome: str
    tilt: float
    peak: np.ndarray


def simulated(drawn: Drawn, motion) -> Came:
    """Return what comes of a motion, led by the holder over rigid contacts."""
    scene, cell = drawn.true, drawn.cell
    first, *stages = motion.stages
    # The ramp from rest has one direction, that of the rates it comes to: it is left out.
    rates = np.array(first.rates)
    start = motion.start_tilt - LEAD_IN * rates[0]
    offset = [float(x / cell.stiffness) for x in cell.press]
    phases, tilt = {}, start
    for k, stage in enumerate(stages):
        duration = stage.duration if k else (stage.tilt - tilt) / rates[0]
        duration += BEYOND / -stage.rates[0] if k == len(stages) - 1 else 0.0
        phases[f"stage_{k}"] = {
            "kind": "contact",
            "duration": float(max(duration, 1e-3)),
            "rates": list(stage.rates),
            "offset": offset,
        }
        tilt = stage.tilt
    configuration = Configuration(
        scene=scene, wrench=WrenchInput(sensor_xyz=(0.0, 0.0, cell.grip_height))
    )
    tree = {
        "lead_in": LEAD_IN,
        "holder": {
            "stiffness": cell.stiffness,
            "rotational_stiffness": cell.rotational_stiffness,
            "damping_ratio": cell.damping_ratio,
            "force_limit": cell.force_limit,
            "torque_limit": cell.torque_limit,
        },
        "start": {
            "angles": [float(start), 0.0, 0.0],
            "rates": rates.tolist(),
            "offset": offset,
        },
        "phases": phases,
    }
    plan = plan_from_tree(configuration, tree)
    run = Run(plan, None)
    x = evaluate(run.knots, run.coefficients, 0.0)
    counted = _Counted(STEPS_FREE + STEPS * run.knots[-1])
    limits = cell.force_limit, cell.torque_limit
    state, t, peak, ended = np.concatenate([x[0, :3], x[1, :3]]), 0.0, np.zeros(3), "end"
    samples = run.grid[run.grid >= LEAD_IN]
    # Piece by piece, since what follows an overload does not matter and may take long.
    while t < run.knots[-1] - 1e-9 and ended == "end":
        until = min(t + PIECE, run.knots[-1])
        here = samples[(samples > t) & (samples <= until)]
        found = run_contact(
            run.model, Start(t, state, LEAD_IN), here, until, limits, RTOL, counted
        )
        t, state, ended = found.t_end, found.state_end, found.ended_by
        if not len(found.t):
            continue
        normal = contact_samples(run.model, found.t, found.states)[1]
        peak = np.maximum(peak, normal.max(axis=0))
        over = (normal > drawn.max_normal).any(axis=1)
        if over.any():
            return Came("overload", found.states[int(np.argmax(over)), 0], peak)
    return Came(_outcome(ended, state[0], scene), state[0], peak)


def _outcome(ended, gamma, scene):
    near = gamma < scene.gamma0 + NEAR_TRANSITION
    if ended in ("end", "transition") or near and ended in ("open B1", "open B2"):
        return "through"
    if ended.startswith("open"):
        return "parts"
    return "wedge" if ended == "wedged" else "holder"


class Chatter(Exception):
    """The integrator takes ever smaller steps."""


class _Counted:
    """Counts the steps, and gives up."""

    def __init__(self, most):
        self.left = most

    def __call__(self, time):
        self.left -= 1
        if self.left < 0:
            raise Chatter


def foreseen(drawn: Drawn, motion) -> tuple[str, float]:
    """Return what the equations say comes first with what is true, and where."""
    true = replace(drawn.true, friction_stddev=0.0, clearance_stddev=0.0)
    ahead = judge(true, drawn.cell, drawn.max_normal, motion)
    if ahead.expected is None:
        return "through", np.nan
    name = ahead.expected.name
    return _CAUSES.get(name, "wedge" if name == "WEDGE" else "holder"), ahead.expected_tilt


def came_of(drawn: Drawn, motion, peak: float = np.nan) -> Came:
    """Return what comes of a motion, also where the peg chatters; `peak` is then all reactions."""
    try:
        return simulated(drawn, motion)
    except Chatter:
        return Came("chatters", np.nan, np.full(3, peak))


class Numbered(NamedTuple):
    """A cell by the numbers that it is drawn from."""

    number: int
    seed: int
    looser: float = 1.0
    bare: bool = False

    def __str__(self):
        """Return a name for files and tables."""
        return f"{self.number:03d}_{self.seed}_{self.looser:g}{'_bare' if self.bare else ''}"


def score_member(cell: Numbered, folder: Path) -> dict:
    """Return what is said of plan and plain closing of a cell, and what comes of both."""
    drawn = cell_of(*cell)
    plan = plan_motion(drawn.scene, drawn.cell, drawn.max_normal)
    row = {"cell": cell.number, "possible": bool(plan.possible)}
    motions = {"plain": (plan.plain, plan.plain_outlook), "plan": (plan.motion, plan.outlook)}
    for name, (motion, ahead) in motions.items():
        said, said_tilt = foreseen(drawn, motion)
        came = came_of(drawn, motion)
        figures = {
            "wedge": ahead.wedge,
            "overload": ahead.overload,
            "said_tilt": said_tilt,
            "came_tilt": came.tilt,
            "over": np.max(came.peak / drawn.max_normal),
            "duration": motion.duration,
            "turning": motion.turning,
        }
        row |= {f"{name}_said": said, f"{name}_came": came.outcome}
        row |= {f"{name}_{what}": float(value) for what, value in figures.items()}
    return row


def members(options) -> list[Numbered]:
    """Return the cells asked for."""
    return [
        Numbered(number, options.seed, options.looser, options.bare)
        for number in range(options.cells)
    ]


def report(found, options) -> Report:
    """Return the tables, and a row for each cell."""
    rows = [row for _, row in found]
    return Report(summary(rows), {"plans": [list(rows[0]), *(list(row.values()) for row in rows)]})


def summary(found) -> str:
    """Return the tables."""
    possible = [row for row in found if row["possible"]]
    kept = sum(row["plan_came"] == "through" for row in possible)
    spoilt = [row for row in possible if row["plain_came"] != "through"]
    parts = [
        f"{len(found)} cells, a plan in {len(possible)}; it kept its limits in {kept} "
        f"({100 * kept / max(len(possible), 1):.1f} %); foreseen mean "
        f"{100 * np.mean([r['plan_wedge'] + r['plan_overload'] for r in possible]):.1f} % fail\n"
        f"of these cells plain closing failed in {len(spoilt)}"
    ]
    for name in ("plain", "plan"):
        rows = []
        for said in OUTCOMES:
            of = [row for row in found if row[f"{name}_said"] == said]
            counts = (sum(row[f"{name}_came"] == came for row in of) for came in OUTCOMES)
            rows.append((said, *counts))
        parts.append(table((f"{name}: said, with what is true", *OUTCOMES), rows))
        same = [
            row[f"{name}_came_tilt"] - row[f"{name}_said_tilt"]
            for row in found
            if row[f"{name}_said"] == row[f"{name}_came"] != "through"
        ]
        if same:
            parts.append(
                f"tilt at which it came less the one said: median {1e3 * np.median(same):.2f} "
                f"mrad, 95 % within {1e3 * np.quantile(np.abs(same), 0.95):.2f} mrad"
            )
    rows = []
    for low, high in ((0, 0.05), (0.05, 0.5), (0.5, 0.95), (0.95, 1.01)):
        of = [r for r in found if low <= max(r["plain_wedge"], r["plain_overload"]) < high]
        came = sum(row["plain_came"] != "through" for row in of)
        rows.append((f"{low:g} to {min(high, 1):g}", len(of), came))
    parts.append(table(("plain: said with the spread", "cells", "came"), rows))
    return "\n\n".join(parts)


def add_options(parser) -> None:
    """Add which cells."""
    parser.add_argument("--cells", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--looser", type=float, default=1.0, help="factor on the load limits")
    parser.add_argument("--bare", action="store_true", help="cylinders without a tool")


FAMILY = Family(
    members, score_member, report, add_options,
    parts=(*ESTIMATE, "config"),
)  # fmt: skip
