"""One run of a cell in MuJoCo: an impedance controller sets the peg on the hole and inserts it."""

from typing import NamedTuple

import mujoco
import numpy as np

from benchmarks.robot_cells.arms import Arm, bodies, rotation
from benchmarks.robot_cells.rows import GAMMA0, GRAVITY, PEG_MASS, D, H, Rows, d

STEP = 1e-4
BOXES, WALL = 720, 0.012
# From the bore's edge to where boxes of the cone begin: else a load there has two contacts [m].
APART = 5e-5
# That a peg's cone is made of.
DISKS = 8
# Of the impedance [N/m], [N m/rad], as shares of critical damping.
STIFFNESS, TURNING, DAMPING = 4000.0, 150.0, 0.9


class Setting(NamedTuple):
    """
    What differs from one run to another; the defaults are those of `bags/cell_*.mcap`.

    Attributes
    ----------
    friction : float
        Of all contacts.
    stiffness, damping : float
        Of a contact [N/m], [N s/m]. By default of steel, some 2 um for the loads here; stiffer
        ones chatter at the rate of the steps.
    hole_xyz, hole_rpy : tuple of 3 float
        Where the hole is in the base, and how it lies [m], [rad].
    gamma, psi : float
        The tilt of the program as it touches down, and the direction of its lean [rad].
    slip : float
        By how much the program turns the peg about its own axis [rad].
    press : tuple of 2 float
        How far beyond the rim it presses, across and along the hole [m].
    hole_chamfer, peg_chamfer : float
        Height of a chamfer of 45 degrees above the bore, and below the shank; 0: none [m].

    """

    friction: float = 0.15
    stiffness: float = 1e7
    damping: float = 6e3
    hole_xyz: tuple[float, float, float] = (0.52, 0.08, 0.05)
    hole_rpy: tuple[float, float, float] = (0.02, -0.01, 0.4)
    gamma: float = 0.28
    psi: float = 0.3
    slip: float = 1.5
    press: tuple[float, float] = (0.002, 0.004)
    hole_chamfer: float = 0.0
    peg_chamfer: float = 0.0

    @property
    def contact(self) -> str:
        """Return a contact's attributes in MuJoCo."""
        return (
            f'condim="3" friction="{self.friction} 0 0" '
            f'solref="{-self.stiffness:g} {-self.damping:g}" solimp="0.5 0.5 0.001"'
        )


SHIPPED = Setting()


def scene(arm: Arm, setting: Setting = SHIPPED) -> str:
    """Return the model."""
    boxes = []
    for k in range(BOXES):
        a = 2 * np.pi * k / BOXES
        x, y, length = (D / 2 + 0.002) * np.cos(a), (D / 2 + 0.002) * np.sin(a), 0.0012
        boxes.append(
            f'<geom type="box" size="0.002 {length} {WALL}" pos="{x:.12g} {y:.12g} {-WALL}" '
            f'quat="{np.cos(a / 2):.12g} 0 0 {np.sin(a / 2):.12g}" class="rim"/>'
        )
        if setting.hole_chamfer:
            boxes.append(_cone_box(a, length, setting.hole_chamfer))
    R = rotation(setting.hole_rpy)
    axes = " ".join(f"{x:.12g}" for x in [*R[:, 0], *R[:, 1]])
    place = " ".join(f"{x:.12g}" for x in setting.hole_xyz)
    center = arm.peg_in_tool - H / 2
    peg = (
        f'<geom name="peg" type="cylinder" size="{d / 2} {H / 2}" pos="0 0 {center}" '
        f'mass="{PEG_MASS}" contype="2" conaffinity="1" {setting.contact}/>'
        f"{_cone_disks(arm.peg_in_tool, setting)}"
        f'<site name="peg" pos="0 0 {arm.peg_in_tool}" quat="0 1 0 0"/>'
    )
    return f"""<mujoco>
  <option timestep="{STEP}" gravity="0 0 {-GRAVITY}" cone="elliptic" impratio="100"
          integrator="implicitfast" ccd_tolerance="1e-10" tolerance="1e-10" iterations="50">
    <flag multiccd="disable"/>
  </option>
  <default><default class="rim">
    <geom contype="1" conaffinity="2" {setting.contact}/>
  </default></default>
  <worldbody>
    <body name="hole" pos="{place}" xyaxes="{axes}">{"".join(boxes)}</body>
    {bodies(arm, peg)}
  </worldbody>
  <sensor><force site="sensor"/><torque site="sensor"/></sensor>
</mujoco>"""


