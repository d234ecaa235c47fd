"""Late messages: put where they belong, everything since processed again, older ones counted."""

from dataclasses import replace

import numpy as np
import pytest

from late_samples import MS, SCENE, ordered, pipeline, play, shuffled, total, undoubted
from peg_on_hole_ros.engine import ring, snapshots
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.engine.state import ORIENTATION_WIDTH
from peg_on_hole_ros.engine.tuned import REPROCESSING
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.methods.registry import METHODS
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.ros.diagnostics import Diagnostics
from simulated import truth
from tiers import nightly

MOST_WRENCHES, STRIDE = REPROCESSING.most_wrenches, REPROCESSING.snapshot_stride


@pytest.mark.parametrize("most_ms", [3, 30])
def test_a_shuffled_stream_ends_where_the_ordered_one_does(most_ms):
    samples = ordered()
    late = shuffled(samples, most_ms * MS)
    assert late != samples
    first, second = pipeline(), pipeline()
    expected, found = play(first, samples), play(second, late)
    # Bit for bit: the same operations in the same order.
    np.testing.assert_array_equal(second.filter.x, first.filter.x)
    np.testing.assert_array_equal(second.filter.P, first.filter.P)
    for name in ("state", "state_covariance", "normal", "normal_stddev"):
        np.testing.assert_array_equal(getattr(found[-1], name), getattr(expected[-1], name))
    assert undoubted(found[-1].monitor) == undoubted(expected[-1].monitor)
    assert found[-1].alarms == expected[-1].alarms
    counts = second.counts
    for name in ("joints_used", "wrench_used"):
        assert counts[name] == first.counts[name]
    assert counts["joints_late"] > 20 and counts["wrench_late"] > 20
    assert counts["wrench_reprocessed"] > counts["went_back"] > 10
    assert not any("_dropped_" in name for name in counts)
    assert total(counts) == len(samples)


def test_what_a_stated_low_pass_lags_is_put_back_too():
    """The lag is that from the wrench before in stamps, not from the one processed before."""
    samples, stated = ordered(), pipeline().configuration
    stated = replace(stated, wrench=replace(stated.wrench, low_pass=5.0))
    line = [play(Pipeline(stated), each) for each in (samples, shuffled(samples, 30 * MS))]
    expected, found = line[0][-1], line[1][-1]
    assert expected.monitor["doubt_low_pass"] > 0.0
    np.testing.assert_array_equal(found.normal_stddev, expected.normal_stddev)


def test_late_joint_states_without_any_wrench_between_are_bounded_and_counted():
    """A wrench that has stopped while late joint states go on must not fill all memory."""
    samples = ordered(100)
    line, most = pipeline(), REPROCESSING.most_waiting
    play(line, samples)
    now = max(each.t_ns for each in samples if isinstance(each, WrenchSample))
    last = next(each for each in reversed(samples) if isinstance(each, JointSample))
    many = [last._replace(t_ns=now - 900_000 + 20 * k) for k in range(most + 200)]
    before = line.counts["joints_late"]
    play(line, many)
    assert line.counts["joints_late"] - before == len(many)
    dropped = line.counts["joints_dropped_without_wrench"]
    assert 200 <= dropped < 210
    heavier = next(each for each in reversed(samples) if isinstance(each, WrenchSample))
    assert play(line, [heavier._replace(t_ns=now + MS)])
    assert total(line.counts) == len(samples) + len(many) + 1


def test_without_a_window_the_shuffled_stream_ends_elsewhere():
    samples = ordered()
    first, second = pipeline(), pipeline(0.0)
    play(first, samples)
    play(second, shuffled(samples, 30 * MS))
    assert (second.filter.x != first.filter.x).any()
    assert second.counts["wrench_dropped_late"] > 20
    assert second.counts["joints_dropped_late"] > 20
    assert total(second.counts) == len(samples)


