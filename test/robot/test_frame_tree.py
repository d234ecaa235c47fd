"""Which frames peg and hole have in the robot's tree, and what is told where they have none."""

from dataclasses import replace

import pytest

from arm import OPTIONS
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.options import Configuration, Frames, JointInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.robot.frame_tree import frame_tree

NOWHERE = JointInput().hole_xyz


def tree(frames=None, joints=OPTIONS, **changes):
    joints = replace(joints, **changes)
    return frame_tree(Configuration(joints=joints, frames=frames or Frames()))


def test_the_hole_hangs_at_the_root_link_where_its_place_is_stated():
    found = tree()
    assert found == ("pedestal", "hole", "peg", OPTIONS.hole_xyz, OPTIONS.hole_rpy, "", "")
    assert tree(hole_xyz=NOWHERE)[:3] == ("", "hole", "peg")
    # However well the origin of the root link is known, nobody has put a hole there.
    assert tree(hole_xyz=NOWHERE, hole_xyz_stddev=2e-3).base == ""
    # As with a prefix that the robot's own publisher adds.
    assert tree(Frames(base="left/pedestal")).base == "left/pedestal"


def test_the_frame_of_a_chamfered_hole_is_that_of_its_throat():
    scene = replace(Configuration().scene, hole_chamfer=0.5e-3)
    joints = replace(OPTIONS, hole_rpy=(0.0, 0.0, 0.3))
    found = frame_tree(Configuration(scene=scene, joints=joints))
    x, y, z = OPTIONS.hole_xyz
    assert found[3] == pytest.approx((x, y, z - 0.5e-3), abs=1e-12)


def test_without_a_robot_the_base_is_named():
    peg = JointInput(hole_xyz=(0.4, 0.0, 0.1))
    assert tree(joints=peg).base == ""
    assert tree(Frames(base="table"), peg)[:3] == ("table", "hole", "peg")


def test_a_description_that_has_not_come_leaves_both_out():
    assert tree(urdf="topic")[:3] == ("", "hole", "")


@pytest.mark.parametrize(
    ("frames", "changes", "base", "peg", "told"),
    [
        (Frames(hole="tool"), {}, "", "peg", "frames.hole = 'tool' is a link of"),
        (Frames(peg="tool"), {}, "pedestal", "", "frames.peg = 'tool' is a link of"),
        (Frames(base="base"), {}, "", "peg", "is not the root link 'pedestal'"),
        (Frames(base="x"), {"hole_xyz": NOWHERE}, "", "peg", "joints.hole_xyz is not stated"),
        # Nothing is published, so nothing is a second parent.
        (Frames(hole="tool"), {"hole_xyz": NOWHERE}, "", "peg", ""),
    ],
)
def test_what_would_break_the_tree_is_left_out_and_told(frames, changes, base, peg, told):
    found = tree(frames, **changes)
    lines = [found.hole_line, found.peg_line]
    assert (found.base, found.peg) == (base, peg)
    assert told in "".join(lines) and lines.count("") == (1 if told else 2)


@pytest.mark.parametrize(
    ("parameters", "told"),
    [
        ({"frames.hole": "/hole"}, "frames.hole = '/hole' begins with a slash"),
        ({"frames.peg": ""}, "frames.peg is empty; it is a string such as 'peg'"),
        ({"frames.peg": "hole"}, "frames.hole and frames.peg are both 'hole'"),
        ({"frames.base": "peg"}, "frames.peg and frames.base are both 'peg'"),
    ],
)
def test_names_that_are_no_frames_are_refused(parameters, told):
    with pytest.raises(PegOnHoleError) as caught:
        from_parameters(parameters)
    assert str(caught.value).startswith(told)
