"""A clock that drifts: stamps of joint states and wrenches part more and more."""

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.leads import Leads
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import CLOCK_DRIFT_TEST
from peg_on_hole_ros.number_text import number


class ClockDrift(Suspect):
    """
    Fits a line through how far stamps of joint states are ahead of wrenches that came before them.

    On the way one message takes longer than another: medians of blocks are what is fitted. A way
    that becomes longer once, or a clock that is set, is no line.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "clock_drift"
    FINDS = (
        (
            "`the clock of /joint_states goes 5000 ppm fast`, or slow, beside that of the wrench: "
            "no constant `joints.delay` compensates for it, and none is named. Meanwhile the mode "
            "is `unknown`, and `reactions_determined` is 0",
            "anywhere, once the clocks have parted by 5 ms, in 2 s at the earliest",
        ),
    )
    LASTS = True
    OF_STAMPS = True
    WITHOUT_WRENCH = True

    def __init__(self, stated: Stated) -> None:
        topics = stated.configuration.topics
        self._topics = topics.joint_states, topics.wrench
        self.finding: Finding | None = None
        self.restart()

    def restart(self) -> None:
        """Forget the stamps so far."""
        self._leads = Leads()
        self._block: list[np.ndarray] = []
        self._lasts_ns = CLOCK_DRIFT_TEST.block_ns
        self._points: list[tuple[int, float]] = []
        self._drifts = False

    @property
    def unsure(self) -> bool:
        """Whether the clocks part."""
        return self._drifts

    @property
    def hides(self) -> bool:  # type: ignore[override]
        """Whether what others make of the stamps is no setting."""
        return self._drifts

    def take_stamps(self, of_wrench: np.ndarray, t_ns: np.ndarray) -> None:
        """Process messages in the order in which they came, see the package."""
        found = self._leads.of(of_wrench, t_ns)
        if len(found):
            self._block.append(found)

    def take(self, instant: Instant, unsure: bool) -> None:
        """Look at a block that is complete."""
        if not self._block:
            return
        first_ns, last_ns = self._block[0][0, 0], self._block[-1][-1, 0]
        if 0 <= last_ns - first_ns < self._lasts_ns:
            return
        block = np.concatenate(self._block)
        self._block = []
        if len(block) < CLOCK_DRIFT_TEST.fewest:
            return
        self._points.append((int(np.median(block[:, 0])), float(np.median(block[:, 1]))))
        if len(self._points) >= CLOCK_DRIFT_TEST.most_blocks:
            # Every second one is kept, and of those to come as well.
            self._points, self._lasts_ns = self._points[::2], 2 * self._lasts_ns
        if len(self._points) >= CLOCK_DRIFT_TEST.blocks:
            self._judge()

    def _judge(self):
        t_ns, leads = (np.array(each) for each in zip(*self._points))
        t = (t_ns - t_ns[0]) * 1e-9
        if t[-1] <= 0.0 or (np.diff(t) <= 0.0).any():
            self.restart()
            return
        slope, begin = np.polyfit(t, leads * 1e-9, 1)
        apart = abs(slope) * t[-1]
        off = np.abs(leads * 1e-9 - begin - slope * t).max()
        self._drifts = bool(
            apart > CLOCK_DRIFT_TEST.apart and off < CLOCK_DRIFT_TEST.straight * apart
        )
        if self._drifts and self.finding is None:
            self.finding = Finding(self._said(slope, apart, t[-1]), {}, "clocks")

    def _said(self, slope, apart, seconds):
        joints, wrench = self._topics
        return (
            f"the clock of {joints} drifts: it goes {abs(slope) * 1e6:.0f} ppm "
            f"{'fast' if slope > 0 else 'slow'} beside that of {wrench}, "
            f"{number(apart * 1e3, 2)} ms in {number(seconds, 2)} s, so that no constant "
            "joints.delay fits: synchronise the clocks of both drivers (NTP or PTP), or let one "
            "machine stamp both. Meanwhile reactions are withheld"
        )
