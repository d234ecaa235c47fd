"""What the data tell of the settings as they come: findings, and what is used in their place."""

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from peg_on_hole_ros.config.options import Configuration, WrenchInput
from peg_on_hole_ros.diagnosis.delay import Delay
from peg_on_hole_ros.diagnosis.diagnosis import Diagnosis
from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.free_air import FreeAir
from peg_on_hole_ros.diagnosis.low_pass import LowPass
from peg_on_hole_ros.diagnosis.rim_motion import RimMotion
from peg_on_hole_ros.diagnosis.untold import Untold
from peg_on_hole_ros.measurements.measurement import WrenchReduction
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample

# Stamps that fall by more begin another window of the diagnosis.
DUE_NS = 100_000_000
_NOISE = "force_stddev", "torque_stddev"


class Findings:
    """
    Looks for settings that are wrong, and for what is right.

    Parameters
    ----------
    configuration : Configuration
    reduction : WrenchReduction
    counts : Counter
        Counted up: `setting_contradicted`, `setting_adopted`, `tare` is looked at.
    offline : bool
        Whether there is time to run the estimator again at other delays.

    Attributes
    ----------
    untold : Untold
        What the present motion does not tell.

    """

    def __init__(
        self,
        configuration: Configuration,
        reduction: WrenchReduction,
        counts: Counter[str],
        offline: bool = False,
    ) -> None:
        self._counts, self._offline = counts, offline
        self._low_pass = LowPass(configuration.wrench)
        # What is used in place of what is stated.
        self._adopted: dict[str, Any] = {}
        self._mounted: dict[str, Any] = {}
        self._found: list[Finding] = []
        self._stated = configuration.wrench
        self.look(configuration, reduction, reduction.taken_off)

    def look(
        self, configuration: Configuration, reduction: WrenchReduction, taken_off: np.ndarray
    ) -> None:
        """Begin to look, with what is taken off a wrench as received, shape (6,)."""
        self._configuration = configuration
        self._diagnosis = Diagnosis(configuration, taken_off)
        self._air = FreeAir(configuration, reduction)
        self._rim = RimMotion(configuration)
        self._delay = Delay(configuration, taken_off) if self._offline else None
        self.untold = Untold(configuration)

    def restart(self) -> None:
        """Forget what a motion has told so far."""
        self._diagnosis.restart()
        self._air.restart()
        self._rim.restart()
        if self._delay is not None:
            self._delay.restart()
        self.untold.restart()

    def forget_zero(self) -> None:
        """Forget what was found of the zero: a tare has taken it."""
        self._found = [finding for finding in self._found if finding is not self._air.finding]

    def mount(self, xyz: tuple[float, float, float], rpy: tuple[float, float, float]) -> None:
        """Take note of another pose of the sensor [m], [rad]."""
        self._mounted = {"sensor_xyz": xyz, "sensor_rpy": rpy}

    def restate(self, wrench: WrenchInput) -> bool:
        """Let noise that is stated anew take the place of what was found; return whether it is."""
        before, self._stated = self._stated, wrench
        changed = [name for name in _NOISE if getattr(wrench, name) != getattr(before, name)]
        for name in changed:
            self._adopted.pop(name, None)
        return bool(changed)

    def as_found(self, configuration: Configuration) -> Configuration:
        """Return settings with what is used in place of them."""
        wrench = replace(configuration.wrench, **(self._mounted | self._adopted))
        return replace(configuration, wrench=wrench)

    @property
    def unsure(self) -> bool:
        """Whether nothing sure may be told."""
        return self._diagnosis.unsure

    @property
    def due(self) -> tuple[int, int]:
        """Stamps from which on a wrench is looked at, and before which one is, too [ns]."""
        due_ns = self._diagnosis.due_ns
        return due_ns, due_ns - DUE_NS

    @property
    def causes(self) -> list[str]:
        """Settings that the data have contradicted, a line each."""
        return [
            f"{finding.of}: {finding.text}; used in place of what is stated (wrench.adopt_found)"
            if self._is_used(finding)
            else f"{finding.of}: {finding.text}"
            # What a wrench means rests on how hole and peg are stated.
            for finding in sorted(self._found, key=lambda each: each.of == "wrench")
        ]

    @property
    def void_reactions(self) -> bool:
        """Whether reactions rest on what the data have contradicted, with nothing in its place."""
        return any(found.voids and not self._is_used(found) for found in self._found)

    def _is_used(self, finding):
        return bool(finding.found) and self._adopted.items() >= finding.found.items()

    def pass_by(self, t_ns: np.ndarray, wrenches: np.ndarray) -> None:
        """Take any wrenches in their order: stamps [ns], force and torque (n, 6)."""
        self._low_pass.take_all(t_ns, wrenches)
        if self._delay is not None:
            self._delay.pass_by(t_ns, wrenches)

    def take(
        self,
        sample: WrenchSample,
        measured: AngleMeasurement,
        stands_still: bool,
        in_air: bool | None,
    ) -> bool:
        """
        Try what else a wrench that is due may mean.

        Parameters
        ----------
        sample : WrenchSample
        measured : AngleMeasurement
            The latest orientation.
        stands_still : bool
            Whether the wrench repeats one value.
        in_air : bool or None
            Whether the peg was told to be in the air; None: nothing was told.

        Returns
        -------
        bool
            Whether another setting is to be used from here on, see `as_found`.

        """
        diagnosis, known = self._diagnosis, self._diagnosis.finding
        diagnosis.take(sample, measured)
        if not diagnosis.unsure and not stands_still:
            self._air.take(sample, measured.q, in_air is True)
        self._rim.take(measured, in_air is not False)
        others = [self._air.finding, self._low_pass.finding, self._rim.finding]
        if self._delay is not None:
            self._delay.take(measured, in_air is False and not diagnosis.unsure)
            others.append(self._delay.finding)
        others.append(self.untold.finding)
        for finding in (diagnosis.rounded(), diagnosis.finding, *others):
            if finding is None or finding is known or finding in self._found:
                continue
            self._counts["setting_contradicted"] += 1
            self._found.append(finding)
            # Each once: a wrench that fits the one now and the other then has another fault. Two
            # faults at once are told alone, for more of them fit by chance. And a tare that was
            # taken by the wrong setting has no meaning by the right one.
            alone = len(finding.found) == 1 or finding is not diagnosis.finding
            new = alone and finding.found and not finding.found.keys() & self._adopted.keys()
            adopts = self._configuration.wrench.adopt_found and not self._counts["tare"]
            if new and adopts:
                self._adopted |= finding.found
                self._counts["setting_adopted"] += 1
                return True
        return False
