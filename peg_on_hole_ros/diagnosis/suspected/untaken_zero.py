"""The zero that nobody has taken: what a peg at rest reads at first may be that, or a contact."""

from math import sqrt

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import UNTAKEN_ZERO_TEST
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.number_text import number
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample


class UntakenZero(Suspect):
    """
    Doubts contacts until a peg has moved, or has hung free, of a sensor whose zero nobody knows.

    A peg that is at rest from the start, and reads the same all the time, may touch, or hang free
    from a sensor that was never tared. What decides is a motion, a load that changes, a reading
    that is the weight alone, a place at the hole, or more than any zero is. Until then nothing
    is made of the wrench.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "untaken_zero"
    FINDS = (
        (
            "`wrench.bias_force_stddev`: the sensor was never tared, or the peg touches; tare "
            "while the peg hangs free. Until a motion decides, the mode is `unknown`",
            "a peg that is at rest from the start on, after half a second",
        ),
    )
    OF_ZERO = True

    def __init__(self, stated: Stated) -> None:
        configuration, wrench = stated.configuration, stated.configuration.wrench
        self._reduction = stated.reduction
        self._about_sensor = np.linalg.inv(stated.reduction.matrix)
        self._weight_H = configuration.scene.peg_mass * np.array(configuration.scene.gravity)
        self._radius = 0.5 * configuration.scene.peg_diameter
        noise = np.array([wrench.force_stddev] * 3 + [wrench.torque_stddev] * 3)
        self._noise = UNTAKEN_ZERO_TEST.sure * noise
        threshold = configuration.monitor.contact_force_threshold
        reach = float(np.linalg.norm(wrench.sensor_xyz)) + self._radius
        self._none = np.array([threshold] * 3 + [reach * threshold] * 3)
        self._most = np.array(
            [UNTAKEN_ZERO_TEST.force] * 3 + [UNTAKEN_ZERO_TEST.torque] * 3, dtype=float
        )
        # A zero that is stated, or how well it is, is the user's word; so is a tare, and contact
        # where no mode is asked for.
        known = (wrench.bias_force_stddev, wrench.bias_torque_stddev, *stated.taken_off)
        self._decided = any(known) or not configuration.monitor.modes
        self.finding: Finding | None = None
        self.restart()

    def restart(self) -> None:
        """Begin to look at a peg at rest anew, unless the zero has been decided."""
        self._open, self._rows = False, 0
        self._mean, self._sum, self._squares = np.zeros(6), np.zeros(6), np.zeros(6)
        self._recent = np.zeros((UNTAKEN_ZERO_TEST.recent, 6))
        self._R0 = np.eye(3)
        self._begun_ns = self._last_ns = 0

    @property
    def unsure(self) -> bool:
        """Whether nothing sure of contacts can be published now."""
        return self._open

    @property
    def zero_open_ns(self) -> int:
        """For how long the reading may have been a zero that nobody has taken; 0: it may not."""
        return self._last_ns - self._begun_ns if self._open else 0

    def take(self, instant: Instant, unsure: bool) -> None:
        """Process a wrench, see the package."""
        if self._decided:
            return
        since_ns = instant.sample.t_ns - self._last_ns
        if unsure or not 0 < since_ns < UNTAKEN_ZERO_TEST.silence_ns:
            self.restart()
        if unsure:
            return
        self._last_ns = instant.sample.t_ns
        self._take(instant.sample, instant.measured)
        shown = self._has_shown(instant.measured)
        beyond = np.abs(self._mean) > self._none + self._noise / sqrt(self._rows)
        if shown or (instant.in_air and not beyond.any()):
            self._decided, self._open = True, False
            return
        self._open = bool(beyond.any()) and self._is_noisy()
        if self._open and self.zero_open_ns >= UNTAKEN_ZERO_TEST.reported_ns:
            self.finding = self.finding or self._found()

    def _take(self, sample: WrenchSample, measured: AngleMeasurement) -> None:
        R_HP = peg_axes(measured.q)
        if not self._rows:
            self._R0, self._begun_ns = R_HP, sample.t_ns
        left = self._reduction.on_peg(sample.force, sample.torque, measured.q)
        left[:3] += R_HP.T @ self._weight_H
        read = self._about_sensor @ left
        self._recent[self._rows % UNTAKEN_ZERO_TEST.recent] = read
        self._rows += 1
        self._sum += read
        self._squares += read * read
        self._mean = self._sum / self._rows

    def _has_shown(self, measured: AngleMeasurement) -> bool:
        """Return whether the reading is no zero of a peg at rest, or the place is at the hole."""
        R_HP = peg_axes(measured.q)
        turn = float(np.linalg.norm(self._R0.T @ R_HP - np.eye(3))) / sqrt(2.0)
        # Three angles, each of two orientations.
        noise = sqrt(6.0 * measured.covariance[0, 0])
        if turn > UNTAKEN_ZERO_TEST.turned * noise:
            return True
        if (np.abs(self._mean) > self._most).any():
            return True
        # A simulated sensor without noise has no zero.
        lasts_ns = self._last_ns - self._begun_ns
        if lasts_ns >= UNTAKEN_ZERO_TEST.noise_ns and not self._is_noisy():
            return True
        return self._has_changed() or self._is_at_hole(measured, R_HP)

    def _is_noisy(self):
        """Return whether the readings differ from each other as those of a sensor do."""
        noise = self._noise / UNTAKEN_ZERO_TEST.sure
        return bool((self._spread() > UNTAKEN_ZERO_TEST.least_noise * noise).any())

    def _spread(self):
        return np.sqrt(np.maximum(self._squares / self._rows - self._mean**2, 0.0))

    def _has_changed(self):
        """Return whether the latest readings differ from those before."""
        recent = UNTAKEN_ZERO_TEST.recent
        before = self._rows - recent
        if before < recent:
            return False
        latest = self._recent.sum(axis=0)
        earlier = (self._sum - latest) / before
        noise = np.maximum(self._spread(), self._noise / UNTAKEN_ZERO_TEST.sure)
        off = np.abs(latest / recent - earlier)
        changed = UNTAKEN_ZERO_TEST.changed * noise * sqrt(1.0 / recent + 1.0 / before)
        return bool((off > changed).any())

    def _is_at_hole(self, measured, R_HP):
        """Return whether the place that is measured lets the peg's lower end touch."""
        if measured.position is None or not np.isfinite(measured.position).all():
            return False
        lowest = measured.position[2] - self._radius * sqrt(max(1.0 - R_HP[2, 2] ** 2, 0.0))
        stddev = sqrt(max(measured.position_covariance[2, 2], 0.0))
        return bool(lowest < UNTAKEN_ZERO_TEST.sure * stddev)

    def _found(self) -> Finding:
        """Return what is to be set, and why."""
        read = self._reduction.sign * self._mean
        force, torque = (", ".join(number(x, 2) for x in each) for each in (read[:3], read[3:]))
        size = float(np.linalg.norm(read[:3])), float(np.linalg.norm(read[3:]))
        return Finding(
            f"wrench.bias_force_stddev: a peg at rest reads [{force}] N, [{torque}] N m beside "
            "its weight from the start on: a zero that nobody has taken (or a payload that is "
            "not stated), or a contact. Tare it where it hangs free (~/tare, "
            f"wrench.tare_automatically), or state bias_force_stddev: {number(size[0], 2)} and "
            f"bias_torque_stddev: {number(size[1], 2)}; until it moves the contact mode is "
            "unknown",
            {},
        )
