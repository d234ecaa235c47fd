#!/usr/bin/env python3
"""
What the node costs over DDS at 1 kHz, beside a bare node of rclpy that publishes as much.

    python -m benchmarks.cost.node_cost [--seconds 60] [--turns 1] [--rate 1000]

Wrenches at 1 kHz and joint states at half of it, stamped as they are sent, go to the node, then
to one that takes the same bytes and answers each wrench with outputs that are prepared: what is
between them is the package's own. A listener of its own process has all outputs. Of each node:
time of the processor for a wrench that it answers, time from the stamp of a wrench until its
`state` is given to DDS, and wrenches without one. What is lost costs a node nothing, so nothing
is divided by it.
"""

import argparse
import inspect
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.config.parameters_file import write_parameters
from peg_on_hole_ros.messages.beside_estimates import (
    DIAGNOSTICS,
    LATCHED,
    PREFIX,
    TOPICS,
    UNSTAMPED,
)
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.replay.run import stored_configuration
from peg_on_hole_ros.ros.local_dds import environment, free_domain

BAG = Path(__file__).parents[2] / "bags" / "working_cycle.mcap"
INPUTS = {"/wrench": WRENCH_TYPE, "/joint_states": JOINTS_TYPE}
STATE = PREFIX + "state"
OUTPUTS = {PREFIX + suffix: kind for suffix, kind in TOPICS.items()}
OUTPUTS |= {"/diagnostics": DIAGNOSTICS}
WITHOUT_STAMP = {PREFIX + suffix for suffix in (*UNSTAMPED, "markers")}
DEPTH = 200
# What is sent first may come before a reader is known, and is not measured.
WARM_UP = 2.0  # [s]
NODE = ["-m", "peg_on_hole_ros.ros.node", "--ros-args", "--params-file"]
PATIENCE = 300.0  # [s]
TWO = inspect.signature(lambda payload, known: None)


class Turn(NamedTuple):
    """
    What one node did with all wrenches.

    Attributes
    ----------
    cpu : float
        Time of its process for a wrench that has a state [s].
    ages : list of float
        From the stamp of each wrench until its state was given to DDS [s].
    lost : int
        Wrenches without a state.
    outputs : float
        Messages that were published for each state.

    """

    cpu: float
    ages: list[float]
    lost: int
    outputs: float


def stamped(payload: bytes, t_ns: int) -> bytes:
    """Return a serialised message that begins with a header, with another stamp."""
    seconds, nanoseconds = divmod(t_ns, 1_000_000_000)
    both = seconds.to_bytes(4, "little") + nanoseconds.to_bytes(4, "little")
    return payload[:4] + both + payload[12:]


def stamp_ns(payload: bytes) -> int:
    """Return the stamp of a serialised message that begins with a header [ns]."""
    seconds, nanoseconds = (int.from_bytes(payload[at : at + 4], "little") for at in (4, 8))
    return seconds * 1_000_000_000 + nanoseconds


def recorded() -> list[tuple[bytes, bytes | None]]:
    """Return the bag's wrenches, each with the joint state that comes with it."""
    found, joints = [], None
    for message, payload in Bag(BAG).with_payloads(list(INPUTS)):
        if message.topic == "/wrench":
            found.append((payload, joints))
            joints = None
        else:
            joints = payload
    return found


