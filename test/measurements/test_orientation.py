"""Rotation matrices to angles, rotation errors to angle errors, a robot's joints to both."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from arm import BENT, JOINTS, OPTIONS, Arm, angles, options, peg_rotation
from peg_on_hole_ros.measurements.angles import angle_covariance, angle_errors, angles_of
from peg_on_hole_ros.measurements.orientation import RobotJoints
from peg_on_hole_ros.measurements.screws import empty_poses
from peg_on_hole_ros.measurements.tuned import PLAUSIBLE_JOINTS
from peg_on_hole_ros.records import JointSample
from tiers import nightly

TURN = st.floats(-3.1, 3.1)
BENT_OVER_HOLE = Arm().joints_at(np.zeros(3), peg_rotation([0.2, 0.1, 0.3]), BENT)


def wrapped(x):
    return np.pi - (np.pi - np.asarray(x)) % (2 * np.pi)


@given(gamma=st.floats(1e-9, 3.1), psi=TURN, phi=TURN)
def test_angles_come_back(gamma, psi, phi):
    q = angles_of(peg_rotation([gamma, psi, phi]).as_matrix())
    # scipy's matrix is rounded: 1e-16 of an axis that leans by gamma turns psi by 1e-16/gamma.
    tolerance = 1e-14 + 1e-15 / np.sin(gamma)
    assert q[0] == pytest.approx(gamma, abs=1e-14)
    assert wrapped(q[1] - psi) == pytest.approx(0, abs=tolerance)
    # The sum is known however small the tilt; near pi it is the difference.
    known = q[1] + q[2] - psi - phi if gamma < 1.5 else q[1] - q[2] - psi + phi
    assert wrapped(known) == pytest.approx(0, abs=1e-14)


@pytest.mark.parametrize("gamma", [0.0, 1e-300, 1e-17])
def test_untilted_peg_has_its_turn_in_the_sum(gamma):
    q = angles_of(peg_rotation([gamma, 0.0, 1.3]).as_matrix())
    assert q[0] == pytest.approx(gamma, abs=1e-16)
    assert wrapped(q[1] + q[2]) == pytest.approx(1.3, abs=1e-15)


@given(gamma=st.floats(0.01, 1.5), psi=TURN, phi=TURN)
def test_angle_errors_against_turned_rotations(gamma, psi, phi):
    rotation, h = peg_rotation([gamma, psi, phi]), 1e-5
    T = angle_errors([gamma, psi, phi])
    for i, axis in enumerate(np.eye(3)):
        after = angles_of((Rotation.from_rotvec(h * axis) * rotation).as_matrix())
        before = angles_of((Rotation.from_rotvec(-h * axis) * rotation).as_matrix())
        slope = wrapped(after - before) / (2 * h)
        # Third derivatives go like gamma^-3 times h^2; rounding of psi 1e-16 / (gamma h).
        assert slope == pytest.approx(T[:, i], abs=4 * h**2 / gamma**3 + 1e-10 / gamma)


@pytest.mark.parametrize("gamma", [0.0, 1e-9, 1e-6, 1e-4, 0.05, 0.7, 1.5])
def test_error_of_the_sum_stays_known_at_any_tilt(gamma):
    T = angle_errors([gamma, 0.3, 0.4])
    assert np.isfinite(T).all()
    covariance = 1e-8 * T @ T.T
    assert np.linalg.eigvalsh(covariance)[0] > 0
    # psi + phi turns about z and, the more the peg tilts, about h: 1 + tan(gamma/2)^2.
    one = np.array([0.0, 1.0, 1.0])
    # Variances of psi and phi are up to 1e12 times that of the sum: four digits are left.
    assert one @ covariance @ one == pytest.approx(1e-8 * (1 + np.tan(gamma / 2) ** 2), rel=1e-3)
    assert pytest.approx(angle_covariance(gamma, 1.0), rel=1e-9, abs=1e-9) == T @ T.T


class ByFormulas:
    """The arm's kinematics without Pinocchio."""

    lower, upper = np.full(7, -2.96), np.full(7, 2.96)

    def __init__(self):
        self.arm = Arm()

    def poses(self, positions):
        poses = empty_poses(*positions.shape)
        for i, position in enumerate(positions):
            _, rotation, axes = self.arm.tip(dict(zip(JOINTS, position)))
            poses.rotation[i] = rotation.as_matrix()
            poses.jacobian[i] = np.array([axes[name][0] for name in JOINTS]).T
        return poses


