"""YAML as ROS 2 reads it: names are texts, tags mean nothing, 1e-4 is a number, no aliases."""

import re
from math import inf, isinf, nan

import yaml

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.safe_text import cut, printable, shown

# No parameter lies deeper, and no part of a file for a node.
DEEPEST = 32
_TEXT = "tag:yaml.org,2002:str"
_NULL = ("", "~", "null", "Null", "NULL")
_BOOL = re.compile("(y|yes|true|on)|(n|no|false|off)")
# As strtol, which takes 0x for sixteen and 0 for eight.
_INTEGER = re.compile(r"[-+]?(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)")
_DOUBLE = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
_NO_NUMBER = re.compile(r"([-+]?)\.?(inf|infinity|nan)", re.IGNORECASE)
# Beyond, a text is no number for ROS 2 either.
_LONGEST = 1000
_SMALLEST = 2.2250738585072014e-308


class NoYaml(PegOnHoleError):
    """
    A text that is no YAML, or has what ROS 2 does not read of it.

    Attributes
    ----------
    line : int
        Where, from 1 on.

    """

    def __init__(self, line: int, problem: str) -> None:
        super().__init__(f"at line {line}: {printable(problem)}")
        self.line = line


class Group(dict):
    """
    Names and their values.

    Attributes
    ----------
    lines : dict of str to int
        Where each name stands, from 1 on.

    """

    def __init__(self) -> None:
        super().__init__()
        self.lines: dict[str, int] = {}


def load(text: str) -> object:
    """
    Return what a text holds: a Group, a list, a bool, an int, a float, a str or None.

    Raises
    ------
    NoYaml
        No YAML, several documents, an alias, `<<`, a name twice in one group, a name that is no
        text, or groups and lists within each other more than DEEPEST times.

    """
    try:
        # Events, not PyYAML's own objects: it builds these by recursion, and takes tags.
        return _document(text)
    except yaml.reader.ReaderError as error:
        # Of a text its place counts characters.
        line = text.count("\n", 0, error.position) + 1
        raise NoYaml(line, f"the character #x{error.character:04x} is none of a text") from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise NoYaml(mark.line + 1 if mark else 1, cut(str(error.problem), 200)) from None


def _document(text):
    found, open_ = [], []
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        line = event.start_mark.line + 1
        if isinstance(event, yaml.AliasEvent):
            raise NoYaml(
                line,
                f"*{cut(event.anchor)} stands for a value elsewhere, which ROS 2 does not read; "
                "write the value out",
            )
        if isinstance(event, yaml.CollectionEndEvent):
            open_.pop()
        elif isinstance(event, yaml.NodeEvent):
            _put(open_, found, event, line)
        if len(open_) > DEEPEST:
            raise NoYaml(line, f"groups or lists lie deeper within each other than {DEEPEST}")
    if len(found) > 1:
        raise NoYaml(line, "a second document begins behind ---; keep one")
    return found[0] if found else None


class _Open:
    """A group or a list whose end has not come."""

    def __init__(self, content):
        self.content = content
        self.name: str | None = None


def _put(open_, found, event, line):
    """Put a value, a name, or the begin of a group or list where it belongs."""
    owner = open_[-1] if open_ else None
    is_name = owner is not None and isinstance(owner.content, Group) and owner.name is None
    if is_name:
        if not isinstance(event, yaml.ScalarEvent):
            raise NoYaml(line, "a list or a group stands where a name belongs")
        _name(owner, event.value, line)
        return
    if isinstance(event, yaml.ScalarEvent):
        plain = event.style is None and event.tag != _TEXT
        value = value_of(event.value) if plain else event.value
    else:
        value = [] if isinstance(event, yaml.SequenceStartEvent) else Group()
        open_.append(_Open(value))
    if owner is None:
        found.append(value)
    elif isinstance(owner.content, list):
        owner.content.append(value)
    else:
        owner.content[owner.name], owner.name = value, None


def _name(owner, name, line):
    if name == "<<":
        raise NoYaml(
            line,
            "<< puts the names of another group here for YAML, and is a name to ROS 2; write "
            "them out",
        )
    before = owner.content.lines.get(name)
    if before is not None:
        # PyYAML would keep the later group, ROS 2 merges both.
        raise NoYaml(
            line,
            f"{shown(name)} was there before in the same group, at line {before}; write it once, "
            "with all that belongs to it",
        )
    owner.name = name
    owner.content.lines[name] = line


def value_of(text: str) -> bool | int | float | str | None:
    """Return what ROS 2 reads of a value without quotes; None: no value, or YAML's null."""
    if text in _NULL:
        return None
    if len(text) > _LONGEST:
        return text
    truth = _BOOL.fullmatch(text.lower())
    if truth and text in (text.lower(), text.upper(), text.title()):
        return truth[1] is not None
    if _INTEGER.fullmatch(text):
        value = int(text, 16 if "x" in text.lower() else 8 if text.lstrip("+-")[0] == "0" else 10)
        if -(1 << 63) <= value < 1 << 63:
            return value
        return _double(str(value), text)
    special = _NO_NUMBER.fullmatch(text)
    if special:
        value = nan if special[2].lower() == "nan" else inf
        return -value if special[1] == "-" else value
    return _double(text, text) if _DOUBLE.fullmatch(text) else text


def _double(number, text):
    """Return a double, or the text of what is none: too large or too small, as for strtod."""
    value = float(number)
    nothing = abs(value) < _SMALLEST and re.search("[1-9]", number.lower().partition("e")[0])
    return text if isinf(value) or nothing else value
