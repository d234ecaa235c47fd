"""A robot's description as a chain of joints up to the frame that carries the peg, checked."""

import difflib
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from math import hypot, inf, isfinite
from typing import NamedTuple

from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.robot.urdf_source import MOST_URDF_BYTES, description_of, named
from peg_on_hole_ros.safe_text import listed, shown

MOVING = ("revolute", "continuous", "prismatic")
# Of a coordinate [m] or an angle [rad]: squares of much larger ones are no doubles.
_LARGEST = 1e6
# Of an axis: squares of much smaller ones are zero, and it would have no direction.
_LEAST_AXIS = 1e-6
# Pinocchio descends the tree by recursion: it overflows a stack of 8 MB between 2000 and 4000
# links below each other, and there are smaller stacks.
MOST_DEPTH = 200
MOST_LINKS = 1000
# Pinocchio reserves 63 bytes times the third power of the degrees of freedom: 130 MB of these.
MOST_FREEDOMS = 128
# Degrees of freedom of a joint by its kind; of every other kind one at most.
_FREEDOMS = {"fixed": 0, "planar": 3, "floating": 6}
# Of XML elements: in all, and within each other, as far as Pinocchio's parser follows.
_MOST_ELEMENTS, _MOST_NESTED = 100_000, 100


class Joint(NamedTuple):
    """
    One joint of the description.

    Attributes
    ----------
    name, kind, parent, child : str
        The kind as in the file: `revolute`, `continuous`, `prismatic`, `fixed`, ...
    lower, upper : float
        Limits of a revolute joint [rad]; infinite for the other kinds.
    leader : str
        Joint that this one follows (`mimic`); empty: none.
    multiplier, offset : float
        Position = multiplier * leader's position + offset.
    xyz, rpy : tuple of 3 float
        Of the child in the parent at position 0 [m], [rad].

    """

    name: str
    kind: str
    parent: str
    child: str
    lower: float
    upper: float
    leader: str
    multiplier: float
    offset: float
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Chain(NamedTuple):
    """
    What moves the tip, and how it depends on the joints that are read.

    Attributes
    ----------
    text : str
        The description.
    moving : tuple of str
        Joints between the root link and the tip that move, mimicking ones too.
    source : tuple of int
        For each of them the place in `joints.names` of the joint that moves it.
    multiplier, offset : tuple of float
        Position = multiplier * position that was read + offset.
    lower, upper : tuple of float
        Limits of each joint in `joints.names` [rad]; infinite where there are none.

    """

    text: str
    moving: tuple[str, ...]
    source: tuple[int, ...]
    multiplier: tuple[float, ...]
    offset: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]


def read_chain(options: JointInput) -> Chain:
    """
    Read joints.urdf up to joints.tip_frame and match it with joints.names.

    Raises
    ------
    PegOnHoleError
        No such file, no URDF, no such frame or joint, a joint of a kind that one position does
        not determine, or names that leave a joint out or have one too many.

    """
    path, text = named(options), description_of(options)
    links, joints = parts(text, path)
    if options.tip_frame not in links:
        raise PegOnHoleError(
            f"joints.tip_frame = {shown(options.tip_frame)} is no link of {path}; "
            f"{_nearest(options.tip_frame, links)}"
        )
    moving = [joint for joint in _way(options.tip_frame, joints, path) if joint.kind != "fixed"]
    for joint in moving:
        if joint.kind not in MOVING:
            raise PegOnHoleError(
                f"{path}: joint {shown(joint.name)} is {joint.kind}; between the root link and "
                f"{options.tip_frame} only {', '.join(MOVING)} and fixed joints can be read"
            )
    led = {joint.name: _leader(joint, joints, path) for joint in moving}
    leaders = list(dict.fromkeys(leader for leader, _, _ in led.values()))
    _check_names(options, joints, leaders, path)
    if not any(joint.kind != "prismatic" for joint in moving):
        raise PegOnHoleError(
            f"{path}: no joint between the root link and {options.tip_frame} turns it, so the "
            "joints do not determine its orientation"
        )
    place = {name: i for i, name in enumerate(options.names)}
    source, multiplier, offset = zip(*(led[joint.name] for joint in moving))
    return Chain(
        text,
        tuple(joint.name for joint in moving),
        tuple(place[name] for name in source),
        multiplier,
        offset,
        tuple(joints[name].lower for name in options.names),
        tuple(joints[name].upper for name in options.names),
    )


