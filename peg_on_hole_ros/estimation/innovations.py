"""Whether the innovations are as small, and as evenly spread, as the stated noise makes them."""

from array import array
from bisect import bisect_left, insort
from collections import deque
from math import exp, fsum
from typing import NamedTuple

# Enough to tell 3.3 from the median of a chi-squared variable of 3 degrees of freedom, 2.37, by
# five standard deviations of a median (0.19).
WINDOW = 200
TOO_LARGE = 3.3
# A chi-squared variable of 3 degrees of freedom is above it once in 7e5 windows. Over 11 s of a
# working cycle the largest was 17, in a friction that is not as learnt after each turn.
DRIFTS = 30.0
# Over so many corrections the mean is taken that says whether a contact mode fits.
MEAN_OF = 20
# One that noise has thrown is no other contact, which surprises again and again: against a mode
# each counts as so much at most.
MOST_AGAINST_MODE = 30.0
EXPECTED = 3.0
# Friction that was begun anew is learnt in some tens of milliseconds.
DOUBTED_AGAIN_NS = 200_000_000


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
    MEMORY = 0.3
    FEWEST = 10
    # In 3400 simulated runs at 100 Hz to 1 kHz with all as stated 94 was the most, in turns back
    # and forth at low noise, and 29 in slides without any. A tare that is off by ten standard
    # deviations of the force is at 200 and more.
    TOO_FAR = 120.0

    def __init__(self):
        self.restart()

    def restart(self):
        """Forget all."""
        self._sum, self._weight, self._count = (0.0, 0.0, 0.0), 0.0, 0.0
        self.drift: float | None = None

    @property
    def too_far(self) -> bool:
        """Whether the drift is above TOO_FAR."""
        return self.drift is not None and self.drift > self.TOO_FAR

    def snapshot(self):
        """Return what `restore` takes back."""
        return self._sum, self._weight, self._count, self.drift

    def restore(self, snapshot):
        """Go back to a snapshot; it can be gone back to again."""
        self._sum, self._weight, self._count, self.drift = snapshot

    def add(self, dt: float, white):
        """
        Take one weighing.

        Parameters
        ----------
        dt : float
            Time since the prediction before [s].
        white : tuple of 3 float
            Accelerations less those that are expected, over the lower root of their covariance.

        """
        kept = exp(-dt / self.MEMORY)
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


class Told(NamedTuple):
    """
    What one innovation has told.

    Attributes
    ----------
    too_large : int
        How many watches find the innovations larger than stated.
    friction : bool
        Whether friction does not fit, and is to be begun anew.

    """

    too_large: int
    friction: bool


class Innovations:
    """
    What the innovations tell of settings, contact mode and friction.

    Parameters
    ----------
    white : bool
        Whether innovations are white: where bias or tilt are learnt they are not.

    Attributes
    ----------
    mean : float
        Of the last MEAN_OF, normalised and squared; EXPECTED before there are any.
    misfit : float
        That mean with MOST_AGAINST_MODE of each at most.

    """

    def __init__(self, white: bool):
        self._white = white
        self._watch, self._surprises = InnovationWatch(), SurpriseWatch()
        self._balance = BalanceWatch()
        self.restart()

    @property
    def any(self) -> bool:
        """Whether there are any."""
        return bool(self._last)

    def restart(self):
        """Forget all innovations."""
        self._last: deque[float] = deque(maxlen=MEAN_OF)
        self.mean = self.misfit = EXPECTED
        self._watch.restart()
        self._balance.restart()
        self._surprises.total = 0.0
        self._doubted_ns = -DOUBTED_AGAIN_NS

    def snapshot(self):
        """Return what `restore` takes back."""
        means = self.mean, self.misfit
        told = tuple(self._last), means, self._surprises.total, self._doubted_ns
        return told, self._watch.snapshot(), self._balance.snapshot()

    def restore(self, snapshot):
        """Go back to a snapshot; it can be gone back to again."""
        (last, means, self._surprises.total, self._doubted_ns), watch, balance = snapshot
        self.mean, self.misfit = means
        self._last = deque(last, maxlen=MEAN_OF)
        self._watch.restore(watch)
        self._balance.restore(balance)

    def weigh(self, dt, white) -> bool:
        """
        Take by how much a prediction found the forces on the peg out of balance.

        Parameters
        ----------
        dt : float
            Of the prediction [s].
        white : tuple of 3 float
            See `BalanceWatch.add`.

        Returns
        -------
        bool
            Whether they have been so, to one side, by more than is stated.

        """
        if not self._white:
            return False
        self._balance.add(dt, white)
        return self._balance.too_far

    def add(self, t_ns, nis, kalman, used, in_contact, touching) -> Told:
        """
        Take an innovation.

        Parameters
        ----------
        t_ns : int
            Stamp [ns].
        nis : float
            Normalised and squared, 3 degrees of freedom, finite.
        kalman : ContactFilter
            Right after the correction.
        used : bool
            Whether it was corrected as predicted, without any widening.
        in_contact : bool
            Whether the contact equations predicted it.
        touching : bool
            Whether it says something of the settings: in contact, or in a mode that is doubtful.

        """
        # Constant rates say nothing for or against three contacts: what they miss by must not
        # keep the mode from being tried again.
        self._last.append(nis if in_contact else EXPECTED)
        self.mean = fsum(self._last) / len(self._last)
        against = (min(value, MOST_AGAINST_MODE) for value in self._last)
        self.misfit = fsum(against) / len(self._last)
        too_large = 0
        if touching:
            # What was not learnt from one innovation is in the next.
            white = used and self._white and not kalman.held_back
            self._watch.add(nis, kalman.white_innovation() if white else (0.0, 0.0, 0.0))
            too_large += self._watch.too_large
        # A peg that turns round surprises whatever its friction is.
        doubt = in_contact and kalman.tells_friction and self._surprises.add(nis)
        if doubt:
            # What surprises again soon after is something else.
            again = t_ns - self._doubted_ns <= DOUBTED_AGAIN_NS
            self._doubted_ns = t_ns
            too_large += again
            doubt = not again
        return Told(too_large, doubt)

    def told(self) -> dict[str, float]:
        """Return median and drifts by the names they are published under, once there are any."""
        told = {
            "nis_median": self._watch.median,
            "nis_drift": self._watch.drift if self._white else None,
            "balance_drift": self._balance.drift,
        }
        return {name: value for name, value in told.items() if value is not None}
