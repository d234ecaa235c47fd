"""What the data tell of the settings as they come: findings, and what is used in their place."""

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from peg_on_hole_ros.config.options import Configuration, WrenchInput
from peg_on_hole_ros.diagnosis.dead_component import DeadComponent
from peg_on_hole_ros.diagnosis.delay import Delay
from peg_on_hole_ros.diagnosis.diagnosis import Diagnosis
from peg_on_hole_ros.diagnosis.due import Due
from peg_on_hole_ros.diagnosis.fence import Failures, Fenced
from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.free_air import FreeAir
from peg_on_hole_ros.diagnosis.low_pass import LowPass
from peg_on_hole_ros.diagnosis.rim_motion import RimMotion
from peg_on_hole_ros.diagnosis.untold import KINDS, Untold
from peg_on_hole_ros.engine.tuned import DIAGNOSIS_STEP
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.measurements.measurement import WrenchReduction
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample

_NOISE = "force_stddev", "torque_stddev"
_NO_COSTS = np.full(len(KINDS), np.nan)


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
    failures : Failures
        Looks that failed: each of them is fenced, and the others and the estimate go on.

    """

    def __init__(
        self,
        configuration: Configuration,
        reduction: WrenchReduction,
        counts: Counter[str],
        offline: bool = False,
    ) -> None:
        self._counts, self._offline = counts, offline
        self.failures = Failures(counts)
        self._due = Due()
        self._low_pass = self._fenced("low_pass", lambda: LowPass(configuration.wrench))
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
        self._due.restart()
        fenced = self._fenced
        self._dead = fenced("dead_component", lambda: DeadComponent(configuration.wrench))
        self._diagnosis = fenced("wrong_wrench", lambda: Diagnosis(configuration, taken_off))
        self._air = fenced("free_air", lambda: FreeAir(configuration, reduction))
        self._rim = fenced("rim_motion", lambda: RimMotion(configuration))
        self._delay = None
        if self._offline:
            self._delay = fenced("delay", lambda: Delay(configuration, taken_off))
        self._untold = fenced("unobservable", lambda: Untold(configuration))

    def _fenced(self, name, make):
        return Fenced(name, make, self.failures)

    def restart(self) -> None:
        """Forget what a motion has told so far."""
        self._due.restart()
        for look in (
            self._dead, self._diagnosis, self._air, self._rim, self._delay, self._untold,
        ):  # fmt: skip
            if look is not None:
                look(lambda it: it.restart(), None)

    def forget_zero(self) -> None:
        """Forget what was found of the zero: a tare has taken it."""
        zero = _finding(self._air)
        self._found = [finding for finding in self._found if finding is not zero]

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
        if self._dead(lambda look: look.suspects, False):
            return True
        look = self._diagnosis.look
        if look is None:
            return False
        # Of a look that has failed a doubt is dropped; what it found stays.
        return look.finding is not None if self._diagnosis.failed else look.unsure

    @property
    def due(self) -> tuple[int, int]:
        """Stamps from which on a wrench is looked at, and before which one is, too [ns]."""
        return self._due.ns, self._due.ns - DIAGNOSIS_STEP.back_ns

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
        self._low_pass(lambda look: look.take_all(t_ns, wrenches), None)
        if self._delay is not None:
            self._delay(lambda look: look.pass_by(t_ns, wrenches), None)

    def count(self, wrenches: int) -> None:
        """Take note of so many wrenches whose estimate was given."""
        self._untold(lambda look: look.count(wrenches), None)

    def take_estimate(self, t_ns: int, peg: ContactFilter, determined: bool) -> None:
        """Take the estimate at a stamp [ns] on three contacts, see `Untold.take`."""
        self._untold(lambda look: look.take(t_ns, peg, determined), None)

    def lift(self) -> None:
        """Take note that the peg is not on three contacts."""
        self._untold(lambda look: look.restart(), None)

    @property
    def costs(self) -> np.ndarray:
        """What each setting that is off would cost, see `Untold`, shape (8,) [N]."""
        return self._untold(lambda look: look.costs, _NO_COSTS)

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
        known = _finding(self._diagnosis)
        self._dead(lambda look: look.take(sample), None)
        self._due.take(sample.t_ns)
        self._diagnosis(lambda look: look.take(sample, measured), None)
        unsure = self.unsure
        if not unsure and not stands_still:
            self._air(lambda look: look.take(sample, measured.q, in_air is True), None)
        self._rim(lambda look: look.take(measured, in_air is not False), None)
        if self._delay is not None:
            self._delay(lambda look: look.take(measured, in_air is False and not unsure), None)
        rounded = self._diagnosis(lambda look: look.rounded(), None)
        found = _finding(self._diagnosis)
        looks = self._air, self._low_pass, self._rim, self._delay, self._untold
        told = [rounded, found, *map(_finding, looks)]
        if self._dead(lambda look: look.suspects, False):
            # What a wrench without one of its components seems to mean is no setting.
            told = [_finding(self._dead), _finding(self._rim)]
        for finding in told:
            if finding is None or finding is known or finding in self._found:
                continue
            self._counts["setting_contradicted"] += 1
            self._found.append(finding)
            # Each once: a wrench that fits the one now and the other then has another fault. Two
            # faults at once are told alone, for more of them fit by chance. And a tare that was
            # taken by the wrong setting has no meaning by the right one.
            alone = len(finding.found) == 1 or finding is not found
            new = alone and finding.found and not finding.found.keys() & self._adopted.keys()
            adopts = self._configuration.wrench.adopt_found and not self._counts["tare"]
            if new and adopts:
                self._adopted |= finding.found
                self._counts["setting_adopted"] += 1
                return True
        return False


def _finding(look):
    """Return what a look has found, whether it has failed since or not."""
    return None if look is None or look.look is None else look.look.finding
