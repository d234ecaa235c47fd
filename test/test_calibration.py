"""Calibration finds what was put into a recording, says how well, and what it cannot tell."""

from functools import cache

import numpy as np
import pytest

from peg_on_hole_ros.edges import calibration_text
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.estimation.calibration import calibrate
from peg_on_hole_ros.estimation.inverse_dynamics import fit
from peg_on_hole_ros.estimation.likelihood import (
    NAMES,
    QUANTITIES,
    configured,
    innovations,
    start_values,
)
from peg_on_hole_ros.estimation.noise_levels import noise_levels
from peg_on_hole_ros.estimation.recording import recording, steady
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.records import AngleMeasurement, JointSample, WrenchSample
from recorded import between, disturbed, with_friction

BIAS = (1.0, -0.5, 2.0, 0.02, -0.03, 0.01)
TILT = (0.0035, -0.002)  # 0.2 and 0.1 degree
DELAY = 2e-3
NOISE = (0.15, 0.003)  # on 0.2 N and 0.005 N m
FRICTION = 0.2
CLEARANCE = 1e-4
LEVELS = (np.hypot(0.2, 0.15), np.hypot(0.005, 0.003), 1e-4)
TRUTH = dict(zip(NAMES, (FRICTION, *BIAS, *TILT, DELAY, CLEARANCE)))
TRUTH |= dict(zip(("force_stddev", "torque_stddev", "position_stddev"), LEVELS))


@cache
def changed():
    record, configuration = disturbed("working_cycle", BIAS, TILT, DELAY, NOISE)
    return between(record, 1.2, 5.8), configuration


@cache
def calibrated():
    record, configuration = changed()
    return calibrate(record, with_friction(configuration, 0.5 * FRICTION))


def test_intervals_hold_what_was_put_in():
    found = calibrated()
    inside = [one.name for one in found.estimates if one.low <= TRUTH[one.name] <= one.high]
    # 14 intervals of 95 %, several of them correlated: two may miss, none by another half width.
    assert len(inside) >= 12, inside
    for one in found.estimates:
        half = 0.5 * (one.high - one.low)
        assert abs(TRUTH[one.name] - 0.5 * (one.high + one.low)) < 2 * half, one


def test_intervals_are_narrow_enough_to_be_of_use():
    spread = {one.name: (one.high - one.low) / 3.92 for one in calibrated().estimates}
    assert spread["friction"] < 0.01 * FRICTION
    assert max(spread[f"bias_force_{axis}"] for axis in "xyz") < 0.3
    assert max(spread[f"bias_torque_{axis}"] for axis in "xyz") < 0.03
    assert spread["clearance"] < 0.05 * CLEARANCE
    assert all(spread[name] < 0.03 * level for name, level in zip(TRUTH, LEVELS) if "std" in name)


@pytest.mark.parametrize("start", [0.5, 1.5, 4.0])
def test_friction_is_found_from_a_start_far_off(start):
    record, configuration = changed()
    configuration = with_friction(configuration, start * FRICTION)
    parts = steady(record, configuration)
    values, _ = fit(record, parts, configuration, start_values(configuration))
    assert values[0] == pytest.approx(FRICTION, rel=0.01)


def test_the_calibrated_configuration_replays_with_innovations_of_their_size():
    record, _ = changed()
    assert mean_nis(record, calibrated().configuration) == pytest.approx(3.0, abs=0.5)


def test_a_wrong_configuration_does_not():
    record, configuration = changed()
    assert not abs(mean_nis(record, configuration) - 3.0) < 0.5


def mean_nis(record, configuration):
    """Mean NIS of the pipeline in declared three-point contact."""
    pipeline = Pipeline(configuration)
    events = [
        (t, 0, JointSample(round(t * 1e9), ("gamma", "psi", "phi"), tuple(q)))
        for t, q in zip(record.joint_t, record.q.tolist())
    ]
    events += [
        (t, 1, WrenchSample(round(t * 1e9), tuple(row[:3]), tuple(row[3:])))
        for t, row in zip(record.wrench_t, record.wrench.tolist())
    ]
    seen = []
    for _, kind, sample in sorted(events, key=lambda event: event[:2]):
        if not kind:
            pipeline.on_joints(sample)
            continue
        outputs = pipeline.on_wrench(sample)
        if outputs is not None and sample.t_ns * 1e-9 > record.wrench_t[0] + 0.5:
            seen.append(pipeline.health["nis_mean"])
    assert pipeline.counts["joints_dropped_late"] == 0
    return float(np.mean(seen))


