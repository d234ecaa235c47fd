"""A dead component: one of the wrench keeps one value while others of its kind change."""

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Moment, Stated, Suspect

# Wrenches with one value, bit for bit, after which a component is suspected, before any other
# setting can be reported; and after which it is reported itself.
_SUSPECTED, _REPORTED = 10, 25
# Components that stay together at most, force and torque. Where more do, what comes is no sensor's
# reading: coarsely rounded, or calculated without noise.
_MOST = 2
# Distinct values of a component that is alive, over wrenches.
_ALIVE = 0.8
# Least distance of two of its values, over the stated noise: coarser steps are those of a rounding
# that may hide the noise of the others as well.
_FINE = 0.5
_NAMES = tuple(f"the {kind}'s {axis}" for kind in ("force", "torque") for axis in "xyz")


class DeadComponent(Suspect):
    """
    Looks for components that are 0, or one other value, whatever acts on the peg.

    More than _MOST components that stay are no finding: coarse rounding does that too, and so
    does a load that is calculated without noise.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "dead_component"
    TELLS = (
        (
            "`the force's x stays at 0 N while the others change`, or any other component: the "
            "driver does not fill it in. Meanwhile no other setting is reported or adopted, the "
            "mode is `unknown`, and `reactions_determined` is 0",
            "anywhere, after 0.3 s",
        ),
    )
    WITHOUT_WRENCH = True

    def __init__(self, stated: Stated) -> None:
        wrench = stated.configuration.wrench
        self._noise = np.array([wrench.force_stddev] * 3 + [wrench.torque_stddev] * 3)
        self.restart()

    def restart(self) -> None:
        """Forget all."""
        self._rows = np.zeros((_REPORTED, 6))
        self._taken = 0
        # Those that are reported, with their values.
        self._dead: dict[int, float] = {}
        # Whether a component may be dead: what the wrench seems to mean then is no setting.
        self.hides = False
        self.finding: Finding | None = None

    @property
    def unsure(self) -> bool:
        """Whether nothing sure of contacts can be published now."""
        return self.hides

    def take(self, moment: Moment, unsure: bool) -> None:
        """Take a wrench, see the package."""
        sample = moment.sample
        now = (*sample.force, *sample.torque)
        self._rows[self._taken % _REPORTED] = now
        self._taken += 1
        # Once reported it is dead for as long as its value stays, however the others move.
        self._dead = {i: value for i, value in self._dead.items() if now[i] == value}
        self.hides = bool(self._dead) or bool(self._staying(_SUSPECTED))
        if self.hides and not self._dead and (dead := self._staying(_REPORTED)):
            self._dead = {i: now[i] for i in dead}
            which = " and ".join(
                f"{_NAMES[i]} stays at {now[i]:.4g} {'N' if i < 3 else 'N m'}" for i in dead
            )
            self.finding = Finding(
                f"{which} while the others change: the sensor or its driver does not fill it in; "
                "the estimate needs all six, so put the driver right",
                {},
                voids=True,
            )

    def _staying(self, count):
        """Return which components have kept one value over so many wrenches."""
        if self._taken < count:
            return []
        latest = self._rows[np.arange(self._taken - count, self._taken) % _REPORTED]
        stays = (latest == latest[0]).all(axis=0)
        found: list[int] = []
        if np.count_nonzero(stays) > _MOST:
            return found
        for kind in (slice(0, 3), slice(3, 6)):
            if stays[kind].any() and self._alive(latest[:, kind], self._noise[kind.start]):
                found += [kind.start + i for i in np.flatnonzero(stays[kind]).tolist()]
        return found

    def _alive(self, values, noise):
        """Return whether a component of a kind changes, and by steps that do not hide noise."""
        for column in values.T:
            steps = np.diff(np.unique(column))
            if len(steps) + 1 >= _ALIVE * len(column) and steps.min() < _FINE * noise:
                return True
        return False