def test_what_was_given_out_is_not_given_again():
    samples = shuffled(ordered(), 10 * MS)
    line = pipeline()
    stamps = [outputs.t_ns for outputs in play(line, samples)]
    assert all(late > early for early, late in zip(stamps, stamps[1:]))
    assert len(stamps) + line.counts["wrench_late"] == line.counts["wrench_used"]


def test_a_message_older_than_the_window_is_counted_and_changes_nothing():
    samples = ordered(150)
    old = [
        next(s for s in samples[30:] if type(s) is kind) for kind in (JointSample, WrenchSample)
    ]
    rest = [s for s in samples if s not in old]
    ends = []
    for extra in ([], old):
        line = pipeline(0.02)
        play(line, [*rest[:-6], *extra, *rest[-6:]])
        ends.append(line.filter.x.copy())
    np.testing.assert_array_equal(*ends)
    assert line.counts["joints_dropped_late"] == line.counts["wrench_dropped_late"] == 1
    assert line.counts["went_back"] == 0


class StepByStep(ContactFilter):
    """The compiled estimator, which a derived class has called step by step from Python."""


def step_by_step(scene, options, noise, offsets=None):
    settings = default_settings(**METHODS[options.method].settings)
    return StepByStep(scene, options, noise, offsets, settings)


def test_a_filter_that_is_called_step_by_step_goes_back_for_late_messages_as_well():
    samples = shuffled(ordered(100), 10 * MS)
    first = pipeline()
    second = Pipeline(first.configuration, make=step_by_step)
    expected, found = play(first, samples), play(second, samples)
    assert first.counts["went_back"] > 5 and second.counts == first.counts
    assert [told.t_ns for told in found] == [told.t_ns for told in expected]
    np.testing.assert_allclose(second.filter.x, first.filter.x, rtol=1e-9, atol=1e-12)


def test_without_a_window_a_joint_state_is_late_by_the_delay_and_the_tolerance_at_most():
    """The delay is 10 ms, the tolerance 4 ms: of its own stamp it is 3 ms late, then 20 ms."""
    samples = ordered(150)
    joint = next(s for s in samples[::-1] if type(s) is JointSample)
    line = pipeline(0.0, delay=0.01)
    play(line, samples)
    for late_ms, dropped in ((3, 0), (20, 1)):
        line.on_joints(joint._replace(t_ns=samples[-1].t_ns - late_ms * MS + 100_000))
        assert line.counts["joints_dropped_late"] == dropped


def test_a_late_wrench_of_a_known_stamp_is_a_repetition():
    samples = ordered(100)
    again = [s for s in samples if type(s) is WrenchSample][-10]
    line = pipeline()
    play(line, [*samples, again])
    assert line.counts["wrench_dropped_repeated_stamp"] == 1 and line.counts["went_back"] == 0


def test_several_late_messages_go_back_once():
    samples = ordered(100)
    joints = [s for s in samples if type(s) is JointSample]
    late = joints[-8:-4]
    line, plain = pipeline(), pipeline()
    rest = [s for s in samples if s not in late]
    play(line, [*rest[:-3], *late, *rest[-3:]])
    play(plain, samples)
    assert line.counts["went_back"] == 1
    # 8 joint states at 500 Hz: from the wrench of the first late one to the latest.
    assert 8 <= line.counts["wrench_reprocessed"] <= 16 + STRIDE
    np.testing.assert_array_equal(line.filter.x, plain.filter.x)


def test_memory_is_bounded():
    samples = ordered(200)
    line = pipeline(0.02)
    play(line, shuffled(samples, 15 * MS))
    # One wrench a millisecond.
    assert 20 <= line.kept[0] <= 20 + 2 * STRIDE


