"""Coarse encoders: joint states whose values lie on a grid that is wider than their noise."""

from math import pi, sqrt

import numpy as np

from peg_on_hole_ros.diagnosis.encoder_step import encoder_steps
from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import COARSE_JOINTS_TEST
from peg_on_hole_ros.number_text import number


class CoarseJoints(Suspect):
    """
    Looks for values of a joint that all lie whole steps apart.

    A step q adds an error of variance q^2/12, which orientations are given as well.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "coarse_joints"
    FINDS = (
        (
            "`joint states come in steps of 0.00175 rad (0.1 degree)`, wider than "
            "`joints.position_stddev`, with the value that fits. Meanwhile each orientation has "
            "the variance of the step added, and `reactions_determined` is 0",
            "while the joints move, after 0.1 to 0.5 s",
        ),
    )
    LASTS = True
    OF_STAMPS = True
    WITHOUT_WRENCH = True

    def __init__(self, stated: Stated) -> None:
        self.finding: Finding | None = None
        self._step, self._looks = 0.0, 0
        self.restate(stated)
        self.restart()

    def restate(self, stated: Stated) -> None:
        """Take another noise."""
        joints = stated.configuration.joints
        self._stddev, self._names = joints.position_stddev, joints.names
        self._topic = stated.configuration.topics.joint_states
        if not self._is_wide(self._step):
            self.finding, self._step = None, 0.0

    def restart(self) -> None:
        """Forget the values so far; encoders stay what they are."""
        self._values = np.empty((0, len(self._names)))

    def _is_wide(self, step):
        return step > sqrt(12.0) * self._stddev

    @property
    def withholds(self) -> bool:
        """Whether values are too coarse for rates."""
        return self._step > 0.0

    @property
    def explains_joints(self) -> bool:
        """Whether steps are known: values that repeat, and noise, come of them."""
        return self._step > 0.0

    @property
    def joints_variance(self) -> float:
        """Times which the variance is the stated one."""
        return 1.0 + self._step * self._step / (12.0 * self._stddev * self._stddev)

    def take_joints(self, t_ns: np.ndarray, positions: np.ndarray) -> None:
        """Process joint states in the order in which they came, see the package."""
        self._values = np.concatenate([self._values, positions])[-COARSE_JOINTS_TEST.kept :]

    def take(self, instant: Instant, unsure: bool) -> None:
        """Look at the values that have come."""
        self._looks = (self._looks + 1) % COARSE_JOINTS_TEST.every
        if self._looks:
            return
        if len(self._values) < COARSE_JOINTS_TEST.fewest:
            return
        steps = encoder_steps(self._values)
        step = float(steps.max(initial=0.0))
        if self._is_wide(step) and step > self._step:
            name = self._names[int(np.argmax(steps))]
            self._step, self.finding = step, Finding(self._said(step, name), {}, "joints")

    def _said(self, step, name):
        fits = sqrt(self._stddev * self._stddev + step * step / 12.0)
        return (
            f"joint states come in steps of {number(step)} rad "
            f"({number(step * 180.0 / pi, 2)} degrees) on {self._topic}, at {name}, which is "
            "wider than joints.position_stddev: coarse encoders, or a driver that rounds: have "
            f"it send all digits, or state joints.position_stddev: {number(fits, 2)}. Until then "
            "the variance of a step is added to each orientation, and reactions are withheld"
        )
