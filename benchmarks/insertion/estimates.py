"""
How well reactions and friction are known while a peg slides in on two points.

Of the insertions that another engine simulated (`mujoco_traces.py`), with the settings that they
were made with, but for the wrench's noise: the other engine's pegs vibrate on their contacts,
which is some of it. `python -m benchmarks insertion` tells the same of drawn ones.
"""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from benchmarks.harness.errors import coverage, inside
from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.player import Record
from benchmarks.harness.truths import play
from benchmarks.insertion import engine, programs
from benchmarks.insertion.engine import AFTER, TRACES, engine_rows
from benchmarks.insertion.programs import PROGRAMS, plan_of
from peg_on_hole_ros.sim.measure import sensor_wrench

# A peg that is slower along the hole does not slide [m/s].
SLIDES = 5e-4
# One that is more upright lies on a line [rad].
UPRIGHT = 1e-3
# Friction is to be known to this share, so long after the first contact [s].
KNOWN, AFTER_CONTACT = 0.1, 0.5
SEED = 5_500
# Fewer samples tell no share.
FEW = 50


class Estimates(NamedTuple):
    """
    Errors in the samples that are told `two_point` while the peg slides on two points.

    Attributes
    ----------
    error, stddev, true : ndarray, shape (n, 2)
        Of N_K and N_B [N].
    friction, deviations : ndarray, shape (m,)
        Error of friction over the true one, and over its stated deviation, from AFTER_CONTACT on.
    sliding : int
        Samples in which the peg slides on two points, whatever is told.

    """

    error: np.ndarray
    stddev: np.ndarray
    true: np.ndarray
    friction: np.ndarray
    deviations: np.ndarray
    sliding: int

    @property
    def rms(self) -> np.ndarray:
        """Return root mean square of the errors of N_K and N_B over the mean load."""
        return coverage(self.error, self.stddev).rms / self.true.mean(axis=0)

    @property
    def covered(self) -> np.ndarray:
        """Return the share of N_K and N_B within their 95 % bounds."""
        return coverage(self.error, self.stddev).covered

    def summary(self) -> dict:
        """Return what scenes are pooled by, as a plain tree."""
        off = np.abs(self.deviations)
        return {
            "samples": len(self.error),
            "sliding": self.sliding,
            "rms": self.rms.tolist() if len(self.error) else [],
            "covered": inside(self.error, self.stddev).sum(axis=0).tolist(),
            "friction": len(self.friction),
            "known": int((np.abs(self.friction) <= KNOWN).sum()),
            "within_two": int((off <= 2.0).sum()),
            "beyond_four": int((off > 4.0).sum()),
        }


def estimates_of(
    record: Record, t: np.ndarray, slides: np.ndarray, normal: np.ndarray, friction: np.ndarray
) -> Estimates:
    """
    Return the errors of a scene.

    Parameters
    ----------
    record : Record
    t : ndarray, shape (n,)
        [s]
    slides : ndarray of bool, shape (n,)
        Where the peg truly slides on two points, and what is told of it counts.
    normal : ndarray, shape (n, 2)
        True loads of rim and edge [N].
    friction : ndarray, shape (n,)
        True.

    """
    rows = slides & (record.mode == "two_point") & np.isfinite(record.normal_stddev).all(axis=1)
    told = np.column_stack([record.normal[:, 0], record.normal[:, 1:].sum(axis=1)])
    # B1 and B2 are halves of B.
    spread = np.column_stack([record.normal_stddev[:, 0], record.normal_stddev[:, 1:].sum(axis=1)])
    touched = t[(normal > 0).any(axis=1)].min(initial=np.inf)
    late = rows & (t >= touched + AFTER_CONTACT)
    off = record.monitor["friction"] - friction
    return Estimates(
        (told - normal)[rows],
        spread[rows],
        normal[rows],
        off[late] / friction[late],
        off[late] / record.monitor["friction_stddev"][late],
        int(slides.sum()),
    )


