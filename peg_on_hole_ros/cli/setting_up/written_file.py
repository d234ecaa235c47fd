"""What `peg-on-hole setup` writes and prints: settings, each with how it is known."""

import os
import re
from pathlib import Path

from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.config.configuration import BY_NAME
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.config.parameters_file import KNOWN_COMMENT, write_parameters
from peg_on_hole_ros.robot.urdf_source import FROM_TOPIC
from peg_on_hole_ros.safe_text import printable
from peg_on_hole_ros.setup_steps.evidence import shown_value
from peg_on_hole_ros.setup_steps.knowledge import (
    DEFAULT,
    FOLLOWS,
    MEASURED,
    STATED,
    UNKNOWN,
    Cell,
    Known,
)

_KINDS = MEASURED, STATED, FOLLOWS, DEFAULT, UNKNOWN
_COMMENT = re.compile(rf"\s*# {KNOWN_COMMENT} ({'|'.join(_KINDS)})(?:: (.*))?$")
_KEY = re.compile(r"( +)([a-z_0-9]+):")
# What the table has of every cell, beside what is not a default in this one.
_ALWAYS = (
    "joints.urdf",
    "joints.tip_frame",
    "joints.hole_xyz",
    "joints.hole_rpy",
    "scene.gravity",
    "scene.hole_diameter",
    "scene.peg_diameter",
    "wrench.acts_on",
    "wrench.axes",
    "wrench.sensor_xyz",
    "wrench.payload_mass",
    "wrench.bias_force",
    "joints.delay",
)
HEADING = """\
Settings of a cell by `peg-on-hole setup`; the same file serves node and replay. Above each
setting stands how it is known; `peg-on-hole setup --config` goes on from here."""


def written(cell: Cell, out: str) -> str:
    """Return the text of the file."""
    values = dict(cell.values)
    urdf = values.get("joints.urdf", "")
    if urdf not in ("", FROM_TOPIC):
        values["joints.urdf"] = _from(out, urdf)
    known = {name: str(cell.how(name)) for name in BY_NAME}
    lines = [HEADING, *(f"CONTRADICTED {each}" for each in cell.contradictions)]
    heading = "\n".join(printable(each) for line in lines for each in line.split("\n"))
    return write_parameters(values, heading, known)


def _from(out: str, urdf: str) -> str:
    """Return how a file names another: relative where that lies in its folder, or below."""
    folder, file = Path(out).resolve().parent, Path(urdf).expanduser().resolve()
    return os.path.relpath(file, folder) if file.is_relative_to(folder) else str(file)


def read_known(path: str) -> dict[str, Known]:
    """Return how the settings of a file are known, where it was written by `written`."""
    found, group, known = {}, "", None
    for line in Path(path).read_text(encoding="utf-8").splitlines():
        comment, key = _COMMENT.match(line), _KEY.match(line)
        if comment:
            known = Known(comment[1], comment[2] or "")
        elif key and line.rstrip().endswith(":"):
            group = f"{key[2]}." if len(key[1]) == 4 else ""
        elif key:
            name = f"{group if len(key[1]) > 4 else ''}{key[2]}"
            if known is not None and name in BY_NAME:
                found[name] = known
            known = None
    return found


def known_table(cell: Cell, configuration: Configuration) -> str:
    """Return the settings that matter, each with value and how it is known."""
    rows = []
    for name in BY_NAME:
        known = cell.how(name)
        if known.kind == DEFAULT and name not in _ALWAYS:
            continue
        unit = BY_NAME[name].unit
        value = f"{_short(shown_value(cell, configuration, name))}{f' {unit}' if unit else ''}"
        rows.append((name, printable(value), printable(known)))
    return table(("setting", "value", "how it is known"), rows, 3)


def _short(value: object) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_short, value))}]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
