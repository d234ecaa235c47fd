"""Bias of the sensor and tilt of the hole as states: equal to the reference, found, honest."""

from dataclasses import replace

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.contact import ContactFilter, Correction, Prediction
from peg_on_hole_ros.estimation.filters.methods import make_filter
from peg_on_hole_ros.estimation.filters.offset import OffsetFilter
from peg_on_hole_ros.estimation.filters.smoother import SmoothingFilter
from peg_on_hole_ros.estimation.kernel.friction_lag import WANDERS_BESIDE
from peg_on_hole_ros.estimation.kernel.memory import part
from scipy.stats import chi2

import offsets_learnt
from grid_cells import SMALLEST, Motion, truth_of, with_noise
from grid_score import INTERVAL, SETTLE_NS
from offsets_learnt import Stated
from peg_on_hole_ros.configuration import from_parameters
from peg_on_hole_ros.edges.config_file import read_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimation.measurement import WrenchReduction, angles_of, tilt_axes
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.simulation.measure import START_NS
from side_by_side import bag_steps, compared
from simulated import ROOT


def uncertain(configuration, force=0.0, torque=0.0, tilt=0.0, **options):
    stated = Stated(force, torque, tilt, configuration.scene.friction_stddev)
    told = offsets_learnt.uncertain(configuration, stated)
    return replace(told, filter=replace(told.filter, **options))


@pytest.mark.xdist_group("filterpy")
@pytest.mark.parametrize(
    "stated",
    [
        {"force": 0.5, "torque": 0.01, "tilt": 0.003},
        {"force": 0.5, "torque": 0.01, "wrench_bias": "considered"},
        {"tilt": 0.003, "hole_tilt": "considered"},
    ],
    ids=["all", "bias_considered", "tilt_considered"],
)
def test_equals_the_reference_filter(stated):
    configuration = from_parameters(read_parameters(ROOT / "config" / "closing_with_slip.yaml"))
    configuration = uncertain(configuration, **stated)
    steps = bag_steps(ROOT / "bags" / "closing_with_slip.mcap", configuration)[:40]
    assert_equal(configuration, steps)


def assert_equal(configuration, steps):
    found = list(compared(configuration, steps))
    # In standard deviations; rounding of steps solved to 1e-11 rad/s stays a thousandth of it.
    for name in ("mean", "covariance", "reactions", "reactions_covariance"):
        assert np.max([getattr(item, name) for item in found]) < 1e-6, name


@pytest.mark.xdist_group("filterpy")
@pytest.mark.parametrize(
    ("bag", "force", "tilt", "beside"),
    [
        ("closing_with_slip", 0.1, 0.0, {"AT_MEAN": True}),
        ("closing_without_slip", 0.05, 0.0, {"TOLD_SHARE": True}),
        ("closing_without_slip", 2.0, 0.002, {"TOLD_SHARE": False}),
    ],
    ids=["tangents_at_the_mean", "small_beside_balance", "large_beside_balance"],
)
def test_equals_the_reference_filter_later(monkeypatch, bag, force, tilt, beside):
    configuration = from_parameters(read_parameters(ROOT / "config" / f"{bag}.yaml"))
    configuration = uncertain(configuration, force, force / 100, tilt)
    steps = bag_steps(ROOT / "bags" / f"{bag}.mcap", configuration)[:120]
    seen = dict.fromkeys(beside, False)
    predict = OffsetFilter.predict

    def noted(kalman, dt, in_contact):
        result = predict(kalman, dt, in_contact)
        for name in seen:
            seen[name] |= bool(part(kalman._memory, name).item() > 0.0)
        return result

    monkeypatch.setattr(OffsetFilter, "predict", noted)
    assert_equal(configuration, steps)
    assert seen == beside


CONSIDERED = pytest.mark.parametrize(
    "stated",
    [
        {"tilt": 0.003, "hole_tilt": "considered"},
        {"force": 0.05, "torque": 0.001, "wrench_bias": "considered"},
    ],
    ids=["tilt", "bias"],
)


def hardly_slipping(stated):
    """Return a configuration and steps of closing without slip, where slips are hardly told."""
    read = read_parameters(ROOT / "config" / "closing_without_slip.yaml")
    configuration = uncertain(from_parameters(read), **stated)
    steps = bag_steps(ROOT / "bags" / "closing_without_slip.mcap", configuration)[120:320]
    return configuration, steps


