"""Symmetric three by three matrices in scalars."""

from peg_on_hole_ros.mechanics.kernel import inlined


@inlined
def factors(s00, s10, s11, s20, s21, s22):
    """Return the factors L D L.T of a symmetric matrix: l10, l20, l21 and the three of D."""
    l10, l20 = s10 / s00, s20 / s00
    d1 = s11 - l10 * s10
    l21 = (s21 - l20 * s10) / d1
    d2 = s22 - l20 * s20 - l21 * l21 * d1
    return l10, l20, l21, s00, d1, d2


@inlined
def solve(factors, t0, t1, t2):
    """Return the solution of L D L.T g = t."""
    l10, l20, l21, d0, d1, d2 = factors
    t1 -= l10 * t0
    t2 -= l20 * t0 + l21 * t1
    g2 = t2 / d2
    g1 = t1 / d1 - l21 * g2
    return t0 / d0 - l10 * g1 - l20 * g2, g1, g2


@inlined
def times(s, g0, g1, g2):
    """Return the product of a symmetric matrix, as of `factors`, and a vector."""
    s00, s10, s11, s20, s21, s22 = s
    return (
        s00 * g0 + s10 * g1 + s20 * g2,
        s10 * g0 + s11 * g1 + s21 * g2,
        s20 * g0 + s21 * g1 + s22 * g2,
    )
