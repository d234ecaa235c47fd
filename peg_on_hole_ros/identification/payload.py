"""What hangs below the sensor, and the sensor's zero, from poses at which a free peg is still."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.identification.recording import Recording, in_sensor_axes, motion
from peg_on_hole_ros.identification.tuned import STILL_POSE_TEST
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy
from peg_on_hole_ros.mechanics.reference import peg_axes


class Payload(NamedTuple):
    """
    What still poses tell.

    Attributes
    ----------
    poses : int
    mass, mass_stddev : float
        Payload's, without the peg [kg].
    com, com_stddev : ndarray, shape (3,)
        Its mass centre in the sensor frame [m]; NaN where its mass is nothing.
    bias, bias_stddev : ndarray, shape (6,)
        What the unloaded sensor reads, as received [N], [N m].
    left : float
        Root mean square of what is left of the forces [N].
    missing : tuple of str
        Poses that would tell what these do not, a sentence each.

    """

    poses: int
    mass: float
    mass_stddev: float
    com: np.ndarray
    com_stddev: np.ndarray
    bias: np.ndarray
    bias_stddev: np.ndarray
    left: float
    missing: tuple[str, ...]


class StillPoses(NamedTuple):
    """
    Poses at which a free peg is still.

    Attributes
    ----------
    R_SH : ndarray, shape (n, 3, 3)
        Hole axes in those of the sensor.
    wrench : ndarray, shape (n, 6)
        Means as the sensor reads them, sensor axes [N], [N m].
    counts : ndarray of int, shape (n,)
        Of how many wrenches each is the mean.

    """

    R_SH: np.ndarray
    wrench: np.ndarray
    counts: np.ndarray

    def gravity(self, configuration: Configuration) -> np.ndarray:
        """Return gravity in sensor axes, shape (n, 3) [m/s^2]."""
        return self.R_SH @ np.array(configuration.scene.gravity)


def find_payload(record: Recording, configuration: Configuration) -> Payload:
    """
    Return payload and zero by least squares; what hangs is free at every still pose.

    Parameters
    ----------
    record : Recording
    configuration : Configuration
        With the peg's own mass and mass centre, the sensor's axes and noise.

    Raises
    ------
    PegOnHoleError
        There is no still pose, or all have one direction of gravity.

    """
    poses = still_poses(record, configuration)
    return payload_of(poses.gravity(configuration), poses.wrench, poses.counts, configuration)


def payload_of(
    g_S: np.ndarray, wrench: np.ndarray, count: np.ndarray, configuration: Configuration
) -> Payload:
    """
    Return the same from still poses.

    Parameters
    ----------
    g_S : ndarray, shape (n, 3)
        Gravity in sensor axes [m/s^2].
    wrench : ndarray, shape (n, 6)
        Means as the sensor reads them, sensor axes [N], [N m].
    count : ndarray of int, shape (n,)
        Of how many wrenches each is the mean.
    configuration : Configuration

    Raises
    ------
    PegOnHoleError
        All have one direction of gravity.

    """
    options, scene = configuration.wrench, configuration.scene
    spread, axes = _spread(g_S)
    if spread[0] < STILL_POSE_TEST.least_spread:
        raise PegOnHoleError(
            "tilt the peg by 20 degrees and more between still poses: "
            f"{len(g_S)} with one direction of gravity in the sensor's axes do not distinguish "
            "weight from bias"
        )
    A, y, weight = _equations(g_S, wrench, count, options)
    # Nothing beyond what a robot carries: it keeps what is not told finite.
    prior = np.array([10.0, 2.0, 2.0, 2.0, *[100.0] * 3, *[10.0] * 3])
    root = A * weight[:, None]
    information = root.T @ root + np.diag(prior**-2.0)
    theta = np.linalg.solve(information, root.T @ (y * weight))
    left = y - A @ theta
    free = max(len(y) - len(theta), 1)
    wider = max(float(np.sum((left * weight) ** 2)) / free, 1.0)
    covariance = np.linalg.inv(information) * wider
    # What two directions of gravity do not tell: a moment of mass along their difference.
    along = axes[0]
    unknown = np.sqrt(along @ covariance[1:4, 1:4] @ along) / max(theta[0], 1e-3)
    missing = ()
    if unknown > STILL_POSE_TEST.center_stddev:
        axis = "xyz"[int(np.argmax(np.abs(along)))]
        missing = (
            "tilt the peg about another axis too, by 20 degrees: gravity turned about one axis "
            f"only, and the mass centre along {axis} of the sensor is known to {unknown:.2g} m",
        )
    force = left.reshape(-1, 6)[:, :3]
    payload = _without_peg(theta, covariance, scene, options)
    zero = _bias(theta, covariance, options)
    return Payload(len(g_S), *payload, *zero, float(np.sqrt(np.mean(force**2))), missing)  # type: ignore[call-arg]


def still_poses(record: Recording, configuration: Configuration) -> StillPoses:
    """
    Return the poses at which the peg is still for long enough.

    Raises
    ------
    PegOnHoleError
        There is none.

    """
    moved = motion(record)
    gamma, still = moved.q[:, 0], STILL_POSE_TEST.still_rate
    slow = np.abs(moved.rates[:, 0]) < still
    # psi and phi turn about axes that are gamma apart; each alone is noise near the upright.
    slow &= np.abs(np.sin(gamma) * moved.rates[:, 1]) < still
    slow &= np.abs(moved.rates[:, 2] + np.cos(gamma) * moved.rates[:, 1]) < still
    slow &= moved.valid
    edges = np.flatnonzero(np.diff(np.r_[False, slow, False].astype(int)))
    R_SP = rotation_from_rpy(configuration.wrench.sensor_rpy).T
    axes, means, counts = [], [], []
    t, wrench = record.joint_t - configuration.joints.delay, in_sensor_axes(record, configuration)
    for begin, end in zip(edges[::2], edges[1::2]):
        if t[end - 1] - t[begin] < STILL_POSE_TEST.shortest:
            continue
        at = (record.wrench_t >= t[begin]) & (record.wrench_t <= t[end - 1])
        if not at.any():
            continue
        R_HP = peg_axes(moved.q[begin:end].mean(axis=0))
        axes.append(R_SP @ R_HP.T)
        means.append(wrench[at].mean(axis=0))
        counts.append(int(at.sum()))
    if not axes:
        raise PegOnHoleError(
            "hang the peg free and still at three tilts or more, for half a second each: the "
            f"recording has no pose of {STILL_POSE_TEST.shortest:g} s below "
            f"{STILL_POSE_TEST.still_rate:g} rad/s"
        )
    return StillPoses(np.array(axes), np.array(means), np.array(counts))


def _spread(g_S):
    """Return how far gravity's direction spreads, largest first, and along which axes."""
    direction = g_S / np.linalg.norm(g_S, axis=1)[:, None]
    _, sizes, axes = np.linalg.svd(direction - direction.mean(axis=0), full_matrices=True)
    sizes = np.r_[sizes, np.zeros(3)][:3] / np.sqrt(len(g_S))
    return sizes, axes


