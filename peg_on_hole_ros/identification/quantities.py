"""What a recording may tell of a cell, as coordinates of a search, and back."""

from dataclasses import replace
from math import asin, atan2, exp, log
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy, tilt_axes


class Quantity(NamedTuple):
    """
    One parameter that enters the innovations.

    Attributes
    ----------
    name, unit : str
    step : float
        For differences; far above rounding.
    range : float
        How far from the start the truth may lie, as a standard deviation.
    useful : float
        A standard deviation above this tells a cell nothing.
    log : bool
        The search is in its logarithm: step, range and useful are shares.

    Those of forces and torques are for a peg that is pressed by TYPICAL_FORCE into a hole of
    TYPICAL_DIAMETER, see `measures`.

    """

    name: str
    unit: str
    step: float
    range: float
    useful: float
    log: bool = False


CALIBRATED_QUANTITIES = (
    Quantity("friction", "", 1e-4, 0.5, 0.05),
    *(Quantity(f"bias_force_{axis}", "N", 2e-3, 20.0, 1.0) for axis in "xyz"),
    *(Quantity(f"bias_torque_{axis}", "N m", 1e-4, 1.0, 0.05) for axis in "xyz"),
    *(Quantity(f"tilt_{axis}", "rad", 5e-4, 0.05, 0.01) for axis in "xy"),
    Quantity("delay", "s", 2e-4, 0.02, 0.001),
    Quantity("clearance", "m", 1e-3, 0.3, 0.08, True),
    Quantity("force_stddev", "N", 0.02, 1.5, 0.3, True),
    Quantity("torque_stddev", "N m", 0.02, 1.5, 0.3, True),
    Quantity("position_stddev", "rad", 0.02, 1.5, 0.3, True),
)
QUANTITY_NAMES = tuple(quantity.name for quantity in CALIBRATED_QUANTITIES)
# What moves the peg, and what scatters the sensors.
IS_NOISE = np.array([name.endswith("stddev") for name in QUANTITY_NAMES])
IS_FORCE = np.array([name.startswith("bias_force") for name in QUANTITY_NAMES])
IS_TORQUE = np.array([name.startswith("bias_torque") for name in QUANTITY_NAMES])
# What steps, ranges and uses of forces and torques are stated for [N], [m].
TYPICAL_FORCE, TYPICAL_DIAMETER = 25.0, 0.05
# Where each stands among the coordinates.
FRICTION_AT, DELAY_AT, CLEARANCE_AT = 0, 9, 10
BIAS_AT, TILT_AT, NOISE_AT = slice(1, 7), slice(7, 9), slice(11, 14)


class SearchScales(NamedTuple):
    """
    Steps, ranges and uses of CALIBRATED_QUANTITIES for one peg under one load; see `Quantity`.

    Attributes
    ----------
    step, range, useful : ndarray, shape (14,)

    """

    step: np.ndarray
    range: np.ndarray
    useful: np.ndarray


def measures(diameter: float, force: float) -> SearchScales:
    """
    Return what is small, likely and of use for a hole of some diameter [m] and a load [N].

    Whether a bias tells a cell anything is a matter of the load it is beside, and a torque is a
    force at the rim: 0.05 N m, little beside 25 N on a peg of 50 mm, would turn one of 8 mm round.
    """
    rows = np.array([(one.step, one.range, one.useful) for one in CALIBRATED_QUANTITIES]).T
    rows[:, IS_TORQUE] *= diameter / TYPICAL_DIAMETER
    rows[2, IS_FORCE | IS_TORQUE] *= force / TYPICAL_FORCE
    return SearchScales(*rows)


def coordinates(configuration: Configuration) -> np.ndarray:
    """Return where the search starts, shape (14,); tilts are against the start."""
    scene, wrench, joints = configuration.scene, configuration.wrench, configuration.joints
    x = np.zeros(len(CALIBRATED_QUANTITIES))
    x[FRICTION_AT], x[DELAY_AT] = scene.friction, joints.delay
    x[BIAS_AT] = *wrench.bias_force, *wrench.bias_torque
    x[CLEARANCE_AT] = log(scene.hole_diameter - scene.peg_diameter)
    x[NOISE_AT] = np.log([wrench.force_stddev, wrench.torque_stddev, joints.position_stddev])
    return x


def natural(quantity: Quantity, coordinate: float) -> float:
    """Return a value from its coordinate in the search."""
    return exp(min(coordinate, 700.0)) if quantity.log else float(coordinate)


def configured(start: Configuration, x: np.ndarray) -> Configuration:
    """Return a configuration with coordinates put in."""
    value = [
        natural(quantity, coordinate) for quantity, coordinate in zip(CALIBRATED_QUANTITIES, x)
    ]
    force, torque, position = value[NOISE_AT]
    scene = replace(
        start.scene,
        friction=value[FRICTION_AT],
        peg_diameter=start.scene.hole_diameter - value[CLEARANCE_AT],
    )
    wrench = replace(
        start.wrench,
        bias_force=tuple(value[BIAS_AT][:3]),  # type: ignore[arg-type]
        bias_torque=tuple(value[BIAS_AT][3:]),  # type: ignore[arg-type]
        force_stddev=force,
        torque_stddev=torque,
    )
    joints = replace(start.joints, delay=value[DELAY_AT], position_stddev=position)
    if any(value[TILT_AT]):
        R_SH = tilt_axes(value[TILT_AT])
        scene = replace(scene, gravity=_turned(R_SH, scene.gravity))
        if joints.robot_gravity is not None:
            joints = replace(joints, robot_gravity=_turned(R_SH, joints.robot_gravity))
        R = rotation_from_rpy(joints.hole_rpy) @ R_SH
        rpy = atan2(R[2, 1], R[2, 2]), asin(-R[2, 0]), atan2(R[1, 0], R[0, 0])
        joints = replace(joints, hole_rpy=rpy)
    return replace(start, scene=scene, wrench=wrench, joints=joints)


def _turned(R_SH, gravity):
    """Return gravity in the axes of a hole that is turned, given it in those of the start."""
    return tuple((R_SH.T @ gravity).tolist())
