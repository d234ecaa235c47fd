"""One run of a cell in MuJoCo: an impedance controller sets the peg on the hole and inserts it."""

from typing import NamedTuple

import mujoco
import numpy as np

from benchmarks.robot_cells.arms import Arm, bodies, rotation
from benchmarks.robot_cells.rows import GRAVITY, PEG_MASS, D, H, Rows, d

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
    peg_diameter : float
        [m]
    rim : float
        How far the plate reaches from the bore's edge [m].
    step : float
        Of the engine; stiffer contacts need a shorter one [s].
    boxes : int
        That the rim is made of: 720 have it round to 0.24 um, 180 to 4 um at a third of the cost.

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
    peg_diameter: float = d
    rim: float = 0.004
    step: float = STEP
    boxes: int = BOXES

    @property
    def gamma0(self) -> float:
        """Return the tilt at which three-point contact ends [rad]."""
        return float(np.arccos(self.peg_diameter / D))

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
    for k in range(setting.boxes):
        a = 2 * np.pi * k / setting.boxes
        half = setting.rim / 2
        x, y, length = (D / 2 + half) * np.cos(a), (D / 2 + half) * np.sin(a), 0.0012
        boxes.append(
            f'<geom type="box" size="{half} {length} {WALL}" pos="{x:.12g} {y:.12g} {-WALL}" '
            f'quat="{np.cos(a / 2):.12g} 0 0 {np.sin(a / 2):.12g}" class="rim"/>'
        )
        if setting.hole_chamfer:
            boxes.append(_cone_box(a, length, setting.hole_chamfer))
    R = rotation(setting.hole_rpy)
    axes = " ".join(f"{x:.12g}" for x in [*R[:, 0], *R[:, 1]])
    place = " ".join(f"{x:.12g}" for x in setting.hole_xyz)
    center, radius = arm.peg_in_tool - H / 2, setting.peg_diameter / 2
    peg = (
        f'<geom name="peg" type="cylinder" size="{radius} {H / 2}" pos="0 0 {center}" '
        f'mass="{PEG_MASS}" contype="2" conaffinity="1" {setting.contact}/>'
        f"{_cone_disks(arm.peg_in_tool, setting)}"
        f'<site name="peg" pos="0 0 {arm.peg_in_tool}" quat="0 1 0 0"/>'
    )
    return f"""<mujoco>
  <option timestep="{setting.step}" gravity="0 0 {-GRAVITY}" cone="elliptic" impratio="100"
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
        f'<geom type="cylinder" size="{setting.peg_diameter / 2 - (k + 1) * thick} {thick / 2}" '
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


def seat(gamma: float, setting: Setting = SHIPPED) -> tuple[float, float]:
    """
    Return where three contacts have the lower end along h and z [m].

    Below gamma0 it is the mouth of the hole.
    """
    peg, gamma0 = setting.peg_diameter, setting.gamma0
    tilt = max(gamma, gamma0)
    s, c = np.sin(tilt), np.cos(tilt)
    a1, a2 = (peg - D * c) / (2 * s), (D - peg * c) / (2 * s)
    h, z = a2 * s, a1 - a2 * c
    if gamma < gamma0:
        h *= gamma / gamma0
    return h, z


def commanded(t: float, setting: Setting = SHIPPED) -> tuple[np.ndarray, np.ndarray]:
    """Return where the program wants the peg's lower end, and its angles, in the hole."""
    gamma = setting.gamma - (setting.gamma - 0.08) * _smooth(t, 2.5, 5.0)
    gamma -= 0.08 * _smooth(t, 5.0, 6.4)
    psi, phi = setting.psi, 0.2 + setting.slip * _smooth(t, 2.0, 6.6)
    # Where three contacts would have the lower end, and below gamma0 the mouth of the hole.
    h, z = seat(gamma, setting)
    press = _smooth(t, 1.9, 2.3)
    h -= setting.press[0] * press * (1 - _smooth(t, 5.0, 6.4))
    above = 0.02 * (1 - _smooth(t, 0.7, 1.9)) - setting.press[1] * press
    down = -0.008 * _smooth(t, 6.0, 7.3)
    return np.array([h * np.cos(psi), h * np.sin(psi), z + above + down]), np.array(
        [gamma, psi, phi]
    )


