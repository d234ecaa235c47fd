"""Messages of a topic in the order of their stamps, though some came behind others."""

import numpy as np

# Messages that may be overtaken by ones that came later; one whose stamp falls by more is of
# another recording [ns].
_OVERTAKEN = 256
_NEW_RECORDING_NS = 1_000_000_000


class ByStamp:
    """Messages in the order of their stamps, some behind those that come."""

    def __init__(self) -> None:
        self._t_ns, self._rows = np.empty(0, np.int64), np.empty((0, 0))

    def take(self, t_ns: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return stamps and rows that no later one precedes, the last of those before first.

        Parameters
        ----------
        t_ns : ndarray of int64, shape (n,)
            In the order of a bag [ns].
        rows : ndarray, shape (n, m)

        """
        if len(self._t_ns):
            t_ns = np.concatenate([self._t_ns, t_ns])
            rows = np.concatenate([self._rows, rows])
        part = np.cumsum(np.diff(t_ns, prepend=t_ns[:1]) < -_NEW_RECORDING_NS)
        order = np.lexsort((t_ns, part))
        t_ns, rows = t_ns[order], rows[order]
        first = max(len(t_ns) - _OVERTAKEN, 0)
        self._t_ns, self._rows = t_ns[first:], rows[first:]
        return t_ns[: first + 1], rows[: first + 1]

    @property
    def rest(self) -> tuple[np.ndarray, np.ndarray]:
        """The last of those that were returned, and all behind it."""
        return self._t_ns, self._rows
