"""
Reactions, friction and flags where the truth is another engine's: the gate for every setting.

Runs are MuJoCo's motions on the rim (`mujoco_traces.npz`), closings of other clearances, frictions
and masses (`mujoco_closings.npz`) and insertions (`mujoco_insertions.npz`), and Pinocchio's
insertions of three more pegs in two contact models (`pinocchio_traces.py`). Each is measured with
its sensors' noise and friction drawn from what is stated of it, once told that all else is exact,
and once with the default accuracies stated (`stated`). Told of each:

covered: of the reactions that are called determined while three contacts carry, or the peg slides
on two, which share lies within 95 % bounds, of the contacts the least; rms: root mean square of
their errors over the mean load, of the contacts the most; determined: their share of such samples;
friction: the share of samples from SETTLED on in which it is off by over four of its deviations;
flag: when it came, after the transition.
"""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from benchmarks.engines import engine as traces
from benchmarks.harness.errors import coverage, drawn
from benchmarks.harness.exact import exactly
from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.player import Record, record_of
from benchmarks.harness.tables import percent, table
from benchmarks.insertion import estimates, pegs
from benchmarks.insertion.engine import TRACES as INSERTIONS
from benchmarks.scenes import engine as closings
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.sim.measure import START_NS, measure, sensor_wrench

PINOCCHIO = Path(__file__).parents[1] / "insertion" / "data" / "pinocchio_insertions.npz"
# Insertions of MuJoCo that slide on two points for long enough; the others are stuck.
SLIDING = ("slides", "goes_in")
# Filter and friction have settled [s].
SETTLED = 0.1
# A contact that carries less is open [N]; slower along the hole it does not slide [m/s].
TOUCHES, SLIDES = 0.05, 5e-4
DEVIATIONS = 4.0
# Each run has draws of its own.
SEED, SEEDS = 930_000, 1
TOLD = ("exact", "stated")
HEAD = (
    "run", "three contacts: coverage, error, determined",
    "two points: coverage, error, determined",
    "samples with friction wrong by over four standard deviations", "flag [ms]",
    "coverage with accuracies stated",
)  # fmt: skip
# Of the first flag [ms]; the others are shares.
LEVELS = (
    "run", "told", "three_covered", "two_covered", "three_rms", "two_rms", "three_determined",
    "two_determined", "friction_beyond", "flag_ms",
)  # fmt: skip


def names() -> list[str]:
    """Return the runs that there are: whose, and which."""
    with np.load(PINOCCHIO) as stored:
        pinocchio = list(stored.files)
    return [
        *(f"rim {name}" for name in traces.names()),
        *(f"closing {number}" for number in closings.numbers()),
        *(f"insertion {name}" for name in SLIDING),
        *(f"peg {name}" for name in pinocchio),
    ]


def truth_of(name: str) -> SimpleNamespace:
    """
    Return a run as a truth that `measure` takes.

    Returns
    -------
    SimpleNamespace
        plan; t_ns (n,); q (n, 3) [rad]; wrench (n, 6) at the sensor; normal (n, 3): K, B1, B2,
        on two points B halved [N]; three, two (n,): where three contacts carry, and where it
        slides on two.

    """
    kind, _, which = name.partition(" ")
    truth = {"rim": _rim, "closing": _closing, "insertion": _insertion, "peg": _peg}[kind](which)
    above = truth.q[:, 0] > truth.plan.configuration.scene.gamma0
    loaded = truth.normal > TOUCHES
    truth.three = loaded.all(axis=1) & above & truth.slides
    truth.two = loaded[:, 0] & loaded[:, 1:].any(axis=1) & ~above & truth.slides
    below = ~above & loaded.any(axis=1)
    truth.transition = truth.t_ns[below.argmax()] * 1e-9 if below.any() and above[0] else None
    return truth


def _rim(which):
    truth = traces.trace(which)
    # Up to where a contact sticks.
    truth.slides = np.arange(len(truth.q)) < truth.slides
    return truth


def _closing(which):
    truth = closings.truth_of(int(which))
    truth.wrench = sensor_wrench(truth)
    # Nothing guides the peg in the hole, and its loads there are not kept apart.
    truth.slides = truth.q[:, 0] > truth.plan.configuration.scene.gamma0
    return truth


def _insertion(which):
    truth = estimates.engine_truth(which)
    rim, edge = truth.normal.T
    truth.normal = np.column_stack([rim, edge / 2, edge / 2])
    scene = truth.plan.configuration.scene
    # Above gamma0 B1 and B2 are not kept apart.
    truth.slides = (np.abs(truth.speed) > SLIDES) & (truth.q[:, 0] > estimates.UPRIGHT)
    truth.slides &= truth.q[:, 0] < scene.gamma0
    return truth


def _peg(which):
    peg, _, contact = which.rpartition("_")
    plan = pegs.plan_of(peg)
    scene = plan.configuration.scene
    # What contacts give is stated, as a cell with such parts does.
    accuracy = replace(plan.configuration.accuracy, compliance=pegs.COMPLIANCES[contact])
    with np.load(PINOCCHIO) as stored:
        rows = np.cumsum(stored[which], axis=0) * pegs.UNITS
    q, depth, force, moment, normal = np.split(rows, [3, 4, 7, 10], axis=1)
    t_ns = 1_000_000 * np.arange(1, len(rows) + 1)
    truth = SimpleNamespace(
        plan=SimpleNamespace(
            configuration=replace(plan.configuration, accuracy=accuracy),
            seed=0,
            wrench_rate=1000,
            joint_rate=500,
        ),
        t_ns=t_ns,
        q=q,
        force=force,
        moment=moment,
    )
    truth.wrench = sensor_wrench(truth)
    below = truth.q[:, 0] < scene.gamma0
    halves = normal[:, 1:].mean(axis=1, keepdims=True)
    # What the edge carries is one contact in the hole.
    truth.normal = np.where(below[:, None], np.hstack([normal[:, :1], halves, halves]), normal)
    truth.slides = ~below | (np.abs(np.gradient(depth[:, 0], t_ns * 1e-9)) > SLIDES)
    return truth