@CONSIDERED
def test_what_is_only_considered_leaves_a_covariance_where_steps_are_not_believed(stated):
    """Rates from beside kept what it shares with others: eigenvalues of -120, then a restart."""
    configuration, steps = hardly_slipping(stated)
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    kalman = make_filter(
        configuration.scene, configuration.filter, reduction.covariance,
        reduction.offsets(configuration),
    )  # fmt: skip
    kalman.start(steps[0].q, steps[0].R)
    kinds, least = [], []
    for step in steps[1:]:
        kalman.hold(step.u)
        kinds.append(kalman.predict(step.dt, True))
        if step.q is not None:
            assert kalman.correct(*kalman.in_hole_axes(step.q, step.R))[0] is not Correction.RESET
        P = kalman.joint_covariance()
        known = np.diagonal(P) > 0
        stddev = np.sqrt(np.diagonal(P)[known])
        correlation = P[np.ix_(known, known)] / np.outer(stddev, stddev)
        least.append(np.linalg.eigvalsh(correlation).min())
    # Where rates beside would be taken.
    assert (Prediction.CONTACT, Prediction.SLOW) in zip(kinds, kinds[1:])
    assert min(least) > -1e-12


@pytest.mark.xdist_group("filterpy")
@CONSIDERED
def test_equals_the_reference_filter_where_steps_are_not_believed(stated):
    assert_equal(*hardly_slipping(stated))


@pytest.mark.parametrize(
    ("stated", "learnt"),
    [
        ({"tilt": 0.003}, (0, 1)),
        ({"tilt": 0.003, "hole_tilt": "considered"}, (0, 0)),
        ({"force": 0.5}, (1, 0)),
        ({"force": 0.5, "wrench_bias": "considered"}, (0, 0)),
        ({"force": 0.5, "tilt": 0.003, "wrench_bias": "considered"}, (0, 1)),
    ],
)
def test_what_is_known_or_only_considered_is_not_learnt(stated, learnt):
    """Where nothing is, steps are not believed again sooner for its sake."""
    kalman = Pipeline(uncertain(Configuration(), **stated)).filter
    assert part(kalman.memory, "OFFSETS")[2:].tolist() == list(learnt)


@pytest.mark.parametrize(
    ("stated", "beside"),
    [
        ({"tilt": 0.003}, WANDERS_BESIDE),
        ({"tilt": 0.003, "hole_tilt": "considered"}, 1.0),
        ({"force": 0.5, "wrench_bias": "considered"}, 1.0),
        ({"force": 0.5, "tilt": 0.003, "wrench_bias": "considered"}, WANDERS_BESIDE),
        ({"force": 0.5, "friction": "considered"}, 0.0),
    ],
)
def test_friction_walks_farther_beside_what_is_learnt(stated, beside):
    configuration = uncertain(Configuration(), **stated)
    expected = (beside * configuration.filter.friction_noise) ** 2
    assert Pipeline(configuration).filter.process.friction_density == expected
    # And beside a clearance that is learnt, whatever the offsets are.
    scene = replace(configuration.scene, clearance_stddev=1e-6)
    expected = (WANDERS_BESIDE * configuration.filter.friction_noise) ** 2 if beside else 0.0
    kalman = Pipeline(replace(configuration, scene=scene)).filter
    assert kalman.process.friction_density == expected


def test_the_load_of_bias_and_tilt_is_that_of_the_reduction():
    wrench = replace(
        Configuration().wrench,
        acts_on="robot",
        sensor_xyz=(0.01, -0.02, 0.09),
        sensor_rpy=(3.0, 0.2, 0.7),
        payload_mass=0.8,
        payload_com=(0.03, 0.01, -0.02),
    )
    configuration = uncertain(replace(Configuration(), wrench=wrench), 1.0, 0.1, 0.01)
    reduction = WrenchReduction(wrench, configuration.scene)
    gravity = np.array(configuration.scene.gravity)
    kalman = make_filter(
        configuration.scene,
        configuration.filter,
        reduction.covariance,
        reduction.offsets(configuration),
    )
    q, force, torque = np.array([0.2, 0.9, -2.0]), (3.0, -2.0, 8.0), (0.1, 0.2, -0.3)
    kalman.start(q, np.eye(3) * 1e-8)
    kalman.hold(reduction.on_peg(force, torque, q))

    def on_peg(offset):
        # Of peg and payload, gravity as the hole's axes have it after a small tilt.
        bias, gravity_H = offset[:6], tilt_axes(offset[6:]).T @ gravity
        reading = np.array([*force, *torque]) - bias
        applied = reduction.on_peg(reading[:3], reading[3:], q, gravity_H)
        applied[:3] += configuration.scene.peg_mass * peg_axes(q).T @ gravity_H
        return applied

    step = 1e-5
    load = [(on_peg(step * e) - on_peg(-step * e)) / (2 * step) for e in np.eye(8)]
    # Linear in the bias, and of third order in the tilt.
    np.testing.assert_allclose(part(kalman.memory, "LOAD", (6, 8)).T, load, rtol=0, atol=1e-8)


