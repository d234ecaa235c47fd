"""Bags: order, damage, folders, missing topics; a bag written is a bag read."""

import json
import random
import tracemalloc
from pathlib import Path

import pytest
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import CompressionType, IndexType
from mcap.writer import Writer as McapWriter

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import CONFIGURATION_METADATA, BagWriter
from peg_on_hole_ros.cli.bag_and_configuration import open_bag
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import BagError, PegOnHoleError
from peg_on_hole_ros.messages.definitions import definition
from recorded import records
from small_bags import JOINTS, MS, WRENCH, header, joints, wrench, write_bag

TEXT = "std_msgs/msg/String"
BOTH = {"/wrench": WRENCH, "/joint_states": JOINTS}


def raw_text(text):
    data = text.encode() + b"\0"
    return b"\0\1\0\0" + len(data).to_bytes(4, "little") + data


def text_bag(path, times, chunk_size=200, schema=None, encoding="ros2msg", **options):
    """Write std_msgs/String messages "0", "1", ... with these log times, in small chunks."""
    with open(path, "wb") as stream:
        writer = McapWriter(stream, chunk_size=chunk_size, **options)
        writer.start(profile="ros2")
        data = definition(TEXT).encode() if schema is None else schema
        channel = writer.register_channel(
            "/t", "cdr", writer.register_schema(TEXT, encoding, data)
        )
        for i, t_ns in enumerate(times):
            writer.add_message(channel, t_ns, raw_text(str(i)), t_ns)
        writer.finish()
    return path


def order(bag):
    return [int(m.message.data) for m in bag.messages(["/t"])]


