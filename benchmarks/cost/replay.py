"""
How many times faster than real time a recording is replayed, and in how much memory.

    python -m benchmarks.cost.replay [--seconds 300] [--repetitions 3] [--out FOLDER]

The shipped working cycle is played again and again into one recording: wrenches at 1 kHz, joint
states at 500 Hz, packed by zstd, without its truth. Printed are the processor's seconds of reading
alone, of a replay with its summary, of one that writes all topics, of one with a report, and one
whose joint states come 1.8 ms behind their wrenches, each in a process of its own, which has its
compiled code at hand; the medians of the recording's length over them; and the most memory that
each took.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import CONFIGURATION_METADATA, BagWriter
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.plain import header, xyz
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.replay.run import sources_of, stored_configuration

ROOT = Path(__file__).parents[2]
SAMPLE = ROOT / "bags" / "working_cycle.mcap"
# Between the end of one cycle and the begin of the next [ns].
STEP_NS = 1_000_000
# By so much joint states come late, where they do [ns].
LATE_NS = 1_800_000
_SUMMARY = "replay(bag, configuration, NodeOptions())"
_TASKS = {
    "reading": "for batch in bag.batches(check_bag(bag, configuration)): pass",
    "summary": _SUMMARY,
    "all topics": "replay(bag, configuration, NodeOptions(), {out!r})",
    "report": "replay(bag, configuration, NodeOptions(), None, {out!r})",
    "late": _SUMMARY,
}
_PROGRAM = """
import resource, time
import peg_on_hole_ros
from peg_on_hole_ros.cli.replay import replay
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.replay.run import check_bag, stored_configuration
from peg_on_hole_ros.messages.warm_up import warm
from peg_on_hole_ros.config.options import NodeOptions
configuration = stored_configuration(Bag({path!r}))
warm(configuration)
begun = time.process_time()
bag = Bag({path!r})
{task}
seconds = time.process_time() - begun
print(seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


def lengthened(path: Path, seconds: float, late_ns: int = 0) -> tuple[float, int]:
    """
    Write the working cycle over and over, its joint states late by so much [ns].

    Return how long that lasts [s], and its messages.
    """
    bag = Bag(SAMPLE)
    configuration = stored_configuration(bag)
    sources = sources_of(configuration)
    items = [
        (item.topic, item.sample, item.sample.t_ns + late_ns * (type(item.sample) is JointSample))
        for item in _items(bag, sources)
    ]
    items.sort(key=lambda item: item[2])
    first, last = items[0][2], items[-1][2]
    period, count = last - first + STEP_NS, 0
    metadata = {CONFIGURATION_METADATA: bag.metadata[CONFIGURATION_METADATA]}
    cycles = max(round(seconds * 1e9 / period), 1)
    with BagWriter(path, metadata=metadata) as writer:
        for cycle in range(cycles):
            for topic, sample, log_ns in items:
                message = _message(sample, sample.t_ns + cycle * period)
                writer.write(topic, *message, log_ns + cycle * period)
                count += 1
    return cycles * period * 1e-9, count


def _items(bag, sources):
    types = {topic: bag.topics[topic].types[0] for topic in sources}
    return [item for batch in bag.batches(types) for item in batch.items()]


def _message(sample, t_ns):
    if isinstance(sample, WrenchSample):
        wrench = {"force": xyz(sample.force), "torque": xyz(sample.torque)}
        return WRENCH_TYPE, {"header": header(t_ns, "sensor"), "wrench": wrench}
    names, position = list(sample.names), list(sample.position)
    return JOINTS_TYPE, {"header": header(t_ns, ""), "name": names, "position": position}


def main(arguments=None) -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(dir=options.out) as folder:
        path, late, out = (Path(folder) / name for name in ("in.mcap", "late.mcap", "out.mcap"))
        length, messages = lengthened(path, options.seconds)
        lengthened(late, options.seconds, LATE_NS)
        print(f"{length:.0f} s, {messages} messages, {path.stat().st_size / 1e6:.1f} MB")
        print(f"{'':12s}{'CPU [s]':>9s}{'times real time':>17s}{'messages/s':>12s}{'MB':>7s}")
        for name, task in _TASKS.items():
            source = str(late if name == "late" else path)
            program = _PROGRAM.format(path=source, task=task.format(out=str(out)))
            found = [tuple(map(float, _run(program).split())) for _ in range(options.repetitions)]
            spent = median(seconds for seconds, _ in found)
            most = max(megabytes for _, megabytes in found)
            rate = messages / spent
            print(f"{name:12s}{spent:9.2f}{length / spent:17.1f}{rate:12.0f}{most:7.0f}")
    return 0


def _run(program):
    return subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    ).stdout.splitlines()[-1]


if __name__ == "__main__":
    sys.exit(main())
