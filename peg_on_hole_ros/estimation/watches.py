"""Watches over what a filter sees: too large, leaning one way, or out of balance for too long."""

from array import array
from bisect import bisect_left, insort
from math import exp, fsum

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


class BalanceWatch:
    """
    Whether the forces on a bridged peg are out of balance to one side.

    Where noise stops the peg within most steps none is believed, and innovations are those of
    constant rates: they tell of no wrong setting. What is left is that a held peg hardly
    accelerates. By how much the equations say that it does, over its spread, is limited to LIMIT
    either way, as a peg that turns round is off by far, and for a short while only; a wrong tare
    is for as long as it lasts.

    Attributes
    ----------
    drift : float or None
        Square of the sum over some MEMORY, over its variance: of 3 degrees of freedom or less, if
        all is as stated and rates are steady. None before FEWEST have been weighed.

    """

    LIMIT = 1.0
    # Of a normal variable so limited.
    VARIANCE = 0.516
    # [s]
    MEMORY = 0.5
    FEWEST = 10
    # In 3400 simulated runs at 100 Hz to 1 kHz with all as stated 101 was the most, in turns
    # back and forth at low noise, and 30 in slides without any. A tare that is off by ten standard
    # deviations of the force is at 200 and more.
    TOO_FAR = 120.0

    def __init__(self):
        self.restart()

    def restart(self):
        """Forget all."""
        self._sum, self._weight, self._count = (0.0, 0.0, 0.0), 0.0, 0.0
        self._t_ns: int | None = None
        self.drift: float | None = None

    @property
    def too_far(self) -> bool:
        """Whether the drift is above TOO_FAR."""
        return self.drift is not None and self.drift > self.TOO_FAR

    def snapshot(self):
        """Return what `restore` takes back."""
        return self._sum, self._weight, self._count, self._t_ns, self.drift

    def restore(self, snapshot):
        """Go back to a snapshot; it can be gone back to again."""
        self._sum, self._weight, self._count, self._t_ns, self.drift = snapshot

    def add(self, t_ns: int, white):
        """
        Take one weighing.

        Parameters
        ----------
        t_ns : int
            Stamp [ns], after that of the one before.
        white : tuple of 3 float
            Accelerations less those that are expected, over the lower root of their covariance.

        """
        since = 0 if self._t_ns is None else t_ns - self._t_ns
        kept, self._t_ns = exp(-since * 1e-9 / self.MEMORY), t_ns
        self._sum = tuple(
            kept * total + max(-self.LIMIT, min(self.LIMIT, value))
            for total, value in zip(self._sum, white, strict=True)
        )
        self._weight = kept * kept * self._weight + 1.0
        self._count = kept * self._count + 1.0
        if self._count >= self.FEWEST or self.drift is not None:
            squares = fsum(total * total for total in self._sum)
            self.drift = squares / (self.VARIANCE * self._weight)


class SurpriseWatch:
    """
    Whether innovations under contact have been too large for some time on end: Page's test.

    Each adds what it is above EXCESS, up to MOST_AT_ONCE, to a sum that is not below zero; when it
    passes ENOUGH, it has been: after four in a row that are far too large, and not once in a
    million that are as stated.
    """

    EXCESS = 6.0
    MOST_AT_ONCE = 14.0
    ENOUGH = 30.0

    def __init__(self):
        self.total = 0.0

    def add(self, nis: float) -> bool:
        """Take a normalised innovation squared, 3 degrees of freedom; begin anew after a yes."""
        self.total = max(0.0, self.total + min(nis, self.MOST_AT_ONCE) - self.EXCESS)
        if self.total <= self.ENOUGH:
            return False
        self.total = 0.0
        return True
