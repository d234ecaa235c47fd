"""The arm of data/arm.urdf by formulas of its own: an oracle that knows no Pinocchio."""

import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from peg_on_hole_ros.config.options import JointInput

URDF = Path(__file__).parent / "data" / "arm.urdf"
JOINTS = tuple(f"arm_{i}" for i in range(1, 8))
# The tool's z points out of the gripper, the peg's up its axis; the hole leans a little.
OPTIONS = JointInput(
    source="robot",
    names=JOINTS,
    position_stddev=5e-5,
    urdf=str(URDF),
    tip_frame="tool",
    peg_xyz=(0.0, 0.0, 0.06),
    peg_rpy=(np.pi, 0.0, 0.4),
    hole_xyz=(0.55, 0.05, 0.90),
    hole_rpy=(0.05, -0.03, 0.7),
)
BENT = np.array([0.3, 0.5, -0.2, 1.2, 0.3, -1.1, 0.4])


def options(**changes):
    return replace(OPTIONS, **changes)


def _vector(element, key, default):
    text = default if element is None else element.get(key, default)
    return np.array([float(x) for x in text.split()])


def _rpy(angles):
    # URDF: fixed axes x, y, z in this order.
    return Rotation.from_euler("xyz", angles)


class Arm:
    """Forward kinematics from the file, joint by joint, with scipy's rotations."""

    def __init__(self, text=None, tip="tool"):
        root = ElementTree.fromstring((text or URDF.read_text(encoding="utf-8")).encode())
        above = {joint.find("child").get("link"): joint for joint in root.findall("joint")}
        self._steps, link = [], tip
        while link in above:
            joint = above[link]
            origin = joint.find("origin")
            self._steps.insert(
                0,
                (
                    joint.get("name"),
                    joint.get("type"),
                    _vector(origin, "xyz", "0 0 0"),
                    _rpy(_vector(origin, "rpy", "0 0 0")),
                    _vector(joint.find("axis"), "xyz", "1 0 0"),
                ),
            )
            link = joint.find("parent").get("link")

    def tip(self, positions: dict):
        """Return position, rotation, and {joint: (axis, point)} (root axes); arrays for arrays."""
        p, R, axes = np.zeros(3), Rotation.identity(), {}
        for name, kind, xyz, rotation, axis in self._steps:
            p, R = p + R.apply(xyz), R * rotation
            if kind == "fixed":
                continue
            axis = axis / np.linalg.norm(axis)
            axes[name] = R.apply(axis), p
            if kind == "prismatic":
                p = p + R.apply(np.multiply.outer(positions[name], axis))
            else:
                R = R * Rotation.from_rotvec(np.multiply.outer(positions[name], axis))
        return p, R, axes

    def peg(self, joints, o=OPTIONS):
        """Return position and rotation of the peg in the hole frame."""
        p, R, _ = self.tip(dict(zip(JOINTS, joints)))
        hole = _rpy(o.hole_rpy)
        p_R = p + R.apply(o.peg_xyz)
        return hole.inv().apply(p_R - o.hole_xyz), hole.inv() * R * _rpy(o.peg_rpy)

    def joints_at(self, position, rotation, start, o=OPTIONS, tolerance=1e-12):
        """Return joints that hold the peg at a pose in the hole frame, by Newton's method."""
        q = np.array(start, float)
        hole = _rpy(o.hole_rpy)
        for _ in range(60):
            p, R, axes = self.tip(dict(zip(JOINTS, q)))
            p_H, R_H = self.peg(q, o)
            error = np.concatenate([position - p_H, (rotation * R_H.inv()).as_rotvec()])
            if np.abs(error).max() < tolerance:
                return q
            p_R = p + R.apply(o.peg_xyz)
            J = np.array(
                [
                    [*hole.inv().apply(np.cross(a, p_R - c)), *hole.inv().apply(a)]
                    for a, c in (axes[name] for name in JOINTS)
                ]
            ).T
            step = np.linalg.lstsq(J, error, rcond=None)[0]
            q = q + step * min(1.0, 0.3 / max(np.abs(step).max(), 1e-12))
        raise AssertionError(f"no joints reach {position}: {error}")


def peg_rotation(q):
    """R_HP of gamma, psi, phi."""
    return Rotation.from_euler("ZYZ", [q[1], -q[0], q[2]])


def angles(rotation):
    """gamma, psi, phi of R_HP by scipy; gamma > 0."""
    psi, gamma, phi = rotation.as_euler("ZYZ").T
    # scipy has the middle angle positive, here it turns the other way: both others by half a turn
    return np.array([gamma, psi + np.pi, phi - np.pi]).T
