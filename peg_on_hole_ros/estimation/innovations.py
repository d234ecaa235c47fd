"""What the innovations tell of settings and of the contact mode."""

from collections import deque
from math import fsum

from peg_on_hole_ros.estimation.watches import InnovationWatch

# Over so many corrections the mean is taken that says whether a contact mode fits.
MEAN_OF = 20
# One that noise has thrown is no other contact, which surprises again and again: against a mode
# each counts as so much at most.
MOST_AGAINST_MODE = 30.0
EXPECTED = 3.0


class Innovations:
    """
    What the innovations tell of settings and of the contact mode.

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
        self._watch = InnovationWatch()
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

    def snapshot(self):
        """Return what `restore` takes back."""
        return tuple(self._last), self.mean, self.misfit, self._watch.snapshot()

    def restore(self, snapshot):
        """Go back to a snapshot; it can be gone back to again."""
        last, self.mean, self.misfit, watch = snapshot
        self._last = deque(last, maxlen=MEAN_OF)
        self._watch.restore(watch)

    def add(self, nis, innovation, in_contact, touching) -> bool:
        """
        Take an innovation.

        Parameters
        ----------
        nis : float
            Normalised and squared, 3 degrees of freedom, finite.
        innovation : tuple of 3 float, or None
            Whitened; None: it was not used.
        in_contact : bool
            Whether the contact equations are in force.
        touching : bool
            Whether it says something of the settings: in contact, or in a mode that is doubtful.

        Returns
        -------
        bool
            Whether the innovations are larger than stated.

        """
        # Without contacts they say nothing for or against three: what they miss by must not keep
        # the mode from being tried again.
        self._last.append(nis if in_contact else EXPECTED)
        self.mean = fsum(self._last) / len(self._last)
        against = (min(value, MOST_AGAINST_MODE) for value in self._last)
        self.misfit = fsum(against) / len(self._last)
        if not touching:
            return False
        known = self._white and innovation is not None
        self._watch.add(nis, innovation if known else (0.0, 0.0, 0.0))
        return self._watch.too_large

    def told(self) -> dict[str, float]:
        """Return median and drifts by the names they are published under, once there are any."""
        told = {
            "nis_median": self._watch.median,
            "nis_drift": self._watch.drift if self._white else None,
        }
        return {name: value for name, value in told.items() if value is not None}
