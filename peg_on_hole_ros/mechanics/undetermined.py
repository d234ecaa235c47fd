"""What the wrench does not determine, with the range that it can take."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linprog

from peg_on_hole_ros.mechanics.free_body import FreeBody, free_body, sticking, wrench_of
from peg_on_hole_ros.mechanics.scene import Scene

# A stuck contact's cone starts as 8 planes; where the optimum leaves the cone a plane is added.
_FIRST_PLANES, _MAX_CUTS, _CONE_TOLERANCE = 8, 60, 1e-9
# Largest sum of reactions over the load that is looked at.
_CAP = 1e7


class Determination(Enum):
    """What is known about the reactions; the values are advice."""

    DETERMINED = "the reactions follow from motion and wrench"
    UNDETERMINED = "friction or the split between contacts leaves a range: use its ends"
    UNBOUNDED = "the contacts can squeeze the peg with any force: wedged, reactions have no bound"
    IMPOSSIBLE = "no reactions within the friction cones give this motion: the peg moves otherwise"


class ReactionRanges(NamedTuple):
    """
    Ranges of the normal reactions.

    Attributes
    ----------
    low, high : ndarray, shape (3,)
        Of N_K, N_B1, N_B2 [N]; `high` is inf where nothing bounds it; both zero if impossible.
    determination : Determination
    can_wedge : bool
        Whether forces within the cones can balance each other with no load at all.

    """

    low: np.ndarray
    high: np.ndarray
    determination: Determination
    can_wedge: bool


def reaction_ranges(
    scene: Scene,
    q: ArrayLike,
    rates: ArrayLike,
    force_H: ArrayLike,
    moment_H: ArrayLike,
    force_tolerance: float = 0.0,
    rest_speed: float = 1e-9,
) -> ReactionRanges:
    """
    Return the least and the largest normal reactions that motion and wrench allow.

    A contact at rest may have any friction within its cone, a sliding one has its own direction. A
    peg at rest as a whole must stay so; otherwise its three accelerations are free.

    Parameters
    ----------
    scene : Scene
    q, rates : array_like, shape (3,)
        gamma, psi, phi [rad] and their rates [rad/s].
    force_H, moment_H : array_like, shape (3,)
        Applied at the mass centre, hole axes, without gravity [N], [N m].
    force_tolerance : float
        By how much each force may be off [N], and each moment by that times the hole's radius:
        the error of a sensor, say. Where B1 and B2 merge, the split between them opens with it.
    rest_speed : float
        Below it a contact counts as at rest [m/s].

    Returns
    -------
    ReactionRanges

    Notes
    -----
    Each end is a linear programme over outer planes of the cones, cut until the optimum lies
    within 1e-9 of them.

    """
    body = free_body(scene, q, rates, force_H, moment_H)
    problem = reaction_problem(scene, body, rest_speed, force_tolerance)
    # A range has no end where forces without a load, the set's recession cone, have a part in it.
    squeeze = problem._replace(right=0 * problem.right, slack=0 * problem.slack)
    endless = np.array([squeeze.extreme(k, -1, 1.0) > 1e-6 for k in problem.normal])
    can_wedge = bool(endless.any())

    low, high = np.zeros(3), np.zeros(3)
    for i, k in enumerate(problem.normal):
        ends = [problem.extreme(k, sign, _CAP) for sign in (1, -1)]
        if ends[0] is None or ends[1] is None:
            return ReactionRanges(np.zeros(3), np.zeros(3), Determination.IMPOSSIBLE, can_wedge)
        low[i] = ends[0] * problem.load
        high[i] = np.inf if endless[i] else ends[1] * problem.load
    if endless.any():
        kind = Determination.UNBOUNDED
    elif np.max(high - low) > 1e-6 * max(np.max(high), problem.load):
        kind = Determination.UNDETERMINED
    else:
        kind = Determination.DETERMINED
    return ReactionRanges(low, high, kind, can_wedge)


def reaction_problem(
    scene: Scene, body: FreeBody, rest_speed: float, force_tolerance: float = 0.0
) -> _Problem:
    """Return the linear programmes of the reactions of a body, see `reaction_ranges`."""
    stuck = sticking(body, rest_speed)
    forces, axes, cones, normal = [], [], [], []
    for i in range(3):
        n = body.normals[i]
        normal.append(len(forces))
        if stuck[i] and scene.friction:
            first = np.cross(n, [0.0, 0.0, 1.0])
            first /= np.linalg.norm(first)
            directions = [n, first, np.cross(n, first)]
            cones.append(len(forces))
        else:
            speed = np.linalg.norm(body.velocity[i])
            u = body.velocity[i] / speed if speed > rest_speed else np.zeros(3)
            directions = [n - scene.friction * u]
        axes += [(i, direction) for direction in directions]
        forces += [wrench_of(body.arms[i], direction) for direction in directions]
    motion = np.zeros((6, 0)) if stuck.all() else -body.mass @ body.freedom
    right = body.mass @ body.drift - body.load
    radius = scene.hole_diameter / 2
    # Rows and columns in N: moments over the radius, accelerations by what they weigh.
    rows = np.array([1, 1, 1, 1 / radius, 1 / radius, 1 / radius])
    columns = np.column_stack([*forces, motion]) * rows[:, None]
    size = np.linalg.norm(columns, axis=0)
    size[: len(forces)] = 1
    load = max(np.max(np.abs(right * rows)), 1e-9)
    slack = np.full(6, force_tolerance / load)
    return _Problem(
        columns / size, right * rows / load, slack, cones, normal, scene.friction, load, axes
    )


class _Problem(NamedTuple):
    """Linear programmes over columns @ x = right +- slack, cones at some parts of x."""

    columns: np.ndarray
    right: np.ndarray
    slack: np.ndarray
    cones: list
    normal: list
    friction: float
    load: float
    axes: list

    def plane(self, angle, start):
        """Return the row of one outer plane of the cone at `start`."""
        row = np.zeros(self.columns.shape[1])
        row[start] = -self.friction
        row[start + 1], row[start + 2] = np.cos(angle), np.sin(angle)
        return row

    def example(self):
        """Return forces at the contacts with least N_K, shape (3, 3); None if there are none."""
        x = self.optimum(self.normal[0], 1, _CAP)
        if x is None:
            return None
        forces = np.zeros((3, 3))
        for (contact, direction), share in zip(self.axes, x):
            forces[contact] += share * self.load * direction
        return forces

    def extreme(self, index, sign, total):
        """Return the least (sign 1) or largest (-1) x[index]; None if there is no solution."""
        x = self.optimum(index, sign, total)
        return None if x is None else float(x[index])

    def optimum(self, index, sign, total):
        """
        Return x where x[index] is least (sign 1) or largest (-1); None if there is no solution.

        The sum of normal reactions stays under `total`, so that no programme is unbounded.
        """
        n = self.columns.shape[1]
        cost, cap = np.zeros(n), np.zeros(n)
        cost[index], cap[self.normal] = sign, 1
        bounds = [(0, None) if k in self.normal else (None, None) for k in range(n)]
        angles = 2 * np.pi * np.arange(_FIRST_PLANES) / _FIRST_PLANES
        planes = [cap, *(self.plane(angle, start) for start in self.cones for angle in angles)]
        loose = bool(np.any(self.slack))
        for _ in range(_MAX_CUTS):
            upper, limits = planes, [total] + [0.0] * (len(planes) - 1)
            if loose:
                upper = [*planes, *self.columns, *-self.columns]
                limits = [*limits, *(self.right + self.slack), *(self.slack - self.right)]
            result = linprog(
                cost,
                A_ub=np.array(upper),
                b_ub=limits,
                A_eq=None if loose else self.columns,
                b_eq=None if loose else self.right,
                bounds=bounds,
                method="highs",
                options={"primal_feasibility_tolerance": 1e-10},
            )
            if result.status != 0:
                return None
            x, cut = result.x, False
            for start in self.cones:
                tangential = np.hypot(x[start + 1], x[start + 2])
                if tangential > self.friction * x[start] + _CONE_TOLERANCE * (1 + abs(x[start])):
                    planes.append(self.plane(np.arctan2(x[start + 2], x[start + 1]), start))
                    cut = True
            if not cut:
                break
        return x
