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
_U32 = struct.Struct("<I")
_SECOND = 1_000_000_000


def _text_end(payload, at):
    return at + 4 + _U32.unpack_from(payload, at)[0]


class _Learnt:
    """The length of a message that was read, and the parts of it in which others are the same."""

    def __init__(self) -> None:
        self._length = 0
        self._same: list[tuple[int, int, bytes]] = []

    def _fits(self, payload):
        return (
            len(payload) == self._length
            and payload[:4] == _LITTLE_ENDIAN
            and all(payload[begin:end] == data for begin, end, data in self._same)
        )


class WrenchReader(_Learnt):
    """Reads serialised geometry_msgs/WrenchStamped like one that was learnt."""

    def learn(self, payload: bytes) -> None:
        """Take a message that ROS has read."""
        self._length, at = 0, _text_end(payload, _TEXTS)
        self._same = [(_TEXTS, at, payload[_TEXTS:at])]
        self._numbers = at + (4 - at) % 8
        if payload[:4] == _LITTLE_ENDIAN and len(payload) == self._numbers + _SIX.size:
            self._length = len(payload)

    def read(self, payload: bytes) -> WrenchSample | Malformed | None:
        """Return the sample, as `wrench_sample` does; None: it has to be read as any other."""
        if not self._fits(payload):
            return None
        sec, nanosec = _STAMP.unpack_from(payload, 4)
        if nanosec >= _SECOND:
            return Malformed("bad_stamp")
        numbers = _SIX.unpack_from(payload, self._numbers)
        return checked_wrench(WrenchSample(sec * _SECOND + nanosec, numbers[:3], numbers[3:]))


class JointsReader(_Learnt):
    """
    Reads serialised sensor_msgs/JointState like one that was learnt.

    Parameters
    ----------
    needed : tuple of str
        See `joint_sample`.

    """

    def __init__(self, needed: tuple[str, ...]) -> None:
        super().__init__()
        self._needed = needed

    def learn(self, payload: bytes, names: tuple[str, ...]) -> None:
        """Take a message that ROS has read, and the names in it."""
        self._names, self._length, self._same = names, 0, []
        if payload[:4] != _LITTLE_ENDIAN:
            return
        end = _text_end(payload, _TEXTS)
        end += -end % 4 + 4
        for _ in names:
            end = _text_end(payload, end + -end % 4)
        begin = _TEXTS
        for array in range(3):
            end += -end % 4 + 4
            # A length is the same as before, and so is all before the first.
            self._same.append((begin, end, payload[begin:end]))
            count = _U32.unpack_from(payload, end - 4)[0]
            if count:
                end += (4 - end) % 8
            if array == 0:
                self._numbers, self._position = end, struct.Struct(f"<{count}d")
            end += 8 * count
            begin = end + -end % 4
        if len(payload) == end:
            self._length = end

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
