"""ROS 2 parameters files: what is read, what is refused, what is written."""

import pytest
import yaml

from peg_on_hole_ros.config.configuration import PARAMETERS, from_parameters, node_options
from peg_on_hole_ros.config.options import Configuration, NodeOptions
from peg_on_hole_ros.config.parameters_file import (
    DEFAULT_HEADING,
    read_parameters,
    write_parameters,
)
from peg_on_hole_ros.errors import PegOnHoleError
from simulated import ROOT

COMMITTED = ROOT / "config" / "peg_on_hole.yaml"


def written(tmp_path, text):
    path = tmp_path / "c.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def body(*lines):
    return "peg_on_hole:\n  ros__parameters:\n" + "".join(f"    {line}\n" for line in lines)


def test_committed_file_is_what_the_table_gives():
    expected = write_parameters({}, DEFAULT_HEADING)
    assert COMMITTED.read_text(encoding="utf-8") == expected, (
        "run: python3 -m peg_on_hole_ros.config.parameters_file > config/peg_on_hole.yaml"
    )


def test_committed_file_gives_the_defaults_and_names_every_parameter():
    parameters = read_parameters(COMMITTED)
    assert set(parameters) == {row.name for row in PARAMETERS}
    assert from_parameters(parameters) == Configuration()
    assert node_options(parameters) == NodeOptions()


OTHER = "other_node:\n  ros__parameters: {rate: 3}\n"
OWN = "peg_on_hole:\n  ros__parameters:\n    scene.friction: 0.3\n    scene: {peg_mass: 2.5}\n"
EVERY = "/**:\n  ros__parameters:\n    use_sim_time: true\n    scene: {friction: 0.9}\n"


@pytest.mark.parametrize(
    ("text", "friction"),
    [
        (OTHER + EVERY + OWN, 0.3),
        (OWN + EVERY + OTHER, 0.9),
        (OWN + EVERY.replace("**", "*"), 0.9),
    ],
)
def test_own_part_and_that_for_all_count_in_the_order_of_the_file(tmp_path, text, friction):
    # test_node_parameters.py holds this to what ROS 2 itself makes of such files.
    assert read_parameters(written(tmp_path, text)) == {
        "use_sim_time": True,
        "scene.friction": friction,
        "scene.peg_mass": 2.5,
    }


@pytest.mark.parametrize(
    "text",
    [
        "/peg_on_hole:\n  ros__parameters: {scene: {friction: 0.3}}\n",
        "/cell/peg_on_hole:\n  ros__parameters: {scene: {friction: 0.3}}\n",
        "cell:\n  peg_on_hole:\n    ros__parameters: {scene: {friction: 0.3}}\n"
        "  driver:\n    ros__parameters: {rate: 3}\n",
        "/**:\n  ros__parameters: {scene: {friction: 0.3}}\n",
        "/*:\n  ros__parameters: {scene: {friction: 0.3}}\n",
    ],
)
def test_namespaces_and_wildcards_are_found(tmp_path, text):
    assert read_parameters(written(tmp_path, text)) == {"scene.friction": 0.3}


SCENE = "{}:\n  ros__parameters: {{scene: {{{}}}}}\n"


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        # The node's own name says in which namespace it is; the rest is as ROS 2 matches it.
        (["/cell/peg_on_hole", "/cell/*", "/**/peg_on_hole"], [0, 1, 2]),
        (["/cell/peg_on_hole", "/left/*", "/*", "/*/peg_on_hole"], [0, 3]),
        (["/peg_on_hole", "/cell/**", "/*"], [0, 2]),
        # Else that of a part with wildcards, in which all others fit.
        (["/**/peg_on_hole", "/cell/*"], [0, 1]),
        (["/cell/*", "/**"], [0, 1]),
        (["/cell/**"], [0]),
    ],
)
def test_parts_for_all_nodes_of_a_namespace_count_as_for_ros(tmp_path, parts, expected):
    rows = ["friction: 0.3", "peg_mass: 2.5", "peg_height: 0.08", "clearance_stddev: 1.0e-6"]
    text = "".join(SCENE.format(name, row) for name, row in zip(parts, rows))
    names = {f"scene.{rows[i].split(':')[0]}" for i in expected}
    assert set(read_parameters(written(tmp_path, text))) == names


