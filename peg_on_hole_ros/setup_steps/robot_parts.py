"""What a robot's description offers: links that may carry the peg, and joints that move them."""

from typing import NamedTuple

from peg_on_hole_ros.robot.fixed_links import Tree
from peg_on_hole_ros.robot.urdf_file import MOVING, Joint, parts


class RobotParts(NamedTuple):
    """
    The tree of a description.

    Attributes
    ----------
    links : list of str
    joints : dict of str to Joint

    """

    links: list[str]
    joints: dict[str, Joint]

    @classmethod
    def of(cls, text: str, path: str) -> "RobotParts":
        """
        Return those of a description that is to be found at a path.

        Raises
        ------
        PegOnHoleError
            It is no URDF.

        """
        return cls(*parts(text, path))

    def way(self, link: str) -> list[Joint]:
        """Return the joints from the root link to a link."""
        above = {joint.child: joint for joint in self.joints.values()}
        found: list[Joint] = []
        while link in above and len(found) <= len(self.joints):
            found.insert(0, above[link])
            link = above[link].parent
        return found

    def root(self, link: str) -> str:
        """Return the link at the top of those above a link."""
        return Tree(self.links, self.joints).root_of(link)

    def names(self, link: str) -> tuple[str, ...]:
        """Return the joints that have to be read for the pose of a link: those that lead."""
        found: dict[str, None] = {}
        for joint in self.way(link):
            while joint.leader and joint.leader in self.joints and joint.leader != joint.name:
                joint = self.joints[joint.leader]
            if joint.kind in MOVING:
                found[joint.name] = None
        return tuple(found)

    def likely_tip(self) -> str:
        """Return the link at the end that most joints move, of these the last in the file."""
        above = {joint.parent for joint in self.joints.values()}
        ends = [link for link in self.links if link not in above] or self.links
        return max(ends, key=lambda link: (len(self.names(link)), self.links.index(link)))

    def lines(self, tip: str) -> list[str]:
        """Return the way from the root link to a tip, and the other links, as text."""
        way = self.way(tip)
        steps = "".join(f" -{joint.name} ({joint.kind})-> {joint.child}" for joint in way)
        passed = {joint.child for joint in way} | {self.root(tip)}
        others = [link for link in self.links if link not in passed]
        lines = [f"{self.root(tip)}{steps}"]
        return [*lines, f"other links: {', '.join(others)}"] if others else lines
