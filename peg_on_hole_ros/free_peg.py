"""Whether a peg hangs free and still, as a tare needs it, by what was told of it last."""

from math import cos, sqrt

import numpy as np

from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.records import Outputs

TOUCHING = ("three_point", "two_point")
# Standard deviations by which a peg has to turn faster than at rest to count as turning.
SURE = 4.0


def not_free(told: Outputs | None, configuration: Configuration) -> str:
    """Return what says that the peg touches or moves, or nothing; None: nothing was told."""
    if told is None:
        return ""
    if told.contact_mode in TOUCHING:
        return f"the peg touches, contact mode {told.contact_mode}"
    speed, stddev = turning(told)
    if (
        speed - SURE * stddev
        > configuration.monitor.rest_speed / configuration.scene.hole_diameter
    ):
        return f"the peg turns at {speed:.3g} rad/s, contact mode {told.contact_mode}"
    return ""


def turning(told: Outputs) -> tuple[float, float]:
    """Return how fast the peg turns about any axis, and the standard deviation of that [rad/s]."""
    gamma, rates = told.state.item(0), told.state[3:]
    # psi and phi turn about axes that are gamma apart.
    metric = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, cos(gamma)], [0.0, cos(gamma), 1.0]])
    slope = metric @ rates
    speed = sqrt(max(float(rates @ slope), 0.0))
    if not speed:
        return 0.0, 0.0
    variance = float(slope @ told.state_covariance[3:, 3:] @ slope) / speed**2
    return speed, sqrt(max(variance, 0.0))
