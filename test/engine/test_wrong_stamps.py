"""One stamp that is wrong costs its message, and not the estimate."""

import numpy as np
import pytest

from estimates import columns
from late_samples import MS, ordered, pipeline, play, total, undoubted
from peg_on_hole_ros.engine.tuned import REPROCESSING
from peg_on_hole_ros.messages.beside_estimates import OutputStream
from peg_on_hole_ros.messages.tries import Tries
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.replay.summary import Summary
from tiers import at_push

AT = 150


def of_kind(samples, kind, begin):
    return next(i for i, s in enumerate(samples) if i >= begin and isinstance(s, kind))


def apart(counts, expected):
    return {k: counts[k] - expected[k] for k in {*counts, *expected} if counts[k] != expected[k]}


@pytest.mark.parametrize("kind", [WrenchSample, JointSample])
@pytest.mark.parametrize("stamp", [0, -2000 * MS])
def test_one_stamp_far_back_is_late_and_no_clock(kind, stamp):
    samples = ordered()
    # The same message again, without a stamp, or two seconds late.
    i = of_kind(samples, kind, AT)
    wrong = samples[i]._replace(t_ns=samples[i].t_ns + stamp if stamp else 0)
    first, second = pipeline(), pipeline()
    expected = play(first, samples)
    found = play(second, [*samples[: i + 1], wrong, *samples[i + 1 :]])
    assert [o.t_ns for o in found] == [o.t_ns for o in expected]
    np.testing.assert_array_equal(found[-1].state, expected[-1].state)
    source = "wrench" if kind is WrenchSample else "joints"
    assert apart(second.counts, first.counts) == {f"{source}_dropped_late": 1}


@pytest.mark.parametrize("kind", [WrenchSample, JointSample])
def test_stamps_that_stand_still_far_back_are_no_clock_either(kind):
    samples = ordered()
    line, found = pipeline(), []
    for i, sample in enumerate(samples):
        found += play(line, [sample])
        if AT < i < AT + 20:
            found += play(line, [samples[of_kind(samples, kind, 0)]._replace(t_ns=7)])
    assert line.counts["clock_jumped_back"] == 0
    assert len(found) == len([s for s in samples if isinstance(s, WrenchSample)])


@pytest.mark.parametrize("kind", [WrenchSample, JointSample])
def test_two_stamps_in_a_row_that_go_on_are_a_clock(kind):
    """By one topic alone, too: the other may be silent."""
    samples = ordered()
    line = pipeline()
    play(line, [s._replace(t_ns=s.t_ns + 5000 * MS) for s in samples])
    again = [s for s in samples if isinstance(s, kind)][:2]
    play(line, again[:1])
    assert line.counts["clock_jumped_back"] == 0
    play(line, again[1:])
    assert line.counts["clock_jumped_back"] == 1


@pytest.mark.parametrize("ahead_ms", [80, 900, 10_000])
def test_a_wrench_far_ahead_is_undone_by_the_next(ahead_ms):
    samples = ordered()
    i = of_kind(samples, WrenchSample, AT)
    wrong = samples[i]._replace(t_ns=samples[i].t_ns + ahead_ms * MS)
    first, second = pipeline(), pipeline()
    expected = play(first, samples)
    found = play(second, [*samples[: i + 1], wrong, *samples[i + 1 :]])
    # The first of its stamp; ten seconds without an orientation give none.
    ahead = [k for k, o in enumerate(found) if o.t_ns == wrong.t_ns][:1]
    assert len(ahead) == (ahead_ms < 5000)
    for k in ahead:
        told = found.pop(k)
        assert ahead_ms < 100 or not told.monitor["reactions_determined"]
    assert [o.t_ns for o in found] == [o.t_ns for o in expected]
    for a, b in zip(found, expected):
        np.testing.assert_array_equal(a.state, b.state)
        np.testing.assert_array_equal(a.normal_stddev, b.normal_stddev)
        assert a.contact_mode == b.contact_mode
        assert undoubted(a.monitor) == undoubted(b.monitor)
    # A joint state that came in between was late for the wrong one.
    events = apart(second.counts, first.counts)
    assert events.pop("wrench_dropped_ahead") == 1 and set(events) <= {"joints_late"}
    assert total(second.counts) == total(first.counts) + 1