# How long the program lasts [s].
SECONDS = 7.6


class Plant:
    """
    Arm, peg and hole, with the impedance controller that holds the peg.

    Parameters
    ----------
    arm : Arm
    setting : Setting
    wanted : ndarray, shape (3,)
        Of the peg's lower end at the start, in the base [m].
    axes : ndarray, shape (3, 3)
        Of the peg.

    """

    def __init__(self, arm: Arm, setting: Setting, wanted: np.ndarray, axes: np.ndarray) -> None:
        self.setting = setting
        self.model = model = mujoco.MjModel.from_xml_string(scene(arm, setting))
        self.data = data = mujoco.MjData(model)
        self._drives = [model.joint(f"drive_{name}").qposadr[0] for name in arm.joints]
        self._moved = [model.joint(f"drive_{name}").dofadr[0] for name in arm.joints]
        self._gears = [model.joint(f"gear_{name}").qposadr[0] for name in arm.joints]
        self._site, self._peg = model.site("peg").id, model.geom("peg").id
        self._sensor = model.site("sensor").id
        self._R, self._p = rotation(setting.hole_rpy), np.array(setting.hole_xyz)
        # A second model, of drives alone, is what the controller knows.
        self._known = mujoco.MjData(model)
        data.qpos[self._drives] = arm.start
        _reach(model, self._known, data, self._drives, self._moved, self._site, wanted, axes)
        _sag(model, data, self._drives, self._gears)
        self._at_start = data.qpos[self._gears].copy()
        self._home = data.qpos[self._drives].copy()
        self._jacobian = np.zeros((2, 3, model.nv))
        self._steps, self._mean, self._loads = 0, np.zeros(6), np.zeros(3)
        self._before: np.ndarray | None = None

    def know(self) -> tuple[np.ndarray, np.ndarray]:
        """Return where the drives have the peg's lower end, and its axes, in the base."""
        known, data, moved = self._known, self.data, self._moved
        known.qpos[:] = 0.0
        known.qpos[self._drives], known.qpos[self._gears] = data.qpos[self._drives], self._at_start
        known.qvel[:] = 0.0
        known.qvel[moved] = data.qvel[moved]
        # Without contacts, which a controller does not know.
        mujoco.mj_kinematics(self.model, known)
        mujoco.mj_comPos(self.model, known)
        mujoco.mj_makeM(self.model, known)
        mujoco.mj_fwdVelocity(self.model, known)
        return known.site_xpos[self._site], known.site_xmat[self._site].reshape(3, 3)

    def hold(self, wanted: np.ndarray, axes: np.ndarray, rates: np.ndarray) -> None:
        """
        Set the torques of the drives: a Cartesian impedance by the drives' angles.

        Parameters
        ----------
        wanted : ndarray, shape (3,)
            [m]
        axes : ndarray, shape (3, 3)
        rates : ndarray, shape (6,)
            Of both [m/s], [rad/s]; all in the base.

        """
        x, R = self.know()
        model, data, known, moved = self.model, self.data, self._known, self._moved
        mujoco.mj_jacSite(model, known, self._jacobian[0], self._jacobian[1], self._site)
        A = np.vstack([self._jacobian[0][:, moved], self._jacobian[1][:, moved]])
        pull, turn = wanted - x, rotation_vector(axes @ R.T)
        v = rates - A @ data.qvel[moved]
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, known, M)
        # Critical damping by what the tip weighs, drives and all.
        inertia = A @ np.linalg.solve(M[np.ix_(moved, moved)], A.T) + 1e-6 * np.eye(6)
        inertia = np.linalg.inv(inertia)
        K = np.array([STIFFNESS] * 3 + [TURNING] * 3)
        damp = 2 * DAMPING * np.sqrt(np.clip(np.diag(inertia), 0.02, 40.0) * K)
        force = K * np.concatenate([pull, turn]) + damp * v
        torque = A.T @ force + known.qfrc_bias[moved]
        # What the tip leaves free goes home.
        free = np.eye(len(moved)) - np.linalg.pinv(A) @ A
        rest = 20.0 * (self._home - data.qpos[self._drives]) - 8.0 * data.qvel[moved]
        data.qfrc_applied[moved] = torque + free @ rest

    def go(self) -> tuple:
        """Go on for a millisecond; return its row, see `Rows`."""
        setting, data, R_BH = self.setting, self.data, self._R
        per_row = round(1e-3 / setting.step)
        self._mean[:], self._loads[:] = 0.0, 0.0
        for _ in range(per_row):
            mujoco.mj_step(self.model, data)
            self._steps += 1
            self._mean += data.sensordata / per_row
            axis = R_BH.T @ data.site_xmat[self._site].reshape(3, 3)[:, 2]
            self._loads += _normals(data, self._peg, axis, R_BH, self._p) / per_row
        now = angles(R_BH.T @ data.site_xmat[self._site].reshape(3, 3))
        before = self._before
        turned = np.zeros(3) if before is None else (now - before + np.pi) % (2 * np.pi) - np.pi
        self._before = now
        return (
            self._steps * setting.step, data.qpos[self._drives] + self._at_start,
            self._mean.copy(), data.site_xmat[self._sensor].reshape(3, 3).copy(), now,
            turned / 1e-3, self._loads.copy(),
            R_BH.T @ (data.site_xpos[self._site] - self._p),
        )  # fmt: skip


