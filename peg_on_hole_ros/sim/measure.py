"""What the sensors say of a truth: wrench and orientation, with noise from a seed."""

from collections.abc import Iterator
from heapq import merge

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.sim.dynamics import rotation
from peg_on_hole_ros.sim.truth import Truth

# Stamp of the first sample: 2026-01-01T00:00:00Z, so that stamps are as long as real ones [ns].
START_NS = 1_767_225_600 * 10**9


def sensor_axes(rpy: ArrayLike) -> np.ndarray:
    """Return the sensor's axes in peg axes, Rz(yaw) Ry(pitch) Rx(roll), shape (3, 3)."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy), np.cos(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def sensor_wrench(truth: Truth) -> np.ndarray:
    """
    Return force and torque at the sensor origin in sensor axes, without noise, shape (n, 6).

    The payload between sensor and peg is a point mass that moves with the peg: the sensor reads
    what it takes to carry and accelerate it on top. The sign is that of `wrench.acts_on`.

    """
    settings, scene = truth.plan.configuration.wrench, truth.plan.configuration.scene
    R_PS = sensor_axes(settings.sensor_rpy)
    sensor_P = np.asarray(settings.sensor_xyz) - [0, 0, scene.mass_center_height]
    payload_P = sensor_P + R_PS @ settings.payload_com
    out = np.empty((len(truth.t_ns), 6))
    for i, q in enumerate(truth.q):
        R_HP = rotation(q)
        F, M = truth.force[i], truth.moment[i]
        lever = R_HP @ sensor_P
        torque = M - np.cross(lever, F)
        if settings.payload_mass:
            arm = R_HP @ payload_P
            carried = settings.payload_mass * (
                _point_acceleration(truth, i, arm) - np.asarray(scene.gravity)
            )
            F = F + carried
            torque = torque + np.cross(arm - lever, carried)
        R_SH = (R_HP @ R_PS).T
        out[i, :3], out[i, 3:] = R_SH @ F, R_SH @ torque
    return out if settings.acts_on == "peg" else -out


def _point_acceleration(truth, i, arm):
    """Return the acceleration of a point of the peg at `arm` from the mass centre, hole axes."""
    # Not from the angles: psi and phi of an upright peg have no rates.
    w, alpha = truth.turning[i]
    return truth.centre[i, 2] + np.cross(alpha, arm) + np.cross(w, np.cross(w, arm))


def measured_angles(
    q: np.ndarray, error: np.ndarray, R_MH: np.ndarray | None = None
) -> np.ndarray:
    """
    Return gamma, psi, phi of orientations turned by small errors, exactly through R_HP.

    Parameters
    ----------
    q : ndarray, shape (n, 3)
        [rad]
    error : ndarray, shape (n, 3)
        Rotation vectors in peg axes [rad].
    R_MH : ndarray, shape (3, 3), optional
        Hole axes in those that the angles are measured in; None: the same.

    Returns
    -------
    ndarray, shape (n, 3)
        psi and phi within (-pi, pi].

    """
    out = np.empty_like(q)
    for i, (angles, w) in enumerate(zip(q, error, strict=True)):
        R = rotation(angles) @ _exponential(w)
        R = R if R_MH is None else R_MH @ R
        out[i, 0] = np.arctan2(np.hypot(R[2, 0], R[2, 1]), R[2, 2])
        out[i, 1] = np.arctan2(-R[1, 2], -R[0, 2])
        out[i, 2] = np.arctan2(-R[2, 1], R[2, 0])
    # arctan2 gives -pi for a negative zero.
    out[:, 1:] = np.where(out[:, 1:] <= -np.pi, np.pi, out[:, 1:])
    return out


def _exponential(w):
    angle = np.linalg.norm(w)
    K = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    a = np.sinc(angle / np.pi)
    b = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    return np.eye(3) + a * K + b * K @ K


def measure(
    truth: Truth,
    seed: int | None = None,
    start_ns: int = START_NS,
    exact: np.ndarray | None = None,
) -> Iterator[WrenchSample | JointSample]:
    """
    Yield the samples in the order of their stamps; of one stamp the joints come first.

    Parameters
    ----------
    truth : Truth
    seed : int, optional
        Of the noise; None is the plan's own.
    start_ns : int
        Stamp of the first sample [ns].
    exact : ndarray, optional
        What `sensor_wrench` gives for this truth, where it is known already.

    Notes
    -----
    Wrench: the bias, and white noise of force_stddev and torque_stddev on every component.
    Orientation: a rotation of the peg by a vector of three independent components of
    position_stddev, in axes in which the hole's are turned by hole_rpy, stamped late by delay.

    """
    plan = truth.plan
    settings, joints = plan.configuration.wrench, plan.configuration.joints
    wrench_noise, joint_noise = np.random.default_rng(plan.seed if seed is None else seed).spawn(2)
    n, every = len(truth.t_ns), plan.wrench_rate // plan.joint_rate
    stddev = np.repeat([settings.force_stddev, settings.torque_stddev], 3)
    exact = sensor_wrench(truth) if exact is None else exact
    wrench = exact + wrench_noise.normal(size=(n, 6)) * stddev
    wrench += [*settings.bias_force, *settings.bias_torque]
    q = truth.q[::every]
    R_MH = sensor_axes(joints.hole_rpy) if any(joints.hole_rpy) else None
    errors = joint_noise.normal(size=q.shape) * joints.position_stddev
    angles = measured_angles(q, errors, R_MH)
    names = tuple(joints.names)
    late_ns = start_ns + round(joints.delay * 1e9)
    yield from merge(  # type: ignore[misc]
        (
            JointSample(late_ns + int(t_ns), names, tuple(row.tolist()))
            for t_ns, row in zip(truth.t_ns[::every], angles)
        ),
        (
            WrenchSample(start_ns + int(t_ns), tuple(row[:3].tolist()), tuple(row[3:].tolist()))
            for t_ns, row in zip(truth.t_ns, wrench)
        ),
        key=lambda sample: sample.t_ns,  # type: ignore[attr-defined]
    )
