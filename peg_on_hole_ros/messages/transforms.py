"""The peg in the hole as a transform for /tf, at a rate that displays need."""

from collections.abc import Callable

from peg_on_hole_ros.messages.plain import HOLE_FRAME

TRANSFORMS = "tf2_msgs/msg/TFMessage"
TRANSFORM_TOPIC = "/tf"
PEG_FRAME = "peg"
# Between two of them [ns].
TRANSFORM_PERIOD_NS = 20_000_000


class Transforms:
    """Makes of poses, as `~/pose` has them, transforms hole -> peg; time is that of the stamps."""

    def __init__(self) -> None:
        self._last_ns: int | None = None

    def message(self, t_ns: int, pose_of: Callable[[], dict]) -> dict | None:
        """
        Return tf2_msgs/TFMessage, or None where none is due.

        Parameters
        ----------
        t_ns : int
            Stamp [ns].
        pose_of : callable
            Returns its PoseWithCovarianceStamped, or header and pose of that.

        """
        last_ns = self._last_ns
        # Stamps may jump back: a bag played again, a simulator started again.
        if last_ns is not None and last_ns <= t_ns < last_ns + TRANSFORM_PERIOD_NS:
            return None
        self._last_ns = t_ns
        pose = pose_of()
        there = pose["pose"]["pose"]
        transform = {
            "header": {"stamp": pose["header"]["stamp"], "frame_id": HOLE_FRAME},
            "child_frame_id": PEG_FRAME,
            "transform": {"translation": there["position"], "rotation": there["orientation"]},
        }
        return {"transforms": [transform]}