def test_nodes_of_other_namespaces_have_their_own_parameters(tmp_path):
    other = "/arm/*:\n  ros__parameters: {update_rate: 100}\n"
    text = other + SCENE.format("/**", "friction: 0.3")
    assert read_parameters(written(tmp_path, text)) == {"scene.friction": 0.3}
    path = written(
        tmp_path, SCENE.format("/a/*", "friction: 0.3") + SCENE.format("/b/*", "friction: 0.2")
    )
    with pytest.raises(PegOnHoleError, match=r"for /a/\*, /b/\*: keep those of one node"):
        read_parameters(path)


def test_two_nodes_of_this_kind_in_one_file_are_not_mixed(tmp_path):
    text = "/a/peg_on_hole:\n  ros__parameters: {}\nb:\n  peg_on_hole: {ros__parameters: {}}\n"
    path = written(tmp_path, text)
    with pytest.raises(PegOnHoleError) as caught:
        read_parameters(path)
    assert str(caught.value) == (
        f"{path} has parameters for /a/peg_on_hole, b/peg_on_hole: keep those of one node"
    )


@pytest.mark.parametrize("text", ["1e-4", "1.0e-4", "1E-4", "+.0001", "0.0001"])
def test_numbers_are_read_as_ros_reads_them(tmp_path, text):
    path = written(tmp_path, body(f"joints: {{position_stddev: {text}}}"))
    assert read_parameters(path) == {"joints.position_stddev": 1e-4}


