"""Finite but absurd messages: dropped at the door, and refused by what would remember them."""

import numpy as np
import pytest

from inputs import closing, joints, wrench
from late_samples import MS, ordered, pipeline, play
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.measurements.tuned import PLAUSIBLE_WRENCH
from peg_on_hole_ros.measurements.wrench_reduction import wrench_fault
from peg_on_hole_ros.messages.decode import Malformed, wrench_sample
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.records import JointSample, WrenchSample
from tiers import nightly

MOST_FORCE, MOST_TORQUE = PLAUSIBLE_WRENCH.most_force, PLAUSIBLE_WRENCH.most_torque
# Fields of a row that are finite whatever is known.
ARRAYS = (
    "state", "state_stddev", "state_covariance", "normal", "normal_stddev", "slip_speed",
    "slip_speed_stddev", "contact_wrench", "contact_point", "position", "rotation",
    "pose_covariance",
)  # fmt: skip


def not_finite(outputs):
    """Return the names of what is not finite, at any stamp."""
    found = set()
    for each in outputs:
        arrays = ((n, each.row[n]) for n in ARRAYS)
        alarms = ((alarm.name, alarm.numbers) for alarm in each.alarms)
        for name, value in (*each.monitor.items(), *arrays, *alarms):
            if not np.isfinite(np.array(value, float)).all():
                found.add(name)
    return found


def with_one(samples, kind, at_ms, **changes):
    """Return samples of which the first of a kind after a time is changed, and its place."""
    start = samples[0].t_ns
    at = next(i for i, s in enumerate(samples) if type(s) is kind and s.t_ns - start > at_ms * MS)
    return [*samples[:at], samples[at]._replace(**changes), *samples[at + 1 :]], at


@pytest.mark.parametrize("kind", ["force", "torque"])
@pytest.mark.parametrize("size", [2e6, -1e308, *nightly(1e20, 1e200)])
def test_a_wrench_that_no_sensor_measures_is_dropped(kind, size):
    samples, at = with_one(ordered(250), WrenchSample, 150, **{kind: (0.0, size, 1.0)})
    line, plain = pipeline(), pipeline()
    found, expected = play(line, samples), play(plain, samples[:at] + samples[at + 1 :])
    assert line.counts["wrench_dropped_out_of_range"] == 1
    assert not_finite(found) == set()
    np.testing.assert_array_equal(found[-1].state, expected[-1].state)
    assert found[-1].monitor == expected[-1].monitor


def test_the_door_lets_in_what_is_large_and_nothing_that_is_no_number():
    fields = 0, (0.0, 0.0, MOST_FORCE), (MOST_TORQUE, 0.0, 0.0)
    assert wrench_fault(WrenchSample(*fields)) is None
    reasons = {1.1 * MOST_FORCE: "out_of_range", -1e308: "out_of_range"}
    for value, reason in (reasons | {np.inf: "not_finite", np.nan: "not_finite"}).items():
        for i in (1, 2):
            sample = WrenchSample(*fields)._replace(**{("force", "torque")[i - 1]: (value, 0, 0)})
            assert wrench_fault(sample) == reason


@pytest.mark.parametrize("kind", ["force", "torque"])
def test_the_largest_that_is_let_in_is_not_remembered(kind):
    size, at_ms = {"force": MOST_FORCE, "torque": MOST_TORQUE}[kind] / 2.0, 150
    samples, _ = with_one(ordered(250), WrenchSample, at_ms, **{kind: (size, -size, size)})
    outputs = play(pipeline(), samples)
    start = samples[0].t_ns
    assert sum(each.t_ns - start > (at_ms + 1.5) * MS for each in outputs) > 90
    assert not_finite(outputs) == set()


@pytest.mark.parametrize("at_ms", [-1, 150])
@pytest.mark.parametrize("size", [2e6, 1e300, *nightly(1e16, 1e100)])
def test_angles_that_no_joint_counts_are_dropped(at_ms, size):
    samples, _ = with_one(ordered(250), JointSample, at_ms, position=(0.15, size, -size))
    line = pipeline()
    assert not_finite(play(line, samples)) == set()
    assert line.counts["joints_dropped_out_of_range"] == 1


def test_the_messages_are_counted_by_the_node_and_a_replay():
    assert wrench_sample(wrench(0, force=(1e200, 0.0, 0.0))) == Malformed("out_of_range")
    assert wrench_sample(wrench(0, torque=(0.0, -2e6, 0.0))) == Malformed("out_of_range")
    stream = message_stream(Configuration())
    for k, (source, message) in enumerate(closing(60)):
        stream.on_joints(message) if source == "joints" else stream.on_wrench(message)
        if k == 40:
            t_ns = 10_020_000_001
            assert stream.on_wrench(wrench(t_ns, force=(0.0, 0.0, 1e200))) == []
            stream.on_joints(joints(t_ns, psi=1e200))
    counts = stream.counts
    assert counts["wrench_dropped_malformed_out_of_range"] == 1
    assert counts["joints_dropped_out_of_range"] == 1
