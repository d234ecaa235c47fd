"""Which contact the peg is in, as far as wrench, tilt and innovations tell."""

from math import erf, exp, sqrt
from typing import NamedTuple

from peg_on_hole_ros.options import MonitorOptions

MODES = ("three_point", "two_point", "open", "unknown")

# A running mean of the normalised innovation (3 degrees of freedom) above this is no noise: over
# 20 corrections its standard deviation is about 0.5.
NIS_LIMIT = 9.0
_SMOOTHING = 0.005


def normal_probability(z: float) -> float:
    """Return the probability that a standard normal variable is below z."""
    return 0.5 * (1.0 + erf(z / sqrt(2.0)))


class Evidence(NamedTuple):
    """
    What one wrench message shows.

    Attributes
    ----------
    t : float
        [s].
    contact_force, force_stddev : float
        Size of the force that the rim must carry, and its noise [N].
    tilt_margin, tilt_stddev : float
        gamma - gamma0 and its standard deviation [rad].
    normal, normal_stddev : sequence of 3 float or None
        Reactions if the contact is three-point [N]; None if the equations have none.
    nis : float
        Running mean of the normalised innovation squared.

    """

    t: float
    contact_force: float
    force_stddev: float
    tilt_margin: float
    tilt_stddev: float
    normal: object
    normal_stddev: object
    nis: float


class ContactMode:
    """
    The contact mode, with dwell: a mode must be the best one for a while before it is declared.

    Attributes
    ----------
    mode : str
        One of MODES.
    validity : float
        Probability that pose and wrench fit three-point contact.
    below : float
        Probability that gamma is below gamma0.

    """

    def __init__(self, options: MonitorOptions):
        self.options = options
        self.restart()

    def restart(self):
        """Forget all evidence."""
        self.mode = "unknown"
        self.validity = 0.0
        self.below = 0.0
        self._candidate = "unknown"
        self._since = None
        self._last = None
        self._force = 0.0
        self._press = 0.0

    def update(self, evidence: Evidence) -> str:
        """Take one piece of evidence and return the mode."""
        options = self.options
        dt = 0.0 if self._last is None else evidence.t - self._last
        first = self._last is None
        self._last = evidence.t
        gain = 1.0 if first else 1.0 - exp(-max(dt, 0.0) / _SMOOTHING)
        self._force += gain * (evidence.contact_force - self._force)
        margin = self._force - options.contact_force_threshold
        touching = normal_probability(margin / max(evidence.force_stddev, 1e-9))
        self.below = normal_probability(-evidence.tilt_margin / max(evidence.tilt_stddev, 1e-12))
        press = 0.0
        if evidence.normal is not None:
            press = 1.0
            for N, stddev in zip(evidence.normal, evidence.normal_stddev, strict=True):
                press *= normal_probability(N / max(stddev, 1e-9))
        self._press += gain * (press - self._press)
        fits = 1.0 / (1.0 + exp(min(evidence.nis - NIS_LIMIT, 50.0)))
        self.validity = touching * (1.0 - self.below) * self._press * fits
        if touching < 0.5:
            best = "open"
        elif self.below > 0.5:
            best = "two_point"
        else:
            best = "three_point" if self.validity > 0.5 else "unknown"
        if best != self._candidate:
            self._candidate, self._since = best, evidence.t
        if best != self.mode and evidence.t - self._since >= options.mode_dwell:
            self.mode = best
        return self.mode
