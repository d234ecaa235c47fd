"""Read and write ROS 2 parameters files: `peg_on_hole: ros__parameters:`."""

import difflib
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from peg_on_hole_ros.config.configuration import BY_NAME, PARAMETERS, check, check_one, spaced
from peg_on_hole_ros.config.node_parts import BODY, NODE, Part, of_node, of_ours, parts
from peg_on_hole_ros.config.parameter_table import Parameter
from peg_on_hole_ros.config.ros_yaml import Group, NoYaml, load, value_of
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.safe_text import cut, printable, shown

# A file of more holds no parameters, or never ends (/dev/zero) [bytes].
MOST_FILE_BYTES = 1 << 20


class NoPart(PegOnHoleError):
    """A parameters file without a part for this node."""


def read_parameters(path: str | Path, node: str | None = None) -> dict[str, object]:
    """
    Return dotted name to value of a ROS 2 parameters file, each checked on its own.

    A block for every node (`/**:`) and the node's own count in the order of the file, as for
    ROS 2: of two values of one parameter the later holds.

    Parameters
    ----------
    path : str or Path
    node : str, optional
        Full name of a node that runs, as `/cell/peg_on_hole`: what ROS 2 gives it of the file.
        Without it the file itself has to tell in which namespace it is.

    Raises
    ------
    PegOnHoleError
        No such file, no YAML, a name twice in one group, another node's file, unknown name, wrong
        type, out of range; with file and line.

    """
    path = Path(path)
    content = load_yaml(path)
    if not isinstance(content, dict) or not content:
        raise PegOnHoleError(f"{path} holds no parameters; {_expected()}")
    ours = _ours(content, path) if node is None else of_node(parts(content), node)
    values: dict[str, object] = {}
    lines: dict[str, int] = {}
    for part in ours:
        found: dict[str, object] = {}
        try:
            _flatten(_body(part), "", part.line, found, lines)
        except _Misplaced as error:
            raise PegOnHoleError(f"{path}, line {error.line}: {error}") from None
        values |= found
    # A name that does not exist tells more than the value that it was split from: 0,2.
    for name, value in sorted(values.items(), key=lambda item: item[0] in BY_NAME):
        try:
            check_one(name, value)
        except PegOnHoleError as error:
            raise PegOnHoleError(f"{path}, line {lines[name]}: {error}") from None
    return values


class _Misplaced(Exception):
    """Something that is no parameter where one belongs, or the other way round."""

    def __init__(self, line, problem):
        super().__init__(problem)
        self.line = line


def _ours(content, path):
    found = of_ours(parts(content))
    if found is None:
        names = ", ".join(printable(part.name) for part in parts(content))
        raise PegOnHoleError(f"{path} has parameters for {cut(names)}: keep those of one node")
    if not found:
        names = ", ".join(printable(key) for key in content)
        raise NoPart(f"{path} has parameters for {cut(names)}, none for {NODE}; {_expected()}")
    return found


def _body(part: Part):
    body = part.body
    if isinstance(body, dict) and list(body) == [BODY]:
        return body[BODY]
    found, near = shown(body), ""
    if isinstance(body, dict):
        found = cut(printable(", ".join(body)))
        near = " (two underscores)" if difflib.get_close_matches(BODY, body) else ""
    raise _Misplaced(
        part.line,
        f"below {printable(part.name)} there is {found}, not {BODY}{near}; {_expected()}",
    )


def load_yaml(path: Path) -> Any:
    """Return what a YAML file holds, its values as ROS 2 reads them; errors name file and line."""
    try:
        check_no_pipe(path)
        with path.open("rb") as file:
            data = file.read(MOST_FILE_BYTES + 1)
        if len(data) > MOST_FILE_BYTES:
            raise PegOnHoleError(
                f"{path} is larger than {MOST_FILE_BYTES} bytes, so that it is no parameters file"
            )
        return load(data.decode())
    except FileNotFoundError:
        raise PegOnHoleError(f"there is no configuration file {path}") from None
    except UnicodeDecodeError as error:
        raise PegOnHoleError(
            f"cannot read the configuration {path}: it is no text in UTF-8 at byte {error.start}, "
            "a bag perhaps; a configuration is a ROS 2 parameters file (YAML)"
        ) from None
    except NoYaml as error:
        raise NoYamlFile(path, error) from None
    except PegOnHoleError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a name with a NUL
        reason = getattr(error, "strerror", None) or error
        raise PegOnHoleError(f"cannot read the configuration {path}: {reason}") from None