def _equations(g_S, wrench, count, options):
    """Return matrix, right side and weights of the least squares, six rows a pose."""
    sign = -1.0 if options.acts_on == "robot" else 1.0
    A = np.zeros((len(g_S), 6, 10))
    x, y, z = g_S.T
    A[:, :3, 0] = -g_S
    # Gravity crosses the moment of mass.
    A[:, 3, 2], A[:, 3, 3] = -z, y
    A[:, 4, 1], A[:, 4, 3] = z, -x
    A[:, 5, 1], A[:, 5, 2] = -y, x
    A[:, range(6), range(4, 10)] = 1.0
    noise = np.array([options.force_stddev] * 3 + [options.torque_stddev] * 3)
    weight = np.sqrt(count)[:, None] / noise
    return A.reshape(-1, 10), (sign * wrench).ravel(), weight.ravel()


def _without_peg(theta, covariance, scene, options):
    """Return mass and mass centre of what hangs beside the peg, each with its spread."""
    R_SP = rotation_from_rpy(options.sensor_rpy).T
    peg = R_SP @ (np.array([0.0, 0.0, scene.mass_center_height]) - np.array(options.sensor_xyz))
    mass = float(theta[0]) - scene.peg_mass
    stddev = np.sqrt(np.diagonal(covariance))
    if mass < STILL_POSE_TEST.significance * stddev[0]:
        return mass, stddev[0], np.full(3, np.nan), np.full(3, np.nan)
    com = (theta[1:4] - scene.peg_mass * peg) / mass
    slope = np.hstack([-com[:, None], np.eye(3)]) / mass
    spread = np.sqrt(np.diagonal(slope @ covariance[:4, :4] @ slope.T))
    return mass, stddev[0], com, spread


def _bias(theta, covariance, options):
    sign = -1.0 if options.acts_on == "robot" else 1.0
    return sign * theta[4:], np.sqrt(np.diagonal(covariance))[4:]
