"""A joint state whose stamp was there already: its noise is the same, so it is not used again."""

import numpy as np
import pytest

from late_samples import MS, ordered, pipeline, play, shuffled, total
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.engine.tuned import REPROCESSING, STAMP_ORDER
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.sim.measure import measure
from simulated import truth
from tiers import nightly

REASON = "joints_dropped_repeated_stamp"


def twice(samples, after=1):
    """Return samples with each joint state sent again, so many samples later."""
    stream = list(samples)
    for i in range(len(samples) - 1, -1, -1):
        if isinstance(samples[i], JointSample):
            stream.insert(min(i + after, len(samples)), samples[i])
    return stream


def joint_count(samples):
    return sum(isinstance(s, JointSample) for s in samples)


# At once, with a wrench in between, and as late as a message may be: 40 ms.
@pytest.mark.parametrize("after", [3, *nightly(1, 60)])
@pytest.mark.parametrize("window", [0.05, 0.0])
def test_sent_twice_is_used_once(after, window):
    samples = ordered(200)
    first, second = pipeline(window), pipeline(window)
    expected, found = play(first, samples), play(second, twice(samples, after))
    for one, other in zip(expected, found, strict=True):
        np.testing.assert_array_equal(other.state, one.state)
        np.testing.assert_array_equal(other.state_covariance, one.state_covariance)
        assert other.monitor == one.monitor
    counts = second.counts
    # Without a window what is later than `filter.late_tolerance` is dropped for that.
    dropped = counts[REASON] + counts["joints_dropped_late"]
    assert dropped == counts["joints_used"] == joint_count(samples)
    if window:
        assert counts["joints_dropped_late"] == counts["went_back"] == 0
    assert total(counts) == len(samples) + joint_count(samples)


def test_a_repetition_of_the_newest_wrenchs_stamp_is_not_used():
    samples = list(measure(truth("closing_with_slip"), 5))[:300]
    lines = []
    for stream in (samples, twice(samples, 2)):
        lines.append(pipeline())
        play(lines[-1], stream)
    np.testing.assert_array_equal(lines[1].filter.x, lines[0].filter.x)
    assert lines[1].counts[REASON] == joint_count(samples)


def test_repetitions_in_a_shuffled_stream_change_nothing():
    samples = ordered()
    late = shuffled(samples, 20 * MS)
    first, second = pipeline(), pipeline()
    play(first, samples)
    play(second, twice(late, 5))
    np.testing.assert_array_equal(second.filter.x, first.filter.x)
    np.testing.assert_array_equal(second.filter.P, first.filter.P)
    assert second.counts[REASON] == joint_count(samples)


def test_the_first_of_a_stamp_is_used_and_one_without_all_joints_is_no_first():
    """Two drivers on one topic, of one clock: a gripper's message does not hide the peg's."""
    samples = ordered(200)
    stream = []
    for sample in samples:
        if isinstance(sample, JointSample):
            stream.append(JointSample(sample.t_ns, ("finger", "gamma"), (0.02, 0.5)))
            stream.append(sample)
            # The peg's joints again, among others and in another order.
            names, position = ("finger", *sample.names[::-1]), (0.0, *sample.position[::-1])
            stream.append(JointSample(sample.t_ns, names, position))
        else:
            stream.append(sample)
    first, second = pipeline(), pipeline()
    play(first, samples)
    play(second, stream)
    np.testing.assert_array_equal(second.filter.x, first.filter.x)
    assert second.counts["joints_dropped_missing_joint"] == joint_count(samples)
    assert second.counts[REASON] == joint_count(samples)


def test_a_bag_that_is_played_again_is_a_clock_that_jumped():
    samples = ordered(100)
    apart = [s._replace(t_ns=s.t_ns + 2_000 * MS) for s in samples]
    line = pipeline()
    play(line, [*samples, *apart])
    used = line.counts["joints_used"]
    play(line, [*samples, *apart])
    assert line.counts["clock_jumped_back"] == 1
    assert line.counts[REASON] == 0
    # The first stamp that is far behind may be one that is wrong.
    assert line.counts["joints_used"] + line.counts["joints_dropped_late"] == 2 * used
    assert line.counts["joints_dropped_late"] == 1


def test_a_reset_begins_anew_with_any_stamp():
    samples = ordered(50)
    line = pipeline()
    play(line, samples)
    line.reset()
    line.on_joints(next(s for s in samples[::-1] if isinstance(s, JointSample)))
    assert line.counts[REASON] == 0 and line.counts["joints_used"] == joint_count(samples) + 1


def test_orientations_ahead_of_a_wrench_that_has_stopped_are_bounded_and_counted():
    samples = ordered(200)
    line = pipeline()
    play(line, samples)
    assert not line.counts["joints_dropped_without_wrench"]
    last = next(s for s in samples[::-1] if isinstance(s, JointSample))
    ahead = 3 * STAMP_ORDER.most_joint_stamps
    play(line, [last._replace(t_ns=samples[-1].t_ns + 1 + k) for k in range(ahead)])
    assert line.counts["joints_dropped_without_wrench"] == ahead - REPROCESSING.most_waiting
    # Of the stamps before it the latest are still known.
    play(line, [samples[-2] if isinstance(samples[-2], JointSample) else samples[-3]])
    assert line.counts[REASON] + line.counts["joints_late"] == 1


def test_bounds_hold_with_joint_states_sent_twice():
    """Used twice, one noise counts as two: 89 % of the tilts were within their 95 % bounds."""
    result, inside = truth("closing_with_slip"), []
    for seed in range(1, 5):
        samples = list(measure(result, seed))
        line = Pipeline(result.plan.configuration)
        for found in play(line, twice(samples))[50:]:
            row = np.searchsorted(result.t_ns, found.t_ns - samples[0].t_ns)
            error = found.state[0] - result.q[row, 0]
            inside.append(abs(error) < 1.96 * np.sqrt(found.state_covariance[0, 0]))
    assert np.mean(inside) > 0.92
