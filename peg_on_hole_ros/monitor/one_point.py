"""Which of the two points in the hole carries alone, by the estimate with two."""

from math import exp, log, pi, sqrt

from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.contact_probabilities import normal_cdf
from peg_on_hole_ros.monitor.tuned import EVIDENCE_WEIGHTS, ONE_POINT
from peg_on_hole_ros.typed_record import Floats

# Hypotheses: K alone, B alone, both.
K_ALONE, B_ALONE, BOTH = range(3)
COUNT = 3


@compiled
def forget_points(probabilities: Floats) -> None:
    """Set the probabilities, shape (3,), as they are before any evidence."""
    for i in range(COUNT):
        probabilities[i] = ONE_POINT.prior[i]


@compiled
def absence(normal: float, variance: float) -> float:
    """
    Return log p(wrenches | there is no such reaction) - log p(wrenches | it pushes).

    The set without it is the set with it where the reaction is zero: their likelihoods are to each
    other as its density there is to what it was before the wrench (J. M. Dickey, Annals of
    Mathematical Statistics 42 (1971) 204-223).

    Parameters
    ----------
    normal, variance : float
        Of the reaction, by the set with it [N], [N^2].

    """
    sigma = sqrt(max(variance, 1e-18))
    z = normal / sigma
    # The density at zero of what pushes, whose tail cancels the square.
    tail = (
        0.5 * log(0.5 * pi) + log(-z)
        if z < ONE_POINT.tail
        else -0.5 * z * z - log(2.0 * normal_cdf(z))
    )
    ratio = tail - log(sigma) + 0.5 * log(ONE_POINT.reaction * ONE_POINT.reaction + sigma * sigma)
    return (
        min(max(ratio, -EVIDENCE_WEIGHTS.most), EVIDENCE_WEIGHTS.most) if ratio == ratio else 0.0
    )


@compiled
def weigh_points(
    probabilities: Floats, estimate: Estimate, dt: float, rate: float, correlation: float
) -> None:
    """
    Carry the probabilities over a time, then weigh them with the reactions of two points.

    Parameters
    ----------
    probabilities : ndarray, shape (3,)
        Changed.
    estimate : Estimate
        Which has weighed a wrench with two points.
    dt : float
        Since the last wrench [s].
    rate, correlation : float
        As for `contacts.weigh`.

    """
    change, share = 1.0 - exp(-rate * dt), min(dt / correlation, 1.0)
    for i in range(COUNT):
        probabilities[i] += change * (ONE_POINT.prior[i] - probabilities[i])
    # B stands as two equal halves.
    N, C = estimate.reactions.normal, estimate.reactions.covariance
    of_B = C[1, 1] + 2.0 * C[1, 2] + C[2, 2]
    probabilities[K_ALONE] *= exp(share * absence(N[1] + N[2], of_B))
    probabilities[B_ALONE] *= exp(share * absence(N[0], C[0, 0]))
    total = probabilities[K_ALONE] + probabilities[B_ALONE] + probabilities[BOTH]
    for i in range(COUNT):
        probabilities[i] /= total
