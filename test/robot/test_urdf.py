"""A robot's joints through its URDF and Pinocchio: kinematics, refusals, a whole replay."""

import os
import re
import sys

import numpy as np
import pytest

from arm import JOINTS, URDF, Arm, options
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.measurements.screws import TipPoses
from peg_on_hole_ros.robot.kinematics import UrdfKinematics, orientation_source
from peg_on_hole_ros.robot.urdf_file import read_chain
from peg_on_hole_ros.robot.urdf_source import beside

needs_pinocchio = pytest.mark.usefixtures("pinocchio")


@pytest.fixture(scope="module")
def pinocchio():
    return pytest.importorskip("pinocchio")


# The same arm with the joints that other machines have: a lift under it whose second stage
# follows the first, and a turntable in the tool geared to the wrist's last joint.
TEXT = URDF.read_text(encoding="utf-8")
MACHINE = TEXT.replace(
    "</robot>",
    """
  <link name="ground"/><link name="lift_low"/>
  <joint name="lift" type="prismatic"><parent link="ground"/><child link="lift_low"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.4" effort="1" velocity="1"/></joint>
  <joint name="lift_upper" type="prismatic"><parent link="lift_low"/><child link="pedestal"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.4" effort="1" velocity="1"/>
    <mimic joint="lift" multiplier="0.5" offset="0.01"/></joint>
  <link name="table"/>
  <joint name="turntable" type="revolute"><parent link="tool"/><child link="table"/>
    <origin xyz="0 0.01 0.02" rpy="0.3 -0.2 0.1"/><axis xyz="1 2 2"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/>
    <mimic joint="arm_7" multiplier="-0.25" offset="0.2"/></joint>
</robot>""",
)


