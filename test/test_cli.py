"""The command line: what it prints, what it writes, its exit codes and errors."""

import base64
import json
import math
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

from json_schema import check
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.configuration import from_parameters
from peg_on_hole_ros.edges.bag_reader import Bag
from peg_on_hole_ros.edges.bag_writer import BagWriter
from peg_on_hole_ros.edges.config_file import write_parameters
from peg_on_hole_ros.edges.estimates import estimates
from peg_on_hole_ros.edges.messages import JOINT_STATE, STRING, joint_state
from peg_on_hole_ros.mechanics.reference import solve_contact
from peg_on_hole_ros.mechanics.scene import Scene
from small_bags import JOINTS, MS, WRENCH, joints, wrench, write_bag

ROOT = Path(__file__).parents[1]
SCHEMA = json.loads((ROOT / "docs" / "summary.schema.json").read_text(encoding="utf-8"))
COMMANDS = ["replay", "simulate", "solve", "inspect", "compare", "node"]


def command(*arguments, cwd=None):
    """Run the real command in a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-m", "peg_on_hole_ros.cli.main", *map(str, arguments)],
        capture_output=True,
        text=True,
        env=environment,
        cwd=cwd,
        timeout=120,
        check=False,
    )


def fails(capsys, code, message, *arguments):
    """Run in this process; the error is one line, exactly this one."""
    assert main([str(a) for a in arguments]) == code
    assert capsys.readouterr().err.splitlines()[-1] == f"peg-on-hole: error: {message}"


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return write_bag(tmp_path_factory.mktemp("bag") / "a.mcap", count=400)


@pytest.fixture(scope="module")
def replayed(bag):
    folder = bag.parent
    out, summary = folder / "out.mcap", folder / "summary.json"
    assert main(["replay", str(bag), "--out", str(out), "--summary", str(summary)]) == 0
    return out, json.loads(summary.read_text(encoding="utf-8"))


def config(tmp_path, text, name="c.yaml"):
    path = tmp_path / name
    path.write_text("peg_on_hole:\n  ros__parameters:\n    " + text + "\n", encoding="utf-8")
    return path


# --- the command itself


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
    assert all(f"    {name} " in done.stdout for name in COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help_with_an_example(name, capsys):
    with pytest.raises(SystemExit) as end:
        main([name, "--help"])
    assert end.value.code == 0
    text = capsys.readouterr().out
    assert f"example:\n  peg-on-hole {name}" in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "the following arguments are required: COMMAND"),
        (["replay"], "the following arguments are required: BAG"),
        (["solve"], "the following arguments are required: --state"),
        (["solve", "--state"], "argument --state: expected one argument"),
        (["dance"], "argument COMMAND: invalid choice: 'dance'"),
    ],
)
def test_wrong_arguments_are_exit_code_2(arguments, message, capsys):
    with pytest.raises(SystemExit) as end:
        main(arguments)
    assert end.value.code == 2
    assert f"error: {message}" in capsys.readouterr().err


def test_errors_are_one_line_and_never_a_traceback(tmp_path):
    done = command("replay", tmp_path / "none.mcap")
    assert done.returncode == 3
    assert done.stderr == f"peg-on-hole: error: there is no bag {tmp_path}/none.mcap\n"
    assert done.stdout == ""


def test_nothing_of_the_progress_is_piped(bag):
    done = command("inspect", bag)
    assert (done.returncode, done.stderr) == (0, "")
    assert "\r" not in done.stdout


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


# --- configuration


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "scene: {hole_diamter: 0.05}",
            "unknown parameter 'scene.hole_diamter'; the nearest are: scene.hole_diameter, "
            "scene.peg_diameter",
        ),
        (
            "scene: {peg_diameter: 0.051}",
            "peg_diameter = 0.051 m is not below hole_diameter = 0.05 m: a peg rests on three "
            "points of a rim only if it is thinner than the hole; check whether the two are "
            "exchanged",
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
    fails(capsys, 2, f"{path}: {message}", name, *subject, "--config", path)


def test_missing_configuration_is_exit_code_2(tmp_path):
    done = command("solve", "--config", tmp_path / "c.yaml", "--state", "0.2,0,0,0,0,1")
    assert done.returncode == 2
    assert done.stderr == f"peg-on-hole: error: there is no configuration file {tmp_path}/c.yaml\n"


# --- bags that cannot be used


@pytest.mark.parametrize("name", ["replay", "inspect"])
def test_files_that_are_no_bags_are_exit_code_3(tmp_path, capsys, name):
    path = tmp_path / "a.mcap"
    fails(capsys, 3, f"there is no bag {path}", name, path)
    path.write_bytes(b"")
    fails(capsys, 3, f"{path} is empty (0 bytes)", name, path)
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
        "name the topics in the configuration (topics.wrench, topics.joint_states)",
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
        "1)",
        "replay",
        path,
    )


def test_bag_of_which_nothing_can_be_used_is_exit_code_3(tmp_path, capsys):
    path = tmp_path / "a.mcap"
    with BagWriter(path) as writer:
        writer.write("/wrench", WRENCH, wrench(MS, (float("nan"), 0.0, 0.0)), MS)
        writer.write("/wrench", WRENCH, wrench(2 * MS), 2 * MS)
        writer.write("/joint_states", JOINTS, joints(3 * MS), 3 * MS)
    fails(
        capsys,
        3,
        f"{path}: no wrench of 2 could be used: wrench_dropped_before_joints 1, "
        "wrench_dropped_malformed_not_finite 1",
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
    damage = f"{path} is cut off at byte {len(whole) // 2}"
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


# --- replay


def test_replay_writes_the_topics_of_the_node_with_stamps_as_log_times(replayed):
    out, summary = replayed
    bag = Bag(out)
    names = {"state", "state_stddev", "contacts", "contacts_stddev", "monitor", "pose", "alarms"}
    names |= {"contact/k", "contact/b1", "contact/b2", "transition", "contact_mode", "markers"}
    assert set(bag.topics) == {f"/peg_on_hole/{name}" for name in names}
    assert bag.topics["/peg_on_hole/state"].count == summary["outputs"] == 399
    for _, log_ns, message in bag.messages(["/peg_on_hole/state"]):
        stamp = message.header.stamp
        assert log_ns == stamp.sec * 10**9 + stamp.nanosec
    stored = bag.metadata["peg_on_hole_configuration"]
    assert stored["scene.hole_diameter"] == "0.05"


def test_summary_fits_its_schema_and_counts_every_message(replayed):
    _, summary = replayed
    check(summary, SCHEMA)
    messages = summary["messages"]
    assert messages["read"] == 600
    assert messages["dropped"] == {"wrench_dropped_before_joints": 1}
    assert messages["used"] + sum(messages["dropped"].values()) == messages["read"]
    assert summary["duration"] == pytest.approx(0.398, abs=1e-9)
    # The first joint state lies behind the first wrench: that one has no estimate.
    assert summary["start_time"] == pytest.approx(1.001, abs=1e-9)


def test_joint_states_behind_the_last_wrench_are_counted(tmp_path):
    longer, summary = tmp_path / "a.mcap", tmp_path / "s.json"
    with BagWriter(longer) as writer:
        for i in range(20):
            t_ns = 10**9 + i * MS
            if i < 10:
                writer.write("/wrench", WRENCH, wrench(t_ns), t_ns)
            if i % 2 == 0:
                writer.write("/joint_states", JOINTS, joints(t_ns), t_ns)
    assert main(["replay", str(longer), "--summary", str(summary)]) == 0
    messages = json.loads(summary.read_text())["messages"]
    # Wrenches at 0 to 9 ms, the first without a joint state before it; joint states to 18 ms.
    assert messages["read"] == 20
    assert messages["dropped"] == {
        "joints_dropped_after_last_wrench": 5,
        "wrench_dropped_before_joints": 1,
    }
    assert messages["used"] == 14


def test_replay_is_the_same_twice(bag, replayed, tmp_path, capsys):
    out, _ = replayed
    again = tmp_path / "again.mcap"
    assert main(["replay", str(bag), "--out", str(again)]) == 0
    assert again.read_bytes() == out.read_bytes()
    capsys.readouterr()
    assert main(["compare", str(out), str(again), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["identical"] is True
    assert result["stamps"] == {"common": 399, "only_a": 0, "only_b": 0}


def test_places_that_cannot_be_written_are_refused_before_the_work(bag, tmp_path, capsys):
    out = tmp_path / "none" / "out.mcap"
    fails(
        capsys,
        2,
        f"cannot write {out}: there is no folder {out.parent}",
        *("replay", bag, "--out", out),
    )
    fails(capsys, 2, f"cannot write {tmp_path}: it is a folder", "replay", bag, "--out", tmp_path)
    fails(
        capsys, 2, f"cannot write {bag}: it is the bag that is read", "replay", bag, "--out", bag
    )
    fails(
        capsys,
        2,
        "--out, --report and --summary name one file twice",
        *("replay", bag, "--out", tmp_path / "x", "--summary", tmp_path / "x"),
    )


def test_configuration_in_the_bag_is_used_unless_one_is_given(tmp_path, capsys):
    path = tmp_path / "a.mcap"
    with BagWriter(path, from_parameters({"topics.wrench": "/ft"})) as writer:
        for i in range(4):
            t_ns = (i + 1) * MS
            writer.write("/joint_states", JOINTS, joints(t_ns), t_ns)
            writer.write("/ft", WRENCH, wrench(t_ns), t_ns)
    assert main(["replay", str(path)]) == 0
    assert capsys.readouterr().err == f"configuration: that in {path}\n"
    given = tmp_path / "c.yaml"
    given.write_text(write_parameters({}))
    assert main(["replay", str(path), "--config", str(given)]) == 3
    assert "has no messages on /wrench" in capsys.readouterr().err


# --- truth and report


@pytest.fixture(scope="module")
def with_truth(tmp_path_factory):
    """Write a bag whose truth is 1 mrad and 0.5 N off a constant, so that errors are known."""
    path = tmp_path_factory.mktemp("truth") / "a.mcap"
    angles, contacts = ["gamma", "psi", "phi"], ["K", "B1", "B2"]
    with BagWriter(path) as writer:
        writer.write("/truth/contact_mode", STRING, {"data": "three_point"}, 10**9)
        for i in range(300):
            t = 10**9 + i * MS
            writer.write("/joint_states", JOINTS, joints(t), t)
            writer.write("/wrench", WRENCH, wrench(t), t)
            state = joint_state(t, angles, [0.301, 0.0, 0.0], [0.0] * 3)
            writer.write("/truth/state", JOINTS, state, t)
            forces = joint_state(t, contacts, [1.0] * 3, [0.0] * 3, [1.0, 2.0, 3.0])
            writer.write("/truth/contacts", JOINTS, forces, t)
    return path


def test_errors_and_coverage_are_those_between_output_and_truth(with_truth, tmp_path, capsys):
    out, summary = tmp_path / "out.mcap", tmp_path / "s.json"
    arguments = ["replay", str(with_truth), "--out", str(out), "--summary", str(summary)]
    assert main(arguments) == 0
    content = json.loads(summary.read_text())
    check(content, SCHEMA)
    rows = list(estimates(Bag(out)))
    errors = {name: [] for name in ("gamma", "psi", "phi", "K", "B1", "B2")}
    for row in rows:
        three = row.mode == "three_point"
        for i, (name, true) in enumerate(zip(errors, [0.301, 0.0, 0.0, 1.0, 2.0, 3.0])):
            column = i if i < 3 else i + 3
            if i < 3 or three:
                error = row.values[column] - true
                errors[name].append((error, abs(error) <= 1.959964 * row.stddev[column]))
    assert len(errors["gamma"]) == 300 and 100 < len(errors["K"]) <= 300
    for name, pairs in errors.items():
        rmse = math.sqrt(sum(e * e for e, _ in pairs) / len(pairs))
        # Summed in another order than there: rounding only.
        assert content["rmse"][name] == pytest.approx(rmse, rel=1e-9)
        coverage = sum(inside for _, inside in pairs) / len(pairs)
        assert content["coverage95"][name] == pytest.approx(coverage, abs=1e-12)
    assert "inside 95 % bounds" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (
            ["tilt", "psi", "phi"],
            "{path}: /truth/state has values for tilt, psi, phi, and truth needs gamma, psi, phi",
        ),
        (
            ["gamma", "psi", "phi"],
            "{path} has no messages on /truth/contacts (sensor_msgs/msg/JointState)",
        ),
    ],
)
def test_truth_that_cannot_be_used_is_said_and_the_replay_goes_on(
    tmp_path, capsys, names, message
):
    path, summary = tmp_path / "a.mcap", tmp_path / "s.json"
    with BagWriter(path) as writer:
        for i in range(20):
            t = 10**9 + i * MS
            writer.write("/joint_states", JOINTS, joints(t), t)
            writer.write("/wrench", WRENCH, wrench(t), t)
            writer.write("/truth/state", JOINTS, joint_state(t, names, [0.3, 0.0, 0.0]), t)
            if names[0] == "tilt":
                writer.write("/truth/contacts", JOINTS, joint_state(t, []), t)
                writer.write("/truth/contact_mode", STRING, {"data": "three_point"}, t)
    assert main(["replay", str(path), "--summary", str(summary)]) == 0
    error = capsys.readouterr().err
    assert error.startswith(
        "no comparison with the truth: " + message.replace("{path}", str(path))
    )
    assert "rmse" not in json.loads(summary.read_text())


def test_report_stands_alone_and_holds_the_figures(with_truth, tmp_path):
    pytest.importorskip("matplotlib")
    path = tmp_path / "r.html"
    assert main(["replay", str(with_truth), "--report", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    assert "<h2>Against the truth</h2>" in text
    assert '<td>scene.hole_diameter</td><td class="number">0.05</td><td>m</td>' in text
    (png,) = re.findall(r'src="data:image/png;base64,([^"]+)"', text)
    assert base64.b64decode(png).startswith(b"\x89PNG\r\n")
    assert not re.search(r"""(src|href)=["'](?!data:)|@import|url\(""", text)
    parser = HTMLParser()
    parser.feed(text)
    parser.close()
    for tag in ("table", "tr", "td", "th", "h2", "p", "body", "html"):
        assert len(re.findall(f"<{tag}[ >]", text)) == text.count(f"</{tag}>"), tag


