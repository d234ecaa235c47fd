#!/usr/bin/env python3
"""
Damaged copies of a bag: what `replay` and `inspect` make of each, in what time and memory.

    python -m benchmarks.mutated_bags [--count 1000] [--seed 1] [--only KIND]

Each copy is read in a process of its own with a bound of memory and time. It has to end with a
documented exit code, with one line of error where that is not 0, within 10 s and 500 MB.
"""

import argparse
import contextlib
import json
import os
import random
import resource
import signal
import struct
import sys
import tempfile
import time
import zlib
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import lz4.frame
import zstandard
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer
from rosbags.typesys import Stores, get_typestore

from peg_on_hole_ros.cli.main import main as command_line

SAMPLE = Path(__file__).parents[1] / "bags" / "closing_with_slip.mcap"
DOCUMENTED = (0, 2, 3, 4)
MOST_SECONDS = 10
MOST_MEMORY = 500_000_000
MIB = 1 << 20
# Records of MCAP: opcode, length of what follows.
HEAD = struct.Struct("<BQ")
MAGIC = 8
SCHEMA, CHANNEL, MESSAGE, CHUNK, CHUNK_INDEX = 0x03, 0x04, 0x05, 0x06, 0x08
MESSAGE_INDEX, STATISTICS, METADATA, DATA_END = 0x07, 0x0B, 0x0C, 0x0F
ABSURD = (0, 1, 1 << 31, (1 << 32) - 1, 1 << 40, (1 << 63) - 1, (1 << 64) - 1)


class Record(NamedTuple):
    """A record of a file: where it begins, what it is, where it ends."""

    begin: int
    opcode: int
    end: int


def records(data: bytes, at: int = MAGIC, end: int | None = None) -> list[Record]:
    """Return the records of a whole file, or of what a chunk holds from 0 on."""
    found, end = [], len(data) - MAGIC if end is None else end
    while at < end:
        opcode, length = HEAD.unpack_from(data, at)
        found.append(Record(at, opcode, at + HEAD.size + length))
        at = found[-1].end
    return found


def record(opcode: int, body: bytes) -> bytes:
    """Return a record."""
    return HEAD.pack(opcode, len(body)) + body


def chunk(content: bytes, compression: str, packed: bytes, size: int | None = None) -> bytes:
    """Return a chunk with the checksum of what it holds."""
    size = len(content) if size is None else size
    name = compression.encode()
    head = struct.pack("<QQQI", 0, 1 << 62, size, zlib.crc32(content)) + _text(name)
    return record(CHUNK, head + struct.pack("<Q", len(packed)) + packed)


def _text(text):
    return struct.pack("<I", len(text)) + text


def unpacked(data: bytes, place: Record) -> tuple[bytes, str]:
    """Return what a chunk holds, and how it is packed."""
    at = place.begin + HEAD.size + 28
    (length,) = struct.unpack_from("<I", data, at)
    name = data[at + 4 : at + 4 + length].decode()
    body = data[at + 4 + length + 8 : place.end]
    if name == "zstd":
        body = zstandard.ZstdDecompressor().decompressobj().decompress(body)
    elif name == "lz4":
        body = lz4.frame.decompress(body)
    return body, name


def packed(content: bytes, name: str) -> bytes:
    """Return what a chunk's compression makes of its content."""
    if name == "zstd":
        return zstandard.ZstdCompressor().compress(content)
    return lz4.frame.compress(content) if name == "lz4" else content


def of(data: bytes, *opcodes: int) -> list[Record]:
    """Return the records of some kinds."""
    return [each for each in records(data) if each.opcode in opcodes]


def put(data: bytes, begin: int, end: int, new: bytes) -> bytes:
    """Return the data with a part of it replaced."""
    return data[:begin] + new + data[end:]


# What a copy suffers; each takes the generator and the bytes, and returns other bytes.


def bits(rng: random.Random, data: bytes) -> bytes:
    """Turn over one to 64 bits anywhere."""
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 8, 64))):
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def cut(rng: random.Random, data: bytes) -> bytes:
    """End anywhere."""
    return data[: rng.randrange(len(data))]


def hole(rng: random.Random, data: bytes) -> bytes:
    """Leave a piece out, as a disk that was full in between."""
    begin = rng.randrange(len(data))
    return put(data, begin, begin + rng.randrange(1, 4096), b"")


def rubbish(rng: random.Random, data: bytes) -> bytes:
    """Write zeros, ones or noise over a piece, or in between."""
    begin, length = rng.randrange(len(data)), rng.randrange(1, 2048)
    noise = rng.choice((bytes(length), b"\xff" * length, rng.randbytes(length)))
    return put(data, begin, begin + rng.choice((0, length)), noise)


