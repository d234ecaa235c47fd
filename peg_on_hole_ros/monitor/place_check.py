"""Whether a peg is where contacts would have it: its measured place against the hole."""

from math import asin, cos, exp, fabs, nan, sin, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.kernel import closed_forms, compiled
from peg_on_hole_ros.mechanics.linear_algebra import surprise
from peg_on_hole_ros.monitor.contact_probabilities import normal_cdf
from peg_on_hole_ros.monitor.tuned import EVIDENCE_WEIGHTS, PLACE_CHECK
from peg_on_hole_ros.typed_record import Floats, Record


class Misfit(NamedTuple):
    """
    How far a peg is from where it would touch: on three points, or below gamma0 in the hole.

    Attributes
    ----------
    offset : float
        Distance from where contacts would have it [m].
    deviations : float
        The same in standard deviations, all three coordinates together.
    evidence : float
        Log ratio, p(place | elsewhere) over p(place | contacts), from 0 to the most: a place that
        fits is no evidence, for a peg in the air a micrometre above the rim is there too.
    within_reach : float
        Probability that the peg is low enough to touch what is around the hole.
    beside : float
        Probability that it is, and that it does not touch the hole.
    inside : bool
        Whether it is surely in the hole, below the rim.
    depth, depth_stddev : float
        Of the peg's lower end below the rim [m].

    """

    offset: float
    deviations: float
    evidence: float
    within_reach: float
    beside: float
    inside: bool
    depth: float
    depth_stddev: float


class PlaceMisfit(Record):
    """The last misfit that was measured, see `Misfit`; NaN, and no evidence: none was."""

    offset: float
    deviations: float
    evidence: float
    within_reach: float
    beside: float
    inside: bool
    depth: float
    depth_stddev: float


@compiled
def forget_place(place: PlaceMisfit) -> None:
    """Forget what was measured."""
    place.offset = place.deviations = place.depth = place.depth_stddev = nan
    place.evidence = place.within_reach = place.beside = 0.0
    place.inside = False


@compiled
def take_place(place: PlaceMisfit, found: Misfit) -> None:
    """Take what was measured."""
    place.offset, place.deviations = found.offset, found.deviations
    place.evidence, place.within_reach = found.evidence, found.within_reach
    place.beside, place.inside = found.beside, found.inside
    place.depth, place.depth_stddev = found.depth, found.depth_stddev


@compiled
def touching_place(d: float, D: float, gamma: float, psi: float) -> Floats:
    """
    Return the peg frame's origin in three-point contact, hole axes, shape (3,) [m].

    Source: docs/notation.md, G1 to G3: O is a1 above the rim, and a2 up the peg's axis.
    """
    gamma0 = 2.0 * asin(sqrt((D - d) / (2.0 * D)))
    gamma = max(gamma, gamma0 * (1.0 + PLACE_CHECK.edge))
    geo = closed_forms(d, D, 0.0, gamma0, gamma)
    aside = geo.a2 * geo.s
    return np.array([aside * cos(psi), aside * sin(psi), geo.a1 - geo.a2 * geo.c])


@compiled
def two_point_length(d: float, D: float, gamma: float) -> float:
    """Return how much of a peg is in the hole on two points, l sin(gamma) = D - d cos(gamma)."""
    length: float = (D - d * cos(gamma)) / max(sin(gamma), 1e-9)
    return length


@compiled
def place_inside(d: float, D: float, gamma: float, place: Floats) -> Floats:
    """
    Return the place in the hole that is nearest to a peg frame's origin, shape (3,) [m].

    Below gamma0 a peg touches the hole only from within: its lower end is no deeper than two
    points allow, and no farther aside than it has room.
    """
    aside = sqrt(place[0] * place[0] + place[1] * place[1])
    room = min(1.0, (D - d) / max(aside, 1e-12))
    deepest = two_point_length(d, D, gamma)
    return np.array([room * place[0], room * place[1], min(max(place[2], -deepest), 0.0)])


@compiled
def misfit(
    q: Floats,
    R: Floats,
    position: Floats,
    position_covariance: Floats,
    d: float,
    D: float,
    diameter_variance: float,
    around: float,
) -> Misfit:
    """
    Compare a measured place with that of contacts at the measured angles.

    Above gamma0 that is the place of three contacts, below it anywhere in the hole.

    Parameters
    ----------
    q : ndarray, shape (3,)
        gamma, psi, phi [rad].
    R : ndarray, shape (3, 3)
        Their covariance [rad^2].
    position, position_covariance : ndarray, shape (3,), (3, 3)
        Of the peg's origin in the hole frame [m], [m^2].
    d, D : float
        Diameters [m].
    diameter_variance : float
        Of d [m^2].
    around : float
        What may be there beside the hole is no higher than this [m].

    Returns
    -------
    Misfit

    Notes
    -----
    The hole's own place is one draw for a whole run, and not one a sample: what speaks against
    three contacts has to outweigh all that this leaves open, else there is no evidence.

    """
    gamma, psi = q[0], q[1]
    spread_z = sqrt(position_covariance[2, 2])
    lowest = position[2] - 0.5 * d * fabs(sin(gamma))
    reach = normal_cdf((around - lowest) / spread_z)
    if cos(gamma) > d / D:
        residual = position - place_inside(d, D, gamma, position)
        deep = position[2] < -PLACE_CHECK.sure * spread_z
        return _misfit(residual, position_covariance, reach, deep, -position[2])
    place = touching_place(d, D, gamma, psi)
    residual = position - place
    slopes = np.zeros((3, 2))
    slopes[:, 0] = (touching_place(d, D, gamma + PLACE_CHECK.step, psi) - place) / PLACE_CHECK.step
    slopes[0, 1], slopes[1, 1] = -place[1], place[0]
    S = position_covariance.copy()
    for i in range(3):
        for j in range(3):
            for k in range(2):
                for l in range(2):
                    S[i, j] += slopes[i, k] * R[k, l] * slopes[j, l]
    if diameter_variance > 0.0:
        spread = sqrt(diameter_variance)
        S += _outer(touching_place(d - spread, D, gamma, psi) - place)
    return _misfit(residual, S, reach, False, -position[2])


@compiled
def _misfit(residual: Floats, S: Floats, reach: float, deep: bool, depth: float) -> Misfit:
    """Return the misfit of a residual with a covariance, of a peg as low and as deep."""
    wide = S + PLACE_CHECK.elsewhere * PLACE_CHECK.elsewhere * np.eye(3)
    white = np.empty(3)
    squared, spread = surprise(S.copy(), 3, residual, white)
    elsewhere, wide_spread = surprise(wide, 3, residual, white)
    ratio = max(0.5 * (squared + spread - elsewhere - wide_spread), 0.0)
    distance = sqrt((residual * residual).sum())
    evidence = min(ratio, EVIDENCE_WEIGHTS.most)
    beside = reach * (1.0 - exp(-ratio))
    inside = deep and squared < PLACE_CHECK.sure * PLACE_CHECK.sure
    spread_z = sqrt(S[2, 2])
    return Misfit(distance, sqrt(squared), evidence, reach, beside, inside, depth, spread_z)


@compiled
def _outer(v: Floats) -> Floats:
    return v.reshape(3, 1) * v.reshape(1, 3)
