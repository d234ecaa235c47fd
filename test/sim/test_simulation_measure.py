"""Simulated sensors: what they read without noise, and how the noise is spread."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.sim.measure import (
    START_NS,
    measure,
    measured_angles,
    sensor_axes,
    sensor_wrench,
)
from peg_on_hole_ros.sim.truth import integrate
from rigid_body_oracle import rotation
from simulated import contact_plan, truth

pytestmark = pytest.mark.xdist_group("simulation")

XYZ, RPY, COM = (0.01, -0.02, 0.09), (0.3, -0.7, 1.9), (0.004, 0.003, -0.02)


@cache
def odd_sensor(acts_on="peg", payload_mass=0.0):
    """The same motion seen by a sensor that sits askew; 10 kHz for the differences."""
    wrench = WrenchInput(
        acts_on=acts_on,
        sensor_xyz=XYZ,
        sensor_rpy=RPY,
        payload_mass=payload_mass,
        payload_com=COM,
    )
    start = contact_plan(
        [0.25, 0.5, 0.3],
        [-0.16, 0.4, 1.5],
        [-2e-4, 1e-4, -1e-3],
        0.04,
        Configuration(wrench=wrench),
    )
    return integrate(replace(start, wrench_rate=10000, joint_rate=5000))


def test_sensor_wrench_has_the_power_of_the_holder():
    result = odd_sensor()
    wrench, h = sensor_wrench(result), 1e-4
    scene = result.plan.configuration.scene
    for i in (10, 40, 90):
        # Motion of sensor and mass centre by differences of the poses.
        R = np.array([rotation(q) for q in result.q[i - 1 : i + 2]])
        origin = result.position[i - 1 : i + 2]
        sensor, centre = origin + R @ XYZ, origin + R @ [0, 0, scene.mass_center_height]
        W = (R[2] - R[0]) / (2 * h) @ R[1].T
        w = np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]]) / 2
        R_HS = R[1] @ sensor_axes(RPY)
        force, torque = R_HS @ wrench[i, :3], R_HS @ wrench[i, 3:]
        power = force @ (sensor[2] - sensor[0]) / (2 * h) + torque @ w
        holder = result.force[i] @ (centre[2] - centre[0]) / (2 * h) + result.moment[i] @ w
        # Differences over 0.1 ms.
        assert power == pytest.approx(holder, rel=1e-5)
        assert force == pytest.approx(result.force[i], rel=1e-12)


def test_sensor_axes_turn_about_x_then_y_then_z():
    quarter = np.pi / 2
    assert sensor_axes((quarter, 0, 0)) @ [0, 1, 0] == pytest.approx([0, 0, 1], abs=1e-15)
    assert sensor_axes((0, quarter, 0)) @ [0, 0, 1] == pytest.approx([1, 0, 0], abs=1e-15)
    assert sensor_axes((0, 0, quarter)) @ [1, 0, 0] == pytest.approx([0, 1, 0], abs=1e-15)
    both = sensor_axes((quarter, 0, quarter)) @ [0, 1, 0]
    assert both == pytest.approx([0, 0, 1], abs=1e-15)


def test_a_sensor_that_reads_the_robot_reads_the_opposite():
    peg, robot = sensor_wrench(odd_sensor()), sensor_wrench(odd_sensor("robot"))
    assert np.array_equal(peg, -robot)


def test_payload_adds_its_weight_and_inertia():
    mass = 0.8
    without, loaded = odd_sensor(), odd_sensor("peg", mass)
    difference = sensor_wrench(loaded) - sensor_wrench(without)
    gravity = np.array(loaded.plan.configuration.scene.gravity)
    h = 1e-4
    weights = np.array([2, -27, 270, -490, 270, -27, 2]) / (180 * h * h)
    place = np.array(XYZ) + sensor_axes(RPY) @ COM
    points = np.array([p + rotation(q) @ place for p, q in zip(loaded.position, loaded.q)])
    for i in (10, 40, 90):
        R_SH = (rotation(loaded.q[i]) @ sensor_axes(RPY)).T
        force = R_SH @ (mass * (weights @ points[i - 3 : i + 4] - gravity))
        # Second differences over 0.1 ms.
        assert difference[i, :3] == pytest.approx(force, abs=1e-5)
        assert difference[i, 3:] == pytest.approx(np.cross(COM, force), abs=1e-6)


def test_samples_come_in_order_with_the_joints_first():
    result = truth("closing_with_slip")
    samples = list(measure(result))
    assert isinstance(samples[0], JointSample) and isinstance(samples[1], WrenchSample)
    assert samples[0].t_ns == samples[1].t_ns == START_NS
    stamps = [s.t_ns for s in samples]
    assert stamps == sorted(stamps)
    assert sum(isinstance(s, WrenchSample) for s in samples) == len(result.t_ns)
    joints = np.array([s.t_ns for s in samples if isinstance(s, JointSample)])
    assert np.array_equal(np.unique(np.diff(joints)), [2_000_000])


def test_a_seed_gives_the_same_samples_and_another_gives_others():
    result = truth("closing_with_slip")
    assert list(measure(result, 7)) == list(measure(result, 7))
    assert list(measure(result)) == list(measure(result, result.plan.seed))
    first, other = next(measure(result, 7)), next(measure(result, 8))
    assert first.position != other.position


def test_noise_has_the_stated_deviation_on_every_axis():
    result = truth("working_cycle")
    samples = list(measure(result))
    wrench = np.array([s.force + s.torque for s in samples if isinstance(s, WrenchSample)])
    error = wrench - sensor_wrench(result)
    n = len(error)
    expected = np.repeat([0.2, 0.005], 3)
    # Five deviations of a sample's deviation and mean.
    assert error.std(axis=0) == pytest.approx(expected, rel=5 / np.sqrt(2 * n))
    assert np.abs(error.mean(axis=0) / expected).max() < 5 / np.sqrt(n)
    angles = np.array([s.position for s in samples if isinstance(s, JointSample)])
    turns = []
    for measured, q in zip(angles, result.q[::2]):
        E = rotation(q).T @ rotation(measured)
        turns.append([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]])
    turns = np.array(turns) / 2
    assert turns.std(axis=0) == pytest.approx(1e-4, rel=5 / np.sqrt(2 * len(turns)))
    covariance = np.corrcoef(turns.T) - np.eye(3)
    assert np.abs(covariance).max() < 5 / np.sqrt(len(turns))
    # Near the hole's axis psi and phi are one rotation: each is noisy, their sum is not.
    tail = slice(-100, None)
    spread = angles[tail, 1:] - result.q[::2][tail, 1:]
    spread = (spread + np.pi) % (2 * np.pi) - np.pi
    assert spread.std(axis=0).min() > 3e-3
    assert spread.sum(axis=1).std() < 2e-4


def test_measured_angles_wrap():
    q = np.array([[0.3, np.pi, -np.pi], [0.3, 3.5, -7.0], [0.3, -np.pi - 1e-3, 12.0]])
    out = measured_angles(q, np.zeros((3, 3)))
    assert out[:, 0] == pytest.approx(0.3, abs=1e-15)
    assert (out[:, 1:] > -np.pi).all() and (out[:, 1:] <= np.pi).all()
    turns = (out[:, 1:] - q[:, 1:]) / (2 * np.pi)
    assert turns == pytest.approx(np.round(turns), abs=1e-12)


def test_joint_names_are_those_of_the_configuration():
    joints = JointInput(names=("tilt", "around", "spin"))
    start = contact_plan(
        [0.2, 0, 0], [0, 0, 2.0], [0, 0, -1e-3], 0.04, Configuration(joints=joints)
    )
    assert next(measure(integrate(start))).names == ("tilt", "around", "spin")


def test_bias_delay_and_tilt_of_the_hole_are_put_in_and_taken_out_again():
    plain = odd_sensor()
    configuration = plain.plan.configuration
    bias, rpy = ((1.0, -2.0, 3.0), (0.1, 0.2, -0.3)), (0.01, -0.02, 0.3)
    wrench = replace(configuration.wrench, bias_force=bias[0], bias_torque=bias[1])
    joints = replace(configuration.joints, delay=0.0035, hole_rpy=rpy)
    changed = replace(configuration, wrench=wrench, joints=joints)
    result = replace(plain, plan=replace(plain.plan, configuration=changed))
    samples = list(measure(result))
    assert [s.t_ns for s in samples] == sorted(s.t_ns for s in samples)
    read, directly = PegJoints(joints), PegJoints(configuration.joints)
    for kind in (JointSample, WrenchSample):
        before = [s for s in measure(plain) if isinstance(s, kind)]
        after = [s for s in samples if isinstance(s, kind)]
        assert len(before) == len(after)
        for old, new in zip(before, after):
            if kind is WrenchSample:
                assert new.t_ns == old.t_ns
                assert np.subtract(new.force, old.force) == pytest.approx(bias[0], abs=1e-12)
                assert np.subtract(new.torque, old.torque) == pytest.approx(bias[1], abs=1e-12)
            else:
                assert new.t_ns == old.t_ns + 3_500_000
                # 1e-9: gamma of some tenths, psi and phi by the sine of it.
                assert read(new).q == pytest.approx(directly(old).q, abs=1e-9)
