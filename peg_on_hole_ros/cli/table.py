"""Plain tables and JSON on stdout."""

import json
from collections.abc import Sequence
from math import isfinite
from typing import Any


def table(head: Sequence[str], rows: Sequence[Sequence[str]], left: int = 1) -> str:
    """Return columns that line up: the first `left` ones are texts, the others numbers."""
    lines = [list(head), *(list(row) for row in rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(head))]
    text = []
    for line in lines:
        cells = [cell.ljust(width) for cell, width in zip(line[:left], widths)]
        cells += [cell.rjust(width) for cell, width in zip(line[left:], widths[left:])]
        text.append("  ".join(cells).rstrip())
    return "\n".join(text)


def to_json(content: dict) -> str:
    """Return JSON in a stable form; a number that is not finite raises ValueError."""
    return json.dumps(content, indent=2, allow_nan=False)


def finite(value: Any) -> float | None:
    """Return a Python float, or None where there is no finite one."""
    value = float(value)
    return value if isfinite(value) else None
