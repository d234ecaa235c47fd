"""What else a wrench may mean than what is stated, each as the settings that state it."""

from collections.abc import Sequence
from dataclasses import fields, replace
from itertools import product
from math import log
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import WrenchInput
from peg_on_hole_ros.diagnosis.tuned import HYPOTHESIS_PRIORS
from peg_on_hole_ros.measurements.rotations import quarter_turns, rotation_from_rpy, rpy_of
from peg_on_hole_ros.number_text import quantity
from peg_on_hole_ros.typed_record import Matrix3, Record, new

_KN, _N_MM, _KN_M = (1e3, "kN"), (1e-3, "N mm"), (1e3, "kN m")
_UNITS = (
    {"force": _KN},
    {"torque": _N_MM},
    {"force": _KN, "torque": _N_MM},
    {"force": _KN, "torque": _KN_M},
)
# Left-handed axes that a driver may send, of force and torque alike. With the sign they are 6 of
# the 24 signed permutations that no turn of the sensor is; the others are a turn and the sign.
_LEFT_HANDED = {
    **{f"the {'xyz'[i]} axis mirrored": np.diag(1.0 - 2.0 * np.eye(3)[i]) for i in range(3)},
    **{
        f"the axes {'xyz'[i]} and {'xyz'[j]} exchanged": np.eye(3)[np.array(order)]
        for i, j, order in ((0, 1, (1, 0, 2)), (0, 2, (2, 1, 0)), (1, 2, (0, 2, 1)))
    },
}


class WrenchTransform(Record):
    """
    What a wrench may mean, for compiled code.

    Attributes
    ----------
    force_factor, torque_factor : float
        Of a wrong unit.
    in_base_axes, weight_removed : bool
    axes : shape (3, 3)
        To turn to, with the sign.

    """

    force_factor: float
    torque_factor: float
    in_base_axes: bool
    weight_removed: bool
    axes: Matrix3


class Hypothesis(NamedTuple):
    """
    What a wrench may mean.

    Attributes
    ----------
    options : WrenchInput
        That state it, but for units and left-handed axes, which have no setting.
    settings : tuple of str
        In which they differ from the stated ones, as `name: value`, or the units, or the axes.
    cost : float
        Before anything is measured [nats].
    meaning : WrenchTransform
    mirrored : str
        How its axes are left-handed, where that is what it means; else empty.
    left_handed : bool
        Whether its axes are, in whatever way it is stated.

    """

    options: WrenchInput
    settings: tuple[str, ...]
    cost: float
    meaning: WrenchTransform
    mirrored: str
    left_handed: bool


def hypotheses(stated: WrenchInput) -> list[Hypothesis]:
    """Return what a wrench may mean, what is stated first."""
    found = [_hypothesis(stated, stated)]
    R_PS = rotation_from_rpy(stated.sensor_rpy)
    of_sensor = stated.axes if stated.base_rpy is None else "sensor"
    for turn, robot, compensated in product(quarter_turns(), (False, True), (False, True)):
        rpy = stated.sensor_rpy
        if not np.array_equal(turn, np.eye(3)):
            rpy = tuple(round(angle, 6) + 0.0 for angle in rpy_of(R_PS @ turn))
        options = replace(stated, sensor_rpy=rpy, axes=of_sensor)  # type: ignore[arg-type]
        found.append(_hypothesis(stated, _meant(options, robot, compensated)))
    # Of links that are not turned against each other the first names them all.
    links = stated.base_links[::-1]
    for link, robot, compensated in product(links, (False, True), (False, True)):
        options = replace(stated, axes=link.name)
        found.append(_hypothesis(stated, _meant(options, robot, compensated)))
    for units in _UNITS:
        found.append(_hypothesis(stated, stated, units))
    robot = stated.acts_on == "robot"
    for name, compensated in product(_LEFT_HANDED, (False, True)):
        found.append(_hypothesis(stated, _meant(stated, robot, compensated), mirror=name))
    first = {hypothesis.settings: hypothesis for hypothesis in reversed(found)}
    distinct: dict[tuple[float, ...], Hypothesis] = {}
    for hypothesis in sorted(first.values(), key=lambda hypothesis: hypothesis.cost):
        # A mirrored axis is a turn with the other sign: the cheaper of the two stands for it.
        distinct.setdefault(_rounded(hypothesis.meaning), hypothesis)
    return list(distinct.values())


