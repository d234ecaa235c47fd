"""Draws that read like ranges, and what a drawn case is called and seeded with."""

from typing import ClassVar, NamedTuple

import numpy as np


class Draw:
    """Draws that read like ranges."""

    def __init__(self, seed):
        self._rng = np.random.default_rng(seed)

    def even(self, low, high) -> float:
        """Return a number of a range, each as likely."""
        return float(self._rng.uniform(low, high))

    def log(self, low, high) -> float:
        """Return a number of a range, each order of magnitude as likely."""
        return float(np.exp(self._rng.uniform(np.log(low), np.log(high))))

    def normal(self, stddev) -> float:
        """Return a normally distributed number."""
        return float(self._rng.normal(0.0, stddev))

    def sign(self) -> float:
        """Return 1 or -1."""
        return float(self._rng.choice((-1.0, 1.0)))

    def chance(self, share) -> bool:
        """Return True with a probability."""
        return bool(self._rng.random() < share)


class _Case(NamedTuple):
    family: str
    number: int
    set: str = "scoring"


class DrawnCase(_Case):
    """
    One scene: its family, its number in it, and whether it is for tuning or for scoring.

    Attributes
    ----------
    SEEDS : dict of str to int
        First of the numbers that a draw is seeded with, by set: no scene is of both.
    FAMILIES : tuple of str

    """

    __slots__ = ()
    SEEDS: ClassVar[dict[str, int]] = {}
    FAMILIES: ClassVar[tuple[str, ...]] = ()

    def __str__(self):
        """Return a name for files and tables."""
        return f"{self.family}_{self.number:03d}_{self.set}"

    @property
    def seed(self) -> list[int]:
        """Return what the draw, and with one more number the noise, is seeded with."""
        return [self.SEEDS[self.set], self.FAMILIES.index(self.family), self.number]
