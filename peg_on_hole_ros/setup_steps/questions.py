"""What is asked of a cell, since no recording tells it; and how an answer is read."""

import re
from math import pi
from typing import NamedTuple

from peg_on_hole_ros.config.configuration import BY_NAME, check_one
from peg_on_hole_ros.config.ros_yaml import value_of
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.safe_text import shown

# Units that may stand behind a number: the SI unit of the parameter, and its multiple of that.
_UNITS = {
    "m": {"m": 1.0, "mm": 1e-3, "um": 1e-6},
    "rad": {"rad": 1.0, "mrad": 1e-3, "deg": pi / 180.0},
    "kg": {"kg": 1.0, "g": 1e-3},
    "s": {"s": 1.0, "ms": 1e-3},
}


class Question(NamedTuple):
    """
    One question.

    Attributes
    ----------
    name : str
        Of the parameter that it asks for.
    text : str
        What it means in the cell, and how to find it.
    missing : str
        What its default means where nobody states it; empty: it is as good as any value.

    """

    name: str
    text: str
    missing: str = ""


PARTS = (
    Question(
        "scene.hole_diameter",
        "Gauge the bore, not its chamfer, to micrometres: the clearance sets every lever.",
        "gauge the bore and state it",
    ),
    Question(
        "scene.peg_diameter",
        "Gauge the shank, not its chamfer, to micrometres.",
        "gauge the shank and state it",
    ),
    Question("scene.peg_height", "From the lower end to the upper one.", "measure the peg"),
    Question("scene.peg_mass", "Of the peg alone; a gripper is payload.", "weigh the peg"),
    Question("scene.friction", "0.1 to 0.2 for steel on steel; it is estimated from contact on."),
)
PEG_IN_TOOL = (
    Question(
        "joints.peg_xyz",
        "Where the peg's lower end is in the tip frame.",
        "measure how far the peg stands out of the tool",
    ),
    Question(
        "joints.peg_rpy",
        "Peg axes in the tip frame, z up the peg, from its lower end into the gripper: "
        "[3.14159265, 0, 0] where the tip's z points out of the gripper, [0, -1.57079633, 0] "
        "where its x does.",
        "state which way the peg points in the tip frame",
    ),
)
HOLE = (
    Question(
        "joints.hole_xyz",
        "Centre of the hole in its outer face, in the robot's root link, to a millimetre: move "
        "the peg's lower end there and read the robot's display, or take it from the drawing.",
        "touch the rim, or end --run in the hole",
    ),
    Question(
        "joints.hole_rpy",
        "Hole axes in the root link, z out of the hole; zeros for a hole that is upright.",
        "state it, touch the plate (--plate), or end --run in the hole",
    ),
)
SENSOR = (
    Question(
        "wrench.gravity",
        "measured: the wrench changes when the hanging tool is tilted; compensated: the "
        "controller subtracts the weight of the payload.",
    ),
)
SENSOR_PLACE = (
    Question(
        "wrench.sensor_xyz",
        "The sensor's origin in the peg frame: how far above the peg's lower end its drawing "
        "has the origin.",
        "measure from the peg's lower end to the sensor's origin",
    ),
)


def read_answer(name: str, text: str) -> object:
    """
    Return the value that an answer means: numbers with their unit or in SI, lists by commas.

    Raises
    ------
    PegOnHoleError
        It is none, or out of range.

    """
    if name not in BY_NAME:
        check_one(name, text)
        raise PegOnHoleError(f"{name} is a parameter of every ROS 2 node, and none of a cell")
    row, text = BY_NAME[name], text.strip()
    kind = row.type.removesuffix("[]")
    if kind == "string":
        if not row.type.endswith("[]"):
            return check_one(name, text)
        return check_one(name, [part for part in re.split(r"[\s,\[\]]+", text) if part])
    if kind != "double":
        return check_one(name, value_of(text))
    factor, unit = 1.0, re.search(r"[A-Za-z]+$", text)
    units = _UNITS.get(row.unit, {})
    if unit and unit[0] in units:
        factor, text = units[unit[0]], text[: unit.start()]
    numbers = [value_of(part) for part in re.split(r"[\s,\[\]]+", text) if part]
    if not numbers or not all(type(number) in (int, float) for number in numbers):
        like = f", such as 1.5 {' or 1.5 '.join(units)}" if units else ""
        raise PegOnHoleError(f"{name}: {shown(text)} is no number{like}")
    values = [float(f"{factor * float(number):.12g}") for number in numbers]  # type: ignore[arg-type]
    if row.type.endswith("[]"):
        return check_one(name, values)
    if len(values) != 1:
        raise PegOnHoleError(
            f"{name}: {shown(text)} has {len(values)} numbers, and the parameter has one"
        )
    return check_one(name, values[0])
