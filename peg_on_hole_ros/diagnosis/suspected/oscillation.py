"""An oscillation of the wrench: hum of the mains, or an arm that swings, at one frequency."""

from math import hypot, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import OSCILLATION_TEST

# Root mean square of an oscillation, over its amplitude.
_RMS = sqrt(0.5)


class _Tone(NamedTuple):
    """Frequency [Hz], and the largest amplitude of force and torque [N], [N m]."""

    frequency: float
    force: float
    torque: float


class Oscillation(Suspect):
    """
    Looks for one line in the spectrum of the wrench, in stretches of a quarter second.

    A motion and a touch-down have wide spectra; what stays at one frequency is none of them. It
    has no mean, so that a zero that seems to be off is that of the moment. One that is loud counts
    as noise, by the root of its mean square.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "oscillation"
    FINDS = (
        (
            "`the wrench oscillates`, with frequency and amplitude: hum of the mains, or an arm "
            "that swings. Meanwhile no other setting is reported or adopted; where it exceeds the "
            "stated noise by four times it counts as noise, and until then, or without "
            "`wrench.adopt_found`, the mode is `unknown`, and `reactions_determined` is 0",
            "anywhere, after 0.8 s; from 12 Hz on",
        ),
    )
    WITHOUT_WRENCH = True
    LASTS = True
    ADOPTS = True

    def __init__(self, stated: Stated) -> None:
        self.finding: Finding | None = None
        self.restate(stated)
        self.restart()

    def restate(self, stated: Stated) -> None:
        """Take other noise, which may be that of the oscillation."""
        wrench = stated.configuration.wrench
        self._noise = np.array([wrench.force_stddev] * 3 + [wrench.torque_stddev] * 3)

    def restart(self) -> None:
        """Forget the wrenches so far."""
        self._passed: list[tuple[np.ndarray, np.ndarray]] = []
        # Of the last stretch, how many before it were alike, and how many since had no such line.
        self._last: _Tone | None = None
        self._alike = self._without = 0
        self._tone: _Tone | None = None

    @property
    def hides(self) -> bool:  # type: ignore[override]
        """Whether a mean is that of the moment."""
        return self._tone is not None

    @property
    def unsure(self) -> bool:
        """Whether it exceeds the noise by far."""
        if self._tone is None:
            return False
        over = self._tone.force / self._noise[0], self._tone.torque / self._noise[3]
        return max(over) > OSCILLATION_TEST.loud

    def _with(self, tone: _Tone) -> dict[str, object]:
        """Return the noise that wrenches have with a tone."""
        force, torque = self._noise[[0, 3]].tolist()
        return {
            "force_stddev": hypot(force, tone.force * _RMS),
            "torque_stddev": hypot(torque, tone.torque * _RMS),
        }

    def take_every_wrench(self, t_ns: np.ndarray, wrenches: np.ndarray) -> None:
        """Process every wrench, see the package."""
        if len(t_ns):
            self._passed.append((t_ns, wrenches))

    def take(self, instant: Instant, unsure: bool) -> None:
        """Look at a stretch that is complete."""
        if not self._passed:
            return
        lasts_ns = self._passed[-1][0][-1] - self._passed[0][0][0]
        if 0 <= lasts_ns < OSCILLATION_TEST.stretch_ns:
            return
        t_ns, rows = (np.concatenate(each) for each in zip(*self._passed))
        self._passed = []
        before, self._last = self._last, self._heard(t_ns, rows)
        same = before is not None and self._last is not None and _same(before, self._last)
        self._alike = self._alike + 1 if same else 0
        self._without = 0 if same else self._without + 1
        if same:
            self._tone = self._last
        elif self._without >= OSCILLATION_TEST.lasts:
            self._tone = None
        if self._tone and self._alike >= OSCILLATION_TEST.stretches - 1 and self.finding is None:
            noise = self._with(self._tone) if self.unsure else {}
            self.finding = Finding(_said(self._tone), noise)

    def _heard(self, t_ns, rows):
        """Return the line in the spectrum of a stretch, or None."""
        steps = np.diff(t_ns)
        period_ns = np.median(steps)
        if len(rows) < OSCILLATION_TEST.fewest or period_ns <= 0:
            return None
        if steps.min() < 0.5 * period_ns or steps.max() > 1.5 * period_ns:
            return None
        n = len(rows)
        line = np.column_stack([np.ones(n), np.linspace(-1.0, 1.0, n)])
        left = rows - line @ np.linalg.lstsq(line, rows, rcond=None)[0]
        window = np.hanning(n + 1)[:n]
        spectra = np.abs(np.fft.rfft(left * window[:, None], axis=0))
        power = np.square(spectra / self._noise).sum(axis=1)
        first, beside = OSCILLATION_TEST.first_bin, OSCILLATION_TEST.beside
        if len(power) <= first + 2 * beside:
            return None
        k = first + int(np.argmax(power[first : len(power) - beside]))
        floor = np.median(power[first:])
        hill = max(power[max(k - beside, 1)], power[k + beside])
        least = max(OSCILLATION_TEST.above * floor, OSCILLATION_TEST.narrow * hill)
        if not 0.0 < least < power[k]:
            return None
        # Of a Hann window the bins beside a line tell where between them it lies.
        side = 1 if power[k + 1] > power[k - 1] else -1
        ratio = np.sqrt(power[k + side] / power[k])
        beyond = (2.0 * ratio - 1.0) / (1.0 + ratio)
        gain = np.sinc(beyond) / (1.0 - beyond**2) if abs(beyond) < 0.99 else 0.5
        amplitudes = 2.0 * spectra[k] / (window.sum() * gain)
        frequency = (k + side * beyond) / (n * period_ns * 1e-9)
        return _Tone(frequency, float(amplitudes[:3].max()), float(amplitudes[3:].max()))


def _same(a, b):
    near = OSCILLATION_TEST.same
    return abs(a.frequency - b.frequency) < near * b.frequency


def _said(tone):
    mains = any(abs(tone.frequency - hertz) < 1.0 for hertz in OSCILLATION_TEST.mains)
    why = (
        "hum of the mains: look at the sensor's cable, its shield and its ground"
        if mains
        else "an arm, a tool or a cable that swings, or a controller that is not stable: damp it, "
        "or move more slowly"
    )
    return (
        f"the wrench oscillates at {tone.frequency:.1f} Hz by {tone.force:.2g} N and "
        f"{tone.torque:.2g} N m: {why}. Its samples show no zero, which is the mean over whole "
        "periods"
    )
