"""The command line refuses what it cannot use: exact messages, exit codes, no traceback."""

import json
import os
import re
import subprocess
import sys

import pytest

from cli_helpers import COMMANDS, ROOT, SCHEMA, command, config, fails
from json_schema import check
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from small_bags import JOINTS, MS, WRENCH, joints, wrench, write_bag


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return write_bag(tmp_path_factory.mktemp("bag") / "a.mcap", count=400)


def test_help_imports_nothing_heavy():
    code = (
        "import sys\nfrom peg_on_hole_ros.cli.main import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit as end:\n    assert end.code == 0\n"
        "heavy = {'numpy', 'numba', 'scipy', 'rclpy', 'mcap', 'mcap_ros2', 'yaml', 'matplotlib'}\n"
        "print('loaded:', sorted(heavy & set(sys.modules)))\n"
    )
    done = subprocess.run(
        # -S would drop the environment's packages; -I the path to this checkout.
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
    )
    assert done.stdout.splitlines()[-1] == "loaded: []"
    assert all(re.search(rf"^    {name}\s", done.stdout, re.M) for name in COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help_with_an_example(name, capsys):
    with pytest.raises(SystemExit) as end:
        main([name, "--help"])
    assert end.value.code == 0
    text = capsys.readouterr().out
    assert f"example:\n  peg-on-hole {name}" in text


@pytest.mark.parametrize(
    ("arguments", "usage", "message"),
    [
        ([], "", "the following arguments are required: COMMAND"),
        (["replay"], "replay ", "the following arguments are required: BAG"),
        (["solve"], "solve ", "the following arguments are required: --state"),
        (["solve", "--state"], "solve ", "argument --state: expected one argument"),
        (["dance"], "", "argument COMMAND: invalid choice: 'dance' (choose from"),
        # Of a subcommand: its usage, not that of the whole.
        (["replay", "a.mcap", "--frob"], "replay ", "unrecognized arguments: --frob"),
        (["inspect", "a.mcap", "b\nc"], "inspect ", r"unrecognized arguments: b\x0ac"),
    ],
)
def test_wrong_arguments_are_one_line_with_the_usage_of_the_command(
    arguments, usage, message, capsys
):
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"peg-on-hole: error: {message}")
    assert f"; usage: peg-on-hole {usage}[-h]" in line


def test_the_help_says_whose_configuration_holds(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    told = " ".join(capsys.readouterr().out.split())
    assert (
        "Without one, replay, inspect and calibrate use the configuration in the bag. If the bag "
        "has none, and in all other commands, the defaults of config/peg_on_hole.yaml are used."
    ) in told


def test_errors_are_one_line_and_never_a_traceback(tmp_path):
    done = command("replay", tmp_path / "none.mcap")
    assert done.returncode == 3
    assert done.stderr == f"peg-on-hole: error: there is no bag {tmp_path}/none.mcap\n"
    assert done.stdout == ""


def test_nothing_of_the_progress_is_piped(bag):
    done = command("inspect", bag)
    assert (done.returncode, done.stderr) == (0, "")
    assert "\r" not in done.stdout


@pytest.mark.nightly
def test_reader_that_goes_away_is_no_error(bag):
    done = subprocess.run(
        f"{sys.executable} -m peg_on_hole_ros.cli.main inspect {bag} | true; "
        'echo "${PIPESTATUS[0]}"',
        shell=True,
        executable="/bin/bash",
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
    )
    assert (done.stdout, done.stderr) == ("0\n", "")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "scene: {hole_diamter: 0.05}",
            "unknown parameter 'scene.hole_diamter'; the nearest are: scene.hole_diameter, "
            "scene.peg_diameter, scene.hole_chamfer",
        ),
        (
            "scene: {peg_diameter: 0.051}",
            "scene.peg_diameter = 0.051 m is not below scene.hole_diameter = 0.05 m: a peg rests "
            "on three points of a rim only if it is thinner than the hole; check whether the two "
            "are exchanged",
        ),
        (
            "scene: {hole_diameter: 50.0, peg_diameter: 49.9, peg_height: 70.0}",
            "scene.hole_diameter = 50 m is not within 0.0001 to 1 m; 0.05 m would be: the units "
            "look slipped by 1000",
        ),
        (
            "wrench: {sensor_xyz: [0.0, 0.0, 70.0]}",
            "wrench.sensor_xyz[2] = 70 m is not within -10 to 10 m; 0.07 m would be: the units "
            "look slipped by 1000",
        ),
        (
            "scene: {friction: high}",
            "scene.friction = 'high' is a string, not a double; it is a double such as 0.2",
        ),
    ],
)
@pytest.mark.parametrize("name", ["replay", "inspect", "solve"])
def test_wrong_configurations_are_exit_code_2(tmp_path, bag, capsys, name, text, message):
    path = config(tmp_path, text)
    subject = ["--state", "0.2,0,0,0,0,1"] if name == "solve" else [bag]
    # One parameter stands in a line; values that do not fit together stand in several.
    line = "" if " is not below " in message else ", line 3"
    fails(capsys, 2, f"{path}{line}: {message}", name, *subject, "--config", path)


