"""Calibration finds what was put into a recording, says how well, and what it cannot tell."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from peg_on_hole_ros.bags.simulated_bag import write_bag
from peg_on_hole_ros.cli.calibration_text import not_seen, rows
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.configuration import from_parameters, to_parameters
from peg_on_hole_ros.config.options import Configuration, JointInput
from peg_on_hole_ros.config.parameters_file import read_parameters, write_parameters
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.identification.calibration import calibrate
from peg_on_hole_ros.identification.likelihood import Likelihood
from peg_on_hole_ros.identification.low_pass import noise_of_neighbours
from peg_on_hole_ros.identification.noise_levels import noise_levels
from peg_on_hole_ros.identification.quantities import (
    CALIBRATED_QUANTITIES,
    QUANTITY_NAMES,
    TILT_AT,
    configured,
    coordinates,
    measures,
)
from peg_on_hole_ros.identification.recording import (
    load,
    motion,
    recording,
    shortfall,
    slow_slip,
    steady,
    turned,
)
from peg_on_hole_ros.identification.selection import conditional, kept_ones
from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.records import AngleMeasurement, JointSample, WrenchSample
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.sim.truth import integrate
from simulated import contact_plan
from simulated import truth as simulated_truth

pytestmark = pytest.mark.xdist_group("simulation")

TRUE = {
    "friction": 0.2,
    "bias_force_x": 1.0,
    "bias_force_z": 2.0,
    "bias_torque_y": 0.03,
    "delay": 3e-3,
    "clearance": 1e-4,
    "force_stddev": 0.3,
}
# A closing and an opening motion with turns both ways, pressed.
PHASES = {
    "close": {"kind": "contact", "duration": 0.5, "rates": [-0.25, 0.6, 1.2]},
    "back": {"kind": "contact", "duration": 0.5, "rates": [0.02, -0.6, -1.2]},
    "again": {"kind": "contact", "duration": 0.5, "rates": [-0.1, 0.4, -1.0]},
}


@cache
def moved():
    plan = contact_plan(
        [0.3, 0.6, 0.4], [0.0, 0.0, 1.0], [-0.0005, 0.0, -0.0015], phases=PHASES, lead_in=0.1
    )
    return integrate(plan)


def changed(configuration, **values):
    x = coordinates(configuration)
    for i, quantity in enumerate(CALIBRATED_QUANTITIES):
        if quantity.name in values:
            value = values[quantity.name]
            x[i] = np.log(value) if quantity.log else value
    return configured(configuration, x)


def measured(**values):
    truth = moved()
    configuration = changed(truth.plan.configuration, **values)
    return replace(truth, plan=replace(truth.plan, configuration=configuration))


def as_recording(truth, start, end=np.inf, begin=0.0):
    wrenches, angles, read = [], [], PegJoints(start.joints)
    samples = list(measure(truth))
    for sample in samples:
        if not begin <= (sample.t_ns - samples[0].t_ns) * 1e-9 <= end:
            continue
        if isinstance(sample, WrenchSample):
            wrenches.append(sample)
        else:
            angles.append(read(sample))
    return recording(wrenches, angles)


@pytest.fixture(scope="module")
def wrong(tmp_path_factory):
    """What a calibration writes by the command line from a start that is wrong in much."""
    folder = tmp_path_factory.mktemp("wrong")
    start = changed(moved().plan.configuration, friction=0.3)
    bag, before, after = (folder / name for name in ("a.mcap", "before.yaml", "after.yaml"))
    write_bag(bag, measured(**TRUE))
    before.write_text(write_parameters(to_parameters(start)), encoding="utf-8")
    arguments = ["calibrate", bag, "--config", before, "--out", after]
    assert main([str(argument) for argument in arguments]) == 0
    return after


@pytest.mark.nightly
def test_what_was_put_in_is_written(wrong):
    found = from_parameters(read_parameters(wrong))
    assert found.scene.friction == pytest.approx(TRUE["friction"], rel=0.05)
    assert found.wrench.bias_force[2] == pytest.approx(TRUE["bias_force_z"], abs=1.0)
    assert found.wrench.force_stddev == pytest.approx(TRUE["force_stddev"], rel=0.1)
    heading = wrong.read_text(encoding="utf-8").split("peg_on_hole:")[0]
    assert "Most likely values with 95 % intervals, and what is written:" in heading
    assert "the model explains the recording" in " ".join(heading.split())


@pytest.mark.nightly
@pytest.mark.parametrize(("friction", "clearance"), [(0.12, 1.1e-4), (0.3, 9e-5)])
def test_intervals_hold_what_was_put_in_wherever_the_search_starts(friction, clearance):
    truth, true = measured(**TRUE, tilt_x=0.0), coordinates(measured(**TRUE).plan.configuration)
    start = changed(truth.plan.configuration, friction=friction, clearance=clearance)
    found = calibrate(as_recording(truth, start), start)
    assert found.nis < 3.2 < found.nis_before
    at = [np.exp(x) if one.log else x for one, x in zip(CALIBRATED_QUANTITIES, true)]
    # Of one recording: 14 that err together.
    assert sum(e.low <= t <= e.high for e, t in zip(found.estimates, at)) >= 12


@pytest.mark.nightly
def test_a_cell_that_is_right_is_left_as_it_is_and_what_is_not_told_is_named():
    truth = simulated_truth("closing_with_slip")
    start = truth.plan.configuration
    found = calibrate(as_recording(truth, start), start)
    assert [one.name for one in found.estimates if one.changed] == []
    assert found.nis == found.nis_before
    # One way, by 66 degrees, in half a second: a force across has no lever of its own.
    across = found.estimates[QUANTITY_NAMES.index("bias_force_x")]
    assert not across.seen and "bias_torque_y" in across.alike
    said = "\n".join(not_seen(found))
    assert "force bias along x: record half a turn or more" in said
    assert "(in this motion it looks like" in said and "torque bias about y" in said
    row = next(row for row in rows(found) if row[0] == "force bias along x")
    assert row[2:4] == ("?", "?")


def test_a_likelihood_falls_to_every_side_of_the_truth_by_what_its_slopes_say():
    truth = moved()
    start = truth.plan.configuration
    record, x0 = as_recording(truth, start), coordinates(start)
    likelihood = Likelihood(record, steady(record, start), start)
    best = likelihood.run(x0)
    # Three degrees of freedom of an orientation, and as many of a wrench beside its reactions.
    assert best.nis.mean() == pytest.approx(3.0, abs=0.6)
    for name, by in (
        ("friction", 0.002), ("bias_force_z", 0.2), ("bias_torque_z", 0.01), ("tilt_y", 0.004),
        ("clearance", 0.05),
    ):  # fmt: skip
        for sign in (1.0, -1.0):
            x = x0.copy()
            x[QUANTITY_NAMES.index(name)] += sign * by
            assert likelihood.run(x).total < best.total - 5.0, name


def small_peg(rates):
    base = Configuration()
    scene = replace(base.scene, hole_diameter=0.008, peg_diameter=0.007984)
    return integrate(
        contact_plan([0.3, 0.0, 0.0], rates, [0.0, 0.0, -0.0015], 0.4, replace(base, scene=scene))
    )


def test_a_small_peg_slides_at_the_rates_of_a_large_one():
    truth = small_peg([-0.1, 0.0, 0.45])
    start = truth.plan.configuration
    record = as_recording(truth, start)
    parts = steady(record, start)
    # 0.4 s at 500 Hz less half a window and a rest at either end.
    assert sum(part.stop - part.start for part in parts) > 140
    assert slow_slip(Configuration()) == pytest.approx(2e-3)


def test_what_a_slow_recording_lacks_is_said_with_a_rate_for_its_diameter():
    truth = small_peg([-0.01, 0.0, 0.05])
    start = truth.plan.configuration
    text = shortfall(as_recording(truth, start), start)
    assert "of these pressed on the rim (median 2" in text
    assert "0 of these with all contacts faster than 0.32 mm/s" in text
    # 0.32 mm/s at a radius of 4 mm, and a quarter more.
    assert "turned about its axis by 0.1 rad/s and more" in text


def test_torques_are_judged_as_forces_at_the_rim():
    large, small = measures(0.05, 25.0), measures(0.01, 5.0)
    force, torque = QUANTITY_NAMES.index("bias_force_x"), QUANTITY_NAMES.index("bias_torque_x")
    assert large.useful[[force, torque]].tolist() == [1.0, 0.05]
    assert small.useful[force] == pytest.approx(0.2)
    assert small.useful[torque] / small.useful[force] == pytest.approx(0.01)
    assert small.range[force] == large.range[force]


def test_two_that_look_alike_are_not_both_kept_where_together_they_differ():
    # Each is known to 10, their sum to 0.1; the start is 0 and the sum is found to be 5.
    covariance = np.array([[100.0, -99.995], [-99.995, 100.0]])
    padded = np.eye(len(CALIBRATED_QUANTITIES)) * 1e-12
    padded[1:3, 1:3] = covariance
    gone = np.zeros(len(CALIBRATED_QUANTITIES))
    gone[1:3] = 2.5
    kept = kept_ones(gone, padded)
    assert kept[1:3].sum() == 1
    final = conditional(gone, padded, np.zeros(len(gone)), kept)
    assert final[1] + final[2] == pytest.approx(5.0, abs=1e-3)
    gone[1:3] = 2.5, -2.5
    assert kept_ones(gone, padded)[1:3].all()


def test_turned_angles_are_those_that_the_pipeline_reads():
    rpy = (0.02, -0.01, 0.3)
    tilted, plain = PegJoints(JointInput(hole_rpy=rpy)), PegJoints(JointInput())
    samples = [
        JointSample(t, ("gamma", "psi", "phi"), q)
        for t, q in ((0, (0.2, 0.5, -1.0)), (5, (0.1, 2.0, 0.3)))
    ]
    record = turned(
        recording([WrenchSample(0, (0.0,) * 3, (0.0,) * 3)], [plain(s) for s in samples]),
        rotation_from_rpy(rpy).T,
    )
    for i, sample in enumerate(samples):
        expected = tilted(sample)
        assert record.q[i] == pytest.approx(expected.q, abs=1e-12)
        assert record.covariance[i] == pytest.approx(expected.covariance, rel=1e-9, abs=1e-20)


def low_passed(cutoff, noise=0.3):
    """Wrenches at 1 kHz of a peg that is pressed ever more, behind a low-pass [Hz]; 0: none."""
    rng = np.random.default_rng(7)
    t = 1e-3 * np.arange(8000)
    wrench = 5.0 * t[:, None] + rng.normal(size=(8000, 6)) * np.repeat([noise, 0.02 * noise], 3)
    share = 1.0 - np.exp(-2.0 * np.pi * cutoff * 1e-3) if cutoff else 1.0
    for i in range(1, len(wrench)):
        wrench[i] = wrench[i - 1] + share * (wrench[i] - wrench[i - 1])
    wrenches = [
        WrenchSample(round(s * 1e9), tuple(row[:3]), tuple(row[3:])) for s, row in zip(t, wrench)
    ]
    angles = [AngleMeasurement(t, np.array([0.2, 0.1, 0.1]), np.eye(3)) for t in (0, 10**9)]
    return recording(wrenches, angles)


@pytest.mark.parametrize("cutoff", [50.0, 100.0])
def test_a_low_pass_is_found_by_noise_that_neighbours_share_and_the_noise_before_it(cutoff):
    record = low_passed(cutoff)
    found = noise_of_neighbours(record.wrench_t, record.wrench, (0.3, 0.006))
    # Over 8 ms noise behind 50 Hz is still alike by a tenth, which tells a cut-off that high.
    assert found.cutoff == pytest.approx(cutoff, rel=0.2)
    force, torque, _ = noise_levels(record, found.pole)
    # At low frequencies the filter leaves the noise as it was.
    assert np.exp([force.log, torque.log]) == pytest.approx([0.3, 0.006], rel=0.15)
    assert np.exp(noise_levels(record)[0].log) < 0.1


def test_white_noise_has_no_low_pass():
    record = low_passed(0.0)
    found = noise_of_neighbours(record.wrench_t, record.wrench, (0.3, 0.006))
    assert found.enough and found.cutoff == found.pole == 0.0
    assert noise_levels(record, found.pole)[0] == noise_levels(record)[0]


@pytest.mark.nightly
def test_a_calibration_writes_the_low_pass_of_a_recording(tmp_path, capsys):
    """A bag of the shipped arm whose driver filters at 100 Hz."""
    out = tmp_path / "found.yaml"
    bag = Path(__file__).parents[2] / "bags" / "cell_franka_like.mcap"
    assert main(["calibrate", str(bag), "--out", str(out)]) == 0
    assert "as behind a low-pass of" in capsys.readouterr().out
    assert read_parameters(out)["wrench.low_pass"] == pytest.approx(100.0, rel=0.25)


@pytest.mark.parametrize("size", [0.5, 3.0])
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
    levels = noise_levels(recording(wrenches, measurements))
    # 60 and 30 medians of 100 samples: 2 to 3 % of spread.
    found = [np.exp(level.log) for level in levels]
    assert found == pytest.approx((0.2 * size, 0.005, size), rel=0.1)
    off = np.log(found) - np.log([0.2 * size, 0.005, size])
    assert (np.abs(off) < 3.0 * np.array([level.stddev for level in levels])).all()
    assert (np.array([level.stddev for level in levels]) < 0.05).all()


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
    x = coordinates(start) + [quantity.step for quantity in CALIBRATED_QUANTITIES]
    there = configured(start, x)
    back = coordinates(there)
    back[TILT_AT] = x[TILT_AT]
    assert back == pytest.approx(x, rel=1e-9)
    # The hole's axis, and gravity in the hole's axes, turn against each other.
    R_MH = rotation_from_rpy(there.joints.hole_rpy)
    assert R_MH @ there.scene.gravity == pytest.approx(start.scene.gravity, abs=1e-12)
    assert R_MH[:, 2] == pytest.approx([x[TILT_AT][1], -x[TILT_AT][0], 1.0], abs=1e-6)
    assert len(QUANTITY_NAMES) == len(set(QUANTITY_NAMES)) == len(x)


# A driver that pauses; a recorder that takes up one topic before the other, or lets go of it.
@pytest.mark.parametrize("silence", [(0.3, 0.4), (-1.0, 0.2), (1.2, 9.0)])
def test_no_wrench_is_held_over_a_silence(silence):
    truth = moved()
    start = truth.plan.configuration
    record = as_recording(truth, start)
    heard = (record.wrench_t < silence[0]) | (record.wrench_t > silence[1])
    record = record._replace(wrench_t=record.wrench_t[heard], wrench=record.wrench[heard])
    for part in steady(record, start):
        t = record.joint_t[part]
        assert not ((t > silence[0]) & (t < silence[1])).any()
    # With the last wrench before it held on it was 90 and more.
    assert (
        Likelihood(record, steady(record, start), start).run(coordinates(start)).nis.mean() < 4.0
    )


@pytest.mark.parametrize("delay", [0.1, -0.1])
def test_a_stated_delay_of_the_stamps_moves_no_part_that_slides_steadily(delay):
    # Pressed and let go of several times: a load at the wrong time ends parts elsewhere.
    truth = simulated_truth("working_cycle")
    start = truth.plan.configuration
    record = as_recording(truth, start)
    late = record._replace(joint_t=record.joint_t + delay)
    stated = replace(start, joints=replace(start.joints, delay=delay))
    assert len(steady(record, start)) == 4
    assert steady(late, stated) == steady(record, start)


def test_a_steady_load_is_read_up_to_both_ends_and_no_later_than_it_is():
    start = Configuration()
    ramp = np.linspace(20.0, 40.0, 60)
    wrenches = [WrenchSample(k * 4_000_000, (0.0, 0.0, f), (0.0,) * 3) for k, f in enumerate(ramp)]
    upright = np.array([0.3, 0.0, 0.0])
    angles = [AngleMeasurement(k * 4_000_000, upright, np.eye(3)) for k in range(60)]
    record = recording(wrenches, angles)
    carried = load(record, motion(record), start)
    reduction = WrenchReduction(start.wrench, start.scene)
    weight = start.scene.peg_mass * np.array(start.scene.gravity) @ peg_axes(upright)
    read = np.array([reduction.matrix[:3, :3] @ (0.0, 0.0, f) * reduction.sign for f in ramp])
    exact = np.linalg.norm(read + weight, axis=1)
    # A mean over eleven of what grows steadily is what is in the middle; but for the ends.
    np.testing.assert_allclose(carried[5:-5], exact[5:-5], rtol=1e-9)
    assert np.all(np.diff(carried) > 0.0)
    assert carried[[0, -1]] == pytest.approx(exact[[0, -1]], abs=0.02 * 40.0)


def test_a_recording_without_sliding_is_refused_with_what_to_record():
    truth = moved()
    start = truth.plan.configuration
    with pytest.raises(BagError, match=r"only 0 joint states while all three contacts slide"):
        calibrate(as_recording(truth, start, 0.05), start)
