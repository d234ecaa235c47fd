"""In which steps a driver rounds what it sends."""

from collections.abc import Sequence
from math import sqrt

from peg_on_hole_ros.diagnosis.tuned import ROUNDING_STEPS


class Steps:
    """
    The coarsest of `ROUNDING_STEPS` in which all values so far lie.

    Attributes
    ----------
    step : float
        [N] or [N m]; 0: in none.

    """

    def __init__(self) -> None:
        self._at = 0
        self._first: tuple[float, ...] | None = None
        self._changed = False

    @property
    def step(self) -> float:
        """See above."""
        return ROUNDING_STEPS.sizes[self._at]

    def notice(self, values: Sequence[float]) -> bool:
        """Process values; return whether the step changes by them, or they are the first."""
        before, first = self._at, self._first is None
        if first:
            self._first = tuple(values)
        elif not self._changed:
            self._changed = tuple(values) != self._first
        while self.step and any(
            abs(x - self.step * round(x / self.step)) > 1e-6 * self.step for x in values
        ):
            self._at += 1
        return first or self._at != before

    @property
    def variance(self) -> float:
        """Of what rounding takes off, [N^2] or [N^2 m^2]."""
        return self.step**2 / 12.0

    def coarse(self, stddev: float) -> bool:
        """Return whether values that change are rounded more coarsely than a noise is wide."""
        return self._changed and self.variance > stddev**2

    def stddev(self, stddev: float) -> float:
        """Return a noise with that of rounding."""
        return sqrt(stddev**2 + self.variance)
