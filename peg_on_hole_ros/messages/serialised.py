"""
Samples out of serialised messages that look like one that was read before.

A driver's messages differ in stamp and numbers alone. So a message that has the texts and lengths
of an earlier one, which ROS has read, needs no reading of its texts.
"""

import struct

from peg_on_hole_ros.messages.decode import Malformed, checked_joints, checked_wrench
from peg_on_hole_ros.records import JointSample, WrenchSample

# Of the encapsulation, of which the rest says how much of the end is none of the message's.
_LITTLE_ENDIAN = b"\0\1\0\0"
_STAMP = struct.Struct("<iI")
# Behind the encapsulation and the stamp.
_TEXTS = 12
_SIX = struct.Struct("<6d")
_SECOND = 1_000_000_000


class WrenchReader:
    """Reads serialised geometry_msgs/WrenchStamped like one that was learnt."""

    def __init__(self) -> None:
        self._length = 0
        self._frame = b""

    def learn(self, payload: bytes, frame: str) -> None:
        """Take a message that has been read, and its frame_id."""
        text = frame.encode(errors="surrogateescape") + b"\0"
        self._frame = len(text).to_bytes(4, "little") + text
        at = _TEXTS + len(self._frame)
        self._numbers = at + (4 - at) % 8
        self._length = self._numbers + _SIX.size
        if not self._fits(payload):
            self._length = 0

    def _fits(self, payload):
        return (
            len(payload) == self._length
            and payload[:4] == _LITTLE_ENDIAN
            and payload[_TEXTS : _TEXTS + len(self._frame)] == self._frame
        )

    def read(self, payload: bytes) -> WrenchSample | Malformed | None:
        """Return the sample, as `wrench_sample` does; None: it has to be read as any other."""
        if not self._fits(payload):
            return None
        sec, nanosec = _STAMP.unpack_from(payload, 4)
        if nanosec >= _SECOND:
            return Malformed("bad_stamp")
        numbers = _SIX.unpack_from(payload, self._numbers)
        return checked_wrench(WrenchSample(sec * _SECOND + nanosec, numbers[:3], numbers[3:]))


class JointsReader:
    """
    Reads serialised sensor_msgs/JointState like one that was learnt.

    Parameters
    ----------
    needed : tuple of str
        See `joint_sample`.

    """

    def __init__(self, needed: tuple[str, ...]) -> None:
        self._needed = needed
        self._length = 0
        self._same: list[tuple[int, int, bytes]] = []

    def learn(self, payload: bytes, frame: str, names: tuple[str, ...], *counts: int) -> None:
        """Take a message that has been read: frame_id, names, lengths of its three arrays."""
        self._names, self._length, self._same = names, 0, []
        at = _TEXTS
        for text in (frame, None, *names):
            at += -at % 4
            if text is None:
                at = self._expect(at, len(names).to_bytes(4, "little"))
            else:
                data = text.encode(errors="surrogateescape") + b"\0"
                at = self._expect(at, len(data).to_bytes(4, "little") + data)
        starts = []
        for count in counts:
            at = self._expect(at + -at % 4, count.to_bytes(4, "little"))
            if count:
                at += (4 - at) % 8
            starts.append(at)
            at += 8 * count
        self._numbers, self._position = starts[0], struct.Struct(f"<{counts[0]}d")
        self._length = at
        if not self._fits(payload):
            self._length = 0

    def _expect(self, at, data):
        self._same.append((at, at + len(data), data))
        return at + len(data)

    def _fits(self, payload):
        return (
            len(payload) == self._length
            and payload[:4] == _LITTLE_ENDIAN
            and all(payload[begin:end] == data for begin, end, data in self._same)
        )

    def read(self, payload: bytes) -> JointSample | Malformed | None:
        """Return the sample, as `joint_sample` does; None: it has to be read as any other."""
        if not self._fits(payload):
            return None
        sec, nanosec = _STAMP.unpack_from(payload, 4)
        if nanosec >= _SECOND:
            return Malformed("bad_stamp")
        position = self._position.unpack_from(payload, self._numbers)
        sample = JointSample(sec * _SECOND + nanosec, self._names, position)
        return checked_joints(sample, self._needed)
