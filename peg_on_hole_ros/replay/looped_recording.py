"""Whether the stamps of a topic come again, as in a recording that was played in a loop."""

import numpy as np

# Farther back than messages are late [ns].
_BACK_NS = 100_000_000
_FEWEST_BEHIND = 20
# One stamp in eight is remembered, by a multiplicative hash.
_HASH_FACTOR, _HASH_SHIFT = np.uint64(0x9E3779B97F4A7C15), np.uint64(61)


def contents(values: np.ndarray) -> np.ndarray:
    """Return a number for each row of values, shape (n,): alike where they are, bit for bit."""
    bits = np.ascontiguousarray(values, float).view(np.uint64)
    factors = _HASH_FACTOR * np.arange(1, 2 * bits.shape[1], 2, dtype=np.uint64)
    return (bits * factors).sum(axis=1, dtype=np.uint64)


class LoopedRecording:
    """
    Looks at the stamps of one topic in the order of a recording, with what bears them.

    Two publishers whose clocks are apart have stamps that go back as well, but not the same ones;
    where a clock is set back the same stamps come again, of other values.
    """

    def __init__(self) -> None:
        self._newest: int | None = None
        self._known: list[np.ndarray] = []
        self._behind = self._asked = self._again = self._back_ns = 0

    def add(self, t_ns: np.ndarray, content: np.ndarray) -> None:
        """Take stamps [ns], and a number for what each message holds: alike where it is."""
        if not len(t_ns):
            return
        newest = np.maximum.accumulate(t_ns)
        if self._newest is not None:
            newest = np.maximum(newest, self._newest)
        back = newest - t_ns
        behind = back > _BACK_NS
        self._newest = int(newest[-1])
        remembered = (t_ns.astype(np.uint64) * _HASH_FACTOR) >> _HASH_SHIFT == 0
        messages = t_ns.astype(np.uint64) * _HASH_FACTOR + content
        self._known.append(messages[remembered & ~behind])
        if behind.any():
            asked = messages[remembered & behind]
            known = np.concatenate(self._known)
            self._known = [known]
            self._behind += int(behind.sum())
            self._asked += len(asked)
            self._again += int(np.isin(asked, known).sum())
            self._back_ns = max(self._back_ns, int(back.max()))

    @property
    def seconds(self) -> float:
        """How far stamps went back, at most, to come again [s]; 0: there is no loop."""
        some = self._behind >= _FEWEST_BEHIND and self._asked > 0
        return self._back_ns * 1e-9 if some and 2 * self._again > self._asked else 0.0
