"""Parameters of the node: files and overrides as ROS 2 hands them over, and what is refused."""

import re

import pytest
import rclpy
from rclpy.node import Node

from dds_peer import PATIENCE, node_process
from peg_on_hole_ros.config.parameters_file import read_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.robot.frame_tree import frame_tree
from peg_on_hole_ros.ros import process
from peg_on_hole_ros.ros.node import PegOnHoleNode
from peg_on_hole_ros.ros.parameters import check_files
from simulated import ROOT
from tiers import at_push

pytestmark = pytest.mark.xdist_group("dds_starts")


def file(tmp_path, text):
    path = tmp_path / "parameters.yaml"
    path.write_text(text)
    return path


OWN = "peg_on_hole:\n  ros__parameters:\n    scene: {friction: 0.1}\n"


BAD = [
    (
        ["-p", "scene.peg_diameter:=49.9"],
        "",
        "peg-on-hole: error: scene.peg_diameter = 49.9 m is not within 0.0001 to 1 m; "
        "0.0499 m would be: the units look slipped by 1000",
    ),
    (
        ["-p", "scene.peg_diameter:=0.06"],
        "",
        "peg-on-hole: error: scene.peg_diameter = 0.06 m is not below scene.hole_diameter = "
        "0.05 m: a peg rests on three points of a rim only if it is thinner than the hole; "
        "check whether the two are exchanged",
    ),
    (
        ["-p", "scene.frictoin:=0.2"],
        "",
        "peg-on-hole: error: unknown parameter 'scene.frictoin'; the nearest are: "
        "scene.friction, scene.friction_stddev, scene.friction_k_stddev, filter.friction",
    ),
    (
        ["-p", "scene.friction:=1"],
        "",
        "peg-on-hole: error: scene.friction = 1 is an integer, not a double; write 1.0 "
        "(ROS 2 does not take an integer for a double)",
    ),
    (
        ["-p", "scene.gravity:=[0.0, 0, -9.8]"],
        "",
        "peg-on-hole: error: -p scene.gravity:=[0.0, 0, -9.8]: scene.gravity[1] = 0 is an "
        "integer, not a double; write 0.0 (ROS 2 does not take an integer for a double)",
    ),
    (
        ["-p", "joints.names:=[]"],
        "",
        "peg-on-hole: error: joints.names = [] is empty; it is a string[] such as "
        "['gamma', 'psi', 'phi']",
    ),
    (
        ["--params-file", "{file}", "-r", "__node:=left"],
        OWN,
        "peg-on-hole: error: {file} has parameters for /peg_on_hole, but this node is /left "
        "and would run with its defaults: write '/left:' or '/**:' in the file",
    ),
    (
        ["--params-file", "{file}", "-r", "__ns:=/cell"],
        OWN,
        "peg-on-hole: error: {file} has parameters for /peg_on_hole, but this node is "
        "/cell/peg_on_hole and would run with its defaults: write '/cell/peg_on_hole:' or "
        "'/**:' in the file",
    ),
]


@pytest.mark.parametrize(("arguments", "text", "message"), at_push(BAD[6:7], BAD))
def test_bad_parameters_end_with_one_line_and_code_2(arguments, text, message, tmp_path):
    path = file(tmp_path, text)
    arguments = [word.replace("{file}", str(path)) for word in arguments]
    with node_process(*arguments) as started:
        printed, _ = started.communicate(timeout=PATIENCE)
    assert printed.splitlines() == [message.replace("{file}", str(path))]
    assert started.returncode == 2


NAMES = "it is a string[] such as ['gamma', 'psi', 'phi']"
NAME = "it is a string such as 'gamma'"
INTEGER = "is an integer, not a double; write {}.0 (ROS 2 does not take an integer for a double)"
DEFAULT = "or take the line out for the default"
GROUP = "a group of parameters, not one of them; write it as in 'scene.hole_diameter'"


def said(*arguments):
    """Return what a node says of its arguments where it does not start."""
    try:
        process.init(["--ros-args", *arguments])
        PegOnHoleNode(["--ros-args", *arguments]).destroy_node()
    except PegOnHoleError as error:
        return str(error)
    finally:
        rclpy.try_shutdown()
    return None


