"""What a hand records of a new cell: three presses, and still poses of a peg with a payload."""

import numpy as np
from scipy.spatial.transform import Rotation

from arm import BENT, Arm, peg_rotation
from arm import JOINTS as ARM_JOINTS
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.messages.beside_estimates import joint_state
from small_bags import JOINTS, MS, WRENCH, joints, wrench

UP, X, Y = np.eye(3)[[2, 0, 1]]
G = np.array([0.0, 0.0, -9.80665])
SENSOR, CENTER = np.array([0.0, 0.0, 0.07]), np.array([0.0, 0.0, 0.035])
MASS, COM = 0.8, np.array([0.01, -0.02, 0.03])
BIAS = np.array([1.5, -2.0, 3.0, 0.04, -0.03, 0.02])
POSES = ([0.05, 0.0, 0.0], [0.5, 0.0, 0.3], [0.5, 1.6, 0.3], [0.6, -1.5, 1.0])


def presses(path, rpy, acts_on, pushes=(UP, X, Y), strength=25.0, seed=1, held=None):
    """
    Write what a sensor reads of a hanging peg that a hand pushes, 1 s each.

    By Newton: what holds the peg carries its weight, and the opposite of the hand. `held` are the
    angles at which it hangs, of which there are joint states; by `rpy` of None its numbers are in
    the axes of these.
    """
    random, t_ns = np.random.default_rng(seed), 10**9
    to_sensor = Rotation.from_euler("xyz", (0.0, 0.0, 0.0) if rpy is None else rpy).inv()
    if rpy is None:
        to_sensor = Rotation.from_matrix(peg_axes(np.array(held)))
    weight, zero = np.array([0.0, 0.0, -12.0]), np.array([3.0, -2.0, 5.0])
    with BagWriter(path) as bag:
        for push in pushes:
            for i in range(2500):
                hand = strength * np.sin(np.pi * min(max((i - 700) / 1000, 0.0), 1.0)) * push
                load = to_sensor.apply(-(weight + hand))
                read = (load if acts_on == "peg" else -load) + zero + random.normal(0, 0.5, 3)
                bag.write("/wrench", WRENCH, wrench(t_ns, read, [0.0] * 3), t_ns)
                if held and i % 10 == 0:
                    bag.write("/joint_states", JOINTS, joints(t_ns, held), t_ns)
                t_ns += MS
    return path


def poses(path, angles, sign=1.0, seed=1):
    """Write a peg of 0.5 kg with a payload, moved from pose to pose and held for 0.6 s."""
    random, t_ns = np.random.default_rng(seed), 10**9
    with BagWriter(path) as bag:
        for k, q in enumerate(angles):
            before = np.array(angles[max(k - 1, 0)])
            for i in range(1000):
                here = before + min(i / 400, 1.0) * (np.array(q) - before)
                R = peg_axes(here).T
                peg, payload = -0.5 * (R @ G), -MASS * (R @ G)
                force = peg + payload
                torque = np.cross(CENTER - SENSOR, peg) + np.cross(COM, payload)
                read = sign * np.r_[force, torque] + BIAS
                read += random.normal(0, [0.2] * 3 + [0.005] * 3)
                bag.write("/wrench", WRENCH, wrench(t_ns, read[:3], read[3:]), t_ns)
                if i % 2 == 0:
                    noise = random.normal(0, 1e-5, 3)
                    bag.write("/joint_states", JOINTS, joints(t_ns, here + noise), t_ns)
                t_ns += MS
    return path


def arm_poses(path, options, angles=POSES, in_base=False, seed=1):
    """
    Write a peg with a payload that an arm holds still at some angles, 0.6 s each.

    Weight is that along -z of the arm's root link, and the sensor sits on the peg. Its numbers
    are in its own axes, or in those of the root link.
    """
    random, t_ns, arm, q = np.random.default_rng(seed), 10**9, Arm(), BENT
    with BagWriter(path) as bag:
        for k, pose in enumerate(angles):
            before = np.array(angles[max(k - 1, 0)])
            for i in range(1000):
                here = before + min(i / 400, 1.0) * (np.array(pose) - before)
                if i <= 400:
                    q = arm.joints_at(np.zeros(3), peg_rotation(here), q, options, 1e-9)
                    R_RP = Rotation.from_euler("xyz", options.hole_rpy) * peg_rotation(here)
                peg, payload = (-mass * R_RP.inv().apply(G) for mass in (0.5, MASS))
                torque = np.cross(CENTER - SENSOR, peg) + np.cross(COM, payload)
                force = peg + payload + BIAS[:3] + random.normal(0, 0.2, 3)
                torque = torque + BIAS[3:] + random.normal(0, 0.005, 3)
                if in_base:
                    force, torque = R_RP.apply(force), R_RP.apply(torque)
                bag.write("/wrench", WRENCH, wrench(t_ns, force, torque), t_ns)
                if i % 4 == 0:
                    state = joint_state(t_ns, ARM_JOINTS, q + random.normal(0, 1e-5, 7))
                    bag.write("/joint_states", JOINTS, state, t_ns)
                t_ns += MS
    return path
