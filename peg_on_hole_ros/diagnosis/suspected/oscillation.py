"""An oscillation of the wrench: hum of the mains, or an arm that swings, at one frequency."""

from collections import deque
from math import ceil, hypot, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import OSCILLATION_TEST
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.number_text import number

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
            "stated noise by half it counts as noise. Where it does by four times, the mode is "
            "`unknown`, and `reactions_determined` is 0, until then, without "
            "`wrench.adopt_found`, and where the load over whole periods is less than a third of "
            "it",
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
        self._reduction, self._scene = stated.reduction, stated.configuration.scene
        wrench = stated.configuration.wrench
        self._noise = np.array([wrench.force_stddev] * 3 + [wrench.torque_stddev] * 3)

    def restart(self) -> None:
        """Forget the wrenches so far."""
        self._passed: list[tuple[np.ndarray, np.ndarray]] = []
        # The latest of these, for the load.
        self._recent: deque[tuple[np.ndarray, np.ndarray]] = deque()
        # Of the last stretch, how many before it were alike, and how many since had no such line.
        self._last: _Tone | None = None
        self._alike = self._without = 0
        self._tone: _Tone | None = None
        self._loud = self._slight = False

    @property
    def hides(self) -> bool:  # type: ignore[override]
        """Whether a mean is that of the moment."""
        return self._tone is not None

    @property
    def unsure(self) -> bool:
        """Whether it exceeds the noise by far, or all that may carry the peg."""
        return self._tone is not None and (self._is_loud(self._tone) or self._slight)

    def _is_loud(self, tone):
        return self._over_noise(tone) > OSCILLATION_TEST.loud

    def _over_noise(self, tone):
        return max(tone.force / self._noise[0], tone.torque / self._noise[3])

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
            self._recent.append((t_ns, wrenches))
            while t_ns[-1] - self._recent[0][0][-1] > OSCILLATION_TEST.stretch_ns:
                self._recent.popleft()

    def take(self, instant: Instant, unsure: bool) -> None:
        """Look at the load, and at a stretch that is complete."""
        if not self._passed:
            return
        self._weigh(instant.measured.q)
        lasts_ns = self._passed[-1][0][-1] - self._passed[0][0][0]
        if 0 <= lasts_ns < OSCILLATION_TEST.stretch_ns:
            return
        t_ns, rows = (np.concatenate(each) for each in zip(*self._passed))
        first, self._passed = self._last is None and not self._without, []
        before, self._last = self._last, self._heard(t_ns, rows)
        same = before is not None and self._last is not None and _same(before, self._last)
        self._alike = self._alike + 1 if same else 0
        self._without = 0 if same else self._without + 1
        if same or (first and self._last and self._is_loud(self._last)):
            # Of what a recording begins with nothing else is known yet.
            self._tone = self._last
            self._loud = self._loud or self._is_loud(self._last)
        elif self._without >= OSCILLATION_TEST.lasts:
            self._tone, self._loud = None, False
        if self._tone and self._alike >= OSCILLATION_TEST.stretches - 1 and self.finding is None:
            counts = self._over_noise(self._tone) > OSCILLATION_TEST.counts
            noise = self._with(self._tone) if counts or self.unsure else {}
            self.finding = Finding(_said(self._tone), noise)

    def _weigh(self, q):
        """Note whether a loud oscillation swings by more than the load over whole periods."""
        self._slight = False
        if self._tone is None or not self._loud:
            return
        t_ns, rows = (np.concatenate(each) for each in zip(*self._recent))
        periods = ceil(OSCILLATION_TEST.mean_s * self._tone.frequency)
        lasts_ns = periods * 1e9 / self._tone.frequency
        mean = rows[t_ns > t_ns[-1] - lasts_ns].mean(axis=0)
        carried = self._reduction.on_peg(mean[:3], mean[3:], q)
        carried[:3] += self._scene.peg_mass * (peg_axes(q).T @ np.array(self._scene.gravity))
        sizes = np.linalg.norm(carried.reshape(2, 3), axis=1)
        least = OSCILLATION_TEST.slight * np.array([self._tone.force, self._tone.torque])
        self._slight = bool((sizes < least).all())

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
        f"the wrench oscillates at {tone.frequency:.1f} Hz by {number(tone.force, 2)} N and "
        f"{number(tone.torque, 2)} N m: {why}. Its samples show no zero, which is the mean "
        "over whole periods"
    )