def check_no_pipe(path: Path) -> None:
    """
    Refuse a named pipe, whose writer would be waited for; one of a shell has its writer.

    Raises
    ------
    PegOnHoleError

    """
    if path.is_fifo() and not os.path.realpath(path).startswith("/proc/"):
        raise PegOnHoleError(f"{path} is a named pipe, which is not read; name a file")


class NoYamlFile(PegOnHoleError):
    """A file that is no YAML, or has what ROS 2 does not read of it."""

    def __init__(self, path: Path, error: NoYaml) -> None:
        super().__init__(f"{path} is not YAML {error}")


def _expected():
    return f"a ROS 2 parameters file begins with '{NODE}:' and below it '{BODY}:'"


def _flatten(tree, prefix, line, values, lines):
    """Fill in value and line of each parameter by its dotted name."""
    name = printable(cut(prefix.rstrip(".") or BODY))
    if tree is None or prefix and tree == {}:
        raise _Misplaced(
            line, f"nothing stands below {name}, which ROS 2 does not read; take the line out too"
        )
    if not isinstance(tree, Group):
        remedy = f"; {spaced(tree)}" if isinstance(tree, str) and ":" in tree else ""
        raise _Misplaced(
            line, f"{name} = {shown(tree)} is a value, but it is a group of names{remedy}"
        )
    for key, value in tree.items():
        full = f"{prefix}{key}"
        group = isinstance(value, Group) or any(row.startswith(f"{full}.") for row in BY_NAME)
        if group and full not in BY_NAME:
            _flatten(value, f"{full}.", tree.lines[key], values, lines)
        elif full in values:
            # Dotted and within its group: which of the two would hold is no matter of luck.
            raise _Misplaced(
                tree.lines[key],
                f"{printable(cut(full))} was there before, at line {lines[full]}; write it once",
            )
        else:
            values[full], lines[full] = value, tree.lines[key]


# Begins the comment that says how a setting is known.
KNOWN_COMMENT = "known:"


def write_parameters(
    parameters: dict[str, object], heading: str = "", known: Mapping[str, str] | None = None
) -> str:
    """
    Return a ROS 2 parameters file with every parameter, each with unit, default and effect.

    Parameters
    ----------
    parameters : dict of str to value
        What differs from the defaults; checked.
    heading : str
        Lines put above as a comment.
    known : mapping of str to str, optional
        How each value is known, a line put above it as a comment.

    """
    values = check(parameters)
    lines = [f"# {line}".rstrip() for line in heading.splitlines()]
    lines += [f"{NODE}:", f"  {BODY}:"]
    group = ""
    # Parameters outside groups first: YAML has no way back out of the last group.
    for row in sorted(PARAMETERS, key=lambda row: "." in row.name):
        owner, _, name = row.name.rpartition(".")
        if owner != group:
            lines.append(f"    {owner}:")
            group = owner
        indent = "      " if owner else "    "
        lines.append(f"{indent}# {_comment(row)}")
        if known is not None:
            lines.append(f"{indent}# {KNOWN_COMMENT} {printable(known[row.name])}")
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
        text = plain and isinstance(value_of(value), str)
        return value if text else '"' + _escaped(value) + '"'
    return str(value)


def _escaped(text):
    return "".join(
        f"\\{c}" if c in '\\"' else c if c.isprintable() else f"\\U{ord(c):08x}" for c in text
    )


DEFAULT_HEADING = """\
All parameters of peg_on_hole with their defaults; the same file serves the node
    ros2 run peg_on_hole_ros peg_on_hole --ros-args --params-file peg_on_hole.yaml
and the command line
    peg-on-hole replay BAG --config peg_on_hole.yaml
Units are SI, angles are in radians. Doubles need their point: 1.0, not 1.
Made by: python3 -m peg_on_hole_ros.config.parameters_file > config/peg_on_hole.yaml"""


if __name__ == "__main__":
    print(write_parameters({}, DEFAULT_HEADING), end="")
