"""Layouts for RViz, Foxglove and PlotJuggler, and the launch file, name what the node has."""

import json
import re
import runpy
import sys
from types import ModuleType, SimpleNamespace
from xml.etree import ElementTree

import pytest
import yaml

from inputs import closing
from peg_on_hole_ros.config.options import Configuration, Topics
from peg_on_hole_ros.messages.beside_estimates import JOINT_STATE, TOPICS
from peg_on_hole_ros.messages.definitions import definition
from peg_on_hole_ros.messages.plain import HOLE_FRAME
from peg_on_hole_ros.messages.stream import message_stream
from simulated import ROOT

PREFIX = "/peg_on_hole/"
TYPES = {PREFIX + suffix: ros_type for suffix, ros_type in TOPICS.items()}
CONFIG = ROOT / "config"
# What a display of RViz takes.
DISPLAYS = {
    "MarkerArray": "visualization_msgs/msg/MarkerArray",
    "PoseWithCovariance": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "WrenchStamped": "geometry_msgs/msg/WrenchStamped",
}


@pytest.fixture(scope="module")
def told():
    """Fields of the first message of each topic."""
    stream, found = message_stream(Configuration()), {}
    for source, message in closing(60):
        if source == "joints":
            stream.on_joints(message)
            continue
        for suffix, _, fields in stream.on_wrench(message):
            found.setdefault(PREFIX + suffix, fields)
    return found


def test_rviz_shows_topics_of_their_types_in_the_frame_of_the_hole():
    content = yaml.safe_load((CONFIG / "peg_on_hole.rviz").read_text(encoding="utf-8"))
    manager = content["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == HOLE_FRAME
    shown = {}
    for display in manager["Displays"]:
        kind = display["Class"].removeprefix("rviz_default_plugins/")
        if "Topic" in display:
            assert TYPES[display["Topic"]["Value"]] == DISPLAYS[kind]
            shown[display["Topic"]["Value"]] = kind
        else:
            assert kind in ("Grid", "TF")
    assert {PREFIX + f"contact/{name}" for name in ("k", "b1", "b2")} < set(shown)


def leaves(node):
    return [node] if isinstance(node, str) else leaves(node["first"]) + leaves(node["second"])


def test_foxglove_has_a_place_for_each_panel_and_each_path_leads_to_a_field(told):
    content = json.loads((CONFIG / "foxglove_layout.json").read_text(encoding="utf-8"))
    panels = content["configById"]
    assert sorted(leaves(content["layout"])) == sorted(panels)
    paths = [path["value"] for panel in panels.values() for path in panel.get("paths", [])]
    assert len(paths) >= 6
    for path in paths:
        topic, field, index = re.fullmatch(r"([\w/]+)\.(\w+)(?:\[(\d)\])?", path).groups()
        value = told[topic][field]
        assert index is None or 0 <= int(index) < len(value), path
    whole = [panel.get("topicPath") or panel.get("topicToRender") for panel in panels.values()]
    drawn = [topic for panel in panels.values() for topic in panel.get("topics", {})]
    for topic in [*filter(None, whole), *drawn]:
        assert topic in TYPES, topic
        assert definition(TYPES[topic])


def test_plotjuggler_plots_series_that_come(told):
    root = ElementTree.parse(CONFIG / "plotjuggler.xml").getroot()
    areas = root.findall(".//DockArea")
    (splitter,) = root.findall(".//DockSplitter")
    assert int(splitter.get("count")) == len(areas) == len(splitter.get("sizes").split(";"))
    names = [curve.get("name") for curve in root.findall(".//curve")]
    assert len(names) >= 6
    for name in names:
        topic = max((t for t in TYPES if name.startswith(t + "/")), key=len)
        rest = name.removeprefix(topic + "/")
        if TYPES[topic] == JOINT_STATE:
            joint, part = rest.split("/")
            assert joint in told[topic]["name"] and len(told[topic][part]), name
        else:
            assert rest in told[topic], name


class Made(SimpleNamespace):
    """What a class of launch was called with."""


def made(name):
    return type(name, (), {"__new__": lambda cls, *a, **k: Made(kind=name, args=a, **k)})


def test_the_launch_file_hands_every_argument_to_the_node(monkeypatch):
    """The wheels have no launch; its classes here note with what they are called."""
    for module, names in {
        "launch": ["LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument"],
        "launch.substitutions": ["LaunchConfiguration", "PathJoinSubstitution"],
        "launch_ros.actions": ["LifecycleNode"],
        "launch_ros.substitutions": ["FindPackageShare"],
    }.items():
        holder = ModuleType(module)
        for name in names:
            setattr(holder, name, made(name))
        monkeypatch.setitem(sys.modules, module, holder)
    file = runpy.run_path(str(ROOT / "launch" / "peg_on_hole.launch.py"))
    *declared, node = file["generate_launch_description"]().args[0]
    names = [argument.args[0] for argument in declared]
    assert names[:4] == ["params", "name", "namespace", "use_sim_time"]
    assert all(argument.description for argument in declared)
    assert (node.name.args, node.namespace.args) == (("name",), ("namespace",))
    params, clock = node.parameters
    assert params.args == ("params",) and clock["use_sim_time"].args == ("use_sim_time",)
    remapped = {topic: found.args[0] for topic, found in node.remappings}
    # The names that the node reads unless told otherwise.
    assert set(remapped) == set(vars(Topics()).values())
    assert set(names[4:]) == set(remapped.values())
    assert {d.args[0]: d.default_value for d in declared[4:]} == {
        name: topic for topic, name in remapped.items()
    }
    assert (ROOT / "config" / declared[0].default_value.args[0][-1]).exists()
