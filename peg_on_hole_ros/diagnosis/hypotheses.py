"""What else a wrench may mean than what is stated, each as the settings that would say so."""

from dataclasses import fields, replace
from itertools import product
from math import log
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import WrenchInput
from peg_on_hole_ros.measurements.measurement import rotation_from_rpy
from peg_on_hole_ros.measurements.rotations import quarter_turns, rpy_of

# What a wrong setting costs before anything is measured, and each beside it [nats].
ONE_WRONG, MORE_WRONG = 3.0, 6.0
_KN, _N_MM, _KN_M = (1e3, "kN"), (1e-3, "N mm"), (1e3, "kN m")
_UNITS = (
    {"force": _KN},
    {"torque": _N_MM},
    {"force": _KN, "torque": _N_MM},
    {"force": _KN, "torque": _KN_M},
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

    """

    options: WrenchInput
    settings: tuple[str, ...]
    cost: float
    row: np.ndarray


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


def _hypothesis(stated, options, units=MappingProxyType({})):
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
    row[:2] = 1.0
    for name, (factor, unit) in units.items():
        settings.append(f"unit of the {name} read as {unit}")
        row[0 if name == "force" else 1] = factor
    row[2], row[3] = options.axes == "base", options.gravity == "compensated"
    axes = np.eye(3) if options.axes == "base" else rotation_from_rpy(options.sensor_rpy)
    row[4:] = (-axes if options.acts_on == "robot" else axes).ravel()
    cost = ONE_WRONG + MORE_WRONG * (len(settings) - 1) + spread if settings else 0.0
    return Hypothesis(options, tuple(settings), cost, row)


_WHY = {
    "wrench.acts_on: robot": ": robot would fit, the sign of the wrench is reversed",
    "wrench.acts_on: peg": ": peg would fit, the sign of the wrench is reversed",
    "wrench.axes: base": ": its numbers are in the axes of the robot's base, whatever frame_id is",
    "wrench.axes: sensor": ": its numbers are in the axes of the sensor, not of the base",
    "wrench.gravity: compensated": ": the weight seems to be taken off already",
    "wrench.gravity: measured": ": the weight does not seem to be taken off",
    "unit of the force read as kN": ": the driver has to send N",
    "unit of the torque read as N mm": ": the driver has to send N m",
}


def said(found: Hypothesis, before: float, after: float) -> str:
    """Return in a line what is wrong; to how much forces balance before and after [N]."""
    why = _WHY.get(found.settings[0], "")
    return (
        f"with {' and '.join(found.settings)} the forces balance to {after:.2g} N instead of "
        f"{before:.2g} N{why}"
    )


def changed(stated: WrenchInput, found: Hypothesis) -> dict[str, object]:
    """Return the fields in which a hypothesis differs from what is stated; for units none."""
    return {
        field.name: getattr(found.options, field.name)
        for field in fields(WrenchInput)
        if getattr(found.options, field.name) != getattr(stated, field.name)
    }
