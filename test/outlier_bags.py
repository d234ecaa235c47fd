"""Copies of bags in which single messages are far off, or are missing."""

from pathlib import Path

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.messages.decode import joint_sample, wrench_sample
from peg_on_hole_ros.replay.run import stored_configuration
from small_bags import JOINTS, WRENCH, joints, wrench

W, J = "/wrench", "/joint_states"


def altered(path: Path, source: Path, off: dict[tuple[str, int], tuple[float, ...] | None]):
    """
    Write wrenches and joint states of a bag with some of them altered; return the path.

    Parameters
    ----------
    path, source : Path
    off : dict
        By topic and place among its messages, below zero from the end: what is added to force and
        torque, or to gamma, psi and phi; None leaves the message out.

    """
    bag = Bag(source)
    topics = [topic for topic in (W, J) if topic in bag.topics]
    added = {(topic, at % bag.topics[topic].count): by for (topic, at), by in off.items()}
    seen = {W: 0, J: 0}
    with BagWriter(path, stored_configuration(bag)) as writer:
        for topic, log_ns, message in bag.messages(topics):
            by = added.get((topic, seen[topic]), (0.0,) * 6)
            seen[topic] += 1
            if by is None:
                continue
            if topic == W:
                sample = wrench_sample(message)
                values = [a + b for a, b in zip((*sample.force, *sample.torque), by)]
                writer.write(W, WRENCH, wrench(sample.t_ns, values[:3], values[3:]), log_ns)
            else:
                sample = joint_sample(message)
                values = [a + b for a, b in zip(sample.position, by)]
                writer.write(J, JOINTS, joints(sample.t_ns, values), log_ns)
    return path