def test_memory_of_the_fastest_wrench_is_bounded():
    """Without an estimate: 24 000 wrenches at 10 kHz, a window of 1.5 s, and late orientations."""
    line = pipeline()
    processor = line.processor
    kept, words = ring.new_ring(processor.filter.state), processor.words
    state, orientation = processor.filter.state, np.zeros(ORIENTATION_WIDTH)
    r, late = kept.places[0], 0
    for k in range(2 * MOST_WRENCHES):
        now = 100_000 * k
        ring.append_wrench(kept, r, now, np.zeros(6))
        if snapshots.is_due(kept.snapshots):
            snapshots.save(kept.snapshots, int(r["last"]) - 1, words, state)
        r["done"] = r["last"]
        ring.settle(kept, r, 1500 * MS)
        wrenches, states = int(r["last"] - r["first"]), snapshots.in_use(kept.snapshots)
        if k % 97 == 96:
            # From somewhere within what is kept, and all since anew.
            back = 1 + k * 37 % min(wrenches - 1, 4000)
            ring.put_late_orientation(kept, r, now - 100_000 * back, orientation)
            ring.rewind(kept, r, words, state)
            assert r["done"] >= r["first"]
            r["done"], r["restored"] = r["last"], 0
            late += 1
        assert wrenches < MOST_WRENCHES + 2 * STRIDE
        # Of the latest all, and of the others one in eight.
        assert states <= REPROCESSING.recent_snapshots + wrenches / STRIDE + 2
        assert snapshots.has_snapshot(kept.snapshots, int(r["first"]))
    assert late > 200
    assert r["reprocessed"] > 1000 * late
    assert r["last"] - r["first"] > MOST_WRENCHES - 2 * STRIDE


def test_the_longest_delay_is_within_what_is_kept_of_a_fast_wrench():
    """Wrenches at 5 kHz and a delay of 0.45 s: 2250 of them, and the window's 250."""
    delay = 450 * MS
    slow = ordered(550)
    fast = [
        s._replace(t_ns=s.t_ns + 200_000 * k)
        for s in slow
        if isinstance(s, WrenchSample)
        for k in range(5)
    ]
    joints = [s for s in slow if isinstance(s, JointSample)][:50:10]
    lines = pipeline(), pipeline(delay=delay * 1e-9)
    play(lines[0], sorted([*joints, *fast], key=lambda s: s.t_ns))
    first, *late = (s._replace(t_ns=s.t_ns + delay) for s in joints)
    play(lines[1], [first, *sorted([*late, *fast], key=lambda s: s.t_ns)])
    assert lines[1].counts["joints_dropped_late"] == 0
    assert lines[1].counts["joints_late"] == len(late)
    assert lines[1].counts["wrench_reprocessed"] > 2000 * len(late)
    np.testing.assert_array_equal(lines[1].filter.x, lines[0].filter.x)
    np.testing.assert_array_equal(lines[1].filter.P, lines[0].filter.P)


def test_a_tare_is_not_gone_back_behind():
    samples = ordered(120)
    late = next(s for s in samples[-40:] if type(s) is JointSample)
    rest = [s for s in samples if s is not late]
    line = pipeline()
    sensor = replace(line.configuration.wrench, tare_in_contact=True)
    line = Pipeline(replace(line.configuration, wrench=sensor))
    play(line, rest[:-4])
    assert line.tare().success
    play(line, [late, *rest[-4:]])
    assert line.counts["joints_dropped_late"] == 1 and line.counts["went_back"] == 0


def test_a_late_message_that_was_put_is_forgotten_by_a_reset():
    samples = ordered(100)
    late = next(s for s in samples[-40:] if type(s) is JointSample)
    line = pipeline()
    play(line, [*(s for s in samples if s is not late), late])
    line.reset()
    play(line, samples[-10:])
    assert line.counts["went_back"] == 0