def test_report_of_a_damaged_bag_says_so(with_truth, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    data = with_truth.read_bytes()
    path, report = tmp_path / "<b>.mcap", tmp_path / "r.html"
    # The summary section alone is cut off: all messages are there, and still it is no whole bag.
    path.write_bytes(data[:-20])
    assert main(["replay", str(path), "--report", str(report)]) == 4
    text = report.read_text(encoding="utf-8")
    assert '<p class="damage">' in text and "cut off at byte" in text
    assert "&lt;b&gt;.mcap" in text and "<b>.mcap" not in text


# --- solve


def test_solve_gives_the_reference_model_as_json(capsys):
    arguments = ["solve", "--state", "0.2,0.1,-0.3,-0.16,0.5,2", "--json"]
    assert main([*arguments, "--wrench", "1,2,-10,0.01,0.3,-0.02"]) == 0
    result = json.loads(capsys.readouterr().out)
    expected = solve_contact(
        Scene(), [0.2, 0.1, -0.3], [-0.16, 0.5, 2.0], [1, 2, -10], [0.01, 0.3, -0.02]
    )
    # The same code with the same input: nothing but the text form lies between.
    assert list(result["acceleration"].values()) == expected.acceleration.tolist()
    assert list(result["normal"].values()) == expected.normal.tolist()
    assert list(result["slip_speed"].values()) == expected.slip_speed.tolist()
    assert result["critical_friction"] == expected.critical_friction
    assert result["outcome"] == expected.outcome.name.lower()
    assert list(result["acceleration"]) == ["gamma", "psi", "phi"]
    assert list(result["normal"]) == list(result["slip_speed"]) == ["K", "B1", "B2"]


def test_solve_takes_the_scene_of_the_configuration_and_negative_numbers(tmp_path, capsys):
    path = config(tmp_path, "scene: {friction: 0.0}")
    assert main(["solve", "--config", str(path), "--state", "0.2,0,0,-0.1,0,2", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["critical_friction"] is None
    assert main(["solve", "--state", "0.2,0,0,-0.1,0,2", "--wrench", "-1,0,0,0,0,0"]) == 0
    assert "acceleration [rad/s^2]" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        (
            "--state",
            "0.2,0,0",
            "--state = 0.2,0,0 is not six finite numbers (rad, rad, rad, rad/s, rad/s, rad/s)",
        ),
        (
            "--state",
            "-0.2,0,0,0,0,nan",
            "--state = -0.2,0,0,0,0,nan is not six finite numbers (rad, rad, rad, rad/s, rad/s, "
            "rad/s)",
        ),
        (
            "--wrench",
            "a,b",
            "--wrench = a,b is not six finite numbers (N, N, N, N m, N m, N m)",
        ),
    ],
)
def test_solve_refuses_what_is_not_six_numbers(option, value, message, capsys):
    state = [] if option == "--state" else ["--state", "0.2,0,0,0,0,1"]
    fails(capsys, 2, message, "solve", *state, option, value)


def test_solve_refuses_a_tilt_without_three_point_contact(capsys):
    assert main(["solve", "--state", "11.5,0,0,0,0,1"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("peg-on-hole: error: gamma = 11.5 rad has no three-point contact")


# --- inspect


def test_inspect_reports_rates_and_a_clock_in_order(bag, capsys):
    assert main(["inspect", str(bag), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    wrench_row = next(row for row in result["topics"] if row["name"] == "/wrench")
    assert wrench_row["rate"] == pytest.approx(1000.0, rel=1e-9)
    assert wrench_row["type"] == WRENCH and wrench_row["count"] == 400
    clock = result["clock"]["/wrench"]
    assert clock["median_period"] == pytest.approx(1e-3, rel=1e-9)
    assert (clock["backwards"], clock["repeated"], clock["trouble"]) == (0, 0, [])
    assert result["replay"]["possible"] is True
    assert result["replay"]["used"] == {"/joint_states": 200, "/wrench": 400}


def test_inspect_finds_gaps_and_clock_trouble(tmp_path, capsys):
    path = tmp_path / "a.mcap"
    stamps = [0, 1, 2, 2, 1, 3, 300, 301]
    with BagWriter(path) as writer:
        for i, stamp in enumerate(stamps):
            t_ns = 10**9 + i * MS
            message = wrench(10**9 + stamp * MS)
            if i == 7:
                message["wrench"]["force"]["x"] = float("inf")
            writer.write("/wrench", WRENCH, message, t_ns)
            writer.write("/joint_states", JOINTS, joints(t_ns + 5 * 10**9), t_ns)
        message = joints(10**9) | {"name": ["a", "b", "c"]}
        writer.write("/joint_states", JOINTS, message, 2 * 10**9)
    assert main(["inspect", str(path), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    clock = result["clock"]["/wrench"]
    assert (clock["backwards"], clock["repeated"]) == (1, 1)
    assert clock["gaps"]["count"] == 1
    assert clock["gaps"]["longest"] == pytest.approx(0.297, abs=1e-9)
    assert clock["gaps"]["limit"] == pytest.approx(0.1, abs=1e-9)
    assert [text.split(":")[0] for text in clock["trouble"]] == [
        "1 stamps go backwards",
        "1 stamps repeat the one before",
        "1 gaps over 0.1 s (filter.max_gap)",
    ]
    offsets = result["clock"]["/joint_states"]
    assert offsets["log_minus_stamp"]["mean"] == pytest.approx(-5.0, abs=1e-9)
    assert "the clocks of driver and recorder are not the same" in offsets["trouble"][-1]
    assert result["replay"]["dropped"] == {
        "/joint_states: missing_joint": 1,
        "/wrench: not_finite": 1,
    }
    assert main(["inspect", str(path)]) == 0
    text = capsys.readouterr().out
    assert "trouble: 1 stamps go backwards: late messages are dropped" in text
    assert "dropped, /wrench: not_finite: 1" in text


def test_inspect_says_why_a_replay_is_not_possible(tmp_path, capsys):
    path = write_bag(tmp_path / "a.mcap", count=4, joint_topic="")
    assert main(["inspect", str(path)]) == 0
    text = capsys.readouterr().out
    assert f"a replay is not possible: {path} has no messages on /joint_states" in text


# --- compare


def test_compare_gives_known_differences(tmp_path, capsys):
    def output(name, shift, stamps, prefix="/peg_on_hole/"):
        path = tmp_path / name
        angles, contacts = ["gamma", "psi", "phi"], ["K", "B1", "B2"]
        psi = math.remainder(3.1 + shift, math.tau)
        # The wider of two bounds must not hide a difference.
        wide = 7 if shift else 1
        with BagWriter(path) as writer:
            for i in stamps:
                t = i * MS
                rows = {
                    "state": joint_state(t, angles, [0.3, psi, 0.0], [0.0] * 3),
                    "state_stddev": joint_state(t, angles, [wide * 0.01] * 3, [1.0] * 3),
                    "contacts": joint_state(
                        t, contacts, [1] * 3, [0.1] * 3, [5 + i * shift, 5, 5]
                    ),
                    "contacts_stddev": joint_state(t, contacts, (), [0.0] * 3, [wide * 0.5] * 3),
                    "monitor": joint_state(t, ["friction"], [0.2 + shift]),
                }
                for topic, message in rows.items():
                    writer.write(prefix + topic, JOINT_STATE, message, t)
        return path

    # psi goes from 3.1 past pi: 0.2 rad apart, not 6.08.
    a, b = output("a.mcap", 0.0, range(1, 5)), output("b.mcap", 0.2, range(2, 7))
    content = Bag(b)
    assert content.count == 25
    assert main(["compare", str(a), str(b), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["stamps"] == {"common": 3, "only_a": 1, "only_b": 2}
    assert result["identical"] is False and result["configuration"] is None
    rows = {row["name"]: row for row in result["quantities"]}
    assert rows["gamma"]["max"] == rows["gamma"]["rms_in_stddev"] == 0.0
    assert rows["psi"]["max"] == pytest.approx(0.2, abs=1e-12)
    assert rows["psi"]["max_in_stddev"] == pytest.approx(20.0, abs=1e-9)
    # Over i = 2, 3, 4: 0.4, 0.6, 0.8 N; stddev 0.5 N.
    assert rows["N_K"]["max"] == pytest.approx(0.8, abs=1e-12)
    assert rows["N_K"]["rms"] == pytest.approx((1.16 / 3) ** 0.5, abs=1e-12)
    assert rows["N_K"]["max_in_stddev"] == pytest.approx(1.6, abs=1e-12)
    assert rows["slip_K"]["max_in_stddev"] is None
    assert result["monitor"] == [
        {"name": "friction", "stamps": 3, "max": pytest.approx(0.2), "rms": pytest.approx(0.2)}
    ]
    assert main(["compare", str(a), str(b)]) == 0
    assert "stamps in common: 3; only in A: 1; only in B: 2" in capsys.readouterr().out


def test_compare_one_bag_under_two_configurations(bag, tmp_path, capsys):
    a = config(tmp_path, "scene: {friction: 0.2}", "a.yaml")
    b = config(tmp_path, "scene: {friction: 0.25}", "b.yaml")
    assert main(["compare", str(a), str(b), "--bag", str(bag), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["configuration"] == {"scene.friction": [0.2, 0.25]}
    assert result["identical"] is False
    assert result["stamps"]["common"] == 399
    assert main(["compare", str(a), str(a), "--bag", str(bag), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["identical"] is True


def test_compare_refuses_bags_that_are_no_outputs(bag, replayed, tmp_path, capsys):
    out, _ = replayed
    assert main(["compare", str(out), str(bag)]) == 3
    error = capsys.readouterr().err
    assert error.startswith(f"peg-on-hole: error: no output of replay or node: {bag} has no")
    later = write_bag(tmp_path / "later.mcap", count=20, start=10**12)
    other = tmp_path / "other.mcap"
    assert main(["replay", str(later), "--out", str(other)]) == 0
    capsys.readouterr()
    fails(capsys, 3, f"{out} and {other} have no stamp in common", "compare", out, other)
