"""Bursts: wrenches that a line delivers in heaps bear the stamps of their arrival."""

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import BURSTS_TEST
from peg_on_hole_ros.number_text import number


class Bursts(Suspect):
    """
    Looks for wrenches whose stamps lie close together, as many each time, with a pause between.

    A thread that is woken late makes heaps as well, but not of one size.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "bursts"
    FINDS = (
        (
            "`wrenches come in bursts`, with how many and how often: a line delivers them in "
            "heaps, as a USB adapter by its latency timer, and they bear the stamps of their "
            "arrival. Meanwhile `reactions_determined` is 0",
            "anywhere, after eight bursts",
        ),
    )
    LASTS = True
    OF_STAMPS = True
    WITHOUT_WRENCH = True

    def __init__(self, stated: Stated) -> None:
        self._topic = stated.configuration.topics.wrench
        self.finding: Finding | None = None
        self.restart()

    def restart(self) -> None:
        """Forget the stamps so far."""
        self._stamps = np.empty(0, np.int64)
        self._come = False

    @property
    def withholds(self) -> bool:
        """Whether the latest wrenches came in bursts."""
        return self._come

    def take_stamps(self, of_wrench: np.ndarray, t_ns: np.ndarray) -> None:
        """Process messages in the order in which they came, see the package."""
        stamps = np.concatenate([self._stamps, t_ns[of_wrench]])
        self._stamps = stamps[-BURSTS_TEST.kept :]

    def take(self, instant: Instant, unsure: bool) -> None:
        """Look at the stamps that have come."""
        steps = np.diff(self._stamps)
        if len(steps) < BURSTS_TEST.fewest or (steps <= 0).any():
            return
        mean = steps.mean()
        pauses = np.flatnonzero(steps > mean)
        if len(pauses) < BURSTS_TEST.bursts:
            self._come = False
            return
        close = steps < BURSTS_TEST.close * mean
        counts, size = np.diff(pauses), int(np.median(np.diff(pauses)))
        apart = np.delete(np.arange(len(steps)), pauses)
        period_ns = int(np.diff(self._stamps[pauses]).mean())
        self._come = bool(
            size >= BURSTS_TEST.size
            and period_ns >= BURSTS_TEST.period_ns
            and close[apart].mean() > BURSTS_TEST.share
            and (np.abs(counts - size) <= 1).mean() > BURSTS_TEST.share
        )
        if self._come and self.finding is None:
            within = float(np.median(steps[apart])) * (size - 1)
            self.finding = Finding(self._said(size, within * 1e-6, period_ns * 1e-6), {})

    def _said(self, size, within, period):
        return (
            f"wrenches come in bursts: on {self._topic} {size} within {number(within, 2)} ms, "
            f"every {number(period)} ms, so that their stamps are those of their arrival: the "
            "latency timer of a USB adapter is a likely cause (set it to 1 ms), or a driver "
            "that reads what has gathered; have each stamped when it is measured. Meanwhile "
            "reactions are withheld"
        )
