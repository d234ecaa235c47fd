"""
Faults played into the real node over DDS, and what it publishes held to what has to happen.

    python -m benchmarks.faults.live [--fault TEXT]

A recording with a fault goes as a bag through publishers at its own pace, as drivers send. Ends
with 1 where a flag of the transition is wrong, a jam missed or an ERROR of jamming false without
mode `unknown` or an ERROR of the diagnostics, where what has to be reported is not, or where the
node ends.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.faults.expected import BY_NAME, Case
from benchmarks.faults.injector import Recording, inject
from benchmarks.faults.scenes import Scene, scene
from benchmarks.faults.score import false_jams, untold_jams, wrong_flags
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.config.parameters_file import write_parameters
from peg_on_hole_ros.messages.beside_estimates import PREFIX, joint_state
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.plain import header
from peg_on_hole_ros.messages.ros_messages import message_class
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.ros.local_dds import environment, free_domain

# Scene and fault of each that is played.
PLAYED = (
    ("closing", "no fault"),
    ("jam", "no fault"),
    ("closing", "no messages for a while"),
    ("jam", "encoders stand still"),
    ("jam", "wrench noise x 5"),
    ("closing", "wrench with the other sign"),
    ("closing", "played in a loop"),
    ("jam", "5 % of wrenches NaN"),
    ("jam", "the sensor stands still"),
)
ERROR = 2


class Heard(NamedTuple):
    """
    What a node has published.

    Attributes
    ----------
    true_ns : ndarray of int, shape (n,)
        Stamps of the estimates, in order of arrival [ns].
    mode : ndarray of str, shape (n,)
    flag : ndarray of bool, shape (n,)
    jamming, level : ndarray of int, shape (n,)
        Level of the alarm, and the worst of the diagnostics, as they stood.
    told : list of str
        What the diagnostics of filter and input said but OK.
    code : int
        With which the node ended.

    """

    true_ns: np.ndarray
    mode: np.ndarray
    flag: np.ndarray
    jamming: np.ndarray
    level: np.ndarray
    told: list
    code: int


def write(path: Path, recorded: Scene, recording: Recording) -> None:
    """Write a recording to a bag, in the order of arrival; calls are left out."""
    arrival = 0
    with BagWriter(path, recorded.configuration) as writer:
        for sample, true_ns in recording:
            # Of a clock that goes on, whatever the stamps say.
            arrival = max(arrival + 1, true_ns)
            if isinstance(sample, WrenchSample):
                force, torque = dict(zip("xyz", sample.force)), dict(zip("xyz", sample.torque))
                message = {
                    "header": header(sample.t_ns, recorded.frame),
                    "wrench": {"force": force, "torque": torque},
                }
                writer.write("/wrench", WRENCH_TYPE, message, arrival)
            elif not isinstance(sample, str):
                message = joint_state(sample.t_ns, sample.names, sample.position)
                writer.write("/joint_states", JOINTS_TYPE, message, arrival)


def hear(recorded: Scene, recording: Recording, folder: Path) -> Heard:
    """Play a recording into a node of its own; return what it publishes."""
    from peg_on_hole_ros.ros.player import Player

    path, parameters = folder / "faulted.mcap", folder / "parameters.yaml"
    write(path, recorded, recording)
    text = write_parameters(to_parameters(recorded.configuration))
    parameters.write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "peg_on_hole_ros.ros.node"]
    with (folder / "node.log").open("w") as log:
        node = subprocess.Popen(
            [*command, "--ros-args", "--params-file", str(parameters)],
            stdout=log,
            stderr=subprocess.STDOUT,
        )
        try:
            player = Player("/wrench", "/joint_states", node)
            try:
                player.wait_for_node()
                player.play(Bag(path), 1.0)
            finally:
                player.close()
            node.send_signal(signal.SIGINT)
            code = node.wait(timeout=60)
        finally:
            node.kill()
            node.wait()
    return _heard(player.received, code)


def _heard(received, code):
    """Return what was said with each estimate: what stands is what came before the next."""
    from rclpy.serialization import deserialize_message

    rows, told = [], []
    stands = {"mode": "unknown", "flag": False, "jamming": 0, "level": 0}

    for topic, ros_type, t_ns, payload in received:
        name = topic.removeprefix(PREFIX)
        if name == "state":
            rows.append([t_ns, dict(stands)])
            continue
        if name not in ("contact_mode", "transition", "alarms", "/diagnostics"):
            continue
        message = deserialize_message(payload, message_class(ros_type))
        if name == "contact_mode":
            stands["mode"] = message.data
        elif name == "transition":
            stands["flag"] = message.data
        elif name == "alarms":
            levels = {each.name.rpartition(" ")[2]: each.level for each in message.status}
            stands["jamming"] = _number(levels.get("jamming", 0))
        else:
            of = {each.name.rpartition(" ")[2]: each for each in message.status}
            judged = [of[each] for each in ("filter", "input") if each in of]
            stands["level"] = max((_number(each.level) for each in judged), default=0)
            told += [line for each in judged if _number(each.level)
                     for line in each.message.split("; ")]  # fmt: skip
        if rows:
            rows[-1][1] = dict(stands)
    return Heard(
        true_ns=np.array([row[0] for row in rows], np.int64),
        mode=np.array([row[1]["mode"] for row in rows], "U16"),
        flag=np.array([row[1]["flag"] for row in rows], bool),
        jamming=np.array([row[1]["jamming"] for row in rows], int),
        level=np.array([row[1]["level"] for row in rows], int),
        told=told,
        code=code,
    )


def _number(level):
    return level[0] if isinstance(level, bytes) else int(level)


def shortfalls(recorded: Scene, case: Case, heard: Heard) -> list[str]:
    """Return what has to happen with a case and did not, a line each."""
    found = [
        f"{count} estimates with {what}"
        for count, what in (
            (wrong_flags(recorded, heard).sum(), "a wrong transition flag"),
            (untold_jams(recorded, heard).sum(), "no word of the jam"),
            (false_jams(recorded, heard).sum(), "a false ERROR of jamming"),
        )
        if count
    ]
    if heard.code:
        found.append(f"the node ended with code {heard.code}")
    if not len(heard.true_ns):
        found.append("no estimate")
    if case.told and not any(case.told in line for line in heard.told):
        found.append(f"not reported: {case.told}")
    if case.level and not heard.told:
        found.append("the diagnostics are OK")
    return found


def run(name: str, case: Case, folder: Path) -> list[str]:
    """Play a case into a node; return what falls short."""
    recorded = scene(name, folder)
    begin, end = (0.0, inf) if case.lasts else recorded.part
    recording = recorded.recording
    if case.fault:
        recording = inject(
            recording, case.fault, begin, end, cell=recorded.cell, **case.parameters
        )
    with tempfile.TemporaryDirectory(dir=folder) as own:
        heard = hear(recorded, recording, Path(own))
    return shortfalls(recorded, case, heard)


def main(arguments=None) -> int:
    """Play all; return 1 where something falls short."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--fault", default="", help="those whose name holds this text")
    options = parser.parse_args(arguments)
    # Before rclpy is loaded: it reads these when it starts.
    os.environ.update(environment(free_domain()))
    fell = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, fault in PLAYED:
            if options.fault in fault:
                short = run(name, BY_NAME[fault], Path(folder))
                fell += bool(short)
                print(f"{name}, {fault}: {'; '.join(short) or 'held'}", flush=True)
    return int(fell > 0)


if __name__ == "__main__":
    sys.exit(main())
