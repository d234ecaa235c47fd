"""A larger unit: the noise of the wrench is that of a driver which sends kN or kN m."""

from math import sqrt

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import LARGER_UNIT_TEST
from peg_on_hole_ros.number_text import quantity

# Median of the length of a step of three components of unit noise: sqrt(2 * 2.37).
_STEP = sqrt(4.73)
_PARTS = {"force": ("N", slice(0, 3)), "torque": ("N m", slice(3, 6))}


class LargerUnit(Suspect):
    """
    Compares the noise of force and torque with what is stated, from the first wrenches on.

    Axes, sign and weight of a wrench that is a thousand times too small all look wrong as well:
    meanwhile no other setting of it is reported.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "larger_unit"
    FINDS = (
        (
            "force in kN, torque in kN m, by their noise; or noise that is stated far wrong: no "
            "other setting of the wrench is reported then",
            "anywhere, after 100 wrenches",
        ),
    )
    WITHOUT_WRENCH = True
    LASTS = True

    def __init__(self, stated: Stated) -> None:
        wrench = stated.configuration.wrench
        self._stated = {"force": wrench.force_stddev, "torque": wrench.torque_stddev}
        self._steps: list[np.ndarray] = []
        self._count = 0
        self._last: np.ndarray | None = None
        self._small: dict[str, float] = {}
        self._found: tuple[Finding, ...] = ()
        self.hides = False

    def findings(self) -> tuple[Finding, ...]:
        """Return a finding for force and for torque."""
        return self._found

    def take_every_wrench(self, t_ns: np.ndarray, wrenches: np.ndarray) -> None:
        """Process the first wrenches, see the package."""
        if self._count >= LARGER_UNIT_TEST.enough or not len(t_ns):
            return
        rows = wrenches if self._last is None else np.vstack([self._last, wrenches])
        self._last = wrenches[-1].copy()
        self._steps.append(np.diff(rows, axis=0))
        self._count += len(rows) - 1

    def take(self, instant: Instant, unsure: bool) -> None:
        """Judge by the wrenches so far, see the package."""
        if self._found or not self._steps:
            return
        done = self._count >= LARGER_UNIT_TEST.enough
        if self._count >= LARGER_UNIT_TEST.fewest:
            steps = np.concatenate(self._steps)
            self._small = {}
            for name, (_, part) in _PARTS.items():
                noise = float(np.median(np.linalg.norm(steps[:, part], axis=1))) / _STEP
                if 0.0 < noise * LARGER_UNIT_TEST.times < self._stated[name]:
                    self._small[name] = noise
            # What the wrench seems to mean then is no setting.
            self.hides = bool(self._small)
        if done:
            self._steps = []
            self._found = tuple(self._said(name, noise) for name, noise in self._small.items())

    def _said(self, name, noise):
        unit, stated = _PARTS[name][0], self._stated[name]
        units = (f"unit of the {each} read as k{_PARTS[each][0]}" for each in self._small)
        return Finding(
            f"the wrench seems to come in k{unit}: the driver has to send N and N m; with "
            f"{' and '.join(units)} the noise is as stated. Now the noise of the {name} is "
            f"{quantity(noise, unit, 2)}, {stated / noise:.0f} times less than "
            f"wrench.{name}_stddev = {quantity(stated, unit)}, and reactions mean nothing; noise "
            "that is stated far wrong looks the same",
            {},
            voids=True,
        )
