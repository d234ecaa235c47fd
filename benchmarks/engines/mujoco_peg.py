"""
Simulate a held peg on a hole's rim in MuJoCo, and write what its contacts carried.

    pip install mujoco numpy
    python -m benchmarks.engines.mujoco_peg test/data/mujoco_align.npz
    python -m benchmarks.engines.mujoco_peg test/data/mujoco_turning.npz --slip 2 --slide 0.3

made the two traces that the tests read (MuJoCo 4.0.0). The peg is pressed into the rim by a stiff
holder whose tilt goes down at a constant rate; nothing of this package is used. A second of
simulation takes minutes on one core.

The rim is a ring of boxes tangent to it, each longer than its share of the ring: short ones would
trap the peg on their end faces. Contacts are stiff springs with dampers; friction has a high
`impratio`, else it adds to the normal force. Each row is the mean over a millisecond: angles and
rates from the pose at its ends, momentum's rate of change, applied wrench, contact forces.
"""

import argparse

import mujoco
import numpy as np

D, d, H, MASS, FRICTION, GRAVITY = 0.050, 0.049, 0.070, 1.0, 0.2, 9.81
BOXES, BOX_LENGTH, STEP, WINDOW = 1440, 0.003, 2e-5, 50
# Of a contact, over the mass that it moves: stiffness (0.43 of it holds) and damping [1/s^2, 1/s].
CONTACT = 4.7e6, 2600.0
# Half of how deep the boxes go down [m].
WALL = 0.005
# How far boxes go from the plane in which the peg tilts at the begin, beside B and beside K [rad].
SECTOR = np.pi / 2, np.pi / 2
# How much stiffer contacts are along the surfaces: friction creeps by 1 over it.
IMPRATIO = 1000
# Holder: stiffness, and damping at this ratio; where it holds the peg, from the three-point pose.
STIFFNESS, TURNING_STIFFNESS, DAMPING_RATIO = 2e4, 2000.0, 0.7
PRESS = np.array([-0.3e-3, 0.0, -0.5e-3])


def scene() -> str:
    """Return the model."""
    boxes = []
    for k in range(BOXES):
        angle = 2 * np.pi * k / BOXES
        if abs((angle + np.pi / 2) % np.pi - np.pi / 2) > SECTOR[int(np.cos(angle) < 0)]:
            continue
        x, y = (D / 2 + 0.002) * np.cos(angle), (D / 2 + 0.002) * np.sin(angle)
        half = angle / 2
        boxes.append(
            f'<geom type="box" size="0.002 {BOX_LENGTH / 2} {WALL}" '
            f'pos="{x:.17g} {y:.17g} {-WALL}" '
            f'quat="{np.cos(half):.17g} 0 0 {np.sin(half):.17g}" class="rim"/>'
        )
    Ie, Iz = MASS * (3 * (d / 2) ** 2 + H**2) / 12, MASS * (d / 2) ** 2 / 2
    contact = f'condim="3" friction="{FRICTION} 0 0" '
    contact += f'solref="{-CONTACT[0]} {-CONTACT[1]}" solimp="0.3 0.3 0.001" '
    return f"""<mujoco>
  <option timestep="{STEP}" gravity="0 0 {-GRAVITY}" cone="elliptic" impratio="{IMPRATIO}"
          integrator="implicitfast" ccd_tolerance="1e-10" tolerance="1e-10" iterations="50">
    <flag multiccd="disable"/>
  </option>
  <default><default class="rim"><geom contype="1" conaffinity="2" {contact}/></default></default>
  <worldbody>
    {"".join(boxes)}
    <body name="peg" pos="0 0 1">
      <freejoint/>
      <inertial pos="0 0 0" mass="{MASS}" diaginertia="{Ie} {Ie} {Iz}"/>
      <geom name="peg" type="cylinder" size="{d / 2} {H / 2}" contype="2" conaffinity="1"
            {contact}/>
    </body>
  </worldbody>
</mujoco>"""


def rotation(gamma, psi, phi):
    """Return peg axes in the world, Rz(psi) Ry(-gamma) Rz(phi)."""

    def about_z(a):
        return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])

    s, c = np.sin(gamma), np.cos(gamma)
    return about_z(psi) @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) @ about_z(phi)


def three_point_center(gamma, psi):
    """Return where the holder puts the mass centre for a tilt (a start; contacts decide)."""
    s, c = np.sin(gamma), np.cos(gamma)
    a1, a2 = (d - D * c) / (2 * s), (D - d * c) / (2 * s)
    h, z = -(H / 2 - a2) * s, (H / 2 - a2) * c + a1
    return np.array([h * np.cos(psi), h * np.sin(psi), z])


def angles(R):
    """Return gamma, psi, phi of the peg's axes in the world."""
    zeta = R[:, 2]
    gamma, psi = np.arccos(zeta[2]), np.arctan2(-zeta[1], -zeta[0])
    flat = rotation(gamma, psi, 0.0).T @ R
    return np.array([gamma, psi, np.arctan2(flat[1, 0], flat[0, 0])])


def contact_forces(model, data, peg, psi):
    """Return total and normal force on the peg in three groups: K, B1, B2 (world), (3, 3) each."""
    total, normal = np.zeros((3, 3)), np.zeros((3, 3))
    local = np.zeros(6)
    h = np.array([np.cos(psi), np.sin(psi), 0])
    e = np.array([-np.sin(psi), np.cos(psi), 0])
    for i in range(data.ncon):
        contact = data.contact[i]
        mujoco.mj_contactForce(model, data, i, local)
        frame = contact.frame.reshape(3, 3)
        # The frame's normal points from the first geom to the second, which feels the force.
        sign = 1 if contact.geom2 == peg else -1
        place = contact.pos
        group = 0 if place @ h < -0.3 * D else (1 if place @ e < 0 else 2)
        total[group] += sign * frame.T @ local[:3]
        normal[group] += sign * frame[0] * local[0]
    return total, normal


