"""Without any orientation for long the motion is let go of, counted, and begun anew with one."""

from itertools import product
from math import isfinite, pi

import numpy as np
import pytest

from late_samples import total, undoubted
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.engine.tuned import KNOWN_MOTION
from peg_on_hole_ros.records import JointSample, WrenchSample
from steady_slide import BEGIN, MS, motion, orientation, wrench
from tiers import at_push

LOST = KNOWN_MOTION.lost
LOST_MS = round(LOST * 1e3)


def pause(silence_ms, end_ms=None, wrenches=False, first="joint", count=400, step=1, rate=-0.05):
    """
    Return samples, orientations of which are silent for a while in the middle.

    Wrenches go on if asked to, every so many ms; `first` says what comes first after it.
    """
    random, found = np.random.default_rng(0), []
    back = count + silence_ms
    for k in [*range(count), *(range(count, back, step) if wrenches else ()),
              *range(back, end_ms or back + count)]:  # fmt: skip
        # Wrenches of a silence are those of its begin.
        moved = k if k < count else max(k - silence_ms, count)
        if k % 2 == 0 and not count <= k < back and not (k == back and first == "wrench"):
            found.append(orientation(moved, random, rate)._replace(t_ns=BEGIN + k * MS))
        found.append(wrench(k, random, moved, rate))
    return found


def sane(outputs):
    for out in outputs:
        assert -pi / 2 < out.state[0] < pi / 2
        assert (np.diagonal(out.state_covariance) >= 0.0).all()
        assert (np.diagonal(out.pose_covariance) >= 0.0).all()
        for spread in (out.normal_stddev, out.slip_speed_stddev):
            assert (spread >= 0.0).all() and np.isfinite(spread).all()
        assert all(isfinite(value) for value in out.monitor.values())


def fates(line):
    return total(line.counts) + line.counts["joints_gated"]


def same(first, second):
    np.testing.assert_array_equal(second.filter.x, first.filter.x)
    np.testing.assert_array_equal(second.filter.P, first.filter.P)
    assert second.processor.oriented == first.processor.oriented
    for name in (
        "motion_lost",
        "joints_used",
        "wrench_used",
        "wrench_dropped_without_orientation",
    ):
        assert second.counts[name] == first.counts[name], name


OPEN = {"wrench.bias_force_stddev": 1.0, "joints.hole_tilt_stddev": 0.01}
PAUSES = [
    ({}, 14 * 3600.0, "wrench"),
    (OPEN, LOST + 0.1, "joint"),
    ({"monitor.modes": False}, 60.0, "joint"),
]
ALL_PAUSES = product(
    ({}, OPEN, {"monitor.modes": False}),
    (LOST + 0.1, 60.0, 3600.0, 14 * 3600.0),
    ("joint", "wrench"),
)


@pytest.mark.parametrize(("settings", "silence_s", "first"), at_push(PAUSES, ALL_PAUSES))
def test_after_a_pause_the_motion_begins_anew(settings, silence_s, first):
    line = Pipeline(from_parameters(settings))
    samples = pause(round(silence_s * 1e3), first=first)
    outputs = list(line.play(samples))
    sane(outputs)
    assert line.counts["motion_lost"] == 1
    # Until there is an orientation, nothing is told; it comes with the second wrench after.
    dropped = 0 if first == "joint" else 2
    assert line.counts["wrench_dropped_without_orientation"] == dropped
    assert len(outputs) == sum(isinstance(s, WrenchSample) for s in samples) - dropped
    assert fates(line) == len(samples)
    after = [o for o in outputs if o.t_ns > BEGIN + 400 * MS]
    assert after[0].contact_mode == "unknown"
    assert line.counts["joints_gated"] == 0
    for out in after[100:]:
        moved = (out.t_ns - BEGIN) / MS - round(silence_s * 1e3)
        end, spread = out.state[0], np.sqrt(out.state_covariance[0, 0])
        assert abs(end - motion(moved)[0][0]) < 5 * spread
        # As known as the hole's direction is.
        assert spread < 1e-3 + settings.get("joints.hole_tilt_stddev", 0.0)


def test_it_begins_as_any_other_does():
    settings = {"scene.friction_stddev": 0.0}
    samples = pause(LOST_MS + 200)
    begin = next(i for i, s in enumerate(samples) if s.t_ns > BEGIN + LOST_MS * MS)
    first, second = (Pipeline(from_parameters(settings)) for _ in range(2))
    for before in samples[:begin]:
        second.on_sample(before)
    for one, other in zip(first.play(samples[begin:]), second.play(samples[begin:]), strict=True):
        told = undoubted(other.monitor)
        for name, value in undoubted(one.monitor).items():
            assert told[name] == value, name
        np.testing.assert_array_equal(other.state_covariance, one.state_covariance)
        np.testing.assert_array_equal(other.normal, one.normal)
        assert other.contact_mode == one.contact_mode


def test_what_was_learnt_stays():
    line = Pipeline(from_parameters({"scene.friction_stddev": 0.1}))
    samples = pause(round(LOST_MS * 1.1))
    list(line.play(samples[:600]))
    learnt, known_to = line.filter.friction
    list(line.play(samples[600:603]))
    assert line.counts["motion_lost"] == 1
    value, spread = line.filter.friction
    assert known_to < 0.05
    assert value == pytest.approx(learnt, abs=0.1 * known_to)
    assert spread == pytest.approx(known_to, rel=0.2)


def test_a_tilt_of_the_hole_is_known_as_stated_at_first():
    line = Pipeline(from_parameters(OPEN))
    first = next(iter(line.play(pause(LOST_MS))))
    assert first.hole_tilt_stddev == pytest.approx([0.01, 0.01], rel=1e-2)


