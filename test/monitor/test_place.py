"""Where the peg is, as a robot's joints tell it, against where three contacts would have it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from arm import BENT, JOINTS, OPTIONS, Arm, options, peg_rotation
from peg_on_hole_ros.config.configuration import Configuration, from_parameters
from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.measurements.orientation import PegJoints, RobotJoints
from peg_on_hole_ros.measurements.screws import TipPoses
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitor.place_check import misfit, touching_place
from peg_on_hole_ros.monitor.tuned import EVIDENCE_WEIGHTS, PLACE_CHECK
from peg_on_hole_ros.records import ANGLES, AngleMeasurement, JointSample, WrenchSample
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.sim.truth import integrate
from simulated import contact_plan

pytestmark = pytest.mark.xdist_group("simulation")
SCENE = Scene()
VALUES = np.array([SCENE.peg_diameter, SCENE.hole_diameter])


@cache
def closing():
    return integrate(contact_plan([0.2, 0.4, 0.0], [-0.16, 0.2, 1.5], [-2e-4, 0, -1e-3], 0.25))


def measured(q, position, stddev=1e-4, angle_stddev=1e-5):
    covariances = angle_stddev**2 * np.eye(3), stddev**2 * np.eye(3)
    return AngleMeasurement(0, np.array(q), covariances[0], np.array(position), covariances[1])


def held_against(seen, diameter_variance=0.0):
    return misfit(*seen[1:], *VALUES, diameter_variance, PLACE_CHECK.around)


def test_touching_place_is_that_of_the_simulated_peg():
    truth = closing()
    for k in range(0, len(truth.t_ns), 40):
        place = touching_place(*VALUES, *truth.q[k, :2])
        assert place == pytest.approx(truth.position[k], abs=1e-12)


@pytest.mark.nightly
@pytest.mark.parametrize(("draws", "within"), [(500, 0.33), (2000, 0.17)])
def test_what_the_hole_and_the_angles_leave_open_is_in_the_deviations(draws, within):
    """White draws of place, angle and clearance: chi-squared with three degrees of freedom."""
    rng = np.random.default_rng(5)
    q, spread, squares = np.array([0.12, 0.5, 0.0]), 5e-6, []
    for _ in range(draws):
        d = VALUES[0] + rng.normal(0, spread)
        place = touching_place(d, VALUES[1], *q[:2]) + rng.normal(0, 2e-5, 3)
        seen = measured(q + rng.normal(0, 1e-3, 3), place, 2e-5, 1e-3)
        squares.append(held_against(seen, spread**2).deviations ** 2)
    # Mean 3 with sqrt(6/2000) = 0.055, of 500 twice that; three of these.
    assert np.mean(squares) == pytest.approx(3.0, abs=within)


def test_only_a_place_that_cannot_be_explained_is_evidence():
    q = [0.15, 0.3, 0.1]
    place = touching_place(*VALUES, *q[:2])
    assert held_against(measured(q, place)).evidence == 0.0
    lifted = place + [0.0, 0.0, 1e-3]
    found = held_against(measured(q, lifted))
    assert found.evidence == EVIDENCE_WEIGHTS.most
    assert found.offset == pytest.approx(1e-3) and found.deviations == pytest.approx(10, rel=0.01)
    # Two standard deviations of one draw of the hole's place say nothing.
    assert held_against(measured(q, place + [2e-4, 0, 0])).evidence == 0.0
    # Nor does anything where that place is hardly known.
    assert held_against(measured(q, lifted, 1e-2)).evidence == 0.0


@pytest.mark.parametrize(
    ("place", "off"),
    [
        ([0.0, 0.0, 0.0], 0.0),
        ([5e-5, 0.0, -8e-3], 0.0),
        ([0.0, 0.0, 5e-3], 5e-3),
        ([4e-3, 3e-3, -8e-3], 5e-3 - 1e-4),
        # At 10 mrad two points let it (D - d cos(gamma))/sin(gamma) = 10.25 mm deep.
        ([0.0, 0.0, -12e-3], 12e-3 - 10.2497e-3),
    ],
)
def test_below_gamma0_a_peg_touches_the_hole_only_from_within(place, off):
    found = held_against(measured([0.010, 0.3, 0.0], place, 1e-3))
    assert found.offset == pytest.approx(off, abs=1e-7)
    assert found.deviations == pytest.approx(off / 1e-3, abs=1e-3)
    assert (found.evidence > 0.9 * EVIDENCE_WEIGHTS.most) == (off > 4.5e-3)


@pytest.mark.parametrize(
    ("gamma", "height", "mode"),
    [
        (0.010, 0.3, "open"),
        (0.010, -0.008, "two_point"),
        # A place that is stated wrongly shows in the rim's path, for which contacts have to be
        # weighed: above gamma0 the mode is in doubt. The lowest point is 5 mm below the middle.
        (0.2, 0.3, "unknown"),
        (0.2, 0.02, "unknown"),
    ],
)
def test_what_a_sensor_makes_up_in_the_air_is_no_contact(gamma, height, mode):
    """A peg at any tilt, whose sensor shows 2 N and 0.1 N m, above the hole and in it."""
    rng, modes = np.random.default_rng(7), []

    def place(sample):
        noise = np.array([1e-4, 1e-4 / gamma, 1e-4])
        q = np.array([gamma, 0.3, 0.0]) + rng.normal(0, 1, 3) * noise
        covariance = np.diag(noise) ** 2
        where = np.array([0.0, 0.0, height])
        return AngleMeasurement(sample.t_ns, q, covariance, where, 1e-6 * np.eye(3))

    line = Pipeline(Configuration(), place)
    for k in range(300):
        line.on_joints(JointSample(k * 1_000_000, ANGLES, (0.0, 0.0, 0.0)))
        force = rng.normal(0, 0.2, 3) + [2.0, 0.0, 4.9]
        torque = rng.normal(0, 0.005, 3) + [0.0, 0.1, 0.0]
        outputs = line.on_wrench(WrenchSample(k * 1_000_000, tuple(force), tuple(torque)))
        modes.append(outputs.contact_mode if outputs else mode)
    assert set(modes[50:]) == {mode}


class Placed:
    """The truth's angles and place, the peg's offset by what is lifted from a time on."""

    def __init__(self, truth, configuration, lift=None, stddev=2e-4):
        self.truth, self.lift, self.variance = truth, lift, stddev**2
        self.angles = PegJoints(configuration.joints)
        # One draw of the hole's place for the run.
        self.hole = np.random.default_rng(2).normal(0, stddev, 3)

    def __call__(self, sample):
        measurement = self.angles(sample)
        if self.lift is None:
            return measurement
        k = int(np.argmin(np.abs(self.truth.t_ns - sample.t_ns)))
        place = self.truth.position[k] + self.hole
        place += (sample.t_ns > 100_000_000) * np.array(self.lift)
        covariance = self.variance * np.eye(3)
        return measurement._replace(position=place, position_covariance=covariance)


def played(lift):
    truth = closing()
    configuration = truth.plan.configuration
    pipeline = Pipeline(configuration, Placed(truth, configuration, lift))
    outputs = []
    for sample in measure(truth, 3, 0):
        if isinstance(sample, WrenchSample):
            outputs.append(pipeline.on_wrench(sample))
        else:
            pipeline.on_joints(sample)
    return {o.t_ns // 1_000_000: o for o in outputs if o is not None}


def test_a_lifted_peg_whose_wrench_would_fit_is_not_taken_for_three_contacts():
    """As one that stands on a chip: tilt, motion and wrench are those of a peg on three points."""
    unseen, fits, lifted = played(None), played([0, 0, 0]), played([0, 0, 1.5e-3])
    for t in (90, 150, 200, 229):
        assert unseen[t].monitor["three_point_validity"] > 0.95
        assert "position_misfit" not in unseen[t].monitor
        assert fits[t].monitor["three_point_validity"] > 0.95
        assert fits[t].monitor["position_misfit"] < 4.0
    assert lifted[90].contact_mode == "three_point"
    for t in (150, 200, 229):
        assert lifted[t].monitor["three_point_validity"] < 0.1
        assert lifted[t].contact_mode == "elsewhere"
        assert lifted[t].monitor["position_offset"] == pytest.approx(1.5e-3, abs=6e-4)
        # What it is said to be is something else, and no contact that was lost.
        assert {a.level for a in lifted[t].alarms if a.name == "contact_loss"} == {0}


class Known:
    lower, upper = np.full(7, -2.96), np.full(7, 2.96)

    def __init__(self):
        self.arm = Arm()

    def poses(self, positions):
        return TipPoses(*map(np.stack, zip(*map(self.pose, positions))))

    def pose(self, position):
        p, rotation, axes = self.arm.tip(dict(zip(JOINTS, position)))
        turns = np.array([axes[name][0] for name in JOINTS]).T
        moves = np.array([np.cross(axes[n][0], p - axes[n][1]) for n in JOINTS]).T
        return rotation.as_matrix(), turns, p, moves


def test_place_and_its_covariance_are_those_of_joints_with_noise():
    arm, q, place = Arm(), [0.15, 0.6, -1.0], np.array([1e-3, 2e-3, 4e-3])
    joints = arm.joints_at(place, peg_rotation(q), BENT)
    sample = JointSample(7, JOINTS, tuple(joints))
    assert RobotJoints(options(hole_xyz_stddev=0.0), Known())(sample).position is None
    source = RobotJoints(options(hole_xyz_stddev=1e-5), Known())
    found = source(sample)
    assert found.position == pytest.approx(place, abs=1e-9)
    noise = np.random.default_rng(3).normal(0, OPTIONS.position_stddev, (4000, 7))
    places = arm.peg((joints + noise).T)[0]
    expected = np.cov(places.T) + 1e-10 * np.eye(3)
    white = np.linalg.inv(np.linalg.cholesky(found.position_covariance))
    # As in test_orientation: five standard deviations of a sample covariance of 4000.
    assert white @ expected @ white.T == pytest.approx(np.eye(3), abs=0.11)


def test_a_place_is_asked_of_a_robot_only():
    with pytest.raises(PegOnHoleError, match="hole_xyz_stddev = 0.002 m needs joints.source rob"):
        from_parameters({"joints.hole_xyz_stddev": 0.002})


def test_a_place_is_used_where_it_is_stated_and_nowhere_else():
    """A hole at the origin of the root link is one that nobody has placed."""
    robot = replace(JointInput(), source="robot", hole_xyz=(0.5, 0.0, 0.1))
    assert robot.place_stddev == 1e-3
    assert replace(robot, hole_xyz_stddev=0.0).place_stddev is None
    assert replace(robot, hole_xyz=(0.0, 0.0, 0.0)).place_stddev is None
    assert JointInput().place_stddev is None
