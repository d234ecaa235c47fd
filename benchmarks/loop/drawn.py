"""What is drawn of a cell in the loop, and what is stated of it; needs no MuJoCo."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from benchmarks.harness.draw import Draw
from benchmarks.robot_cells.arms import ARMS, Arm, rotation
from benchmarks.robot_cells.rows import D
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.config.options import Configuration

SEED = 65_000
ARM = ARMS["ur_like"]
DEGREE = np.pi / 180
# How often the robot sends [ms]; the wrench's frame, a link of the robot's description from whose
# place the levers follow; how long a try may last [s].
EVERY, FRAME, LONGEST = 2, "ft_sensor", 25.0
# What a contact may bear [N].
MOST_LOAD = 200.0
# How well touches of the plate measure the direction of the hole, and how the grasp is known: one
# standard deviation about an axis [rad].
SURVEY, GRASP = 0.14 * DEGREE, 0.2 * DEGREE
LEAN = 0.6 * DEGREE
# Of the controller; the plan is made for it [N/m], [N m/rad].
STIFFNESS, TURNING = 4000.0, 150.0


class Try(NamedTuple):
    """
    What is drawn.

    Attributes
    ----------
    friction : float
        Of all contacts.
    clearance : float
        [m]
    off : tuple of 2 float
        Of the hole from where it is stated, across it [m].
    lean : tuple of 2 float
        Of the hole from how it is stated, about x and y [rad].
    grasp : tuple of 2 float
        Of the peg in the gripper, about x and y of the tool [rad].
    seed : int
        Of the sensor.
    surveyed : bool
        Whether touches of the plate have measured before how the hole leans. What is left of it
        is then an error of `SURVEY`, and the grasp.

    """

    friction: float
    clearance: float
    off: tuple[float, float]
    lean: tuple[float, float]
    grasp: tuple[float, float]
    seed: int
    surveyed: bool = False


def drawn(number: int, surveyed: bool = False) -> Try:
    """Return the draw of a number; the same of a hole that has been surveyed."""
    draw = Draw([SEED, number])

    def off_by(most):
        size, way = draw.even(0.0, most), draw.even(-np.pi, np.pi)
        return size * np.cos(way), size * np.sin(way)

    true = Try(
        friction=draw.even(0.05, 0.5),
        clearance=draw.log(20e-6, 200e-6),
        off=off_by(1.5e-3),
        lean=off_by(1.5 * DEGREE),
        grasp=off_by(0.5 * DEGREE),
        seed=number,
        surveyed=surveyed,
    )
    error = draw.normal(SURVEY), draw.normal(SURVEY)
    return true._replace(lean=error) if surveyed else true


def configuration_of(true: Try) -> Configuration:
    """Return what the engineer of the cell states: the diameters as gauged, the rest as usual."""
    configuration, _ = load("config/cell_ur_like.yaml")
    wrench = replace(configuration.wrench, low_pass=LOW_PASS)
    scene = replace(
        configuration.scene, peg_diameter=D - true.clearance, friction=0.25, friction_stddev=0.1,
        clearance_stddev=2e-6,
    )  # fmt: skip
    tilt = float(np.hypot(SURVEY if true.surveyed else LEAN, GRASP))
    joints = replace(configuration.joints, hole_tilt_stddev=tilt)
    monitor = replace(configuration.monitor, max_normal=(MOST_LOAD,) * 3, inserted_depth=8e-3)
    plan = replace(
        configuration.plan, start_tilt=0.2, press=(-6.0, 0.0, -16.0), grip_height=0.07,
        stiffness=STIFFNESS, rotational_stiffness=TURNING, force_limit=120.0, torque_limit=40.0,
        min_closing_rate=0.02, max_closing_rate=0.2, max_slip_rate=0.5,
    )  # fmt: skip
    return replace(
        configuration, wrench=wrench, scene=scene, joints=joints, monitor=monitor, plan=plan
    )


# Of the sensor [Hz].
LOW_PASS = 100.0


def pose(xyz, R) -> np.ndarray:
    """Return a place and axes as one matrix."""
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = R, xyz
    return found


def stated_hole(configuration: Configuration) -> np.ndarray:
    """Return the hole in the base, as stated."""
    return pose(configuration.joints.hole_xyz, rotation(configuration.joints.hole_rpy))


def true_hole(true: Try, stated: np.ndarray) -> np.ndarray:
    """Return the hole in the base as it is."""
    return stated @ pose((*true.off, 0.0), rotation((*true.lean, 0.0)))


def grasped(true: Try) -> tuple[Arm, np.ndarray]:
    """Return the arm that holds the peg askew, and the peg as it is in the peg as stated."""
    xyz, _ = ARM.tool
    askew = rotation((*true.grasp, 0.0))
    in_tool = pose((0.0, 0.0, ARM.peg_in_tool), np.diag([1.0, -1.0, -1.0]))
    is_in_stated = np.linalg.inv(in_tool) @ pose(np.zeros(3), askew) @ in_tool
    return ARM._replace(tool=(xyz, (*true.grasp, 0.0))), is_in_stated


def axes(lean, spin):
    """Return the axes of a peg that leans by x, y and has turned by this about its own axis."""
    x, y = lean
    z = np.sqrt(max(1.0 - x * x - y * y, 0.0))
    k, c, s = 1.0 / (1.0 + z), np.cos(spin), np.sin(spin)
    least = np.array([[1 - k * x * x, -k * x * y, x], [-k * x * y, 1 - k * y * y, y], [-x, -y, z]])
    return least @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