def swapped(rng: random.Random, data: bytes) -> bytes:
    """Change places of two records; chunks mostly."""
    chunks = of(data, CHUNK)
    places = chunks if chunks and rng.random() < 0.7 else records(data)
    first, second = sorted(rng.sample(places, 2))
    changed = put(data, second.begin, second.end, data[first.begin : first.end])
    return put(changed, first.begin, first.end, data[second.begin : second.end])


def repeated(rng: random.Random, data: bytes) -> bytes:
    """Have a record twice, or not at all."""
    place = rng.choice(of(data, CHUNK, MESSAGE) if rng.random() < 0.7 else records(data))
    return put(data, place.begin, place.end, data[place.begin : place.end] * rng.choice((0, 2)))


def without_index(rng: random.Random, data: bytes) -> bytes:
    """Leave out what a reader may find its way by, or have it point elsewhere."""
    end = next(each.end for each in records(data) if each.opcode == DATA_END)
    kind = rng.randrange(4)
    if kind == 0:
        return data[:end]
    if kind == 1:
        return put(data, end, len(data), rng.randbytes(rng.randrange(200)))
    gone = {(MESSAGE_INDEX,), (CHUNK_INDEX,), (STATISTICS,), (MESSAGE_INDEX, CHUNK_INDEX)}
    for place in reversed(of(data, *rng.choice(sorted(gone)))):
        new = b""
        if kind == 3:
            body = bytearray(data[place.begin + HEAD.size : place.end])
            if body:
                body[rng.randrange(len(body))] ^= 0xFF
            new = record(place.opcode, bytes(body))
        data = put(data, place.begin, place.end, new)
    return data


def lengths(rng: random.Random, data: bytes) -> bytes:
    """State an absurd length of a record or of a part of one, or another opcode."""
    place = rng.choice(records(data))
    if rng.random() < 0.2:
        return put(data, place.begin, place.begin + 1, bytes([rng.randrange(256)]))
    if rng.random() < 0.5:
        return put(data, place.begin + 1, place.begin + 9, _number(rng, 8))
    width = rng.choice((4, 8))
    at = place.begin + HEAD.size + rng.randrange(max(1, min(64, place.end - place.begin - 9)))
    return put(data, at, at + width, _number(rng, width))


def _number(rng, width):
    return (rng.choice(ABSURD) & (1 << 8 * width) - 1).to_bytes(width, "little")


