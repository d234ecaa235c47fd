"""A low-pass of the driver: it makes the noise of neighbouring wrenches alike."""

from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Stated, Suspect
from peg_on_hole_ros.identification.low_pass import NoiseOfNeighbours
from peg_on_hole_ros.identification.tuned import LOW_PASS_TEST
from peg_on_hole_ros.number_text import number, quantity


class LowPass(Suspect):
    """
    Compares the noise of neighbours with that of wrenches apart, see `NoiseOfNeighbours`.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "low_pass"
    FINDS = (
        (
            "`low-pass`: noise of successive wrenches is correlated; with the filter's cut-off",
            "the quietest half second of 1.5 s and more",
        ),
    )
    LASTS = True

    def __init__(self, stated: Stated) -> None:
        wrench = stated.configuration.wrench
        self._cutoff = wrench.low_pass
        self._noise = NoiseOfNeighbours(wrench.force_stddev, wrench.torque_stddev)
        self.finding: Finding | None = None
        self._taken: list[tuple[ArrayLike, ArrayLike]] = []
        self._room = LOW_PASS_TEST.stretch

    def take_every_wrench(self, t_ns: np.ndarray, wrenches: np.ndarray) -> None:
        """Process every wrench, see the package."""
        while len(t_ns):
            room = self._room
            self._add(t_ns[:room], wrenches[:room], min(room, len(t_ns)))
            t_ns, wrenches = t_ns[room:], wrenches[room:]

    def _add(self, t_ns, rows, count):
        self._taken.append((t_ns, rows))
        self._room -= count
        if not self._room:
            stamps, rows = zip(*self._taken)
            self._judge(np.vstack(rows), np.hstack(stamps))
            self._taken, self._room = [], LOW_PASS_TEST.stretch

    def _judge(self, rows, t_ns):
        if not self._noise.compare(t_ns, rows) or not self._noise.enough:
            return
        if self._noise.pole == 0.0:
            self.finding = None
        elif self.finding is None and not 0.0 < 0.5 * self._cutoff < self._noise.cutoff:
            self.finding = Finding(self._said(), {})

    def _said(self):
        pole = self._noise.pole
        wider = sqrt((1.0 + pole) / (1.0 - pole))
        return (
            "low-pass: the noise of successive wrenches is correlated, as behind a filter of "
            f"about {quantity(self._noise.cutoff, 'Hz', 2)}: turn the driver's filter off, or "
            f"state wrench.low_pass, and force_stddev and torque_stddev {number(wider, 2)} "
            "times as large"
        )
