"""What else a wrench may mean than what is stated, each as the settings that would say so."""

from dataclasses import fields, replace
from itertools import product
from math import log
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import WrenchInput
from peg_on_hole_ros.measurements.measurement import rotation_from_rpy
from peg_on_hole_ros.measurements.rotations import quarter_turns, rpy_of

# What a wrong setting costs before anything is measured, and each beside it [nats].
ONE_WRONG, MORE_WRONG = 3.0, 6.0
_NEWTONS, _NEWTON_METRES = ("N", 1.0), ("N m", 1.0)
# Units of force and torque that a driver may send, each with its N and N m.
_POUND = 4.448222
_UNITS = (
    (("kN", 1e3), _NEWTON_METRES),
    (_NEWTONS, ("N mm", 1e-3)),
    (("kN", 1e3), ("N mm", 1e-3)),
    (("kN", 1e3), ("kN m", 1e3)),
    (("lbf", _POUND), _NEWTON_METRES),
    (("lbf", _POUND), ("lbf in", 0.0254 * _POUND)),
    (("lbf", _POUND), ("lbf ft", 0.3048 * _POUND)),
)
# Columns of a row: factors of force and torque, whether in the base's axes, whether freed of
# weight, and the axes to turn to (3, 3) with the sign.
WIDTH = 13


class Hypothesis(NamedTuple):
    """
    What a wrench may mean.

    Attributes
    ----------
    options : WrenchInput
        That say so, but for units, which have no setting.
    settings : tuple of str
        In which they differ from the stated ones, as `name: value`, or the units.
    cost : float
        Before anything is measured [nats].
    row : ndarray, shape (WIDTH,)
        For compiled code.
    unit : str
        Of the force as it is sent.

    """

    options: WrenchInput
    settings: tuple[str, ...]
    cost: float
    row: np.ndarray
    unit: str


def hypotheses(stated: WrenchInput) -> list[Hypothesis]:
    """Return what a wrench may mean, what is stated first."""
    found = [_hypothesis(stated, stated)]
    R_PS = rotation_from_rpy(stated.sensor_rpy)
    for turn, robot, compensated in product(quarter_turns(), (False, True), (False, True)):
        rpy = stated.sensor_rpy
        if not np.array_equal(turn, np.eye(3)):
            rpy = tuple(round(angle, 6) + 0.0 for angle in rpy_of(R_PS @ turn))
        options = replace(stated, sensor_rpy=rpy, axes="sensor")  # type: ignore[arg-type]
        found.append(_hypothesis(stated, _meant(options, robot, compensated)))
    for robot, compensated in product((False, True), (False, True)):
        options = replace(stated, axes="base")
        found.append(_hypothesis(stated, _meant(options, robot, compensated)))
    for units in _UNITS:
        found.append(_hypothesis(stated, stated, units))
    first = {hypothesis.settings: hypothesis for hypothesis in reversed(found)}
    return sorted(first.values(), key=lambda hypothesis: hypothesis.cost)


def _meant(options, robot, compensated):
    return replace(
        options,
        acts_on="robot" if robot else "peg",
        gravity="compensated" if compensated else "measured",
    )


def _hypothesis(stated, options, units=(_NEWTONS, _NEWTON_METRES)):
    settings, spread = [], 0.0
    for name in ("acts_on", "axes", "gravity"):
        value = getattr(options, name)
        if value != getattr(stated, name):
            settings.append(f"wrench.{name}: {value}")
    if options.sensor_rpy != stated.sensor_rpy:
        settings.append(f"wrench.sensor_rpy: {[round(angle, 4) for angle in options.sensor_rpy]}")
        # One of so many turns.
        spread = log(23)
    row = np.zeros(WIDTH)
    for i, (name, (unit, factor)) in enumerate(zip(("force", "torque"), units)):
        row[i] = factor
        if factor != 1.0:
            settings.append(f"unit of the {name} read as {unit}")
    row[2], row[3] = options.axes == "base", options.gravity == "compensated"
    axes = np.eye(3) if options.axes == "base" else rotation_from_rpy(options.sensor_rpy)
    row[4:] = (-axes if options.acts_on == "robot" else axes).ravel()
    cost = ONE_WRONG + MORE_WRONG * (len(settings) - 1) + spread if settings else 0.0
    return Hypothesis(options, tuple(settings), cost, row, units[0][0])


_WHY = {
    "wrench.acts_on: robot": ": robot would fit, the sign of the wrench is reversed",
    "wrench.acts_on: peg": ": peg would fit, the sign of the wrench is reversed",
    "wrench.axes: base": ": its numbers are in the axes of the robot's base, whatever frame_id is",
    "wrench.axes: sensor": ": its numbers are in the axes of the sensor, not of the base",
    "wrench.gravity: compensated": ": the weight seems to be taken off already",
    "wrench.gravity: measured": ": the weight does not seem to be taken off",
}


def said(found: Hypothesis, before: float, after: float) -> str:
    """Return in a line what is wrong; to how much forces balance before, as sent, and after."""
    units = found.settings[0].startswith("unit")
    why, sent = _WHY.get(found.settings[0], ""), "N"
    if units:
        wrong = [unit for unit, factor in zip(("N", "N m"), found.row) if factor != 1.0]
        why, sent = f": the driver has to send {' and '.join(wrong)}", found.unit
    return (
        f"with {' and '.join(found.settings)} the forces balance to {after:.2g} N instead of "
        f"{before:.2g} {sent}{why}"
    )


def changed(stated: WrenchInput, found: Hypothesis) -> dict[str, object]:
    """Return the fields in which a hypothesis differs from what is stated; for units none."""
    return {
        field.name: getattr(found.options, field.name)
        for field in fields(WrenchInput)
        if getattr(found.options, field.name) != getattr(stated, field.name)
    }
