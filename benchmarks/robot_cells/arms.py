"""Arms of the usual builds, of numbers of their own: their URDF, and their model in MuJoCo."""

from typing import NamedTuple

import numpy as np

Q = np.pi / 2


class Step(NamedTuple):
    """
    A joint, which turns about z, and its link.

    Attributes
    ----------
    xyz, rpy : tuple of 3 float
        In the link before [m], [rad].
    mass : float
        Of the link [kg].
    com : tuple of 3 float
        [m]
    rotor : float
        Inertia of the drive, reflected [kg m^2].
    stiffness : float
        Of the gear [N m/rad].

    """

    xyz: tuple
    rpy: tuple
    mass: float
    com: tuple
    rotor: float
    stiffness: float


class Arm(NamedTuple):
    """
    An arm with sensor, gripper and peg.

    Attributes
    ----------
    name : str
    joints : tuple of str
    steps : tuple of Step
    sensor : tuple of (xyz, rpy)
        Of the sensor's link in the last link [m], [rad].
    tool : tuple of (xyz, rpy)
        Of the tool's link in that of the sensor.
    peg_in_tool : float
        Along z of the tool to the peg's lower end [m].
    gripper_mass : float
        With the sensor's lower half, on the peg's side [kg].
    gripper_com : tuple of 3 float
        In the sensor's link [m].
    start : tuple of float
        Joints near which the peg is held above the hole [rad].

    """

    name: str
    joints: tuple
    steps: tuple
    sensor: tuple
    tool: tuple
    peg_in_tool: float
    gripper_mass: float
    gripper_com: tuple
    start: tuple


UR_LIKE = Arm(
    "ur_like",
    tuple(f"axis_{i}" for i in range(1, 7)),
    (
        Step((0, 0, 0.16), (0, 0, 0), 3.6, (0, 0.02, 0), 1.2, 2.5e4),
        Step((0, 0.0, 0), (Q, 0, 0), 7.8, (-0.2, 0, 0.12), 1.2, 2.5e4),
        Step((-0.42, 0, 0), (0, 0, 0), 2.4, (-0.2, 0, 0.02), 0.6, 1.5e4),
        Step((-0.39, 0, 0.13), (0, 0, 0), 1.3, (0, -0.02, 0), 0.2, 8e3),
        Step((0, -0.1, 0), (Q, 0, 0), 1.2, (0, 0.02, 0), 0.2, 8e3),
        Step((0, 0.1, 0), (-Q, 0, 0), 0.4, (0, 0, -0.02), 0.2, 8e3),
    ),
    ((0, 0, 0.0), (0, 0, 0)),
    ((0, 0, 0.12), (0, 0, 0)),
    0.07,
    0.9,
    (0.002, -0.003, 0.06),
    (0.2, -1.4, 1.7, -1.9, -1.57, 0.3),
)
FRANKA_LIKE = Arm(
    "franka_like",
    tuple(f"joint{i}" for i in range(1, 8)),
    (
        Step((0, 0, 0.33), (0, 0, 0), 4.0, (0, -0.03, -0.06), 0.6, 1.4e4),
        Step((0, 0, 0), (-Q, 0, 0), 4.0, (0, -0.08, 0.03), 0.6, 1.4e4),
        Step((0, -0.32, 0), (Q, 0, 0), 3.2, (0.03, 0.03, -0.06), 0.5, 1.4e4),
        Step((0.08, 0, 0), (Q, 0, 0), 3.2, (-0.04, 0.04, 0.03), 0.5, 1.4e4),
        Step((-0.08, 0.38, 0), (-Q, 0, 0), 2.6, (0, 0.04, -0.1), 0.3, 9e3),
        Step((0, 0, 0), (Q, 0, 0), 1.5, (0.05, 0, 0), 0.2, 9e3),
        Step((0.09, 0, 0), (Q, 0, 0), 0.8, (0, 0, 0.07), 0.2, 9e3),
    ),
    ((0, 0, 0.107), (0, 0, 0)),
    ((0, 0, 0.10), (0, 0, -np.pi / 4)),
    0.07,
    0.7,
    (0.0, 0.0, 0.03),
    (0.1, 0.3, -0.1, -1.9, 0.05, 2.2, 0.9),
)
IIWA_LIKE = Arm(
    "iiwa_like",
    tuple(f"a{i}" for i in range(1, 8)),
    (
        Step((0, 0, 0.15), (0, 0, 0), 5.0, (0, -0.03, 0.12), 1.0, 2e4),
        Step((0, 0, 0.19), (Q, 0, np.pi), 4.5, (0, 0.06, 0.04), 1.0, 2e4),
        Step((0, 0.21, 0), (Q, 0, np.pi), 3.0, (0, 0.03, 0.13), 0.8, 1.6e4),
        Step((0, 0, 0.21), (Q, 0, 0), 2.7, (0, 0.07, 0.03), 0.8, 1.6e4),
        Step((0, 0.19, 0), (-Q, np.pi, 0), 1.7, (0, 0.02, 0.08), 0.4, 1e4),
        Step((0, 0, 0.21), (Q, 0, 0), 1.8, (0, 0, 0.01), 0.2, 1e4),
        Step((0, 0.08, 0), (-Q, np.pi, 0), 0.3, (0, 0, 0.02), 0.2, 1e4),
    ),
    ((0, 0, 0.045), (0, 0, Q)),
    ((0, 0, 0.14), (0, 0, 0)),
    0.07,
    1.1,
    (0.004, 0.0, 0.06),
    (0.2, 0.6, 0.0, -1.4, 0.1, 1.1, 0.3),
)
ARMS = {arm.name: arm for arm in (UR_LIKE, FRANKA_LIKE, IIWA_LIKE)}


