"""Places that are stated on a plate's face and at a peg's tip, where both have chamfers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from arm import BENT, JOINTS, OPTIONS, Arm, options, peg_rotation
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.measurements.edges import at_edges
from peg_on_hole_ros.measurements.orientation import RobotJoints
from peg_on_hole_ros.measurements.screws import TipPoses
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.replay.run import replay_bag
from simulated import ROOT

KNOWN = options(hole_xyz_stddev=1e-5)


class ByFormulas:
    lower, upper = np.full(7, -2.96), np.full(7, 2.96)

    def poses(self, positions):
        p, rotation, axes = Arm().tip(dict(zip(JOINTS, positions[0])))
        turns = np.array([axes[name][0] for name in JOINTS]).T
        moves = np.array([np.cross(axes[n][0], p - axes[n][1]) for n in JOINTS]).T
        return TipPoses(*(np.stack([x]) for x in (rotation.as_matrix(), turns, p, moves)))


def test_the_place_is_that_of_the_shoulder_against_the_throat():
    """A tip that stands in the plane of a face, beside its hole, is that of no contact."""
    q, tip = np.array([0.15, 0.6, -1.0]), np.array([1e-3, 2e-3, -3e-4])
    # The arm holds the tip there in the frame of the face, by its own formulas.
    sample = JointSample(0, JOINTS, tuple(Arm().joints_at(tip, peg_rotation(q), BENT)))
    scene = Scene(hole_chamfer=7e-4, peg_chamfer=4e-4)
    sharp, found = (
        RobotJoints(at_edges(KNOWN, s), ByFormulas())(sample) for s in (Scene(), scene)
    )
    assert sharp.position == pytest.approx(tip, abs=1e-9)
    # The shoulder stands up the peg's axis from the tip, and the throat below the face.
    shoulder = tip + 4e-4 * peg_rotation(q).as_matrix()[:, 2]
    assert found.position == pytest.approx(shoulder + [0.0, 0.0, 7e-4], abs=1e-9)
    np.testing.assert_array_equal(found.q, sharp.q)


def test_without_chamfers_nothing_is_computed():
    assert at_edges(OPTIONS, Scene()) is OPTIONS
    only = at_edges(OPTIONS, Scene(peg_chamfer=4e-4))
    assert only.hole_xyz is OPTIONS.hole_xyz and only.peg_xyz != OPTIONS.peg_xyz


def test_they_are_parameters():
    stated = from_parameters({"scene.hole_chamfer": 5e-4, "scene.peg_chamfer": 3e-4})
    assert stated.scene == replace(Configuration().scene, hole_chamfer=5e-4, peg_chamfer=3e-4)


class Kept:
    def __init__(self):
        self.rows = []

    def take(self, columns):
        self.rows.append(columns.rows.copy())


def played(configuration):
    kept = Kept()
    replay_bag(Bag(ROOT / "bags" / "cell_ur_like.mcap"), configuration, 0.0, [kept])
    return np.concatenate(kept.rows)


def test_a_cell_that_is_stated_by_face_and_tip_has_the_numbers_of_the_edges():
    """Sensor by the URDF, place and reactions: all are as where throat and shoulder are stated."""
    pytest.importorskip("pinocchio")
    configuration, _ = load(ROOT / "config" / "cell_ur_like.yaml")
    joints = replace(configuration.joints, hole_xyz_stddev=1e-3)
    by_edges = replace(configuration, joints=joints)
    scene = replace(by_edges.scene, hole_chamfer=7e-4, peg_chamfer=4e-4)
    up_hole, up_peg = (
        Rotation.from_euler("xyz", rpy).as_matrix()[:, 2]
        for rpy in (joints.hole_rpy, joints.peg_rpy)
    )
    outer = replace(
        joints,
        hole_xyz=tuple(joints.hole_xyz + 7e-4 * up_hole),
        peg_xyz=tuple(joints.peg_xyz - 4e-4 * up_peg),
    )
    expected, found = (played(c) for c in (by_edges, replace(by_edges, scene=scene, joints=outer)))
    # Places differ by rounding, and the sensor's is rounded to a nanometre.
    for name in ("position_offset", "state", "normal", "contact_mode"):
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-6, atol=1e-7)
    assert np.isfinite(found["position_offset"]).sum() > 1000
