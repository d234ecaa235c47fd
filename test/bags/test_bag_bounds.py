"""Bombs, cuts and rubbish: told with their place, within little memory and time."""

import struct
import tracemalloc
import zlib
from contextlib import contextmanager

import pytest
import zstandard
from mcap.opcode import Opcode
from mcap.writer import CompressionType

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.errors import BagError
from recorded import INPUTS, PACK, Row, described, motion, records, write, writer

MIB = 1 << 20
ROWS = motion()


@contextmanager
def at_most(mebibytes):
    tracemalloc.start()
    yield
    peak = tracemalloc.get_traced_memory()[1] / MIB
    tracemalloc.stop()
    assert peak < mebibytes


def chunk(content, compression=b"zstd", size=None, packed=None, crc=None):
    packed = PACK(content) if packed is None else packed
    size = len(content) if size is None else size
    head = struct.pack("<QQQI", 0, 0, size, zlib.crc32(content) if crc is None else crc)
    body = head + struct.pack("<I", len(compression)) + compression
    body += struct.pack("<Q", len(packed)) + packed
    return b"\x06" + struct.pack("<Q", len(body)) + body


def zeros(size, stated=True):
    """Return so many zeros as zstd, with their number in its head or without."""
    packer = zstandard.ZstdCompressor().compressobj(size=size if stated else -1)
    return b"".join(packer.compress(bytes(MIB)) for _ in range(size // MIB)) + packer.flush()


def put_in_front(path, record):
    data = path.read_bytes()
    (_, _, behind), *_ = records(data)
    path.write_bytes(data[:behind] + record + data[behind:])
    return behind


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("claim", [512 * MIB, 1 * MIB, 0])
def test_a_chunk_that_swells_is_told_and_not_unpacked(tmp_path, stated, claim):
    path = write(tmp_path / "a.mcap", ROWS)
    packed = zeros(512 * MIB, stated)
    at = put_in_front(path, chunk(b"", size=claim, packed=packed, crc=0))
    with at_most(40):
        bag = Bag(path)
    if claim != MIB:
        # It says that it is empty, and is taken at its word; or is passed over.
        assert not bag.damage and len(list(bag.items(INPUTS))) == len(ROWS)
        told = (
            "skipped: a chunk of 512 MiB unpacked, more than the 64 MiB that --max-chunk allows, "
            "with the messages in it (none and more); the rest is read, and with --max-chunk 513 "
            "all"
        )
        assert bag.remarks(INPUTS) == ([told] if claim else [])
        return
    assert bag.damage.startswith(f"{path} is damaged at byte {at}: ") and not bag.count
    with pytest.raises(BagError, match=f"holds no messages; {path} is damaged at byte {at}"):
        bag.require(INPUTS)


def test_a_chunk_in_lz4_that_swells(tmp_path):
    import lz4.frame

    path = write(tmp_path / "a.mcap", ROWS)
    packed = lz4.frame.compress(bytes(256 * MIB))
    put_in_front(path, chunk(b"", b"lz4", size=MIB, packed=packed, crc=0))
    with at_most(40):
        assert "does not end after the 1048576 bytes that it states" in Bag(path).damage


def test_the_bound_of_a_chunk_can_be_chosen(tmp_path):
    path = write(tmp_path / "a.mcap", ROWS, chunk_size=40_000)
    bag = Bag(path, most_chunk=20_000)
    told = "skipped: 2 chunks of up to 0.0"
    assert not bag.damage and not bag.count and bag.skipped[0].startswith(told)
    with pytest.raises(BagError, match=f"holds no messages; {told}.* and with --max-chunk 2 all"):
        bag.require(INPUTS)
    bag = Bag(path, most_chunk=80_000)
    assert not bag.damage and len(list(bag.items(INPUTS))) == len(ROWS)


def with_points(path, count=1, **options):
    """Write ROWS, and behind the first of each topic messages of 3 MiB on another topic."""
    with writer(path, **options) as add:
        for i, row in enumerate(ROWS):
            for _ in range(count if i == 10 else 0):
                add(Row("/points", row.log_ns, bytes(3 * MIB)), "std_msgs/msg/String")
            add(row)
    return path


@pytest.mark.parametrize("compression", CompressionType)
def test_a_chunk_that_is_too_large_is_passed_over_with_what_it_holds(tmp_path, compression):
    """Topics that are declared in it are known behind it, and what it holds is counted."""
    path = with_points(tmp_path / "a.mcap", chunk_size=20_000, compression=compression)
    with at_most(20):
        bag = Bag(path, most_chunk=2 * MIB)
        assert not bag.damage and len(list(bag.items(INPUTS))) == len(ROWS) - 10
    (told,) = bag.skipped
    assert told.startswith("skipped: a chunk of 3.0")
    assert "the messages in it (/joint_states 4, /points 1, /wrench 6); the rest is read" in told
    assert told.endswith(", and with --max-chunk 5 all")
    whole = Bag(path, most_chunk=5 * MIB)
    assert not whole.skipped and len(list(whole.items(INPUTS))) == len(ROWS)


def test_records_that_are_too_large_are_passed_over(tmp_path):
    path = with_points(tmp_path / "a.mcap", 3, use_chunking=False, enable_data_crcs=True)
    bag = Bag(path, most_chunk=2 * MIB)
    assert not bag.damage and len(list(bag.items(INPUTS))) == len(ROWS)
    assert bag.remarks(INPUTS) == [
        "skipped: 3 records of up to 3.00002 MiB on /points, more than the 2 MiB that --max-chunk "
        "allows; the rest is read"
    ]
    # Their bytes count in the checksum of the data, which shows a fault in them.
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    assert "the data section does not fit its checksum" in Bag(path, most_chunk=2 * MIB).damage


def test_messages_that_swell_are_bounded_together(tmp_path):
    bomb = zeros(40 * MIB)
    rows = [Row("/wrench", i, bomb) for i in range(20)]
    with at_most(150):
        bag = Bag(write(tmp_path / "a.mcap", rows))
        assert "more than the 64 MiB that --max-chunk allows" in bag.damage


@pytest.mark.parametrize("front", [b"", b"\x89MCAP0\r\n"])
def test_a_file_that_swells(tmp_path, front):
    # Zeros are records of a kind that there is none of; an attachment may have any length.
    path = tmp_path / "a.mcap.zstd"
    head = front + (b"\x09" + struct.pack("<Q", 1 << 40) if front else b"")
    packer = zstandard.ZstdCompressor().compressobj()
    parts = [packer.compress(head), *(packer.compress(bytes(MIB)) for _ in range(1024))]
    path.write_bytes(b"".join(parts) + packer.flush())
    with at_most(60):
        if front:
            assert "unpacks to more than 1000 times its size" in Bag(path).damage
        else:
            with pytest.raises(BagError, match="is not an MCAP file"):
                Bag(path)


def test_zeros_are_no_records(tmp_path):
    path = tmp_path / "a.mcap"
    path.write_bytes(b"\x89MCAP0\r\n" + bytes(1000))
    assert Bag(path).damage == f"{path} is damaged at byte 8: a record of kind 0, of zeros alone"


@pytest.mark.parametrize("length", [1 << 62, 200 * MIB])
def test_a_record_that_states_an_absurd_length(tmp_path, length):
    path = write(tmp_path / "a.mcap", ROWS)
    with path.open("r+b") as stream:
        stream.seek(17 + int.from_bytes(path.read_bytes()[9:17], "little"))
        at = stream.tell()
        stream.write(b"\x05" + struct.pack("<Q", length))
        stream.truncate(at + 9 + 200 * MIB)  # a file with a hole
    with at_most(20):
        damage = Bag(path).damage
    assert str(at) in damage or "cut off" in damage


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.ZSTD])
def test_a_chunk_that_was_cut_out_whole_is_told(tmp_path, compression):
    whole = write(tmp_path / "w.mcap", ROWS, chunk_size=9000, compression=compression)
    data = whole.read_bytes()
    assert not Bag(whole).damage
    chunks = [(at, end) for at, kind, end in records(data) if kind == Opcode.CHUNK]
    at, end = chunks[2]
    path = tmp_path / "a.mcap"
    path.write_bytes(data[:at] + data[end:])
    bag = Bag(path)
    lost = len(ROWS) - bag.count
    assert lost > 20 and len(list(bag.items(INPUTS))) == bag.count
    assert f"{path} is damaged: {lost} of 600 messages that its index counts are not" in bag.damage
    assert bag.damage.endswith("): a part was cut out")
    # Two that changed places lose nothing.
    (a, b), (c, d) = chunks[1], chunks[3]
    path.write_bytes(data[:a] + data[c:d] + data[b:c] + data[a:b] + data[d:])
    bag = Bag(path)
    assert not bag.damage
    assert [i.log_ns for i in bag.items(INPUTS)] == [row.log_ns for row in ROWS]


