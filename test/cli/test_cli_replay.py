"""`peg-on-hole replay`: outputs, summary, comparison with truth, report."""

import json
import math

import pytest
from rosbags.rosbag2 import Reader as Rosbag2Reader

from cli_helpers import ROOT, SCHEMA, fails
from json_schema import check
from peg_on_hole_ros.bags.estimates import estimates
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.parameters_file import write_parameters
from peg_on_hole_ros.messages.beside_estimates import STRING, joint_state
from small_bags import JOINTS, MS, WRENCH, joints, wrench
from tiers import nightly


def test_replay_writes_the_topics_of_the_node_with_stamps_as_log_times(replayed):
    out, summary = replayed
    bag = Bag(out)
    names = {"state", "state_stddev", "contacts", "contacts_stddev", "monitor", "pose", "alarms"}
    names |= {"contact/k", "contact/b1", "contact/b2", "transition", "contact_mode", "markers"}
    # The bag ends in contact, so that there is a record of a try.
    names |= {"alarm_level", "cycle"}
    assert set(bag.topics) == {f"/peg_on_hole/{name}" for name in names}
    assert bag.topics["/peg_on_hole/state"].count == summary["outputs"] == 399
    for _, log_ns, message in bag.messages(["/peg_on_hole/state"]):
        stamp = message.header.stamp
        assert log_ns == stamp.sec * 10**9 + stamp.nanosec
    stored = bag.metadata["peg_on_hole_configuration"]
    assert stored["scene.hole_diameter"] == "0.05"


def test_smoothed_state_is_added_and_changes_nothing_else(bag, replayed, tmp_path, capsys):
    out, summary = tmp_path / "out.mcap", tmp_path / "s.json"
    arguments = ["replay", str(bag), "--smooth", "--summary", str(summary)]
    assert main([*arguments, "--out", str(out)]) == 0
    plain, smooth = Bag(replayed[0]), Bag(out)
    added = {f"/peg_on_hole/smoothed_state{end}" for end in ("", "_stddev")}
    assert set(smooth.topics) - set(plain.topics) == added
    states = [list(b.messages(["/peg_on_hole/state"])) for b in (plain, smooth)]
    assert [m.message.position for m in states[0]] == [m.message.position for m in states[1]]
    stamps = [m.log_ns for m in states[1]]
    for topic in added:
        found = list(smooth.messages([topic]))
        assert [m.log_ns for m in found] == stamps
        assert found[0].message.name == ["gamma", "psi", "phi"]
        assert all(
            math.isfinite(x) for x in (*found[9].message.position, *found[9].message.velocity)
        )
    assert json.loads(summary.read_text())["outputs"] == replayed[1]["outputs"]
    capsys.readouterr()
    message = "--smooth adds topics to an output: name one with --out OUT.mcap"
    fails(capsys, 2, message, *arguments)


def test_a_name_without_suffix_is_a_rosbag2_folder(bag, replayed, tmp_path, capsys):
    out = tmp_path / "estimate"
    assert main(["replay", str(bag), "--out", str(out)]) == 0
    file = Bag(replayed[0])
    with Rosbag2Reader(out) as folder:
        counts = {each.topic: each.msgcount for each in folder.connections}
        latched = {each.topic for each in folder.connections if each.ext.offered_qos_profiles}
        span = folder.start_time, folder.end_time - 1
        payloads = [bytes(payload) for each, _, payload in folder.messages()]
    assert counts == {name: info.count for name, info in file.topics.items()}
    assert span == (
        min(info.first_ns for info in file.topics.values()),
        max(info.last_ns for info in file.topics.values()),
    )
    assert latched == {f"/peg_on_hole/{n}" for n in ("transition", "contact_mode", "alarm_level")}
    assert payloads == [payload for _, payload in file.with_payloads(file.topics)]
    capsys.readouterr()
    full = f"cannot write {out}: the folder has something in it; name another"
    fails(capsys, 2, full, "replay", bag, "--out", f"{out}/")
    # Of what cannot be replayed nothing is left.
    other = tmp_path / "other"
    fails(capsys, 3, "there is no bag gone.mcap", "replay", "gone.mcap", "--out", other)
    assert not other.exists()


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


def test_reactions_that_were_determined_nowhere_have_no_largest(bag, tmp_path, capsys):
    """A peg that rests: friction may point anywhere within its cones."""
    report, summary = tmp_path / "r.html", tmp_path / "s.json"
    arguments = ["replay", str(bag), "--report", str(report), "--summary", str(summary)]
    assert main(arguments) == 0
    told = capsys.readouterr().out.splitlines()
    assert (
        "largest reaction: none, because no sample determines them (reactions_determined)" in told
    )
    row = next(line.split() for line in told if "unfinished" in line)
    assert row[4] == "-"
    content = json.loads(summary.read_text())
    check(content, SCHEMA)
    assert content["max_normal"] == dict.fromkeys(("K", "B1", "B2"))
    assert "Reactions are not determined anywhere." in report.read_text(encoding="utf-8")