@pytest.mark.parametrize(("arguments", "text", "message"), BAD)
def test_bad_parameters_are_told_in_one_line(arguments, text, message, tmp_path):
    """As by the process, in this one."""
    path = file(tmp_path, text)
    told = said(*(word.replace("{file}", str(path)) for word in arguments))
    assert f"peg-on-hole: error: {told}" == message.replace("{file}", str(path))


@pytest.mark.parametrize(
    ("text", "name", "message"),
    [
        # Empty lists are nothing to ROS 2.
        (
            "joints: {names: []}",
            "joints.names",
            f"{{file}}, line 3: joints.names = [] is empty; {NAMES}",
        ),
        (
            "scene: {friction: []}",
            "scene.friction",
            "{file}, line 3: scene.friction = [] is a list, not a double; it is a double ",
        ),
        (
            "scene: []",
            "scene",
            "{file}, line 3: scene = [] is a value, but it is a group of names",
        ),
        # Values that ROS 2 refuses in a file, with a line and no name.
        (
            "joints: {names: [1, 2.5]}",
            "joints.names[0]",
            "{file}, line 3: joints.names[0] = 1 is an integer, not a string;",
        ),
        (
            "joints: {names: [x, y, z]}",
            "joints.names[1]",
            "{file}, line 3: joints.names[1] = True is a bool, not a string; ",
        ),
        (
            "scene: {gravity: [0, 0.0, -9.8]}",
            "scene.gravity[0]",
            "{file}, line 3: scene.gravity[0] = 0 " + INTEGER.format(0),
        ),
        (
            "scene: {gravity: [0.0, 0.0, null]}",
            "scene.gravity[2]",
            "{file}, line 3: scene.gravity[2] = null is empty; it is ",
        ),
        (
            "scene: {friction: }",
            "scene.friction",
            "{file}, line 3: scene.friction has no value (null); it is a double ",
        ),
        (
            "scene: {friction: 0,2}",
            "scene.2",
            "{file}, line 3: unknown parameter 'scene.2'; a number has a point, ",
        ),
        (
            "scene: {friction:0.2}",
            "scene.friction:0.2",
            "{file}, line 3: unknown parameter 'scene.friction:0.2'; a colon needs a space "
            "behind it: "
            "'friction: 0.2'",
        ),
        (
            "scene: {peg_mass: 0.5, friction:0,2}",
            "scene.friction:0",
            "{file}, line 3: unknown parameter 'scene.friction:0'; a colon needs a space "
            "behind it: ",
        ),
        (
            "scene:",
            "scene",
            "{file}, line 3: nothing stands below scene, which ROS 2 does not read; take the line",
        ),
        (
            "scene: {}\n    autostart: true",
            "scene",
            "{file}, line 3: nothing stands below scene, which ROS 2 does not read; take the ",
        ),
        (
            "scene: {friction: &f 0.2, peg_mass: *f}",
            "*f",
            "{file} is not YAML at line 3: *f stands for",
        ),
        # What ROS 2 takes, for something else.
        (
            "record_arrivals: null",
            "record_arrivals",
            f"{{file}}, line 3: record_arrivals has no value (null); it is a string, {DEFAULT}",
        ),
        (
            "topics: {wrench: null}",
            "topics.wrench",
            "{file}, line 3: topics.wrench has no value (null); it is a string such as ",
        ),
        (
            "joints: {names: [~, a, b]}",
            "joints.names[0]",
            f"{{file}}, line 3: joints.names[0] = null is empty; {NAME}",
        ),
        (
            "joints: {names: [gamma, psi, '']}",
            "joints.names[2]",
            f"{{file}}, line 3: joints.names[2] = '' is empty; {NAME}",
        ),
        (
            "use_sim_time: 1",
            "use_sim_time",
            "{file}, line 3: use_sim_time = 1 is an integer, not a bool: true or false",
        ),
        (
            "use_sim_time: 'true'",
            "use_sim_time",
            "{file}, line 3: use_sim_time = 'true' is a string, not a bool: true or false",
        ),
        # The names of a group where a list belongs.
        (
            "joints: {names: {gamma: 1, psi: 2, phi: 3}}",
            "joints.names",
            "{file}, line 3: joints.names = {'gamma': 1, 'psi': 2, 'phi': 3} is not string[]; "
            "it is ",
        ),
    ],
)
def test_what_ros_cannot_read_or_misreads_is_told_in_the_words_of_a_command(
    text, name, message, tmp_path
):
    path = file(tmp_path, f"peg_on_hole:\n  ros__parameters:\n    {text}\n")
    with pytest.raises(PegOnHoleError) as caught:
        read_parameters(path)
    assert str(caught.value).startswith(message.replace("{file}", str(path)))
    assert re.search(f"[ ']{re.escape(name)}[ ',]", str(caught.value))
    assert said("--params-file", str(path)) == str(caught.value)