def write(tmp_path, text, name="robot.urdf"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def check_kinematics(o, arm, positions_of):
    kinematics = UrdfKinematics(read_chain(o), o)
    rng = np.random.default_rng(1)
    positions = rng.uniform(-3, 3, (20, len(o.names)))
    for position, *fields in zip(positions, *kinematics.poses(positions)):
        pose = TipPoses(*fields)
        place, rotation, _ = arm.tip(positions_of(position))
        assert pose.position == pytest.approx(place, abs=1e-14)
        assert pose.rotation == pytest.approx(rotation.as_matrix(), abs=1e-14)
        for i in range(len(o.names)):
            h = 1e-6 * np.eye(len(o.names))[i]
            there, after, _ = arm.tip(positions_of(position + h))
            here, before, _ = arm.tip(positions_of(position - h))
            assert pose.velocities[:, i] == pytest.approx((there - here) / 2e-6, abs=1e-9)
            # Central differences: 1e-12 of their own error, 1e-16 / 1e-6 of rounding.
            turn = (after * before.inv()).as_rotvec() / 2e-6
            assert pose.jacobian[:, i] == pytest.approx(turn, abs=1e-9)
        # One joint state gives what it gives among others.
        for field, alone in zip(pose, kinematics.poses(position[np.newaxis])):
            assert (field == alone[0]).all()


@needs_pinocchio
def test_kinematics_of_the_arm_with_joints_in_any_order():
    names = tuple(JOINTS[i] for i in (4, 6, 0, 3, 1, 5, 2))
    check_kinematics(options(names=names), Arm(), lambda q: dict(zip(names, q)))


@needs_pinocchio
def test_kinematics_with_lift_and_joints_that_follow_others(tmp_path):
    names = ("lift", *JOINTS)
    o = options(urdf=write(tmp_path, MACHINE), tip_frame="table", names=names)

    def positions(q):
        by_name = dict(zip(names, q))
        follow = {"lift_upper": 0.5 * by_name["lift"] + 0.01}
        return by_name | follow | {"turntable": -0.25 * by_name["arm_7"] + 0.2}

    check_kinematics(o, Arm(MACHINE, "table"), positions)


ONE_JOINT = """<robot name="r"><link name="base"/><link name="tool"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="tool"/>
<origin xyz="0 0 0.5"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""


@needs_pinocchio
def test_kinematics_of_a_single_joint(tmp_path):
    o = options(urdf=write(tmp_path, ONE_JOINT), names=("turn",))
    check_kinematics(o, Arm(ONE_JOINT), lambda q: {"turn": q[0]})


def test_limits_are_those_of_the_revolute_joints(tmp_path):
    chain = read_chain(options())
    assert chain.upper == (2.96, 2.09, 2.96, 2.09, 2.96, 2.09, np.inf)
    assert chain.lower == tuple(-x for x in chain.upper)
    # Zero to zero is what exporters write where they know none.
    none = TEXT.replace('lower="-2.96" upper="2.96"', 'lower="0" upper="0"')
    chain = read_chain(options(urdf=write(tmp_path, none)))
    assert chain.upper[0] == np.inf and chain.lower[0] == -np.inf


ROLL = JOINTS[:3] + ("arm_5", "arm_6", "arm_7")


@pytest.mark.parametrize(
    ("change", "edit", "message"),
    [
        (
            {"tip_frame": "tol"},
            None,
            "joints.tip_frame = 'tol' is no link of {path}; the nearest are: tool",
        ),
        (
            {"names": ("arm_1", "arm2", *JOINTS[2:])},
            None,
            "joints.names: 'arm2' is no joint of {path}; the nearest are: arm_2, arm_7, arm_6",
        ),
        (
            {"names": ("q1",), "tip_frame": "pedestal"},
            lambda t: re.sub(r"(?s)<joint.*</joint>", "", t),
            "joints.names: 'q1' is no joint of {path}; it has: none",
        ),
        (
            {"names": ROLL},
            None,
            "joints.names lacks arm_4, which moves tool: every joint between the root link and "
            "the tip has to be read",
        ),
        (
            {"names": (*JOINTS, "finger_left")},
            None,
            "joints.names: 'finger_left' does not move tool; leave it out",
        ),
        (
            {"names": (*JOINTS, "gripper_to_tool")},
            None,
            "joints.names: 'gripper_to_tool' does not move tool; leave it out",
        ),
        (
            {"names": (*JOINTS, "finger_right"), "tip_frame": "right"},
            None,
            "joints.names: 'finger_right' mimics 'finger_left'; name that one in its place",
        ),
        (
            {},
            lambda t: t.replace('"arm_3" type="revolute"', '"arm_3" type="floating"'),
            "{path}: joint 'arm_3' is floating; between the root link and tool only revolute, "
            "continuous, prismatic and fixed joints can be read",
        ),
        (
            {"names": ("finger_left",), "tip_frame": "left"},
            lambda t: re.sub('"(revolute|continuous)"', '"fixed"', t),
            "{path}: no joint between the root link and left turns it, so the joints do not "
            "determine its orientation",
        ),
        (
            {},
            lambda t: t.replace('joint="finger_left"', 'joint="finger_right"').replace(
                '"gripper"/><child link="tool"', '"right"/><child link="tool"'
            ),
            "{path}: joint 'finger_right' mimics 'finger_right', which leads to no joint that "
            "moves by itself",
        ),
        (
            {},
            lambda t: t.replace('parent link="pedestal"', 'parent link="tool"'),
            "{path}: the links above 'tool' form a loop",
        ),
        (
            {},
            lambda t: t.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>', 1),
            "{path}: joint 'arm_1' turns about no axis: '0 0 0'",
        ),
        (
            {},
            lambda t: t.replace('upper="2.96"', 'upper="pi"', 1),
            "{path}: joint 'arm_1' has upper 'pi', which is no number",
        ),
        (
            {},
            lambda t: t.replace('<child link="base"/>', ""),
            "{path}: joint 'pedestal_to_base' lacks its name, parent or child",
        ),
        (
            {},
            lambda t: t[: len(t) // 2],
            "joints.urdf: {path} is not XML: ",
        ),
        (
            {},
            lambda t: "<sdf/>",
            "joints.urdf: {path} is not a URDF: it begins with <sdf>, not <robot>",
        ),
        (
            {},
            lambda t: t.replace(
                '<robot name="arm">',
                '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
                '<xacro:include filename="a"/>',
            ),
            "joints.urdf: {path} is to be expanded first: xacro {path} > robot.urdf",
        ),
    ],
)
def test_refusals_name_what_is_wrong(tmp_path, change, edit, message):
    path = write(tmp_path, edit(TEXT) if edit else TEXT)
    with pytest.raises(PegOnHoleError) as raised:
        read_chain(options(urdf=path, **change))
    text = str(raised.value)
    expected = message.replace("{path}", path)
    assert text == expected or (message.endswith(": ") and text.startswith(expected))


@needs_pinocchio
def test_what_only_the_parser_refuses_is_told_in_its_words_and_by_nobody_else(tmp_path, capfd):
    path = write(tmp_path, TEXT.replace('effort="', 'effort="x', 1))
    with pytest.raises(PegOnHoleError, match="is not a valid URDF: .*effort value .x176. is not"):
        orientation_source(options(urdf=path))
    # Of a colour or a mesh it complains as well, and goes on.
    unused = write(tmp_path, TEXT.replace('length="0.16"', 'length="x"', 1))
    orientation_source(options(urdf=unused))
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            'xyz="0.10 -0.20 0.75"',
            'xyz="0.10 x 0.75"',
            "has xyz '0.10 x 0.75', which is not three",
        ),
        ('xyz="0.10 -0.20 0.75"', 'xyz="1e308 0 0"', "has xyz '1e308 0 0', which is not three"),
        ("<axis xyz=", '<axis xyz="1e308 0 0"/><axis xyz=', "turns about no axis: '1e308 0 0'"),
        ("<axis xyz=", '<axis xyz="0 0 0"/><axis xyz=', "turns about no axis: '0 0 0'"),
    ],
)
def test_numbers_that_no_robot_has_are_named_with_their_joint(tmp_path, old, new, told):
    path = write(tmp_path, TEXT.replace(old, new, 1))
    with pytest.raises(PegOnHoleError, match=f"joint '[a-z0-9_]+' {re.escape(told)}"):
        read_chain(options(urdf=path))


def test_only_a_regular_file_of_bounded_size_is_read(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    large = tmp_path / "large.urdf"
    with large.open("wb") as file:
        file.truncate((16 << 20) + 1)
    for urdf, told in (
        ("/dev/zero", "/dev/zero is no regular file"),
        (str(tmp_path / "pipe"), "pipe is no regular file"),
        (str(large), "large.urdf has 16.7772 MB, a description at most 16 MB"),
        ("~nobody_at_all/x.urdf", "there is no user for '~nobody_at_all'"),
        ("a\0b", r"joints.urdf = 'a\\x00b' is no name of a file"),
    ):
        with pytest.raises(PegOnHoleError, match=told):
            read_chain(options(urdf=urdf))


def test_missing_file_is_named_in_full(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(PegOnHoleError) as raised:
        orientation_source(options(urdf="robot.urdf"))
    assert str(raised.value) == f"joints.urdf: there is no file {tmp_path / 'robot.urdf'}"


def test_without_pinocchio_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    with pytest.raises(PegOnHoleError, match=r"pip install pin; beside a"):
        orientation_source(options())


def test_other_package_of_that_name_is_told_apart(monkeypatch, tmp_path):
    write(tmp_path, "", "pinocchio.py")
    monkeypatch.delitem(sys.modules, "pinocchio", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(PegOnHoleError, match=r"pinocchio\.py is another package of that name"):
        orientation_source(options())
    sys.modules.pop("pinocchio", None)


def test_a_urdf_in_a_package_is_refused_with_where_to_look():
    with pytest.raises(PegOnHoleError) as raised:
        read_chain(options(urdf="package://ur_description/urdf/ur10.urdf"))
    assert str(raised.value) == (
        "joints.urdf = 'package://ur_description/urdf/ur10.urdf' names a package; give the file's "
        "path: `ros2 pkg prefix --share ur_description` prints the folder that has "
        "'urdf/ur10.urdf'"
    )


def test_a_urdf_lies_beside_the_parameters_file(tmp_path, monkeypatch):
    cell, elsewhere = tmp_path / "cell", tmp_path / "elsewhere"
    for folder in (cell, elsewhere):
        folder.mkdir()
    (cell / "arm.urdf").write_text(TEXT)
    path = cell / "cell.yaml"
    path.write_text(
        "peg_on_hole:\n  ros__parameters:\n    joints: {source: robot, urdf: arm.urdf, "
        "tip_frame: flange, names: [a]}\n"
    )
    monkeypatch.chdir(elsewhere)
    assert load(str(path))[0].joints.urdf == str(cell / "arm.urdf")
    assert beside("arm.urdf", ["/nowhere/x.yaml", str(path)]) == str(cell / "arm.urdf")
    # What the working directory has comes first, as before.
    (elsewhere / "arm.urdf").write_text(TEXT)
    assert load(str(path))[0].joints.urdf == "arm.urdf"
    assert beside("none.urdf", [str(path)]) == "none.urdf"
