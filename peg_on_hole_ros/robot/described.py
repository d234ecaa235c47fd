"""What a robot's description adds to the settings: where down is."""

from dataclasses import replace

from peg_on_hole_ros.config.options import Configuration, JointInput
from peg_on_hole_ros.config.parameter_table import GRAVITY_STATED
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.measurements.measurement import rotation_from_rpy
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.robot.fixed_links import Tree
from peg_on_hole_ros.robot.urdf_file import parts
from peg_on_hole_ros.robot.urdf_source import awaited, description_of, named
from peg_on_hole_ros.safe_text import listed, shown

_DEFAULT = Scene().gravity


def described(configuration: Configuration) -> Configuration:
    """
    Return settings with what the robot's description says of them.

    Gravity, where it is not stated, pulls along -z of the root link or of `joints.gravity_link`.
    Settings without a robot stay, and so do those whose description has yet to come; what is
    described once may be described again.

    Raises
    ------
    PegOnHoleError
        The description cannot be read, or has no such link.

    """
    joints = configuration.joints
    if joints.source != "robot" or awaited(joints):
        return configuration
    tree = Tree(*parts(description_of(joints), named(joints)))
    if joints.tip_frame not in tree.links:
        # An error, which the kinematics tell.
        return configuration
    return _with_gravity(configuration, tree)


def _with_gravity(configuration, tree):
    scene, joints = configuration.scene, configuration.joints
    stated = scene.gravity not in (_DEFAULT, joints.robot_gravity)
    if joints.gravity_link == GRAVITY_STATED:
        scene = scene if stated else replace(scene, gravity=_DEFAULT)
        joints = replace(joints, robot_gravity=None)
    else:
        joints = replace(joints, robot_gravity=_gravity(joints, tree))
        scene = scene if stated else replace(scene, gravity=joints.robot_gravity)
    return replace(configuration, scene=scene, joints=joints)


def _gravity(joints: JointInput, tree: Tree) -> tuple[float, float, float]:
    """Return gravity in hole axes [m/s^2]."""
    root = tree.root_of(joints.tip_frame)
    link = joints.gravity_link or root
    if link not in tree.links:
        raise PegOnHoleError(
            f"joints.gravity_link = {shown(link)} is no link of {named(joints)}; it has: "
            f"{listed(tree.links)}"
        )
    fixed = tree.fixed(link)
    if fixed.link != root:
        raise PegOnHoleError(
            f"joints.gravity_link = {shown(link)} moves against the root link {shown(root)}, so "
            "that gravity has no direction in it; name one that stands still, or leave it empty"
        )
    gravity_R = fixed.R @ _DEFAULT
    turned = rotation_from_rpy(joints.hole_rpy).T @ gravity_R
    x, y, z = (float(component) + 0.0 for component in turned)
    return x, y, z
