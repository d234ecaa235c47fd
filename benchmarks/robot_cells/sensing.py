"""What the robot of a cell would have sent: its rate, filter, noise, zero, axes and signs."""

from dataclasses import dataclass

import numpy as np

from benchmarks.robot_cells.arms import Arm
from benchmarks.robot_cells.rows import GRAVITY, PEG_MASS, Rows


@dataclass(frozen=True)
class Driver:
    """
    How a robot sends its wrench and its joints.

    Attributes
    ----------
    every : int
        Milliseconds between two messages; the wrench is the mean over them.
    force_noise, torque_noise : float
        White, of one message [N], [N m].
    zero : tuple of 6 float
        What an unloaded sensor reads [N], [N m].
    wander : float
        Standard deviation of the forces' zero as it wanders, with a memory of 2 s [N].
    low_pass : float
        Of first order, before the noise [Hz]; 0: none.
    compensated : bool
        Whether the weight of what hangs below is taken off, by values that are 1 % and 2 mm off.
    joint_noise, joint_step : float
        White, and the encoder's step [rad].
    frame : str
        frame_id of the wrench.
    base : bool
        Whether the numbers are in the base's axes.
    seed : int

    """

    every: int
    force_noise: float
    torque_noise: float
    zero: tuple
    wander: float
    low_pass: float
    compensated: bool
    joint_noise: float
    joint_step: float
    frame: str = "ft_sensor"
    base: bool = False
    seed: int = 1


# The force of a robot's own sensor or observer is that on the robot, in all of them.
UR_LIKE = Driver(
    2, 1.5, 0.05, (0.4, -0.3, 0.6, 0.01, 0.02, 0.0), 0.0, 0.0, True, 2e-5, 0.0, seed=11
)
UR_LIKE_BASE = Driver(
    2, 1.5, 0.05, (0.4, -0.3, 0.6, 0.01, 0.02, 0.0), 0.0, 0.0, True, 2e-5, 0.0, "tool0", True, 12
)
FRANKA_LIKE = Driver(
    1, 0.3, 0.02, (0.5, 0.5, -0.8, 0.02, -0.03, 0.01), 0.3, 100.0, True, 1e-5, 0.0, seed=13
)
IIWA_LIKE = Driver(
    5, 0.3, 0.01, (1.0, -2.0, 0.5, 0.02, 0.0, -0.01), 0.0, 80.0, False, 0.0, 4e-5, seed=14
)


@dataclass(frozen=True)
class Sent:
    """
    What is sent, one row a message.

    Attributes
    ----------
    rows : ndarray of int, shape (n,)
        Places of the messages in the rows of the run.
    wrench : ndarray, shape (n, 6)
        [N], [N m]
    joints : ndarray, shape (n, joints)
        [rad]

    """

    rows: np.ndarray
    wrench: np.ndarray
    joints: np.ndarray


def sent(rows: Rows, arm: Arm, driver: Driver) -> Sent:
    """Return what a robot sends of a run."""
    rng = np.random.default_rng(driver.seed)
    # On the robot; MuJoCo reports that on the peg's side.
    wrench = -rows.sensor
    if driver.compensated:
        wrench -= weight_taken_off(rows.axes, arm)
    if driver.low_pass:
        share = 1.0 - np.exp(-2 * np.pi * driver.low_pass * 1e-3)
        for k in range(1, len(wrench)):
            wrench[k] = wrench[k - 1] + share * (wrench[k] - wrench[k - 1])
    ends = np.arange(driver.every - 1, len(rows.t), driver.every)
    mean = np.stack([wrench[ends - k] for k in range(driver.every)]).mean(axis=0)
    mean += driver.zero
    mean += rng.normal(size=mean.shape) * np.repeat([driver.force_noise, driver.torque_noise], 3)
    if driver.wander:
        keep = np.exp(-driver.every * 1e-3 / 2.0)
        zero = np.zeros(3)
        for row in mean:
            zero = keep * zero + driver.wander * np.sqrt(1 - keep**2) * rng.normal(size=3)
            row[:3] += zero
    if driver.base:
        axes = rows.axes[ends]
        for part in (slice(0, 3), slice(3, 6)):
            mean[:, part] = np.einsum("nij,nj->ni", axes, mean[:, part])
    joints = rows.drives[ends] + driver.joint_noise * rng.normal(size=(len(ends), len(arm.joints)))
    if driver.joint_step:
        joints = driver.joint_step * np.round(joints / driver.joint_step)
    return Sent(ends, mean, joints)


def weight_taken_off(axes, arm):
    """Return what the controller takes the weight of gripper and peg for, sensor axes, (n, 6)."""
    mass = 1.01 * (arm.gripper_mass + PEG_MASS)
    (x, y, z), _ = arm.tool
    peg = np.array([x, y, z + arm.peg_in_tool - 0.035])
    com = (arm.gripper_mass * np.array(arm.gripper_com) + PEG_MASS * peg) / (
        arm.gripper_mass + PEG_MASS
    )
    force = np.einsum("nji,j->ni", axes, [0.0, 0.0, -mass * GRAVITY])
    return np.hstack([force, np.cross(com + [0.002, 0.0, 0.0], force)])