def test_missing_configuration_is_exit_code_2(tmp_path):
    done = command("solve", "--config", tmp_path / "c.yaml", "--state", "0.2,0,0,0,0,1")
    assert done.returncode == 2
    assert done.stderr == f"peg-on-hole: error: there is no configuration file {tmp_path}/c.yaml\n"


@pytest.mark.parametrize("name", ["replay", "inspect"])
def test_files_that_are_no_bags_are_exit_code_3(tmp_path, capsys, name):
    path = tmp_path / "a.mcap"
    fails(capsys, 3, f"there is no bag {path}", name, path)
    path.write_bytes(b"")
    nothing = (
        "its recorder was stopped before it wrote, or its copy ended: copy it again, or name "
        "another bag"
    )
    fails(capsys, 3, f"{path} is empty (0 bytes); {nothing}", name, path)
    sqlite = tmp_path / "a.db3"
    sqlite.touch()
    message = f"{sqlite} is no bag in SQLite: it is empty (0 bytes); {nothing}"
    fails(capsys, 3, message, name, sqlite)
    sqlite.unlink()
    path.write_bytes(b"time,fx,fy\n0,1,2\n")
    fails(capsys, 3, f"{path} is not an MCAP file: it begins with b'time,fx,'", name, path)
    fails(
        capsys,
        3,
        f"{tmp_path} is a folder without metadata.yaml and without .mcap files: no bag"
        if not path.unlink()
        else "",
        name,
        tmp_path,
    )


def test_bag_without_messages_is_exit_code_3(tmp_path, capsys):
    path = tmp_path / "a.mcap"
    with BagWriter(path):
        pass
    fails(capsys, 3, f"{path} holds no messages", "replay", path)


def test_bag_without_the_topics_is_exit_code_3_and_says_which_it_has(tmp_path, capsys):
    path = write_bag(tmp_path / "a.mcap", count=4, wrench_topic="/ft")
    fails(
        capsys,
        3,
        f"{path} has no messages on /wrench (geometry_msgs/msg/WrenchStamped); it has: /ft "
        "(geometry_msgs/msg/WrenchStamped, 4), /joint_states (sensor_msgs/msg/JointState, 2); "
        "name the topics by --wrench-topic and --joints-topic, or in the configuration "
        "(topics.wrench, topics.joint_states)",
        "replay",
        path,
    )


def test_topic_of_another_type_is_exit_code_3(tmp_path, capsys):
    path = tmp_path / "a.mcap"
    with BagWriter(path) as writer:
        writer.write("/wrench", JOINTS, joints(MS), MS)
        writer.write("/joint_states", JOINTS, joints(MS), MS)
    fails(
        capsys,
        3,
        f"{path}: /wrench is sensor_msgs/msg/JointState, not geometry_msgs/msg/WrenchStamped; it "
        "has: /joint_states (sensor_msgs/msg/JointState, 1), /wrench (sensor_msgs/msg/JointState, "
        "1); name the topics by --wrench-topic and --joints-topic, or in the configuration "
        "(topics.wrench, topics.joint_states)",
        "replay",
        path,
    )


