"""Whether a peg hangs free and still, as a tare needs it, by what was told of it last."""

from math import cos, sqrt

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.monitor.memory import MODES
from peg_on_hole_ros.records import Outputs

*TOUCHING, FREE, UNKNOWN = MODES
# Standard deviations by which a peg has to turn faster than at rest to count as turning.
SURE = 4.0
# A peg that is free and still for so long is tared, where that is asked for [ns].
FREE_NS = 1_000_000_000


def not_free(told: Outputs | None, configuration: Configuration, unsure: bool) -> str:
    """
    Return what speaks against a peg that hangs free and still, or nothing.

    Parameters
    ----------
    told : Outputs or None
        The last; None: nothing was told. A zero that is off by more than is stated leaves the mode
        unknown.
    configuration : Configuration
    unsure : bool
        Whether the wrench seems to mean something else than is stated, such as another unit.

    """
    if told is None:
        return ""
    if told.contact_mode in TOUCHING:
        return f"the peg touches, contact mode {told.contact_mode}"
    moves = turns(told, configuration)
    if moves or told.contact_mode == FREE or not unsure:
        return moves
    return (
        f"the peg may touch, contact mode {told.contact_mode}: the wrench seems to mean something "
        "else than is stated (/diagnostics)"
    )


def turns(told: Outputs, configuration: Configuration) -> str:
    """Return what says that the peg turns, or nothing."""
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


class FreeFor:
    """
    Whether a peg has surely hung free and still for long, told once each time it comes to do so.

    Parameters
    ----------
    configuration : Configuration
        Where `wrench.tare_automatically` is false it is never told.

    """

    def __init__(self, configuration: Configuration) -> None:
        self._configuration = configuration
        self._since_ns: int | None = None
        self._told = False

    @property
    def asked(self) -> bool:
        """Whether a tare of a free peg is asked for."""
        return self._configuration.wrench.tare_automatically

    def long(self, outputs: Outputs | None) -> bool:
        """Take what was told of a wrench; return whether the peg now is free for long enough."""
        if not self.asked:
            return False
        free = outputs is not None and outputs.contact_mode == FREE
        if not free or turns(outputs, self._configuration):
            self._since_ns, self._told = None, False
            return False
        if self._since_ns is None or outputs.t_ns < self._since_ns:
            self._since_ns = outputs.t_ns
        if self._told or outputs.t_ns - self._since_ns < FREE_NS:
            return False
        self._told = True
        return True
