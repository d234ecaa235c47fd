"""Two publishers of joint states on one topic, whose positions differ."""

import numpy as np

from peg_on_hole_ros.diagnosis.encoder_step import encoder_steps
from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import ENCODER_STEP, TWIN_JOINTS_TEST
from peg_on_hole_ros.number_text import number


class TwinJoints(Suspect):
    """
    Looks for joint states that take turns between two motions.

    Within a short time a motion is a parabola. Two of them, apart by one offset, explain messages
    that take turns; of noise and of a vibration they explain little more than one does.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "twin_joints"
    FINDS = (
        (
            "`two publish on /joint_states`, with how far apart their joints are: a driver and a "
            "joint_state_publisher, targets beside measured positions, or one that publishes late "
            "what another has sent. Meanwhile the mode is `unknown`, and `reactions_determined` "
            "is 0",
            "anywhere, after some 60 joint states",
        ),
    )
    LASTS = True
    OF_STAMPS = True
    WITHOUT_WRENCH = True

    def __init__(self, stated: Stated) -> None:
        self._topic = stated.configuration.topics.joint_states
        self._names = stated.configuration.joints.names
        self.finding: Finding | None = None
        self._step, self._looks = 0.0, 0
        self.restart()

    def restart(self) -> None:
        """Forget the joint states so far."""
        self._t_ns, self._values = np.empty(0, np.int64), np.empty((0, len(self._names)))
        self._take_turns = False

    @property
    def unsure(self) -> bool:
        """Whether the latest joint states take turns."""
        return self._take_turns

    @property
    def hides(self) -> bool:  # type: ignore[override]
        """Whether what others make of the joint states is no setting."""
        return self._take_turns

    @property
    def explains_joints(self) -> bool:
        """Whether what looks like noise is two motions."""
        return self.finding is not None

    def take_joints(self, t_ns: np.ndarray, positions: np.ndarray) -> None:
        """Process joint states in the order in which they came, see the package."""
        kept = TWIN_JOINTS_TEST.kept_steps
        self._t_ns = np.concatenate([self._t_ns, t_ns])[-kept:]
        self._values = np.concatenate([self._values, positions])[-kept:]

    def take(self, instant: Instant, unsure: bool) -> None:
        """Look at the joint states that have come."""
        kept = TWIN_JOINTS_TEST.kept
        self._looks = (self._looks + 1) % TWIN_JOINTS_TEST.every
        if self._looks or len(self._t_ns) < kept:
            return
        apart = motions_apart(self._t_ns[-kept:], self._values[-kept:])
        if apart > 0.0:
            # A joint that toggles between two steps of an encoder is one motion.
            self._step = max(self._step, float(encoder_steps(self._values).max(initial=0.0)))
        self._take_turns = apart > TWIN_JOINTS_TEST.grid * self._step
        if self._take_turns and self.finding is None:
            self.finding = Finding(self._said(apart), {}, "joints")

    def _said(self, apart):
        return (
            f"two publish on {self._topic}: joint states take turns between two motions, "
            f"{number(apart, 2)} rad apart, as of a driver and a joint_state_publisher, of "
            "measured positions and targets, or of one that is late: `ros2 topic info -v` lists "
            "who publishes; end one, or have topics.joint_states name the driver's own topic. "
            "Meanwhile the contact mode is unknown"
        )


def motions_apart(t_ns: np.ndarray, values: np.ndarray) -> float:
    """Return how far apart the joints of two motions are, at most [rad]; 0: it is one motion."""
    t = (t_ns - t_ns[0]) * 1e-9
    if not np.isfinite(values).all() or not np.ptp(t) > 0.0:
        return 0.0
    motion = np.vander((t - t.mean()) / np.ptp(t), 3)
    left = values - motion @ np.linalg.lstsq(motion, values, rcond=None)[0]
    along = np.linalg.svd(left, full_matrices=False)[2][0]
    second = left @ along > 0.0
    for _ in range(TWIN_JOINTS_TEST.rounds):
        if min(second.sum(), len(t) - second.sum()) < TWIN_JOINTS_TEST.fewest:
            return 0.0
        columns = np.column_stack([motion, second])
        found = np.linalg.lstsq(columns, values, rcond=None)[0]
        offset = found[-1]
        size = float(np.linalg.norm(offset))
        if not size > 0.0:
            return 0.0
        beside = (values - motion @ found[:-1]) @ offset / size
        second = beside > 0.5 * size
    turns = np.count_nonzero(np.diff(second.astype(np.int8)))
    within = float(np.sqrt(np.mean((beside - size * second) ** 2)))
    taken = turns >= TWIN_JOINTS_TEST.turns and size > TWIN_JOINTS_TEST.clear * within
    widest = int(np.abs(offset).argmax())
    apart = float(abs(offset[widest]))
    # Values that repeat are those of an encoder between two steps.
    taken = taken and len(np.unique(values[:, widest])) > ENCODER_STEP.distinct * len(t)
    return apart if taken else 0.0
