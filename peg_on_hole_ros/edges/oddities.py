"""What is odd in the messages of one topic, whatever the estimate makes of them."""

from collections import Counter
from contextlib import suppress

import numpy as np

from peg_on_hole_ros.edges.messages.decode import JOINTS_TYPE, MISFITS, WRENCH_TYPE

# A sensor's noise, and most encoders', changes the last digits within so many messages.
_ALIKE = 100
# A joint that turns faster, or by more than a step of the encoder between two messages, is two
# joints [rad/s], [rad]; once in a while one that counts within a turn begins anew.
_FASTEST, _STEP = 100.0, 0.01
_OFTEN = 0.1
_SHOWN = 4


class Oddities:
    """
    Looks at wrenches or joint states in the order of a recording.

    Parameters
    ----------
    names : sequence of str, optional
        Joints that are looked at; of a wrench none.

    """

    def __init__(self, names=()):
        self._names = tuple(names)
        self._frames: Counter[str] = Counter()
        self._first: dict[str, tuple] = {}
        self._changed: set[str] = set()
        self._last: tuple[int, np.ndarray] | None = None
        self._count = self._jumps = 0
        self._widest = 0.0

    def add(self, message) -> None:
        """Take a message as it was read; joint states without all of the names tell nothing."""
        with suppress(*MISFITS):  # its definition in the bag is another's: counted elsewhere
            if self._names:
                self._joints(message)
            else:
                self._wrench(message)

    def _wrench(self, message):
        self._frames[message.header.frame_id] += 1
        self._count += 1
        for name in ("force", "torque"):
            vector = getattr(message.wrench, name)
            self._note(name, (vector.x, vector.y, vector.z))

    def _joints(self, message):
        at = dict(zip(message.name, message.position))
        if not all(name in at for name in self._names):
            return
        self._frames[message.header.frame_id] += 1
        self._count += 1
        position = np.array([at[name] for name in self._names])
        self._note("position", tuple(position))
        stamp = message.header.stamp
        t_ns = stamp.sec * 10**9 + stamp.nanosec
        if self._last is not None:
            seconds = max((t_ns - self._last[0]) * 1e-9, 0.0)
            way = np.abs(position - self._last[1]).max()
            if way > max(_STEP, _FASTEST * seconds):
                self._jumps += 1
                self._widest = max(self._widest, float(way))
        self._last = t_ns, position

    def _note(self, name, value):
        if name not in self._changed and self._first.setdefault(name, value) != value:
            self._changed.add(name)

    def lines(self) -> list[str]:
        """Return what a user has to look at, a line for each oddity."""
        told = []
        if len(self._frames) > 1:
            frames = ", ".join(f"{name!r} ({n})" for name, n in self._frames.most_common(_SHOWN))
            told.append(
                f"messages of {len(self._frames)} frames, {frames}, count as one's: two publish "
                "on one topic; give each a topic of its own"
            )
        if self._jumps > _OFTEN * self._count:
            told.append(
                f"positions jump {self._jumps} times in {self._count} messages, by up to "
                f"{self._widest:.3g} and faster than {_FASTEST:g} a second: two publish joints of "
                "the same names on one topic, or the stamps are wrong"
            )
        for name, value in self._first.items():
            if self._count >= _ALIKE and name not in self._changed:
                shown = ", ".join(f"{x:.6g}" for x in value)
                why = (
                    "the peg rests throughout, or the driver repeats an old one"
                    if self._names
                    else "a sensor's noise changes it, so the driver does not fill it or repeats "
                    "an old one"
                )
                told.append(f"{name} is ({shown}) in all {self._count} messages: {why}")
        return told


def two_robots(types: dict[str, list[str]], wrench: str, joints: str) -> str:
    """
    Return what speaks for a wrench and joint states of two robots, or nothing.

    Parameters
    ----------
    types : dict of str to list of str
        Of each topic in a bag.
    wrench, joints : str
        Topics that are read.

    """
    (at_wrench, _, wrench_name), (at_joints, _, joints_name) = (
        topic.rpartition("/") for topic in (wrench, joints)
    )
    others = (
        (f"{at_joints}/{wrench_name}", WRENCH_TYPE),
        (f"{at_wrench}/{joints_name}", JOINTS_TYPE),
    )
    found = [topic for topic, name in others if types.get(topic) == [name]]
    if at_wrench == at_joints or not found:
        return ""
    return (
        f"topics: {wrench} and {joints} are read, of two namespaces, though there is "
        f"{' and '.join(found)}: wrench and joint states have to be of one robot (topics.wrench, "
        "topics.joint_states)"
    )
