"""
Samples out of serialised messages that look like one that was read before.

A driver's messages differ in stamp and numbers alone. So a message of the layout of an earlier
one, which ROS has read, needs no reading of its texts.
"""

from peg_on_hole_ros.messages.cdr_layout import ENCAPSULATION, MessageLayout
from peg_on_hole_ros.messages.decode import (
    JOINTS_TYPE,
    WRENCH_TYPE,
    Malformed,
    checked_joints,
    checked_wrench,
)
from peg_on_hole_ros.records import JointSample, WrenchSample


class _LearntReader:
    """The layout of a message that ROS has read; None: it has none."""

    ros_type = ""

    def __init__(self) -> None:
        self._layout: MessageLayout | None = None

    def _learn(self, payload):
        try:
            self._layout = MessageLayout(self.ros_type, payload)
        except ValueError:
            self._layout = None

    def _read(self, payload):
        # Where the last two bytes are others, they say how much of the end is padding.
        if self._layout is None or payload[: len(ENCAPSULATION)] != ENCAPSULATION:
            return None
        return self._layout.read_one(payload)


class WrenchReader(_LearntReader):
    """Reads serialised geometry_msgs/WrenchStamped like one that was learnt."""

    ros_type = WRENCH_TYPE

    def learn(self, payload: bytes) -> None:
        """Take a message that ROS has read."""
        self._learn(payload)

    def read(self, payload: bytes) -> WrenchSample | Malformed | None:
        """Return the sample, as `wrench_sample` does; None: it has to be read as any other."""
        found = self._read(payload)
        if found is None:
            return None
        t_ns, numbers = found
        return checked_wrench(WrenchSample(t_ns, tuple(numbers[:3]), tuple(numbers[3:])))


class JointsReader(_LearntReader):
    """
    Reads serialised sensor_msgs/JointState like one that was learnt.

    Parameters
    ----------
    needed : tuple of str
        See `joint_sample`.

    """

    ros_type = JOINTS_TYPE

    def __init__(self, needed: tuple[str, ...]) -> None:
        super().__init__()
        self._needed = needed

    def learn(self, payload: bytes, names: tuple[str, ...]) -> None:
        """Take a message that ROS has read, and the names in it."""
        self._names = names
        self._learn(payload)

    def read(self, payload: bytes) -> JointSample | Malformed | None:
        """Return the sample, as `joint_sample` does; None: it has to be read as any other."""
        found = self._read(payload)
        if found is None:
            return None
        t_ns, numbers = found
        sample = JointSample(t_ns, self._names, tuple(numbers[: len(self._names)]))
        return checked_joints(sample, self._needed)