def cpu_seconds(pid: int) -> float:
    """Return the time of the processor that a process has taken [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def child(*arguments: str, log: Path | None = None) -> Iterator[subprocess.Popen]:
    """Run another Python until the end of the block, and end it by SIGINT."""
    said = log.open("w") if log else None
    process = subprocess.Popen(
        [sys.executable, *arguments], stdout=subprocess.PIPE, stderr=said, text=True
    )
    try:
        yield process
        process.send_signal(signal.SIGINT)
        process.wait(PATIENCE)
    finally:
        process.kill()
        process.communicate()


def qos(topic: str, depth: int) -> Any:
    """Return what the node publishes a topic with."""
    from rclpy.qos import DurabilityPolicy, QoSProfile

    if topic.removeprefix(PREFIX) in LATCHED:
        return QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    return QoSProfile(depth=depth)


def listen(path: Path) -> None:
    """
    Subscribe to all outputs; write when each state was given to DDS, and the others' last.

    The others are received, but only looked at in the end: the listener shall not be what is slow.
    """
    import rclpy
    from rclpy.experimental import EventsExecutor
    from rclpy.signals import SignalHandlerOptions

    from peg_on_hole_ros.messages.ros_messages import message_class
    from peg_on_hole_ros.startup.interrupt import note_signals

    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    stopping = note_signals()
    states, last = [], {}
    heard, aside = (rclpy.create_node(f"listener_{name}") for name in ("states", "others"))

    def note(topic):
        def take(given):
            payload, known = given
            if topic == STATE:
                states.append((stamp_ns(payload), known["source_timestamp"]))
            last[topic] = payload, known["publication_sequence_number"]

        return take

    for topic, kind in OUTPUTS.items():
        node, depth = (heard, 5000) if topic == STATE else (aside, 1)
        take = note(topic)
        # rclpy gives what is known of a message to a callback of two arguments alone.
        take.__signature__ = TWO
        node.create_subscription(message_class(kind), topic, take, qos(topic, depth), raw=True)
    executor = EventsExecutor()
    executor.add_node(heard)
    while not heard.count_publishers(STATE):
        executor.spin_once(timeout_sec=0.05)
    print("ready", flush=True)
    while not stopping:
        executor.spin_once(timeout_sec=0.1)
    executor.add_node(aside)
    end = time.monotonic() + 1.0
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=0.1)
    rest = {topic: [payload.hex(), count] for topic, (payload, count) in last.items()}
    path.write_text(json.dumps({"states": states, "last": rest}))


def answer(path: Path) -> None:
    """Be the bare node: take the inputs, answer each wrench with what is prepared."""
    import rclpy
    from rclpy.executors import ExternalShutdownException
    from rclpy.experimental import EventsExecutor
    from rclpy.signals import SignalHandlerOptions

    from peg_on_hole_ros.messages.ros_messages import message_class
    from peg_on_hole_ros.ros.inputs import subscribe
    from peg_on_hole_ros.startup.interrupt import note_signals

    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    stopping = note_signals()
    node = rclpy.create_node("bare")
    prepared = []
    told = json.loads(path.read_text())["last"]
    often = told[STATE][1]
    for topic, (payload, count) in told.items():
        kind = message_class(OUTPUTS[topic])
        publisher = node.create_publisher(kind, topic, qos(topic, DEPTH))
        every = max(1, round(often / count))
        prepared.append((publisher, bytes.fromhex(payload), every, topic not in WITHOUT_STAMP))
    count = 0

    def on_wrench(payload):
        nonlocal count
        stamp = payload[4:12]
        for publisher, data, every, has_stamp in prepared:
            if count % every == 0:
                publisher.publish(data[:4] + stamp + data[12:] if has_stamp else data)
        count += 1

    takes = {"/wrench": on_wrench, "/joint_states": lambda payload: None}
    kept = [
        subscribe(node, message_class(kind), topic, DEPTH, takes[topic], lambda missing: None)
        for topic, kind in INPUTS.items()
    ]
    executor = EventsExecutor()
    executor.add_node(node)
    while kept and not stopping:
        try:
            executor.spin_once(timeout_sec=0.1)
        except ExternalShutdownException:
            return


def play(publishers: dict, seconds: float, rate: float, pid: int) -> tuple[list[int], float]:
    """Send; return the stamps of what is measured, and the time a process took for it."""
    inputs, sent = recorded(), []
    count, first, begun = round((seconds + WARM_UP) * rate), round(WARM_UP * rate), 0.0
    start = time.monotonic()
    for i in range(count):
        if i == first:
            begun = cpu_seconds(pid)
        wrench, joints = inputs[i % len(inputs)]
        left = start + i / rate - time.monotonic()
        if left > 0:
            time.sleep(left)
        t_ns = time.time_ns()
        if joints is not None:
            publishers["/joint_states"].publish(stamped(joints, t_ns))
        publishers["/wrench"].publish(stamped(wrench, t_ns))
        if i >= first:
            sent.append(t_ns)
    time.sleep(0.5)
    return sent, cpu_seconds(pid) - begun


def turn(publishers: dict, arguments: list[str], seconds: float, rate: float, out: Path) -> Turn:
    """Have a node take all wrenches, and a listener what it publishes."""
    ours = ["-m", "benchmarks.cost.node_cost"]
    log = out.with_suffix(".log")
    with child(*arguments, log=log) as process, child(*ours, "--listen", str(out)) as listener:
        end = time.monotonic() + PATIENCE
        while not all(each.get_subscription_count() for each in publishers.values()):
            if process.poll() is not None or time.monotonic() > end:
                raise SystemExit(f"{' '.join(arguments)}: it does not listen\n{log.read_text()}")
            time.sleep(0.1)
        assert listener.stdout is not None
        listener.stdout.readline()
        time.sleep(1.0)
        sent, cpu = play(publishers, seconds, rate, process.pid)
    told = json.loads(out.read_text())
    states, counts = dict(told["states"]), {name: each[1] for name, each in told["last"].items()}
    ages = [(states[t_ns] - t_ns) * 1e-9 for t_ns in sent if t_ns in states]
    outputs = sum(counts.values()) / counts[STATE]
    return Turn(cpu / max(len(ages), 1), ages, len(sent) - len(ages), outputs)


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--seconds", type=float, default=60.0, help="of each node in a turn")
    parser.add_argument("--turns", type=int, default=1)
    parser.add_argument("--rate", type=float, default=1000.0, help="of wrenches [Hz]")
    parser.add_argument("--listen", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--answer", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.listen or given.answer:
        listen(given.listen) if given.listen else answer(given.answer)
        return
    os.environ.update(environment(free_domain()))
    import rclpy
    from rclpy.qos import QoSProfile, ReliabilityPolicy

    from peg_on_hole_ros.messages.ros_messages import message_class

    rclpy.init()
    node = rclpy.create_node("player")
    best_effort = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
    publishers = {
        topic: node.create_publisher(message_class(kind), topic, best_effort)
        for topic, kind in INPUTS.items()
    }
    turns: dict[str, list[Turn]] = {"node": [], "bare": []}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        parameters = folder / "parameters.yaml"
        parameters.write_text(write_parameters(to_parameters(stored_configuration(Bag(BAG)))))
        out, other = folder / "node.json", folder / "bare.json"
        bare = ["-m", "benchmarks.cost.node_cost", "--answer", str(out)]
        for _ in range(given.turns):
            real = [*NODE, str(parameters)]
            turns["node"].append(turn(publishers, real, given.seconds, given.rate, out))
            turns["bare"].append(turn(publishers, bare, given.seconds, given.rate, other))
    rclpy.shutdown()
    print(table(turns))


def table(turns: dict[str, list[Turn]]) -> str:
    """Return a row for each node, and what the first takes beside the other."""
    head = ("", "CPU for a wrench answered [us]", "stamp to DDS, median [ms]", "99 % [ms]")
    lines = ["| " + " | ".join((*head, "lost", "outputs for a state")) + " |", "|---" * 6 + "|"]
    late = []
    for name, found in turns.items():
        ages = sorted(age for each in found for age in each.ages)
        if not ages:
            return f"{name}: no wrench was answered"
        cpu = statistics.median(each.cpu for each in found)
        middle, most = ages[len(ages) // 2], ages[len(ages) * 99 // 100]
        late.append(most)
        lost = sum(each.lost for each in found)
        figures = f"{cpu * 1e6:.0f} | {middle * 1e3:.2f} | {most * 1e3:.2f}"
        share = f"{lost} of {lost + len(ages)}"
        lines.append(f"| {name} | {figures} | {share} | {found[0].outputs:.2f} |")
    ratios = [a.cpu / b.cpu for a, b in zip(*turns.values(), strict=True)]
    lines.append(
        f"the node takes {statistics.median(ratios):.2f} times the bare node's time; at 99 % its "
        f"states are {late[0] / late[1]:.1f} times as old"
    )
    return "\n".join(lines)


if __name__ == "__main__":
    main()