def _cone_box(a: float, length: float, height: float) -> str:
    """Return a box whose face is a part of the hole's cone, from the bore's edge up."""
    # Half of the face along the cone; its normal points inwards and up.
    half, slope = height / np.sqrt(2.0), np.sqrt(0.5)
    out = D / 2 + APART + 0.5 * height + 0.002 * slope
    up = APART + 0.5 * height - 0.002 * slope
    x, y = out * np.cos(a), out * np.sin(a)
    along = f"{-np.sin(a):.12g} {np.cos(a):.12g} 0"
    outwards = f"{slope * np.cos(a):.12g} {slope * np.sin(a):.12g} {-slope:.12g}"
    return (
        f'<geom type="box" size="0.002 {length} {half:.12g}" pos="{x:.12g} {y:.12g} {up:.12g}" '
        f'xyaxes="{outwards} {along}" class="rim"/>'
    )


def _cone_disks(end: float, setting: Setting) -> str:
    """Return the peg's cone, as disks within it; it weighs nothing."""
    thick = setting.peg_chamfer / DISKS
    return "".join(
        f'<geom type="cylinder" size="{d / 2 - (k + 1) * thick} {thick / 2}" '
        f'pos="0 0 {end + (k + 0.5) * thick}" mass="0" contype="2" conaffinity="1" '
        f"{setting.contact}/>"
        for k in range(DISKS if thick else 0)
    )


def tilted(gamma, psi, phi) -> np.ndarray:
    """Return peg axes in the hole, Rz(psi) Ry(-gamma) Rz(phi)."""

    def about_z(a):
        return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])

    s, c = np.sin(gamma), np.cos(gamma)
    return about_z(psi) @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) @ about_z(phi)


def angles(R) -> np.ndarray:
    """Return gamma, psi, phi of the peg's axes in the hole."""
    zeta = R[:, 2]
    gamma, psi = np.arctan2(np.hypot(zeta[0], zeta[1]), zeta[2]), np.arctan2(-zeta[1], -zeta[0])
    flat = tilted(gamma, psi, 0.0).T @ R
    return np.array([gamma, psi, np.arctan2(flat[1, 0], flat[0, 0])])


def _smooth(t, begin, end):
    """Return 0 to 1 between two times, smooth to the acceleration."""
    u = np.clip((t - begin) / (end - begin), 0.0, 1.0)
    return u**3 * (10 - 15 * u + 6 * u * u)


def commanded(t: float, setting: Setting = SHIPPED) -> tuple[np.ndarray, np.ndarray]:
    """Return where the program wants the peg's lower end, and its angles, in the hole."""
    gamma = setting.gamma - (setting.gamma - 0.08) * _smooth(t, 2.5, 5.0)
    gamma -= 0.08 * _smooth(t, 5.0, 6.4)
    psi, phi = setting.psi, 0.2 + setting.slip * _smooth(t, 2.0, 6.6)
    # Where three contacts would have the lower end, and below gamma0 the mouth of the hole.
    tilt = max(gamma, GAMMA0)
    s, c = np.sin(tilt), np.cos(tilt)
    a1, a2 = (d - D * c) / (2 * s), (D - d * c) / (2 * s)
    h, z = a2 * s, a1 - a2 * c
    if gamma < GAMMA0:
        h *= gamma / GAMMA0
    press = _smooth(t, 1.9, 2.3)
    h -= setting.press[0] * press * (1 - _smooth(t, 5.0, 6.4))
    above = 0.02 * (1 - _smooth(t, 0.7, 1.9)) - setting.press[1] * press
    down = -0.008 * _smooth(t, 6.0, 7.3)
    return np.array([h * np.cos(psi), h * np.sin(psi), z + above + down]), np.array(
        [gamma, psi, phi]
    )