@pytest.mark.parametrize("jump", [False, True])
def test_what_was_put_and_not_yet_processed_at_a_restart_is_counted(jump):
    samples = ordered(100)
    wrench = next(s for s in samples[-40:] if type(s) is WrenchSample)
    joints = [s for s in samples[-40:] if type(s) is JointSample]
    # One that would have corrected at once, had no other been put before it.
    after = joints[0]._replace(t_ns=samples[-1].t_ns)
    late = [joints[0], wrench, after]
    line = pipeline()
    rest = [s for s in samples if s not in late]
    assert type(rest[-1]) is WrenchSample
    play(line, [*rest, *late])
    if jump:
        for behind in (2000, 1999):
            line.on_wrench(wrench._replace(t_ns=wrench.t_ns - behind * MS))
    else:
        line.reset()
    assert line.counts["joints_dropped_restart"] == 2
    assert line.counts["wrench_dropped_restart"] == 1
    assert total(line.counts) == len(samples) + 1 + 2 * jump


def test_the_same_arrivals_give_the_same_bits():
    late = shuffled(ordered(200), 20 * MS)
    runs = [play(pipeline(), late) for _ in range(2)]
    for one, other in zip(*runs):
        np.testing.assert_array_equal(one.state, other.state)
        np.testing.assert_array_equal(one.state_covariance, other.state_covariance)
        assert one.monitor == other.monitor


def test_joint_states_that_are_always_late_lose_little():
    """A sensor that is 10 ms slow: reprocessed, the estimate is that of a fast one, 10 ms ago."""
    samples = ordered()
    slow = sorted(samples, key=lambda s: s.t_ns + 10 * MS * (type(s) is JointSample))
    line = pipeline()
    outputs = play(line, [samples[0], *(s for s in slow if s is not samples[0])])
    result, errors = truth(SCENE), []
    start = samples[0].t_ns + 300_000
    for found in outputs[100:]:
        row = np.searchsorted(result.t_ns, found.t_ns - start)
        errors.append((found.state[0] - result.q[row, 0]) / np.sqrt(found.state_covariance[0, 0]))
    # Predicted over 10 ms, with the covariance that this has; correlated over as long.
    assert np.mean(np.square(errors)) < 2.0
    assert line.counts["joints_dropped_late"] == 0


def stamped(samples, delay_ns):
    """Return samples whose joint states are stamped and arrive later by a delay."""
    moved = [
        s._replace(t_ns=s.t_ns + delay_ns) if isinstance(s, JointSample) else s for s in samples
    ]
    return sorted(moved, key=lambda s: s.t_ns)


@pytest.mark.parametrize("delay_ms", [-10, *nightly(10, 80)])
def test_a_known_delay_between_the_sensors_is_taken_out(delay_ms):
    samples = ordered(200)
    first = play_all(pipeline(), samples, 0)
    second = play_all(pipeline(delay=delay_ms * 1e-3), samples, delay_ms * MS)
    # Bit for bit, and also where the delay is longer than the window for what comes late.
    np.testing.assert_array_equal(second.filter.x, first.filter.x)
    np.testing.assert_array_equal(second.filter.P, first.filter.P)
    assert not any("joints_dropped" in name for name in second.counts)
    unknown = play_all(pipeline(), samples, delay_ms * MS)
    assert (unknown.filter.x != first.filter.x).any()


def play_all(line, samples, delay_ns):
    """Play samples whose joint states are delayed; the last wrenches find all of them there."""
    begin = samples[0]
    last = [s for s in samples if isinstance(s, WrenchSample)][-1]
    played = stamped(samples, delay_ns)
    played.remove(begin._replace(t_ns=begin.t_ns + delay_ns))
    played.remove(last)
    play(line, [begin._replace(t_ns=begin.t_ns + delay_ns), *played, last])
    return line


def test_diagnostics_tell_what_was_lost_from_what_came_late_or_is_usual():
    usual = {"wrench_late": 3, "joints_late": 2, "went_back": 4}
    report, lines = Diagnostics().report(0, 1, usual | {"joints_dropped_late": 1}, {})
    assert lines == ["joints dropped late: 1 time"]
    diagnostics = Diagnostics()
    diagnostics.report(0, 1, {"gap": 3}, {})
    # Going back may undo what was counted.
    assert diagnostics.report(0, 1, {"gap": 2}, {})[1] == []
