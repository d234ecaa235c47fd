"""Messages that have arrived and wait for the estimator, two sources merged by their stamps."""

import struct
from collections import deque
from collections.abc import Iterator

MOST_ARRIVALS = 64  # 40 ms at 1.5 kHz; a longer wait would be felt in the output

_STAMP = struct.Struct("<iI")
_BIG_ENDIAN_STAMP = struct.Struct(">iI")


class Arrivals:
    """
    DDS keeps no order between topics: behind a busy moment all wrenches may come first.

    The joint states among them would then be late. So what is there together is handed on in the
    order of stamps, each source for itself in the order in which it came.
    """

    def __init__(self):
        self._wrench: deque[bytes] = deque()
        self._joints: deque[bytes] = deque()

    def __len__(self) -> int:
        """Return how many wait."""
        return len(self._wrench) + len(self._joints)

    def wrench(self, payload: bytes) -> None:
        """Take a serialised WrenchStamped."""
        self._wrench.append(payload)

    def joints(self, payload: bytes) -> None:
        """Take a serialised JointState."""
        self._joints.append(payload)

    def take(self) -> Iterator[tuple[str, bytes]]:
        """Yield and remove (source, payload); of equal stamps the joint state comes first."""
        while self._wrench or self._joints:
            if not self._wrench or (
                self._joints and stamp_ns(self._joints[0]) <= stamp_ns(self._wrench[0])
            ):
                yield "joints", self._joints.popleft()
            else:
                yield "wrench", self._wrench.popleft()


def stamp_ns(payload: bytes) -> int:
    """Return the stamp [ns] of a serialised message that begins with a header; 0 for a stump."""
    if len(payload) < 12:
        return 0
    sec, nanosec = (_STAMP if payload[1] & 1 else _BIG_ENDIAN_STAMP).unpack_from(payload, 4)
    return sec * 1_000_000_000 + nanosec