def simulate(start_tilt, closing, slide, slip, seconds):
    """
    Return one row a millisecond.

    Parameters
    ----------
    start_tilt, closing, slide, slip : float
        Commanded: tilt at the begin [rad], and the rates -gamma', psi', phi' [rad/s].
    seconds : float
        How long.

    Returns
    -------
    ndarray, shape (n, 31)
        Time, q (3), rates (3), applied wrench (6), momentum's rate (6), N (3), forces (9).

    """
    model = mujoco.MjModel.from_xml_string(scene())
    data = mujoco.MjData(model)
    peg = model.geom("peg").id
    inertia_P = model.body_inertia[1]
    target = np.array([start_tilt, 0.0, 0.0])
    rate = np.array([-closing, slide, slip])
    data.qpos[:3] = three_point_center(target[0], 0.0) + 2e-6 * np.array([0, 0, 1])
    R = rotation(*target)
    mujoco.mju_mat2Quat(data.qpos[3:7], R.ravel())
    damp = 2 * DAMPING_RATIO * np.sqrt(STIFFNESS * MASS)
    turn_damp = 2 * DAMPING_RATIO * np.sqrt(TURNING_STIFFNESS * np.max(inertia_P))
    rows = []
    for _ in range(round(seconds / (STEP * WINDOW))):
        start, before = momentum(data, inertia_P), angles(axes_of(data))
        applied, forces, normals = np.zeros(6), np.zeros((3, 3)), np.zeros((3, 3))
        for _ in range(WINDOW):
            now = target + rate * data.time
            axes = axes_of(data)
            wanted = rotation(*now)
            h = np.array([np.cos(now[1]), np.sin(now[1]), 0])
            # Smoothly pressed in the first 50 ms.
            press = min(1.0, data.time / 0.05) * (PRESS[0] * h + PRESS[2] * np.array([0, 0, 1]))
            force = STIFFNESS * (three_point_center(now[0], now[1]) + press - data.qpos[:3])
            ahead = 1e-6
            next_center = three_point_center(*(now + ahead * rate)[:2])
            v_wanted = (next_center - three_point_center(now[0], now[1])) / ahead
            force += damp * (v_wanted - data.qvel[:3])
            error = wanted @ axes.T
            small = np.array([error[2, 1] - error[1, 2], error[0, 2] - error[2, 0],
                              error[1, 0] - error[0, 1]]) / 2  # fmt: skip
            e = np.array([-h[1], h[0], 0])
            w_wanted = -rate[0] * e + rate[1] * np.array([0, 0, 1]) + rate[2] * wanted[:, 2]
            w = axes @ data.qvel[3:6]
            moment = TURNING_STIFFNESS * small + turn_damp * (w_wanted - w)
            data.xfrc_applied[1, :3], data.xfrc_applied[1, 3:] = force, moment
            mujoco.mj_step(model, data)
            # Contact forces of the step just done, which used the pose before it.
            total, normal = contact_forces(model, data, peg, now[1])
            forces, normals = forces + total / WINDOW, normals + normal / WINDOW
            applied += np.concatenate([force, moment]) / WINDOW
        end = momentum(data, inertia_P)
        after = angles(axes_of(data))
        turned = (after - before + np.pi) % (2 * np.pi) - np.pi
        q, rates = before + turned / 2, turned / (WINDOW * STEP)
        change = (end - start) / (WINDOW * STEP)
        N = np.linalg.norm(normals, axis=1)
        rows.append(np.concatenate([[data.time], q, rates, applied, change, N, forces.ravel()]))
    return np.array(rows)


def main():
    """Run and write the trace."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[1])
    parser.add_argument("out")
    parser.add_argument("--slip", type=float, default=0.0)
    parser.add_argument("--slide", type=float, default=0.0)
    parser.add_argument("--closing", type=float, default=0.4)
    parser.add_argument("--start", type=float, default=0.6)
    parser.add_argument("--seconds", type=float, default=0.95)
    args = parser.parse_args()

    table = simulate(args.start, args.closing, args.slide, args.slip, args.seconds)
    names = ("t", "q", "rates", "wrench", "momentum_rate", "normal", "force")
    widths = (1, 3, 3, 6, 6, 3, 9)
    parts = np.split(table, np.cumsum(widths)[:-1], axis=1)
    scene_values = np.array([D, d, H, MASS, FRICTION, GRAVITY])
    # The angles need all their digits near the rim; the rest is good to 1e-6 as it is.
    stored = {n: (p if n in ("t", "q") else p.astype(np.float32)) for n, p in zip(names, parts)}
    np.savez_compressed(args.out, scene=scene_values, engine=mujoco.__version__, **stored)
    N = table[:, 19:22]
    print(f"{args.out}: {len(table)} rows, gamma {table[0, 1]:.3f} to {table[-1, 1]:.3f}, "
          f"mean N {N[100:].mean(axis=0).round(2)}")  # fmt: skip


def axes_of(data):
    """Return the peg's axes in the world."""
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, data.qpos[3:7])
    return axes.reshape(3, 3)


def momentum(data, inertia_P):
    """Return momentum and angular momentum about the mass centre (world), shape (6,)."""
    axes = axes_of(data)
    return np.concatenate([MASS * data.qvel[:3], axes @ (inertia_P * data.qvel[3:6])])


if __name__ == "__main__":
    main()
