"""Layouts for RViz, Foxglove and PlotJuggler, and the launch file, name what the node has."""

import json
import re
import runpy
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace
from xml.etree import ElementTree

import pytest
import yaml

from inputs import closing
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.node_parts import NODE
from peg_on_hole_ros.config.options import Configuration, Topics
from peg_on_hole_ros.config.parameters_file import read_parameters
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

    def perform(self, context):
        """Return what a substitution stands for: of an argument, what it was given or ''."""
        return context.get(self.args[0], "")


def made(name):
    return type(name, (), {"__new__": lambda cls, *a, **k: Made(kind=name, args=a, **k)})


@pytest.fixture
def described(monkeypatch):
    """Reads a launch file. The wheels have no launch: its classes note how they are called."""
    for module, names in {
        "launch": ["LaunchDescription"],
        "launch.actions": [
            "DeclareLaunchArgument",
            "GroupAction",
            "IncludeLaunchDescription",
            "OpaqueFunction",
        ],
        "launch.launch_description_sources": ["PythonLaunchDescriptionSource"],
        "launch.substitutions": ["LaunchConfiguration", "PathJoinSubstitution"],
        "launch_ros.actions": ["LifecycleNode", "Node"],
        "launch_ros.substitutions": ["FindPackageShare"],
    }.items():
        holder = ModuleType(module)
        for name in names:
            setattr(holder, name, made(name))
        monkeypatch.setitem(sys.modules, module, holder)
    return lambda path: runpy.run_path(str(ROOT / path))["generate_launch_description"]().args[0]


LAUNCH = Path("launch", "peg_on_hole.launch.py")
SWITCHES = ("autostart", "use_sim_time")


def test_the_launch_file_hands_every_argument_to_the_node(described):
    *declared, then = described(LAUNCH)
    names = [argument.args[0] for argument in declared]
    assert names[:5] == ["params", "name", "namespace", *SWITCHES]
    assert all(argument.description for argument in declared)
    (node,) = then.function({})
    assert (node.name.args, node.namespace.args) == (("name",), ("namespace",))
    # What is not given is as the parameters file has it.
    (params,) = node.parameters
    assert params.args == ("params",)
    for given in ({"autostart": "false"}, {"use_sim_time": "true", "autostart": "true"}):
        (node,) = then.function(given)
        params, stated = node.parameters
        assert params.args == ("params",)
        assert {name: value.args for name, value in stated.items()} == {
            name: (name,) for name in given
        }
    remapped = {topic: found.args[0] for topic, found in node.remappings}
    # The names that the node reads unless told otherwise.
    assert set(remapped) == set(vars(Topics()).values())
    assert set(names[5:]) == set(remapped.values())
    assert {d.args[0]: d.default_value for d in declared[5:]} == {
        name: topic for topic, name in remapped.items()
    }
    assert (ROOT / "config" / declared[0].default_value.args[0][-1]).exists()
    assert [d.default_value for d in declared[3:5]] == ["", ""]


def included(action):
    """Return what an included launch file is given, which has to be this package's."""
    (source,) = action.args
    package, *path = source.args[0].args[0]
    assert (package.args, Path(*path)) == (("peg_on_hole_ros",), LAUNCH)
    return dict(action.launch_arguments)


def test_a_managed_node_waits_for_its_manager(described):
    include, manager = described("examples/managed.launch.py")
    assert included(include) == {"autostart": "false"}
    (parameters,) = manager.parameters
    assert (manager.package, manager.executable) == ("nav2_lifecycle_manager", "lifecycle_manager")
    assert parameters["node_names"] == [NODE] and parameters["autostart"] is True
    # Without a bond a manager that waits for one would take the node down.
    assert parameters["bond_timeout"] == 0.0


def test_two_holes_are_two_nodes_with_frames_of_their_own(described):
    groups = described("examples/two_holes.launch.py")
    given = [included(action) for group in groups for action in group.args[0]]
    cells = []
    for arguments in given:
        assert set(arguments) == {"namespace", "params"}
        name = f"/{arguments['namespace']}/{NODE}"
        cells.append(from_parameters(read_parameters(Path(arguments["params"]), name)))
    left, right = cells
    # They share all but where the hole is, and the names of its frames.
    joints = replace(left.joints, hole_xyz=right.joints.hole_xyz)
    assert left.joints.hole_xyz != right.joints.hole_xyz
    assert replace(left, frames=right.frames, joints=joints) == right
    names = [name for cell in cells for name in (cell.frames.hole, cell.frames.peg)]
    assert len(set(names)) == 4
