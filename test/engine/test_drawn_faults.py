"""Streams with faults drawn at random: many at once give what one by one give, bit for bit."""

from dataclasses import replace

import numpy as np
import pytest

from late_samples import MS, SCENE, ordered
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.monitor.output_view import OutputView
from peg_on_hole_ros.records import Arrivals, JointSample, WrenchSample
from simulated import truth
from tiers import nightly

DELAY_NS = 4 * MS


def moved(sample, by_ms):
    return sample._replace(t_ns=sample.t_ns + int(by_ms) * MS)


def late_joints(samples, behind_ns):
    due = [s.t_ns + behind_ns * isinstance(s, JointSample) for s in samples]
    return [samples[i] for i in np.argsort(due, kind="stable")]


def faulty(samples, seed):
    """Return samples with some twice, missing, late, out of order, or with wrong stamps."""
    rng, out, jump = np.random.default_rng(seed), [], 0
    share = 10.0 ** -rng.uniform(0.7, 3.0)
    for sample in samples:
        sample = moved(sample, jump)
        if rng.random() > share:
            out.append(sample)
            continue
        back = int(rng.integers(0, min(len(out), 60) + 1))
        fault = rng.integers(0, 7)
        if fault == 0:
            out += [sample, sample]
        elif fault == 1:
            out.append(moved(sample, rng.integers(-70, 70)))
        elif fault == 2:
            out.append(moved(sample, rng.integers(-3000, 3000)))
        elif fault == 3:
            out.insert(len(out) - back, sample)
        elif fault == 4 and back:
            out += [out[-back], sample]
        elif fault == 5:
            jump += int(rng.integers(-1500, 1500)) * (rng.random() < 0.3)
            out.append(moved(sample, jump))
    return late_joints(out, int(rng.integers(0, 60)) * MS // 10) if seed % 2 else out


def one_by_one(line, samples):
    return [(o.t_ns, o.state.tobytes(), o.monitor) for o in line.play(samples)]


def many_at_once(line, samples):
    delay = line.configuration.joints.delay * 1e9
    arrivals = Arrivals(
        np.array([isinstance(s, WrenchSample) for s in samples]),
        np.array([s.t_ns - round(delay) * isinstance(s, JointSample) for s in samples]),
        np.ones(len(samples), bool),
        np.array([[*s.force, *s.torque] for s in samples if isinstance(s, WrenchSample)]),
        np.array([line.orientation(s).row for s in samples if isinstance(s, JointSample)]),
        np.array([s.position for s in samples if isinstance(s, JointSample)]),
    )
    found, end = [], 0
    while end < len(samples):
        end, rows = line.push(arrivals, end)
        assert (np.diff(rows.t_ns) > 0).all()
        found += [OutputView(int(t), row) for t, row in zip(rows.t_ns, rows.values)]
    return [(o.t_ns, o.state.tobytes(), o.monitor) for o in found]


@pytest.mark.parametrize("window", [0.05, 0.0, 0.3])
@pytest.mark.parametrize("seed", [0, 2, *nightly(1, *range(3, 8))])
def test_many_at_once_are_as_one_by_one(seed, window):
    configuration = truth(SCENE).plan.configuration
    configuration = replace(
        configuration,
        filter=replace(configuration.filter, late_window=window),
        joints=replace(configuration.joints, delay=DELAY_NS * 1e-9 * (seed % 3 == 2)),
    )
    samples = faulty(ordered(300), seed)
    first, second = Pipeline(configuration), Pipeline(configuration)
    expected = one_by_one(first, samples)
    found = many_at_once(second, samples)
    assert found == expected
    assert second.counts == first.counts


def test_what_comes_twice_is_taken_once():
    samples = [s for sample in ordered(300) for s in (sample, sample)]
    line = Pipeline(truth(SCENE).plan.configuration)
    found = many_at_once(line, samples)
    counts = line.counts
    assert counts["wrench_dropped_repeated_stamp"] == counts["wrench_used"] == len(found)
    assert counts["joints_dropped_repeated_stamp"] == counts["joints_used"]
