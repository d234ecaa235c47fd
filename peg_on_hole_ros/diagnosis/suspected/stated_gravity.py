"""Gravity that is stated and contradicts the robot: its root link and the hole's axes in it."""

from math import acos, asin, atan2, degrees

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import STATED_GRAVITY_TEST
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy
from peg_on_hole_ros.safe_text import shown


class StatedGravity(Suspect):
    """
    Compares `scene.gravity`, where it is stated, with gravity by the robot's description.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "stated_gravity"
    FINDS = (
        (
            "`scene.gravity`: it contradicts `joints.hole_rpy` and the robot's root link by more "
            "than 3 degrees; with the `hole_rpy` that would agree",
            "at once, where `scene.gravity` is stated and `joints.source` is `robot`",
        ),
    )
    WITHOUT_WRENCH = True

    def __init__(self, stated: Stated) -> None:
        self._text = contradiction(stated.configuration)

    def take(self, instant: Instant, unsure: bool) -> None:
        """Report it with the first wrench, see the package."""
        if self._text and self.finding is None:
            self.finding = Finding(self._text, {}, "scene", voids=True)


def contradiction(configuration: Configuration) -> str:
    """Return how gravity as stated contradicts the robot, and what to set; empty: it does not."""
    scene, joints = configuration.scene, configuration.joints
    if joints.robot_gravity is None:
        return ""
    stated, robot = np.array(scene.gravity), np.array(joints.robot_gravity)
    size = float(np.linalg.norm(stated))
    if not size:
        return ""
    along = float(stated @ robot) / (size * float(np.linalg.norm(robot)))
    off = degrees(acos(min(max(along, -1.0), 1.0)))
    if off <= STATED_GRAVITY_TEST.most_off:
        return ""
    link = f"link {shown(joints.gravity_link)}" if joints.gravity_link else "root link"
    other = _other_way(stated, configuration)
    return (
        f"scene.gravity is {off:.1f} degrees off the robot's: take scene.gravity out{other}, or "
        "if no link stands upright, state joints.gravity_link: stated. Stated is "
        f"{_listed(stated)}; by joints.hole_rpy = {_listed(joints.hole_rpy)} and -z of the {link} "
        f"it is {_listed(robot)}"
    )


def _other_way(stated, configuration):
    """Return which hole_rpy would agree with gravity as stated, where -z of the root is down."""
    joints = configuration.joints
    down = rotation_from_rpy(joints.hole_rpy) @ np.array(joints.robot_gravity)
    if np.hypot(down[0], down[1]) > 1e-6 * abs(down[2]) or down[2] > 0.0:
        return ""
    x, y, z = -stated / np.linalg.norm(stated)
    rpy = atan2(y, z), asin(min(max(-x, -1.0), 1.0)), joints.hole_rpy[2]
    return f", or correct the hole, as by joints.hole_rpy: {_listed(rpy)}"


def _listed(values):
    return f"[{', '.join(f'{round(float(x), 5) + 0.0:.6g}' for x in values)}]"
