"""What recorders get wrong, as `inspect` and `replay` tell it: both the same."""

import json
import os

import numpy as np
import pytest
from mcap.opcode import Opcode

from cli_helpers import ROOT, config, fails
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import (
    CONFIGURATION_METADATA,
    BagWriter,
    configuration_metadata,
)
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.configuration import from_parameters
from recorded import (
    INPUTS,
    PACK,
    STORE,
    UNPACKED,
    Row,
    definition,
    described,
    joints,
    motion,
    records,
    wrench,
    write,
    writer,
)
from small_bags import MS
from small_bags import write_bag as write_small
from tiers import nightly

SAMPLE = ROOT / "bags" / "closing_with_slip.mcap"


def sample():
    """Return what a shipped bag has of wrench and joint states."""
    rows = Bag(SAMPLE).with_payloads(INPUTS)
    return [Row(message.topic, message.log_ns, payload) for message, payload in rows]


def both(capsys, tmp_path, path, *options, code=0):
    """Return what inspect and replay say of a bag, as JSON and as text, and the summary."""
    options = [str(path), *map(str, options)]
    assert main(["inspect", *options, "--json"]) == code
    inspected = json.loads(capsys.readouterr().out)
    assert main(["inspect", *options]) == code
    text = capsys.readouterr().out
    summary = tmp_path / "summary.json"
    assert main(["replay", *options, "--summary", str(summary)]) == code
    return inspected, text, capsys.readouterr().out, json.loads(summary.read_text())


def agree(inspected, summary):
    """Return messages used; what inspect promises is what the replay has used, by topic."""
    dropped = summary["messages"]["dropped"]
    promised = inspected["replay"]
    assert promised["possible"]
    assert sum(promised["used"].values()) == summary["messages"]["used"]
    found = {}
    for name, count in dropped.items():
        source, _, reason = name.partition("_dropped_")
        topic = {"wrench": "/wrench", "joints": "/joint_states"}[source]
        found[f"{topic}: {reason.removeprefix('malformed_')}"] = count
    assert promised["dropped"] == found
    return summary["messages"]["used"]


@pytest.mark.parametrize(
    "wrong, absurd",
    [
        *nightly((slice(300, 303), 0), (slice(300, 303), 2**63)),
        (slice(300, 303), 2**64 - 5000),
        (slice(0, None, 3), 0),
    ],
)
def test_wrong_log_times_cost_nothing(tmp_path, capsys, wrong, absurd):
    rows = sample()
    rows[wrong] = [row._replace(log_ns=absurd + i) for i, row in enumerate(rows[wrong])]
    count = len(rows[wrong])
    path = write(tmp_path / "a.mcap", rows, chunk_size=20_000)
    inspected, text, told, summary = both(capsys, tmp_path, path)
    assert agree(inspected, summary) == len(rows) == 1001
    for said in (text, told):
        assert (
            sum(line.startswith(f"log time: {count} messages (") for line in said.splitlines())
            == 1
        )
        assert "synchronise" not in said and "joints.delay" not in said
    rates = {topic["name"]: topic["rate"] for topic in inspected["topics"]}
    assert rates == pytest.approx({"/wrench": 1000.0, "/joint_states": 500.0}, rel=1e-6)
    assert [t["duration"] for t in inspected["topics"]] == pytest.approx([0.666, 0.666], abs=1e-9)


@pytest.mark.parametrize(("rounds", "mixed"), [(4, 6), *nightly((2, 0), (2, 6), (4, 0))])
def test_short_loops_are_named(tmp_path, capsys, mixed, rounds):
    rows = sample()
    order, n = rows * rounds, len(rows)
    if mixed:
        seam = order[n - mixed : n + mixed]
        order[n - mixed : n + mixed] = [
            row for pair in zip(seam[mixed:], seam[:mixed]) for row in pair
        ]
    order = [row._replace(log_ns=rows[0].log_ns + i * 666_000) for i, row in enumerate(order)]
    path = write(tmp_path / "a.mcap", order)
    inspected, text, told, summary = both(capsys, tmp_path, path)
    assert agree(inspected, summary) == 1001
    for said in (text, told):
        assert sum(line.startswith("loop: the stamps of wrench") for line in said.split("\n")) == 1
        assert "synchronise" not in said and "joints.delay" not in said


def test_long_loops_are_a_recording_for_each_round(tmp_path, capsys):
    rows = motion(1500)
    later = [row._replace(log_ns=row.log_ns + 2 * 10**9) for row in rows]
    path = write(tmp_path / "a.mcap", rows + later)
    inspected, text, told, summary = both(capsys, tmp_path, path)
    assert agree(inspected, summary) > 1.98 * len(rows)
    assert summary["messages"]["events"]["clock_jumped_back"] == 1
    assert "each round is a recording of its own, with clock_jumped_back" in text
    assert "each round is a recording of its own, with clock_jumped_back" in told


