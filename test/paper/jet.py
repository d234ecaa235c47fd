"""Values with exact first and second derivatives by two variables, truncated Taylor series."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Jet(NamedTuple):
    """
    A value with its gradient and Hessian by two variables.

    Attributes
    ----------
    v : float
    g : ndarray, shape (2,)
    h : ndarray, shape (2, 2)

    """

    v: float
    g: np.ndarray
    h: np.ndarray

    def __add__(self, other: Jet | float) -> Jet:  # type: ignore[override]
        """Return the sum."""
        o = _jet(other)
        return Jet(self.v + o.v, self.g + o.g, self.h + o.h)

    def __mul__(self, other: Jet | float) -> Jet:  # type: ignore[override]
        """Return the product."""
        o = _jet(other)
        cross = np.outer(self.g, o.g)
        return Jet(
            self.v * o.v,
            self.v * o.g + o.v * self.g,
            self.v * o.h + o.v * self.h + cross + cross.T,
        )

    def __neg__(self) -> Jet:
        """Return the opposite."""
        return Jet(-self.v, -self.g, -self.h)

    def __sub__(self, other: Jet | float) -> Jet:
        """Return the difference."""
        return self + (-_jet(other))

    def __rsub__(self, other: Jet | float) -> Jet:
        """Return the difference from a number."""
        return _jet(other) - self

    def __truediv__(self, other: Jet | float) -> Jet:
        """Return the quotient."""
        o = _jet(other)
        return self * o.through(1 / o.v, -1 / o.v**2, 2 / o.v**3)

    def __rtruediv__(self, other: Jet | float) -> Jet:
        """Return a number over this."""
        return _jet(other) / self

    def __radd__(self, other: Jet | float) -> Jet:
        """Return the sum."""
        return self + other

    def __rmul__(self, other: Jet | float) -> Jet:  # type: ignore[override]
        """Return the product."""
        return self * other

    def through(self, f: float, df: float, ddf: float) -> Jet:
        """Return a function of this from its value and derivatives at v."""
        return Jet(f, df * self.g, df * self.h + ddf * np.outer(self.g, self.g))

    def sqrt(self) -> Jet:
        """Return the square root."""
        root = np.sqrt(self.v)
        return self.through(root, 1 / (2 * root), -1 / (4 * root**3))

    def sin(self) -> Jet:
        """Return the sine."""
        s, c = np.sin(self.v), np.cos(self.v)
        return self.through(s, c, -s)

    def cos(self) -> Jet:
        """Return the cosine."""
        s, c = np.sin(self.v), np.cos(self.v)
        return self.through(c, -s, -c)


def variables(first: float, second: float) -> tuple[Jet, Jet]:
    """Return two independent variables as jets."""
    zero = np.zeros((2, 2))
    return Jet(first, np.array([1.0, 0.0]), zero), Jet(second, np.array([0.0, 1.0]), zero)


def _jet(x):
    return x if isinstance(x, Jet) else Jet(x, np.zeros(2), np.zeros((2, 2)))
