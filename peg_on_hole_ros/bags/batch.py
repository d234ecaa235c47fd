"""Wrenches and joint states of a recording as arrays, in the order in which they are taken."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from peg_on_hole_ros.bags.storage.fixed_layouts import NO_LAYOUT, Layout
from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.measurements.orientation import (
    ROW,
    JointOrientation,
    Outcome,
    positions_of,
)
from peg_on_hole_ros.measurements.wrench_reduction import sound_wrenches
from peg_on_hole_ros.messages.decode import (
    JOINTS_TYPE,
    WRENCH_TYPE,
    checked_joints,
    checked_wrench,
    frame_of,
    joint_sample,
    stamp_of,
    wrench_sample,
)
from peg_on_hole_ros.messages.wrench_frames import WrenchFrames
from peg_on_hole_ros.records import Arrivals, JointSample, WrenchSample


class Item(NamedTuple):
    """
    One message.

    Attributes
    ----------
    topic : str
    log_ns : int
        When it was recorded; where that is wrong, when it must have been [ns].
    sample : WrenchSample, JointSample, Malformed or object
        Of other types the message, fields as attributes.
    frame : str
        frame_id; empty: none, or of a type that is not read.

    """

    topic: str
    log_ns: int
    sample: Any
    frame: str = ""


class Batch(NamedTuple):
    """
    Messages that follow one another.

    Attributes
    ----------
    types : dict of str to str
        Type of each topic that is read, in order.
    layouts : list of Layout
        Those met so far, the same list for all batches of a reading.
    topic : ndarray of int, shape (n,)
        Place in `types`.
    log_ns : ndarray of int64, shape (n,)
        When each was recorded; where that is wrong, when it must have been [ns].
    t_ns : ndarray of int64, shape (n,)
        Stamp; of what has no layout 0 [ns].
    layout : ndarray of int, shape (n,)
        Place in `layouts`; NO_LAYOUT: the message is in `others`.
    values : ndarray, shape (n, m)
        Force [N] and torque [N m], or positions [rad or m], as many as the layout has; behind
        them as many efforts, where these are read.
    others : dict of int to object
        By place: decoded messages of other types, or that no layout fits.

    """

    types: dict[str, str]
    layouts: list[Layout]
    topic: np.ndarray
    log_ns: np.ndarray
    t_ns: np.ndarray
    layout: np.ndarray
    values: np.ndarray
    others: dict[int, Any]

    def __len__(self) -> int:
        """Return the number of messages."""
        return len(self.topic)

    def items(self, needed: tuple[str, ...] = ()) -> Iterator[Item]:
        """
        Yield each message as a sample, or as what is wrong with it.

        Parameters
        ----------
        needed : tuple of str
            Joints whose positions have to be finite; empty: all.

        """
        for i in range(len(self)):
            yield self.item(i, needed)

    def item(self, i: int, needed: tuple[str, ...] = ()) -> Item:
        """Return one message as `items` does, by its place."""
        name, ros_type = self._types[self.topic[i]]
        log_ns, layout = int(self.log_ns[i]), int(self.layout[i])
        if layout == NO_LAYOUT:
            message = self.others[i]
            return Item(name, log_ns, _sample(ros_type, message, needed), frame_of(message))
        frame = self.layouts[layout].frame_id
        t_ns, values = int(self.t_ns[i]), self.values[i].tolist()
        if ros_type == WRENCH_TYPE:
            sample = WrenchSample(t_ns, tuple(values[:3]), tuple(values[3:6]))
            return Item(name, log_ns, checked_wrench(sample), frame)
        names, width = self.layouts[layout].names, self.layouts[layout].width
        sample = JointSample(t_ns, names, tuple(values[:width]))
        return Item(name, log_ns, checked_joints(sample, needed), frame)

    def first_frame(self, sources: Mapping[str, str]) -> tuple[str, int] | None:
        """Return frame_id and stamp [ns] of the first wrench that names a frame, or None."""
        topics = [topic for topic in self.types if sources.get(topic) == "wrench"]
        found = [
            (int(at[0]), stretch.frame_id, int(stretch.t_ns[0]))
            for topic in topics
            for at, stretch in stretches(self, topic)
            if stretch.frame_id
        ]
        return min(found)[1:] if found else None

    @property
    def _types(self):
        return list(self.types.items())


def _sample(ros_type, message, needed):
    if ros_type == WRENCH_TYPE:
        return wrench_sample(message)
    if ros_type == JOINTS_TYPE:
        return joint_sample(message, needed)
    return message


class Stretch(NamedTuple):
    """
    Messages of one topic and one layout within a batch, or one that fits none.

    Attributes
    ----------
    frame_id : str
    names : tuple of str
        Of joints.
    t_ns : ndarray of int64, shape (n,)
        [ns]
    values : ndarray, shape (n, m)
        Of a wrench six, force [N] first, else positions [rad or m].

    """

    frame_id: str
    names: tuple[str, ...]
    t_ns: np.ndarray
    values: np.ndarray


def stretches(batch: Batch, topic: str) -> Iterator[tuple[np.ndarray, Stretch]]:
    """
    Yield places and content of a topic's messages with readable fields, by layout.

    Places of a layout are in order; those of a message that fits none come by themselves.
    """
    number = list(batch.types).index(topic)
    places = np.flatnonzero(batch.topic == number)
    for layout in np.unique(batch.layout[places]).tolist():
        at = places[batch.layout[places] == layout]
        if layout == NO_LAYOUT:
            for i in at.tolist():
                found = _odd(batch.others[i], batch.types[topic])
                if found is not None:
                    yield np.array([i]), found
            continue
        known = batch.layouts[layout]
        yield (
            at,
            Stretch(known.frame_id, known.names, batch.t_ns[at], batch.values[at, : known.width]),
        )


def _odd(message, ros_type):
    """Return what a message that fits no layout holds, or None where its fields are another's."""
    t_ns = stamp_of(message)
    if t_ns is None:
        return None
    try:
        frame = str(message.header.frame_id)
        if ros_type == WRENCH_TYPE:
            force, torque = message.wrench.force, message.wrench.torque
            numbers = force.x, force.y, force.z, torque.x, torque.y, torque.z
            names = ()
        else:
            names = tuple(map(str, message.name))
            numbers = tuple(message.position)
            if len(names) != len(numbers):
                return None
        values = np.array([numbers], float).reshape(1, -1)
    except (AttributeError, TypeError, ValueError):
        return None
    return Stretch(frame, names, np.array([t_ns]), values)


