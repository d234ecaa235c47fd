"""How deep a peg on two points is by tilt and clearance, and what a measured depth tells."""

from math import cos, sin, sqrt

import numpy as np

from peg_on_hole_ros.estimator.contact import clearance_slopes, scene_at
from peg_on_hole_ros.estimator.mixture import reweigh
from peg_on_hole_ros.estimator.state import CLEARANCE
from peg_on_hole_ros.estimator.update import update
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled
from peg_on_hole_ros.record_types import ScratchRecord, SettingsRecord, StateRecord


@compiled
def depth_at(d: float, D: float, gamma: float) -> tuple[float, float, float]:
    """
    Return how deep two points let the lower end's centre be, with its slopes.

    Source: T1, l cos(gamma) - d sin(gamma) / 2.

    Parameters
    ----------
    d, D : float
        Diameters [m].
    gamma : float
        Tilt, above 0 [rad].

    Returns
    -------
    depth : float
        Below the rim [m].
    by_tilt, by_diameter : float
        Its derivatives by gamma [m/rad] and by d [-].

    """
    s, c = sin(gamma), cos(gamma)
    room = D - d * c
    by_tilt = 0.5 * d * c - room - room * c * c / (s * s)
    return room * c / s - 0.5 * d * s, by_tilt, -c * c / s - 0.5 * s


@compiled
def sink(
    s: StateRecord, scratch: ScratchRecord, o: SettingsRecord, p: SceneScalars, at: np.ndarray,
    n: int, learnt: np.ndarray, depth: float, variance: float, since: float,
) -> bool:  # fmt: skip
    """
    Correct every component by a measured depth, where two points surely carry; return if so.

    Parameters
    ----------
    s, scratch, o, p, at, n, learnt
        As for `step.weigh`.
    depth, variance : float
        Of the lower end's centre below the rim [m], and of the place that it is known by [m^2].
    since : float
        After the depth before [s].

    """
    if at[CLEARANCE] < 0 or s.contacts[0] != 2.0 or not 0.0 < since < o.place_time:
        return False
    C = s.covariance
    two = s.mean[n + 1] + s.mean[n + 2]
    spread = C[n + 1, n + 1] + C[n + 2, n + 2] + 2.0 * C[n + 1, n + 2]
    if not (
        s.mean[0] > o.sure * sqrt(max(C[0, 0], 0.0))
        and s.mean[n] > o.sure * sqrt(max(C[n, n], 0.0))
        and two > o.sure * sqrt(max(spread, 0.0))
    ):
        return False
    E, residual = scratch.E, scratch.residual
    scratch.R[0, 0] = variance * o.place_time / since
    for j in range(s.components):
        scratch.log_likelihood[j] = 0.0
        x = s.x[j]
        if s.alive[j // o.levels] == 0.0 or x[0] <= 0.0:
            continue
        q = scene_at(p, x, at, -s.load[0])
        stands, by_tilt, by_diameter = depth_at(q.d, q.D, x[0])
        residual[0] = depth - stands
        for i in range(n):
            E[0, i] = 0.0
        E[0, 0] = by_tilt
        clearance_slopes(q, x, at, -s.load[0], 0, by_diameter, E)
        off = by_tilt * by_tilt * s.P[j, 0, 0] + variance
        by_clearance = E[0, at[CLEARANCE]]
        off += by_clearance * by_clearance * s.P[j, at[CLEARANCE], at[CLEARANCE]]
        if residual[0] * residual[0] > o.outlier * off:
            continue
        update(
            s.P[j], n, learnt, 0.0, residual, E, scratch.R, 1, scratch.root, scratch.gain,
            scratch.white, scratch.step,
        )  # fmt: skip
        for i in range(n):
            x[i] += scratch.step[i]
    reweigh(s, scratch, o)
    return True
