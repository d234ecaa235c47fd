"""
Simulate insertions with Pinocchio's contact solvers: contacts of another engine, in two models.

    python -m benchmarks.insertion.pinocchio_traces OUT.npz [--only NAME]

made `data/pinocchio_insertions.npz` (Pinocchio 4.1.0, some ten seconds each on a core). Nothing of
the package's mechanics is used: where the circles of rim and edge touch is found here, by the
gaps alone; normal forces, friction and which contacts carry are the solver's (ADMM, absolute
tolerance 1e-10). The peg, the holder and its program are those of `pegs.py`. Rows are 1 ms apart:
angles and depth at their end, and means over them of the holder's wrench about the mass centre and
of normal forces at K, B1 and B2. What is stored are differences of rows, in UNITS.

`metal` is dry metal: 50 MN/m, damped to 0.7 of critical, and Coulomb's law exactly. `soft` has
10 MN/m, is hardly damped, and its friction is the convex one of soft engines: what slides lifts.
"""

import argparse
from math import acos, atan2, cos, hypot, pi, sin
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from benchmarks.insertion.pegs import COMPLIANCES, PEGS, UNITS, plan_of
from peg_on_hole_ros.measurements.angles import angles_of
from peg_on_hole_ros.sim.command import evaluate
from peg_on_hole_ros.sim.dynamics import angular_velocity, rotation, scene_numbers
from peg_on_hole_ros.sim.holder import holder_numbers, mass_centre
from peg_on_hole_ros.sim.hole_forces import commanded, pull
from peg_on_hole_ros.sim.insertion_phases import begin_of, place_program
from peg_on_hole_ros.sim.plan import holder_program

STEP, WINDOW = 2e-5, 50
# Contacts nearer than this take part in a step [m].
NEAR = 2e-5
TOLERANCE, ITERATIONS = 1e-10, 5000
# Half the width in which an angle is sought by parabolas, at first [rad].
WIDTH = 1e-3


class Contact(NamedTuple):
    """Stiffness [N/m], share of critical damping, and whether Coulomb's law is exact."""

    stiffness: float
    damping: float
    exact: bool


CONTACTS = {
    "metal": Contact(1 / COMPLIANCES["metal"], 0.7, True),
    "soft": Contact(1 / COMPLIANCES["soft"], 0.1, False),
}
NAMES = tuple(f"{peg}_{contact}" for peg in PEGS for contact in CONTACTS)


class Place(NamedTuple):
    """Where a contact is, its normal on the peg, its gap [m], and its column in the rows."""

    point: np.ndarray
    normal: np.ndarray
    gap: float
    column: int


def least(gap_of, angle: float) -> float:
    """Return where near an angle a gap is least, by parabolas through three values."""
    width = WIDTH
    for _ in range(4):
        left, middle, right = gap_of(angle - width), gap_of(angle), gap_of(angle + width)
        bend = left - 2 * middle + right
        if bend > 0:
            angle += width * min(max((left - right) / (2 * bend), -50.0), 50.0)
        width /= 4
    return angle


def touching(scene, C: np.ndarray, R: np.ndarray) -> list[Place]:
    """Return every place where rim and side, or edge and wall or rim, are near to touching."""
    D, r = scene.hole_diameter, scene.peg_diameter / 2
    zeta, end = R[:, 2], C - scene.mass_center_height * R[:, 2]
    psi = atan2(-zeta[1], -zeta[0])
    h = np.array([cos(psi), sin(psi), 0.0])
    e = np.array([-h[1], h[0], 0.0])
    up, aside = np.cross(e, zeta), e
    places = []

    def on_rim(a):
        return D / 2 * (cos(a) * h + sin(a) * e)

    def off_axis(a):
        w = on_rim(a) - end
        return w - (w @ zeta) * zeta

    def on_edge(a):
        return end + r * (cos(a) * up + sin(a) * aside)

    for start, column in ((pi, 0), (0.0, 1)):
        a = least(lambda a: np.linalg.norm(off_axis(a)), start)
        point, w = on_rim(a), off_axis(a)
        length = np.linalg.norm(w)
        if length - r < NEAR and 0.0 < (point - end) @ zeta < scene.peg_height:
            places.append(Place(point, -w / length, length - r, column))

    def within(a):
        point = on_edge(a)
        return D / 2 - hypot(point[0], point[1])

    # Where the edge goes through the plane of the rim; up[2] is the sine of the tilt.
    lift = -end[2] / (r * up[2])
    crosses = acos(lift) if -1.0 < lift < 1.0 else 0.0
    found = set()
    for side in (-1.0, 1.0):
        # From the crossing on, what of the edge is below the rim and nearest to the wall.
        a = least(within, side * max(crosses, 0.02))
        if on_edge(a)[2] < 0.0:
            if round(a, 5) not in found:
                found.add(round(a, 5))
                point = on_edge(a)
                out = np.array([point[0], point[1], 0.0]) / hypot(point[0], point[1])
                places.append(Place(point, -out, within(a), 1 if a < 0 else 2))
        elif crosses:
            a = side * crosses
            point = on_edge(a)
            normal = np.cross(-sin(a) * up + cos(a) * aside, [-point[1], point[0], 0.0])
            normal /= np.linalg.norm(normal)
            out = np.array([point[0], point[1], 0.0]) / hypot(point[0], point[1])
            normal *= -np.sign(normal @ out)
            places.append(Place(point, normal, within(a) * -(normal @ out), 1 if a < 0 else 2))
    a = least(within, pi)
    point = on_edge(a)
    if point[2] < 0.0 and within(a) < NEAR:
        out = np.array([point[0], point[1], 0.0]) / hypot(point[0], point[1])
        places.append(Place(point, -out, within(a), 0))
    return [place for place in places if place.gap < NEAR]