def _text(values):
    return " ".join(f"{float(value):.9g}" for value in values)


def urdf(arm: Arm) -> str:
    """Return the description of an arm."""
    lines = [
        '<?xml version="1.0"?>',
        "<!-- An arm of the usual build, of numbers of its own; made by",
        "     python -m benchmarks.robot_cells urdf -->",
        f'<robot name="{arm.name}">',
        '  <link name="base_link"/>',
    ]
    parent = "base_link"
    for number, (name, step) in enumerate(zip(arm.joints, arm.steps), 1):
        child = f"link_{number}"
        lines.append(
            f'  <joint name="{name}" type="revolute">'
            f'<parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{_text(step.xyz)}" rpy="{_text(step.rpy)}"/><axis xyz="0 0 1"/>'
            '<limit lower="-6.2832" upper="6.2832" effort="150" velocity="3.14"/></joint>'
        )
        lines.append(
            f'  <link name="{child}"><inertial><origin xyz="{_text(step.com)}"/>'
            f'<mass value="{step.mass:g}"/>{_inertia(step.mass)}</inertial></link>'
        )
        parent = child
    for child, (xyz, rpy) in (("ft_sensor", arm.sensor), ("tool0", arm.tool)):
        lines.append(
            f'  <joint name="{child}_mount" type="fixed"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="{_text(xyz)}" rpy="{_text(rpy)}"/></joint>'
        )
        lines.append(f'  <link name="{child}"/>')
        parent = child
    return "\n".join([*lines, "</robot>", ""])


def _inertia(mass):
    i = mass * 0.06**2
    return f'<inertia ixx="{i:.4g}" ixy="0" ixz="0" iyy="{i:.4g}" iyz="0" izz="{i:.4g}"/>'


def rotation(rpy) -> np.ndarray:
    """Return Rz(yaw) Ry(pitch) Rx(roll)."""
    r, p, y = rpy
    cr, sr, cp, sp, cy, sy = np.cos(r), np.sin(r), np.cos(p), np.sin(p), np.cos(y), np.sin(y)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def _pose(xyz, rpy):
    # Degrees are MuJoCo's default, and its Euler angles turn with the body.
    R = rotation(rpy)
    return f'pos="{_text(xyz)}" xyaxes="{_text([*R[:, 0], *R[:, 1]])}"'


def bodies(arm: Arm, peg: str) -> str:
    """
    Return the arm as bodies of MuJoCo: each joint is a drive and, behind a spring, its link.

    Parameters
    ----------
    arm : Arm
    peg : str
        What is at the tool.

    """
    lines, ends = [], 0
    for name, step in zip(arm.joints, arm.steps):
        i = step.mass * 0.06**2
        damping = 2 * 0.1 * np.sqrt(step.stiffness * 0.05)
        lines.append(
            f"<body {_pose(step.xyz, step.rpy)}>"
            f'<joint name="drive_{name}" axis="0 0 1" armature="{step.rotor}" damping="0.5"/>'
            '<inertial pos="0 0 0" mass="0.2" diaginertia="2e-4 2e-4 2e-4"/>'
            f'<body><joint name="gear_{name}" axis="0 0 1" stiffness="{step.stiffness}" '
            f'damping="{damping:.4g}"/>'
            f'<inertial pos="{_text(step.com)}" mass="{step.mass}" '
            f'diaginertia="{i:.4g} {i:.4g} {i:.4g}"/>'
        )
        ends += 2
    # A force sensor of MuJoCo measures between a body and the one above it.
    lines.append(f'<body name="below_sensor" {_pose(*arm.sensor)}><site name="sensor"/>')
    lines.append(
        f'<geom type="sphere" size="0.01" pos="{_text(arm.gripper_com)}" '
        f'mass="{arm.gripper_mass}" '
        'contype="0" conaffinity="0"/>'
    )
    lines.append(f'<body name="tool" {_pose(*arm.tool)}>{peg}</body></body>')
    return "".join(lines) + "</body>" * ends
