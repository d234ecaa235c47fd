"""How far friction lags behind what is told of it, in plain Python: the kernel is held to it."""

from peg_on_hole_ros.estimation.kernel.friction_lag import LAGS


class FrictionLag:
    """
    The sum of friction's movements, each forgotten by what has been told since.

    Parameters
    ----------
    value, variance : float
        As they are stated.

    Attributes
    ----------
    value, variance : float
        After the last correction.
    lag : float

    """

    def __init__(self, value, variance):
        self.value, self.variance, self.lag = value, variance, 0.0
        self._stated = variance

    def follow(self, value, variance):
        """Return the variance that friction is left with after a correction."""
        told = max(1.0 - variance / self.variance, 0.0) if self.variance > 0.0 else 0.0
        self.lag = (1.0 - told) * (self.lag + value - self.value)
        self.value = value
        self.variance = max(variance, min(LAGS * self.lag**2, self._stated))
        return self.variance

    def rest(self, value, variance):
        """Take friction for what it is, on its way with what else is learnt."""
        self.value, self.variance, self.lag = value, variance, 0.0
