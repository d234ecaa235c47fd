"""Peg and hole in the tree of frames that the robot publishes: parents, and names it has."""

from typing import NamedTuple

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.measurements.edges import at_edges
from peg_on_hole_ros.robot.fixed_links import Tree
from peg_on_hole_ros.robot.urdf_file import parts
from peg_on_hole_ros.robot.urdf_source import awaited, description_of, named
from peg_on_hole_ros.safe_text import shown


class FrameTree(NamedTuple):
    """
    Which transforms are published, so that every frame has one parent.

    Attributes
    ----------
    base : str
        Parent of the hole's frame; empty: its place is not published.
    hole : str
        The hole's frame, parent of the peg's.
    peg : str
        The peg's frame; empty: its place is not published.
    xyz : tuple of 3 float
        Origin of the hole in the base [m].
    rpy : tuple of 3 float
        Axes of the hole in those of the base [rad].
    hole_line, peg_line : str
        Why a place is not published though it is stated; empty: it is, or is not stated.

    """

    base: str
    hole: str
    peg: str
    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float]
    hole_line: str = ""
    peg_line: str = ""


def frame_tree(configuration: Configuration) -> FrameTree:
    """
    Return the frames of peg and hole.

    The hole's place is known where `joints.hole_xyz` is stated, in the root link of the robot's
    description, or in a frame that `frames.base` names. A name that is a link of the robot has a
    parent already, whose publisher is the robot's. The frame of the hole is that of its throat, as
    in all messages.

    Raises
    ------
    PegOnHoleError
        The description cannot be read.

    """
    joints, frames = configuration.joints, configuration.frames
    throat = at_edges(joints, configuration.scene).hole_xyz
    nowhere = FrameTree("", frames.hole, "", throat, joints.hole_rpy)
    if awaited(joints):
        # Until it comes there is no estimate, and so no peg.
        return nowhere
    links, root = _links(joints)
    line = _why_not(configuration, links, root)
    known = not line and joints.is_placed
    taken = frames.peg in links
    return nowhere._replace(
        base=(frames.base or root) if known else "",
        peg="" if taken else frames.peg,
        hole_line=line,
        peg_line=_taken("peg", frames.peg, joints) if taken else "",
    )


def _why_not(configuration, links, root):
    """Return why the hole's place cannot be published; empty: it can, or is not stated."""
    joints, frames = configuration.joints, configuration.frames
    if not joints.is_placed:
        return (
            f"frames.base: the place of {shown(frames.hole)} in {shown(frames.base)} is not "
            "published, as joints.hole_xyz is not stated"
            if frames.base
            else ""
        )
    if frames.base not in ("", root) and frames.base in links:
        return (
            f"frames.base = {shown(frames.base)} is not the root link {shown(root)} of "
            f"{named(joints)}, in which joints.hole_xyz is: the place of {shown(frames.hole)} is "
            "not published; leave it empty"
        )
    return _taken("hole", frames.hole, joints) if frames.hole in links else ""


def _links(joints):
    """Return the links of the robot, and the one at the root; nothing without a robot."""
    if joints.source != "robot":
        return [], ""
    tree = Tree(*parts(description_of(joints), named(joints)))
    return tree.links, tree.root_of(joints.tip_frame)


def _taken(which, name, joints):
    return (
        f"frames.{which} = {shown(name)} is a link of {named(joints)}, whose place the robot "
        "publishes: a frame has one parent, so no other is published; give it another name"
    )