def parts(text: str, path: str) -> tuple[list[str], dict[str, Joint]]:
    """
    Return the links and the joints, by name, of a description that is to be found at a path.

    Raises
    ------
    PegOnHoleError
        It is no URDF, has xacro in it, or is larger than what Pinocchio can be given.

    """
    if len(text) > MOST_URDF_BYTES:
        raise PegOnHoleError(
            f"joints.urdf: {path} has {len(text)} characters, a description at most "
            f"{MOST_URDF_BYTES}"
        )
    parser = ElementTree.XMLParser(target=_Bounded(path))
    try:
        # Bytes, as ElementTree refuses a text that declares its encoding.
        root = ElementTree.fromstring(text.encode(), parser)
    except PegOnHoleError:
        raise
    # Of an encoding that is unknown, or has several bytes a character, the others.
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise PegOnHoleError(f"joints.urdf: {path} is not XML: {error}") from None
    if root.tag != "robot":
        raise PegOnHoleError(
            f"joints.urdf: {path} is not a URDF: it begins with <{root.tag}>, not <robot>"
        )
    if any("xacro" in element.tag for element in root.iter()):
        raise PegOnHoleError(
            f"joints.urdf: {path} is to be expanded first: xacro {path} > robot.urdf"
        )
    links = [link.get("name", "") for link in root.findall("link")]
    joints = {}
    for element in root.findall("joint"):
        joint = _joint(element, path)
        if joint.name in joints:
            raise PegOnHoleError(f"{path} has two joints {shown(joint.name)}")
        joints[joint.name] = joint
    _check_tree(links, joints, path)
    return links, joints


class _Bounded(ElementTree.TreeBuilder):
    """Builds a tree as long as it is within the bounds of a description."""

    def __init__(self, path):
        super().__init__()
        self._path, self._depth, self._count = path, 0, 0

    def doctype(self, name, public, system):
        # It may declare entities, which a few bytes make as long as memory lasts.
        raise PegOnHoleError(
            f"joints.urdf: {self._path} has a DOCTYPE, which a URDF does not need; take it out"
        )

    def start(self, tag, attributes):
        self._depth += 1
        self._count += 1
        if self._depth > _MOST_NESTED or self._count > _MOST_ELEMENTS:
            raise PegOnHoleError(
                f"joints.urdf: {self._path} is no description of a robot: it has more than "
                f"{_MOST_ELEMENTS} XML elements, or more than {_MOST_NESTED} within each other"
            )
        return super().start(tag, attributes)

    def end(self, tag):
        self._depth -= 1
        return super().end(tag)


def _check_tree(links, joints, path):
    """Refuse a larger tree than Pinocchio can be given; that it is one at all, its parser sees."""
    freedoms = sum(_FREEDOMS.get(joint.kind, 1) for joint in joints.values())
    if len(links) > MOST_LINKS or freedoms > MOST_FREEDOMS:
        raise PegOnHoleError(
            f"joints.urdf: {path} has {len(links)} links and {freedoms} degrees of freedom, of "
            f"at most {MOST_LINKS} and {MOST_FREEDOMS}; leave out what does not carry the peg"
        )
    above, below = {}, defaultdict(list)
    for joint in joints.values():
        if joint.child in above:
            raise PegOnHoleError(
                f"{path}: joints {shown(above[joint.child])} and {shown(joint.name)} both carry "
                f"{shown(joint.child)}; a link has one parent"
            )
        above[joint.child] = joint.name
        below[joint.parent].append(joint.child)
    level, depth = [link for link in links if link not in above], 0
    while level := [child for link in level for child in below[link]]:
        depth += 1
    if depth > MOST_DEPTH:
        raise PegOnHoleError(
            f"joints.urdf: {path} has {depth} joints one behind the other, of at most "
            f"{MOST_DEPTH}; leave out what does not carry the peg"
        )


