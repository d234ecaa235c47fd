"""Messages that have arrived and wait for the estimator, two sources merged by their stamps."""

from collections import deque
from collections.abc import Callable, Iterator

from peg_on_hole_ros.messages.cdr_layout import stamp_ns


class WaitingMessages:
    """
    DDS keeps no order between topics: behind a busy moment all wrenches may come first.

    The joint states among them would then be late. So what is there together is handed on in the
    order of stamps, each source for itself in the order in which it came.

    Parameters
    ----------
    most : int, optional
        How many of each source may wait; beyond, what is next in the order of stamps is pushed
        out, of either source: one alone would leave the other behind, and the node would work
        off what is oldest of it only. None: any number.
    pushed_out : callable, optional
        Called with the source, `wrench` or `joints`, of each message that is.

    Attributes
    ----------
    received : int
        How many have come, whatever became of them.

    """

    def __init__(
        self, most: int | None = None, pushed_out: Callable[[str], None] = lambda source: None
    ) -> None:
        self._waiting: dict[str, deque[bytes]] = {"wrench": deque(), "joints": deque()}
        self._wrench, self._joints = self._waiting.values()
        self._most, self._pushed_out = most, pushed_out
        self.received = 0

    def __len__(self) -> int:
        """Return how many wait."""
        return len(self._wrench) + len(self._joints)

    def wrench(self, payload: bytes) -> None:
        """Take a serialised WrenchStamped."""
        self._add("wrench", payload)

    def joints(self, payload: bytes) -> None:
        """Take a serialised JointState."""
        self._add("joints", payload)

    def _add(self, source, payload):
        waiting = self._waiting[source]
        waiting.append(payload)
        self.received += 1
        while self._most is not None and len(waiting) > self._most:
            self._pushed_out(self._next()[0])

    def take(self) -> Iterator[tuple[str, bytes]]:
        """Yield and remove (source, payload); of equal stamps the joint state comes first."""
        while self._wrench or self._joints:
            yield self._next()

    def _next(self):
        if not self._wrench or (
            self._joints and stamp_ns(self._joints[0]) <= stamp_ns(self._wrench[0])
        ):
            return "joints", self._joints.popleft()
        return "wrench", self._wrench.popleft()