def test_descriptions_that_swell_or_nest(tmp_path):
    names = "abcdefghij"
    growing = ["a: &a [" + ",".join("x" * 9) + "]"]
    growing += [f"{b}: &{b} [" + ",".join([f"*{a}"] * 9) + "]" for a, b in zip(names, names[1:])]
    top = "rosbag2_bagfile_information:\n"
    write(tmp_path / "a.mcap", ROWS)
    description = tmp_path / "metadata.yaml"
    for text in (
        "[" * 3000,
        top + "  x: " + "[" * 3000 + "]" * 3000 + "\n  relative_file_paths: [a.mcap]",
        top + "  version: .inf\n  relative_file_paths: [a.mcap]",
        top + "  version: !!timestamp x\n  relative_file_paths: [a.mcap]",
        top + "  version: !!int ''\n  relative_file_paths: [a.mcap]",
        top + "  relative_file_paths: [[a.mcap]]",
        "\n".join(growing) + "\n" + top + "  relative_file_paths: *j",
        "\n".join(growing) + "\n" + top + "  version: *j\n  relative_file_paths: [a.mcap]",
    ):
        description.write_text(text)
        with at_most(40), pytest.raises(BagError) as caught:
            Bag(tmp_path)
        assert str(caught.value) == (
            f"{description} is not a description of a bag (rosbag2_bagfile_information with "
            f"relative_file_paths); remove it to read the files of {tmp_path}"
        )
    # An alias alone is no harm.
    description.write_text("x: &x a.mcap\n" + described("*x"))
    assert Bag(tmp_path).count == len(ROWS)
    description.write_text(described("a.mcap") + "#" * (5 << 20))
    with pytest.raises(BagError, match="metadata.yaml has .* bytes, a description at most"):
        Bag(tmp_path)