def test_a_merge_that_ros_takes_for_a_name_is_told_by_both(tmp_path):
    path = file(tmp_path, "peg_on_hole:\n  ros__parameters:\n    <<: {scene: {friction: 0.3}}\n")
    told = said("--params-file", str(path))
    assert told.startswith("unknown parameter '<<.scene.friction'; the nearest ")
    with pytest.raises(PegOnHoleError, match="at line 3: << puts the names of another group"):
        read_parameters(path)


@pytest.mark.parametrize("hole", ["left", "right"])
def test_two_nodes_have_a_part_each_of_one_file(hole):
    """What the launch file of two holes starts, read by ROS 2 itself."""
    pytest.importorskip("pinocchio")
    params = str(ROOT / "examples" / "two_holes.yaml")
    arguments = ["--ros-args", "-r", f"__ns:=/{hole}", "--params-file", params]
    process.init(arguments)
    try:
        node = PegOnHoleNode(arguments)
        cell = node.configuration
        # The description is found from the folder of the file.
        tree = frame_tree(cell)
        node.destroy_node()
    finally:
        rclpy.shutdown()
    assert tree[:3] == ("base_link", f"{hole}_hole", f"peg_at_{hole}_hole")
    assert cell.joints.hole_xyz[1] == {"left": 0.08, "right": -0.12}[hole]
    assert cell.wrench.gravity == "compensated" and not tree.hole_line + tree.peg_line


def test_an_empty_list_for_ros_itself_is_told_by_name(tmp_path):
    text = "peg_on_hole:\n  ros__parameters: {qos_overrides: {/wrench: {depth: []}}}\n"
    assert said("--params-file", str(file(tmp_path, text))) == (
        "qos_overrides./wrench.depth = [] is empty, which ROS 2 takes for no value; give it one, "
        "or take the line out"
    )


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        ("scene.friction:=", "-p scene.friction:=: scene.friction has no value (null); it is a "),
        (
            "/cell/a:scene.gravity:=[0.0, 0]",
            "-p /cell/a:scene.gravity:=[0.0, 0]: scene.gravity = ",
        ),
        (
            "scene.friction=0.2",
            "-p scene.friction=0.2 is no rule for a parameter; write -p NAME:=",
        ),
        ("scene:={friction: 0.3}", "-p scene:={friction: 0.3}: scene is " + GROUP),
    ],
)
def test_rules_that_ros_cannot_read_are_told_by_name(rule, message):
    assert said("-p", rule).startswith(message)


def test_what_ros_cannot_read_in_the_part_of_another_node_has_a_remedy(tmp_path):
    path = file(tmp_path, OWN + "camera:\n  ros__parameters: {size: [1, 2.5]}\n")
    assert said("--params-file", str(path)) == (
        f"Couldn't parse params file: '--params-file {path}'. Error: Sequence should be of same "
        "type. Value type 'double' do not belong at line_num 5; a list holds doubles or integers, "
        "not both: write 1.0 for 1; y, n, yes, no, on and off are bools, unless within quotes"
    )
    path = file(tmp_path, "camera:\n  ros__parameters: {size: }\n")
    assert said("--params-file", str(path)).endswith(
        "No value at line 2; a name has no value: give it one, or take the line out"
    )


@pytest.mark.parametrize("name", ["/**", "/*", "/cell/*", "cell/peg_on_hole", "/**/peg_on_hole"])
def test_parameters_file_may_use_wildcards(name, tmp_path):
    path = file(tmp_path, OWN.replace("peg_on_hole:", f"{name}:", 1))
    node = "/peg_on_hole" if name == "/*" else "/cell/peg_on_hole"
    check_files(node, ["--ros-args", "--params-file", str(path)])


