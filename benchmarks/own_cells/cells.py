"""Drawn cells: what their settings are, and what their sensors send of one cycle."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml

from benchmarks.harness.draw import Draw
from benchmarks.own_cells.arms import BASES, JOINTS, Arm, NoJoints, along_last_axis, drawn_arm
from benchmarks.own_cells.arms import joints_of as reached
from peg_on_hole_ros.bags.truth import CONTACTS_TOPIC, MODE_TOPIC, STATE_TOPIC
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy, rpy_of
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.beside_estimates import JOINT_STATE, STRING, WRENCH, joint_state
from peg_on_hole_ros.messages.plain import header, xyz
from peg_on_hole_ros.records import ANGLES, CONTACTS
from peg_on_hole_ros.sim.dynamics import rotation
from peg_on_hole_ros.sim.measure import START_NS, sensor_wrench
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import Truth, integrate

FIRST_SEED = 31_000
GRAVITY = 9.80665
URDF, WRENCHES, STATES = "arm.urdf", "/ft/wrench", "/joint_states"
# Of wrench and joint states [Hz].
RATE, EVERY = 500, 2


def _alone(truth: Truth) -> Truth:
    return truth


class Cell(NamedTuple):
    """
    A cell with what is right of it, and what it sends.

    Attributes
    ----------
    number : int
    arm : Arm
    parameters : dict of str to object
        All right; the description is `URDF`, beside the bag.
    truth : Truth
    wrench : ndarray, shape (n, 6)
        As received [N], [N m].
    joints : ndarray, shape (n / EVERY, 6)
        As measured [rad].
    late : float
        How much later than it is joint states are stamped [s].

    """

    number: int
    arm: Arm
    parameters: dict[str, object]
    truth: Truth
    wrench: np.ndarray
    joints: np.ndarray
    late: float = 0.0


def drawn_cell(number: int, folder: Path, before: Callable[[Truth], Truth] = _alone) -> Cell:
    """
    Return a cell; the same number gives the same one. Its description goes into a folder.

    `before` puts something before its cycle.
    """
    for attempt in range(20):
        draw = Draw([FIRST_SEED, number, attempt])
        try:
            return _cell(number, draw, folder, before)
        except NoJoints:
            continue
    raise NoJoints(f"no arm of cell {number} reaches its hole and goes in")


def _cell(number, draw, folder, before):
    base, wrist = BASES[number % 3], "meeting" if number % 2 == 0 else "crossed"
    arm = drawn_arm(draw, base, wrist)
    (folder / URDF).write_text(arm.urdf)
    D = draw.even(0.02, 0.05)
    scene = Scene(
        hole_diameter=round(D, 5),
        peg_diameter=round(D, 5) - round(D * draw.log(1.5e-3, 4e-3), 6),
        peg_height=round(D * draw.even(1.5, 2.2), 4),
        peg_mass=round(draw.even(0.2, 0.8), 3),
        friction=round(draw.even(0.14, 0.26), 3),
    )
    placed = _placed(draw, arm, wrist)
    R_RH = rotation_from_rpy(placed.hole_rpy)
    down = R_RH.T @ [0.0, 0.0, -GRAVITY]
    scene = replace(scene, gravity=tuple(down.tolist()))
    in_base = draw.chance(0.5)
    height = scene.peg_height * draw.even(1.3, 2.0)
    payload = draw.even(0.3, 0.9)
    wrench = WrenchInput(
        acts_on="robot" if draw.chance(0.5) else "peg",
        axes="sensor",
        payload_mass=round(payload, 3),
        payload_com=tuple(round(draw.even(-0.015, 0.015), 4) for _ in range(2)) + (-0.02,),
        sensor_xyz=(0.0, 0.0, round(height, 4)),
        sensor_rpy=(0.0, 0.0, round(draw.even(-3.0, 3.0), 3)),
        force_stddev=round(draw.log(0.2, 0.7), 3),
        torque_stddev=round(draw.log(0.005, 0.02), 4),
        bias_force_stddev=5.0,
        bias_torque_stddev=0.1,
    )
    configuration = Configuration(scene=scene, wrench=wrench)
    truth = integrate(plan_from_tree(configuration, _program(draw, scene)))
    if truth.ended_by != "end":
        raise NoJoints(truth.ended_by)
    truth = before(truth)
    peg = np.array([rotation(q) for q in truth.q])
    read = sensor_wrench(truth)
    zero = [*(draw.even(-5, 5) for _ in range(3)), *(draw.even(-0.1, 0.1) for _ in range(3))]
    noise = np.random.default_rng([FIRST_SEED, number])
    read = read + zero
    if in_base:
        turn = (R_RH.T @ arm.base_axes).T @ peg @ rotation_from_rpy(wrench.sensor_rpy)
        read = np.hstack([np.einsum("nij,nj->ni", turn, read[:, s]) for s in _PARTS])
    read += noise.normal(size=read.shape) * np.repeat(
        [wrench.force_stddev, wrench.torque_stddev], 3
    )
    joints = replace(placed, urdf=str(folder / URDF))
    angles = reached(joints, peg[::EVERY], truth.position[::EVERY], draw)
    angles = angles + noise.normal(size=angles.shape) * placed.position_stddev
    parameters = _parameters(scene, wrench, placed, in_base, draw.chance(0.5))
    return Cell(number, arm, parameters, truth, read, angles)


_PARTS = slice(0, 3), slice(3, 6)


def _placed(draw, arm, wrist):
    """Return peg and hole of an arm: the hole leans by 8 to 30 degrees, somewhere before it."""
    lean, about = np.radians(draw.even(8.0, 30.0)), draw.even(-3.0, 3.0)
    axis = lean * np.array([np.cos(about), np.sin(about)])
    R_RH = rotation_from_rpy((axis[0], axis[1], draw.even(-3.0, 3.0)))
    far, aside = draw.even(0.45, 0.6), draw.even(-0.6, 0.6)
    place = arm.stands @ [far * np.cos(aside), far * np.sin(aside), draw.even(0.1, 0.35), 1.0]
    out = np.eye(3)[0 if wrist == "meeting" else 1]
    return JointInput(
        source="robot",
        urdf=URDF,
        tip_frame="gripper_tcp",
        names=JOINTS,
        position_stddev=3e-5,
        peg_xyz=tuple((draw.even(0.03, 0.07) * out).tolist()),
        peg_rpy=tuple(along_last_axis(wrist, draw)),
        hole_xyz=tuple(place[:3].tolist()),
        hole_rpy=tuple(rpy_of(R_RH)),
    )


def _program(draw, scene):
    """Return a cycle: it hangs, comes near, slides with reversals, goes through and in."""
    gamma0, psi, spin = scene.gamma0, draw.even(-3.0, 3.0), draw.sign() * draw.even(0.8, 1.4)
    high, turn = gamma0 + draw.even(0.18, 0.24), draw.sign() * draw.even(0.4, 0.7)
    press, phi = draw.even(0.001, 0.0025), 0.0
    above = {"kind": "free", "offset": [0.0, 0.0, 0.02]}
    phases = {"hang": {**above, "duration": 1.5, "angles": [high + 0.01, psi, 0.0]}}
    start = {"angles": [high + 0.01, psi, 0.0], "offset": above["offset"]}
    # Time, tilt above gamma0 over the most of it, how far psi and phi turn, and at what rates.
    for name, kind, duration, tilt, turned, spun, rates in (
        ("approach", "free", 1.0, 1.0, 0.2, 0.4 * spin, (0.0, 0.0, spin)),
        ("touch_down", "contact", 0.3, 1.0, 0.0, 0.3 * spin, (0.0, 0.0, spin)),
        ("close_and_slide", "contact", 1.2, 0.45, 0.4 * turn, 1.2 * spin, (-0.12, turn, spin)),
        ("reverse", "contact", 0.9, 0.3, 0.0, 0.0, (-0.02, -turn, -spin)),
        ("open_and_slide", "contact", 0.7, 0.5, -0.5 * turn, -0.7 * spin, (0.05, -turn, -spin)),
        ("close", "contact", 1.3, 0.08, -0.3 * turn, -1.3 * spin, (-0.12, 0.0, -spin)),
    ):
        psi, phi = psi + turned, phi + spun
        angles = [gamma0 + (high - gamma0) * tilt, psi, phi]
        down = -press if kind == "contact" else 0.0
        phases[name] = {"kind": kind, "duration": duration, "angles": angles,
                        "rates": list(rates), "offset": [0.3 * down, 0.0, down]}  # fmt: skip
    for name, duration, tilt, load in (("go_in", 0.6, 0.5, 40.0), ("rest", 0.2, 0.45, 15.0)):
        phases[name] = {"kind": "two_point", "duration": duration, "load": [load, load],
                        "angles": [tilt * gamma0, psi, phi - 0.4 * spin]}  # fmt: skip
    holder = {"stiffness": 2e4, "rotational_stiffness": 2e3, "force_limit": 800.0}
    tree = {"wrench_rate": RATE, "joint_rate": RATE // EVERY, "settle": 0.06}
    return {**tree, "holder": holder | {"torque_limit": 60.0}, "start": start, "phases": phases}


def _parameters(scene, wrench, joints, in_base, states_gravity):
    found: dict[str, object] = {"topics.wrench": WRENCHES, "wrench.tare_automatically": True}
    for group, of, names in (
        ("scene", scene, "hole_diameter peg_diameter peg_height peg_mass"),
        ("wrench", wrench, "acts_on payload_mass payload_com sensor_xyz sensor_rpy force_stddev "
         "torque_stddev bias_force_stddev bias_torque_stddev"),
        ("joints", joints, "source urdf tip_frame names position_stddev peg_xyz peg_rpy hole_xyz "
         "hole_rpy"),
    ):  # fmt: skip
        found |= {f"{group}.{name}": getattr(of, name) for name in names.split()}
    # As a cell states it: round, and not what it is.
    found["scene.friction"] = 0.2
    found["wrench.axes"] = "base" if in_base else "sensor"
    if states_gravity:
        found["scene.gravity"] = scene.gravity
    return {key: list(x) if isinstance(x, tuple) else x for key, x in found.items()}


def write(path: Path, cell: Cell) -> None:
    """Write what a cell sends as a bag, with its truth; a gripper's joint comes first."""
    late_ns, truth = round(cell.late * 1e9), cell.truth
    names, mode = ["finger", *JOINTS], None
    with BagWriter(path, from_parameters({})) as bag:
        for i, t in enumerate(truth.t_ns):
            t_ns = START_NS + int(t)
            if i % EVERY == 0:
                state = joint_state(t_ns + late_ns, names, [0.01, *cell.joints[i // EVERY]])
                bag.write(STATES, JOINT_STATE, state, t_ns)
            force, torque = (dict(xyz(cell.wrench[i, part])) for part in _PARTS)
            fields = {
                "header": header(t_ns, "own_ft"),
                "wrench": {"force": force, "torque": torque},
            }
            bag.write(WRENCHES, WRENCH, fields, t_ns)
            q = truth.q[i].copy()
            q[1:] = np.pi - (np.pi - q[1:]) % (2 * np.pi)
            bag.write(STATE_TOPIC, JOINT_STATE, joint_state(t_ns, ANGLES, q, truth.rates[i]), t_ns)
            if truth.known[i]:
                row = truth.closed[i], truth.slip_speed[i], truth.normal[i]
                bag.write(CONTACTS_TOPIC, JOINT_STATE, joint_state(t_ns, CONTACTS, *row), t_ns)
            if truth.mode[i] != mode:
                mode = truth.mode[i]
                bag.write(MODE_TOPIC, STRING, {"data": str(mode)}, t_ns)


def write_parameters(path: Path, cell: Cell) -> None:
    """Write what is stated of a cell as a person writes it: what is out of range as well."""
    content = {"peg_on_hole": {"ros__parameters": cell.parameters}}
    path.write_text(yaml.safe_dump(content))