def bomb(rng: random.Random, data: bytes) -> bytes:
    """Put a chunk in that swells, or states that it does."""
    name = rng.choice(("zstd", "lz4"))
    size = rng.choice((70, 256, 1024)) * MIB
    if name == "zstd":
        stated = rng.choice((size, -1))
        packer = zstandard.ZstdCompressor().compressobj(size=stated)
    else:
        packer = lz4.frame.LZ4FrameCompressor()
        swollen = [packer.begin(rng.choice((size, 0)))]
    piece = bytes(MIB)
    pieces = [packer.compress(piece) for _ in range(size // MIB)] + [packer.flush()]
    swollen = b"".join(pieces if name == "zstd" else swollen + pieces)
    place = rng.choice(records(data))
    claim = rng.choice((size, 0, 1000, (1 << 63) - 1))
    return put(data, place.begin, place.begin, chunk(b"", name, swollen, claim))


def within(rng: random.Random, data: bytes) -> bytes:
    """Spoil what a chunk holds, its checksum right: what a recorder with a fault writes."""
    places = of(data, CHUNK)
    if not places:
        return payload(rng, data)
    place = rng.choice(places)
    content, name = unpacked(data, place)
    change = rng.choice((bits, cut, hole, rubbish, _inner_length, payload))
    content = change(rng, content)
    return put(data, place.begin, place.end, chunk(content, name, packed(content, name)))


def _inner_length(rng, content):
    place = rng.choice(records(content, 0, len(content)))
    at = place.begin + rng.choice((0, 1, 9, 11, 15))
    width = rng.choice((1, 4, 8))
    return put(content, at, at + width, _number(rng, width))


def payload(rng: random.Random, data: bytes) -> bytes:
    """Put absurd numbers into messages: lengths of arrays and texts, stamps, forces."""
    inside = not data.startswith(b"\x89MCAP")
    places = records(data, 0, len(data)) if inside else records(data)
    places = [each for each in places if each.opcode == MESSAGE]
    for _ in range(rng.choice((1, 1, 10, 100))):
        if not places:
            break
        place = rng.choice(places)
        body = place.begin + HEAD.size + 22
        if place.end - body < 12:
            continue
        at = body + 4 * rng.randrange((place.end - body) // 4)
        value = rng.choice(
            (
                _number(rng, 4),
                struct.pack("<d", rng.choice((float("nan"), float("inf"), -1e308, 1e-320))),
                rng.randbytes(4),
            )
        )
        data = put(data, at, at + len(value), value)
    return data


def texts(rng: random.Random, data: bytes) -> bytes:
    """Have other definitions, topics and metadata."""
    place = rng.choice(of(data, SCHEMA, CHANNEL, METADATA))
    body = data[place.begin + HEAD.size : place.end]
    if place.opcode == SCHEMA and rng.random() < 0.7:
        text = rng.choice(
            (
                b"float64[1000000000] x\n",
                b"std_msgs/Header[] header\n",
                b"a/B b\n" + b"=" * 80 + b"\nMSG: a/B\na/B b\n",
                b"string<=18446744073709551616 name\n",
                b"\xff\xfe\x00",
                b"int32 x" * 20_000,
                b"[" * 5000,
                b"",
            )
        )
        head = body[:2] + _text(b"geometry_msgs/msg/WrenchStamped") + _text(b"ros2msg")
        return put(data, place.begin, place.end, record(SCHEMA, head + _text(text)))
    return put(data, place.begin, place.end, record(place.opcode, rubbish(rng, body)))


KINDS: dict[str, Callable[[random.Random, bytes], bytes]] = {
    each.__name__.strip("_"): each
    for each in (
        bits, cut, hole, rubbish, swapped, repeated, without_index, lengths, bomb, within,
        payload, texts,
    )
}  # fmt: skip
# Those that need no records.
ANYWHERE = ("bits", "cut", "hole", "rubbish")


def whole_bags(folder: Path) -> dict[str, tuple[str, bytes]]:
    """Return copies of the sample in several forms, by name, each with its suffix and bytes."""
    found = {}
    for compression in (CompressionType.ZSTD, CompressionType.LZ4, CompressionType.NONE):
        copy = _copied(folder, compression=compression, chunk_size=8000)
        found[compression.name.lower()] = (".mcap", copy)
    found["no chunks"] = (".mcap", _copied(folder, use_chunking=False))
    found["packed"] = (".mcap.zstd", zstandard.ZstdCompressor().compress(found["none"][1]))
    found["sqlite"] = (".db3", _in_sqlite(folder))
    return found


def _copied(folder, **options):
    path = folder / "copy.mcap"
    with SAMPLE.open("rb") as source, path.open("wb") as target:
        bag = Writer(target, **options)
        bag.start(profile="ros2")
        channels = {}
        reader = make_reader(source)
        for metadata in reader.iter_metadata():
            bag.add_metadata(metadata.name, metadata.metadata)
        for schema, channel, message in reader.iter_messages():
            if channel.topic not in channels:
                number = bag.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = bag.register_channel(channel.topic, "cdr", number)
            number = channels[channel.topic]
            bag.add_message(number, message.log_time, message.data, message.publish_time)
        bag.finish()
    return path.read_bytes()


def _in_sqlite(folder):
    store, connections = get_typestore(Stores.ROS2_JAZZY), {}
    with (
        SAMPLE.open("rb") as source,
        Rosbag2Writer(folder / "sqlite", version=9, storage_plugin=StoragePlugin.SQLITE3) as bag,
    ):
        for schema, channel, message in make_reader(source).iter_messages():
            if schema.name not in store.types:
                continue
            if channel.topic not in connections:
                added = bag.add_connection(channel.topic, schema.name, typestore=store)
                connections[channel.topic] = added
            bag.write(connections[channel.topic], message.log_time, message.data)
    return next((folder / "sqlite").glob("*.db3")).read_bytes()


def mutated(
    wholes: dict[str, tuple[str, bytes]], kind: str, seed: int
) -> tuple[str, str, bytes, bytes]:
    """Return the form that a copy has, its suffix, its bytes, and those that were whole."""
    rng = random.Random(f"{kind} {seed}")
    forms = list(wholes)
    if kind not in ANYWHERE:
        forms = [name for name in forms if wholes[name][0] == ".mcap"]
    form = rng.choice(forms)
    suffix, whole = wholes[form]
    return form, suffix, KINDS[kind](rng, whole), whole


class Outcome(NamedTuple):
    """
    What became of a command.

    Attributes
    ----------
    code : int
        Exit code; below zero: the signal that ended it.
    seconds : float
    memory : int
        Most that it had resident [bytes].
    said : str
        What it printed to stderr.

    """

    code: int
    seconds: float
    memory: int
    said: str

    def fault(self) -> str:
        """Return what is wrong with it; empty: nothing."""
        lines = self.said.splitlines()
        if self.code == -signal.SIGALRM or self.seconds > MOST_SECONDS:
            return f"not done after {MOST_SECONDS} s"
        if self.code not in DOCUMENTED:
            return f"ended with {self.code}: {' '.join(lines[-1:])}"
        if self.memory > MOST_MEMORY or "not enough memory" in self.said:
            return f"took {self.memory / 1e6:.0f} MB: {' '.join(lines[-1:])}"
        errors = sum(line.startswith("peg-on-hole: error: ") for line in lines)
        if "Traceback" in self.said or errors != bool(self.code):
            return f"{errors} errors at exit code {self.code}: {' | '.join(lines[:3])}"
        return ""


def ended(arguments: list[str], folder: Path) -> Outcome:
    """Run a command in a child process with bounds of memory and time."""
    said = folder / "stderr.txt"
    begun = time.monotonic()
    child = os.fork()
    if not child:
        code = 70
        try:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.alarm(MOST_SECONDS)
            pages = int(Path("/proc/self/statm").read_text().split()[0])
            bound = pages * resource.getpagesize() + MOST_MEMORY
            resource.setrlimit(resource.RLIMIT_AS, (bound, bound))
            for number, path in ((1, os.devnull), (2, said)):
                file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
                os.dup2(file, number)
            code = command_line(arguments)
        except SystemExit as ending:
            code = ending.code if isinstance(ending.code, int) else 70
        finally:
            with contextlib.suppress(Exception):
                sys.stderr.flush()
            os._exit(code)
    _, status, usage = os.wait4(child, 0)
    seconds = time.monotonic() - begun
    text = said.read_text(errors="replace")
    return Outcome(os.waitstatus_to_exitcode(status), seconds, usage.ru_maxrss * 1024, text)


def commands(bag: Path, folder: Path) -> Iterator[tuple[str, list[str]]]:
    """Yield the commands that read a bag."""
    out, summary = folder / "out.mcap", folder / "summary.json"
    yield "replay", ["replay", str(bag), "--out", str(out), "--summary", str(summary)]
    yield "inspect", ["inspect", str(bag), "--json"]


def untold(folder: Path, whole: int) -> bool:
    """Return whether a replay that says nothing of damage has read less than there was."""
    content = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return content["damage"] is None and content["messages"]["read"] < whole


def main() -> int:
    """Print a table of outcomes; return 1 where one is none of the documented ones."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--count", type=int, default=1000, help="copies (1000)")
    parser.add_argument("--seed", type=int, default=1, help="of the first (1)")
    parser.add_argument("--only", choices=KINDS, help="damage of one kind alone")
    given = parser.parse_args()
    kinds = [given.only] if given.only else list(KINDS)
    codes, worst, faults, silent = defaultdict(Counter), defaultdict(lambda: (0.0, 0)), [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wholes = whole_bags(folder)
        sound = {}
        for form, (suffix, data) in wholes.items():
            # All that is loaded and compiled once is so in this process, and its children have it.
            path = folder / f"whole{suffix}"
            path.write_bytes(data)
            with open(os.devnull, "w") as nothing, contextlib.redirect_stdout(nothing):
                for what, arguments in commands(path, folder):
                    if code := command_line(arguments):
                        raise SystemExit(f"{what} of the whole bag, {form}: exit code {code}")
            content = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
            sound[form] = content["messages"]["read"]
        for i in range(given.count):
            kind, seed = kinds[i % len(kinds)], given.seed + i // len(kinds)
            form, suffix, data, _ = mutated(wholes, kind, seed)
            path = folder / f"copy{suffix}"
            path.write_bytes(data)
            for what, arguments in commands(path, folder):
                outcome = ended(arguments, folder)
                if outcome.fault():
                    # What was compiled on the way is kept: the second time tells of the bag alone.
                    outcome = ended(arguments, folder)
                codes[kind][outcome.code] += 1
                seconds, memory = worst[kind]
                worst[kind] = max(seconds, outcome.seconds), max(memory, outcome.memory)
                if fault := outcome.fault():
                    faults.append(f"{kind}, seed {seed}, {form}, {what}: {fault}")
                elif what == "replay" and not outcome.code and untold(folder, sound[form]):
                    silent.append(f"{kind}, seed {seed}, {form}: fewer messages, and nothing said")
    columns = sorted({*DOCUMENTED, *(code for each in codes.values() for code in each)})
    print("| damage | " + " | ".join(map(str, columns)) + " | longest [s] | most memory [MB] |")
    print("|---" * (len(columns) + 3) + "|")
    for kind in codes:
        counts = " | ".join(str(codes[kind][code]) for code in columns)
        seconds, memory = worst[kind]
        print(f"| {kind} | {counts} | {seconds:.1f} | {memory / 1e6:.0f} |")
    for line in (*faults, *silent):
        print(line)
    print(f"{given.count} copies, {len(faults)} faults, {len(silent)} losses that were not told")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
