"""Which contacts are closed: a small hidden Markov model over what each wrench shows."""

from math import erfc, exp, fabs, log, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.tuned import EVIDENCE_WEIGHTS
from peg_on_hole_ros.typed_record import Floats

# Hypotheses: nothing touches; all three contacts are closed; K, B1 or B2 is open while others
# carry; the rim carries the peg in some other way, for which there is no model.
FREE, CLOSED, LOST_K, LOST_B1, LOST_B2, OTHER = range(6)
COUNT = 6


class ContactEvidence(NamedTuple):
    """
    What one wrench shows of the hypotheses.

    Attributes
    ----------
    load, lost_K, lost_B1, lost_B2, other : float
        Log ratios: contact against none; each opening, and another contact, against all closed.
    displaced : float
        Log ratio of a peg elsewhere than where three contacts would have it.
    rest : float
        Probability that it rests: nothing shows then which contacts are closed, and one that was
        taken for open, as those of a peg that has just wedged are, is forgotten soon.

    """

    load: float
    lost_K: float
    lost_B1: float
    lost_B2: float
    other: float
    displaced: float = 0.0
    rest: float = 0.0


def no_knowledge() -> Floats:
    """Return the probabilities of all hypotheses before any evidence, shape (6,)."""
    return np.array(EVIDENCE_WEIGHTS.prior)


@compiled
def forget_contacts(probabilities: Floats) -> None:
    """Set the probabilities as they are before any evidence."""
    for i in range(COUNT):
        probabilities[i] = EVIDENCE_WEIGHTS.prior[i]


@compiled
def normal_cdf(z: float) -> float:
    """Return the probability that a standard normal variable is below z."""
    return 0.5 * erfc(-z * 0.7071067811865476)


@compiled
def _bounded(value: float) -> float:
    # What is no number is no evidence.
    return (
        min(max(value, -EVIDENCE_WEIGHTS.most), EVIDENCE_WEIGHTS.most) if value == value else 0.0
    )


@compiled
def load_evidence(squares: float) -> float:
    """Return log p(load | contact) - log p(load | nothing touches), even where `squares` is 1."""
    return _bounded(EVIDENCE_WEIGHTS.most * (squares - 1.0))


@compiled
def opening_evidence(normal: float, variance: float) -> float:
    """
    Return log p(this contact is open) - log p(closed) by the reaction that it ought to carry.

    Where a contact is open, the equations of three closed contacts ask it to pull.
    """
    z = normal / sqrt(max(variance, 1e-18))
    if fabs(z) > 5.0:
        return -EVIDENCE_WEIGHTS.most if z > 0.0 else EVIDENCE_WEIGHTS.most
    return _bounded(log(normal_cdf(-z) / normal_cdf(z)))


@compiled
def weigh(
    probabilities: Floats, evidence: ContactEvidence, dt: float, rate: float, correlation: float
) -> None:
    """
    Carry the probabilities over a time, then weigh them with one piece of evidence.

    Parameters
    ----------
    probabilities : ndarray, shape (6,)
        Changed.
    evidence : ContactEvidence
    dt : float
        Since the last evidence [s].
    rate : float
        How often a second contacts change [1/s].
    correlation : float
        Time in which noise and errors of the model repeat themselves [s]; evidence counts by the
        share of it that has passed.

    """
    change = 1.0 - exp(-rate * dt)
    retry = 1.0 - exp(-dt / EVIDENCE_WEIGHTS.retry)
    for i in range(COUNT):
        probabilities[i] += change * (EVIDENCE_WEIGHTS.prior[i] - probabilities[i])
    # Of what is left: after a silence both go by nearly all of it.
    again = retry * probabilities[OTHER]
    probabilities[OTHER] -= again
    probabilities[CLOSED] += again
    for i in range(LOST_K, LOST_B2 + 1):
        again = retry * evidence.rest * probabilities[i]
        probabilities[i] -= again
        probabilities[CLOSED] += again
    share = min(dt / correlation, 1.0)
    # What no three contacts can carry speaks for nothing as much as for those that are left.
    lost = max(evidence.lost_K, evidence.lost_B1, evidence.lost_B2, 0.0)
    probabilities[FREE] *= exp(share * (lost - evidence.load))
    probabilities[LOST_K] *= exp(share * evidence.lost_K)
    probabilities[LOST_B1] *= exp(share * evidence.lost_B1)
    probabilities[LOST_B2] *= exp(share * evidence.lost_B2)
    probabilities[OTHER] *= exp(share * evidence.other)
    probabilities[CLOSED] *= exp(-share * evidence.displaced)
    total = 0.0
    for i in range(COUNT):
        total += probabilities[i]
    for i in range(COUNT):
        probabilities[i] /= total


@compiled
def misfit_evidence(nis: float) -> float:
    """Return log p(another contact) - log p(three contacts) by the running mean of the NIS."""
    # A peg that breaks away surprises for some corrections: against the model it counts less.
    return min(
        _bounded(EVIDENCE_WEIGHTS.nis_share * (nis - EVIDENCE_WEIGHTS.even_nis)),
        EVIDENCE_WEIGHTS.most_misfit,
    )