@pytest.mark.parametrize("chunking", [True, False])
@pytest.mark.parametrize(
    "compression", [CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD]
)
def test_messages_come_by_log_time_and_ties_in_the_order_of_the_file(
    tmp_path, chunking, compression
):
    times = [(i * 37) % 50 // 2 for i in range(200)]
    path = text_bag(tmp_path / "a.mcap", times, use_chunking=chunking, compression=compression)
    bag = Bag(path)
    assert order(bag) == sorted(range(200), key=lambda i: times[i])
    assert order(bag) == order(bag), "a bag can be read twice"
    info = bag.topics["/t"]
    assert (info.types, info.count, info.first_ns, info.last_ns) == ([TEXT], 200, 0, 24)
    assert not bag.damage


def test_memory_holds_only_chunks_that_overlap(tmp_path):
    def peak(count):
        path = text_bag(tmp_path / f"{count}.mcap", range(count), chunk_size=20_000)
        bag, expected = Bag(path), iter(range(count))
        tracemalloc.start()
        assert all(int(m.message.data) == next(expected) for m in bag.messages(["/t"]))
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    peak(4000)  # what is imported and kept once
    assert peak(40_000) < 1.3 * peak(4000)


def test_messages_outside_chunks_are_read_in_runs(tmp_path, monkeypatch):
    path = text_bag(tmp_path / "a.mcap", range(500), use_chunking=False)
    assert len(Bag(path)._blocks) == 1
    monkeypatch.setattr("peg_on_hole_ros.bags.storage.mcap_file._GROUP_BYTES", 400)
    bag = Bag(path)
    # A message takes 40 bytes and a few: a run ends once it has passed 400.
    assert 40 < len(bag._blocks) < 60
    assert order(bag) == list(range(500))


def test_definition_left_out_is_that_of_ros(tmp_path):
    path = text_bag(tmp_path / "a.mcap", range(5), schema=b"")
    bag = Bag(path)
    bag.require({"/t": TEXT})
    assert order(bag) == [0, 1, 2, 3, 4]


def test_cut_off_file_gives_every_whole_chunk_and_says_where(tmp_path):
    whole = text_bag(tmp_path / "a.mcap", range(1000)).read_bytes()
    counts = []
    data_end = next(at for at, opcode, _ in records(whole) if opcode == Opcode.DATA_END)
    third = next(at for at, _, _ in records(whole) if at > len(whole) // 3)
    why = "its recorder was stopped, or it was not copied whole"
    for size, what in (
        (third, f", behind a whole record: {why}"),
        (third + 7, f": {why}, and its last 7 bytes cannot be read"),
        (data_end, f", behind a whole record: {why}"),
        (data_end + 13, ", within the index at its end: no message of it is lost"),
        (len(whole) - 1, ", within the index at its end: no message of it is lost"),
    ):
        path = tmp_path / f"{size}.mcap"
        path.write_bytes(whole[:size])
        bag = Bag(path)
        got = order(bag)
        assert got == list(range(len(got)))
        assert bag.damage == f"{path} is cut off at byte {size}{what}"
        counts.append(len(got))
    assert 100 < counts[0] == counts[1] < counts[2] == counts[3] == counts[4] == 1000


def test_parts_behind_a_damaged_one_are_told(tmp_path):
    path = folder(tmp_path, described(*(f"b_{i}.mcap" for i in range(4))))
    for i in range(2, 4):
        write_bag(path / f"b_{i}.mcap", count=10, start=10**9 + (10 * i) * MS)
    (path / "b_1.mcap").write_bytes((path / "b_1.mcap").read_bytes()[:100])
    bag = Bag(path)
    assert bag.damage.endswith(
        "cannot be read; the parts behind it are not read: b_2.mcap, b_3.mcap"
    )
    assert bag.topics["/wrench"].count == 10


def test_flipped_byte_in_a_chunk_is_found_and_what_lies_before_is_kept(tmp_path):
    path = text_bag(tmp_path / "a.mcap", range(1000), compression=CompressionType.NONE)
    data = bytearray(path.read_bytes())
    at = data.index(raw_text("500")) + 8
    data[at] ^= 1
    path.write_bytes(data)
    bag = Bag(path)
    got = order(bag)
    assert got == list(range(len(got))) and 480 < len(got) <= 500
    assert "does not fit its checksum" in bag.damage and str(path) in bag.damage


@pytest.mark.parametrize("compression", [CompressionType.LZ4, CompressionType.ZSTD])
def test_damage_within_compressed_data_is_reported(tmp_path, compression):
    path = text_bag(tmp_path / "a.mcap", range(1000), compression=compression, chunk_size=4000)
    block = Bag(path)._blocks[2]
    data = bytearray(path.read_bytes())
    middle = block.start + block.length // 2
    data[middle : middle + 64] = bytes(64)
    path.write_bytes(data)
    bag = Bag(path)
    got = order(bag)
    assert got == list(range(len(got))) and 0 < len(got) < 1000
    assert bag.damage.startswith(f"{path} is damaged")


@pytest.mark.nightly
@pytest.mark.parametrize("checked", [False, True])
def test_flipped_bits_in_the_index_cost_no_message(tmp_path, checked):
    # Without checksums, as some recorders write, the index may be anything.
    whole = text_bag(tmp_path / "w.mcap", range(100), 1000, enable_crcs=checked).read_bytes()
    data_end = next(at for at, opcode, _ in records(whole) if opcode == Opcode.DATA_END)
    path = tmp_path / "a.mcap"
    lost = "damaged within the index at its end: no message of it is lost"
    told = 0
    for at in range(data_end + 13, len(whole) - 8):
        data = bytearray(whole)
        data[at] ^= 1 << at % 8
        path.write_bytes(data)
        bag = Bag(path)
        bag.require({"/t": TEXT})
        assert order(bag) == list(range(100))
        # A bit away from a record of the index is one that holds messages.
        assert bag.damage in ("", f"{path} is {lost}") or "where the index has" in bag.damage
        told += bool(bag.damage)
    assert told == len(whole) - 8 - data_end - 13 or not checked


def test_messages_behind_the_end_of_the_data_are_no_index(tmp_path):
    whole = text_bag(tmp_path / "w.mcap", range(100)).read_bytes()
    at, _, _ = next(found for found in records(whole) if found[1] == Opcode.CHUNK)
    path = tmp_path / "a.mcap"
    # As if nothing but the kind of an earlier record had been overwritten.
    path.write_bytes(whole[:at] + bytes([Opcode.DATA_END, 4, *bytes(11)]) + whole[at:])
    assert Bag(path).damage == (
        f"{path} is damaged at byte {at + 13}: messages where the index has to be"
    )


def test_damage_outside_chunks_is_found_by_the_checksum_of_the_whole(tmp_path):
    path = text_bag(tmp_path / "a.mcap", range(50), use_chunking=False, enable_data_crcs=True)
    assert not Bag(path).damage
    data = bytearray(path.read_bytes())
    data[data.index(raw_text("20")) + 8] ^= 1
    path.write_bytes(data)
    assert Bag(path).damage == f"{path} is damaged: the data section does not fit its checksum"


def test_no_damage_whatever_raises_anything_but_a_bag_error(tmp_path):
    whole = write_bag(tmp_path / "w.mcap", count=60, chunk_bytes=2000).read_bytes()
    rng = random.Random(1)
    path = tmp_path / "a.mcap"
    found = 0
    for _ in range(300):
        data = bytearray(whole)
        at = rng.randrange(len(data))
        kind = rng.randrange(4)
        if kind == 0:
            data[at] ^= 1 << rng.randrange(8)
        elif kind == 1:
            data[at : at + rng.randrange(64)] = rng.randbytes(rng.randrange(64))
        elif kind == 2:
            del data[at:]
        else:
            # A record's head of rubbish: any opcode, any length.
            data[at : at + 9] = bytes([rng.randrange(16)]) + rng.randbytes(8)
        path.write_bytes(data)
        try:
            bag = Bag(path)
            read = sum(1 for _ in bag.messages(BOTH))
        except BagError:
            found += 1
            continue
        assert read <= 90
        found += bool(bag.damage)
        assert bag.damage or read + sum(bag.undecodable.values()) == bag.count
    # The rest lies where nothing checks and nothing is read from: indexes and statistics.
    assert found > 200


@pytest.mark.parametrize("field", [8, 16])
def test_absurd_sizes_in_a_chunk_are_damage(tmp_path, field):
    path = write_bag(tmp_path / "a.mcap", count=60, chunk_bytes=2000)
    start = Bag(path)._blocks[2].start
    data = bytearray(path.read_bytes())
    # Of a chunk: start, end, uncompressed size, crc, compression ("zstd" with length), data size.
    place = {8: start + 16, 16: start + 16 + 8 + 4 + 8}[field]
    data[place : place + 8] = b"\xff" * 8
    path.write_bytes(data)
    bag = Bag(path)
    assert bag.damage.startswith(f"{path} is damaged at byte {start - 9}: ")
    assert 0 < bag.count < 90


def test_undecodable_payload_is_counted_not_read(tmp_path):
    path = write_bag(tmp_path / "whole.mcap", count=2)
    with open(path, "rb") as stream:
        payloads = [m.data for _, c, m in make_reader(stream).iter_messages(["/wrench"])]
    path = tmp_path / "a.mcap"
    with open(path, "wb") as stream:
        writer = McapWriter(stream)
        writer.start(profile="ros2")
        schema = writer.register_schema(WRENCH, "ros2msg", definition(WRENCH).encode())
        channel = writer.register_channel("/wrench", "cdr", schema)
        for i, data in enumerate([payloads[0], payloads[0][:-1], b"", payloads[1]]):
            writer.add_message(channel, i, data, i)
        writer.finish()
    bag = Bag(path)
    assert [m.log_ns for m in bag.messages(["/wrench"])] == [0, 3]
    assert bag.undecodable == {"/wrench": 2}


def test_index_is_not_needed(tmp_path):
    path = text_bag(tmp_path / "a.mcap", range(100), index_types=IndexType.NONE)
    assert order(Bag(path)) == list(range(100))


def test_written_messages_come_back_with_the_configuration(tmp_path):
    path = tmp_path / "out.mcap"
    with BagWriter(path, Configuration(), {"origin": {"seed": "3"}}) as writer:
        writer.write("/wrench", WRENCH, wrench(5 * MS, (1.5, -2.0, 3.0), (0.1, 0.2, 0.3)), 5 * MS)
        writer.write_all(
            "/peg_on_hole/",
            [
                ("state", JOINTS, joints(5 * MS)),
                (
                    "/diagnostics",
                    "diagnostic_msgs/msg/DiagnosticArray",
                    {"header": header(5 * MS)},
                ),
            ],
            5 * MS,
        )
        writer.add_metadata("end", {"a": "b"})
    assert [p.name for p in tmp_path.iterdir()] == ["out.mcap"]
    bag = Bag(path)
    assert set(bag.topics) == {"/wrench", "/peg_on_hole/state", "/diagnostics"}
    (message,) = bag.messages(["/wrench"])
    assert message.log_ns == 5 * MS
    assert message.message.wrench.force.y == -2.0
    assert message.message.header.frame_id == "sensor"
    assert json.loads(bag.metadata[CONFIGURATION_METADATA]["scene.gravity"]) == [
        0.0,
        0.0,
        -9.80665,
    ]
    assert bag.metadata["origin"] == {"seed": "3"} and bag.metadata["end"] == {"a": "b"}


def test_failure_while_writing_leaves_no_file(tmp_path):
    with pytest.raises(RuntimeError), BagWriter(tmp_path / "out.mcap"):
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


def test_interruption_while_a_file_is_begun_leaves_none(tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("peg_on_hole_ros.bags.writer.BulkWriter.start", interrupted)
    with pytest.raises(KeyboardInterrupt), BagWriter(tmp_path / "out.mcap"):
        pass
    assert list(tmp_path.iterdir()) == []


def test_place_that_cannot_be_written(tmp_path):
    message = "cannot write .*out.mcap: No such file"
    with pytest.raises(PegOnHoleError, match=message), BagWriter(tmp_path / "none" / "out.mcap"):
        pass


def folder(tmp_path, description=None, files=("b_0.mcap", "b_1.mcap")):
    path = tmp_path / "bag"
    path.mkdir()
    for i, name in enumerate(files):
        write_bag(path / name, count=10, start=10**9 * (1 + i))
    if description is not None:
        (path / "metadata.yaml").write_text(description)
    return path


def described(*names, storage="mcap"):
    return (
        "rosbag2_bagfile_information:\n  version: 9\n"
        f"  storage_identifier: {storage}\n  relative_file_paths: [{', '.join(names)}]\n"
    )


@pytest.mark.parametrize("description", [None, described("b_0.mcap", "b_1.mcap")])
def test_folder_is_read_as_one_bag(tmp_path, description):
    bag = Bag(folder(tmp_path, description))
    bag.require(BOTH)
    times = [m.log_ns for m in bag.messages(["/wrench"])]
    assert len(times) == 20 and times == sorted(times)


def test_files_of_a_folder_without_description_are_in_natural_order(tmp_path):
    path = folder(tmp_path, None, ("b_9.mcap", "b_10.mcap"))
    assert [scan.path.name for scan in Bag(path)._scans] == ["b_9.mcap", "b_10.mcap"]


@pytest.mark.parametrize("left", [b"", b"\x89MC", b"\0" * 4096])
@pytest.mark.parametrize("description", [None, described("b_0.mcap", "b_1.mcap", "b_2.mcap")])
def test_a_last_part_that_was_never_written_leaves_those_before_it(tmp_path, description, left):
    path = folder(tmp_path, description)
    (path / "b_2.mcap").write_bytes(left)
    bag = Bag(path)
    assert bag.damage == f"{path}/b_2.mcap is " + (
        "empty (0 bytes)"
        if not left
        else "cut off at byte 3"
        if len(left) < 8
        else "not an MCAP file: it begins with b'\\x00\\x00\\x00\\x00\\x00\\x00\\x00\\x00'"
    )
    assert bag.topics["/wrench"].count == len(list(bag.messages(["/wrench"]))) == 20
    (path / "b_0.mcap").write_bytes(left)
    with pytest.raises(BagError, match="b_0.mcap is (empty|cut off|not an MCAP file)"):
        Bag(path)


REMEDY = (
    "name one file; or have each replayed by itself: replay with --jobs 1; or, if they are one "
    "recording, have its metadata.yaml written: ros2 bag reindex -s mcap {path}"
)


@pytest.mark.parametrize(
    "names", [("a.mcap", "b.mcap"), ("a_0.mcap", "b_0.mcap"), ("a_0.mcap", "a_1.mcap", "out.mcap")]
)
def test_files_of_several_recordings_are_not_merged(tmp_path, names):
    path = folder(tmp_path, None, names)
    with pytest.raises(BagError) as caught:
        Bag(path)
    assert str(caught.value) == (
        f"{path} is a folder without metadata.yaml, and its files are not named as the "
        f"parts of one recording (NAME_0.mcap, NAME_1.mcap, ...): {', '.join(names)}; "
        + REMEDY.format(path=path)
    )
    (path / "metadata.yaml").write_text(described(*names))
    assert Bag(path).topics["/wrench"].count == 10 * len(names), "a description is believed"


def test_a_folder_of_one_file_is_that_file(tmp_path):
    assert Bag(folder(tmp_path, None, ["any.mcap"])).topics["/wrench"].count == 10


def test_parts_that_were_recorded_at_one_time_are_not_merged(tmp_path):
    path = folder(tmp_path)
    # 10 ms each, the second from 1 ms before the end of the first: a recorder that splits.
    write_bag(path / "b_1.mcap", count=10, start=10**9 + 8 * MS)
    assert Bag(path).topics["/wrench"].count == 20
    write_bag(path / "b_1.mcap", count=10, start=10**9 + 2 * MS)
    with pytest.raises(BagError) as caught:
        Bag(path)
    assert str(caught.value) == (
        f"{path} has no metadata.yaml, and b_0.mcap and b_1.mcap overlap by 0.007 s, so they are "
        "not parts of one recording; " + REMEDY.format(path=path)
    )


@pytest.mark.parametrize(
    ("names", "starts", "what"),
    [
        # Recorded a minute apart, and called after the same thing, but not as a recorder does.
        (("run_1", "run_2"), (1, 61), "run_2.mcap begins 59.991 s after run_1.mcap has ended"),
        (("bag_0", "bag_2"), (1, 61), "bag_2.mcap begins 59.991 s after bag_0.mcap has ended"),
        (("bag_0", "bag_1"), (61, 1), "bag_1.mcap was recorded before bag_0.mcap"),
    ],
)
def test_recordings_of_different_times_are_not_merged(tmp_path, names, starts, what):
    path = folder(tmp_path, None, ())
    for name, start in zip(names, starts):
        write_bag(path / f"{name}.mcap", count=10, start=start * 10**9)
    with pytest.raises(BagError) as caught:
        Bag(path)
    assert str(caught.value) == (
        f"{path} has no metadata.yaml, and {what}, so they are not parts of one recording; "
        + REMEDY.format(path=path)
    )
    (path / "metadata.yaml").write_text(described(*(f"{name}.mcap" for name in names)))
    assert Bag(path).topics["/wrench"].count == 20


def test_a_recorder_may_have_been_paused(tmp_path, monkeypatch):
    path = folder(tmp_path, None, ())
    for i, start in enumerate((1, 61, 62)):
        write_bag(path / f"bag_{i}.mcap", count=10, start=start * 10**9)
    assert Bag(path).topics["/wrench"].count == 30
    monkeypatch.chdir(path)
    assert Bag(".").topics["/wrench"].count == 30
    # One that keeps the latest parts alone has deleted the first.
    (path / "bag_0.mcap").unlink()
    assert Bag(path).topics["/wrench"].count == 20


def test_files_that_a_description_does_not_name_are_told(tmp_path, capsys):
    path = folder(tmp_path, described("b_0.mcap"))
    bag = open_bag(path)
    assert bag.topics["/wrench"].count == 10 and bag.unnamed == (path / "b_1.mcap",)
    assert capsys.readouterr().err == (
        f"{path}: not read, as metadata.yaml does not name it: b_1.mcap; if it is a part of the "
        f"recording: ros2 bag reindex -s mcap {path}\n"
    )


def test_a_folder_of_bags_says_which(tmp_path):
    path = folder(tmp_path, described("b_0.mcap"))
    with pytest.raises(BagError) as caught:
        Bag(tmp_path)
    assert str(caught.value) == (
        f"{tmp_path} is a folder without metadata.yaml and without .mcap files: no bag; the bags "
        f"in it are {path.name}: name one of them"
    )
    for i in (2, 10):  # of recorders that were killed
        (tmp_path / f"run_{i}").mkdir()
        write_bag(tmp_path / f"run_{i}" / f"run_{i}_0.mcap", count=10)
    with pytest.raises(BagError, match="the bags in it are bag, run_2, run_10: name one of them"):
        Bag(tmp_path)


def test_paths_that_are_none(tmp_path, monkeypatch):
    write_bag(tmp_path / "b_0.mcap", count=10)
    monkeypatch.chdir(tmp_path)
    assert Bag(".").count == 15
    with pytest.raises(PegOnHoleError, match="the path of the bag is empty") as caught:
        Bag("")
    assert caught.value.exit_code == 2
    with pytest.raises(BagError, match="cannot read x+: File name too long"):
        Bag("x" * 300)


@pytest.mark.parametrize(
    ("description", "message"),
    [
        (described("b_2.mcap"), "{path}/metadata.yaml names b_2.mcap, which is not in {path}"),
        (
            described("b_0.db3", storage="sqlite3"),
            "{path}/metadata.yaml names b_0.db3, which is not in {path}",
        ),
        (
            "a: 1",
            "{path}/metadata.yaml is not a description of a bag (rosbag2_bagfile_information with "
            "relative_file_paths); remove it to read the files of {path}",
        ),
        (
            described(),
            "{path}/metadata.yaml names no files; remove it to read the files of {path}",
        ),
        # Its letters had been taken for files.
        (
            "rosbag2_bagfile_information: {relative_file_paths: b_0.mcap}",
            "{path}/metadata.yaml is not a description of a bag (rosbag2_bagfile_information with "
            "relative_file_paths); remove it to read the files of {path}",
        ),
        (
            described("b_0.mcap", "b_1.mcap", "b_0.mcap"),
            "{path}/metadata.yaml names b_0.mcap 2 times, and its messages would be read as "
            "often; leave it there once",
        ),
        (
            described("b_0.rrd", storage="rerun"),
            "{path}/b_0.rrd is neither .mcap nor .db3, nor one of them with .zstd: rerun is not "
            "read; convert it: ros2 bag convert -i {path} with storage_id mcap for the output",
        ),
    ],
)
def test_unusable_folders(tmp_path, description, message):
    path = folder(tmp_path, description)
    (path / "b_0.rrd").touch()
    with pytest.raises(BagError) as caught:
        Bag(path)
    assert str(caught.value) == message.replace("{path}", str(path))


def test_an_old_recorder_put_the_name_of_the_folder_before_its_files(tmp_path, monkeypatch):
    old = described("bag/b_0.mcap", "bag/b_1.mcap").replace("version: 9", "version: 3")
    path = folder(tmp_path, old)
    assert Bag(path).topics["/wrench"].count == 20 and not Bag(path).unnamed
    monkeypatch.chdir(path)
    assert Bag(".").topics["/wrench"].count == 20


def test_folder_that_is_no_bag(tmp_path):
    with pytest.raises(BagError, match="without metadata.yaml and without .mcap files: no bag"):
        Bag(tmp_path)
    Path(tmp_path / "x.db3").write_bytes(b"SQLite")
    for path in (tmp_path, tmp_path / "x.db3"):
        with pytest.raises(BagError, match="x.db3 is no bag in SQLite: .*file is not a database"):
            Bag(path)


def test_requirements_are_refused_with_what_the_bag_has(tmp_path):
    path = write_bag(tmp_path / "a.mcap", count=4, wrench_topic="/ft")
    with pytest.raises(BagError) as caught:
        Bag(path).require(BOTH, "look elsewhere")
    assert str(caught.value) == (
        f"{path} has no messages on /wrench (geometry_msgs/msg/WrenchStamped); it has: "
        "/ft (geometry_msgs/msg/WrenchStamped, 4), /joint_states (sensor_msgs/msg/JointState, 2); "
        "look elsewhere"
    )
    with pytest.raises(BagError) as caught:
        Bag(path).require({"/joint_states": WRENCH})
    assert str(caught.value).startswith(
        f"{path}: /joint_states is sensor_msgs/msg/JointState, not geometry_msgs/msg/WrenchStamped"
    )
    with BagWriter(tmp_path / "empty.mcap"):
        pass
    with pytest.raises(BagError, match=r"empty.mcap holds no messages$"):
        Bag(tmp_path / "empty.mcap").require(BOTH)


def test_other_encodings_are_refused_by_name(tmp_path):
    path = text_bag(tmp_path / "a.mcap", range(3), encoding="jsonschema")
    with pytest.raises(BagError, match="/t is encoded as cdr, jsonschema; only messages of ROS 2"):
        Bag(path).require({"/t": TEXT})


def test_a_definition_in_idl_is_that_of_ros(tmp_path):
    idl = b"module std_msgs { module msg { struct String { string data; }; }; };"
    bag = Bag(text_bag(tmp_path / "a.mcap", range(5), schema=idl, encoding="ros2idl"))
    bag.require({"/t": TEXT})
    assert order(bag) == [0, 1, 2, 3, 4]
