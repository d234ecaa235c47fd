"""Truths kept on disk, and what the pipeline says along one in several tries."""

import hashlib
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from benchmarks.harness.exact import exactly
from benchmarks.harness.player import Record, record_of
from benchmarks.harness.runner import sources_key
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.sim.truth import Truth, integrate

# Between one try and the next, without messages [ns].
PAUSE_NS = 1_000_000_000
# What a truth depends on besides its plan.
TRUTH_SOURCES = ("sim", "mechanics/scene.py")
ROW_FIELDS = tuple(
    f.name for f in fields(Truth) if f.name not in ("plan", "ended_by", "events")
)  # fmt: skip


def truth_of(plan, folder: Path | None = None):
    """
    Return the truth of a plan, from the folder if it was integrated before.

    Returns
    -------
    truth : Truth or None
        None: the plan cannot be begun.
    why : str
        Empty, or why there is none.

    """
    if folder is None:
        return _integrated(plan)
    path = folder / f"{_plan_key(plan)}.npz"
    try:
        with np.load(path) as stored:
            rows = {name: stored[name] for name in ROW_FIELDS}
            events = zip(stored["event_t"].tolist(), stored["event"].tolist(), strict=True)
            return Truth(
                plan=plan, ended_by=str(stored["ended_by"]), events=tuple(events), **rows
            ), ""
    except (OSError, ValueError, KeyError):
        pass
    truth, why = _integrated(plan)
    if truth is not None:
        folder.mkdir(parents=True, exist_ok=True)
        partial = path.with_suffix(".partial.npz")
        np.savez_compressed(
            partial,
            ended_by=truth.ended_by,
            event_t=[t for t, _ in truth.events],
            event=[what for _, what in truth.events],
            **{name: getattr(truth, name) for name in ROW_FIELDS},
        )
        partial.replace(path)
    return truth, why


def _integrated(plan):
    try:
        return integrate(plan), ""
    except PegOnHoleError as error:
        return None, str(error)


def _plan_key(plan):
    scene = plan.configuration.scene
    moved = replace(plan, configuration=None)
    # Where the holder takes hold.
    sensor = plan.configuration.wrench.sensor_xyz
    content = f"{sources_key(TRUTH_SOURCES, ())} {scene} {sensor} {moved}"
    return hashlib.sha256(content.encode()).hexdigest()[:24]


def play(truth, configuration, seeds) -> Record:
    """
    Return what the pipeline publishes over measurements of a truth, one after another.

    Parameters
    ----------
    truth : Truth
    configuration : Configuration
        What the estimator is told; the sensors are those of the truth's own.
    seeds : list of list of int
        Of the noise: one for each try. What is published in the last one is returned; what the
        estimator has learnt in those before, it knows.

    Returns
    -------
    Record
        A row for each sample of the truth.

    """
    pipeline, start_ns = Pipeline(exactly(configuration)), START_NS
    for tried, seed in enumerate(seeds):
        said = record_of(pipeline, measure(truth, seed, start_ns))
        record = said.rows_at(truth.t_ns, start_ns)
        if tried:
            # A flag that still stands from the try before was not raised in this one.
            record.flag[: np.argmax(~np.append(record.flag, False))] = False
        start_ns += int(truth.t_ns[-1]) + PAUSE_NS
    return record
