"""Values, names and other people's words as they may stand in a line for a terminal or a log."""

import re
from collections.abc import Iterable

# Of a list of names: more of them are counted.
MOST_NAMED = 10
# Of a value: more of it tells no more.
MOST_SHOWN = 80
# Control characters, lone surrogates (bytes of a file's name that are no text), separators of
# lines, and marks that turn the direction of what follows.
_UNFIT = re.compile(
    r"[\x00-\x1f\x7f-\x9f\ud800-\udfff\u2028\u2029\u200e\u200f\u202a-\u202e\u2066-\u2069]"
)


def printable(text: object) -> str:
    r"""
    Return a text in which what a terminal would obey stands as an escape, such as `\x1b`.

    A byte of a file's name that is no UTF-8 stands as that byte, `\xfc`.
    """
    return _UNFIT.sub(_escaped, str(text))


def _escaped(match):
    number = ord(match[0])
    if 0xDC80 <= number <= 0xDCFF:  # as os.fsdecode has bytes that it cannot decode
        number -= 0xDC00
    return f"\\x{number:02x}" if number <= 0xFF else f"\\u{number:04x}"


def cut(text: str, most: int = MOST_SHOWN) -> str:
    """Return a text of at most so many characters; one that was longer ends with `...`."""
    return text if len(text) <= most else text[: most - 3] + "..."


def shown(value: object) -> str:
    """Return a value as Python writes it, printable and cut to `MOST_SHOWN` characters."""
    try:
        text = repr(value)
    except ValueError:  # an integer of thousands of digits
        text = hex(value) if isinstance(value, int) else f"a {type(value).__name__}"
    except RecursionError:
        text = f"a {type(value).__name__}"
    return cut(printable(text))


def listed(names: Iterable[str], most: int = MOST_NAMED, longest: int = MOST_SHOWN) -> str:
    """Return the first of many names, printable and cut, and how many more there are."""
    names = list(names)
    first = ", ".join(cut(printable(name), longest) for name in names[:most])
    more = len(names) - most
    return f"{first} and {more} more" if more > 0 else first or "none"
