"""Drawn arms with a wrist: their description, and the joints that hold a peg on its way."""

from typing import NamedTuple

import numpy as np

from benchmarks.harness.draw import Draw
from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy, rpy_of
from peg_on_hole_ros.robot.kinematics import UrdfKinematics
from peg_on_hole_ros.robot.urdf_file import read_chain

JOINTS = tuple(f"j{i}" for i in range(1, 7))
# Of a wrist of three axes that meet, and of one of parallel and crossed ones.
AXES = {"meeting": ("z", "y", "y", "x", "y", "x"), "crossed": ("z", "y", "y", "y", "z", "y")}
# Links of the base: the root alone, one turned by half a turn, or a `world` that it stands on.
BASES = ("plain", "turned", "world")


class Arm(NamedTuple):
    """
    An arm, and where its tool is.

    Attributes
    ----------
    urdf : str
    base_axes : ndarray, shape (3, 3)
        Axes in which a driver sends a wrench of the base, in those of the root link.
    stands : ndarray, shape (4, 4)
        The arm's foot in the root link.
    tool : float
        From the last link to the tool [m].

    """

    urdf: str
    base_axes: np.ndarray
    stands: np.ndarray
    tool: float


def drawn_arm(draw: Draw, base: str, wrist: str) -> Arm:
    """Return an arm of some build, whose tool is turned about the axis of its last joint."""
    x, y, z = np.eye(3)
    side = z if wrist == "meeting" else y
    steps = [
        draw.even(0.30, 0.45) * z,
        draw.even(0.0, 0.08) * x,
        draw.even(0.42, 0.55) * z,
        draw.even(0.05, 0.12) * x + draw.even(0.0, 0.05) * z,
        draw.even(0.33, 0.42) * x,
        draw.even(0.07, 0.10) * (x if wrist == "meeting" else side),
    ]
    tool = draw.even(0.08, 0.16)
    world = np.eye(4)
    lines, parent, base_axes = [], "base_link", np.eye(3)
    if base == "turned":
        base_axes = np.diag([-1.0, -1.0, 1.0])
        lines.append(_joint("base_mount", "base_link", "base", np.zeros(3), (0.0, 0.0, np.pi)))
    elif base == "world":
        rpy = (0.0, 0.0, draw.even(-3.0, 3.0))
        world[:3, :3] = rotation_from_rpy(rpy)
        world[:3, 3] = [draw.even(-1, 1), draw.even(-1, 1), draw.even(0.5, 1.0)]
        lines.append(_joint("foot", "world", "base_link", world[:3, 3], rpy))
    for i, (step, axis) in enumerate(zip(steps, AXES[wrist])):
        lines.append(_joint(JOINTS[i], parent, f"l{i + 1}", step, (0.0, 0.0, 0.0), axis))
        parent = f"l{i + 1}"
    out = x if wrist == "meeting" else y
    turned = draw.even(0.3, 1.2) * draw.sign()
    lines.append(_joint("tool_mount", parent, "gripper_tcp", tool * out, tuple(turned * out)))
    links = ["base_link", *(f"l{i + 1}" for i in range(6)), "gripper_tcp"]
    links += {"plain": [], "turned": ["base"], "world": ["world"]}[base]
    text = "\n".join([*(f'<link name="{link}"/>' for link in links), *lines])
    return Arm(f'<robot name="own">\n{text}\n</robot>\n', base_axes, world, tool)


def _joint(name, parent, child, xyz, rpy, axis=""):
    kind = "revolute" if axis else "fixed"
    turns = ""
    if axis:
        vector = " ".join(str(int(axis == each)) for each in "xyz")
        turns = (
            f'<axis xyz="{vector}"/><limit lower="-6.28" upper="6.28" effort="100" velocity="3"/>'
        )
    places = " ".join(f"{value:.9g}" for value in xyz), " ".join(f"{a:.9g}" for a in rpy)
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{places[0]}" rpy="{places[1]}"/>{turns}</joint>'
    )


def along_last_axis(wrist: str, draw: Draw) -> tuple[float, float, float]:
    """Return a `peg_rpy` whose peg points out of the gripper, turned about itself somehow."""
    out = np.eye(3)[0 if wrist == "meeting" else 1]
    # The peg's z points up its axis, into the gripper.
    side = np.array([0.0, 0.0, 1.0])
    R = np.column_stack([np.cross(side, -out), side, -out]) @ rotation_from_rpy(
        (0.0, 0.0, draw.even(-3.0, 3.0))
    )
    return rpy_of(R)


class NoJoints(ArithmeticError):
    """An arm does not reach a pose, or its peg does not go in: another is drawn."""


def joints_of(joints: JointInput, peg: np.ndarray, place: np.ndarray, draw: Draw) -> np.ndarray:
    """
    Return joints that hold the peg on a path, by Newton's method from one pose to the next.

    Parameters
    ----------
    joints : JointInput
    peg : ndarray, shape (n, 3, 3)
        Peg axes in those of the hole.
    place : ndarray, shape (n, 3)
        Of the peg's lower end in the hole [m].
    draw : Draw

    Raises
    ------
    NoJoints
        The arm does not reach.

    """
    arm = UrdfKinematics(read_chain(joints), joints)
    R_RH, R_TP = rotation_from_rpy(joints.hole_rpy), rotation_from_rpy(joints.peg_rpy)
    R_RT = R_RH @ peg @ R_TP.T
    tip = np.array(joints.hole_xyz) + place @ R_RH.T - R_RT @ np.array(joints.peg_xyz)
    for _ in range(40):
        q = np.array([draw.even(-1, 1) for _ in range(6)]) * [3.0, 0.6, 1.5, 1.5, 1.5, 1.5]
        q = q + [0.0, 0.4, 0.5, 0.0, 0.7, 0.0]
        try:
            path = [q := _reach(arm, q, R_RT[0], tip[0], 60)]
            for R, p in zip(R_RT[1:], tip[1:]):
                path.append(q := _reach(arm, q, R, p, 8))
        except NoJoints:
            continue
        # Far from where two joints do one turn, and from their limits.
        singular = np.linalg.svd(_jacobian(arm, path[0])[1])[1][-1]
        if np.abs(path).max() < 6.2 and singular > 0.05:
            return np.array(path)
    raise NoJoints("the arm does not reach the hole")


def _jacobian(arm, q):
    poses = arm.poses(q[None])
    return poses, np.vstack([poses.velocities[0], poses.jacobian[0]])


def _reach(arm, q, R, p, steps):
    for _ in range(steps):
        poses, J = _jacobian(arm, q)
        turn = R @ poses.rotation[0].T
        # Twice the sine of the angle, about its axis: half of it near the goal.
        w = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        error = np.concatenate([p - poses.position[0], 0.5 * w])
        if np.abs(error).max() < 1e-9 and turn.trace() > 2.9:
            return q
        step = np.linalg.lstsq(J, error, rcond=1e-6)[0]
        q = q + step * min(1.0, 0.4 / max(np.abs(step).max(), 1e-12))
    raise NoJoints("a pose is not reached")