def test_a_short_closing_motion_does_not_tell_all_and_says_what():
    record, configuration = disturbed("closing_with_slip")
    found = calibrate(record, configuration)
    unseen = {one.name for one in found.estimates if not one.seen}
    assert {"tilt_x", "tilt_y"} <= unseen
    for one in found.estimates:
        if one.name in unseen:
            start = start_values(configuration)[NAMES.index(one.name)]
            assert one.value == pytest.approx(start, abs=1e-12)
    words = calibration_text.not_seen(found)
    assert len(words) == len(unseen)
    assert "only while the peg turns" in " ".join(words)
    heading = calibration_text.heading(found, "a.mcap", "the defaults")
    assert "Not seen in this recording, kept as at the start:" in heading


def test_a_clearance_far_from_gamma0_is_not_seen():
    record, configuration = disturbed("working_cycle", noise=(1.0, 0.05))
    found = calibrate(between(record, 1.25, 2.1), configuration)
    words = [line for line in calibration_text.not_seen(found) if line.startswith("clearance")]
    assert found.least_tilt > 2
    assert words and "came no nearer to gamma0 than" in words[0]


@pytest.mark.parametrize("size", [0.5, 1.0, 3.0])
def test_noise_comes_from_the_noise_and_not_from_the_motion(size):
    rng = np.random.default_rng(int(10 * size))
    t = 1e-3 * np.arange(6000)
    # A swing of a thousand times the noise, an impact, and a step.
    motion = 200 * np.sin(6 * t) + 50 * (t > 2) + 500 * np.exp(-(((t - 4) / 2e-3) ** 2))
    wrench = motion[:, None] + rng.normal(size=(6000, 6)) * np.repeat([0.2 * size, 0.005], 3)
    q = np.column_stack([0.2 + 0.1 * np.sin(t), t, 2 * t])[::2]
    covariance = np.broadcast_to(np.diag([1e-8, 2e-8, 3e-8]), (3000, 3, 3))
    q = q + size * rng.normal(size=q.shape) * np.sqrt([1e-8, 2e-8, 3e-8])
    wrenches = [
        WrenchSample(round(s * 1e9), tuple(row[:3]), tuple(row[3:])) for s, row in zip(t, wrench)
    ]
    measurements = [
        AngleMeasurement(round(s * 1e9), row, R) for s, row, R in zip(t[::2], q, covariance)
    ]
    force, torque, orientation = noise_levels(recording(wrenches, measurements))
    # Four standard deviations: four of these checks fail by chance once in thousands of seeds.
    for level, truth in ((force, 0.2 * size), (torque, 0.005), (orientation, size)):
        assert abs(level.value - truth) < 4 * level.stddev
        assert level.stddev < 0.03 * truth


def test_a_recording_is_in_the_order_of_stamps_without_repeats_or_jumps_by_turns():
    wrenches = [WrenchSample(t, (float(t), 0.0, 0.0), (0.0,) * 3) for t in (30, 10, 20, 20)]
    angles = [(0.1, 3.1, -3.1), (0.1, -3.1, 3.1)]
    measurements = [AngleMeasurement(t, np.array(q), np.eye(3)) for t, q in zip((15, 25), angles)]
    record = recording(wrenches, measurements)
    assert record.wrench[:, 0].tolist() == [10, 20, 30]
    assert np.diff(record.q[:, 1:], axis=0) == pytest.approx(
        np.array([[2 * np.pi - 6.2, 6.2 - 2 * np.pi]])
    )


def test_values_reach_the_configuration_and_come_back():
    start = Configuration()
    values = start_values(start) + [quantity.step for quantity in QUANTITIES]
    back = start_values(configured(start, values))
    back[[NAMES.index("tilt_x"), NAMES.index("tilt_y")]] = values[7:9]
    assert back == pytest.approx(values, rel=1e-12)
    gravity = np.array(configured(start, values).scene.gravity)
    assert gravity[:2] / -gravity[2] == pytest.approx(values[7:9], rel=1e-6)
    assert np.linalg.norm(gravity) == pytest.approx(9.80665, rel=1e-12)


def test_friction_that_leaves_no_motion_has_no_likelihood():
    record, configuration = changed()
    parts = steady(record, configuration)
    assert innovations(record, parts, with_friction(configuration, 1.5)) is None


def test_a_recording_without_sliding_is_refused_with_what_to_record():
    record, configuration = changed()
    with pytest.raises(BagError, match=r"only 0 joint states while all three contacts slide"):
        calibrate(between(record, 1.2, 1.25), configuration)
