"""Samples of one simulated motion in order, shuffled, and a pipeline that takes them."""

from dataclasses import replace

import numpy as np

from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.sim.measure import measure
from simulated import truth

SCENE = "closing_with_slip"
MS = 1_000_000


def pipeline(window=0.05, delay=0.0):
    configuration = truth(SCENE).plan.configuration
    options = replace(configuration.filter, late_window=window)
    joints = replace(configuration.joints, delay=delay)
    return Pipeline(replace(configuration, filter=options, joints=joints))


def ordered(duration_ms=300):
    samples = list(measure(truth(SCENE), 5))
    # Off the wrench's stamps, so that arrival says nothing about which of the two comes first.
    moved = [s._replace(t_ns=s.t_ns - 300_000) if type(s) is JointSample else s for s in samples]
    return [s for s in moved if s.t_ns - moved[0].t_ns < duration_ms * MS]


def undoubted(monitor):
    """Leave out what a motion does not tell: a look at the estimate is not taken back."""
    return {name: value for name, value in monitor.items() if not name.startswith("doubt_")}


def shuffled(samples, most_ns, seed=3):
    """Return samples as they arrive with delays up to most_ns; begin and end stay in order."""
    rng = np.random.default_rng(seed)
    last = samples[-1].t_ns
    arrival = [s.t_ns + rng.integers(0, most_ns) for s in samples]
    for i, sample in enumerate(samples):
        if i == 0 or last - sample.t_ns < 5 * MS:
            arrival[i] = sample.t_ns if i == 0 else sample.t_ns + most_ns
    return [samples[i] for i in np.argsort(arrival, kind="stable")]


def play(line, samples):
    return list(line.play(samples))


def total(counts):
    """Return how many messages have a fate."""
    return sum(n for name, n in counts.items() if "_dropped_" in name or name.endswith("_used"))
