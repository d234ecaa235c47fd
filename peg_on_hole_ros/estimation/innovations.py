"""What the innovations tell of settings, contact mode and friction."""

from collections import deque
from math import fsum
from typing import NamedTuple

from peg_on_hole_ros.estimation.watches import BalanceWatch, InnovationWatch, SurpriseWatch

# Over so many corrections the mean is taken that says whether a contact mode fits.
MEAN_OF = 20
# One that noise has thrown is no other contact, which surprises again and again: against a mode
# each counts as so much at most.
MOST_AGAINST_MODE = 30.0
EXPECTED = 3.0
# Friction that was begun anew is learnt in some tens of milliseconds.
DOUBTED_AGAIN_NS = 200_000_000


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

    def weigh(self, t_ns, white) -> bool:
        """
        Take by how much a prediction found the forces on the peg out of balance.

        Parameters
        ----------
        t_ns : int
            Its stamp [ns].
        white : tuple of 3 float
            See `BalanceWatch.add`.

        Returns
        -------
        bool
            Whether they have been so, to one side, by more than is stated.

        """
        if not self._white:
            return False
        self._balance.add(t_ns, white)
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
