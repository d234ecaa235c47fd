"""Where the sensor sits on the peg, by the link of the URDF that the wrench's frame_id names."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.measurements.edges import at_edges
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy, rpy_of
from peg_on_hole_ros.robot.fixed_links import Tree
from peg_on_hole_ros.robot.urdf_file import parts
from peg_on_hole_ros.robot.urdf_source import awaited, description_of, named
from peg_on_hole_ros.safe_text import printable, shown

# By so much a stated pose may differ from that of the URDF [m], [rad].
NEAR_POSITION, NEAR_ANGLE = 1e-3, 0.01
_DEFAULT_INPUT = WrenchInput()


class Mounting(NamedTuple):
    """
    Where the sensor is taken to sit.

    Attributes
    ----------
    wrench : WrenchInput
        With the pose that is used.
    line : str
        What there is to say of it; empty: nothing.

    """

    wrench: WrenchInput
    line: str


def mounting(configuration: Configuration, frame: str) -> Mounting:
    """
    Return where the sensor of a wrench with a frame_id sits.

    Parameters
    ----------
    configuration : Configuration
    frame : str
        frame_id of the wrench.

    Raises
    ------
    PegOnHoleError
        What is stated contradicts the URDF, or the URDF cannot be used.

    """
    wrench, joints = configuration.wrench, configuration.joints
    if joints.source != "robot" or wrench.sensor_pose == "stated" or awaited(joints):
        return Mounting(wrench, "")
    stated = [name for name in ("sensor_xyz", "sensor_rpy") if is_stated(wrench, name)]
    by_link = wrench.axes != "sensor" and wrench.base_rpy is None
    pose = _on_peg(at_edges(joints, configuration.scene), frame)
    if isinstance(pose, str):
        told = f"{pose}; the sensor is taken to sit at {_mounting_text(wrench)}"
        return Mounting(wrench, "" if stated or not pose else told)
    # Where the axes are those of a link that is named, frame_id has the sensor's place alone.
    found = replace(
        wrench, sensor_xyz=pose[0], sensor_rpy=wrench.sensor_rpy if by_link else pose[1]
    )
    off = [name for name in stated if not alike(wrench, found, name)]
    if off:
        given = " and ".join(f"wrench.{name} = {list(getattr(wrench, name))}" for name in off)
        raise PegOnHoleError(
            f"{given} is not where {named(joints)} has {shown(frame)}, the frame_id of the "
            f"wrench: {_mounting_text(found)}; take it out, or state wrench.sensor_pose: stated"
        )
    used = replace(found, **{name: getattr(wrench, name) for name in stated})
    return Mounting(
        used, "" if used == wrench else f"sensor: at {shown(frame)}, {_mounting_text(found)}"
    )


def is_stated(wrench: WrenchInput, name: str) -> bool:
    """Return whether a setting is another than the default."""
    return getattr(wrench, name) != getattr(_DEFAULT_INPUT, name)


def _mounting_text(wrench):
    xyz, rpy = (
        ", ".join(f"{x:.6g}" for x in values) for values in (wrench.sensor_xyz, wrench.sensor_rpy)
    )
    return f"wrench.sensor_xyz: [{xyz}], sensor_rpy: [{rpy}]"


def alike(stated: WrenchInput, found: WrenchInput, name: str) -> bool:
    """Return whether two sensors agree in `sensor_xyz` or `sensor_rpy`."""
    if name == "sensor_xyz":
        return bool(
            np.linalg.norm(np.subtract(stated.sensor_xyz, found.sensor_xyz)) <= NEAR_POSITION
        )
    turn = rotation_from_rpy(stated.sensor_rpy).T @ rotation_from_rpy(found.sensor_rpy)
    return bool(np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0)) <= NEAR_ANGLE)


def _on_peg(joints: JointInput, frame: str):
    """Return xyz and rpy of a link in the peg frame, or in words why it has none."""
    tree = Tree(*parts(description_of(joints), named(joints)))
    if joints.tip_frame not in tree.links:
        # An error, which the kinematics tell.
        return ""
    if frame not in tree.links:
        return f"frame_id {shown(frame)} of the wrench is no link of {named(joints)}"
    tip_root, R_0T, p_0T = tree.fixed(joints.tip_frame)
    root, R_0S, p_0S = tree.fixed(frame)
    if root != tip_root:
        axes = frame if root == tree.root_of(joints.tip_frame) else "base"
        return (
            f"frame_id {shown(frame)} of the wrench is a link that {joints.tip_frame} moves "
            f"against: numbers in its axes need wrench.axes: {printable(axes)}"
        )
    R_0P = R_0T @ rotation_from_rpy(joints.peg_rpy)
    p_0P = p_0T + R_0T @ np.array(joints.peg_xyz)
    xyz, rpy = R_0P.T @ (p_0S - p_0P), rpy_of(R_0P.T @ R_0S)
    # Noise of the last digits would be told as part of the pose.
    return tuple(tuple(round(float(x), 9) + 0.0 for x in values) for values in (xyz, rpy))
