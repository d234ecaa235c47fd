"""Descriptions that no robot has: refused before the library sees them, which dies by some."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from cli_helpers import fails
from peg_on_hole_ros.bags.writer import (
    CONFIGURATION_METADATA,
    URDF_METADATA,
    configuration_metadata,
)
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.cli.many_bags.task import work
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.robot.kinematics import UrdfKinematics
from peg_on_hole_ros.robot.urdf_file import MOST_DEPTH, MOST_FREEDOMS, MOST_LINKS, read_chain
from peg_on_hole_ros.robot.urdf_source import MOST_URDF_BYTES
from recorded import STORE, Row, motion, write, writer
from tiers import at_push

DESCRIPTION = "/robot_description"
STRING = "std_msgs/msg/String"
AXIS = "<axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' velocity='1'/>"
TURN = f"<joint name='j' type='revolute'><parent link='a'/><child link='tip'/>{AXIS}</joint>"
ONE = f"<link name='a'/><link name='tip'/>{TURN}"


def joint(name, parent, child, kind="fixed", more=""):
    ends = f"<parent link='{parent}'/><child link='{child}'/>"
    return f"<joint name='{name}' type='{kind}'>{ends}{more}</joint>"


def robot(*parts):
    return f"<robot name='r'>{''.join(parts)}</robot>"


def links(count):
    return "".join(f"<link name='l{i}'/>" for i in range(count))


def chain(depth, kind="fixed"):
    """Links one below the other, behind the joint that turns the tip."""
    parents = ["tip", *(f"l{i}" for i in range(depth - 2))]
    joints = (joint(f"j{i}", at, f"l{i}", kind, AXIS) for i, at in enumerate(parents))
    return robot(ONE, links(depth - 1), *joints)


def star(freedoms, kind="revolute", each=1):
    count = (freedoms - 1) // each
    joints = (joint(f"j{i}", "a", f"l{i}", kind, AXIS) for i in range(count))
    return robot(ONE, links(count), *joints)


def leaves(count):
    return robot(ONE, links(count - 2), *(joint(f"j{i}", "a", f"l{i}") for i in range(count - 2)))


def with_joint(more, kind="revolute"):
    return robot("<link name='a'/><link name='tip'/>", joint("j", "a", "tip", kind, more))


def mimicking(factor):
    """A joint that follows one that follows another, as often as it takes."""
    joints, parents = [], ("a", "l0", "l1")
    for i, parent in enumerate(parents):
        follows = f"<mimic joint='j{i + 1}' multiplier='{factor}'/>"
        joints.append(joint(f"j{i}", parent, f"l{i}", "revolute", AXIS + follows))
    joints.append(joint("j3", "l2", "tip", "revolute", AXIS))
    return robot("<link name='a'/><link name='tip'/>", links(3), *joints)


BILLION = "".join(f"<!ENTITY e{i} '{f'&e{i - 1};' * 10 if i else 'ha' * 10}'>" for i in range(12))
DEADLY = {
    "chain": (chain(4000, "revolute"), "has 4001 links and 4000 degrees of freedom"),
    "fixed chain": (chain(4000), "has 4001 links and 1 degrees of freedom"),
    "deep": (chain(MOST_DEPTH + 1), f"has {MOST_DEPTH + 1} joints one behind the other"),
    "joints": (star(MOST_FREEDOMS + 1), f"and {MOST_FREEDOMS + 1} degrees of freedom"),
    "floating": (star(MOST_FREEDOMS + 5, "floating", 6), "degrees of freedom, of at most"),
    "links": (leaves(MOST_LINKS + 1), f"has {MOST_LINKS + 1} links"),
    "nested": (robot("<a>" * 10**5, "</a>" * 10**5), "no description of a robot"),
    "elements": (robot("<a/>" * 10**6), "no description of a robot"),
    "large": (robot("<!--", "x" * MOST_URDF_BYTES, "-->"), "a description at most 16000000"),
    "entities": (f"<!DOCTYPE r [{BILLION}]><robot>&e11;</robot>", "has a DOCTYPE"),
    "encoding": ("<?xml version='1.0' encoding='big5'?><robot/>", "is not XML: "),
    "no axis": (with_joint("<axis xyz='1e-200 0 0'/>"), "turns about no axis: '1e-200 0 0'"),
    "NaN axis": (with_joint("<axis xyz='nan 0 0'/>"), "turns about no axis: 'nan 0 0'"),
    "infinite place": (with_joint(f"<origin xyz='inf 0 0'/>{AXIS}"), "has xyz 'inf 0 0'"),
    "endless mimic": (mimicking("1e300"), "has multiplier '1e300', more than 1e+06"),
    "mimic of mimics": (mimicking("1e5"), "times 'j3' and 0, which is more than 1e+06"),
    "two joints of a name": (robot(ONE, TURN), "has two joints 'j'"),
    "link on two joints": (robot(ONE, joint("k", "a", "tip")), "'j' and 'k' both carry 'tip'"),
    "link twice": (robot(ONE, "<link name='a'/>"), "not a valid URDF"),
    "two roots": (robot(ONE, "<link name='b'/>"), "not a valid URDF"),
    "no such link": (robot(ONE, joint("k", "tip", "nowhere")), "not a valid URDF"),
    "loop": (robot(ONE, joint("k", "tip", "a")), "the links above 'tip' form a loop"),
    "unknown joint": (with_joint("", "ball"), "is ball; between the root link and tip only"),
}
PARAMETERS = {
    "joints.source": "robot",
    "joints.tip_frame": "tip",
    "joints.names": ["j"],
    "wrench.sensor_pose": "stated",
}


def bag_with(path, text):
    """Write a bag that holds a description in its metadata."""
    return _bag(path, "/nowhere.urdf", motion(20), {URDF_METADATA: {"text": text}})


def bag_that_says(path, payload):
    """Write a bag with a message on the topic of the description."""
    return _bag(path, "topic", [Row(DESCRIPTION, 10**9, payload), *motion(20)], {})


def _bag(path, urdf, rows, metadata):
    configuration = from_parameters(PARAMETERS | {"joints.urdf": urdf})
    metadata[CONFIGURATION_METADATA] = configuration_metadata(configuration)
    with writer(path, metadata=metadata) as add:
        for row in rows:
            add(row, STRING if row.topic == DESCRIPTION else None)
    return path


@pytest.fixture(autouse=True)
def library():
    pytest.importorskip("pinocchio")


@pytest.mark.parametrize("name", at_push(["fixed chain", "joints", "entities", "loop"], DEADLY))
def test_a_bag_with_a_description_that_no_robot_has_ends_with_one_line(name, tmp_path, capsys):
    text, told = DEADLY[name]
    path = bag_with(tmp_path / "a.mcap", text)
    assert main(["replay", str(path)]) == 2
    out, err = capsys.readouterr()
    line = err.splitlines()[-1]
    assert line.startswith("peg-on-hole: error: ") and told in line and len(line) < 1000
    assert "fault of the program" not in line
    assert main(["inspect", str(path)]) in (0, 2)
    out, err = capsys.readouterr()
    assert told in out + err and "fault of the program" not in out + err


def test_a_description_by_a_topic_has_the_same_bounds(tmp_path, capsys):
    text, told = DEADLY["fixed chain"]
    message = bytes(STORE.serialize_cdr(STORE.types[STRING](data=text), STRING))
    path = bag_that_says(tmp_path / "a.mcap", message)
    assert main(["replay", str(path)]) == 2
    assert told in capsys.readouterr().err.splitlines()[-1]


def test_a_description_by_a_topic_that_cannot_be_read_is_told(tmp_path, capsys):
    path = bag_that_says(tmp_path / "a.mcap", b"\0\1\0\0\4\0\0\0\xff\xff\xff\xff")
    message = f"{path}: no message on {DESCRIPTION} can be read as {STRING}"
    fails(capsys, 3, message, "replay", path)


@pytest.mark.parametrize(
    "text",
    [chain(MOST_DEPTH), star(MOST_FREEDOMS), leaves(MOST_LINKS)],
    ids=["deep", "wide", "big"],
)
def test_the_library_carries_what_is_within_the_bounds(text):
    stated = from_parameters(PARAMETERS | {"joints.urdf": "topic"}).joints
    joints = replace(stated, description=text)
    pose = UrdfKinematics(read_chain(joints), joints).poses(np.array([[0.5]]))
    turn = np.array([[np.cos(0.5), -np.sin(0.5), 0], [np.sin(0.5), np.cos(0.5), 0], [0, 0, 1]])
    assert pose.rotation[0] == pytest.approx(turn, abs=1e-15)


OTHERWISE = {
    "line break in a link": ("t\np", "t p", "j", "j", "link 't p'"),
    "tab in a link": ("t\tp", "t p", "j", "j", "link 't p'"),
    "line break in a joint": ("tip", "tip", "j\n1", "j 1", "joint 'j 1'"),
    "letters of another encoding": ("t\xef", "t\xc3\xaf", "j", "j", "link 't\xc3\xaf'"),
}


@pytest.mark.parametrize("name", OTHERWISE)
def test_a_name_that_the_library_reads_otherwise_is_refused(name):
    """Asked for a frame that it does not have, it reads memory that is not its own."""
    link, tip_frame, turning, named, told = OTHERWISE[name]
    text = "<?xml version='1.0' encoding='latin-1'?>" if "encoding" in name else ""
    text += robot(
        "<link name='a'/>", f"<link name='{link}'/>", joint(turning, "a", link, "revolute", AXIS)
    )
    changed = {"joints.urdf": "topic", "joints.tip_frame": tip_frame, "joints.names": [named]}
    joints = replace(from_parameters(PARAMETERS | changed).joints, description=text)
    with pytest.raises(PegOnHoleError) as caught:
        UrdfKinematics(read_chain(joints), joints)
    assert str(caught.value) == (
        f"joints.urdf: Pinocchio finds no {told} in the robot's description: line breaks, tabs "
        "and letters of another encoding than UTF-8 are another name to it; give it a plain name"
    )


def test_of_many_bags_one_with_such_a_description_stands_in_no_other_ones_way(
    tmp_path, monkeypatch
):
    # In this process: starting one takes longer than the bags.
    monkeypatch.setattr(
        "peg_on_hole_ros.cli.many_bags.run.on_this_machine", lambda tasks, jobs: map(work, tasks)
    )
    bags = tmp_path / "bags"
    bags.mkdir()
    bag_with(bags / "bad.mcap", DEADLY["chain"][0])
    write(bags / "good.mcap", motion(50))
    out = tmp_path / "out"
    main(["replay", str(bags), "--jobs", "1", "--out", str(out)])
    with (out / "bags.csv").open(newline="", encoding="utf-8") as file:
        found = {row["bag"].rsplit("/")[-1]: row for row in csv.DictReader(file)}
    assert {name: row["exit_code"] for name, row in found.items()} == {
        "good.mcap": "0",
        "bad.mcap": "2",
    }