def sample(position, names=JOINTS):
    return JointSample(7, tuple(names), tuple(position))


@pytest.mark.parametrize("gamma", [0.15, *nightly(0.02, 0.9)])
def test_covariance_is_that_of_joints_with_noise(gamma):
    source, arm, q = RobotJoints(OPTIONS, ByFormulas()), Arm(), [gamma, 0.6, -1.0]
    joints = arm.joints_at(np.array([1e-3, 0.0, 2e-3]), peg_rotation(q), BENT)
    measured = source(sample(joints))
    assert measured.q == pytest.approx(q, abs=1e-9)
    noise = np.random.default_rng(3).normal(0, OPTIONS.position_stddev, (4000, 7))
    errors = angles(arm.peg((joints + noise).T)[1]) - q
    errors[:, 1:] = wrapped(errors[:, 1:])
    white = np.linalg.solve(np.linalg.cholesky(measured.covariance), errors.T)
    # Entries of a sample covariance of n white samples spread by sqrt(2/n) on its diagonal and
    # sqrt(1/n) beside it: 0.022; five of these. At 0.02 rad second-order terms are below 1 %.
    assert white @ white.T / len(noise) == pytest.approx(np.eye(3), abs=0.11)
    assert white.mean(axis=1) == pytest.approx(np.zeros(3), abs=5 / np.sqrt(len(noise)))


def test_joints_in_any_order_among_others():
    source = RobotJoints(OPTIONS, ByFormulas())
    plain = source(sample(BENT_OVER_HOLE))
    order = [3, 0, 6, 1, 5, 2, 4]
    names = ["finger_left", *(JOINTS[i] for i in order), "finger_right"]
    mixed = source(sample([np.nan, *BENT_OVER_HOLE[order], np.inf], names))
    assert mixed.t_ns == 7
    assert mixed.q.tolist() == plain.q.tolist()
    assert mixed.covariance.tolist() == plain.covariance.tolist()


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda q: (q[:6], JOINTS[:6]), "missing_joint"),
        (lambda q: ([*q[:6], np.nan], JOINTS), "not_finite"),
        (lambda q: (np.degrees(q), JOINTS), "outside_joint_limits"),
    ],
)
def test_samples_without_orientation_say_why(change, reason):
    source = RobotJoints(OPTIONS, ByFormulas())
    assert source(sample(*change(BENT_OVER_HOLE))) == reason


def test_limits_have_a_margin():
    source = RobotJoints(OPTIONS, ByFormulas())
    for excess, reason in ((0.05, False), (0.15, True)):
        position = BENT_OVER_HOLE.copy()
        position[0] = 2.96 + excess
        assert (source(sample(position)) == "outside_joint_limits") is reason


def test_peg_frame_the_wrong_way_up_is_named():
    source = RobotJoints(options(peg_rpy=(0.0, 0.0, 0.0)), ByFormulas())
    assert source(sample(BENT_OVER_HOLE)) == "pointing_away"


def test_joints_that_turn_about_one_axis_leave_a_covariance_that_can_be_inverted():
    class Hinge:
        lower, upper = np.array([-np.inf]), np.array([np.inf])

        def poses(self, positions):
            poses = empty_poses(*positions.shape)
            poses.rotation[:] = Rotation.from_rotvec([[0, x, 0] for (x,) in positions]).as_matrix()
            poses.jacobian[:, 1] = 1.0
            return poses

    still = {"peg_rpy": (0.0, 0.0, 0.0), "hole_rpy": (0.0, 0.0, 0.0)}
    source = RobotJoints(options(names=("hinge",), **still), Hinge())
    measured = source(sample([-0.3], ["hinge"]))
    assert measured.q == pytest.approx([0.3, 0.0, 0.0], abs=1e-15)
    low, *_ = np.linalg.eigvalsh(measured.covariance)
    floor = PLAUSIBLE_JOINTS.orientation_stddev
    assert low >= 0.4 * floor**2
    variance = OPTIONS.position_stddev**2 + floor**2
    assert measured.covariance[0, 0] == pytest.approx(variance, rel=1e-12)
