"""Peg and hole as transforms: the peg at a rate that displays need, the hole once for all."""

from collections.abc import Callable

from peg_on_hole_ros.measurements.wrench_reduction import rotation_from_rpy
from peg_on_hole_ros.messages.beside_estimates import Message
from peg_on_hole_ros.messages.plain import HOLE_FRAME, header, quaternion, xyz
from peg_on_hole_ros.robot.frame_tree import FrameTree

TRANSFORMS = "tf2_msgs/msg/TFMessage"
TRANSFORM_TOPIC = "/tf"
# Kept for late subscribers.
STATIC_TRANSFORM_TOPIC = "/tf_static"
PEG_FRAME = "peg"
# Between two of them [ns].
TRANSFORM_PERIOD_NS = 20_000_000


def static_transform(tree: FrameTree, t_ns: int) -> Message | None:
    """
    Return the message base -> hole; None where the place of the hole is not known.

    Parameters
    ----------
    tree : FrameTree
    t_ns : int
        Stamp [ns]; it holds for all times.

    """
    if not tree.base:
        return None
    there = {
        "translation": xyz(tree.xyz),
        "rotation": quaternion(rotation_from_rpy(tree.rpy)),
    }
    message = _transforms(header(t_ns, tree.base), tree.hole, there)
    return STATIC_TRANSFORM_TOPIC, TRANSFORMS, message


def _transforms(head, child, transform):
    return {
        "transforms": [{"header": head, "child_frame_id": child, "transform": transform}],
    }


class Transforms:
    """
    Makes of poses, as `~/pose` has them, transforms hole -> peg; time is that of the stamps.

    Parameters
    ----------
    hole, peg : str
        Their frames.

    """

    def __init__(self, hole: str = HOLE_FRAME, peg: str = PEG_FRAME) -> None:
        self._hole, self._peg = hole, peg
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
        transform = {"translation": there["position"], "rotation": there["orientation"]}
        head = {"stamp": pose["header"]["stamp"], "frame_id": self._hole}
        return _transforms(head, self._peg, transform)