CONTROLLER = """\
joint_trajectory_controller:
  ros__parameters:
    joints: [a, b]
    topics: [c]
    filter: {order: 2, method: butterworth, cutoff: 20.0}
"""
LEFT = OWN.replace("peg_on_hole", "/left/peg_on_hole")
CLOCK = "/**:\n  ros__parameters: {use_sim_time: true}\n"


def files(tmp_path, *texts):
    paths = [tmp_path / f"{number}.yaml" for number in range(len(texts))]
    for path, text in zip(paths, texts):
        path.write_text(text)
    return ["--ros-args", *(word for path in paths for word in ("--params-file", str(path)))]


@pytest.mark.parametrize(
    "texts",
    [
        ["camera:\n  ros__parameters:\n    exposure: 0.1\n"],
        [CONTROLLER],
        [CONTROLLER, OWN],
        [OWN, CONTROLLER],
        [OWN, LEFT],
        [LEFT + OWN],
        ["peg_on_hole:\n  ros__parameters: {markers_rate: 5.0}\n", LEFT],
    ],
)
def test_parameters_of_other_programs_are_no_matter(texts, tmp_path):
    check_files("/peg_on_hole", files(tmp_path, *texts))


# As launch_ros writes it for {"use_sim_time": ...} beside a parameters file.
CLOCK_BY_NAME = CLOCK.replace("/**", "/peg_on_hole")
BY_LAUNCH = CLOCK_BY_NAME.replace("true", "true, autostart: false")


@pytest.mark.parametrize("more", [[], [CONTROLLER], [CLOCK], [CLOCK_BY_NAME], [BY_LAUNCH]])
def test_ours_under_another_name_alone_is_refused_whatever_other_files_there_are(more, tmp_path):
    arguments = files(tmp_path, *more, LEFT)
    with pytest.raises(PegOnHoleError) as caught:
        check_files("/peg_on_hole", arguments)
    assert str(caught.value) == (
        f"{arguments[-1]} has parameters for /left/peg_on_hole, but this node is /peg_on_hole and "
        "would run with its defaults: write '/peg_on_hole:' or '/**:' in the file"
    )


def given_by_ros(path):
    """Return what ROS 2 itself makes of a parameters file for a node named peg_on_hole."""
    context = rclpy.Context()
    rclpy.init(args=["--ros-args", "--params-file", str(path)], context=context)
    node = Node(
        "peg_on_hole",
        context=context,
        start_parameter_services=False,
        enable_rosout=False,
        automatically_declare_parameters_from_overrides=True,
    )
    found = {name: node.get_parameter(name).value for name in node.list_parameters([], 0).names}
    node.destroy_node()
    rclpy.shutdown(context=context)
    found.pop("use_sim_time", None)
    found.pop("start_type_description_service", None)
    return found


ALL = OWN.replace("peg_on_hole", "/**").replace("0.1", "0.5")
MASS = "    scene.peg_mass: 0.6\n"


@pytest.mark.parametrize(
    "text",
    [
        OWN + ALL,
        ALL + OWN,
        ALL + OWN + MASS + ALL.replace("**", "*").replace("0.5", "0.7"),
        "camera:\n  ros__parameters: {scene: {friction: 0.8}}\n" + OWN + MASS,
        "/**/peg_on_hole:\n  ros__parameters: {scene: {friction: 0.8}}\n" + ALL,
    ],
)
def test_command_line_and_ros_make_the_same_of_a_file(text, tmp_path):
    path = file(tmp_path, text)
    found = given_by_ros(path)
    assert found and read_parameters(path) == found


def test_what_ros_would_merge_is_refused_by_the_command_line(tmp_path):
    path = file(tmp_path, OWN + "    joints: {delay: 0.01}\n    scene: {peg_mass: 0.6}\n")
    assert given_by_ros(path) == {
        "scene.friction": 0.1,
        "joints.delay": 0.01,
        "scene.peg_mass": 0.6,
    }
    with pytest.raises(PegOnHoleError, match="at line 5: 'scene' was there before .* line 3"):
        read_parameters(path)
