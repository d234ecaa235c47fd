"""How friction moved of late, in plain Python: what `moving_friction` is held to."""

from math import sqrt

from peg_on_hole_ros.estimation.kernel.moving_friction import OF_LATE, ON_ITS_WAY, SURELY


class FrictionOfLate:
    """
    Friction and its standard deviation as they were of late.

    Parameters
    ----------
    value, stddev : float
        As they are stated.

    Attributes
    ----------
    value, stddev : float
        Means over OF_LATE.

    """

    def __init__(self, value, stddev):
        self.value, self.stddev, self._stated = value, stddev, stddev**2

    def widened(self, value, variance):
        """Return the variance that friction is left with, for how far it is on its way."""
        fell = SURELY * max(self.stddev - sqrt(variance), 0.0)
        beyond = max(abs(value - self.value) - fell, 0.0)
        return max(variance, min((ON_ITS_WAY * beyond) ** 2, self._stated))

    def follow(self, value, variance, dt):
        """Follow friction and its variance, dt [s] after the last correction."""
        share = min(dt / OF_LATE, 1.0)
        self.value += share * (value - self.value)
        self.stddev += share * (sqrt(variance) - self.stddev)