def test_two_publishers_with_clocks_apart_are_no_loop(tmp_path, capsys):
    rows = motion(600)
    other = motion(600, start=10**9 - 300 * MS + 1)
    other = [row._replace(log_ns=row.log_ns + 300 * MS) for row in other]
    path = write(tmp_path / "a.mcap", sorted(rows + other, key=lambda row: row.log_ns))
    assert main(["inspect", str(path)]) == 0
    assert "loop" not in capsys.readouterr().out


def test_what_arrives_late_or_twice_is_promised_as_it_is_used(tmp_path, capsys):
    rows = motion(800)
    # Late beyond and within filter.late_window, twice, wrenches in front, joint states behind.
    rows.insert(600, rows.pop(300)._replace(log_ns=rows[599].log_ns))
    rows.insert(820, rows.pop(800)._replace(log_ns=rows[819].log_ns))
    rows.insert(400, rows[399])
    rows = rows[1:-1] + [row for row in rows[-40:] if row.topic == "/joint_states"][-1:]
    inspected, _, _, summary = both(capsys, tmp_path, write(tmp_path / "a.mcap", rows))
    assert agree(inspected, summary) < len(rows)
    assert len(summary["messages"]["dropped"]) >= 3


def test_packed_and_unpacked_folders_are_used_whole(tmp_path, capsys):
    rows, folder = sample(), tmp_path / "rec"
    folder.mkdir()
    file = write(folder / "rec_0.mcap", rows, compression=UNPACKED)
    packed = folder / "rec_0.mcap.zstd"
    packed.write_bytes(PACK(file.read_bytes()))
    (folder / "metadata.yaml").write_text(described("rec_0.mcap.zstd"))
    inspected, _, _, summary = both(capsys, tmp_path, folder)
    assert agree(inspected, summary) == 1001 and not inspected["remarks"]
    packed.unlink()
    inspected, text, told, summary = both(capsys, tmp_path, folder)
    assert agree(inspected, summary) == 1001
    line = "files: rec_0.mcap is read for the rec_0.mcap.zstd of metadata.yaml"
    assert line in text.splitlines() and line in told.splitlines()
    (folder / "metadata.yaml").unlink()
    file.unlink()
    message = f"cannot write {packed}: it is the file that is read"
    packed.write_bytes(PACK(write(tmp_path / "b.mcap", rows).read_bytes()))
    fails(capsys, 2, message, "replay", packed, "--out", packed)


@pytest.mark.parametrize(
    "text", [lambda kind: kind, lambda kind: definition(kind).split("===")[0]]
)
def test_incomplete_definitions_are_told(tmp_path, capsys, text):
    path = write(tmp_path / "a.mcap", sample(), text=text)
    inspected, said, told, summary = both(capsys, tmp_path, path)
    assert agree(inspected, summary) == 1001
    for kind in INPUTS.values():
        assert f"definition: that of {kind} on" in said and f"definition: that of {kind}" in told
    assert [topic["count"] for topic in inspected["topics"]] == [334, 667]


def test_a_chunk_that_was_cut_out_is_exit_code_4(tmp_path, capsys):
    data = write(tmp_path / "a.mcap", sample(), chunk_size=9000).read_bytes()
    chunks = [(at, end) for at, kind, end in records(data) if kind == Opcode.CHUNK]
    first, end = chunks[2]
    path = tmp_path / "b.mcap"
    path.write_bytes(data[:first] + data[end:])
    damage = Bag(path).damage
    assert "of 1001 messages that its index counts are not in it" in damage
    for command in ("inspect", "replay"):
        fails(capsys, 4, f"{damage}; what lies before has been used", command, path)


def test_a_chunk_above_the_bound_is_told_with_the_option_that_moves_it(tmp_path, capsys):
    path = write(tmp_path / "a.mcap", sample())
    assert main(["inspect", str(path), "--max-chunk", "0.01"]) == 0
    assert "MiB that --max-chunk allows, with the messages in it (" in capsys.readouterr().out
    assert main(["inspect", str(path), "--max-chunk", "0.3"]) == 0
    for given in ("0", "nan", "1e9"):
        message = f"--max-chunk = {float(given):g} MiB is not within 0.001 to 4096 MiB"
        fails(capsys, 2, message, "replay", path, "--max-chunk", given)


