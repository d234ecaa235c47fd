#!/usr/bin/env python3
"""
Messages read a second: this package's batches beside rosbags and mcap-ros2-support, in one run.

    python -m benchmarks.cost.reading [--seconds 60] [--repeat 3]

A bag of 1 kHz wrenches and 500 Hz joint states is made in a temporary folder. Each reader gives
the stamps and numbers of all messages; their sums have to agree. Readers take turns, and the
least processor time of each counts: others may share the machine.
"""

import argparse
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from benchmarks.cost.hour import memory
from benchmarks.cost.turns import in_turns
from peg_on_hole_ros.bags.batch import stretches
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.definitions import definition
from peg_on_hole_ros.messages.plain import header, xyz

TYPES = {"/wrench": WRENCH_TYPE, "/joint_states": JOINTS_TYPE}
PERIOD_NS = 1_000_000


def write(path: Path, count: int) -> int:
    """Write so many wrenches, and half as many joint states of seven joints; return how many."""
    rng = np.random.default_rng(1)
    names = [f"arm_{i}" for i in range(7)]
    encode = {topic: Encoder(kind) for topic, kind in TYPES.items()}
    total = 0
    with path.open("wb") as stream:
        bag = Writer(stream, compression=CompressionType.ZSTD)
        bag.start(profile="ros2")
        channels = {
            topic: bag.register_channel(
                topic, "cdr", bag.register_schema(kind, "ros2msg", definition(kind).encode())
            )
            for topic, kind in TYPES.items()
        }

        def add(topic, t_ns, message):
            data = encode[topic]({"header": header(t_ns, "tool0"), **message})
            bag.add_message(channels[topic], t_ns, data, t_ns)

        for i in range(count):
            t_ns = 10**18 + i * PERIOD_NS
            six = rng.normal(size=6)
            if i % 2 == 0:
                zeros = [0.0] * 7
                state = {"name": names, "position": rng.normal(size=7).tolist()}
                add("/joint_states", t_ns, state | {"velocity": zeros, "effort": zeros})
                total += 1
            add("/wrench", t_ns, {"wrench": {"force": xyz(six[:3]), "torque": xyz(six[3:])}})
            total += 1
        bag.finish()
    return total


def batches(path: Path) -> float:
    """Read as arrays; every checksum is verified, and the order is that of log times."""
    total = 0.0
    for batch in Bag(path).batches(TYPES):
        for topic in TYPES:
            for _, found in stretches(batch, topic):
                total += found.values.sum() + (found.t_ns * 1e-9).sum()
    return total


def samples(path: Path) -> float:
    """Read as batches, then message by message."""
    total = 0.0
    for item in Bag(path).items(TYPES):
        sample = item.sample
        total += sample.t_ns * 1e-9
        total += sum(sample.position) if item.topic == "/joint_states" else sum(sample.force)
        total += 0.0 if item.topic == "/joint_states" else sum(sample.torque)
    return total


def with_rosbags(path: Path) -> float:
    """Read by rosbags, its typestore prepared."""
    store, total = get_typestore(Stores.ROS2_JAZZY), 0.0
    with Reader(path) as reader:
        for connection, _, data in reader.messages():
            message = store.deserialize_cdr(data, connection.msgtype)
            total += _sum(connection.topic, message)
    return total


def with_mcap(path: Path) -> float:
    """Read by mcap and mcap-ros2-support."""
    total = 0.0
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            total += _sum(channel.topic, message)
    return total


def _sum(topic, message):
    stamp = message.header.stamp
    seconds = (stamp.sec * 10**9 + stamp.nanosec) * 1e-9
    if topic == "/joint_states":
        return seconds + float(sum(message.position))
    f, m = message.wrench.force, message.wrench.torque
    return seconds + f.x + f.y + f.z + m.x + m.y + m.z


READERS = {
    "batches": batches,
    "batches, message by message": samples,
    "rosbags": with_rosbags,
    "mcap, mcap-ros2-support": with_mcap,
}


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--seconds", type=int, default=60, help="length of the bag")
    parser.add_argument("--repeat", type=int, default=3, help="turns of each reader")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.mcap"
        count = write(path, given.seconds * 1000)
        print(f"{count} messages, {path.stat().st_size / 2**20:.1f} MiB")
        ways = {name: partial(read, path) for name, read in READERS.items()}
        turns = in_turns(ways, given.repeat)
    for name in READERS:
        if not np.isclose(turns.results[name], turns.results["rosbags"], rtol=1e-9):
            raise SystemExit(f"{name} reads other numbers than rosbags")
        seconds = turns.least(name)
        times = turns.least("rosbags") / seconds
        print(f"{name:28} {count / seconds:10.0f} messages/s {times:6.1f} times rosbags")
    print(f"maximum resident set of all: {memory():.0f} MiB")


if __name__ == "__main__":
    main()