def test_bag_of_which_nothing_can_be_used_is_exit_code_3(tmp_path, capsys):
    path = tmp_path / "a.mcap"
    with BagWriter(path) as writer:
        writer.write("/wrench", WRENCH, wrench(MS, (float("nan"), 0.0, 0.0)), MS)
        writer.write("/wrench", WRENCH, wrench(2 * MS), 2 * MS)
        # Of the last wrench's time, and later in the bag.
        writer.write("/joint_states", JOINTS, joints(2 * MS), 3 * MS)
    fails(
        capsys,
        3,
        f"{path}: no wrench of 2 could be used: wrench_dropped_before_joints 1, "
        "wrench_dropped_malformed_not_finite 1; the driver sends NaN or infinity",
        "replay",
        path,
        "--out",
        tmp_path / "out.mcap",
    )
    assert [p.name for p in tmp_path.iterdir()] == ["a.mcap"], "no half-written output is left"


def test_cut_off_bag_is_exit_code_4_with_what_was_read_kept(tmp_path, capsys):
    whole = write_bag(tmp_path / "whole.mcap", count=1000, chunk_bytes=20_000).read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[: len(whole) // 2])
    out, summary = tmp_path / "out.mcap", tmp_path / "s.json"
    damage = Bag(path).damage
    assert damage.startswith(f"{path} is cut off at byte {len(whole) // 2}: its recorder was ")
    fails(
        capsys,
        4,
        f"{damage}; what lies before has been used",
        *("replay", path, "--out", out, "--summary", summary),
    )
    content = json.loads(summary.read_text())
    check(content, SCHEMA)
    assert content["damage"] == damage
    assert 200 < content["outputs"] < 800
    assert Bag(out).topics["/peg_on_hole/state"].count == content["outputs"]
    fails(capsys, 4, f"{damage}; what lies before has been used", "inspect", path)


def test_an_empty_last_part_is_exit_code_4_with_what_was_read_kept(tmp_path, capsys):
    folder, summary = tmp_path / "rec", tmp_path / "s.json"
    folder.mkdir()
    write_bag(folder / "rec_0.mcap", count=200)
    (folder / "rec_1.mcap").touch()
    damage = f"{folder}/rec_1.mcap is empty (0 bytes)"
    arguments = "replay", folder, "--summary", summary
    fails(capsys, 4, f"{damage}; what lies before has been used", *arguments)
    content = json.loads(summary.read_text())
    assert (content["outputs"], content["damage"]) == (199, damage)


def test_a_bag_without_sliding_cannot_be_calibrated(bag, tmp_path, capsys):
    out = tmp_path / "c.yaml"
    assert main(["calibrate", str(bag), "--out", str(out)]) == 3
    error = capsys.readouterr().err.splitlines()[-1]
    assert error.startswith("peg-on-hole: error: only 0 joint states while all three contacts")
    assert not out.exists()


def test_a_calibration_does_not_overwrite_what_it_reads(bag, tmp_path, capsys):
    start = config(tmp_path, "scene: {friction: 0.3}")
    message = f"cannot write {start}: it is the file that is read"
    fails(capsys, 2, message, "calibrate", bag, "--out", start, "--config", start)


@pytest.mark.parametrize("host", ["no such host", "192.0.2.1", "."])
@pytest.mark.parametrize("more", [[], ["--foxglove"]])
def test_a_host_that_is_none_of_this_machine_is_not_blamed_on_the_port(capsys, host, more):
    assert main(["watch", "--host", host, *more]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"peg-on-hole: error: --host '{host}' is no address of this machine: ")
    assert "--port" not in error and error.count("\n") == 1


@pytest.mark.parametrize(
    "arguments", [["--" + "x" * 10_000], ["--max-chunk", "x" * 10_000], ["\x1b[31m" * 1000] * 2]
)
def test_of_a_long_argument_the_begin_is_printed_with_the_usage(capsys, arguments):
    assert main(["inspect", "a.mcap", *arguments]) == 2
    error = capsys.readouterr().err
    assert "...; usage: peg-on-hole inspect" in error and len(error) < 1000
    assert "\x1b" not in error