def said(found: list[dict]) -> str:
    """Return figures of scenes by `Estimates.summary`; those with few samples are left out."""
    some = [row for row in found if row["samples"] >= FEW]
    rms = np.array([row["rms"] for row in some])
    samples = sum(row["samples"] for row in some)
    covered = np.sum([row["covered"] for row in some], axis=0) / samples
    lines = [
        f"{len(some)} scenes slide on two points, {samples} samples: rms over the mean load, "
        f"median of scenes: N_K {np.median(rms[:, 0]):.1%}, N_B {np.median(rms[:, 1]):.1%}; "
        f"both within 5 %: {(rms < 0.05).all(axis=1).sum()} scenes; covered: "
        f"N_K {covered[0]:.1%}, N_B {covered[1]:.1%}; determined in "
        f"{samples / sum(row['sliding'] for row in some):.1%} of the slide"
    ]
    count = sum(row["friction"] for row in found)
    if count:
        known, two, four = (
            sum(row[name] for row in found) / count
            for name in ("known", "within_two", "beyond_four")
        )
        lines.append(
            f"friction {AFTER_CONTACT:g} s after the first contact, {count} samples: "
            f"within {KNOWN:.0%}: {known:.1%}; within two of its deviations {two:.1%}, "
            f"beyond four {four:.1%}"
        )
    return "\n".join(lines)


def engine_truth(name: str) -> SimpleNamespace:
    """Return motion and loads of another engine's insertion, with what the sensors need."""
    plan = plan_of(name)
    scene = plan.configuration.scene
    rows = engine_rows(name, scene)
    truth = SimpleNamespace(
        plan=SimpleNamespace(
            configuration=plan.configuration, seed=0, wrench_rate=500, joint_rate=500
        ),
        t_ns=np.round(rows["t"] * 1e9).astype(np.int64),
        q=rows["q"],
        force=rows["force"],
        moment=rows["moment"],
    )
    truth.normal = np.column_stack([rows["rim"], rows["edge"]])
    truth.speed = np.gradient(rows["depth"], rows["t"])
    truth.wrench = sensor_wrench(truth)
    return truth


def engine_estimates(name: str, noise: float = 1.0) -> tuple[Estimates, Record]:
    """
    Return the errors over an insertion of another engine, and all that was said.

    The wrench's noise is stated so many times the sensor's.
    """
    truth = engine_truth(name)
    told = truth.plan.configuration
    force, torque = noise * told.wrench.force_stddev, noise * told.wrench.torque_stddev
    wrench = replace(told.wrench, force_stddev=force, torque_stddev=torque)
    told = replace(told, wrench=wrench)
    record = play(truth, told, [[SEED, list(PROGRAMS).index(name)]])
    t = truth.t_ns * 1e-9
    slides = (np.abs(truth.speed) > SLIDES) & (t > AFTER) & (truth.normal > 0).all(axis=1)
    slides &= truth.q[:, 0] > UPRIGHT
    friction = np.full(len(t), told.scene.friction)
    return estimates_of(record, t, slides, truth.normal, friction), record


def score_member(insertion: Member, folder: Path) -> dict:
    """Return the figures of an insertion, and how often each mode was declared."""
    found, record = engine_estimates(*insertion.of)
    told, count = np.unique(record.mode, return_counts=True)
    return {**found.summary(), "modes": dict(zip(told.tolist(), count.tolist()))}


def report(found, options) -> Report:
    """Return the figures of each insertion."""
    lines = []
    for insertion, row in found:
        few = f"slides on two points in {row['samples']} samples"
        lines.append(f"{insertion.of[0]:14} {few if row['samples'] < FEW else said([row])}")
        lines.append(f"{'':14} modes {row['modes']}")
    return Report("\n".join(lines))


def add_options(parser) -> None:
    """Add the stated noise."""
    parser.add_argument("--noise", type=float, default=1.0, help="stated, over the sensor's")


def members(options) -> list[Member]:
    """Return the insertions, with the wrench's noise as stated, over the sensor's."""
    return [Member(f"{name}_{options.noise:g}", (name, options.noise)) for name in PROGRAMS]


FAMILY = Family(members, score_member, report, add_options, sources=(TRACES, engine, programs))
