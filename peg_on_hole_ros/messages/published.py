"""Messages that come with every estimate, by the table of outputs: numbers, dicts and bytes."""

from typing import Any, NamedTuple

import numpy as np

from peg_on_hole_ros.messages.beside_estimates import (
    JOINT_STATE,
    POSE,
    TOPICS,
    WRENCH,
    joint_state,
)
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.cdr_layout import joined
from peg_on_hole_ros.messages.plain import HOLE_FRAME, header, xyz
from peg_on_hole_ros.monitor.output_row import OUTPUTS, ROW
from peg_on_hole_ros.monitor.publishable_reactions import are_publishable
from peg_on_hole_ros.outputs import NOT_DETERMINED

_BYTES = np.dtype(np.float64).itemsize


class TopicNumbers(NamedTuple):
    """
    The numbers of a topic among those that are published.

    Attributes
    ----------
    name : str
        Of the topic, under the node's name.
    ros_type : str
    at : slice
    names : tuple of str
        Of a JointState's entries.
    fields : dict of str to slice
        Where each of its fields has its numbers, within those of the topic.

    """

    name: str
    ros_type: str
    at: slice
    names: tuple[str, ...]
    fields: dict[str, slice]

    def message(self, t_ns: int, numbers: np.ndarray, frame: str = HOLE_FRAME) -> dict:
        """Return the message of a stamp [ns] whose numbers are given, in the hole's frame."""
        values = {name: numbers[at].tolist() for name, at in self.fields.items()}
        return _MESSAGE_OF_TYPE[self.ros_type](t_ns, frame, self.names, values)


def _joint_state(t_ns, frame, names, values):
    return joint_state(t_ns, names, **values, frame=frame)


def _wrench(t_ns, frame, _, values):
    force, torque = xyz(values["wrench.force"]), xyz(values["wrench.torque"])
    return {"header": header(t_ns, frame), "wrench": {"force": force, "torque": torque}}


def _pose(t_ns, frame, _, values):
    turn = dict(zip("xyzw", values["pose.pose.orientation"]))
    there = {"position": xyz(values["pose.pose.position"]), "orientation": turn}
    return {
        "header": header(t_ns, frame),
        "pose": {"pose": there, "covariance": values["pose.covariance"]},
    }


_MESSAGE_OF_TYPE: dict[str, Any] = {JOINT_STATE: _joint_state, WRENCH: _wrench, POSE: _pose}


def _layouts() -> dict[str, TopicNumbers]:
    """Return where the numbers of each topic stand in a row, by the name of the topic."""
    found: dict[str, TopicNumbers] = {}
    for name, output in OUTPUTS.items():
        kind, offset = ROW.fields[name][:2]  # type: ignore[index]
        topics, fields = output.topic.split(), output.field.split()
        if kind.base != np.float64 or not topics:
            continue
        at, size = offset // _BYTES, kind.itemsize // _BYTES
        share = size // len(topics)
        part = share // len(fields)
        for topic in topics:
            before = found.get(topic, TopicNumbers(topic, TOPICS[topic], slice(at, at), (), {}))
            begin = before.at.start
            places = dict(before.fields)
            for k, field in enumerate(fields):
                first = at - begin + k * part
                places[field] = slice(places.get(field, slice(first, 0)).start, first + part)
            # The entries of every field of a JointState have the same names.
            news = output.names or (name,)
            names = before.names + news if fields[0] == next(iter(places)) else before.names
            found[topic] = TopicNumbers(
                topic, before.ros_type, slice(begin, at + share), names, places
            )
            at += share
    return found


LAYOUTS = _layouts()
# How many numbers are published with every estimate; a row begins with them.
SIZE = max(layout.at.stop for layout in LAYOUTS.values())


def _withheld() -> np.ndarray:
    found = np.zeros(SIZE, bool)
    for name, output in OUTPUTS.items():
        if output.missing == NOT_DETERMINED:
            kind, offset = ROW.fields[name][:2]  # type: ignore[index]
            found[offset // _BYTES :][: kind.itemsize // _BYTES] = True
    return found


# Numbers that a row has and the messages do not, where the reactions are not known.
_WITHHELD = np.flatnonzero(_withheld())


def published(rows: np.ndarray) -> np.ndarray:
    """
    Return the numbers of the messages of many stamps, in their order, shape (n, SIZE).

    Parameters
    ----------
    rows : ndarray of ROW, shape (n,)

    """
    words = np.ascontiguousarray(rows).view(np.float64).reshape(len(rows), -1)
    numbers = words[:, :SIZE].copy()
    unknown = np.flatnonzero(~are_publishable(rows))
    if len(unknown):
        numbers[unknown[:, None], _WITHHELD] = np.nan
    return numbers


class EstimateEncoder:
    """
    Writes the messages of an estimate, which differ from others in stamp and numbers alone.

    Parameters
    ----------
    frame : str
        The hole's, which they are in.

    """

    def __init__(self, frame: str = HOLE_FRAME) -> None:
        layouts = [
            Encoder(each.ros_type).layout(
                each.message(0, np.zeros(each.at.stop - each.at.start), frame)
            )
            for each in LAYOUTS.values()
        ]
        self._template, places = joined(layouts)
        self._places = list(zip(LAYOUTS, places))

    def __call__(self, t_ns: int, numbers: np.ndarray) -> list[tuple[str, bytes]]:
        """
        Return (topic under the node's name, payload) of each message.

        Parameters
        ----------
        t_ns : int
            Stamp [ns].
        numbers : ndarray, shape (published.SIZE,)

        """
        written = self._template.write_one(t_ns, numbers)
        return [(suffix, written[place]) for suffix, place in self._places]
