"""`peg-on-hole calibrate --presses`: axes, sensor_rpy and acts_on from three presses of a hand."""

from collections import Counter
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.recordings import measured_orientations, usable_wrenches
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.identification.presses import (
    Axes,
    Presses,
    axes_of,
    find_axes,
    held_orientation,
)


class FoundAxes(NamedTuple):
    """
    What three presses tell.

    Attributes
    ----------
    values : dict of str to object
        Parameters.
    text : str
        To print.
    pressed : Presses
    axes : Axes

    """

    values: dict[str, object]
    text: str
    pressed: Presses
    axes: Axes


def found_axes(bag: Bag, configuration: Configuration, left_out: Counter[str]) -> FoundAxes:
    """
    Return the parameters that three presses tell, and the text to print.

    Parameters
    ----------
    bag : Bag
    configuration : Configuration
    left_out : Counter
        Counted up: wrenches that are left out, by reason.

    Raises
    ------
    BagError
        There is no wrench; or no orientation, where the numbers are stated to be in axes that
        stand still.
    PegOnHoleError
        As `find_axes`.

    """
    pressed = find_axes(usable_wrenches(bag, configuration, left_out))
    R_HP = held_orientation(measured_orientations(bag, configuration))
    if R_HP is None and configuration.wrench.base_rpy is not None:
        raise BagError(
            f"record the joint states too: with wrench.axes: {configuration.wrench.axes} presses "
            f"need the peg's orientation, and {bag.path} has no joint state that can be used"
        )
    return _parameters_and_text(pressed, configuration, R_HP)


def _parameters_and_text(pressed: Presses, configuration, R_HP: np.ndarray | None):
    found = axes_of(pressed, configuration, R_HP)
    values: dict[str, object] = {"wrench.acts_on": pressed.acts_on, "wrench.axes": found.axes}
    lines = [
        f"three presses of {', '.join(f'{force:.0f}' for force in pressed.forces)} N: up, x, y",
        f"wrench.acts_on: {pressed.acts_on}",
        f"wrench.axes: {found.axes}",
    ]
    turned = pressed.turned
    if found.axes == "sensor":
        rpy = [round(angle, 6) + 0.0 for angle in pressed.rpy]
        values["wrench.sensor_rpy"] = rpy
        lines.append(f"wrench.sensor_rpy: {rpy}")
        beside = f", and the nearest quarter turn by {turned:.0f}" if turned else ""
    else:
        beside = f", and the axes of {found.axes} by {found.off:.0f}"
    lines.append(f"the hand missed its directions by {pressed.missed:.0f} degrees{beside}")
    if found.alike:
        lines.append(
            f"the axes of {found.alike} look the same in this pose: press again with the peg at "
            "another tilt if the wrench may be in these"
        )
    return FoundAxes(values, "\n".join(lines), pressed, found)