# How long the program lasts [s].
SECONDS = 7.6


def run(
    arm: Arm, period: float = 1e-3, seconds: float = SECONDS, setting: Setting = SHIPPED
) -> Rows:
    """Run the program; the controller has the period given [s]."""
    model = mujoco.MjModel.from_xml_string(scene(arm, setting))
    data = mujoco.MjData(model)
    n = len(arm.joints)
    drives = [model.joint(f"drive_{name}").qposadr[0] for name in arm.joints]
    moved = [model.joint(f"drive_{name}").dofadr[0] for name in arm.joints]
    gears = [model.joint(f"gear_{name}").qposadr[0] for name in arm.joints]
    site, peg, sensor = (model.site("peg").id, model.geom("peg").id, model.site("sensor").id)
    R_BH, p_BH = rotation(setting.hole_rpy), np.array(setting.hole_xyz)
    # A second model, of drives alone, is what the controller knows.
    known = mujoco.MjData(model)
    data.qpos[drives] = arm.start
    wanted, q = commanded(0.0, setting)
    _reach(model, known, data, drives, moved, site, p_BH + R_BH @ wanted, R_BH @ tilted(*q))
    _sag(model, data, drives, gears)
    at_start = data.qpos[gears].copy()
    home = data.qpos[drives].copy()
    every, per_row = round(period / STEP), round(1e-3 / STEP)
    columns = {name: [] for name in Rows._fields}
    mean, loads, torque = np.zeros(6), np.zeros(3), np.zeros(n)
    before = None
    J, Jr = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    for k in range(round(seconds / STEP)):
        if k % every == 0:
            torque = _control(
                model, data, known, drives, moved, gears, at_start, site, home, R_BH, p_BH, J, Jr,
                setting,
            )  # fmt: skip
        data.qfrc_applied[moved] = torque
        mujoco.mj_step(model, data)
        mean += data.sensordata / per_row
        R_HP = R_BH.T @ data.site_xmat[site].reshape(3, 3)
        loads += _normals(model, data, peg, angles(R_HP)[1], R_BH, p_BH) / per_row
        if (k + 1) % per_row:
            continue
        now = angles(R_HP)
        turned = np.zeros(3) if before is None else (now - before + np.pi) % (2 * np.pi) - np.pi
        before = now
        row = (
            (k + 1) * STEP, data.qpos[drives] + at_start, mean.copy(),
            data.site_xmat[sensor].reshape(3, 3).copy(), now, turned / 1e-3, loads.copy(),
            R_BH.T @ (data.site_xpos[site] - p_BH),
        )  # fmt: skip
        for name, value in zip(Rows._fields, row):
            columns[name].append(value)
        mean[:], loads[:] = 0.0, 0.0
    return Rows(*(np.array(columns[name]) for name in Rows._fields))