def test_topics_by_option_come_before_any_configuration(tmp_path, capsys):
    path = tmp_path / "a.mcap"
    write_small(path, wrench_topic="/cell/ft", joint_topic="/cell/joints")
    given = config(tmp_path, "topics: {wrench: /elsewhere}")
    options = ("--wrench-topic", "/cell/ft", "--joints-topic", "cell/joints")
    for more in ((), ("--config", given)):
        inspected, _, _, summary = both(capsys, tmp_path, path, *options, *more)
        assert inspected["replay"]["used"] == {"/cell/ft": 199, "/cell/joints": 100}
        assert summary["messages"]["used"] == 299
    out = tmp_path / "out.mcap"
    assert main(["replay", str(path), *options, "--out", str(out)]) == 0
    stored = Bag(out).metadata[CONFIGURATION_METADATA]
    assert json.loads(stored["topics.wrench"]) == "/cell/ft"
    assert main(["calibrate", str(path), *options, "--out", str(tmp_path / "c.yaml")]) == 3
    assert "only 0 joint states" in capsys.readouterr().err
    assert main(["inspect", str(path), "--wrench-topic", "/a b"]) == 2
    one = ("--wrench-topic", "/cell/ft", "--joints-topic", "cell/ft")
    written = ("--out", str(tmp_path / "d.yaml"))
    for command, more in (("inspect", ()), ("replay", ()), ("calibrate", written)):
        assert main([command, str(path), *one, *more]) == 2
        assert "they have to be two" in capsys.readouterr().err


@pytest.fixture
def robot(tmp_path):
    """Return a function that writes a bag whose configuration names a file as URDF."""

    def make(urdf, name="a.mcap"):
        parameters = {
            "joints.source": "robot",
            "joints.urdf": str(urdf),
            "joints.tip_frame": "t",
            "joints.names": ["a"],
        }
        metadata = {CONFIGURATION_METADATA: configuration_metadata(from_parameters(parameters))}
        return write(tmp_path / name, motion(40), metadata=metadata)

    return make


@pytest.mark.parametrize("options", [("--bag-urdf",), pytest.param((), marks=pytest.mark.nightly)])
def test_a_bag_opens_no_device(tmp_path, capsys, robot, options):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for urdf in ("/dev/zero", pipe, tmp_path):
        path = robot(urdf)
        for command in ("inspect", "replay"):
            message = (
                f"the configuration in {path}: joints.urdf: {urdf} is no regular file, so it is "
                "not opened"
            )
            fails(capsys, 2, message, command, path, *options)


def test_a_bag_chooses_no_file(tmp_path, capsys, robot):
    urdf = tmp_path / "secret"
    urdf.write_text("<secret/>")
    path = robot(urdf)
    refused = (
        f"the configuration in {path} names a file as URDF, {urdf}, and a bag does not choose "
        "which files are read: confirm it with --bag-urdf, or give a configuration with --config"
    )
    out = tmp_path / "c.yaml"
    for command, *more in (("replay",), ("calibrate", "--out", out)):
        fails(capsys, 2, refused, command, path, *more)
    assert main(["inspect", str(path)]) == 0
    assert f"a replay is not possible: {refused}" in capsys.readouterr().out
    message = f"joints.urdf: {urdf} is not a URDF: it begins with <secret>, not <robot>"
    fails(capsys, 2, message, "replay", path, "--bag-urdf")
    with urdf.open("wb") as stream:
        stream.truncate(16 * 10**6 + 1)
    message = (
        f"the configuration in {path}: joints.urdf: {urdf} has 16 MB, a description at most 16 MB"
    )
    fails(capsys, 2, message, "replay", path, "--bag-urdf")
    robot_file = config(tmp_path, "joints: {source: robot, urdf: /dev/zero, tip_frame: t}")
    message = "joints.urdf: /dev/zero is no regular file, so it is not opened"
    fails(capsys, 2, message, "replay", path, "--config", robot_file)


