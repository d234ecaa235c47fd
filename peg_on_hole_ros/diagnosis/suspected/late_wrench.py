"""A wrench that comes late: what was handed on before comes once more under fresh stamps."""

from collections import deque

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import LATE_WRENCH_TEST
from peg_on_hole_ros.number_text import number


class _Again:
    """
    Whether rows of values come again in their order, bit for bit.

    Noise does not do so. Of a row that repeats at once only the first counts.

    Attributes
    ----------
    run : int
        How many rows in a row are those of before, so far.
    ago_ns, since_ns : int
        How long before, and the stamp of the first of them [ns].

    """

    def __init__(self) -> None:
        self._places: dict[bytes, int] = {}
        self._kept: deque[tuple[bytes, int]] = deque()
        self._count = self._back = 0
        self.run = self.ago_ns = self.since_ns = 0

    def take(self, t_ns: np.ndarray, rows: np.ndarray) -> None:
        """Process rows in their order: stamps [ns], values (n, width)."""
        data, width = np.ascontiguousarray(rows).tobytes(), rows.itemsize * rows.shape[1]
        for k, stamp in enumerate(t_ns.tolist()):
            self._take(stamp, data[k * width : (k + 1) * width])

    def _take(self, stamp, key):
        kept, places = self._kept, self._places
        if kept and kept[-1][0] == key:
            return
        back = self._count - places.get(key, self._count)
        if not (self.run and back == self._back):
            self.run, self._back, self.since_ns = 0, back, stamp
        # Values that toggle between a few come again soon.
        if back >= LATE_WRENCH_TEST.fewest:
            self.run += 1
            self.ago_ns = stamp - kept[-back][1]
        places[key] = self._count
        kept.append((key, stamp))
        self._count += 1
        if len(kept) > LATE_WRENCH_TEST.kept:
            old = kept.popleft()[0]
            if places.get(old) == self._count - LATE_WRENCH_TEST.kept - 1:
                del places[old]


class LateWrench(Suspect):
    """
    Looks for wrenches that were handed on before, in their order: those behind them are late.

    Where joint states come again as well it is a recording that is played once more. That they
    come in time again shows in no wrench: it does once a motion on three contacts fits them.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "late_wrench"
    FINDS = (
        (
            "`wrenches come late, by 0.3 s`: earlier wrenches arrive again with new stamps, "
            "bit for bit, for example because a driver sends a buffer twice; all that follow are "
            "late. The mode is `unknown` where it is not `open`, and `reactions_determined` is 0, "
            "until a motion on three contacts fits the wrench",
            "anywhere, after 20 wrenches of a sensor with noise",
        ),
    )
    LASTS = True
    WITHOUT_WRENCH = True

    def __init__(self, stated: Stated) -> None:
        self.finding: Finding | None = None
        self._begun_ns: int | None = None
        self.restart()

    def restart(self) -> None:
        """Forget the messages so far."""
        self._wrenches, self._joints = _Again(), _Again()
        self._set_late(False)

    def _set_late(self, late):
        self._late = late
        self._fits, self._misfit = 0, False
        self._q: np.ndarray | None = None

    @property
    def unsure(self) -> bool:
        """Whether wrenches are late."""
        return self._late

    @property
    def hides(self) -> bool:  # type: ignore[override]
        """Whether what others make of wrench and motion is no setting."""
        return self._late

    def take_joints(self, t_ns: np.ndarray, positions: np.ndarray) -> None:
        """Process joint states in the order in which they came, see the package."""
        self._joints.take(t_ns, positions)

    def take_every_wrench(self, t_ns: np.ndarray, wrenches: np.ndarray) -> None:
        """Process every wrench, see the package."""
        if self._begun_ns is None and len(t_ns):
            self._begun_ns = int(t_ns[0])
        self._wrenches.take(t_ns, wrenches)

    def take(self, instant: Instant, unsure: bool) -> None:
        """Look whether wrenches come again, or a motion fits them."""
        numbers = LATE_WRENCH_TEST
        if self._wrenches.run >= numbers.fewest:
            if self._joints.run < numbers.joints:
                self._set_late(True)
                if self.finding is None:
                    self.finding = Finding(self._said(), {})
        elif self._late:
            self._follow(instant)

    def _follow(self, instant):
        """Note whether the motion fits the wrench: for long, or for a while after it did not."""
        q, numbers = np.asarray(instant.measured.q), LATE_WRENCH_TEST
        turned = self._q is not None and abs(q[0] - self._q[0]) > numbers.turned
        if self._q is None or turned:
            self._q = q
        if instant.misfit:
            self._fits, self._misfit = 0, True
        elif turned and instant.in_air is False:
            self._fits += 1
        if self._fits >= (numbers.fits_again if self._misfit else numbers.fits):
            self._late = False

    def _said(self):
        ago, since = self._wrenches.ago_ns, self._wrenches.since_ns - (self._begun_ns or 0)
        return (
            f"wrenches come late, by {number(ago * 1e-9)} s: from {since * 1e-9:.3f} s on "
            f"those of {number(ago * 1e-9)} s before come once more under fresh stamps, bit "
            "for bit: a driver or a bridge that hands on what it has kept; what follows is as "
            "late. Until a motion fits them again the contact mode is unknown and reactions are "
            "withheld"
        )
