"""A dead component: one of the wrench keeps one value while others of its kind change."""

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import DEAD_COMPONENT_TEST
from peg_on_hole_ros.number_text import quantity
from peg_on_hole_ros.records import WRENCH_COMPONENTS


class DeadComponent(Suspect):
    """
    Looks for components that are 0, or one other value, whatever acts on the peg.

    More than a few components that stay are no finding: coarse rounding does that too, and so
    does a load that is calculated without noise.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "dead_component"
    FINDS = (
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
        self._rows = np.zeros((DEAD_COMPONENT_TEST.reported, 6))
        self._taken = 0
        # Those that are reported, with their values.
        self._dead: dict[int, float] = {}
        # Whether a component may be dead: what the wrench seems to mean then is no setting.
        self.hides = False
        self.finding: Finding | None = None

    @property
    def unsure(self) -> bool:
        """Whether what rests on contacts must be withheld now."""
        return self.hides

    def take(self, instant: Instant, unsure: bool) -> None:
        """Process a wrench, see the package."""
        sample = instant.sample
        now = (*sample.force, *sample.torque)
        self._rows[self._taken % DEAD_COMPONENT_TEST.reported] = now
        self._taken += 1
        # Once reported it is dead for as long as its value stays, however the others move.
        self._dead = {i: value for i, value in self._dead.items() if now[i] == value}
        self.hides = bool(self._dead) or bool(self._staying(DEAD_COMPONENT_TEST.suspected))
        if self.hides and not self._dead and (dead := self._staying(DEAD_COMPONENT_TEST.reported)):
            self._dead = {i: now[i] for i in dead}
            which = " and ".join(
                f"{WRENCH_COMPONENTS[i]} stays at {quantity(now[i], 'N' if i < 3 else 'N m')}"
                for i in dead
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
        places = np.arange(self._taken - count, self._taken) % DEAD_COMPONENT_TEST.reported
        latest = self._rows[places]
        stays = (latest == latest[0]).all(axis=0)
        found: list[int] = []
        if np.count_nonzero(stays) > DEAD_COMPONENT_TEST.most:
            return found
        for kind in (slice(0, 3), slice(3, 6)):
            if stays[kind].any() and self._alive(latest[:, kind], self._noise[kind.start]):
                found += [kind.start + i for i in np.flatnonzero(stays[kind]).tolist()]
        return found

    def _alive(self, values, noise):
        """Return whether a component of a kind changes, and by steps that do not hide noise."""
        for column in values.T:
            steps = np.diff(np.unique(column))
            alive = len(steps) + 1 >= DEAD_COMPONENT_TEST.alive * len(column)
            if alive and steps.min() < DEAD_COMPONENT_TEST.fine * noise:
                return True
        return False