def test_a_clock_that_goes_back_leaves_a_summary_that_fits(tmp_path, capsys):
    path, summary = tmp_path / "a.mcap", tmp_path / "s.json"
    stamps = [start + i * MS for start in (10 * 10**9, 0) for i in range(200)]
    with BagWriter(path) as writer:
        for i, t_ns in enumerate(stamps):
            writer.write("/joint_states", JOINTS, joints(t_ns), i * MS)
            writer.write("/wrench", WRENCH, wrench(t_ns), i * MS)
    arguments = ["replay", str(path), "--summary", str(summary)]
    assert main([*arguments, "--report", str(tmp_path / "r.html")]) == 0
    content = json.loads(summary.read_text())
    check(content, SCHEMA)
    assert content["messages"]["events"]["clock_jumped_back"] == 1
    assert content["duration"] == pytest.approx(0.398, abs=2e-3)
    starts = [cycle["start_time"] for cycle in content["cycles"]]
    assert starts == pytest.approx([10.0, 0.0], abs=0.05)
    for cycle in content["cycles"]:
        assert 0.1 < cycle["duration"] < 0.2
    assert "try from stamp [s]" in capsys.readouterr().out


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


def test_late_wrenches_behind_the_last_one_are_counted(tmp_path):
    late, summary = tmp_path / "a.mcap", tmp_path / "s.json"
    with BagWriter(late) as writer:
        # In the order of arrival; the stamps that are missing at first come late.
        for log_ms, i in enumerate((0, 1, 2, 4, 3, 5, 9, 8, 7)):
            t_ns, log_ns = 10**9 + i * MS, 10**9 + log_ms * MS
            if i < 8:
                writer.write("/joint_states", JOINTS, joints(t_ns), log_ns)
            writer.write("/wrench", WRENCH, wrench(t_ns), log_ns)
    assert main(["replay", str(late), "--summary", str(summary)]) == 0
    messages = json.loads(summary.read_text())["messages"]
    # 3 ms was used when 5 ms came; 8 and 7 ms, and the orientation of 7 ms, were not.
    assert messages["dropped"] == {
        "joints_dropped_after_last_wrench": 1,
        "wrench_dropped_after_last_wrench": 2,
    }
    assert messages["events"]["wrench_late"] == 1
    assert (messages["read"], messages["used"]) == (16, 13)


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
        capsys, 2, f"cannot write {bag}: it is the file that is read", "replay", bag, "--out", bag
    )
    fails(
        capsys,
        2,
        f"cannot write {tmp_path / 'x.mcap'}: two outputs have this place",
        *("replay", bag, "--out", tmp_path / "x.mcap", "--summary", tmp_path / "x.mcap"),
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


@pytest.mark.parametrize(
    ("name", "told", "determined", "undetermined"),
    [("closing_without_slip", 690, 400, 10), *nightly(("working_cycle", 11000, 6000, 500))],
)
def test_errors_and_coverage_are_those_between_output_and_truth(
    tmp_path, capsys, name, told, determined, undetermined
):
    """Reactions that are not determined are counted apart: it wedges, or rests for a while."""
    bag = Bag(ROOT / "bags" / f"{name}.mcap")
    true = {}
    for topic, field in (("/truth/state", "position"), ("/truth/contacts", "effort")):
        for _, log_ns, message in bag.messages([topic]):
            true.setdefault(log_ns, []).extend(getattr(message, field))
    modes = [(t, message.data) for _, t, message in bag.messages(["/truth/contact_mode"])]
    out, summary = tmp_path / "out.mcap", tmp_path / "s.json"
    arguments = ["replay", str(bag.path), "--out", str(out), "--summary", str(summary)]
    assert main(arguments) == 0
    content = json.loads(summary.read_text())
    check(content, SCHEMA)
    errors = {}
    for row in estimates(Bag(out)):
        true_mode = [mode for t, mode in modes if t <= row.t_ns][-1]
        three = row.mode == true_mode == "three_point"
        apart = "" if row.monitor["reactions_determined"] == 1.0 else "undetermined"
        for i, name in enumerate(("gamma", "psi", "phi", "K", "B1", "B2")):
            if i >= 3 and not three:
                continue
            column = i if i < 3 else i + 3
            error = row.values[column] - true[row.t_ns][i]
            if i < 3:
                error = math.remainder(error, 2 * math.pi)
            inside = abs(error) <= 1.959964 * row.stddev[column]
            errors.setdefault((name, apart if i >= 3 else ""), []).append((error, inside))
    assert len(errors["gamma", ""]) > told and len(errors["K", ""]) > determined
    assert len(errors["K", "undetermined"]) > undetermined
    for (name, apart), pairs in errors.items():
        if apart:
            # No number is stated where none is determined: samples are all there is to tell.
            assert content[apart]["samples"] == len(pairs)
            assert content[apart]["rmse"][name] is content[apart]["coverage95"][name] is None
            continue
        figures = content
        rmse = math.sqrt(sum(e * e for e, _ in pairs) / len(pairs))
        # Summed in another order than there: rounding only.
        assert figures["rmse"][name] == pytest.approx(rmse, rel=1e-9)
        coverage = sum(inside for _, inside in pairs) / len(pairs)
        assert figures["coverage95"][name] == pytest.approx(coverage, abs=1e-12)
    said = capsys.readouterr().out
    assert "inside 95 % bounds: share of the samples" in said
    assert "N_K, not determined" in said


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


def test_report_of_a_damaged_bag_says_so(with_truth, tmp_path, capsys):
    data = with_truth.read_bytes()
    path, report = tmp_path / "<b>.mcap", tmp_path / "r.html"
    # The summary section alone is cut off: all messages are there, and still it is no whole bag.
    path.write_bytes(data[:-20])
    assert main(["replay", str(path), "--report", str(report)]) == 4
    text = report.read_text(encoding="utf-8")
    assert '<p class="damage">' in text and "cut off at byte" in text
    assert "&lt;b&gt;.mcap" in text and "<b>.mcap" not in text