def play(truth, told: str, seed: int) -> Record:
    """Return what is said of a run, a row for each of its own."""
    configuration = truth.plan.configuration
    if told == "exact":
        configuration = exactly(configuration)
    pipeline = Pipeline(drawn(configuration, seed))
    samples = measure(truth, seed, exact=truth.wrench)
    return record_of(pipeline, samples).rows_at(truth.t_ns, START_NS)


def score(name: str, told: str, seeds: int = SEEDS) -> dict:
    """
    Return the figures of a run.

    Returns
    -------
    dict
        `three` and `two`: samples, determined (a share), covered and rms by contact; `beyond`: of
        friction, a share; `flags`: for each seed after the transition [s], infinite where none
        came; empty where there is no transition.

    """
    truth = truth_of(name)
    t = truth.t_ns * 1e-9
    parts = {"three": [], "two": []}
    beyond, flags = [], []
    first = SEED + 100 * names().index(name)
    for seed in range(first, first + seeds):
        record = play(truth, told, seed)
        for part in parts:
            mode = f"{part}_point"
            asked = getattr(truth, part) & (t > SETTLED)
            rows = asked & record.determined & (record.mode == mode)
            rows &= np.isfinite(record.normal_stddev).all(axis=1)
            parts[part].append(
                (
                    (record.normal - truth.normal)[rows],
                    record.normal_stddev[rows],
                    truth.normal[rows],
                    int(asked.sum()),
                )
            )
        off = np.abs(record.monitor["friction"] - truth.plan.configuration.scene.friction)
        known = (t > SETTLED) & np.isfinite(off)
        beyond.append((off > DEVIATIONS * record.monitor["friction_stddev"])[known])
        if truth.transition is not None:
            came = float(t[record.flag].min(initial=np.inf)) - truth.transition
            flags.append(came)
    found = {part: _figures(rows) for part, rows in parts.items()}
    return {**found, "beyond": float(np.concatenate(beyond).mean()), "flags": flags}


def _figures(parts) -> dict:
    error, stddev, normal = (np.concatenate([part[k] for part in parts]) for k in range(3))
    asked = sum(part[3] for part in parts)
    if not len(error):
        return {"asked": asked, "samples": 0, "determined": 0.0, "covered": [], "rms": []}
    of = coverage(error, stddev)
    return {
        "asked": asked,
        "samples": len(error),
        "determined": len(error) / asked,
        "covered": of.covered.tolist(),
        "rms": (of.rms / normal.mean(axis=0)).tolist(),
    }


def members(options) -> list[Member]:
    """Return the runs, told both."""
    return [
        Member(f"{name.replace(' ', '_')}_{told}", (name, told), options.seeds)
        for name in names()
        for told in TOLD
    ]


def score_member(run: Member, folder: Path) -> dict:
    """Return the figures of a run."""
    return score(*run.of, run.seeds)


def row(name: str, exact: dict, stated: dict) -> tuple:
    """Return a row of the table."""

    def part(of):
        if not of["samples"]:
            return "" if not of["asked"] else "none determined"
        return (
            f"{100 * min(of['covered']):.0f} %, {100 * max(of['rms']):.1f} %, "
            f"{100 * of['determined']:.0f} %"
        )

    covered = [min(stated[of]["covered"], default=None) for of in ("three", "two")]
    return (
        name,
        part(exact["three"]),
        part(exact["two"]),
        f"{100 * exact['beyond']:.1f} %",
        ", ".join(f"{1e3 * flag:.0f}" for flag in exact["flags"]),
        ", ".join(percent(share) for share in covered if share is not None),
    )


def levels(name: str, told: str, figures: dict) -> list:
    """Return a row of what `test/data/gate.csv` keeps; empty: nothing was determined."""
    parts = [figures[part] for part in ("three", "two")]
    flags = [float(np.round(1e3 * flag)) for flag in figures["flags"]]
    return [
        name, told,
        *(round(min(part["covered"]), 3) if part["samples"] else "" for part in parts),
        *(round(max(part["rms"]), 4) if part["samples"] else "" for part in parts),
        *(round(part["determined"], 3) for part in parts),
        round(figures["beyond"], 3), flags[0] if flags else "",
    ]  # fmt: skip


def report(found, options) -> Report:
    """Return a row for each run that has both."""
    of = {run.of: figures for run, figures in found}
    whole = [name for name in names() if all((name, told) in of for told in TOLD)]
    rows = [row(name, *(of[name, told] for told in TOLD)) for name in whole]
    kept = [levels(name, told, of[name, told]) for name in whole for told in TOLD]
    return Report(table(HEAD, rows), csv={"gate": [list(LEVELS), *kept]})


FAMILY = Family(
    members, score_member, report, seeds=SEEDS,
    sources=(
        traces.TRACES, closings.TRACES, INSERTIONS, PINOCCHIO, traces, closings, estimates, pegs,
    ),
)  # fmt: skip