def _rounded(meaning):
    """Return a meaning as a key: those that are nearly the same have the same."""
    numbers = (
        meaning.force_factor, meaning.torque_factor, meaning.in_base_axes, meaning.weight_removed,
        *meaning.axes.ravel(),
    )  # fmt: skip
    return tuple((np.round(numbers, 4) + 0.0).tolist())


def _meant(options, robot, compensated):
    return replace(
        options,
        acts_on="robot" if robot else "peg",
        gravity="compensated" if compensated else "measured",
    )


def _hypothesis(stated, options, units=MappingProxyType({}), mirror=""):
    settings, spread = [mirror] if mirror else [], log(len(_LEFT_HANDED)) if mirror else 0.0
    for name in ("acts_on", "axes", "gravity"):
        value = getattr(options, name)
        if value != getattr(stated, name):
            settings.append(f"wrench.{name}: {value}")
    if options.sensor_rpy != stated.sensor_rpy:
        settings.append(f"wrench.sensor_rpy: {[round(angle, 4) for angle in options.sensor_rpy]}")
        # One of so many turns.
        spread = log(23)
    meaning = new(WrenchTransform)
    meaning.force_factor = meaning.torque_factor = 1.0
    for name, (factor, unit) in units.items():
        settings.append(f"{_UNIT} the {name} read as {unit}")
        setattr(meaning, f"{name}_factor", factor)
    meaning.in_base_axes = options.base_rpy is not None
    meaning.weight_removed = options.gravity == "compensated"
    axes = rotation_from_rpy(options.base_rpy or options.sensor_rpy)
    if mirror:
        axes = axes @ _LEFT_HANDED[mirror]
    meaning.axes[:] = -axes if options.acts_on == "robot" else axes
    one, more = HYPOTHESIS_PRIORS
    cost = one + more * (len(settings) - 1) + spread if settings else 0.0
    turned = options.sensor_rpy != stated.sensor_rpy and options.acts_on != stated.acts_on
    return Hypothesis(options, tuple(settings), cost, meaning, mirror, bool(mirror) or turned)


_UNIT = "unit of"
# What is wrong, by the first setting that would fit.
_WHAT = {
    "wrench.acts_on: robot": "the sign of the wrench is reversed",
    "wrench.acts_on: peg": "the sign of the wrench is reversed",
    "wrench.axes: base": "the wrench is in the axes of the robot's base, whatever frame_id is",
    "wrench.axes: sensor": "the wrench is in the axes of the sensor, not of the base",
    "wrench.gravity: compensated": "the weight seems to be subtracted from the wrench already",
    "wrench.gravity: measured": "the weight does not seem to be subtracted from the wrench",
    "unit of the force read as kN": "the force does not come in N",
    "unit of the torque read as kN m": "the torque does not come in N m",
    "unit of the torque read as N mm": "the torque does not come in N m",
    **dict.fromkeys(_LEFT_HANDED, "the wrench is in left-handed axes, which no setting mends"),
}
_MIRRORED = (
    "put the driver right, force and torque alike: {} (a wrong wrench.acts_on with a wrong "
    "sensor_rpy looks the same)"
)


def finding_text(found: Hypothesis, before: float, after: float, alike: Sequence[str] = ()) -> str:
    """
    Return in a line what is wrong.

    Parameters
    ----------
    found : Hypothesis
    before, after : float
        To how much forces balance as stated, and with it [N].
    alike : sequence of str
        Other left-handed axes that are about as likely.

    """
    what = _WHAT.get(found.settings[0], "")
    if not what and found.options.base_rpy is not None:
        what = f"the wrench is in the axes of {found.options.axes}, whatever frame_id is"
    settings = " or ".join([" and ".join(found.settings), *alike])
    if found.mirrored:
        remedy = _MIRRORED.format(settings)
    elif any(setting.startswith(_UNIT) for setting in found.settings):
        remedy = f"the driver has to send N and N m; {settings} fits"
    else:
        remedy = f"set {settings}"
    balance = f"{quantity(after, 'N', 2)} instead of {quantity(before, 'N', 2)}"
    what = what or "the axes of the wrench are not those that are stated"
    return f"{what}: {remedy}; with it the forces balance to {balance}"


def changed(stated: WrenchInput, found: Hypothesis) -> dict[str, object]:
    """Return the fields that would mend what is wrong; none for what the driver has to mend."""
    if found.mirrored:
        return {}
    return {
        field.name: getattr(found.options, field.name)
        for field in fields(WrenchInput)
        if getattr(found.options, field.name) != getattr(stated, field.name)
    }
