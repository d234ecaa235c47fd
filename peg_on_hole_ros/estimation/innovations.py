"""Whether the innovations are as small as the stated noise makes them."""

from array import array
from bisect import bisect_left, insort

# Enough to tell 3.3 from the median of a chi-squared variable of 3 degrees of freedom, 2.37, by
# five standard deviations of a median (0.19).
WINDOW = 200
TOO_LARGE = 3.3


class InnovationWatch:
    """
    The running median of the normalised innovation squared, over WINDOW corrections.

    A wrong lever arm, tare, direction of the hole or level of noise raises every innovation; a
    reversal raises a few of them very much. The median sees the one and not the other.

    Attributes
    ----------
    median : float or None
        None until the window is full.
    too_large : bool
        Whether the median is above TOO_LARGE.

    """

    def __init__(self):
        self.restart()

    def restart(self):
        """Forget all innovations."""
        # Arrays, as their copies touch no numbers one by one.
        self._last, self._sorted = array("d"), array("d")
        self.median: float | None = None
        self.too_large = False

    def snapshot(self):
        """Return what `restore` takes back."""
        return self._last[:], self._sorted[:], self.median, self.too_large

    def restore(self, snapshot):
        """Go back to a snapshot; it can be gone back to again."""
        last, ordered, self.median, self.too_large = snapshot
        self._last, self._sorted = last[:], ordered[:]

    def add(self, nis: float):
        """Take a normalised innovation squared of 3 degrees of freedom, finite."""
        self._last.append(nis)
        insort(self._sorted, nis)
        if len(self._last) > WINDOW:
            del self._sorted[bisect_left(self._sorted, self._last.pop(0))]
        if len(self._last) == WINDOW:
            self.median = 0.5 * (self._sorted[WINDOW // 2 - 1] + self._sorted[WINDOW // 2])
            self.too_large = self.median > TOO_LARGE
