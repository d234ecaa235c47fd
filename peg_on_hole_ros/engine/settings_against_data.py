"""What the data show of the settings as they come: findings, and what is used in their place."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from peg_on_hole_ros.config.options import Configuration, WrenchInput
from peg_on_hole_ros.diagnosis.due import Due
from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.guarded_looks import Failures, GuardedLook
from peg_on_hole_ros.diagnosis.suspected.registry import SUSPECTED
from peg_on_hole_ros.diagnosis.suspected.suspect import (
    PARTS,
    Instant,
    Stated,
    Suspect,
    has_part,
)
from peg_on_hole_ros.engine.tuned import DIAGNOSIS_STEP
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.typed_record import Floats

_NOISE = "force_stddev", "torque_stddev"


class SettingsAgainstData:
    """
    Looks for settings that are wrong, and for what is right: walks all suspected settings.

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
        self._counts = counts
        self.failures = Failures(counts)
        self._due = Due()
        self._members = [member for member in SUSPECTED if offline or not member.OFFLINE]
        self._looks: dict[type[Suspect], GuardedLook[Suspect]] = {}
        # What is used in place of what is stated.
        self._adopted: dict[str, Any] = {}
        self._mounted: dict[str, Any] = {}
        self._found: list[Finding] = []
        self._arrived: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        self._stated = configuration.wrench
        self.look(configuration, reduction, reduction.taken_off)

    def look(
        self,
        configuration: Configuration,
        reduction: WrenchReduction,
        taken_off: np.ndarray,
        tared: bool = False,
    ) -> None:
        """
        Begin to look, with what is taken off a wrench as received, shape (6,).

        `tared`: that alone has changed, and wrenches as received have not.
        """
        self._configuration = configuration
        self._due.restart()
        stated = Stated(configuration, reduction, taken_off)
        for member in self._members:
            lasts = member.LASTS or (tared and member.SPANS_TARE)
            if lasts and member in self._looks:
                self._looks[member](lambda it: it.restate(stated), None)
            else:
                make = partial(member, stated)
                self._looks[member] = GuardedLook(member.NAME, make, self.failures)
        self._with = {part: self._that_have(part) for part in PARTS}
        self._without_wrench = [
            look for member, look in self._looks.items() if member.WITHOUT_WRENCH
        ]

    def _that_have(self, part: str) -> list[GuardedLook[Suspect]]:
        """Return the looks that have a part of the interface as their own."""
        return [look for member, look in self._looks.items() if has_part(member, part)]

    def restart(self) -> None:
        """Forget what a motion has shown so far."""
        self._due.restart()
        for look in self._looks.values():
            look(lambda it: it.restart(), None)

    def forget_zero(self) -> None:
        """Forget what was found of the zero: a tare has taken it."""
        zero = [
            finding
            for member, look in self._looks.items()
            if member.OF_ZERO
            for finding in _findings(look)
        ]
        self._found = [found for found in self._found if not any(found is each for each in zero)]
        for look in self._looks.values():
            look(lambda it: it.forget_zero(), None)

    def set_sensor_pose(
        self, xyz: tuple[float, float, float], rpy: tuple[float, float, float]
    ) -> None:
        """Record another pose of the sensor [m], [rad]."""
        self._mounted = {"sensor_xyz": xyz, "sensor_rpy": rpy}

    def restate(self, wrench: WrenchInput) -> bool:
        """Drop the noise that was found where noise is stated anew; return whether it is."""
        before, self._stated = self._stated, wrench
        changed = [name for name in _NOISE if getattr(wrench, name) != getattr(before, name)]
        for name in changed:
            self._adopted.pop(name, None)
        return bool(changed)

    def with_findings(self, configuration: Configuration) -> Configuration:
        """Return settings with what is used in place of them."""
        wrench = replace(configuration.wrench, **(self._mounted | self._adopted))
        return replace(configuration, wrench=wrench)

    @property
    def unsure(self) -> bool:
        """Whether what rests on the wrench is withheld."""
        return any(map(_is_unsure, self._with["unsure"]))

    @property
    def unsure_of_meaning(self) -> bool:
        """Whether it is withheld for anything but a zero, which a tare takes."""
        return any(
            _is_unsure(look)
            for member, look in self._looks.items()
            if has_part(member, "unsure") and not member.OF_ZERO
        )

    @property
    def zero_open_ns(self) -> int:
        """For how long the reading may have been a zero that nobody has taken; 0: it may not."""
        return max(look(_zero_open_ns, 0) for look in self._with["zero_open_ns"])

    @property
    def withholds(self) -> bool:
        """Whether no reactions are called determined."""
        return self.reactions_are_void or any(
            look(lambda it: it.withholds, False) for look in self._with["withholds"]
        )

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
            for finding in sorted(self._told, key=lambda each: each.of == "wrench")
        ]

    @property
    def _told(self):
        """What was found, without hints where anything else was: one cause at a time."""
        return [each for each in self._found if not each.hint] or self._found

    @property
    def causes_of_stamps(self) -> list[str]:
        """What the stamps alone show, a line each."""
        return [
            f"{finding.of}: {finding.text}"
            for member, look in self._looks.items()
            if member.OF_STAMPS
            for finding in _findings(look)
        ]

    @property
    def reactions_are_void(self) -> bool:
        """Whether reactions rest on what the data have contradicted, with nothing in its place."""
        return any(found.voids and not self._is_used(found) for found in self._found)

    def _is_used(self, finding):
        return bool(finding.found) and self._adopted.items() >= finding.found.items()

    @property
    def explains_joints(self) -> bool:
        """Whether it was found what is odd about the values of joint states."""
        return any(look(_explains_joints, False) for look in self._with["explains_joints"])

    @property
    def joints_variance(self) -> float:
        """Times which the variance of an orientation is that of the stated noise [-]."""
        return max(
            (look(_joints_variance, 1.0) for look in self._with["joints_variance"]), default=1.0
        )

    def take_arrivals(
        self, of_wrench: np.ndarray, t_ns: np.ndarray, positions: np.ndarray
    ) -> None:
        """
        Process messages in the order in which they came.

        Parameters
        ----------
        of_wrench : ndarray of bool, shape (n,)
        t_ns : ndarray of int64, shape (n,)
            Stamps [ns].
        positions : ndarray, shape (m, joints)
            What the joints read, of all that are no wrench [rad or m].

        """
        self._arrived.append((of_wrench, t_ns, positions))
        if len(self._arrived) >= DIAGNOSIS_STEP.arrivals:
            self._hand_on_arrived()

    def _hand_on_arrived(self):
        if self._arrived:
            of_wrench, t_ns = (np.concatenate(each) for each in list(zip(*self._arrived))[:2])
            read = [positions for *_, positions in self._arrived if len(positions)]
            self._arrived = []
            for look in self._with["take_stamps"]:
                look(lambda it: it.take_stamps(of_wrench, t_ns), None)
            if read:
                positions = np.concatenate(read)
                for look in self._with["take_joints"]:
                    look(lambda it: it.take_joints(t_ns[~of_wrench], positions), None)

    def take_every_wrench(self, t_ns: np.ndarray, wrenches: np.ndarray) -> None:
        """Process any wrenches in their order: stamps [ns], force and torque (n, 6)."""
        for look in self._with["take_every_wrench"]:
            look(lambda it: it.take_every_wrench(t_ns, wrenches), None)

    def count(self, wrenches: int) -> None:
        """Count so many wrenches whose estimate was given."""
        for look in self._with["count"]:
            look(lambda it: it.count(wrenches), None)

    def take_estimate(self, t_ns: int, peg: ContactFilter, determined: bool) -> None:
        """Process the estimate at a stamp [ns] on three contacts, and whether it is determined."""
        for look in self._with["take_estimate"]:
            look(lambda it: it.take_estimate(t_ns, peg, determined), None)

    def leave_three_contacts(self) -> None:
        """Record that the peg is not on three contacts."""
        for look in self._with["leave_three_contacts"]:
            look(lambda it: it.leave_three_contacts(), None)

    @property
    def reaction_errors(self) -> Floats | None:
        """What each setting that is off would cost, of the first look that knows it [N]."""
        for look in self._with["reaction_errors"]:
            reaction_errors = look(_reaction_errors, None)
            if reaction_errors is not None:
                return reaction_errors
        return None

    def take(self, instant: Instant) -> bool:
        """
        Try what else a wrench that is due may mean.

        Returns
        -------
        bool
            Whether another setting is to be used from here on, see `with_findings`.

        """
        self._due.take(instant.sample.t_ns)
        self._hand_on_arrived()
        unsure = False
        looks = self._with["take"]
        if instant.standing is not None:
            looks = [look for look in looks if look in self._without_wrench]
        for look in looks:
            look(partial(_take, instant, unsure), None)
            unsure = unsure or _is_unsure(look)
        hidden = any(look(_hides, False) for look in self._looks.values())
        return any(
            self._report(finding, member)
            for member, look in self._looks.items()
            if member.WITHOUT_WRENCH or not hidden
            for finding in _findings(look)
        )

    def take_zero_jump(self) -> Floats | None:
        """Return by how much the zero has jumped since this was asked last, if it has, (6,)."""
        for look in self._with["take_zero_jump"]:
            jump = look(_take_zero_jump, None)
            if jump is not None:
                return jump
        return None

    def _report(self, finding: Finding, member: type[Suspect]) -> bool:
        """Report a finding once; return whether what fits is to be used from here on."""
        if finding in self._found:
            return False
        self._counts["setting_contradicted"] += 1
        self._found.append(finding)
        # Each once: a wrench that fits the one now and the other then has another fault. And a
        # tare that was taken by the wrong setting has no meaning by the right one.
        new = finding.found and not finding.found.keys() & self._adopted.keys()
        adopts = self._configuration.wrench.adopt_found and not self._counts["tare"]
        if not (member.ADOPTS and finding.alone and new and adopts):
            return False
        self._adopted |= finding.found
        self._counts["setting_adopted"] += 1
        return True


def _take(instant: Instant, unsure: bool, look: Suspect) -> None:
    look.take(instant, unsure)


def _take_zero_jump(look: Suspect) -> Floats | None:
    return look.take_zero_jump()


def _zero_open_ns(look: Suspect) -> int:
    return look.zero_open_ns


def _explains_joints(look: Suspect) -> bool:
    return look.explains_joints


def _joints_variance(look: Suspect) -> float:
    return look.joints_variance


def _hides(look: Suspect) -> bool:
    return look.hides


def _reaction_errors(look: Suspect) -> Floats | None:
    return look.reaction_errors


def _is_unsure(look: GuardedLook[Suspect]) -> bool:
    """Return whether a look doubts; of one that has failed that is dropped, but what it found."""
    found = look.look is not None and look.look.finding is not None
    return look(lambda it: it.unsure, found)


def _findings(look: GuardedLook[Suspect]) -> Sequence[Finding]:
    """Return what a look has found, whether it has failed since or not."""
    found = None if look.look is None else look.look.finding
    return look(lambda it: it.findings(), () if found is None else (found,))
