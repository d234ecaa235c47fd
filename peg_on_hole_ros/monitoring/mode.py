"""The contact mode that is declared, with dwell and hysteresis, and when contact came and went."""

from typing import NamedTuple

from peg_on_hole_ros.monitoring.evidence import Shown
from peg_on_hole_ros.options import MonitorOptions

MODES = ("three_point", "two_point", "open", "unknown")


class Touch(NamedTuple):
    """
    Contact that came or went.

    Attributes
    ----------
    onset : bool
        True: contact came.
    t : float
        When it did, as far as can be told: where the evidence turned [s].
    latency : float
        From there until it was declared [s].

    """

    onset: bool
    t: float
    latency: float


class ContactMode:
    """
    The contact mode: declared once it is probable enough for a while, kept until it no longer is.

    Attributes
    ----------
    mode : str
        One of MODES.
    touch : Touch or None
        The last time that contact came or went.

    """

    def __init__(self, options: MonitorOptions):
        self.options = options
        self.restart()

    def restart(self):
        """Forget all evidence."""
        self.mode = "unknown"
        self.touch: Touch | None = None
        self._candidate = "unknown"
        self._since = 0.0
        self._touching: bool | None = None
        self._turned = [0.0, 0.0]

    def update(self, t: float, shown: Shown) -> str:
        """Take the probabilities at a time [s] and return the mode."""
        options = self.options
        # In the order of MODES.
        probabilities = (
            shown.three_point + shown.stuck,
            shown.two_point,
            shown.free,
            shown.opened + shown.other,
        )
        most = max(probabilities)
        best = MODES[probabilities.index(most)]
        if most < options.mode_probability_on:
            kept = probabilities[MODES.index(self.mode)] >= options.mode_probability_off
            best = self.mode if kept else "unknown"
        if best != self._candidate:
            self._candidate, self._since = best, t
        if best != self.mode and t - self._since >= options.mode_dwell:
            self.mode = best
        self._update_touch(t, shown.free)
        return self.mode

    def _update_touch(self, t, free):
        # Evidence for the other side begins where that for this side was last strong.
        certain = 1.0 - self.options.mode_probability_on
        if free >= 1.0 - certain:
            self._turned[0] = t
        if free <= certain:
            self._turned[1] = t
        if self._touching is None:
            self._touching = free <= 0.5 if self.mode != "unknown" else None
        elif self._touching and self.mode == "open":
            self._touching, self.touch = False, self._turn(False, self._turned[1], t)
        elif not self._touching and free <= certain and self.mode != "open":
            self._touching, self.touch = True, self._turn(True, self._turned[0], t)

    @staticmethod
    def _turn(onset, turned, t):
        return Touch(onset, turned, t - turned)
