"""
First guess of the parameters, from motion to forces, which works from far off.

The six equations read backwards: accelerations from parabolas through the angles, reactions from
the force balance, and what Lagrange's three equations then lack is the residual. It is smooth in
every parameter, where a filter with a friction 10 % wrong finds the peg wedged.
"""

import numpy as np
from scipy.optimize import least_squares

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimation.identification.likelihood import (
    FRICTION,
    IS_NOISE,
    TILT,
    Measures,
    configured,
    coordinates,
)
from peg_on_hole_ros.estimation.identification.recording import (
    HALF_WINDOW,
    Motion,
    Recording,
    motion,
)
from peg_on_hole_ros.estimation.measurement import WrenchReduction
from peg_on_hole_ros.mechanics.reference import six_equations
from peg_on_hole_ros.options import Configuration

# Neighbouring parabolas share their samples: every such one tells almost all.
STRIDE = 5
COARSE = 6
FRICTIONS = (0.05, 0.15, 0.3, 0.6)
LARGE = 1e3


def on_peg(record: Recording, t, q, configuration: Configuration) -> np.ndarray:
    """Return the smoothed wrench at times t [s], angles q, on the peg in its axes, (6, n)."""
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    # As wide as the parabolas of the angles.
    wide = 2 * HALF_WINDOW + 1
    periods = np.median(np.diff(record.joint_t)) / np.median(np.diff(record.wrench_t))
    count = 2 * (round(wide * periods) // 2) + 1
    total = np.cumsum(np.vstack([np.zeros(6), record.wrench]), axis=0)
    low = np.clip(np.arange(len(record.wrench)) - count // 2, 0, None)
    high = np.clip(low + count, None, len(record.wrench))
    smooth = (total[high] - total[low]) / (high - low)[:, None]
    at = np.array([np.interp(t, record.wrench_t, column) for column in smooth.T])
    if configuration.wrench.payload_mass:
        rows = (reduction.on_peg(row[:3], row[3:], angles) for row, angles in zip(at.T, q))
        return np.array(list(rows)).T
    return reduction.matrix @ (reduction.sign * at - reduction.tare[:, None])


def residuals(record, moved: Motion, chosen, configuration: Configuration) -> np.ndarray:
    """Return what Lagrange's equations lack at chosen joint states [N m], shape (3, n)."""
    scene = configuration.scene
    q, rates, acc = (part[chosen].T for part in moved[:3])
    t = record.joint_t[chosen] - configuration.joints.delay
    wrench = on_peg(record, t, q.T, configuration)
    A, r = six_equations(scene, q, rates, wrench, configuration.filter.slip_velocity_scale)
    A, r = np.moveaxis(A, -1, 0), r.T
    motion_part = np.einsum("nij,jn->ni", A[:, :, :3], acc)
    lacking = r - motion_part
    normal = np.linalg.solve(A[:, 3:, 3:], lacking[:, 3:, None])
    return (lacking[:, :3, None] - A[:, :3, 3:] @ normal)[:, :, 0].T


def fit(
    record: Recording, parts, configuration: Configuration, limits, measures: Measures
) -> np.ndarray:
    """
    Return coordinates that fit well, shape (14,), from a configuration that may be far off.

    Parameters
    ----------
    record : Recording
    parts : list of slice
        Joint states to use, from `recording.steady`.
    configuration : Configuration
        Centre of a wide prior, `measures.range`; noise and tilt stay as they are.
    limits : tuple of ndarray, shape (14,)
        Least and greatest coordinates.
    measures : Measures

    """
    moved = motion(record)
    every = np.concatenate([np.arange(part.start, part.stop, STRIDE) for part in parts])
    start = coordinates(configuration)
    free = ~IS_NOISE
    free[TILT] = False
    ranges = measures.range
    bounds = tuple(((limit - start) / ranges)[free] for limit in limits)

    def coordinates_at(z):
        x = start.copy()
        x[free] += z * ranges[free]
        # Rounding leads beyond a limit to which z is scaled.
        return np.clip(x, *limits)

    def misfit(z, chosen, scale):
        try:
            trial = configured(configuration, coordinates_at(z))
            found = residuals(record, moved, chosen, trial) / scale[:, None]
        except (PegOnHoleError, np.linalg.LinAlgError):
            return np.full(3 * len(chosen) + len(z), LARGE)
        found = np.clip(np.nan_to_num(found, nan=LARGE), -LARGE, LARGE)
        return np.concatenate([found.T.ravel(), z])

    def search(z, *rest, evaluations=15):
        return least_squares(
            misfit, np.clip(z, *bounds), args=rest, bounds=bounds, loss="soft_l1",
            max_nfev=evaluations, x_scale="jac", diff_step=1e-4,
        )  # fmt: skip

    few, scale = every[:: max(1, min(COARSE, len(every) // 30))], np.full(3, 1e-2)
    found = []
    for friction in {float(start[FRICTION]), *FRICTIONS}:
        z = np.zeros(free.sum())
        z[FRICTION] = (friction - start[FRICTION]) / ranges[FRICTION]
        found.append(search(z, few, scale))
    z = min(found, key=lambda one: one.cost).x
    for _ in range(2):
        best = configured(configuration, coordinates_at(z))
        lacking = np.abs(residuals(record, moved, every, best))
        scale = np.maximum(1.4826 * np.median(lacking, axis=1), 1e-7)
        z = search(z, every, scale, evaluations=40).x
    return coordinates_at(z)
