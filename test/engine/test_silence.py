"""A wrench that is silent: its interval is bridged without a contact model, and counted once."""

import numpy as np
import pytest

from late_samples import MS, ordered, pipeline, play
from peg_on_hole_ros.records import JointSample, WrenchSample

BEGIN, END = 150, 350


def silent(begin_ms=BEGIN, end_ms=END, duration_ms=400):
    """Return samples without the wrenches strictly between two times, and those wrenches."""
    samples = ordered(duration_ms)
    start = samples[0].t_ns
    missing = [
        s
        for s in samples
        if isinstance(s, WrenchSample) and begin_ms * MS < s.t_ns - start < end_ms * MS
    ]
    return [s for s in samples if s not in missing], missing


def test_joint_states_that_go_on_do_not_hide_a_silent_wrench():
    samples, missing = silent()
    line = pipeline()
    play(line, samples)
    assert len(missing) > 190
    assert line.counts["gap"] == 1
    # They still correct.
    assert line.counts["joints_used"] == sum(isinstance(s, JointSample) for s in samples)


def test_the_wrench_after_a_silence_is_not_held_back_over_it():
    samples, missing = silent()
    first = next(s for s in samples if isinstance(s, WrenchSample) and s > missing[-1])
    ends = []
    for share in (1.0, 3.0):
        line = pipeline()
        pressed = first._replace(force=tuple(share * f for f in first.force))
        for sample in samples[: samples.index(first)]:
            line.on_sample(sample)
        ends.append(line.on_wrench(pressed))
    np.testing.assert_array_equal(ends[0].state, ends[1].state)
    np.testing.assert_array_equal(ends[0].state_covariance, ends[1].state_covariance)


@pytest.mark.parametrize("without_joints", [False, True])
def test_a_silence_counts_once_and_one_below_the_limit_not_at_all(without_joints):
    for length, expected in ((98, 0), (103, 1)):
        samples, missing = silent(BEGIN, BEGIN + length)
        if without_joints:
            between = missing[0].t_ns, missing[-1].t_ns
            samples = [s for s in samples if not between[0] <= s.t_ns <= between[1]]
        line = pipeline()
        play(line, samples)
        assert line.counts["gap"] == expected


def test_a_first_wrench_long_after_the_start_is_not_held_back_to_it():
    samples = ordered(300)
    start = samples[0].t_ns
    late = [s for s in samples if isinstance(s, JointSample) or s.t_ns - start > 200 * MS]
    line = pipeline()
    play(line, late)
    assert line.counts["gap"] == 1


def same_end(first, second):
    np.testing.assert_array_equal(second.filter.x, first.filter.x)
    np.testing.assert_array_equal(second.filter.P, first.filter.P)
    for name in ("gap", "joints_used", "wrench_used"):
        assert second.counts[name] == first.counts[name]


def test_a_joint_state_that_comes_late_into_a_silence_changes_nothing_of_it():
    samples, _ = silent()
    start = samples[0].t_ns
    late = next(s for s in samples if isinstance(s, JointSample) and s.t_ns - start > 320 * MS)
    rest = [s for s in samples if s is not late]
    at = next(i for i, s in enumerate(rest) if s.t_ns - start > 360 * MS)
    first, second = pipeline(), pipeline()
    play(first, samples)
    play(second, [*rest[:at], late, *rest[at:]])
    assert second.counts["went_back"] == 1
    same_end(first, second)


def test_a_wrench_that_comes_late_ends_a_silence_where_it_belongs():
    whole, missing = silent(BEGIN, BEGIN + 130)
    middle = missing[65]
    samples = sorted([*whole, middle], key=lambda s: s.t_ns)
    start = samples[0].t_ns
    at = next(i for i, s in enumerate(whole) if s.t_ns - start > (BEGIN + 135) * MS)
    first, second = pipeline(0.1), pipeline(0.1)
    play(first, samples)
    play(second, whole[:at])
    assert second.counts["gap"] == 1
    play(second, [middle, *whole[at:]])
    assert second.counts["went_back"] == 1
    same_end(first, second)
    assert second.counts["gap"] == 0
