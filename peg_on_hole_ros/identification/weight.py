"""The weight of a peg that hangs still: where it pulls, and what is left beside the one stated."""

from math import acos, degrees
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.identification.payload import StillPoses
from peg_on_hole_ros.identification.tuned import STILL_POSE_TEST
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy


class Weight(NamedTuple):
    """
    What still poses tell of the direction of gravity, whatever is stated of it.

    Attributes
    ----------
    direction : ndarray, shape (3,)
        In hole axes, of length 1.
    off, off_stddev : float
        Between it and gravity as the settings have it [degrees].
    newtons : float
        What the weight contradicts that gravity by [N].
    left : float
        Root mean square of what no weight and zero explain [N].

    """

    direction: np.ndarray
    off: float
    off_stddev: float
    newtons: float
    left: float


def weight_of(poses: StillPoses, configuration: Configuration) -> Weight | None:
    """
    Return the direction of the weight by least squares, or None where the poses do not tell it.

    The forces are those of a weight that is fixed in the hole's axes, and of a zero that is fixed
    in the sensor's: 6 unknowns, and 3 equations a pose.
    """
    n = len(poses.counts)
    A = np.concatenate([-poses.R_SH, np.broadcast_to(np.eye(3), (n, 3, 3))], axis=2)
    A = A.reshape(-1, 6)
    y = (_sign(configuration) * poses.wrench[:, :3]).ravel()
    root = np.repeat(np.sqrt(poses.counts), 3) / configuration.wrench.force_stddev
    least = STILL_POSE_TEST.least_spread * np.sqrt(n)
    if 3 * n <= 6 or np.linalg.matrix_rank(A, tol=least) < 6:
        return None
    theta = np.linalg.lstsq(A * root[:, None], y * root, rcond=None)[0]
    left = (y - A @ theta) * root
    wider = max(float(left @ left) / (len(y) - 6), 1.0)
    covariance = wider * np.linalg.inv((A * root[:, None]).T @ (A * root[:, None]))
    pull, stated = theta[:3], np.array(configuration.scene.gravity)
    size, down = float(np.linalg.norm(pull)), stated / max(float(np.linalg.norm(stated)), 1e-9)
    direction = pull / size
    across = np.eye(3) - np.outer(direction, direction)
    spread = float(np.sqrt(np.trace(across @ covariance[:3, :3] @ across) / 2.0)) / size
    off = acos(min(max(float(direction @ down), -1.0), 1.0))
    newtons = float(np.linalg.norm(pull - (pull @ down) * down))
    apart = float(np.sqrt(np.mean((y - A @ theta) ** 2)))
    return Weight(direction, degrees(off), degrees(spread), newtons, apart)


class Zero(NamedTuple):
    """
    What an unloaded sensor reads, or how far that is from what is stated.

    Attributes
    ----------
    value, stddev : ndarray, shape (6,)
        As received, in sensor axes [N], [N m].

    """

    value: np.ndarray
    stddev: np.ndarray


def zero_of(poses: StillPoses, configuration: Configuration) -> Zero:
    """
    Return what an unloaded sensor reads, given the weight of peg and payload as stated.

    Its standard deviation is that of the noise, and of a payload that is known as well as
    `accuracy.payload_mass` says.
    """
    options, sign = configuration.wrench, _sign(configuration)
    left = poses.wrench - sign * hung_wrench(poses, configuration)
    noise = np.repeat([options.force_stddev, options.torque_stddev], 3)
    value = np.average(left, axis=0, weights=poses.counts)
    payload = 0.0
    if options.gravity == "measured":
        g = float(np.linalg.norm(configuration.scene.gravity))
        payload = configuration.accuracy.payload_mass * options.payload_mass * g
    doubt = payload * np.repeat([1.0, float(np.linalg.norm(options.payload_com))], 3)
    return Zero(value, np.sqrt(noise**2 / poses.counts.sum() + doubt**2))


def hung_wrench(poses: StillPoses, configuration: Configuration) -> np.ndarray:
    """Return what holds a still peg and its payload, at the sensor in its axes, shape (n, 6)."""
    options, scene = configuration.wrench, configuration.scene
    if options.gravity != "measured":
        return np.zeros((len(poses.counts), 6))
    R_SP = rotation_from_rpy(options.sensor_rpy).T
    peg = R_SP @ (np.array([0.0, 0.0, scene.mass_center_height]) - np.array(options.sensor_xyz))
    g = poses.gravity(configuration)
    parts = (scene.peg_mass, peg), (options.payload_mass, np.array(options.payload_com))
    force = -sum(mass for mass, _ in parts) * g
    torque = sum(np.cross(place, -mass * g) for mass, place in parts)
    return np.hstack([force, torque])


def _sign(configuration):
    """Return -1 where the numbers are what acts on the robot."""
    return -1.0 if configuration.wrench.acts_on == "robot" else 1.0