def _joint(element, path):
    name, kind = element.get("name", ""), element.get("type", "")
    ends = [element.find(end) for end in ("parent", "child")]
    if not name or None in ends:
        raise PegOnHoleError(f"{path}: joint {shown(name)} lacks its name, parent or child")
    parent, child = (end.get("link", "") for end in ends)
    limit, mimic = element.find("limit"), element.find("mimic")
    lower, upper = -inf, inf
    if kind == "revolute" and limit is not None:
        lower, upper = (_number(limit, side, 0.0, name, path) for side in ("lower", "upper"))
    if not lower < upper:  # left out, or a placeholder
        lower, upper = -inf, inf
    axis, origin = element.find("axis"), element.find("origin")
    if kind in MOVING and axis is not None:
        given = axis.get("xyz", "1 0 0")
        if hypot(*_triple(given)) < _LEAST_AXIS:
            raise PegOnHoleError(
                f"{path}: joint {shown(name)} turns about no axis: {shown(given)}"
            )
    placed = {}
    for key in () if origin is None else ("xyz", "rpy"):
        given = origin.get(key, "0 0 0")
        placed[key] = tuple(_triple(given))
        if not placed[key]:
            raise PegOnHoleError(
                f"{path}: joint {shown(name)} has {key} {shown(given)}, which is not three "
                f"numbers "
                f"of at most {_LARGEST:g}"
            )
    leader, multiplier, offset = "", 1.0, 0.0
    if mimic is not None:
        leader = mimic.get("joint", "")
        multiplier = _number(mimic, "multiplier", 1.0, name, path, _LARGEST)
        offset = _number(mimic, "offset", 0.0, name, path, _LARGEST)
    return Joint(name, kind, parent, child, lower, upper, leader, multiplier, offset, **placed)


def _triple(text):
    """Return three numbers, or nothing where there are not three that any robot has."""
    try:
        found = [float(x) for x in text.split()]
    except ValueError:
        return []
    return found if len(found) == 3 and all(abs(x) <= _LARGEST for x in found) else []


def _number(element, key, default, joint, path, most=inf):
    text = element.get(key)
    try:
        value = default if text is None else float(text)
    except ValueError:
        value = inf
    if not isfinite(value):
        raise PegOnHoleError(
            f"{path}: joint {shown(joint)} has {key} {shown(text)}, which is no number"
        )
    if abs(value) > most:
        raise PegOnHoleError(
            f"{path}: joint {shown(joint)} has {key} {shown(text)}, more than {most:g}"
        )
    return value


def _way(tip, joints, path):
    """Return the joints from the root link to the tip."""
    above = {joint.child: joint for joint in joints.values()}
    way, link = [], tip
    while link in above:
        way.insert(0, above[link])
        link = above[link].parent
        if len(way) > len(joints):
            raise PegOnHoleError(f"{path}: the links above {shown(tip)} form a loop")
    return way


def _leader(joint, joints, path):
    """Return the joint that moves this one, and by which multiplier and offset."""
    multiplier, offset, seen = 1.0, 0.0, [joint.name]
    while joint.leader:
        multiplier, offset = multiplier * joint.multiplier, multiplier * joint.offset + offset
        if joint.leader not in joints or joint.leader in seen:
            raise PegOnHoleError(
                f"{path}: joint {shown(joint.name)} mimics {shown(joint.leader)}, which leads "
                f"to no joint "
                "that moves by itself"
            )
        joint = joints[joint.leader]
        seen.append(joint.name)
    if not abs(multiplier) <= _LARGEST or not abs(offset) <= _LARGEST:
        raise PegOnHoleError(
            f"{path}: joint {shown(seen[0])} moves by {multiplier:g} times {shown(joint.name)} "
            f"and {offset:g}, which is more than {_LARGEST:g}"
        )
    if joint.kind not in MOVING:
        raise PegOnHoleError(
            f"{path}: joint {shown(seen[0])} mimics {shown(joint.name)}, which is {joint.kind}"
        )
    return joint.name, multiplier, offset


def _check_names(options, joints, leaders, path):
    for name in options.names:
        if name not in joints:
            raise PegOnHoleError(
                f"joints.names: {shown(name)} is no joint of {path}; {_nearest(name, joints)}"
            )
        joint = joints[name]
        if joint.leader:
            raise PegOnHoleError(
                f"joints.names: {shown(name)} mimics {shown(joint.leader)}; name that one in "
                f"its place"
            )
        if name not in leaders:
            raise PegOnHoleError(
                f"joints.names: {shown(name)} does not move {options.tip_frame}; leave it out"
            )
    missing = [name for name in leaders if name not in options.names]
    if missing:
        raise PegOnHoleError(
            f"joints.names lacks {listed(missing)}, which "
            f"{'moves' if len(missing) == 1 else 'move'} {options.tip_frame}: every joint "
            "between the root link and the tip has to be read"
        )


def _nearest(name, known):
    near = difflib.get_close_matches(name, known, n=3, cutoff=0.6)
    if near:
        return f"the nearest are: {listed(near)}"
    return f"it has: {listed(known)}"
