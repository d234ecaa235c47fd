"""Stamps of the messages of one kind that came of late: tells one that comes twice."""

from collections import deque

import numpy as np

# Stamps that are kept at most, some 1 MB: of 1.5 s, the longest reach, at 5 kHz.
MAX_STAMPS = 8192


class RecentStamps:
    """
    The stamps from `reach_ns` behind the estimate on.

    Parameters
    ----------
    reach_ns : int
        How far behind the estimate a message may be that is still used [ns].

    """

    def __init__(self, reach_ns: int) -> None:
        self._reach_ns = reach_ns
        self._order: deque[int] = deque()
        self._stamps: set[int] = set()

    def __len__(self) -> int:
        """Return how many are kept."""
        return len(self._order)

    def clear(self) -> None:
        """Forget all of them."""
        self._order.clear()
        self._stamps.clear()

    def extend(self, stamps: np.ndarray, now_ns: int) -> None:
        """
        Take stamps that are above all before and above one another, as `take` would each.

        Parameters
        ----------
        stamps : ndarray of int64
            [ns].
        now_ns : int
            Stamp that the estimate had come to before the last of them [ns].

        """
        oldest = now_ns - self._reach_ns
        new = stamps[np.searchsorted(stamps, oldest) :][-MAX_STAMPS:].tolist()
        order = self._order
        while order and (order[0] < oldest or len(order) + len(new) > MAX_STAMPS):
            self._stamps.remove(order.popleft())
        order.extend(new)
        self._stamps.update(new)

    def take(self, t_ns: int, now_ns: int) -> bool:
        """
        Take the stamp of a message; return whether it is the first of that stamp.

        Parameters
        ----------
        t_ns : int
            [ns].
        now_ns : int
            Stamp that the estimate has come to [ns].

        """
        order, stamps, oldest = self._order, self._stamps, now_ns - self._reach_ns
        while order and (order[0] < oldest or len(order) >= MAX_STAMPS):
            stamps.remove(order.popleft())
        if t_ns in stamps:
            return False
        order.append(t_ns)
        stamps.add(t_ns)
        return True
