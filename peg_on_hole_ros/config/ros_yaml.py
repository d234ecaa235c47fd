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
_DOUBLE_TEXT = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
_NO_NUMBER = re.compile(r"([-+]?)\.?(inf|infinity|nan)", re.IGNORECASE)
# Beyond, a text is no number for ROS 2 either.
_LONGEST_NUMBER = 1000
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
    loader = _Loader(text)
    try:
        if not loader.check_node():
            return None
        node = loader.get_node()
        if loader.check_node():
            loader.get_event()
            line = _line(loader.peek_event())
            raise NoYaml(line, "a second document begins behind ---; keep one")
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise NoYaml(mark.line + 1 if mark else 1, cut(str(error.problem), 200)) from None
    finally:
        loader.dispose()
    return _content(node)


class _Loader(yaml.SafeLoader):
    """Composes nodes of what ROS 2 reads, and says what it does not; tags have no meaning."""

    def __init__(self, text):
        try:
            super().__init__(text)
        except yaml.reader.ReaderError as error:
            # Of a text its place counts characters.
            line = text.count("\n", 0, error.position) + 1
            raise NoYaml(
                line, f"the character #x{error.character:04x} is none of a text"
            ) from None
        self._depth = 0

    def compose_node(self, parent, index):
        event = self.peek_event()
        if isinstance(event, yaml.AliasEvent):
            raise NoYaml(
                _line(event),
                f"*{cut(event.anchor)} stands for a value elsewhere, which ROS 2 does not read; "
                "write the value out",
            )
        if isinstance(parent, yaml.MappingNode) and index is None:
            _check_name(event)
        # Nothing refers to it.
        event.anchor = None
        inner = isinstance(event, yaml.CollectionStartEvent)
        self._depth += inner
        if self._depth > DEEPEST:
            raise NoYaml(
                _line(event), f"groups or lists lie deeper within each other than {DEEPEST}"
            )
        node = super().compose_node(parent, index)
        self._depth -= inner
        return node

    def resolve(self, kind, value, implicit):
        """Leave it to `value_of` what a value without a tag is."""
        return ""


def _line(event):
    return event.start_mark.line + 1


def _check_name(event):
    if not isinstance(event, yaml.ScalarEvent):
        raise NoYaml(_line(event), "a list or a group stands where a name belongs")
    if event.value == "<<":
        raise NoYaml(
            _line(event),
            "<< puts the names of another group here for YAML, and is a name to ROS 2; write "
            "them out",
        )


def _content(node):
    if isinstance(node, yaml.ScalarNode):
        plain = node.style is None and node.tag != _TEXT
        return value_of(node.value) if plain else node.value
    if isinstance(node, yaml.SequenceNode):
        return [_content(each) for each in node.value]
    group = Group()
    for key, value in node.value:
        name, line, before = key.value, _line(key), group.lines.get(key.value)
        if before is not None:
            # PyYAML would keep the later group, ROS 2 merges both.
            raise NoYaml(
                line,
                f"{shown(name)} was there before in the same group, at line {before}; write it "
                "once, with all that belongs to it",
            )
        group.lines[name], group[name] = line, _content(value)
    return group


def value_of(text: str) -> bool | int | float | str | None:
    """Return what ROS 2 reads of a value without quotes; None: no value, or YAML's null."""
    if text in _NULL:
        return None
    if len(text) > _LONGEST_NUMBER:
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
    return _double(text, text) if _DOUBLE_TEXT.fullmatch(text) else text


def _double(number, text):
    """Return a double, or the text of what is none: too large or too small, as for strtod."""
    value = float(number)
    nothing = abs(value) < _SMALLEST and re.search("[1-9]", number.lower().partition("e")[0])
    return text if isinf(value) or nothing else value
