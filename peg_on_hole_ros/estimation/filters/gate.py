"""Whether a filter takes an orientation, and what it widens before."""

from math import cos, isfinite, sin

from peg_on_hole_ros.estimation.filters.outcomes import Correction

# A surprise may leave the rates this many times as uncertain as they are at a start.
SURPRISING = 3.0
# A normalised innovation squared, of three angles: no smaller one asks for wider rates.
EXPECTED = 3.0


class Gate:
    """
    Judges innovations: one too large widens the rates, and one too large even then is refused.

    Attributes
    ----------
    refused : int
        Orientations that were refused in a row.

    """

    def __init__(self):
        self.refused = 0

    def judge(self, kalman, q, nis: float) -> Correction:
        """
        Say what becomes of an orientation, and widen the filter where its innovation asks for it.

        Parameters
        ----------
        kalman : ContactFilter
        q : ndarray, shape (3,)
            gamma, psi, phi [rad].
        nis : float
            Its normalised innovation squared.

        Returns
        -------
        Correction
            After RESET the filter is to be started from the orientation.

        """
        options = kalman.options
        if not isfinite(nis):
            # A covariance that has lost its meaning is not to be corrected, nor to leave.
            return Correction.RESET
        result, after, before = Correction.USED, nis, None
        if nis > max(options.inflation_threshold, EXPECTED):
            before = kalman.snapshot()
            most = most_widening(kalman.x.item(0), kalman.P, options.initial_rate_stddev)
            kalman.widen(min(nis / EXPECTED - 1.0, most))
            after = kalman.innovation(q)
            result = Correction.INFLATED
        if after <= options.gate_threshold:
            self.refused = 0
            return result
        if before is not None and not self.refused:
            # One outlier tells nothing of the rates; two in a row are a motion.
            kalman.restore(before)
        self.refused += 1
        return Correction.GATED if self.refused <= options.gate_reset_count else Correction.RESET


def most_widening(gamma: float, P, rate_stddev: float) -> float:
    """
    Return by which factor the rates' covariance may grow: no peg turns at any speed.

    Parameters
    ----------
    gamma : float
        [rad].
    P : ndarray, shape (6, 6)
        Covariance of the state.
    rate_stddev : float
        Of the rates at a start [rad/s].

    """
    s, c = sin(gamma), cos(gamma)
    # Of the angular velocity: across the tilt, along it, and about the axis.
    uncertain = max(P[3, 3], s * s * P[5, 5], P[4, 4] + 2 * c * P[4, 5] + c * c * P[5, 5])
    most = (SURPRISING * rate_stddev) ** 2
    return max(most / max(uncertain, 1e-300) - 1.0, 0.0)
