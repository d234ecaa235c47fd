"""Read and write ROS 2 parameters files: `peg_on_hole: ros__parameters:`."""

import difflib
import re
from pathlib import Path

import yaml

from peg_on_hole_ros.configuration import BY_NAME, PARAMETERS, check, spaced
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.parameter_table import Parameter

NODE = "peg_on_hole"
_EVERY_NODE = ("**", "*")
_BODY = "ros__parameters"


class NoPart(PegOnHoleError):
    """A parameters file without a part for this node."""


class _Loader(yaml.SafeLoader):
    """YAML as ROS 2 reads it: 1e-4 is a number (for YAML 1.1 it is a text)."""

    def compose_node(self, parent, index):
        """Refuse what ROS 2 refuses with less to go by."""
        if self.check_event(yaml.AliasEvent):
            event = self.peek_event()
            raise yaml.composer.ComposerError(
                problem=f"*{event.anchor} stands for a value elsewhere, which ROS 2 does not "
                "read; write the value out",
                problem_mark=event.start_mark,
            )
        return super().compose_node(parent, index)

    def construct_mapping(self, node, deep=False):
        """Refuse a name that is there twice: PyYAML keeps the later group, ROS 2 merges both."""
        lines = {}
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                continue
            line = key.start_mark.line + 1
            if key.tag == "tag:yaml.org,2002:merge":
                raise yaml.constructor.ConstructorError(
                    problem="<< puts the names of another group here for YAML, and is a name to "
                    "ROS 2; write them out",
                    problem_mark=key.start_mark,
                )
            if key.value in lines:
                raise yaml.constructor.ConstructorError(
                    problem=f"{key.value!r} was there before in the same group, at line "
                    f"{lines[key.value]}; write it once, with all that belongs to it",
                    problem_mark=key.start_mark,
                )
            lines[key.value] = line
        return super().construct_mapping(node, deep)


# Those that ROS 2 reads in another way; it has no dates, and 1_000 and 12:30 are texts to it.
_OTHER = {f"tag:yaml.org,2002:{kind}" for kind in ("bool", "float", "int", "timestamp")}
_Loader.yaml_implicit_resolvers = {
    letter: [pair for pair in pairs if pair[0] not in _OTHER]
    for letter, pairs in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
for _kind, _pattern, _letters in (
    ("bool", r"[yYnN]|yes|Yes|YES|true|True|TRUE|on|On|ON|no|No|NO|false|False|FALSE|off|Off|OFF",
     "yYnNtTfFoO"),
    ("int", r"[-+]?(0x[0-9a-fA-F]+|0[0-7]*|[1-9]\d*)", "-+0123456789"),
    ("float",
     r"[-+]?(\d+\.\d*|\.\d+|\d+(?=[eE]))([eE][-+]?\d+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
     "-+0123456789."),
):  # fmt: skip
    _Loader.add_implicit_resolver(
        f"tag:yaml.org,2002:{_kind}", re.compile(f"({_pattern})$"), list(_letters)
    )
_Loader.bool_values = yaml.SafeLoader.bool_values | {"y": True, "n": False}


def read_parameters(path: str | Path) -> dict[str, object]:
    """
    Return dotted name to value of a ROS 2 parameters file, each checked on its own.

    A block for every node (`/**:`) and the node's own count in the order of the file, as for
    ROS 2: of two values of one parameter the later holds.

    Raises
    ------
    PegOnHoleError
        No such file, no YAML, a name twice in one group, another node's file, unknown name, wrong
        type, out of range.

    """
    path = Path(path)
    content = load_yaml(path)
    if not isinstance(content, dict) or not content:
        raise PegOnHoleError(f"{path} holds no parameters; {_expected()}")
    parameters: dict[str, object] = {}
    for name, body in _ours(content, path):
        if not isinstance(body, dict) or list(body) != [_BODY]:
            found = ", ".join(map(str, body)) if isinstance(body, dict) else repr(body)
            near = ""
            if isinstance(body, dict) and difflib.get_close_matches(_BODY, map(str, body)):
                near = " (two underscores)"
            raise PegOnHoleError(
                f"{path}: below {name} there is {found}, not {_BODY}{near}; {_expected()}"
            )
        _flatten(body[_BODY], "", parameters, path)
    try:
        check(parameters)
    except PegOnHoleError as error:
        raise PegOnHoleError(f"{path}: {error}") from None
    return parameters


def _ours(content, path):
    """Return (name, body) of the parts for all nodes and for this one, in the file's order."""
    parts = list(_parts(content, ""))
    # A namespace, written as a name with slashes or as a group, is for ROS to tell apart.
    own = [name for name, _ in parts if name.rsplit("/", 1)[-1] == NODE]
    full = [_full_name(name) for name in own if "*" not in name]
    if len(full) == 1:
        ours = [part for part in parts if matches(part[0], full[0])]
    else:
        ours = [part for part in parts if part[0] in own or _may_be_ours(*part)]
        names = [name for name, _ in ours if name.strip("/") not in _EVERY_NODE]
        # In which namespace the node is only it knows: one has to do for all of them.
        full = full or [_full_name(name) for name in names]
        if names and not any(all(matches(name, one) for name in names) for one in full):
            found = ", ".join(names)
            raise PegOnHoleError(f"{path} has parameters for {found}: keep those of one node")
    if not ours:
        found = ", ".join(str(key) for key in content)
        raise NoPart(f"{path} has parameters for {found}, none for {NODE}; {_expected()}")
    return ours


def _full_name(name):
    """Return the name of a node of ours that a part is for; with wildcards, of any."""
    parts = [part for part in name.strip("/").split("/")[:-1] if part != "**"]
    return "/" + "/".join([*(part.replace("*", "any") for part in parts), NODE])


def _may_be_ours(name, body):
    if name.strip("/") in _EVERY_NODE:
        return True
    # All nodes of a namespace: of ours, or of some other cell.
    every = name.rsplit("/", 1)[-1] in _EVERY_NODE
    return every and isinstance(body, dict) and is_ours(body.get(_BODY))


def matches(name: str, full_name: str) -> bool:
    """Return whether a part of a parameters file is for a node, as `/cell/peg_on_hole`."""
    # As rcl: * is one part of a name, ** any number of parts.
    parts = []
    for part in name.strip("/").split("/"):
        parts.append(
            "(/[^/]+)*" if part == "**" else "/" + re.escape(part).replace(r"\*", "[^/]+")
        )
    return re.fullmatch("".join(parts), full_name) is not None


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


def _parts(tree, prefix):
    for key, body in tree.items():
        name = f"{prefix}{key}"
        last = name.rsplit("/", 1)[-1]
        inner = isinstance(body, dict) and _BODY not in body and last != NODE
        if inner and name.strip("/") not in _EVERY_NODE:
            yield from _parts(body, f"{name}/")
        else:
            yield name, body


def load_yaml(path: Path) -> object:
    """Return what a YAML file holds, its numbers as ROS 2 reads them; errors name the file."""
    try:
        return yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)
    except FileNotFoundError:
        raise PegOnHoleError(f"there is no configuration file {path}") from None
    except OSError as error:
        raise PegOnHoleError(f"cannot read the configuration {path}: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise PegOnHoleError(
            f"cannot read the configuration {path}: it is no text in UTF-8 at byte {error.start}, "
            "a bag perhaps; a configuration is a ROS 2 parameters file (YAML)"
        ) from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f" at line {mark.line + 1}" if mark else ""
        problem = getattr(error, "problem", None) or error
        raise PegOnHoleError(f"{path} is not YAML{where}: {problem}") from None