def test_write_and_read_give_the_same_values_back(tmp_path):
    given = {
        "scene.friction": 1e-05,
        "joints.names": ("a b", 'q"\\', "on", "12"),
        "joints.urdf": "/tmp/x y.urdf",
        "autostart": False,
    }
    given["joints.source"] = "robot"
    given["joints.tip_frame"] = "y"
    path = written(tmp_path, write_parameters(given, "what\nwhy"))
    assert path.read_text().startswith("# what\n# why\npeg_on_hole:\n  ros__parameters:\n")
    assert from_parameters(read_parameters(path)) == from_parameters(given)
    # Any YAML 1.1 reader gives the same types.
    plain = yaml.safe_load(path.read_text())["peg_on_hole"]["ros__parameters"]
    assert plain["scene"]["friction"] == 1e-05
    assert plain["joints"]["names"] == ["a b", 'q"\\', "on", "12"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "",
            "{path} holds no parameters; a ROS 2 parameters file begins with 'peg_on_hole:' and "
            "below it 'ros__parameters:'",
        ),
        (
            "robot:\n  ros__parameters: {a: 1}\ncamera: {}\n",
            "{path} has parameters for robot, camera, none for peg_on_hole; a ROS 2 parameters "
            "file begins with 'peg_on_hole:' and below it 'ros__parameters:'",
        ),
        (
            "peg_on_hole:\n  ros_parameters: {a: 1}\n",
            "{path}, line 1: below peg_on_hole there is ros_parameters, not ros__parameters (two "
            "underscores); a ROS 2 parameters file begins with 'peg_on_hole:' and below it "
            "'ros__parameters:'",
        ),
        (
            body("scene: {frction: 0.1}"),
            "{path}, line 3: unknown parameter 'scene.frction'; the nearest are: scene.friction, "
            "scene.friction_stddev, scene.friction_k_stddev, filter.friction",
        ),
        (
            body("scene: {peg_mass: 0.5, friction:0.2}"),
            "{path}, line 3: unknown parameter 'scene.friction:0.2'; a colon needs a space "
            "behind it: "
            "'friction: 0.2'",
        ),
        (
            body("scene: {friction: 0,2}"),
            "{path}, line 3: unknown parameter 'scene.2'; a number has a point, not a comma: 0.2",
        ),
        (
            body("scene:", "  friction:0.2"),
            "{path}, line 3: scene = 'friction:0.2' is a value, but it is a group of names; a "
            "colon needs "
            "a space behind it: 'friction: 0.2'",
        ),
        (body("scene: 5"), "{path}, line 3: scene = 5 is a value, but it is a group of names"),
        (
            body("scene: {friction: 1}"),
            "{path}, line 3: scene.friction = 1 is an integer, not a double; write 1.0 (ROS 2 "
            "does not "
            "take an integer for a double)",
        ),
        (
            body("scene: {friction: low}"),
            "{path}, line 3: scene.friction = 'low' is a string, not a double; it is a double "
            "such as 0.2",
        ),
        (
            body("scene: {friction: {a: 1}}"),
            "{path}, line 3: scene.friction = {'a': 1} is a group of names, not a double; it is a "
            "double such as 0.2",
        ),
        (
            body("scene: {friction: 0.9}", "joints: {delay: 0.01}", "scene: {peg_mass: 0.6}"),
            "{path} is not YAML at line 5: 'scene' was there before in the same group, at line 3; "
            "write it once, with all that belongs to it",
        ),
        (
            body("scene:", "  friction: 0.9", "  friction: 0.6"),
            "{path} is not YAML at line 5: 'friction' was there before in the same group, at line "
            "4; write it once, with all that belongs to it",
        ),
        (
            body("scene: {friction: 0.9}") + body("scene: {peg_mass: 0.6}"),
            "{path} is not YAML at line 4: 'peg_on_hole' was there before in the same group, at "
            "line 1; write it once, with all that belongs to it",
        ),
        (
            body("scene.friction: 0.4", "joints: {delay: 0.01}", "scene: {friction: 0.3}"),
            "{path}, line 5: scene.friction was there before, at line 3; write it once",
        ),
        (
            body("scene: {peg_mass: 0.4, friction: 0.3}", "scene.friction: 0.3"),
            "{path}, line 4: scene.friction was there before, at line 3; write it once",
        ),
        ("a: [1\n", "{path} is not YAML at line 2: expected ',' or ']', but got '<stream end>'"),
        (
            "peg_on_hole:\n  ros__parameters: {joints: {names: {gamma: 1, psi: 2, phi: 3}}}",
            "{path}, line 2: joints.names = {'gamma': 1, 'psi': 2, 'phi': 3} is not string[]; "
            "it is a "
            "string[] such as ['gamma', 'psi', 'phi']",
        ),
        (
            "peg_on_hole:\n  ros__parameters:\n    <<: {scene: {friction: 0.3}}",
            "{path} is not YAML at line 3: << puts the names of another group here for YAML, and "
            "is a name to ROS 2; write them out",
        ),
    ],
)
def test_unusable_files_say_what_is_wrong(tmp_path, text, message):
    path = written(tmp_path, text)
    with pytest.raises(PegOnHoleError) as caught:
        read_parameters(path)
    assert str(caught.value) == message.replace("{path}", str(path))
    assert caught.value.exit_code == 2


def test_missing_and_unreadable_files(tmp_path):
    with pytest.raises(PegOnHoleError, match="there is no configuration file .*none.yaml"):
        read_parameters(tmp_path / "none.yaml")
    with pytest.raises(
        PegOnHoleError, match="cannot read the configuration [^:]*: Is a directory"
    ):
        read_parameters(tmp_path)
    bag = tmp_path / "a.mcap"
    bag.write_bytes(b"\x89MCAP0\r\n")
    with pytest.raises(PegOnHoleError) as caught:
        read_parameters(bag)
    assert str(caught.value) == (
        f"cannot read the configuration {bag}: it is no text in UTF-8 at byte 0, a bag perhaps; a "
        "configuration is a ROS 2 parameters file (YAML)"
    )
