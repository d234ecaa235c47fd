"""A low-pass of the driver: it makes the noise of neighbouring wrenches alike."""

from math import log, pi, sqrt

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import LOW_PASS_TEST


class LowPass(Suspect):
    """
    Compares the noise of neighbours with that of wrenches apart, in forces and in torques.

    Of white noise both are one; a motion makes those apart differ, so the quietest stretch counts.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "low_pass"
    FINDS = (
        (
            "`low-pass`: noise of neighbours is alike, with the filter's cut-off",
            "the quietest half second of 1.5 s and more",
        ),
    )
    LASTS = True

    def __init__(self, stated: Stated) -> None:
        wrench = stated.configuration.wrench
        noise = [wrench.force_stddev] * 3 + [wrench.torque_stddev] * 3
        self._cutoff = wrench.low_pass
        self._least = np.square(LOW_PASS_TEST.noisy * np.array(noise))
        self.finding: Finding | None = None
        self._ratio, self._stretches, self._told = float("inf"), 0, False
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
        steps = np.diff(t_ns)
        period = float(np.median(steps)) * 1e-9
        # Values that repeat, or are rounded, are another matter; so is a gap.
        still = (np.diff(rows, axis=0) == 0.0).all(axis=1).mean()
        if period <= 0.0 or steps.max() > 2.0 * np.median(steps) or still > 0.02:
            return
        near, apart = (_curved(rows, lag) for lag in (1, LOW_PASS_TEST.apart))
        if not (near > self._least).all():
            return
        # A motion is in some of the six.
        ratio = apart / near
        self._ratio = min(self._ratio, float(np.median(ratio[:3])), float(np.median(ratio[3:])))
        self._stretches += 1
        if self._stretches < LOW_PASS_TEST.enough:
            return
        if self._ratio < LOW_PASS_TEST.alike:
            self.finding = None
        elif self.finding is None and not self._is_stated(period):
            self.finding = Finding(self._said(period), {})

    def _is_stated(self, period):
        return self._cutoff > 0.0 and _cutoff(_pole(self._ratio), period) > 0.5 * self._cutoff

    def _said(self, period):
        pole = _pole(self._ratio)
        wider = sqrt((1.0 + pole) / (1.0 - pole))
        return (
            f"low-pass: the noise of neighbouring wrenches is alike, as behind a filter of about "
            f"{_cutoff(pole, period):.2g} Hz: turn the driver's filter off, or state "
            f"wrench.low_pass, and force_stddev and torque_stddev {wider:.2g} times as large"
        )


def _curved(rows, lag):
    """Return the variance of second differences over a lag, of white noise that of the noise."""
    second = rows[2 * lag :] - 2.0 * rows[lag:-lag] + rows[: -2 * lag]
    return np.mean(np.square(second), axis=0) / 6.0


def _cutoff(pole, period):
    """Return the cut-off of a first-order filter with a pole at a period [s], in Hz."""
    return -log(pole) / (2.0 * pi * period)


def _pole(ratio):
    """Return the pole of a first-order filter that has such a ratio, by halving."""
    low, high = 0.0, 1.0 - 1e-6
    for _ in range(50):
        pole = 0.5 * (low + high)
        near, apart = (
            3.0 - 4.0 * pole**lag + pole ** (2 * lag) for lag in (1, LOW_PASS_TEST.apart)
        )
        low, high = (pole, high) if apart / near < ratio else (low, pole)
    return pole
