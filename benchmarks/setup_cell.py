"""
Make the recordings of `bags/setup_cell`: a cell on its first day, to be set up at a desk.

    python -m benchmarks.setup_cell [DIR]

writes plate, presses, poses, hang and run (.mcap) there; without DIR those of the checkout.
An arm (config/cell_ur_like.urdf) holds a peg by a gripper, under a sensor that nobody has tared,
and sends what acts on the robot in the axes of its base. Plate, presses and still peg are Newton's
statics; the insertion is simulated from bags/setup_cell/stated.yaml, with its truth.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.own_cells.beside import smooth
from peg_on_hole_ros.bags.truth import CONTACTS_TOPIC, MODE_TOPIC, STATE_TOPIC
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.simulation_file import read_plan
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.messages.beside_estimates import JOINT_STATE, STRING, WRENCH, joint_state
from peg_on_hole_ros.messages.plain import header, xyz
from peg_on_hole_ros.records import ANGLES, CONTACTS
from peg_on_hole_ros.robot.kinematics import UrdfKinematics
from peg_on_hole_ros.robot.urdf_file import read_chain
from peg_on_hole_ros.sim.measure import START_NS, sensor_wrench
from peg_on_hole_ros.sim.truth import integrate

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "bags" / "setup_cell"
STATED = FOLDER / "stated.yaml"
# What the recordings have to tell: payload, zero as received in sensor axes, noise.
PAYLOAD_MASS, PAYLOAD_COM = 0.8, (0.010, 0.015, -0.040)
ZERO = np.array([-4.0, 3.0, 6.0, 0.08, -0.06, 0.03])
FORCE_STDDEV, TORQUE_STDDEV, JOINT_STDDEV = 0.4, 0.015, 3e-5
JOINTS = tuple(f"axis_{i}" for i in range(1, 7))
# The finger of a gripper, whose driver publishes with the arm's.
FINGER = "finger"
WRENCH_TOPIC, JOINTS_TOPIC = "/ft_raw/wrench", "/joint_states"
RATE, JOINTS_EVERY, TRUTH_EVERY = 500, 4, 5
G = np.array([0.0, 0.0, -9.80665])
# An arm that reaches over the hole with its tool down [rad].
BENT = np.array([0.3, -1.4, 1.6, -1.8, -1.57, 0.0])
HAND = 15.0
# gamma, psi, phi at which the peg hangs still [rad].
HANGING = (0.15, 0.4, 0.0)
LEANING = (0.08, -0.5, 0.0)
POSES = ((0.05, 0.0, 0.0), (0.5, 0.0, 0.3), (0.5, 1.6, 0.3), (0.6, -1.5, 0.8))


class Arm:
    """The arm, its peg and its sensor."""

    def __init__(self, configuration: Configuration) -> None:
        urdf = str(ROOT / "config" / "cell_ur_like.urdf")
        joints = replace(
            configuration.joints, source="robot", urdf=urdf, tip_frame="tool0", names=JOINTS
        )
        self.joints, self.scene = joints, configuration.scene
        self.sensor = np.array(configuration.wrench.sensor_xyz)
        self._kinematics = UrdfKinematics(read_chain(joints), joints)
        self.R_RH, self.R_TP = (
            rotation_from_rpy(joints.hole_rpy),
            rotation_from_rpy(joints.peg_rpy),
        )
        self._at = BENT

    def hold(self, p_H: np.ndarray, R_HP: np.ndarray) -> np.ndarray:
        """Return joints that hold the peg at a pose in the hole, next to those before."""
        R_RT = self.R_RH @ R_HP @ self.R_TP.T
        p_RT = self.R_RH @ p_H + self.joints.hole_xyz - R_RT @ self.joints.peg_xyz
        q = self._at.copy()
        for _ in range(200):
            at = self._kinematics.poses(q[None])
            turn = Rotation.from_matrix(R_RT @ at.rotation[0].T).as_rotvec()
            error = np.concatenate([p_RT - at.position[0], turn])
            if np.abs(error).max() < 1e-10:
                self._at = q
                return q
            step = np.linalg.lstsq(np.vstack([at.velocities[0], at.jacobian[0]]), error)[0]
            q = q + step * min(1.0, 0.2 / np.abs(step).max())
        raise AssertionError(f"no joints reach {p_H}: {error}")

    def hung(self, R_HP: np.ndarray, hand: np.ndarray) -> np.ndarray:
        """Return what a sensor reads of a still peg that a hand pushes (peg axes), sensor axes."""
        g = R_HP.T @ self.R_RH.T @ G
        peg, payload = -self.scene.peg_mass * g, -PAYLOAD_MASS * g
        centre = np.array([0.0, 0.0, self.scene.mass_center_height]) - self.sensor
        torque = (
            np.cross(centre, peg) + np.cross(PAYLOAD_COM, payload) - np.cross(-self.sensor, hand)
        )
        return -np.concatenate([peg + payload - hand, torque])


class Recorder:
    """Writes what the arm sends of peg poses and wrenches: noise, zero, axes and digits."""

    def __init__(self, path: Path, arm: Arm, seed: int) -> None:
        self._bag, self._arm = BagWriter(path), arm
        self._random, self._count = np.random.default_rng(seed), 0

    def __enter__(self):
        """Open the file."""
        self.bag = self._bag.__enter__()
        return self

    def __exit__(self, *error):
        """Close it, or remove it after an error."""
        return self._bag.__exit__(*error)

    def send(self, p_H, R_HP, read: np.ndarray) -> int:
        """Write a wrench (sensor axes), with every fourth the joints; return the stamp."""
        k, random = self._count, self._random
        t_ns = START_NS + k * (10**9 // RATE)
        self._count += 1
        if k % JOINTS_EVERY == 0:
            q = self._arm.hold(p_H, R_HP) + random.normal(0, JOINT_STDDEV, 6)
            state = joint_state(t_ns, [FINGER, *JOINTS], [0.01, *q.round(6)], frame="")
            self.bag.write(JOINTS_TOPIC, JOINT_STATE, state, t_ns)
        noise = np.repeat([FORCE_STDDEV, TORQUE_STDDEV], 3) * random.normal(size=6)
        R_RS = self._arm.R_RH @ R_HP
        force, torque = (R_RS @ part for part in np.split(read + ZERO + noise, 2))
        sides = {"force": xyz(force.round(2)), "torque": xyz(torque.round(3))}
        message = {"header": header(t_ns, "ft_raw"), "wrench": sides}
        self.bag.write(WRENCH_TOPIC, WRENCH, message, t_ns)
        return t_ns


def presses(path: Path, arm: Arm) -> None:
    """Write three presses of a hand that misses its directions by some degrees."""
    R, above = peg_axes(np.array(HANGING)), np.array([0.0, 0.0, 0.06])
    with Recorder(path, arm, 1) as out:
        for push in ((0.03, -0.02, 1.0), (1.0, 0.04, -0.03), (-0.05, 1.0, 0.02)):
            for i in range(int(2.0 * RATE)):
                strength = HAND * np.sin(np.pi * np.clip((i / RATE - 0.5) / 1.0, 0.0, 1.0))
                out.send(above, R, arm.hung(R, strength * np.array(push)))


def poses(path: Path, arm: Arm) -> None:
    """Write the peg moved from tilt to tilt, and held still at each."""
    with Recorder(path, arm, 2) as out:
        for before, after in zip((POSES[0], *POSES), POSES):
            for i in range(int(1.3 * RATE)):
                share = smooth(i / (0.7 * RATE))
                q = np.array(before) + share * (np.array(after) - before)
                R = peg_axes(q)
                out.send(np.array([0.0, 0.0, 0.08]), R, arm.hung(R, np.zeros(3)))


def plate(path: Path, arm: Arm) -> None:
    """Write a peg that leans a little, lowered onto the plate at four places and pressed."""
    R, lean = peg_axes(np.array(LEANING)), 0.5 * arm.scene.peg_diameter * np.sin(LEANING[0])
    up = R.T @ np.array([0.0, 0.0, 1.0])
    with Recorder(path, arm, 5) as out:
        for x, y in ((0.04, 0.04), (-0.04, 0.04), (-0.04, -0.04), (0.04, -0.04)):
            for i in range(int(1.7 * RATE)):
                t = i / RATE
                away = 0.01 * (1.0 - smooth(t / 0.5) + smooth((t - 1.2) / 0.5))
                push = HAND * smooth((t - 0.5) / 0.1) * smooth((1.2 - t) / 0.1)
                out.send(np.array([x, y, lean + away]), R, arm.hung(R, push * up))


def hang(path: Path, arm: Arm) -> None:
    """Write the peg as it hangs still for 3 s."""
    R = peg_axes(np.array(HANGING))
    with Recorder(path, arm, 3) as out:
        for _ in range(3 * RATE):
            out.send(np.array([0.0, 0.0, 0.02]), R, arm.hung(R, np.zeros(3)))


def insertion(path: Path, arm: Arm, truth) -> None:
    """Write the simulated insertion with its truth."""
    read, mode = sensor_wrench(truth), None
    with Recorder(path, arm, 4) as out:
        for i, q in enumerate(truth.q):
            t_ns = out.send(truth.position[i], peg_axes(q), read[i])
            if truth.mode[i] != mode:
                mode = truth.mode[i]
                out.bag.write(MODE_TOPIC, STRING, {"data": str(mode)}, t_ns)
            if i % TRUTH_EVERY:
                continue
            state = joint_state(t_ns, ANGLES, q.round(7), truth.rates[i].round(5))
            out.bag.write(STATE_TOPIC, JOINT_STATE, state, t_ns)
            if truth.known[i]:
                closed, normal = truth.closed[i].astype(float), truth.normal[i].round(3)
                contacts = joint_state(t_ns, CONTACTS, closed, (), normal)
                out.bag.write(CONTACTS_TOPIC, JOINT_STATE, contacts, t_ns)


def main() -> None:
    """Make all five."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    plan = read_plan(STATED)
    configuration = plan.configuration
    arm = Arm(configuration)
    plate(folder / "plate.mcap", arm)
    presses(folder / "presses.mcap", arm)
    poses(folder / "poses.mcap", arm)
    hang(folder / "hang.mcap", arm)
    wrench = replace(
        configuration.wrench,
        acts_on="robot",
        payload_mass=PAYLOAD_MASS,
        payload_com=PAYLOAD_COM,
    )
    scene = replace(configuration.scene, gravity=tuple((arm.R_RH.T @ G).tolist()))
    whole = replace(configuration, wrench=wrench, scene=scene)
    insertion(folder / "run.mcap", arm, integrate(replace(plan, configuration=whole)))


if __name__ == "__main__":
    main()
