"""Links that are fixed to one another, and how they lie."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.measurements.rotations import rotation_from_rpy
from peg_on_hole_ros.robot.urdf_file import Joint


class Fixed(NamedTuple):
    """
    The highest link that another is fixed to, and the pose of that other in it.

    Attributes
    ----------
    link : str
    R : ndarray, shape (3, 3)
    p : ndarray, shape (3,)
        [m]

    """

    link: str
    R: np.ndarray
    p: np.ndarray


class Tree:
    """
    The links of a description, by the joints above them.

    Parameters
    ----------
    links : list of str
    joints : dict of str to Joint
        As of `urdf_file.parts`.

    """

    def __init__(self, links: list[str], joints: dict[str, Joint]) -> None:
        self.links = links
        self._above = {joint.child: joint for joint in joints.values()}

    def root_of(self, link: str) -> str:
        """Return the link at the top of those above a link."""
        seen = set()
        while link in self._above and link not in seen:
            seen.add(link)
            link = self._above[link].parent
        return link

    def fixed(self, link: str) -> Fixed:
        """Return the highest link that a link is fixed to."""
        R, p, seen = np.eye(3), np.zeros(3), {link}
        while link in self._above:
            joint = self._above[link]
            if joint.kind != "fixed" or joint.parent in seen:
                break
            turn = rotation_from_rpy(joint.rpy)
            R, p = turn @ R, np.array(joint.xyz) + turn @ p
            link = joint.parent
            seen.add(link)
        return Fixed(link, R, p)

    def fixed_below(self, root: str, tip: str) -> list[str]:
        """Return the links from the root on towards a tip, as far as they stand still."""
        way = [tip]
        while way[0] in self._above and len(way) <= len(self._above):
            way.insert(0, self._above[way[0]].parent)
        return [link for link in way if self.fixed(link).link == root]
