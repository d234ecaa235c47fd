"""From where peg and hole are stated to the edges that carry: shoulder and throat."""

from dataclasses import replace

import numpy as np

from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy
from peg_on_hole_ros.mechanics.scene import Scene


def at_edges(joints: JointInput, scene: Scene) -> JointInput:
    """
    Return where the peg frame is in the tip frame, and the hole frame in the root link.

    A peg is stated by its outermost end, which can be touched: the shank begins the height of its
    chamfer above. A hole is stated on its outer face: the bore begins the height of its chamfer
    below. Without chamfers both are where they are stated.
    """
    if scene.peg_chamfer:
        shoulder = np.array(joints.peg_xyz)
        shoulder += scene.peg_chamfer * rotation_from_rpy(joints.peg_rpy)[:, 2]
        joints = replace(joints, peg_xyz=tuple(shoulder.tolist()))
    if scene.hole_chamfer and joints.is_placed:
        throat = np.array(joints.hole_xyz)
        throat -= scene.hole_chamfer * rotation_from_rpy(joints.hole_rpy)[:, 2]
        joints = replace(joints, hole_xyz=tuple(throat.tolist()))
    return joints
