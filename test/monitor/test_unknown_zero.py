"""A sensor whose zero is not known: what that may make of a wrench is no evidence of contact."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.estimator.methods.registry import make_filter
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.records import ANGLES, JointSample, WrenchSample
from peg_on_hole_ros.sim.measure import START_NS, measure
from simulated import truth
from tiers import nightly
from under_way import press

MS = 1_000_000
SENSOR = replace(
    Configuration().wrench, sensor_xyz=(0.01, -0.02, 0.09), sensor_rpy=(3.0, 0.2, 0.7)
)


@pytest.mark.parametrize(("force", "torque"), [(0.0, 0.0), (2.0, 0.0), (0.0, 0.05), (1.0, 0.02)])
def test_an_unknown_bias_loads_the_rim_as_drawn_ones_do(force, torque):
    wrench = replace(SENSOR, bias_force_stddev=force, bias_torque_stddev=torque)
    configuration = replace(Configuration(), wrench=wrench)
    scene, reduction = configuration.scene, WrenchReduction(wrench, configuration.scene)
    kalman = make_filter(
        scene, configuration.filter, reduction.covariance, reduction.offsets(configuration)
    )
    q = np.array([0.2, 0.9, -2.0])
    kalman.start(q, np.eye(3) * 1e-8)
    record = press(kalman, reduction.on_peg((0.0, 0.0, -5.0), (0.0, 0.0, 0.0), q))
    if force == torque == 0.0:
        # Not a hair: with a known zero nothing is different.
        assert record.bias_load == 0.0
        return
    unbiased = reduction.on_peg((0.0,) * 3, (0.0,) * 3, q)
    rng = np.random.default_rng(1)
    squares = []
    for _ in range(4000):
        bias = rng.standard_normal(6) * np.repeat([force, torque], 3)
        made = reduction.on_peg(bias[:3], bias[3:], q) - unbiased
        squares.append(made[:3] @ made[:3] + made[3:] @ made[3:] * (2 / scene.peg_diameter) ** 2)
    # The mean of 4000 such squares is told to some 2 %.
    assert record.bias_load == pytest.approx(np.mean(squares), rel=0.07)


@pytest.mark.parametrize("bias", [1.0, *nightly(0.0)])
def test_a_stated_bias_is_no_contact_in_the_air_and_hides_none_on_the_rim(bias):
    """1 N had a peg in the air on three contacts, and then losing them, with an ERROR."""
    scene = truth("working_cycle")
    plain = scene.plan.configuration
    stated = replace(plain, wrench=replace(plain.wrench, bias_force_stddev=2.0))
    down = next(t_ns for t_ns, text in scene.events if text.startswith("touch-down"))
    samples = []
    for sample in measure(scene, 3):
        if sample.t_ns - START_NS > down + 200_000_000:
            break
        if type(sample) is WrenchSample:
            x, y, z = sample.force
            sample = sample._replace(force=(x + bias, y, z))
        samples.append(sample)
    found = list(Pipeline(stated).play(samples))
    t = np.array([row.t_ns - START_NS for row in found])
    modes = np.array([row.contact_mode for row in found])
    # Some wrenches have to come before anything is said.
    assert set(modes[t < 40_000_000]) <= {"unknown", "open"}
    assert set(modes[(t > 40_000_000) & (t < down)]) == {"open"}
    assert not any(alarm.level for row in found for alarm in row.alarms)
    assert set(modes[t > down + 150_000_000]) == {"three_point"}


def in_the_air(tilt, force_rate, torque_rate, until=4.5):
    """Measure a peg that hangs still, with a load that grows from 1 s on [N/s], [N m/s]."""
    random, held = np.random.default_rng(5), (tilt, 0.3, 0.0)
    weight = Rotation.from_euler("ZYZ", [0.3, -tilt, 0.0]).as_matrix().T @ [0.0, 0.0, 4.9]
    for k in range(round(until * 1e3)):
        grown = max(k * 1e-3 - 1.0, 0.0)
        if k % 2 == 0:
            yield JointSample(k * MS, ANGLES, tuple(held + random.normal(0, 1e-4, 3)))
        force = weight + grown * np.array(force_rate) + random.normal(0, 0.2, 3)
        torque = grown * np.array(torque_rate) + random.normal(0, 0.005, 3)
        yield WrenchSample(k * MS, tuple(force), tuple(torque))


UNKNOWN_ZERO = {
    "wrench.sensor_xyz": [0.0, 0.0, 0.035],
    "wrench.bias_force_stddev": 0.5,
    "wrench.bias_torque_stddev": 0.02,
}


@pytest.mark.parametrize("tilt", [0.02, *nightly(0.2)])
def test_a_zero_that_drifts_in_the_air_is_no_contact(tilt):
    """By its stated deviation in a second, in the plane of the tilt, as K and B would load it."""
    line = Pipeline(from_parameters(UNKNOWN_ZERO))
    rows = list(line.play(in_the_air(tilt, (0.5, 0.0, 0.0), (0.0, 0.025, 0.0))))
    assert {row.contact_mode for row in rows[100:]} == {"open"}
    # It is followed: what was learnt before would be 0.
    assert 0.5 < rows[-1].monitor["bias_force_x"] < 2.0


def test_a_press_that_grows_slowly_is_no_drift():
    line = Pipeline(from_parameters(UNKNOWN_ZERO))
    rows = list(line.play(in_the_air(0.2, (0.0, 0.0, -10.0), (0.0, 0.0, 0.0), until=1.5)))
    open_until = max(k for k, row in enumerate(rows) if row.contact_mode == "open")
    assert 1000 < open_until < 1250
