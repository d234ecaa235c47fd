"""
How well reactions and friction are known while a peg slides in on two points.

    python -m benchmarks.insertion.estimates [--noise 1]

prints it for the insertions that another engine simulated (`mujoco_traces.py`), with the settings
that they were made with, but for the wrench's noise: the other engine's pegs vibrate on their
contacts, which is some of it. `monitor.py` prints it for drawn ones.
"""

import argparse
from dataclasses import replace
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from benchmarks.insertion.engine import AFTER, engine_rows
from benchmarks.insertion.programs import PROGRAMS, plan_of
from benchmarks.scenes.play import Record, play
from peg_on_hole_ros.sim.measure import sensor_wrench

# 95 % of a normal distribution lie within so many standard deviations.
BOUND = 1.96
# A peg that is slower along the hole does not slide [m/s].
SLIDES = 5e-4
# One that is more upright lies on a line [rad].
UPRIGHT = 1e-3
# Friction is to be known to this share, so long after the first contact [s].
KNOWN, AFTER_CONTACT = 0.1, 0.5
SEED = 5_500


class Estimates(NamedTuple):
    """
    Errors in the samples that are told `two_point` while the peg slides on two points.

    Attributes
    ----------
    error, stddev, true : ndarray, shape (n, 2)
        Of N_K and N_B [N].
    friction, deviations : ndarray, shape (m,)
        Error of friction over the true one, and over its stated deviation, from AFTER_CONTACT on.

    """

    error: np.ndarray
    stddev: np.ndarray
    true: np.ndarray
    friction: np.ndarray
    deviations: np.ndarray

    @property
    def rms(self) -> np.ndarray:
        """Return root mean square of the errors of N_K and N_B over the mean load."""
        return np.sqrt((self.error**2).mean(axis=0)) / self.true.mean(axis=0)

    @property
    def covered(self) -> np.ndarray:
        """Return the share of N_K and N_B within their 95 % bounds."""
        return (np.abs(self.error) <= BOUND * self.stddev).mean(axis=0)


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
    )


def said(found: list[Estimates]) -> str:
    """Return the scenes' figures in one line each; those with few samples are left out."""
    some = [row for row in found if len(row.error) >= 50]
    rms = np.array([row.rms for row in some])
    error, stddev = (
        np.concatenate([getattr(row, k) for row in some]) for k in ("error", "stddev")
    )
    covered = (np.abs(error) <= BOUND * stddev).mean(axis=0)
    friction = np.concatenate([row.friction for row in found])
    deviations = np.abs(np.concatenate([row.deviations for row in found]))
    lines = [
        f"{len(some)} scenes slide on two points, {len(error)} samples: rms over the mean load, "
        f"median of scenes: N_K {np.median(rms[:, 0]):.1%}, N_B {np.median(rms[:, 1]):.1%}; "
        f"both within 5 %: {(rms < 0.05).all(axis=1).sum()} scenes; covered: "
        f"N_K {covered[0]:.1%}, N_B {covered[1]:.1%}"
    ]
    if len(friction):
        lines.append(
            f"friction {AFTER_CONTACT:g} s after the first contact, {len(friction)} samples: "
            f"within {KNOWN:.0%}: {(np.abs(friction) <= KNOWN).mean():.1%}; "
            f"within two of its deviations {(deviations <= 2.0).mean():.1%}, "
            f"beyond four {(deviations > 4.0).mean():.1%}"
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


def main(arguments=None):
    """Print the table of the other engine's insertions."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--noise", type=float, default=1.0, help="stated, over the sensor's")
    options = parser.parse_args(arguments)
    for name in PROGRAMS:
        found, record = engine_estimates(name, options.noise)
        if len(found.error) < 50:
            print(f"{name:14} slides on two points in {len(found.error)} samples")
        else:
            print(f"{name:14} {said([found])}")
        told, count = np.unique(record.mode, return_counts=True)
        print(f"{'':14} modes {dict(zip(told.tolist(), count.tolist()))}")


if __name__ == "__main__":
    main()