class Solver:
    """Pinocchio's solver of contacts with friction, for up to six at once."""

    def __init__(self, friction: float, contact: Contact):
        """Make the constraints; each is a point contact of a free body."""
        self.model = pin.Model()
        body = self.model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "peg")
        self.settings = pin.ADMMSolverSettings()
        self.settings.solve_ncp, self.settings.max_iterations = contact.exact, ITERATIONS
        for of in ("feasibility", "complementarity"):
            setattr(self.settings, f"absolute_{of}_tol", TOLERANCE)
            setattr(self.settings, f"relative_{of}_tol", TOLERANCE)
        self.sets = []
        for count in range(7):
            models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
            for _ in range(count):
                point = pin.PointContactConstraintModel(self.model, body)
                point.setFriction(friction)
                models.append(pin.ConstraintModel(point))
                datas.append(models[len(models) - 1].createData())
            self.sets.append((models, datas))
        self.unsolved = 0

    def impulses(self, G: np.ndarray, g: np.ndarray) -> np.ndarray:
        """Return impulses, along two tangents and the normal of each contact."""
        models, datas = self.sets[len(g) // 3]
        solver, result = pin.ADMMConstraintSolver(len(g)), pin.ADMMSolverResult()
        done = solver.solve(pin.DelassusOperatorDense(G), g, models, datas, self.settings, result)
        self.unsolved += not done
        return np.array(result.retrieveConstraintImpulses())


def tangents(n: np.ndarray) -> np.ndarray:
    """Return two tangents and the normal as rows."""
    first = np.cross(n, [0.0, 0.0, 1.0] if abs(n[2]) < 0.7 else [1.0, 0.0, 0.0])
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(n, first), n])


def trace(name: str) -> tuple[np.ndarray, int]:
    """Return rows of angles, depth, means of F, M about the mass centre, N; unsolved steps."""
    peg, _, kind = name.rpartition("_")
    contact, plan = CONTACTS[kind], plan_of(peg)
    scene = plan.configuration.scene
    p = scene_numbers(scene)
    holder = holder_numbers(
        scene, plan.configuration.wrench.sensor_xyz, plan.holder.stiffness,
        plan.holder.rotational_stiffness, 0.7,
    )  # fmt: skip
    knots, coefficients = holder_program(plan)
    begin = begin_of(knots, coefficients, p, 0.0)
    knots, pieces = place_program(plan.phases, begin, coefficients[:, :3])
    x = evaluate(knots, coefficients, 0.0)
    x[:2, 3:] = 0
    C, v = (np.array(part) for part in mass_centre(p, x)[:2])
    R, w = rotation(x[0, :3]), angular_velocity(x[0, :3], x[1, :3])
    m = scene.peg_mass
    inertia = np.diag([scene.transverse_inertia] * 2 + [scene.axial_inertia])
    solver, k = Solver(scene.friction, contact), contact.stiffness
    damping = 2 * contact.damping * np.sqrt(k * m)
    # A spring and a damper, taken at the end of the step.
    firm = STEP * k + damping
    rows = []
    for row in range(round(knots[-1] / (STEP * WINDOW))):
        mean = np.zeros(9)
        for step in range(WINDOW):
            t = (row * WINDOW + step) * STEP
            I_H = R @ inertia @ R.T
            F, M = pull(p, holder, commanded(p, knots, pieces, t), C, R, np.concatenate([v, w]))
            F, M = np.array(F), np.array(M)
            turning = np.linalg.inv(I_H)
            u = np.concatenate([
                v + STEP * (F / m + np.array(scene.gravity)),
                w + STEP * turning @ (M - np.cross(w, I_H @ w)),
            ])  # fmt: skip
            normal = np.zeros(3)
            places = touching(scene, C, R)
            if places:
                J = np.vstack([
                    axes @ np.hstack([np.eye(3), -pin.skew(place.point - C)])
                    for place, axes in ((each, tangents(each.normal)) for each in places)
                ])  # fmt: skip
                over = np.zeros((6, 6))
                over[:3, :3], over[3:, 3:] = np.eye(3) / m, turning
                G, g = J @ over @ J.T, J @ u
                for i, place in enumerate(places):
                    G[3 * i + 2, 3 * i + 2] += 1.0 / (STEP * firm)
                    g[3 * i + 2] += k * place.gap / firm
                found = solver.impulses(G, g)
                u = u + over @ J.T @ found
                for i, place in enumerate(places):
                    normal[place.column] += found[3 * i + 2] / STEP
            v, w = u[:3], u[3:]
            C, R = C + STEP * v, pin.exp3(STEP * w) @ R
            mean += np.concatenate([F, M, normal]) / WINDOW
        depth = scene.mass_center_height * R[2, 2] - C[2]
        rows.append(np.concatenate([angles_of(R), [depth], mean]))
    return np.array(rows), solver.unsolved


def main():
    """Simulate what is missing, and write all."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[1])
    parser.add_argument("out", type=Path)
    parser.add_argument("--only", choices=NAMES)
    args = parser.parse_args()
    stored = dict(np.load(args.out)) if args.out.exists() else {}
    for name in [args.only] if args.only else NAMES:
        if name in stored:
            continue
        rows, unsolved = trace(name)
        whole = np.round(rows / UNITS).astype(np.int64)
        stored[name] = np.diff(whole, axis=0, prepend=0).astype(np.int32)
        np.savez_compressed(args.out, **stored)
        most = rows[:, 10:].max(axis=0).round(1)
        print(f"{name}: {len(rows)} rows, N at most {most}, {unsolved} steps unsolved", flush=True)


if __name__ == "__main__":
    main()
