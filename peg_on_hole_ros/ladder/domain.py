"""Where a rung may stand: dimensionless numbers of a state, their limits, bounds on the error."""

from math import fabs, inf, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.ladder.rungs import (
    ALIGN,
    DYNAMIC,
    QUASI_STATIC,
    SMALL_ANGLE,
    force_columns,
)
from peg_on_hole_ros.mechanics.kernel import closed_forms, compiled, inlined
from peg_on_hole_ros.mechanics.reference import six_equations


class Numbers(NamedTuple):
    """
    What the full equations say of a state, without dimensions.

    Attributes
    ----------
    tilt : float
        gamma [rad]: what the small-angle form leaves out grows as its square.
    excess : float
        (gamma - gamma0)/gamma0.
    inertia : float
        Mass times the mass centre's acceleration over the largest reaction.
    turning : float
        The part of `inertia` that psi brings in, by its acceleration and its rate.
    slip, slide : float
        Speed that phi' and psi' give the contacts, over that and the least that gamma' gives one.
    margin : float
        Determinant of the six equations over its frictionless value; 0 is singular.
    balance : float
        The same of the balance of forces alone, which is singular elsewhere.

    """

    tilt: float
    excess: float
    inertia: float
    turning: float
    slip: float
    slide: float
    margin: float
    balance: float


# Beyond these a rung is not tried, whatever its error at the moment: it would not keep.
MOST_TILT = 0.5
MOST_INERTIA = 0.5
MOST_TURNED = 0.3
LEAST_MARGIN, LEAST_BALANCE = 0.02, 0.05
# What the small-angle form leaves out of force and geometry, over gamma squared; of random states
# one in a hundred has more, where slip and slide all but cancel at a contact.
SMALL_ANGLE_ERROR = 30.0


@compiled
def numbers(p, scales, x, y, margin):
    """
    Return the Numbers of a state.

    Parameters
    ----------
    p, scales, x
        As for `rungs.answer`.
    y : ndarray, shape (6,)
        The full equations' accelerations and reactions.
    margin : float
        Their determinant, from `kernel.accelerate`.

    """
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, x[0])
    s, c, a1, a2, S1, S2, b, _, h_c, _, dh_c, dz_c, ddh_c, ddz_c = geo
    dgamma, dpsi = x[3], x[4]
    by_mass = p.m / max(fabs(y[3]), fabs(y[4]), fabs(y[5]))
    e_psi, h_psi = h_c * y[1] + 2.0 * dh_c * dgamma * dpsi, h_c * dpsi * dpsi
    a_h = dh_c * y[0] + ddh_c * dgamma * dgamma - h_psi
    a_z = dz_c * y[0] + ddz_c * dgamma * dgamma
    # K slides along the peg, and both B across it.
    closing = 2.0 * fabs(dgamma) * min(a1 / s, sqrt(a1 * a1 + S1 * S1)) + 1e-12
    by_phi, by_psi = 0.5 * p.d * fabs(x[5]), 0.5 * p.D * fabs(dpsi)
    over_OB = 1.0 / sqrt(0.25 * p.D * p.D + a1 * a1)
    W = force_columns(p, scales, x, s, c, a1, S1, S2, b, over_OB)
    determinant = (
        W[0] * (W[4] * W[8] - W[5] * W[7])
        + W[1] * (W[5] * W[6] - W[3] * W[8])
        + W[2] * (W[3] * W[7] - W[4] * W[6])
    )
    return Numbers(
        x[0],
        x[0] / p.gamma0 - 1.0,
        by_mass * sqrt(a_h * a_h + e_psi * e_psi + a_z * a_z),
        by_mass * sqrt(e_psi * e_psi + h_psi * h_psi),
        by_phi / (closing + by_phi),
        by_psi / (closing + by_psi),
        margin,
        determinant / (2.0 * b * a2 * over_OB * over_OB),
    )


@inlined
def in_domain(rung, n):
    """Return whether a state is one that a rung is made for."""
    if not n.margin > LEAST_MARGIN:
        return False
    if rung == SMALL_ANGLE and n.tilt > MOST_TILT:
        return False
    if rung <= QUASI_STATIC:
        return n.inertia < MOST_INERTIA and n.balance > LEAST_BALANCE
    return n.slide + (n.slip if rung == ALIGN else 0.0) < MOST_TURNED


def gain(scene, q, rates, slip_velocity_scale=0.0) -> float:
    """Return how much the balance of forces amplifies a force into one reaction, at most."""
    A, _ = six_equations(scene, q, rates, np.zeros(6), slip_velocity_scale)
    return float(np.linalg.norm(np.linalg.inv(A[3:, 3:]), axis=1).max())


def bound(rung: int, n: Numbers, friction: float, gain: float) -> float:
    """
    Return a bound on a rung's error in the reactions, over the largest of them.

    What a rung leaves out of the balance of forces, over the largest reaction, times how much the
    balance amplifies a force. For `quasi_static` this is exact up to directions:
    W (N - N_rung) = m a. Rungs that turn with the peg leave out friction directions; their own
    balance is singular where the six equations are, and so amplifies more by the margin.

    Parameters
    ----------
    rung : int
        Place in RUNGS.
    n : Numbers
    friction : float
    gain : float
        From `gain`.

    """
    if rung == SMALL_ANGLE:
        return gain * (n.inertia + SMALL_ANGLE_ERROR * n.tilt**2)
    if rung == QUASI_STATIC:
        return gain * n.inertia
    if rung >= DYNAMIC:
        return 0.0 if n.margin > 0.0 else inf
    turned = n.slide + (n.slip if rung == ALIGN else 0.0)
    over = gain / min(max(n.margin, 1e-9), 1.0)
    return over * (2.0 * friction * turned + n.turning)
