"""Whatever recorders write is read: storages, packings, versions, definitions; all the same."""

import shutil
import sqlite3
import subprocess
from contextlib import closing

import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.errors import BagError
from recorded import (
    INPUTS,
    PACK,
    STORE,
    UNPACKED,
    Row,
    definition,
    described,
    motion,
    write,
    writer,
)
from small_bags import WRENCH
from tiers import at_push

ROWS = motion()


def samples(bag):
    return [item for batch in bag.batches(INPUTS) for item in batch.items()]


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    found = samples(Bag(write(tmp_path_factory.mktemp("bag") / "a.mcap", ROWS)))
    assert len(found) == len(ROWS)
    assert [item.log_ns for item in found] == [row.log_ns for row in ROWS]
    return found


@pytest.mark.parametrize("chunking", [True, False])
@pytest.mark.parametrize(
    "compression", [CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD]
)
def test_chunks(tmp_path, expected, chunking, compression):
    options = {"use_chunking": chunking, "compression": compression, "chunk_size": 5000}
    assert samples(Bag(write(tmp_path / "a.mcap", ROWS, **options))) == expected


@pytest.mark.parametrize("version", at_push([3, 9], range(3, 10)))
@pytest.mark.parametrize("mode", ["none", "FILE", "MESSAGE"])
def test_folders_of_every_version_split_and_packed(tmp_path, expected, version, mode):
    folder = tmp_path / "rec"
    folder.mkdir()
    names = []
    for i, part in enumerate((ROWS[:250], ROWS[250:])):
        name = f"rec_{i}.mcap"
        if mode == "MESSAGE":
            part = [row._replace(data=PACK(row.data)) for row in part]
        write(folder / name, part, compression=UNPACKED, chunk_size=9000)
        if mode == "FILE":
            (folder / f"{name}.zstd").write_bytes(PACK((folder / name).read_bytes()))
            (folder / name).unlink()
            name += ".zstd"
        names.append(f"rec/{name}" if version < 4 else name)
    more = "" if mode == "none" else f"  compression_mode: {mode}\n  compression_format: zstd\n"
    text = described(*names, version=version, more=more)
    (folder / "metadata.yaml").write_text(text)
    bag = Bag(folder)
    assert samples(bag) == expected and not bag.damage and not bag.unnamed
    # A recorder that is killed describes nothing.
    (folder / "metadata.yaml").unlink()
    assert samples(Bag(folder)) == expected


def put_rows(bag):
    with bag:
        connections = {
            topic: bag.add_connection(topic, kind, typestore=STORE)
            for topic, kind in INPUTS.items()
        }
        for row in ROWS:
            bag.write(connections[row.topic], row.log_ns, row.data)


@pytest.mark.parametrize("storage", list(StoragePlugin))
@pytest.mark.parametrize("mode", list(CompressionMode))
@pytest.mark.parametrize("version", [8, 9])
def test_folders_of_another_recorder(tmp_path, expected, storage, mode, version):
    if storage is StoragePlugin.MCAP and mode is CompressionMode.STORAGE:
        mode = CompressionMode.NONE
    folder = tmp_path / "rec"
    bag = Rosbag2Writer(folder, version=version, storage_plugin=storage)
    if mode is not CompressionMode.NONE:
        if storage is StoragePlugin.SQLITE3 and mode is CompressionMode.STORAGE:
            pytest.skip("a storage that packs by itself")
        bag.set_compression(mode, CompressionFormat.ZSTD)
    put_rows(bag)
    assert samples(Bag(folder)) == expected
    # The file alone, too.
    assert samples(Bag(next(f for f in folder.iterdir() if f.suffix != ".yaml"))) == expected


