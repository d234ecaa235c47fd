"""What a robot's description adds to the settings: where down is, and what axes a wrench has."""

from dataclasses import replace

from peg_on_hole_ros.config.options import BaseLink, Configuration, JointInput
from peg_on_hole_ros.config.parameter_table import GRAVITY_STATED
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy, rpy_of
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.robot.fixed_links import Tree
from peg_on_hole_ros.robot.sensor_frame import alike, is_stated
from peg_on_hole_ros.robot.urdf_file import parts
from peg_on_hole_ros.robot.urdf_source import awaited, description_of, named
from peg_on_hole_ros.safe_text import listed, shown

_DEFAULT = Scene().gravity


def described(configuration: Configuration) -> Configuration:
    """
    Return settings with what the robot's description says of them.

    Gravity, where it is not stated, pulls along -z of the root link or of `joints.gravity_link`.
    `wrench.axes` may be a link that stands still, or one that is fixed to the tip: the sensor's
    axes are those of it then. Settings without a robot stay, and so do those whose description
    has yet to come; what is described once may be described again.

    Raises
    ------
    PegOnHoleError
        The description cannot be read, has no such link, or contradicts what is stated.

    """
    joints = configuration.joints
    if joints.source != "robot" or awaited(joints):
        return configuration
    tree = Tree(*parts(description_of(joints), named(joints)))
    if joints.tip_frame not in tree.links:
        # An error, which the kinematics tell.
        return configuration
    return _with_axes(_with_gravity(configuration, tree), tree)


def with_description(configuration: Configuration, text: str) -> Configuration:
    """
    Return settings with a description that has come by the topic, and what it says of them.

    Raises
    ------
    PegOnHoleError
        It is empty, as the first of some launch files, or `described` refuses it.

    """
    if not text:
        raise PegOnHoleError(f"{named(configuration.joints)} is empty")
    joints = replace(configuration.joints, description=text)
    return described(replace(configuration, joints=joints))


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


def _with_axes(configuration, tree):
    wrench, joints = configuration.wrench, configuration.joints
    root, axes = tree.root_of(joints.tip_frame), wrench.axes
    base = "base" if "base" in tree.links and tree.fixed("base").link == root else root
    # What a driver may send: of tables and fixtures nobody does, unless it is stated.
    links = {"base": base, **{link: link for link in tree.fixed_below(root, joints.tip_frame)}}
    if axes != "sensor" and axes not in links:
        if axes not in tree.links:
            raise PegOnHoleError(
                f"wrench.axes = {shown(axes)} is neither sensor nor base, nor a link of "
                f"{named(joints)}; it has: {listed(tree.links)}"
            )
        fixed = tree.fixed(axes).link
        if fixed == tree.fixed(joints.tip_frame).link:
            return replace(configuration, wrench=_turned_sensor(wrench, joints, tree))
        if fixed != root:
            raise PegOnHoleError(
                f"wrench.axes = {shown(axes)} is a link that moves against the root link and "
                f"against {shown(joints.tip_frame)}: name one that is fixed to either"
            )
        links[axes] = axes
    base_links = tuple(BaseLink(name, _rpy(tree.fixed(link).R)) for name, link in links.items())
    return replace(configuration, wrench=replace(wrench, base_links=base_links))


def _turned_sensor(wrench, joints, tree):
    """Return a sensor with the axes of a link that the tip carries."""
    R_TP = rotation_from_rpy(joints.peg_rpy)
    R_0T, R_0A = tree.fixed(joints.tip_frame).R, tree.fixed(wrench.axes).R
    found = replace(wrench, sensor_rpy=_rpy((R_0T @ R_TP).T @ R_0A))
    if is_stated(wrench, "sensor_rpy") and not alike(wrench, found, "sensor_rpy"):
        raise PegOnHoleError(
            f"wrench.sensor_rpy = {list(wrench.sensor_rpy)} is not that of wrench.axes: "
            f"{shown(wrench.axes)}, which is {list(found.sensor_rpy)}; take one of them out"
        )
    return found


def _rpy(R):
    # Noise of the last digits would be told as part of it.
    roll, pitch, yaw = (round(angle, 9) + 0.0 for angle in rpy_of(R))
    return roll, pitch, yaw
