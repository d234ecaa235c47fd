"""Bags in which an arm holds the peg: a sample bag with the arm's joints for the peg's angles."""

import numpy as np

from arm import BENT, JOINTS, OPTIONS, Arm, peg_rotation
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.config.configuration import from_parameters, to_parameters
from peg_on_hole_ros.messages.beside_estimates import JOINT_STATE, STRING, joint_state
from peg_on_hole_ros.messages.beside_estimates import WRENCH as WRENCH_TYPE
from peg_on_hole_ros.messages.plain import header
from peg_on_hole_ros.replay.run import stored_configuration

TRUTH_STATE, TRUTH_MODE = "/truth/state", "/truth/contact_mode"
FIELDS = ("source", "names", "position_stddev", "urdf", "tip_frame")
FRAMES = ("peg_xyz", "peg_rpy", "hole_xyz", "hole_rpy")


def robot_configuration(source, joints=OPTIONS):
    """The configuration of a bag, with an arm to read the angles from."""
    parameters = to_parameters(stored_configuration(Bag(source)))
    parameters |= {f"joints.{name}": getattr(joints, name) for name in FIELDS + FRAMES}
    # The wrench is that of a sensor on the peg, whatever link of the arm has the name, and gravity
    # that of the sample, along the axis of a hole that leans here.
    stated = {"wrench.sensor_pose": "stated", "joints.gravity_link": "stated"}
    return from_parameters(parameters | stated)


def arm_path(q, tolerance=1e-9):
    """Joints of the arm, shape (n, 7), that hold the peg in the mouth of the hole at angles q."""
    arm, joints, path = Arm(), BENT, []
    for angles in q:
        joints = arm.joints_at(np.zeros(3), peg_rotation(angles), joints, tolerance=tolerance)
        path.append(joints)
    return np.array(path)


def write_robot_bag(path, source, seed):
    """
    Copy a bag's wrenches and truth; for the peg's angles put the arm's joints at the true ones.

    Every joint has its noise. The order of the joints is the driver's own, a finger among them is
    not measured, and the gripper's driver publishes on the same topic.

    Returns
    -------
    (int, int)
        Joint states of the arm, and of the gripper.

    """
    bag, rng = Bag(source), np.random.default_rng(seed)
    states = list(bag.messages(["/joint_states"]))
    truth = {row.log_ns: row.message.position for row in bag.messages([TRUTH_STATE])}
    joints = arm_path(truth[row.log_ns] for row in states)
    read = iter(joints + rng.normal(0, OPTIONS.position_stddev, joints.shape))
    order = [2, 6, 0, 5, 1, 4, 3]
    names = ["finger_right", *(JOINTS[i] for i in order)]
    count = 0
    with BagWriter(path, robot_configuration(source)) as writer:
        for topic, t_ns, message in bag.messages(bag.topics):
            if topic == "/joint_states":
                state = joint_state(t_ns, names, [np.nan, *next(read)[order]])
                writer.write(topic, JOINT_STATE, state, t_ns)
                if count % 5 == 0:
                    state = joint_state(t_ns, ["finger_left"], [0.01])
                    writer.write(topic, JOINT_STATE, state, t_ns)
                count += 1
            elif topic == "/wrench":
                sides = message.wrench.force, message.wrench.torque
                force, torque = ({c: getattr(side, c) for c in "xyz"} for side in sides)
                wrench = {"force": force, "torque": torque}
                fields = {"header": header(t_ns, "ft_sensor"), "wrench": wrench}
                writer.write(topic, WRENCH_TYPE, fields, t_ns)
            elif topic == TRUTH_MODE:
                writer.write(topic, STRING, {"data": message.data}, t_ns)
            else:
                row = message.name, message.position, message.velocity, message.effort
                writer.write(topic, JOINT_STATE, joint_state(t_ns, *row), t_ns)
    return count, (count + 4) // 5
