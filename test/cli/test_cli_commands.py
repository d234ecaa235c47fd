"""`peg-on-hole` solve, inspect, simulate, compare."""

import json
import math

import pytest

from cli_helpers import config, fails
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.mechanics.reference import solve_contact
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.beside_estimates import JOINT_STATE, joint_state
from small_bags import JOINTS, MS, WRENCH, joints, wrench, write_bag


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


def test_simulate_refuses_what_it_cannot_do_before_the_work(tmp_path, capsys):
    out = tmp_path / "a.mcap"
    path = config(tmp_path, "scene: {friction: 0.2}")
    fails(
        capsys,
        2,
        f"{path} has no part 'simulation:' with 'ros__parameters:' below it, so there is no "
        "motion to simulate; config/working_cycle.yaml is an example",
        *("simulate", "--config", path, "--out", out),
    )
    fails(
        capsys,
        2,
        f"cannot write {path}: it is the file that is read",
        *("simulate", "--config", path, "--out", path),
    )
    nowhere = tmp_path / "none" / "a.mcap"
    fails(
        capsys,
        2,
        f"cannot write {nowhere}: there is no folder {nowhere.parent}",
        *("simulate", "--config", path, "--out", nowhere),
    )
    text = path.read_text().replace("0.2", "20")
    path.write_text(text + "simulation:\n  ros__parameters: {}\n")
    fails(
        capsys,
        2,
        f"{path}, line 3: scene.friction = 20 is an integer, not a double; write 20.0 (ROS 2 "
        f"does not "
        "take an integer for a double)",
        *("simulate", "--config", path, "--out", out),
    )
    assert not out.exists()


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
    # The first wrench comes before any joint state.
    assert result["replay"]["used"] == {"/joint_states": 200, "/wrench": 399}


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
        "/wrench: repeated_stamp": 1,
    }
    assert result["replay"]["used"] == {"/joint_states": 8, "/wrench": 6}
    assert main(["inspect", str(path)]) == 0
    text = capsys.readouterr().out
    assert (
        "trouble: 1 stamps go backwards: what is later than filter.late_window is dropped" in text
    )
    assert "dropped, /wrench: not_finite: 1" in text


def test_inspect_says_why_a_replay_is_not_possible(tmp_path, capsys):
    path = write_bag(tmp_path / "a.mcap", count=4, joint_topic="")
    assert main(["inspect", str(path)]) == 0
    text = capsys.readouterr().out
    assert f"a replay is not possible: {path} has no messages on /joint_states" in text


def write_rows(writer, prefix, i, shift=0.0):
    """Write an output's stamped topics at i ms; `shift` moves psi, reactions and friction."""
    angles, contacts = ["gamma", "psi", "phi"], ["K", "B1", "B2"]
    psi = math.remainder(3.1 + shift, math.tau)
    # The wider of two bounds must not hide a difference.
    wide = 7 if shift else 1
    t = i * MS
    rows = {
        "state": joint_state(t, angles, [0.3, psi, 0.0], [0.0] * 3),
        "state_stddev": joint_state(t, angles, [wide * 0.01] * 3, [1.0] * 3),
        "contacts": joint_state(t, contacts, [1] * 3, [0.1] * 3, [5 + i * shift, 5, 5]),
        "contacts_stddev": joint_state(t, contacts, (), [0.0] * 3, [wide * 0.5] * 3),
        "monitor": joint_state(t, ["friction"], [0.2 + shift]),
    }
    for topic, message in rows.items():
        writer.write(prefix + topic, JOINT_STATE, message, t)


def output(path, shifts, stamps):
    """Write a bag with outputs: prefix to shift."""
    with BagWriter(path) as writer:
        for i in stamps:
            for prefix, shift in shifts.items():
                write_rows(writer, prefix, i, shift)
    return path


def test_compare_gives_known_differences(tmp_path, capsys):
    # psi goes from 3.1 past pi: 0.2 rad apart, not 6.08.
    a = output(tmp_path / "a.mcap", {"/peg_on_hole/": 0.0}, range(1, 5))
    b = output(tmp_path / "b.mcap", {"/peg_on_hole/": 0.2}, range(2, 7))
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


def friction_difference(capsys, *arguments):
    assert main(["compare", *map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)["monitor"][0]["max"]


def test_compare_finds_outputs_under_any_name_and_lets_choose_among_several(tmp_path, capsys):
    stamps = range(1, 4)
    own = output(tmp_path / "own.mcap", {"/peg_on_hole/": 0.0}, stamps)
    cell = output(tmp_path / "cell.mcap", {"/cell/peg/": 0.2}, stamps)
    both = output(tmp_path / "both.mcap", {"/left/peg/": 0.1, "/right/peg/": 0.4}, stamps)
    assert friction_difference(capsys, own, cell) == pytest.approx(0.2)
    left, right = ("--prefix", "/left/peg"), ("--prefix", "right/peg/")
    assert friction_difference(capsys, both, both, *left, *right) == pytest.approx(0.3)
    assert friction_difference(capsys, both, both, *left) == 0.0
    named = ("--prefix", "/cell/peg", *right)
    assert friction_difference(capsys, cell, both, *named) == pytest.approx(0.2)

    several = "has outputs under /left/peg and /right/peg: choose one with --prefix"
    fails(capsys, 3, f"{both} {several}", "compare", own, both)
    only = "has outputs under /cell/peg, not under /left/peg"
    fails(capsys, 3, f"{cell} {only}", "compare", both, cell, *left)
    once = "--prefix is given 3 times: once for both, or for A and for B"
    fails(capsys, 2, once, "compare", both, both, *left, *right, *left)
    bag = "--prefix chooses among recorded outputs: with --bag there are none"
    fails(capsys, 2, bag, "compare", "a.yaml", "b.yaml", "--bag", own, *left)


def test_other_states_and_monitors_are_no_outputs(tmp_path, capsys):
    path, other = tmp_path / "a.mcap", "std_msgs/msg/String"
    with BagWriter(path) as writer:
        write_rows(writer, "/cell/peg/", 1)
        state = joint_state(MS, ["x"], [0.0])
        writer.write("/arm/state", JOINT_STATE, state, MS)
        writer.write("/gripper/state", JOINT_STATE, state, MS)
        writer.write("/gripper/monitor", other, {"data": "fine"}, MS)
    assert friction_difference(capsys, path, path) == 0.0


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
