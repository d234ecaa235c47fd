"""
Play tries over DDS: the node, the program of the example and a cell, each a process.

    python -m benchmarks.loop.realtime --tries 20 --out runs.csv

The cell goes by the wall clock, or slower where it has no core; `/clock` says how far it is. The
program goes by `/clock`, the node by the stamps. Each try is compared with the same in lockstep,
by what the program says of its outcome.
"""

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from benchmarks.loop import drawn
from benchmarks.loop.drawn import EVERY, FRAME, LONGEST
from benchmarks.loop.program import program_module
from benchmarks.loop.variants import options_of
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.config.parameters_file import write_parameters

EXAMPLE = Path(__file__).parents[2] / "examples" / "insert.py"
# What the program says by its exit code; one that still runs has no outcome.
OUTCOMES = {0: "inserted", 2: "given up", None: "too long"}
# Before a program ends that has not begun [s].
PATIENCE = 120.0


class CellNode:
    """Publishes what the cell sends, and leads it to the last target that has come."""

    def __init__(self, cell, module, context: Context) -> None:
        self.cell, self._module, self.target = cell, module, None
        self.node = rclpy.create_node("cell", context=context)
        self._clock = self.node.create_publisher(Clock, "/clock", 10)
        self._wrench = self.node.create_publisher(WrenchStamped, "/wrench", 100)
        self._joints = self.node.create_publisher(JointState, "/joint_states", 100)
        self._pose = self.node.create_publisher(PoseStamped, "current_pose", 10)
        self.node.create_subscription(PoseStamped, "target_frame", self._take, 10)
        self._stamp = Clock().clock

    def _take(self, message: PoseStamped) -> None:
        p, q = message.pose.position, message.pose.orientation
        lean, spin = self._module.lean_and_spin(q)
        # A quaternion leaves whole turns open.
        turns = np.round((self.cell.spin - spin) / (2 * np.pi))
        self.target = np.array([p.x, p.y, p.z]), lean, spin + 2 * np.pi * turns

    def send(self) -> None:
        """Publish the cell as it is."""
        cell, ns = self.cell, round((1.0 + self.cell.t) * 1e9)
        self._stamp.sec, self._stamp.nanosec = divmod(ns, 10**9)
        joints = JointState(name=list(cell.names), position=cell.drives.tolist())
        wrench, pose = WrenchStamped(), PoseStamped()
        wrench.header.frame_id, pose.header.frame_id = FRAME, "hole"
        f, m = wrench.wrench.force, wrench.wrench.torque
        f.x, f.y, f.z, m.x, m.y, m.z = cell.wrench.tolist()
        p, q = pose.pose.position, pose.pose.orientation
        p.x, p.y, p.z = cell.position.tolist()
        q.x, q.y, q.z, q.w = map(float, self._module.quaternion(cell.lean, cell.spin))
        for message in (joints, wrench, pose):
            message.header.stamp = self._stamp
        self._clock.publish(Clock(clock=self._stamp))
        self._joints.publish(joints)
        self._wrench.publish(wrench)
        self._pose.publish(pose)


