"""
Friction that steps within a contact: whether what is called determined is covered.

Drawn motions on three contacts with slip. In most of them friction steps once, up or down, in the
others it stays; the estimate begins with the friction that is true then. Counted is from the step
on: which share of the reactions that are called determined lies within 95 % bounds, of K, B1 and
B2 the least; which share of the samples is called determined from OPEN_AGAIN on; and in which
share of the runs friction is off by more than SURE of its deviations at any time from FOUND on.
"""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.grid import cells
from benchmarks.grid.cells import first_samples, touching
from benchmarks.harness.errors import REACTIONS, changed_parameters, inside, rms, runs_of
from benchmarks.harness.exact import exactly
from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.player import player_of
from benchmarks.harness.tables import percent, table
from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.measure import START_NS, measure, sensor_wrench
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate
from peg_on_hole_ros.study.runs import LEAST_COVERED

FIRST_SEED = 820_000
STEPPING, STEADY = 20, 6
# Times of a motion [s]: before the recording, from its begin to the step, from there to the end.
LEAD_IN, UNTIL, FROM = 0.05, 0.3, 0.7
# After a step [s].
OPEN_AGAIN, FOUND = 0.1, 0.5
# So long friction is looked at from then on, at least [s].
SHOWN = 0.1
DRAWS = 50
# Commanded into the hole, over its diameter.
PRESS = -0.03
# Of the steps, and bounds of friction before and after.
SIZES, FRICTIONS = (0.02, 0.3), (0.06, 0.5)
# Hole [m], peg over hole, noise of force [N], torque [N m], joints [rad].
PEGS = (
    (0.010, 0.998, 0.1, 0.002, 5e-5),
    (0.025, 0.9976, 0.2, 0.005, 1e-4),
    (0.050, 0.998, 0.2, 0.005, 1e-4),
)
SURE = 4.0
LEAST_DETERMINED, MOST_WRONG = 0.9, 0.01


class Drawn(NamedTuple):
    """
    What is drawn for a motion.

    Attributes
    ----------
    peg : tuple
        Of PEGS.
    closing, turning : float
        By how much the tilt closes and the peg turns about its own axis [rad/s].
    before, after : float
        Friction before and after the step.

    """

    peg: tuple
    closing: float
    turning: float
    before: float
    after: float


def _draw(draw: np.random.Generator, steps: bool) -> Drawn:
    """Return a motion whose friction stays within bounds."""
    while True:
        before = draw.uniform(0.1, 0.35)
        size = np.exp(draw.uniform(*np.log(SIZES))) * draw.choice([-1.0, 1.0])
        if FRICTIONS[0] <= before + size <= FRICTIONS[1]:
            break
    return Drawn(
        PEGS[draw.integers(len(PEGS))],
        draw.uniform(0.05, 0.15),
        float(np.exp(draw.uniform(*np.log((0.3, 2.0))))),
        before,
        float(before + size) if steps else before,
    )


def _plan(drawn: Drawn):
    """Return the plan of a motion."""
    D, share, force, torque, angle = drawn.peg
    scene = Scene(
        hole_diameter=D, peg_diameter=share * D, peg_height=2.0 * D, peg_mass=640.0 * D * D,
        friction=drawn.before,
    )  # fmt: skip
    sensor = WrenchInput(sensor_xyz=(0.0, 0.0, 2.5 * D), force_stddev=force, torque_stddev=torque)
    configuration = Configuration(
        scene=scene, wrench=sensor, joints=JointInput(position_stddev=angle)
    )
    rates = [-drawn.closing, 0.0, drawn.turning]
    tilt = 1.15 * scene.gamma0 + drawn.closing * (LEAD_IN + UNTIL + FROM)
    leg = {"kind": "contact", "rates": rates}
    tree = {
        "lead_in": LEAD_IN,
        "holder": {"force_limit": 2000.0, "torque_limit": 200.0},
        "start": {"angles": [tilt, 0.0, 0.0], "rates": rates, "offset": [0.0, 0.0, PRESS * D]},
        "phases": {
            "lead": leg | {"duration": LEAD_IN},
            "before": leg | {"duration": UNTIL},
            "after": leg | {"duration": FROM, "friction": drawn.after},
        },
    }
    return plan_from_tree(configuration, tree)


