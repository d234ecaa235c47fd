"""What is odd in the messages of one topic, whatever the estimate makes of them."""

from collections import Counter
from collections.abc import Iterable

import numpy as np

from peg_on_hole_ros.bags.batch import Stretch
from peg_on_hole_ros.measurements.repeats import describe, new_repeats, notice_all
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.replay.by_stamp import ByStamp

# A sensor's noise, and most encoders', changes the last digits within so many messages.
_MOST_REPEATS = 100
# A joint that turns faster, or by more than a step of the encoder between two messages, is two
# joints [rad/s], [rad]; once in a while one that counts within a turn begins anew.
_FASTEST_JOINT, _ENCODER_STEP = 100.0, 0.01
_OFTEN_SHARE = 0.1
_NAMES_SHOWN = 4
_OF_WRENCH = {"force": slice(0, 3), "torque": slice(3, 6)}


class TopicOddities:
    """
    Looks at wrenches or joint states in the order of a recording.

    Parameters
    ----------
    names : sequence of str, optional
        Joints that are looked at; of a wrench none.
    angles : bool
        Whether they are gamma, psi and phi: their way is that of the orientation, as psi and phi
        trade places near upright, where their sum alone is determined, and wrap.

    """

    def __init__(self, names: Iterable[str] = (), angles: bool = False) -> None:
        self._names, self._angles = tuple(names), angles
        self._parts = {"position": slice(None)} if names else _OF_WRENCH
        self._frames: Counter[str] = Counter()
        self._first: dict[str, np.ndarray] = {}
        self._changed: set[str] = set()
        # Where messages come out of order, positions do not jump.
        self._by_stamp = ByStamp()
        self._count = self._jumps = 0
        self._widest = 0.0
        self._repeats = new_repeats()
        self._latest = np.empty(0)

    def add(self, found: Iterable[tuple[np.ndarray, Stretch]]) -> None:
        """Take what `stretches` yields; joint states without all of the names tell nothing."""
        places, stamps, values = [], [], []
        for at, stretch in sorted(found, key=lambda one: one[0][0]):
            columns = {name: i for i, name in enumerate(stretch.names)}
            if not columns.keys() >= set(self._names):
                continue
            rows = stretch.values
            rows = rows[:, [columns[name] for name in self._names]] if self._names else rows
            self._frames[stretch.frame_id] += len(at)
            places.append(at)
            stamps.append(stretch.t_ns)
            values.append(rows)
        if places:
            order = np.argsort(np.concatenate(places))
            self._take(np.concatenate(stamps)[order], np.concatenate(values)[order])

    def _take(self, t_ns, values):
        self._count += len(t_ns)
        if not self._latest.size:
            self._latest = np.empty(values.shape[1])
        notice_all(self._repeats, t_ns * 1e-9, values, self._latest)
        for name, part in self._parts.items():
            first = self._first.setdefault(name, values[0, part])
            if name not in self._changed and (values[:, part] != first).any():
                self._changed.add(name)
        if not self._names:
            return
        self._look_for_jumps(*self._by_stamp.take(t_ns, values))

    def _look_for_jumps(self, t_ns, values):
        seconds = np.diff(t_ns) * 1e-9
        if self._angles:
            way = _turns(values)
        else:
            way = np.abs(np.diff(values, axis=0)).max(axis=1, initial=0.0)
        # Where stamps fall another recording begins.
        jumps = (seconds >= 0.0) & (way > np.maximum(_ENCODER_STEP, _FASTEST_JOINT * seconds))
        self._jumps += int(jumps.sum())
        self._widest = max(self._widest, float(way[jumps].max(initial=0.0)))

    def lines(self) -> list[str]:
        """Return what a user has to look at, a line for each oddity."""
        if self._names:
            self._look_for_jumps(*self._by_stamp.rest)
            self._by_stamp = ByStamp()
        repeated = "" if self._repeats is None else describe(self._repeats)
        told = [repeated] if repeated else []
        # Of wrenches those of the first frame are used, and the others told of by the stream.
        if len(self._frames) > 1 and self._names:
            frames = ", ".join(
                f"{name!r} ({n})" for name, n in self._frames.most_common(_NAMES_SHOWN)
            )
            told.append(
                f"messages of {len(self._frames)} frames, {frames}, count as one's: two publish "
                "on one topic; give each a topic of its own"
            )
        if self._jumps > _OFTEN_SHARE * self._count:
            told.append(
                f"positions jump {self._jumps} times in {self._count} messages, by up to "
                f"{self._widest:.3g} and faster than {_FASTEST_JOINT:g} a second: two publish "
                "joints of the same names on one topic, or the stamps are wrong"
            )
        for name, value in self._first.items():
            if self._count >= _MOST_REPEATS and name not in self._changed:
                shown = ", ".join(f"{x:.6g}" for x in value)
                why = (
                    "the peg rests throughout, or the driver repeats an old one"
                    if self._names
                    else "a sensor's noise changes it, so the driver does not fill it or repeats "
                    "an old one"
                )
                told.append(f"{name} is ({shown}) in all {self._count} messages: {why}")
        return told


def _turns(angles):
    """Return the angles of the turns from each orientation to the next, shape (n - 1,) [rad]."""
    R = peg_axes(angles.T)
    # Of a turn by a the Frobenius norm of the difference is 2 sqrt(2) sin(a / 2).
    chord = np.sqrt(np.square(np.diff(R)).sum(axis=(0, 1)) / 8.0)
    return 2.0 * np.arcsin(np.minimum(chord, 1.0))


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
