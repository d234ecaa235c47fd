"""Turns of the peg: whether they are determined."""

from math import nan, pi

from peg_on_hole_ros.bags.truth import BOUND_STDDEVS


def turn_stddev(stddev: float) -> float:
    """
    Return the deviation of psi or phi [rad], NaN where it may be any turn and is not determined.

    That is so near upright, where the sum of both is determined alone.
    """
    return stddev if BOUND_STDDEVS * stddev < pi else nan