@pytest.mark.xfail(
    strict=True,
    reason="without orientations the wrench alone drives the rates until the motion is lost",
)
def test_wrenches_that_go_on_are_told_of_for_a_while_and_then_dropped():
    line = Pipeline(from_parameters({}))
    samples = pause(9000, wrenches=True, step=5)
    outputs = list(line.play(samples))
    sane(outputs)
    silent = [o for o in outputs if BEGIN + 1000 * MS < o.t_ns < BEGIN + 9400 * MS]
    assert {o.contact_mode for o in silent} == {"unknown"}
    # The last orientation was 398 ms after the begin.
    assert silent[-1].t_ns == BEGIN + (395 + LOST_MS) * MS
    assert line.counts["joints_gap"] == line.counts["motion_lost"] == 1
    assert line.counts["wrench_dropped_without_orientation"] == 800
    assert fates(line) == len(samples)
    assert outputs[-1].contact_mode != "unknown"


@pytest.mark.xfail(
    strict=True,
    reason="without orientations the wrench alone drives the rates until the motion is lost",
)
def test_a_longer_silence_that_is_allowed_is_no_loss():
    line = Pipeline(from_parameters({"filter.max_joint_gap": 8.0}))
    list(line.play(pause(7000, wrenches=True, step=5)))
    assert line.counts["motion_lost"] == line.counts["joints_gap"] == 0
    line = Pipeline(from_parameters({"filter.max_joint_gap": 8.0}))
    list(line.play(pause(9000, wrenches=True, step=5)))
    assert line.counts["motion_lost"] == 1


@pytest.mark.nightly
def test_a_tilt_beyond_a_quarter_turn_is_never_told():
    """It opens at 1 rad/s, and orientations end: a second later it would be lying down."""
    line = Pipeline(from_parameters({}))
    outputs = list(line.play(pause(4000, wrenches=True, rate=1.0)))
    sane(outputs)
    assert line.counts["motion_lost"] == 1
    assert line.counts["wrench_dropped_without_orientation"] > 1000
    assert outputs[-1].state[0] == pytest.approx(0.15 + 0.8, abs=0.01)


@pytest.mark.parametrize("late_ms", [3, 40])
def test_a_late_orientation_leads_where_an_ordered_stream_does(late_ms):
    samples = pause(LOST_MS + 200, wrenches=True, step=5)
    back = next(
        i
        for i, s in enumerate(samples)
        if isinstance(s, JointSample) and s.t_ns >= BEGIN + (LOST_MS + 600) * MS
    )
    moved = samples[back]
    at = next(i for i, s in enumerate(samples) if s.t_ns > moved.t_ns + late_ms * MS)
    late = [*samples[:back], *samples[back + 1 : at], moved, *samples[at:]]
    first, second = (Pipeline(from_parameters({})) for _ in range(2))
    list(first.play(samples))
    list(second.play(late))
    assert second.counts["went_back"] >= 1
    same(first, second)


def test_one_just_after_the_wrench_of_its_stamp_begins_too():
    samples = pause(LOST_MS + 200, wrenches=True)
    swapped = list(samples)
    i = next(i for i, s in enumerate(samples) if s.t_ns == BEGIN + (LOST_MS + 600) * MS)
    swapped[i], swapped[i + 1] = swapped[i + 1], swapped[i]
    lines = []
    for window in (0.05, 0.0):
        line = Pipeline(from_parameters({"filter.late_window": window}))
        lines.append(line)
        sane(list(line.play(swapped)))
        assert line.counts["motion_lost"] == 1 and line.processor.oriented
        assert fates(line) == len(samples)
    # And anew, where a later one is late.
    late = [*swapped[: i + 3], *swapped[i + 4 : i + 9], swapped[i + 3], *swapped[i + 9 :]]
    assert isinstance(swapped[i + 3], JointSample)
    line = Pipeline(from_parameters({}))
    list(line.play(late))
    assert line.counts["went_back"] == 1
    same(lines[0], line)


def test_no_window_and_a_late_orientation_begin_with_what_the_peg_may_have_turned():
    settings = {"filter.late_window": 0.0, "filter.late_tolerance": 0.02}
    line, random = Pipeline(from_parameters(settings)), np.random.default_rng(1)
    list(line.play(pause(LOST_MS + 200, end_ms=LOST_MS + 600, wrenches=True, step=5)))
    assert not line.processor.oriented
    line.on_wrench(wrench(LOST_MS + 610, random))
    line.on_joints(orientation(LOST_MS + 600, random, 0.0))
    assert line.processor.oriented
    assert line.filter.P[0, 0] == pytest.approx(1e-8 + 0.01**2)


def test_no_tare_while_lost():
    line, random = Pipeline(from_parameters({})), np.random.default_rng(1)
    list(line.play(pause(LOST_MS + 200, end_ms=LOST_MS + 600, wrenches=True, step=5)))
    assert not line.tare().success
    line.on_joints(orientation(LOST_MS + 600, random, 0.0))
    line.on_wrench(wrench(LOST_MS + 601, random))
    # One joint state shows no peg that is still, however many wrenches there were before it.
    assert not line.tare().success


def test_a_late_orientation_from_before_it_was_lost_finds_the_motion_again():
    line = Pipeline(from_parameters({}))
    samples = iter(pause(LOST_MS + 200, wrenches=True, step=5))
    at = next(s.t_ns for s in samples if line.on_sample(s) is None and line.counts["motion_lost"])
    assert not line.processor.oriented
    line.on_joints(orientation(400, np.random.default_rng(1), 0.0)._replace(t_ns=at - 20 * MS))
    line.on_sample(next(samples))
    assert line.processor.oriented and line.counts["went_back"] == 1
    # What is gone back behind has not happened.
    assert line.counts["motion_lost"] == 0
