"""
A live node at 1 kHz whose publishers are killed at random, for as long as is asked for.

    python -m benchmarks.faults.killed [--seconds 600] [--seed 1]

Wrench and joint states come from a process of their own each, with a sample bag's values by the
clock. Ends with 1 where the node ends, its memory grows, or no estimate comes of publishers that
are both there.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

from peg_on_hole_ros.ros.local_dds import environment, free_domain

BAG = Path(__file__).parents[2] / "bags" / "closing_with_slip.mcap"
SOURCES = {"wrench": ("/wrench", 1_000_000), "joints": ("/joint_states", 2_000_000)}
# From a kill to the next, and until a publisher is back [s].
KILLS, BACK = (0.5, 4.0), (0.0, 1.0)
# Compiling, matching; and until an estimate comes of both publishers, on a busy machine [s].
READY, ESTIMATE = 180.0, 20.0
MOST_GROWTH = 20.0


def publish(source: str) -> None:
    """Publish a bag's values of a source by the clock, until killed."""
    import rclpy

    from peg_on_hole_ros.bags.reader import Bag
    from peg_on_hole_ros.messages.ros_messages import message_class

    topic, period = SOURCES[source]
    bag = Bag(BAG)
    found = [message for _, _, message in bag.messages([topic])]
    rclpy.init()
    node = rclpy.create_node(f"publisher_of_{source}")
    kind = message_class(bag.topics[topic].types[0])
    publisher = node.create_publisher(kind, topic, 10)
    due = time.time_ns() // period
    while True:
        due += 1
        time.sleep(max(due * period - time.time_ns(), 0) * 1e-9)
        values, message = found[due % len(found)], kind()
        stamp = divmod(due * period, 10**9)
        message.header.stamp.sec, message.header.stamp.nanosec = stamp
        if source == "wrench":
            for part in ("force", "torque"):
                for axis in "xyz":
                    read = getattr(getattr(values.wrench, part), axis)
                    setattr(getattr(message.wrench, part), axis, float(read))
        else:
            message.name, message.position = list(values.name), list(map(float, values.position))
        publisher.publish(message)


def resident(pid: int) -> float:
    """Return the memory of a process [MB]."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024.0
    return 0.0


def run(seconds: float, seed: int = 1) -> dict:
    """Run node and publishers; return figures, of which `sound` says whether all is well."""
    os.environ.update(environment(free_domain()))
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray
    from sensor_msgs.msg import JointState

    draw = random.Random(seed)
    node = subprocess.Popen([sys.executable, "-m", "peg_on_hole_ros.ros.node"])
    own = [sys.executable, "-m", "benchmarks.faults.killed", "--publish"]
    alive = {source: subprocess.Popen([*own, source]) for source in SOURCES}
    back = {}
    rclpy.init()
    watch = rclpy.create_node("watch")
    seen = {"estimates": 0, "reports": 0, "last": 0.0}

    def estimate(message):
        seen["estimates"] += 1
        seen["last"] = time.monotonic()

    def report(message):
        seen["reports"] += 1

    watch.create_subscription(JointState, "/peg_on_hole/state", estimate, 100)
    watch.create_subscription(DiagnosticArray, "/diagnostics", report, 10)

    def spin_until(end, done=lambda: False):
        while time.monotonic() < end and not done() and node.poll() is None:
            rclpy.spin_once(watch, timeout_sec=0.05)

    kills, filled = 0, 0.0
    spin_until(time.monotonic() + READY, lambda: seen["estimates"] > 0)
    begun = time.monotonic()
    next_kill = begun + draw.uniform(*KILLS)
    while time.monotonic() < begun + seconds and node.poll() is None:
        spin_until(min(next_kill, *back.values(), begun + seconds))
        now = time.monotonic()
        for source in [name for name, at in back.items() if at <= now]:
            alive[source] = subprocess.Popen([*own, source])
            del back[source]
        if now >= next_kill and alive:
            source = draw.choice(sorted(alive))
            alive[source].kill()
            alive.pop(source).wait()
            back[source] = now + draw.uniform(*BACK)
            kills += 1
            next_kill = now + draw.uniform(*KILLS)
        if not filled and now > begun + 0.3 * seconds:
            filled = resident(node.pid)
    for source in back:
        alive[source] = subprocess.Popen([*own, source])
    before = seen["estimates"]
    spin_until(time.monotonic() + ESTIMATE, lambda: seen["estimates"] > before + 500)
    again = seen["estimates"] - before
    growth = resident(node.pid) - filled if node.poll() is None else float("inf")
    for process in alive.values():
        process.kill()
        process.wait()
    if node.poll() is None:
        node.send_signal(signal.SIGINT)
    code = node.wait(timeout=READY)
    watch.destroy_node()
    rclpy.shutdown()
    sound = code == 0 and growth < MOST_GROWTH and again > 0 and seen["reports"] > 0
    return {
        "seconds": seconds, "kills": kills, "estimates": seen["estimates"], "after": again,
        "growth_mb": round(growth, 1), "exit_code": code, "sound": sound,
    }  # fmt: skip


def main(arguments=None) -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--publish", choices=list(SOURCES), help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.publish:
        publish(options.publish)
    found = run(options.seconds, options.seed)
    print(json.dumps(found))
    return int(not found["sound"])


if __name__ == "__main__":
    sys.exit(main())