def arrivals_of(
    batch: Batch,
    sources: Mapping[str, str],
    joints: JointInput,
    orientation: JointOrientation,
    frames: WrenchFrames,
) -> Arrivals:
    """
    Return messages in their order; those of other topics are marked as not usable.

    Parameters
    ----------
    batch : Batch
    sources : mapping of str to str
        Which topics are `wrench` and `joints`.
    joints : JointInput
    orientation : JointOrientation
    frames : WrenchFrames
        Begins with the first wrench; those of another frame are not usable as they are.

    """
    first = batch.first_frame(sources)
    if first is not None:
        frames.begin(*first)
    source = np.array([sources.get(topic, "") for topic in batch.types] or [""])[batch.topic]
    of_wrench, of_joints = source == "wrench", source == "joints"
    sound = np.zeros(len(batch), bool)
    rows = np.full((len(batch), ROW), np.nan)
    read = np.full((len(batch), len(joints.names)), np.nan)
    for number, layout in enumerate(batch.layouts):
        fits = batch.layout == number
        at = np.flatnonzero(fits & of_wrench)
        if len(at) and not frames.is_other(layout.frame_id):
            sound[at] = sound_wrenches(batch.values[at, :6])
        at = np.flatnonzero(fits & of_joints)
        if len(at):
            positions = batch.values[at, : layout.width]
            sound[at], rows[at] = _orientations(layout.names, positions, joints, orientation)
            read[at] = positions_of(joints.names, layout.names, positions)
    t_ns = np.where(of_wrench, batch.t_ns, batch.t_ns - round(joints.delay * 1e9))
    # A batch without any wrench that can be read may be narrower.
    wrenches = np.full((np.count_nonzero(of_wrench), 6), np.nan)
    received = batch.values[of_wrench, :6]
    wrenches[:, : received.shape[1]] = received
    return Arrivals(of_wrench, t_ns, sound, wrenches, rows[~of_wrench], read[~of_wrench])


def _orientations(names, positions, joints, orientation):
    """Return which joint states of one order are sound, and their rows."""
    needed = [i for i, name in enumerate(names) if not joints.names or name in joints.names]
    sound = np.isfinite(positions[:, needed]).all(axis=1)
    sound &= len(set(names)) == len(names) == positions.shape[1]
    found = orientation.rows(names, positions)
    return sound & (found.outcome == Outcome.orientation), found.rows