def value_of(text: str) -> object:
    """Return what ROS 2 reads of a single value, as behind `-p NAME:=`; raises yaml.YAMLError."""
    return yaml.load(text, Loader=_Loader)


def _expected():
    return f"a ROS 2 parameters file begins with '{NODE}:' and below it '{_BODY}:'"


def _flatten(tree, prefix, parameters, path):
    if tree is None or prefix and tree == {}:
        raise PegOnHoleError(
            f"{path}: nothing stands below {prefix.rstrip('.') or _BODY}, which ROS 2 does not "
            "read; take the line out too"
        )
    if not isinstance(tree, dict):
        name = prefix.rstrip(".") or _BODY
        remedy = f"; {spaced(tree)}" if isinstance(tree, str) and ":" in tree else ""
        raise PegOnHoleError(
            f"{path}: {name} = {tree!r} is a value, but it is a group of names{remedy}"
        )
    for key, value in tree.items():
        name = f"{prefix}{key}"
        group = isinstance(value, dict) or any(row.startswith(f"{name}.") for row in BY_NAME)
        if group and name not in BY_NAME:
            _flatten(value, f"{name}.", parameters, path)
        else:
            parameters[name] = value


def write_parameters(parameters: dict[str, object], heading: str = "") -> str:
    """
    Return a ROS 2 parameters file with every parameter, each with unit, default and effect.

    Parameters
    ----------
    parameters : dict of str to value
        What differs from the defaults; checked.
    heading : str
        Lines put above as a comment.

    """
    values = check(parameters)
    lines = [f"# {line}".rstrip() for line in heading.splitlines()]
    lines += [f"{NODE}:", f"  {_BODY}:"]
    group = ""
    # Parameters outside groups first: YAML has no way back out of the last group.
    for row in sorted(PARAMETERS, key=lambda row: "." in row.name):
        owner, _, name = row.name.rpartition(".")
        if owner != group:
            lines.append(f"    {owner}:")
            group = owner
        indent = "      " if owner else "    "
        lines.append(f"{indent}# {_comment(row)}")
        lines.append(f"{indent}{name}: {_yaml(values[row.name])}")
    return "\n".join(lines) + "\n"


def _comment(row: Parameter) -> str:
    parts = [f"[{row.unit}]"] if row.unit else []
    parts.append(row.effect + ";")
    if row.choices:
        parts.append(f"{' or '.join(row.choices)};")
    elif row.low is not None:
        parts.append(f"{row.low:g} to {row.high:g};")
    parts.append(f"default {_yaml(row.default)}")
    return " ".join(parts)


def _yaml(value):
    if isinstance(value, (tuple, list)):
        return "[" + ", ".join(_yaml(item) for item in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        text = repr(value)
        # Without the point YAML 1.1 readers take 1e-05 for a text.
        return text.replace("e", ".0e") if "e" in text and "." not in text else text
    if isinstance(value, str):
        plain = re.fullmatch(r"[A-Za-z/][A-Za-z0-9_/]*", value)
        known = yaml.load(value, Loader=_Loader) if plain else None
        return value if plain and isinstance(known, str) else '"' + _escaped(value) + '"'
    return str(value)


def _escaped(text):
    return text.replace("\\", "\\\\").replace('"', '\\"')


DEFAULT_HEADING = """\
All parameters of peg_on_hole with their defaults; the same file serves the node
    ros2 run peg_on_hole_ros peg_on_hole --ros-args --params-file peg_on_hole.yaml
and the command line
    peg-on-hole replay BAG --config peg_on_hole.yaml
Units are SI, angles are in radians. Doubles need their point: 1.0, not 1.
Made by: python3 -m peg_on_hole_ros.edges.config_file > config/peg_on_hole.yaml"""


if __name__ == "__main__":
    print(write_parameters({}, DEFAULT_HEADING), end="")
