"""The serialised messages of one estimate after the other, in a buffer that is laid out once."""

import numpy as np

from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.output import Message
from peg_on_hole_ros.messages.plain import header, xyz
from peg_on_hole_ros.messages.published import POSE, SIZE, publish_row

# Of a message: behind the four bytes of its encapsulation numbers lie at multiples of eight.
_FIRST, _ALIGNED = 4, 8


class EstimateEncoder:
    """
    Writes the messages that come with every estimate; they differ in stamp and numbers alone.

    Parameters
    ----------
    messages : list of Message
        Those of any estimate, in the order in which they are published.

    """

    def __init__(self, messages: list[Message]) -> None:
        places: list[int] = []
        parts = []
        self._bounds: list[tuple[str, int, int]] = []
        end = 0
        for suffix, ros_type, fields in messages:
            data, runs = Encoder(ros_type).template(fields)
            begin = end + (_FIRST - end) % _ALIGNED
            parts.append(bytes(begin - end) + data)
            end = begin + len(data)
            self._bounds.append((suffix, begin, end))
            for offset, first, last, _ in runs:
                at = (begin + offset) // _ALIGNED
                places.extend(range(at, at + last - first))
        room = np.zeros(end + -end % _ALIGNED, np.uint8)
        room[:end] = np.frombuffer(b"".join(parts), np.uint8)
        self._room, self._doubles = room.data, room.view("<f8")
        self._words = room.view("<u4")
        self._places = np.array(places)
        self._seconds = np.array([(begin + _FIRST) // 4 for _, begin, _ in self._bounds])
        self._numbers = np.empty(SIZE)

    def pose(self, t_ns: int) -> dict:
        """Return header and pose of what was last written, as PoseWithCovarianceStamped."""
        x, y, z, *turn = self._numbers[POSE : POSE + 7].tolist()
        there = {"position": xyz((x, y, z)), "orientation": dict(zip("xyzw", turn))}
        return {"header": header(t_ns), "pose": {"pose": there}}

    def __call__(self, t_ns: int, row: np.ndarray) -> list[tuple[str, bytes]]:
        """
        Return (topic under the node's name, payload) of each message.

        Parameters
        ----------
        t_ns : int
            Stamp [ns].
        row : ndarray, shape (output_row.SIZE,)

        """
        publish_row(row, self._numbers)
        self._doubles[self._places] = self._numbers
        seconds, nanoseconds = divmod(t_ns, 1_000_000_000)
        # Seconds are signed: before 1970 they wrap.
        self._words[self._seconds] = seconds & 0xFFFFFFFF
        self._words[self._seconds + 1] = nanoseconds
        return [(suffix, bytes(self._room[begin:end])) for suffix, begin, end in self._bounds]