@pytest.mark.parametrize("begin", at_push([AT, AT + 12], range(AT, AT + 24, 3)))
@pytest.mark.parametrize("after", [1, 40])
def test_late_messages_are_put_in_their_place_after_it(begin, after):
    """What is kept for them begins anew, with a snapshot."""
    samples = ordered()
    # No orientation comes beside it.
    kinds = [type(s) for s in samples]
    i = next(k for k in range(begin, len(kinds)) if kinds[k : k + 2] == [WrenchSample] * 2)
    wrong = samples[i]._replace(t_ns=samples[i].t_ns + 900 * MS)
    stream = [*samples[: i + 1], wrong, *samples[i + 1 :]]
    late = of_kind(stream, JointSample, i + after)
    stream.insert(late + 6, stream.pop(late))
    first, second = pipeline(), pipeline()
    play(first, samples)
    play(second, stream)
    np.testing.assert_array_equal(second.filter.x, first.filter.x)
    np.testing.assert_array_equal(second.filter.P, first.filter.P)
    assert second.counts["joints_late"] >= 1


def test_after_a_silence_a_late_wrench_is_late():
    """The newest stays, although the one before it comes behind it."""
    samples = ordered()
    wrenches = [k for k, s in enumerate(samples) if isinstance(s, WrenchSample)]
    begin, end = wrenches[100], wrenches[220]
    stream = [*samples[:begin], *samples[end:]]
    swapped = stream.copy()
    after = [k for k, s in enumerate(swapped) if isinstance(s, WrenchSample)][100:102]
    swapped[after[0]], swapped[after[1]] = swapped[after[1]], swapped[after[0]]
    line = pipeline()
    play(line, swapped)
    assert line.counts["wrench_dropped_ahead"] == 0 and line.counts["wrench_late"] == 1


def test_a_try_and_its_duration_go_on_over_it():
    samples = ordered()
    i = of_kind(samples, WrenchSample, AT)
    wrong = samples[i]._replace(t_ns=samples[i].t_ns + 900 * MS)
    tries, durations = [], []
    for stream in (samples, [*samples[: i + 1], wrong, *samples[i + 1 :]]):
        line, cycles, summary, found = pipeline(), Tries(), Summary(), []
        said = OutputStream(line.scene)
        for outputs in line.play(stream):
            made = columns(said, outputs)
            found += [record for _, records in cycles.take(made) for record in records]
            summary.take(made)
        tries.append(found + cycles.finish())
        durations.append(summary.content()["duration"])
    assert len(tries[0]) == len(tries[1]) == 1
    assert tries[1][0]["duration"] == tries[0][0]["duration"] > 0.2
    assert durations[1] == pytest.approx(durations[0], abs=1e-9)


def test_a_joint_state_far_ahead_waits_and_holds_up_no_other():
    samples = ordered()
    i = of_kind(samples, JointSample, AT)
    wrong = samples[i]._replace(t_ns=samples[i].t_ns + 10_000 * MS)
    first, second = pipeline(), pipeline()
    expected = play(first, samples)
    found = play(second, [*samples[: i + 1], wrong, *samples[i + 1 :]])
    for one, other in zip(expected, found, strict=True):
        assert other.t_ns == one.t_ns and other.contact_mode == one.contact_mode
        np.testing.assert_array_equal(other.state, one.state)
        np.testing.assert_array_equal(other.state_covariance, one.state_covariance)
        np.testing.assert_array_equal(other.normal_stddev, one.normal_stddev)
        assert other.monitor == one.monitor
    # All that follow come behind it and go before it; it has no wrench yet, and no fate.
    events = apart(second.counts, first.counts)
    assert set(events) == {"joints_reordered"} and events["joints_reordered"] > 50
    assert total(second.counts) == len(samples)


def test_of_joint_states_without_a_wrench_the_oldest_goes():
    """A wrench's clock that stands still: 512 wait, and the first of 513 is not used."""
    samples = ordered()
    i = of_kind(samples, WrenchSample, AT)
    at, last = samples[i].t_ns, samples[of_kind(samples, JointSample, i)]
    step_ns = 10 * MS // (REPROCESSING.most_waiting + 2)
    ahead = [last._replace(t_ns=at + k * step_ns) for k in range(1, REPROCESSING.most_waiting + 2)]
    wrench = samples[i]._replace(t_ns=at + 10 * MS)

    def given(waiting):
        line = pipeline()
        (outputs,) = play(line, [*samples[: i + 1], *waiting, wrench])[-1:]
        return line.counts, outputs

    assert len(ahead) == REPROCESSING.most_waiting + 1 == 513
    counts, found = given(ahead)
    full, expected = given(ahead[1:])
    assert apart(counts, full) == {"joints_dropped_without_wrench": 1}
    assert full["joints_dropped_without_wrench"] == 0
    np.testing.assert_array_equal(found.state, expected.state)
    np.testing.assert_array_equal(found.state_covariance, expected.state_covariance)
    # The newest does matter.
    _, other = given(ahead[:-1])
    assert (found.state != other.state).any()
