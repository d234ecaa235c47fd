"""A wrench that stands still: of an emergency stop, a reconnect, or a sensor that warms up."""

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import STANDING_WRENCH_TEST


class StandingWrench(Suspect):
    """
    Reports values that repeat bit for bit and are no measurements, see `wrench_noise.repeated`.

    Zeros and what stays while the peg turns are reported soon; another value at rest is true for
    a moment.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "standing_wrench"
    FINDS = (
        (
            "`wrenches that do not change`: the sensor or its driver stands still, as in an "
            "emergency stop, a reconnect or a start. Meanwhile nothing is estimated, no other "
            "setting is reported or adopted, the mode is `unknown`, and `reactions_determined` "
            "is 0",
            "six zeros where a weight hangs at the sensor, after 0.15 s; one value of a sensor "
            "with noise after 0.5 s, and while the peg turns after 0.05 s",
        ),
    )
    WITHOUT_WRENCH = True
    LASTS = True

    def __init__(self, stated: Stated) -> None:
        self.finding: Finding | None = None
        self._begun_ns: int | None = None

    def take_every_wrench(self, t_ns: np.ndarray, wrenches: np.ndarray) -> None:
        """Note the first stamp."""
        if self._begun_ns is None and len(t_ns):
            self._begun_ns = int(t_ns[0])

    def take(self, instant: Instant, unsure: bool) -> None:
        """Process a wrench, see the package."""
        standing = instant.standing
        self.hides = standing is not None
        if standing is None or self.finding is not None:
            return
        lasts_ns = instant.sample.t_ns - standing.since_ns
        numbers = STANDING_WRENCH_TEST
        after_ns = numbers.zeros_ns if standing.zeros else numbers.held_ns
        if not standing.turned and lasts_ns < after_ns:
            return
        begun_ns = standing.since_ns if self._begun_ns is None else self._begun_ns
        zeros = ", all six components zero" if standing.zeros else ""
        turns = " while the peg turns" if standing.turned else ""
        self.finding = Finding(
            f"wrenches that do not change for {lasts_ns * 1e-9:.2f} s and more{turns}, from "
            f"{(standing.since_ns - begun_ns) * 1e-9:.3f} s on{zeros}: wrenches stand still, as "
            "in an emergency stop, a reconnect or a start of the sensor or its driver; they are "
            "not used, and no setting is tested by them",
            {},
        )