def play_over_dds(true: drawn.Try, module, options, folder: Path) -> dict:
    """Return what became of a try that three processes play together."""
    from benchmarks.loop.lockstep import Cell  # MuJoCo is no part of the extra `dev`

    cell = Cell(true, options)
    parameters = folder / "cell.yaml"
    values = to_parameters(cell.configuration)
    parameters.write_text(write_parameters(values, "A try of the loop."))
    own = {name: value for name, value in vars(options).items() if name != "plan"}
    if options.plan:
        (folder / "plan.json").write_text(json.dumps(options.plan))
        own["plan"] = str(folder / "plan.json")
    stated = [f"{name}:={_shown(value)}" for name, value in own.items()]
    environment = {**os.environ, "ROS_DOMAIN_ID": str(40 + os.getpid() % 60)}
    os.environ["ROS_DOMAIN_ID"] = environment["ROS_DOMAIN_ID"]
    node = [sys.executable, "-m", "peg_on_hole_ros.ros.node", "--ros-args", "--params-file",
            str(parameters)]  # fmt: skip
    program = [sys.executable, str(EXAMPLE), "--ros-args", "-p", "use_sim_time:=true"]
    program += [word for each in stated for word in ("-p", each)]
    context = Context()
    rclpy.init(context=context)
    log = (folder / "log.txt").open("w")
    processes = [
        subprocess.Popen(words, env=environment, stdout=log, stderr=subprocess.STDOUT)
        for words in (node, program)
    ]
    try:
        return _go(CellNode(cell, module, context), context, processes[1])
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            process.wait(timeout=20.0)
        rclpy.shutdown(context=context)
        log.close()


def _go(peer: CellNode, context: Context, program) -> dict:
    """Go on by the wall clock until the program has ended, or the try has lasted too long."""
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(peer.node)
    cell, begun, most, behind = peer.cell, time.monotonic(), 0.0, 0.0
    started, first = None, None
    while program.poll() is None:
        if started is None and time.monotonic() - begun > PATIENCE:
            break
        if started is not None and cell.t - first > LONGEST:
            break
        cell.go()
        most = max(most, *(float(row[6].max()) for row in cell.rows))
        peer.send()
        executor.spin_once(timeout_sec=0.0)
        if peer.target is None:
            # The robot holds still until a program leads it.
            cell.stay()
            due = time.monotonic() + EVERY * 1e-3
        else:
            if started is None:
                started, first = time.monotonic(), cell.t
            cell.lead(*peer.target)
            due = started + cell.t - first
        late = time.monotonic() - due
        behind = max(behind, late) if started is not None else 0.0
        time.sleep(max(-late, 0.0))
    executor.remove_node(peer.node)
    code = program.poll()
    return {
        "outcome": OUTCOMES.get(code, f"exit code {code}"), "most_load": most,
        "time": cell.t - (first or cell.t), "behind": behind,
    }  # fmt: skip


def _shown(value) -> str:
    """Return a value as a ROS argument."""
    if isinstance(value, bool):
        return str(value).lower()
    return str(list(value)) if isinstance(value, tuple) else str(value)


def main() -> None:
    """Play tries both ways, print and write what became of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tries", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--variants", default="plain,all")
    parser.add_argument("--out", type=Path, default=Path("realtime.csv"))
    asked = parser.parse_args()
    from benchmarks.loop.lockstep import play

    module, rows, same = program_module(), [], 0
    for number in range(asked.first, asked.first + asked.tries):
        name = asked.variants.split(",")[number % len(asked.variants.split(","))]
        true = drawn.drawn(number, True)
        options = options_of(module, true, name)
        with tempfile.TemporaryDirectory() as folder:
            real = play_over_dds(true, module, options, Path(folder))
            log = (Path(folder) / "log.txt").read_text()
        ideal = play(true, module, options)
        agrees = real["outcome"] == ideal["outcome"]
        same += agrees
        rows.append([
            number, name, ideal["outcome"], real["outcome"], f"{ideal['most_load']:.0f}",
            f"{real['most_load']:.0f}", f"{ideal['time']:.1f}", f"{real['time']:.1f}",
            f"{real['behind']:.2f}",
        ])  # fmt: skip
        print(*rows[-1], sep="  ", flush=True)
        if not agrees:
            print(log[-2000:])
    head = ["try", "variant", "lockstep", "over_dds", "load_lockstep_N", "load_dds_N",
            "time_lockstep_s", "time_dds_s", "behind_s"]  # fmt: skip
    with asked.out.open("w", newline="") as file:
        csv.writer(file).writerows([head, *rows])
    print(f"the same outcome in {same} of {len(rows)}")


if __name__ == "__main__":
    main()