def test_a_tilt_turns_measured_angles_as_stated():
    kalman = OffsetFilter(
        Configuration().scene,
        Configuration().filter,
        np.eye(6),
        WrenchReduction(Configuration().wrench, Configuration().scene).offsets(
            uncertain(Configuration(), tilt=0.01)
        ),
    )
    q = np.array([0.2, 0.9, -2.0])
    kalman.start(q, np.eye(3) * 1e-8)
    step = 1e-6
    turned = [(angles_of(tilt_axes(step * e) @ peg_axes(q)) - q) / step for e in np.eye(2)]
    # First differences of angles of size 1 over 1e-6.
    turn = part(kalman.memory, "TURN", (3, 2))
    np.testing.assert_allclose(turn.T, turned, rtol=0, atol=1e-4)
    # What the estimate begins with is off by the tilt, in the other sense.
    np.testing.assert_allclose(kalman.Z[:3, :3], 1e-8 * np.eye(3) + 1e-4 * turn @ turn.T)
    kalman.offset[6:] = 0.003, -0.002
    there, R = kalman.in_hole_axes(q, np.eye(3) * 1e-8)
    np.testing.assert_allclose(
        tilt_axes((0.003, -0.002)) @ peg_axes(there), peg_axes(q), atol=1e-14
    )
    assert np.linalg.eigvalsh(R).min() > 0
    # An estimate a little below zero leans to the other side: the same orientation, gamma the
    # other way round.
    kalman.start(np.array([-0.2, 0.9 - np.pi, -2.0 + np.pi]), np.eye(3) * 1e-8)
    below = part(kalman.memory, "TURN", (3, 2))
    kalman.offset[6:] = 0.0
    np.testing.assert_allclose(below.T, turned * np.array([-1.0, 1.0, 1.0]), rtol=0, atol=1e-4)


@pytest.fixture(scope="module")
def truth():
    return truth_of(SMALLEST[0])[0]


def played(truth, configuration, seed, bias=(0.0,) * 6, tilt=(0.0, 0.0)):
    """Return the pipeline after a measurement of the truth by a sensor and a cell that are off."""
    pipeline = offsets_learnt.pipeline_of(configuration, tilt)
    *_, outputs = offsets_learnt.played(pipeline, truth, seed, np.array(bias), tilt)
    return pipeline, outputs


def error(kalman, true):
    """Return errors of the offsets that are not known, and their covariance."""
    variance = np.diagonal(kalman.offset_spread[:, 2:])
    carried = np.flatnonzero(variance > 0)
    P = kalman.offset_spread[:, 2:][np.ix_(carried, carried)]
    return (kalman.offset - true)[carried], P


def test_an_untared_sensor_is_learnt_with_friction(truth):
    bias = np.array([2.0, 0, 0, 0, 0, 0])
    configuration = uncertain(truth.plan.configuration, force=3.0)
    pipeline, outputs = played(truth, configuration, 7, bias)
    off, P = error(pipeline.filter, np.r_[bias, 0, 0])
    # Three of 1e-3 of chance.
    assert off @ np.linalg.solve(P, off) < chi2(3).isf(1e-3)
    # Along the peg friction takes the bias's part, and is not told from it: known to 0.7 N.
    assert P[0, 0] < 0.05**2 and P[2, 2] < 1.0**2
    assert outputs.monitor["bias_force_x"] == pytest.approx(2.0, abs=0.1)
    assert outputs.monitor["bias_force_x_stddev"] == pytest.approx(np.sqrt(P[0, 0]))
    assert "hole_tilt_x" not in outputs.monitor and "nis_drift" not in outputs.monitor
    assert not pipeline.counts["innovations_too_large"]


def test_friction_does_not_take_the_part_of_a_bias():
    """In pure align noise hides the steps: the balance of forces alone tells of anything."""
    truth = with_noise(truth_of(Motion(1e-4, 0.2, 0.16, "align"))[0], "nominal", 0.05)
    configuration = uncertain(truth.plan.configuration, force=3.0)
    off, inside = [], []
    pipeline = offsets_learnt.pipeline_of(configuration)
    for outputs in offsets_learnt.played(pipeline, truth, 7, (2.0, 0, 0, 0, 0, 0)):
        monitor, t_ns = outputs.monitor, outputs.t_ns - START_NS
        if t_ns < SETTLE_NS:
            continue
        off.append((monitor["friction"] - 0.2) / monitor["friction_stddev"])
        normal = truth.normal[np.searchsorted(truth.t_ns, t_ns)]
        inside.append(np.abs(outputs.normal - normal) <= INTERVAL * outputs.normal_stddev)
    assert len(off) > 500
    # Four deviations and more, and none after half a second, where balance teaches friction here.
    assert np.abs(off).max() < 0.5
    assert np.mean(inside, axis=0).min() > 0.95
    # Across the peg the same balance tells of it.
    kalman = pipeline.filter
    assert kalman.offset[0] == pytest.approx(2.0, abs=0.6)
    assert kalman.offset_spread[0, 2] < 0.6**2