def run(
    arm: Arm, period: float = 1e-3, seconds: float = SECONDS, setting: Setting = SHIPPED
) -> Rows:
    """Run the program; the controller has the period given [s]."""
    R_BH, p_BH = rotation(setting.hole_rpy), np.array(setting.hole_xyz)
    wanted, q = commanded(0.0, setting)
    plant = Plant(arm, setting, p_BH + R_BH @ wanted, R_BH @ tilted(*q))
    columns = {name: [] for name in Rows._fields}
    for k in range(round(seconds * 1e3)):
        if k % round(period * 1e3) == 0:
            plant.hold(*_goal(plant.data.time, setting, R_BH, p_BH))
        for name, value in zip(Rows._fields, plant.go()):
            columns[name].append(value)
    return Rows(*(np.array(columns[name]) for name in Rows._fields))


def _goal(t, setting, R_BH, p_BH):
    """Return where the program wants the peg, its axes, and the rates of both, in the base."""
    wanted, q = commanded(t, setting)
    ahead, q_ahead = commanded(t + 1e-4, setting)
    goal, goal_next = R_BH @ tilted(*q), R_BH @ tilted(*q_ahead)
    rate = rotation_vector(goal_next @ goal.T) / 1e-4
    rates = np.concatenate([R_BH @ (ahead - wanted) / 1e-4, rate])
    return p_BH + R_BH @ wanted, goal, rates


def rotation_vector(R):
    """Return axis times angle of a rotation [rad], shape (3,)."""
    angle = np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1))
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    return axis * (angle / np.sin(angle) if angle > 1e-7 else 1.0)


def _reach(model, known, data, drives, moved, site, x, R):
    """Fill in the drives' angles that hold the tip there, by Newton's method."""
    J, Jr = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    for _ in range(200):
        mujoco.mj_fwdPosition(model, data)
        error = np.concatenate(
            [x - data.site_xpos[site], rotation_vector(R @ data.site_xmat[site].reshape(3, 3).T)]
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


def _normals(data, peg, axis, R_BH, p_BH):
    """
    Return the normal forces at K, B1 and B2 [N].

    Parameters
    ----------
    data : MjData
    peg : int
        Geom of the peg.
    axis : ndarray, shape (3,)
        Of the peg, in the hole: it leans from h.
    R_BH, p_BH : ndarray
        Hole in the base.

    """
    sums, contact = np.zeros((3, 3)), data.contact
    addresses = contact.efc_address
    if not len(addresses):
        return sums[0]
    h = -axis[:2] / max(np.hypot(axis[0], axis[1]), 1e-12)
    # The frame's normal points from the first geom to the second, which feels the force.
    sign = np.where(contact.geom2 == peg, 1.0, -1.0)
    # Of an elliptic cone the first row is that of the normal.
    size = np.where(addresses >= 0, data.efc_force[addresses], 0.0)
    place = (contact.pos - p_BH) @ R_BH[:, :2]
    group = np.where(place @ h < -0.3 * D, 0, np.where(place @ [-h[1], h[0]] < 0, 1, 2))
    np.add.at(sums, group, (sign * size)[:, None] * contact.frame[:, :3])
    return np.sqrt((sums * sums).sum(axis=1))
