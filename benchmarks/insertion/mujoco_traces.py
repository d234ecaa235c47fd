"""
Simulate insertions in MuJoCo: another engine's contacts in the hole, under the same holder.

    pip install mujoco numpy
    python -m benchmarks.insertion.mujoco_traces OUT.npz [--only NAME]

made the traces that `engine.py` and the tests read (MuJoCo 4.0.0); each takes some
minutes on a core. Contacts are those of `mujoco_peg.py`: the rim is 1440 boxes, here as deep as
the hole; they give some 2 MN/m each, friction creeps where it sticks. The peg, the holder and
its program are `peg_on_hole_ros.sim`'s, so that motions can be compared; the engine knows
nothing of the contacts there. Rows are 2 ms apart: pose at their end, and means of the holder's
wrench and of the sums of normal forces on rim and edge over them.
"""

import argparse
from pathlib import Path

import mujoco
import numpy as np

from benchmarks.engines import mujoco_peg as engine
from benchmarks.engines.mujoco_peg import CONTACT, IMPRATIO
from benchmarks.insertion.programs import PROGRAMS, plan_of
from peg_on_hole_ros.sim.command import evaluate
from peg_on_hole_ros.sim.dynamics import angular_velocity, rotation, scene_numbers
from peg_on_hole_ros.sim.holder import holder_numbers, mass_centre
from peg_on_hole_ros.sim.hole_forces import commanded, pull
from peg_on_hole_ros.sim.insertion_phases import begin_of, place_program
from peg_on_hole_ros.sim.plan import holder_program

WALL = 0.03  # half of the hole's depth [m]
WINDOW = 100
# A contact no farther than this from the peg's lower end, along its axis, is the edge's [m].
AT_END = 1e-3
# Where nothing touches there are no boxes: this far from the plane of tilt [rad].
SECTOR = 0.35, 0.35
# On three contacts B1 and B2 are aside of it.
SECTORS = {"goes_in": (0.9, 0.15)}
# The holder turns the peg as a contact of 0.8 MN/m would: one that locks a load in is stiffer.
CONTACTS = {"wedges": (4.7e8, 2.6e4)}
# What is locked in creeps away, by 8 % in a second with 1000.
IMPRATIOS = {"wedges": 10_000}


def trace(name: str) -> np.ndarray:
    """Return rows of pose (C, R) and means of F, M about the mass centre, N on rim and edge."""
    plan = plan_of(name)
    scene = plan.configuration.scene
    p = scene_numbers(scene)
    sensor = plan.configuration.wrench.sensor_xyz
    holder = holder_numbers(
        scene, sensor, plan.holder.stiffness, plan.holder.rotational_stiffness, 0.7
    )
    knots, coefficients = holder_program(plan)
    begin = begin_of(knots, coefficients, p, 0.0)
    knots, pieces = place_program(plan.phases, begin, coefficients[:, :3])
    engine.D, engine.d, engine.H = scene.hole_diameter, scene.peg_diameter, scene.peg_height
    engine.MASS, engine.FRICTION, engine.WALL = scene.peg_mass, scene.friction, WALL
    engine.GRAVITY, engine.SECTOR = -scene.gravity[2], SECTORS.get(name, SECTOR)
    engine.CONTACT = CONTACTS.get(name, CONTACT)
    engine.IMPRATIO = IMPRATIOS.get(name, IMPRATIO)
    model = mujoco.MjModel.from_xml_string(engine.scene())
    data = mujoco.MjData(model)
    # From where it touches, as fast as is commanded.
    x = evaluate(knots, coefficients, 0.0)
    x[:2, 3:] = 0
    R, w = rotation(x[0, :3]), angular_velocity(x[0, :3], x[1, :3])
    data.qpos[:3], data.qvel[:3] = mass_centre(p, x)[:2]
    mujoco.mju_mat2Quat(data.qpos[3:7], R.ravel())
    data.qvel[3:6] = R.T @ w
    rows, local = [], np.zeros(6)
    for _ in range(round(knots[-1] / (engine.STEP * WINDOW))):
        mean = np.zeros(8)
        for _ in range(WINDOW):
            R = engine.axes_of(data)
            V = np.concatenate([data.qvel[:3], R @ data.qvel[3:6]])
            command = commanded(p, knots, pieces, data.time)
            F, M = pull(p, holder, command, data.qpos[:3].copy(), R, V)
            data.xfrc_applied[1, :3], data.xfrc_applied[1, 3:] = F, M
            # Contacts are those of the pose before the step.
            axis, centre = R[:, 2], data.qpos[:3].copy()
            mujoco.mj_step(model, data)
            # K; B1 and B2, or the two halves of B.
            pushes = np.zeros((3, 3))
            for i in range(data.ncon):
                contact = data.contact[i]
                mujoco.mj_contactForce(model, data, i, local)
                at_edge = axis @ (contact.pos - centre) + engine.H / 2 < AT_END
                group = (1 if contact.pos[1] < 0 else 2) if at_edge else 0
                # Towards the peg, or all away from it.
                pushes[group] += contact.frame[:3] * local[0]
            K, *B = np.linalg.norm(pushes, axis=1)
            loads = K, sum(B)
            mean += np.concatenate([F, M, loads]) / WINDOW
        rows.append(np.concatenate([data.qpos[:3], engine.axes_of(data).ravel(), mean]))
    return np.array(rows)


def main():
    """Simulate what is missing, and write all."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[1])
    parser.add_argument("out", type=Path)
    parser.add_argument("--only", choices=tuple(PROGRAMS))
    args = parser.parse_args()
    stored = dict(np.load(args.out)) if args.out.exists() else {}
    for name in [args.only] if args.only else PROGRAMS:
        if f"pose_{name}" in stored:
            continue
        rows = trace(name)
        # Poses need their digits; loads are good to 1e-6 as they are.
        stored[f"pose_{name}"] = rows[:, :12]
        stored[f"load_{name}"] = rows[:, 12:].astype(np.float32)
        np.savez_compressed(args.out, **stored)
        most = rows[:, 18:].max(axis=0).round(1)
        print(f"{name}: {len(rows)} rows, N at most {most}", flush=True)


if __name__ == "__main__":
    main()
