"""A watch over the innovations: too large, or leaning one way, for too long."""

from array import array
from bisect import bisect_left, insort

# Enough to tell 3.3 from the median of a chi-squared variable of 3 degrees of freedom, 2.37, by
# five standard deviations of a median (0.19).
WINDOW = 200
TOO_LARGE = 3.3
# A chi-squared variable of 3 degrees of freedom is above it once in 7e5 windows. Over 11 s of a
# working cycle the largest was 17, in a friction that is not as learnt after each turn.
DRIFTS = 30.0


class InnovationWatch:
    """
    Running median of the normalised innovation squared, and drift, over WINDOW corrections.

    A wrong lever arm, tare, direction of the hole or level of noise raises every innovation; a
    reversal raises a few of them very much. The median sees the one and not the other. What a
    parameter that is learnt can nearly make up for, as friction for a tilt, hardly raises them
    and yet pushes all one way: that is the drift, the square of their sum over WINDOW, each
    whitened by its covariance.

    Attributes
    ----------
    median : float or None
        None until the window is full.
    drift : float or None
        Of 3 degrees of freedom; likewise.
    too_large : bool
        Whether the median is above TOO_LARGE, or the drift above DRIFTS.

    """

    def __init__(self):
        self.restart()

    def restart(self):
        """Forget all innovations."""
        # Arrays, as their copies touch no numbers one by one; the first has four a piece.
        self._last, self._sorted = array("d"), array("d")
        self._sum = (0.0, 0.0, 0.0)
        self.median: float | None = None
        self.drift: float | None = None
        self.too_large = False

    def snapshot(self):
        """Return what `restore` takes back."""
        told = self._sum, self.median, self.drift, self.too_large
        return self._last[:], self._sorted[:], told

    def restore(self, snapshot):
        """Go back to a snapshot; it can be gone back to again."""
        last, ordered, told = snapshot
        self._last, self._sorted = last[:], ordered[:]
        self._sum, self.median, self.drift, self.too_large = told

    def add(self, nis: float, white=(0.0, 0.0, 0.0)):
        """
        Take an innovation.

        Parameters
        ----------
        nis : float
            Normalised and squared, 3 degrees of freedom, finite.
        white : tuple of 3 float
            Over the lower root of its covariance; zero where it was not used as predicted.

        """
        w0, w1, w2 = white
        s0, s1, s2 = self._sum
        self._last.extend((nis, w0, w1, w2))
        insort(self._sorted, nis)
        if len(self._sorted) > WINDOW:
            old, o0, o1, o2 = self._last[:4]
            del self._last[:4]
            del self._sorted[bisect_left(self._sorted, old)]
            s0, s1, s2 = s0 - o0, s1 - o1, s2 - o2
        s0, s1, s2 = self._sum = s0 + w0, s1 + w1, s2 + w2
        if len(self._sorted) == WINDOW:
            self.median = 0.5 * (self._sorted[WINDOW // 2 - 1] + self._sorted[WINDOW // 2])
            self.drift = (s0 * s0 + s1 * s1 + s2 * s2) / WINDOW
            self.too_large = self.median > TOO_LARGE or self.drift > DRIFTS