def _control(
    model, data, known, drives, moved, gears, at_start, site, home, R_BH, p_BH, J, Jr, setting
):
    """Return the torques of the drives: a Cartesian impedance by the drives' angles."""
    known.qpos[:] = 0.0
    known.qpos[drives], known.qpos[gears] = data.qpos[drives], at_start
    known.qvel[:] = 0.0
    known.qvel[moved] = data.qvel[moved]
    mujoco.mj_fwdPosition(model, known)
    mujoco.mj_fwdVelocity(model, known)
    mujoco.mj_jacSite(model, known, J, Jr, site)
    A = np.vstack([J[:, moved], Jr[:, moved]])
    wanted, q = commanded(data.time, setting)
    ahead, q_ahead = commanded(data.time + 1e-4, setting)
    x, R = known.site_xpos[site], known.site_xmat[site].reshape(3, 3)
    goal, goal_next = R_BH @ tilted(*q), R_BH @ tilted(*q_ahead)
    pull = p_BH + R_BH @ wanted - x
    turn, rate = _vector(goal @ R.T), _vector(goal_next @ goal.T) / 1e-4
    v = np.concatenate([R_BH @ (ahead - wanted) / 1e-4, rate]) - A @ data.qvel[moved]
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, known, M)
    # Critical damping by what the tip weighs, drives and all.
    inertia = np.linalg.inv(A @ np.linalg.solve(M[np.ix_(moved, moved)], A.T) + 1e-6 * np.eye(6))
    K = np.array([STIFFNESS] * 3 + [TURNING] * 3)
    damp = 2 * DAMPING * np.sqrt(np.clip(np.diag(inertia), 0.02, 40.0) * K)
    force = K * np.concatenate([pull, turn]) + damp * v
    torque = A.T @ force + known.qfrc_bias[moved]
    # What the tip leaves free goes home.
    free = np.eye(len(drives)) - np.linalg.pinv(A) @ A
    rest = 20.0 * (home - data.qpos[drives]) - 8.0 * data.qvel[moved]
    return torque + free @ rest


def _vector(R):
    angle = np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1))
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    return axis * (angle / np.sin(angle) if angle > 1e-7 else 1.0)


def _reach(model, known, data, drives, moved, site, x, R):
    """Fill in the drives' angles that hold the tip there, by Newton's method."""
    J, Jr = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    for _ in range(200):
        mujoco.mj_fwdPosition(model, data)
        error = np.concatenate(
            [x - data.site_xpos[site], _vector(R @ data.site_xmat[site].reshape(3, 3).T)]
        )
        if np.abs(error).max() < 1e-12:
            return
        mujoco.mj_jacSite(model, data, J, Jr, site)
        step = np.linalg.lstsq(np.vstack([J[:, moved], Jr[:, moved]]), error, rcond=None)[0]
        data.qpos[drives] += step * min(1.0, 0.2 / max(np.abs(step).max(), 1e-12))
    raise ArithmeticError(f"the arm does not reach the hole: {error}")


def _sag(model, data, drives, gears):
    """Let weight bend the gears, as a calibrated arm knows it, and turn the drives back by it."""
    angle = data.qpos[drives].copy()
    for _ in range(20):
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        bias = data.qfrc_bias[[model.jnt_dofadr[_joint_of(model, at)] for at in gears]]
        stiffness = np.array([model.jnt_stiffness[_joint_of(model, at)] for at in gears])
        data.qpos[gears] = -bias / stiffness
        data.qpos[drives] = angle - data.qpos[gears]


def _joint_of(model, address):
    return int(np.flatnonzero(model.jnt_qposadr == address)[0])


def _normals(model, data, peg, psi, R_BH, p_BH):
    """Return the normal forces at K, B1 and B2 [N]."""
    sums, local = np.zeros((3, 3)), np.zeros(6)
    h, e = np.array([np.cos(psi), np.sin(psi), 0]), np.array([-np.sin(psi), np.cos(psi), 0])
    for i in range(data.ncon):
        contact = data.contact[i]
        mujoco.mj_contactForce(model, data, i, local)
        # The frame's normal points from the first geom to the second, which feels the force.
        sign = 1 if contact.geom2 == peg else -1
        place = R_BH.T @ (contact.pos - p_BH)
        group = 0 if place @ h < -0.3 * D else (1 if place @ e < 0 else 2)
        sums[group] += sign * contact.frame[:3] * local[0]
    return np.linalg.norm(sums, axis=1)