@pytest.mark.parametrize("seed", [2301, 2307])
def test_a_missing_step_says_nothing_of_friction_beside_a_bias(seed):
    """Sought two deviations below, it left the reactions of these runs within 3 and 80 %."""
    truth = with_noise(truth_of(Motion(1e-4, 0.5, 0.16, "slip"))[0], "nominal", 0.05)
    stated = Stated(2.0, 0.02, 0.0, 0.05)
    ((normalised, deviations, *shares, _, _),) = offsets_learnt.drawn(truth, stated, [seed])
    assert abs(deviations) < 2.0
    assert min(shares) > 0.95
    assert normalised < chi2(7).isf(1e-3)


def test_a_tilted_hole_is_learnt_with_friction(truth):
    tilt = np.radians([0.0, 0.2])
    configuration = uncertain(truth.plan.configuration, tilt=0.005)
    pipeline, outputs = played(truth, configuration, 7, tilt=tilt)
    off, P = error(pipeline.filter, np.r_[np.zeros(6), tilt])
    assert off @ np.linalg.solve(P, off) < chi2(2).isf(1e-3)
    assert np.sqrt(np.diagonal(P)).max() < 0.002
    assert outputs.monitor["hole_tilt_y"] == pytest.approx(tilt[1], abs=0.004)
    assert "bias_force_x" not in outputs.monitor


def test_bounds_hold_over_seeds(truth):
    configuration = uncertain(truth.plan.configuration, 2.0, 0.02)
    scene = replace(configuration.scene, friction_stddev=0.0)
    found = []
    for seed in range(5):
        bias = np.random.default_rng(seed).normal(0, [2.0] * 3 + [0.02] * 3)
        pipeline, _ = played(truth, replace(configuration, scene=scene), seed, bias)
        off, P = error(pipeline.filter, np.r_[bias, 0, 0])
        found.append(off @ np.linalg.solve(P, off))
    assert chi2(30).ppf(1e-3) < sum(found) < chi2(30).isf(1e-3), found


def test_a_tare_begins_the_bias_anew():
    configuration = uncertain(Configuration(), 2.0, 0.02, 0.003)
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    kalman = make_filter(
        configuration.scene, configuration.filter, reduction.covariance,
        reduction.offsets(configuration),
    )  # fmt: skip
    kalman.offset[:] = 1.0
    kalman.offset_spread[2, 8] = kalman.offset_spread[6, 4] = 1e-3
    kalman.tared(reduction.noise / 100)
    assert not kalman.offset[:6].any() and kalman.offset[6] == 1.0
    spread = kalman.offset_spread[:, 2:]
    known = [0.02**2] * 3 + [0.0005**2] * 3 + [0.003**2] * 2
    np.testing.assert_allclose(spread, np.diag(known), rtol=1e-12)


def test_the_default_carries_none_and_others_refuse():
    configuration = Configuration()
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    made = [configuration.scene, configuration.filter, reduction.covariance]
    assert type(make_filter(*made, reduction.offsets(configuration))) is ContactFilter
    offsets = reduction.offsets(uncertain(configuration, tilt=0.01))
    assert offsets.active == slice(6, 8)
    with pytest.raises(PegOnHoleError, match="SmoothingFilter does not carry"):
        SmoothingFilter(*made, offsets)
    with pytest.raises(PegOnHoleError, match="0.01 needs filter.method 'extended'"):
        from_parameters({"joints.hole_tilt_stddev": 0.01, "filter.method": "iterated"})


def test_a_pull_does_not_make_friction_sought_beside_a_bias():
    """An N_K that is 5 N of bias made it sought two deviations below, in this run."""
    truth = with_noise(truth_of(Motion(1e-4, 0.2, 0.16, "align"))[0], "nominal", 0.05)
    stated = Stated(2.0, 0.02, 0.0, 0.05)
    bias = np.array([-0.7, 1.1, -5.1, -0.017, -0.028, 0.027])
    told = offsets_learnt.uncertain(truth.plan.configuration, stated, friction=0.24)
    pipeline, outputs = played(truth, told, 2301, bias)
    assert not pipeline.counts["friction_sought"]
    assert abs(outputs.monitor["friction"] - 0.2) < 2.0 * outputs.monitor["friction_stddev"]