@cache
def stepping(number: int, steps: bool):
    """
    Return the truth of the first drawn motion that keeps three contacts, and its friction.

    Raises
    ------
    RuntimeError
        None of DRAWS does.

    """
    draw = np.random.default_rng([FIRST_SEED, number, int(steps)])
    for _ in range(DRAWS):
        drawn = _draw(draw, steps)
        try:
            truth = integrate(_plan(drawn))
        except PegOnHoleError:
            continue
        touches = touching(truth)
        if touches >= (UNTIL + FOUND + SHOWN) * truth.plan.wrench_rate:
            truth = first_samples(truth, touches)
            later = truth.t_ns >= UNTIL * 1e9
            return truth, np.where(later, drawn.after, drawn.before)
    raise RuntimeError(f"motion {number}: none of {DRAWS} keeps three contacts through the step")


def score_member(member: Member, folder: Path) -> dict:
    """Return the figures of a motion; each is a list over its runs, or over K, B1, B2."""
    truth, friction = stepping(*member.of)
    exact, player = sensor_wrench(truth), player_of(member.checkout)
    parameters = changed_parameters(exactly(truth.plan.configuration))
    records = [
        player(parameters, list(map(tuple, measure(truth, seed, exact=exact))), START_NS)
        for seed in range(FIRST_SEED, FIRST_SEED + member.seeds)
    ]
    runs, t = runs_of(truth, records), truth.t_ns * 1e-9
    told = runs.determined & (t >= UNTIL)
    error, stddev = runs.error[told][:, REACTIONS], runs.stddev[told][:, REACTIONS]
    at = [record.rows_at(truth.t_ns, START_NS).monitor for record in records]
    off = np.array([np.abs(each["friction"] - friction) / each["friction_stddev"] for each in at])
    return {
        "friction": [float(friction[0]), float(friction[-1])],
        "samples": len(error),
        "inside": inside(error, stddev).sum(axis=0).tolist(),
        "rms": rms(error).tolist() if len(error) else [],
        "mean": truth.normal[t >= UNTIL].mean(axis=0).tolist(),
        "determined": float(runs.determined[:, t >= UNTIL + OPEN_AGAIN].mean()),
        "before": float(runs.determined[:, (t >= 0.1) & (t < UNTIL)].mean()),
        "deviations": off[:, t >= UNTIL + FOUND].max(axis=1).tolist(),
        "relative_stddev": float(np.mean([m["friction_stddev"][-1] / friction[-1] for m in at])),
    }


def members(options) -> list[Member]:
    """Return the motions, those with a step first."""
    return [
        Member(f"{name}_{number:02d}", (number, steps), options.seeds)
        for name, steps, many in (("step", True, STEPPING), ("steady", False, STEADY))
        for number in range(many)
    ]


def _pooled(rows: list[dict]) -> tuple[float, float, float]:
    """Return shares of motions together: covered, the least contact's; determined; wrong runs."""
    samples = max(sum(row["samples"] for row in rows), 1)
    covered = np.sum([row["inside"] for row in rows], axis=0).min() / samples
    wrong = np.concatenate([row["deviations"] for row in rows]) > SURE
    return covered, float(np.mean([row["determined"] for row in rows])), float(wrong.mean())


def report(found, options) -> Report:
    """Return a row for each motion, and what all come to; problems where a limit is not kept."""
    rows, problems = [], []
    for member, row in found:
        covered = min(row["inside"]) / row["samples"] if row["samples"] else np.nan
        most = max(row["deviations"])
        figures = percent(covered), percent(row["determined"]), f"{most:.1f}"
        before, after = row["friction"]
        rows.append((member, f"{before:.3f} to {after:.3f}", *figures))
    for kind in ("step", "steady"):
        for other in (False, True):
            own = [
                row
                for m, row in found
                if m.name.startswith(f"{kind}_") and bool(m.checkout) == other
            ]
            if not own:
                continue
            covered, determined, wrong = _pooled(own)
            name = f"all of {kind}{', other' if other else ''}"
            rows.append((name, "", percent(covered), percent(determined), percent(wrong, 1)))
            kept = covered >= LEAST_COVERED and wrong <= MOST_WRONG
            if not other and not (kept and determined >= LEAST_DETERMINED):
                problems.append(f"{name}: a limit is not kept")
    limits = percent(LEAST_COVERED), percent(LEAST_DETERMINED), percent(MOST_WRONG)
    rows.append(("limits", "", *limits))
    head = "motion", "friction", "covered", "determined", "deviations at most; runs beyond 4"
    return Report(table(head, rows), problems=problems)


FAMILY = Family(
    members, score_member, report, seeds=2,
    group=lambda member: member.of, sources=(cells,), against=True,
)  # fmt: skip
