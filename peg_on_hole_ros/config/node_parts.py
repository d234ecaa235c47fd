"""Which parts of a ROS 2 parameters file are for which node: names, namespaces, wildcards."""

import re
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from peg_on_hole_ros.config.configuration import BY_NAME

NODE = "peg_on_hole"
BODY = "ros__parameters"
_EVERY_NODE = ("**", "*")


class Part(NamedTuple):
    """
    What a file has for a node, or for all that a wildcard means.

    Attributes
    ----------
    name : str
        With its namespaces, whether they are written as a name with slashes or as groups.
    body : object
        What stands below: `ros__parameters`, if it is as it has to be.
    line : int
        Of the name.

    """

    name: str
    body: object
    line: int


def parts(tree: Any, prefix: str = "") -> Iterator[Part]:
    """Yield the parts of a file in their order; `tree` is what `ros_yaml.load` gives."""
    for key, body in tree.items() if isinstance(tree, dict) else ():
        name = f"{prefix}{key}"
        last = name.rsplit("/", 1)[-1]
        group = isinstance(body, dict) and BODY not in body
        if group and (_leads_to_body(body) or last not in (*_EVERY_NODE, NODE)):
            # A namespace, or a wildcard for one: `/*:` above `peg_on_hole:` is `/*/peg_on_hole`.
            yield from parts(body, f"{name}/")
        else:
            yield Part(name, body, tree.lines[key])


def _leads_to_body(tree):
    groups = [value for value in tree.values() if isinstance(value, dict)]
    return any(BODY in group or _leads_to_body(group) for group in groups)


def of_node(found: Iterable[Part], full_name: str) -> list[Part]:
    """Return the parts for a node that runs, as `/cell/peg_on_hole`."""
    return [part for part in found if matches(part.name, full_name)]


def of_ours(found: Iterable[Part]) -> list[Part] | None:
    """
    Return the parts for all nodes and for this one, whose namespace the file has to tell.

    None: they are for several nodes of this kind.
    """
    found = list(found)
    # A namespace, written as a name with slashes or as a group, is for ROS to tell apart.
    own = [part.name for part in found if part.name.rsplit("/", 1)[-1] == NODE]
    full = [_full_name(name) for name in own if "*" not in name]
    if len(full) == 1:
        return of_node(found, full[0])
    ours = [part for part in found if part.name in own or _may_be_ours(part)]
    names = [part.name for part in ours if part.name.strip("/") not in _EVERY_NODE]
    # In which namespace the node is only it knows: one has to do for all of them.
    full = full or [_full_name(name) for name in names]
    if names and not any(all(matches(name, one) for name in names) for one in full):
        return None
    return ours


def _full_name(name):
    """Return the name of a node of ours that a part is for; with wildcards, of any."""
    above = [part for part in name.strip("/").split("/")[:-1] if part != "**"]
    return "/" + "/".join([*(part.replace("*", "any") for part in above), NODE])


def _may_be_ours(part):
    if part.name.strip("/") in _EVERY_NODE:
        return True
    # All nodes of a namespace: of ours, or of some other cell.
    every = part.name.rsplit("/", 1)[-1] in _EVERY_NODE
    return every and isinstance(part.body, dict) and is_ours(part.body.get(BODY))


def matches(name: str, full_name: str) -> bool:
    """Return whether a part of a parameters file is for a node, as `/cell/peg_on_hole`."""
    # As rcl: * is one part of a name, ** any number of parts.
    pattern = []
    for part in name.strip("/").split("/"):
        pattern.append(
            "(/[^/]+)*" if part == "**" else "/" + re.escape(part).replace(r"\*", "[^/]+")
        )
    return re.fullmatch("".join(pattern), full_name) is not None


def is_ours(body: object) -> bool:
    """Return whether parameters of a file look like this node's, under whatever name."""
    # Other programs have `joints` or `filter` too, and a misspelt name makes a file no other's.
    names = list(_names(body))
    known = [name for name in names if name in BY_NAME]
    return 2 * len(known) >= len(names) and any("." in name for name in known)


def _names(tree, prefix=""):
    for key, value in tree.items() if isinstance(tree, dict) else ():
        if isinstance(value, dict):
            yield from _names(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"
