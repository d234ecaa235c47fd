"""A peg that lies across its hole: its axis, or that of the hole, is another than stated."""

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding, listed
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import LIES_ACROSS_TEST
from peg_on_hole_ros.measurements.rotations import quarter_turns, rotation_from_rpy, rpy_of
from peg_on_hole_ros.mechanics.reference import peg_axes


class LiesAcross(Suspect):
    """
    Looks for a peg whose lower end is at the hole while it lies across.

    None is set on a hole like that. Meanwhile no setting of the wrench is reported: of a peg that
    lies elsewhere than it is taken to, the weight alone looks wrong.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "lies_across"
    FINDS = (
        (
            "`joints.peg_rpy` by a quarter turn: the peg lies across the hole, and with another "
            "value it would stand on it",
            "half a second near the hole, with `joints.source: robot`",
        ),
    )
    WITHOUT_WRENCH = True

    def __init__(self, stated: Stated) -> None:
        configuration = stated.configuration
        self._near = LIES_ACROSS_TEST.near * configuration.scene.peg_height
        self._robot = configuration.joints.source == "robot"
        self._peg_rpy = configuration.joints.peg_rpy
        self.restart()

    def restart(self) -> None:
        """Forget all."""
        self._across = 0
        self.hides = False
        self.finding: Finding | None = None

    def take(self, instant: Instant, unsure: bool) -> None:
        """Process an orientation, see the package."""
        measured = instant.measured
        self.hides = bool(measured.q[0] > LIES_ACROSS_TEST.tilt)
        place = measured.position
        at_hole = self._robot and place is not None and np.linalg.norm(place) < self._near
        self._across = self._across + 1 if self.hides and at_hole else 0
        if self._across >= LIES_ACROSS_TEST.looks and self.finding is None:
            self.finding = self._said(measured.q)

    def _said(self, q):
        axes = peg_axes(q)
        best = max(quarter_turns(), key=lambda turn: float(axes[2] @ turn[:, 2]))
        stands = float(np.degrees(np.arccos(np.clip(axes[2] @ best[:, 2], -1.0, 1.0))))
        rpy = listed(rpy_of(rotation_from_rpy(self._peg_rpy) @ best), 4)
        return Finding(
            f"the peg lies across the hole, by {np.degrees(q[0]):.0f} degrees: set "
            f"joints.peg_rpy: {rpy}, with which it leans by {stands:.0f} degrees. Its z has to "
            "point up the peg's axis, away from its lower end; a wrong joints.hole_rpy looks "
            "the same",
            {},
            "joints",
            voids=True,
        )