@pytest.mark.nightly
def test_a_description_travels_in_the_bag(tmp_path, capsys):
    pytest.importorskip("pinocchio")
    from robot_bags import write_robot_bag

    path, out = tmp_path / "a.mcap", tmp_path / "out.mcap"
    write_robot_bag(path, SAMPLE, seed=1)
    assert main(["replay", str(path), "--out", str(out)]) == 0
    # Whose file is elsewhere, or nowhere, reads what the bag has.
    bag = Bag(path)
    moved = dict(bag.metadata[CONFIGURATION_METADATA]) | {"joints.urdf": '"/nowhere.urdf"'}
    rows = [Row(m.topic, m.log_ns, data) for m, data in bag.with_payloads(list(INPUTS))]
    again = tmp_path / "b.mcap"
    write(again, rows, metadata=bag.metadata | {CONFIGURATION_METADATA: moved})
    elsewhere = tmp_path / "out2.mcap"
    assert main(["replay", str(again), "--out", str(elsewhere)]) == 0
    capsys.readouterr()
    assert main(["compare", str(out), str(elsewhere), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["identical"]
    with BagWriter(tmp_path / "c.mcap", from_parameters({})):
        pass
    assert "peg_on_hole_urdf" not in Bag(tmp_path / "c.mcap").metadata


def test_joint_states_out_of_order_have_their_period_and_do_not_jump(tmp_path, capsys):
    """At 500 Hz and 1 rad/s, each up to 40 ms on its way."""
    rows, rng = [], np.random.default_rng(4)
    for i in range(1000):
        t_ns = 10**9 + i * MS
        rows.append(Row("/wrench", t_ns, wrench(t_ns)))
        if i % 2 == 0:
            position = (0.3 + 1e-4 * np.sin(i), 1e-3 * i, 0.0)
            log_ns = t_ns + int(rng.integers(0, 40)) * MS
            rows.append(Row("/joint_states", log_ns, joints(t_ns, position)))
    rows.sort(key=lambda row: row.log_ns)
    path = str(write(tmp_path / "a.mcap", rows, chunk_size=20_000))
    assert main(["inspect", path, "--json"]) == 0
    inspected = json.loads(capsys.readouterr().out)
    clock = inspected["clock"]["/joint_states"]
    assert clock["median_period"] == pytest.approx(2e-3, rel=1e-9)
    assert clock["backwards"] > 500 / 3 and clock["gaps"]["count"] == 0
    assert not any("jump" in line for line in inspected["oddities"]["/joint_states"])
    assert inspected["clock"]["/wrench"]["gaps"]["longest"] == pytest.approx(1e-3, rel=1e-9)


def test_two_publishers_of_one_joint_do_jump(tmp_path, capsys):
    """In turn, and each in order: positions are 0.3 rad apart."""
    rows = motion(1000)
    rows = [
        row._replace(data=joints(row.log_ns, (0.3 * (i % 4 < 2), 0.0, 0.0)))
        if row.topic == "/joint_states"
        else row
        for i, row in enumerate(rows)
    ]
    path = str(write(tmp_path / "a.mcap", rows))
    assert main(["inspect", path, "--json"]) in (0, 3)
    lines = json.loads(capsys.readouterr().out)["oddities"]["/joint_states"]
    (line,) = [line for line in lines if "jump" in line]
    assert line.startswith("positions jump ") and "by up to 0.3" in line


def encapsulated(kind, topics=("/wrench", "/joint_states")):
    """The sample with other first bytes, as another way of serialising has them."""
    return [
        row._replace(data=kind + row.data[2:]) if row.topic in topics else row for row in sample()
    ]


@pytest.mark.parametrize(
    ("kind", "told"),
    [
        (b"\0\7", "XCDR2 (0x0007)"),
        (b"\0\6", "big-endian XCDR2 (0x0006)"),
        (b"ab", "no CDR (0x6162)"),
    ],
)
def test_what_is_no_cdr_is_named_as_that(tmp_path, capsys, kind, told):
    path = write(tmp_path / "a.mcap", encapsulated(kind))
    line = (
        f"encoding: messages on /joint_states, /wrench are in {told}, which is not read: have "
        "them published and recorded in CDR (XCDR1), as ROS 2 does"
    )
    fails(capsys, 3, f"{path}: {line}", "replay", path)
    assert main(["inspect", str(path)]) == 0
    out = capsys.readouterr().out
    assert f"\n{line}\n" in out and f"can be used; {line}" in out
    # Where the other can be used it is a remark.
    path = write(tmp_path / "b.mcap", encapsulated(kind, ["/joint_states"])[:400] + sample()[400:])
    assert main(["replay", str(path)]) == 0
    assert f"encoding: messages on /joint_states are in {told}" in capsys.readouterr().out


def test_big_endian_messages_are_read(tmp_path, capsys):
    rows = []
    for row in sample():
        message, kind = STORE.deserialize_cdr(row.data, INPUTS[row.topic]), INPUTS[row.topic]
        data = bytes(STORE.serialize_cdr(message, kind, little_endian=False))
        rows.append(row._replace(data=data))
    assert {row.data[:2] for row in rows} == {b"\0\0"}
    assert main(["replay", str(write(tmp_path / "a.mcap", rows))]) == 0
    assert f"{len(rows)} of {len(rows)} messages used" in capsys.readouterr().out


def test_hundreds_of_topics_make_no_page_of_an_error(tmp_path, capsys):
    path = tmp_path / "a.mcap"
    with writer(path) as add:
        for i in range(800):
            add(Row(f"/a/{i:03d}{'x' * 100}", i, b"\0\1\0\0"), "std_msgs/msg/String")
        for row in sample()[:2]:
            add(row._replace(topic=f"/cell{row.topic}"), INPUTS[row.topic])
    assert main(["replay", str(path)]) == 3
    error = capsys.readouterr().err
    assert len(error) < 2000 and " and 792 more; name the topics" in error
    # What may be meant comes first.
    assert "it has: /cell/wrench (geometry_msgs/msg/WrenchStamped, 1), /a/000xx" in error