def test_a_file_in_sqlite_that_is_damaged(tmp_path):
    folder = tmp_path / "rec"
    with Rosbag2Writer(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        connection = bag.add_connection("/wrench", WRENCH, typestore=STORE)
        for row in motion(20_000):
            if row.topic == "/wrench":
                bag.write(connection, row.log_ns, row.data)
    (file,) = folder.glob("*.db3")
    data = bytearray(file.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 300_000] = b"\xff" * 300_000
    file.write_bytes(data)
    remedy = (
        "copy it again, or if it was cut off take out what is whole: sqlite3 "
        f"{file} .recover | sqlite3 whole.db3"
    )
    with pytest.raises(BagError) as caught:
        Bag(file)
    assert str(caught.value).startswith(f"{file} is no bag in SQLite: ")
    assert str(caught.value).endswith(f" malformed; {remedy}")


@pytest.mark.parametrize("share", [0.6, 0.02])
def test_a_packed_file_in_sqlite_that_is_cut_is_named_as_it_was_given(tmp_path, share):
    random = np.random.default_rng(1)
    with Rosbag2Writer(tmp_path / "rec", version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        connection = bag.add_connection("/points", "std_msgs/msg/String", typestore=STORE)
        for k in range(20):
            bag.write(connection, k, random.bytes(100_000))
    (file,) = (tmp_path / "rec").glob("*.db3")
    data = file.read_bytes()
    path = tmp_path / "a.db3.zstd"
    packed = zstandard.ZstdCompressor().compress(data)
    path.write_bytes(packed[: int(share * len(packed))])
    with pytest.raises(BagError) as caught:
        Bag(path)
    told = str(caught.value)
    assert told.startswith(f"{path} is no bag in SQLite: it is cut off, ")
    assert f" of {len(data)} bytes can be unpacked; " in told and "copy it again" in told
    assert "/peg_on_hole_" not in told


def test_what_a_killed_recorder_left_beside_a_file_in_sqlite_is_read(tmp_path, expected):
    whole, path = tmp_path / "whole", tmp_path / "killed"
    put_rows(Rosbag2Writer(whole, version=9, storage_plugin=StoragePlugin.SQLITE3))
    path.mkdir()
    shutil.copy(whole / "metadata.yaml", path)
    (file,) = whole.glob("*.db3")
    with closing(sqlite3.connect(file)) as database:
        database.execute("PRAGMA journal_mode=WAL")
        last = "CREATE TABLE held AS SELECT * FROM messages WHERE id > 5"
        database.executescript(f"{last}; DELETE FROM messages WHERE id > 5")
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        database.execute("INSERT INTO messages SELECT * FROM held")
        database.commit()
        # Before it is closed, which would put them into the file.
        for name in (file.name, f"{file.name}-wal"):
            shutil.copy(whole / name, path / name)
    assert samples(Bag(path)) == expected
    assert not list(path.glob("*-shm"))


def test_a_file_that_was_unpacked_by_hand_is_read_for_that_of_the_description(tmp_path, expected):
    folder = tmp_path / "rec"
    folder.mkdir()
    write(folder / "rec_0.mcap", ROWS)
    (folder / "metadata.yaml").write_text(described("rec_0.mcap.zstd"))
    bag = Bag(folder)
    assert samples(bag) == expected and not bag.unnamed
    assert bag.remarks(INPUTS) == [
        "files: rec_0.mcap is read for the rec_0.mcap.zstd of metadata.yaml"
    ]
    # Beside what it was unpacked from it is not read a second time.
    (folder / "rec_0.mcap.zstd").write_bytes(PACK((folder / "rec_0.mcap").read_bytes()))
    bag = Bag(folder)
    assert samples(bag) == expected and not bag.unnamed and not bag.remarks(INPUTS)
    (folder / "metadata.yaml").unlink()
    assert samples(Bag(folder)) == expected


def test_a_packed_file_that_is_cut_off_gives_what_lies_before(tmp_path, expected):
    plain = write(tmp_path / "a.mcap", ROWS, chunk_size=2000, compression=UNPACKED)
    path = tmp_path / "a.mcap.zstd"
    packed = PACK(plain.read_bytes())
    path.write_bytes(packed)
    assert samples(Bag(path)) == expected
    # PageUpdates one behind the other, as `zstd` takes files together.
    data = plain.read_bytes()
    path.write_bytes(PACK(data[:10_000]) + PACK(data[10_000:]))
    assert samples(Bag(path)) == expected
    path.write_bytes((PACK(data[:10_000]) + PACK(data[10_000:]))[:-50])
    bag = Bag(path)
    found = samples(bag)
    assert 0 < len(found) < len(ROWS) and found == expected[: len(found)]
    assert bag.damage.startswith(f"{path} is ")
    path.write_bytes(b"\x28\xb5\x2f\xfdrubbish")
    assert "its compression is damaged" in Bag(path).damage


@pytest.mark.parametrize(
    ("name", "command"), [("a.mcap.gz", "gunzip -k"), ("b.bz2", "bunzip2 -k")]
)
def test_other_packings_are_refused_with_the_command(tmp_path, name, command):
    path = tmp_path / name
    path.write_bytes(b"rubbish")
    with pytest.raises(BagError, match=f"in a way that is not read; unpack it: {command} {path}$"):
        Bag(path)


def test_the_command_unpacks(tmp_path, expected):
    if not shutil.which("gzip"):
        pytest.skip("no gzip")
    path = write(tmp_path / "press; 2.mcap", ROWS)
    subprocess.run(["gzip", path], check=True)
    with pytest.raises(BagError) as caught:
        Bag(f"{path}.gz")
    subprocess.run(str(caught.value).partition("unpack it: ")[2], shell=True, check=True)
    assert samples(Bag(path)) == expected


def without_inner(kind):
    return definition(kind).split("=====")[0]


@pytest.mark.parametrize(
    ("text", "lacking"),
    [
        (lambda kind: "", ("", "")),
        (lambda kind: kind, ("all of its fields",) * 2),
        (lambda kind: "rubbish", ("all of its fields",) * 2),
        (lambda kind: "# a comment\n", ("all of its fields",) * 2),
        (without_inner, ("geometry_msgs/Wrench, std_msgs/Header", "std_msgs/Header")),
    ],
)
def test_definitions_that_are_left_out_wholly_or_in_part(tmp_path, capfd, expected, text, lacking):
    bag = Bag(write(tmp_path / "a.mcap", ROWS, text=text))
    bag.require(INPUTS)
    assert samples(bag) == expected
    assert [m.message.header.frame_id for m in bag.messages(["/wrench"])] == ["sensor"] * 400
    told = [
        f"definition: that of {kind} on {topic} is incomplete (it lacks {what}): read by the "
        "type's name"
        for (topic, kind), what in zip(INPUTS.items(), lacking)
        if what
    ]
    assert bag.remarks(INPUTS) == told
    # No line of a parser that is another's.
    assert capfd.readouterr() == ("", "")


def test_a_definition_that_another_has_changed_is_read_as_it_is(tmp_path):
    # A number in front: by the own definition all would be rubbish.
    def text(kind):
        return "uint64 number\n" + definition(kind)

    rows = [Row(r.topic, r.log_ns, b"\0\1\0\0" + bytes(8) + r.data[4:]) for r in ROWS]
    bag = Bag(write(tmp_path / "a.mcap", rows, text=text))
    found = samples(bag)
    assert [item.sample for item in found] == [
        item.sample for item in samples(Bag(write(tmp_path / "b.mcap", ROWS)))
    ]
    assert not bag.remarks(INPUTS)


def test_an_unknown_type_whose_definition_is_incomplete_cannot_be_read(tmp_path):
    path = tmp_path / "a.mcap"
    with writer(path, text=lambda kind: "other_msgs/Thing thing") as add:
        add(Row("/own", 1, b"\0\1\0\0"), "my_msgs/msg/Own")
    with pytest.raises(BagError) as caught:
        list(Bag(path).messages(["/own"]))
    assert str(caught.value) == (
        f"{path}: the definition of my_msgs/msg/Own on /own cannot be read, and the type is not "
        "one that is known: it lacks other_msgs/Thing"
    )


def test_channels_without_a_schema_are_taken_for_what_is_asked_for(tmp_path, expected):
    bag = Bag(write(tmp_path / "a.mcap", ROWS, text=None))
    bag.require(INPUTS)
    assert samples(bag) == expected
    assert bag.remarks(INPUTS) == [
        f"definition: {topic} has no type in the bag; read as {kind}"
        for topic, kind in INPUTS.items()
    ]


def test_a_recording_of_ros_1_is_named_as_what_it_is(tmp_path):
    path = write(tmp_path / "a.mcap", ROWS, encoding=("ros1", "ros1msg"))
    with pytest.raises(BagError) as caught:
        Bag(path).require(INPUTS)
    assert str(caught.value) == (
        f"{path}: /wrench is encoded as ros1, ros1msg, so this is a recording of ROS 1; convert "
        "the bag it was made of: rosbags-convert --src RECORDING.bag --dst FOLDER"
    )


def test_attachments_and_other_channels_cost_nothing(tmp_path, expected):
    from mcap.writer import Writer

    path = tmp_path / "a.mcap"
    with path.open("wb") as stream:
        mcap = Writer(stream, chunk_size=4000)
        mcap.start()
        mcap.add_attachment(1, 1, "photo", "image/png", bytes(3 << 20))
        other = mcap.register_channel("/image", "protobuf", 0)
        channels = {
            topic: mcap.register_channel(topic, "cdr", mcap.register_schema(kind, "ros2msg", b""))
            for topic, kind in INPUTS.items()
        }
        for row in ROWS:
            mcap.add_message(channels[row.topic], row.log_ns, row.data, row.log_ns)
            mcap.add_message(other, row.log_ns, b"rubbish", row.log_ns)
        mcap.finish()
    bag = Bag(path)
    assert samples(bag) == expected and not bag.damage
    assert bag.topics["/image"].count == len(ROWS)
