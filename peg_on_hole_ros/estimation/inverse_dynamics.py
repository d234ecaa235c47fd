"""
Fit of the parameters from motion to forces, which works from far off.

The six equations read backwards: accelerations from parabolas through the angles, reactions from
the force balance, and what Lagrange's three equations then lack is the residual. It is smooth in
every parameter, where a filter with a friction 10 % wrong finds the peg wedged.
"""

import numpy as np
from scipy.optimize import least_squares

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimation.likelihood import NAMES, QUANTITIES, configured
from peg_on_hole_ros.estimation.measurement import WrenchReduction
from peg_on_hole_ros.estimation.recording import HALF_WINDOW, Motion, Recording, motion
from peg_on_hole_ros.mechanics.reference import peg_axes, six_equations
from peg_on_hole_ros.options import Configuration

# Neighbouring parabolas share their samples: every such one tells almost all.
STRIDE = 5
COARSE = 6
FRICTIONS = (0.05, 0.15, 0.3, 0.6)
LARGE = 1e3
# So many in a row (0.3 s at 500 Hz) are summed to see how much the scores vary.
BLOCK = 30
# Least spread of the delay [s], carried to the others: the scores promise 0.2 to 0.3 ms, a few
# simulated recordings of one cycle were 0.3 to 1.7 ms off.
DELAY_STDDEV = 1e-3


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
    wrench = reduction.matrix @ (reduction.sign * at - reduction.tare[:, None])
    if configuration.wrench.payload_mass:
        for i, angles in enumerate(q):
            wrench[:, i] += reduction.payload_wrench(peg_axes(angles))
    return wrench


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


def fit(record: Recording, parts, configuration: Configuration, start, free=None):
    """
    Return values of QUANTITIES that fit best, from a start that may be far off, and their spread.

    Parameters
    ----------
    record : Recording
    parts : list of slice
        Joint states to use, from `recording.steady`.
    configuration : Configuration
    start : ndarray, shape (11,)
        Centre of a wide prior, QUANTITIES.range, and what is not free.
    free : ndarray of bool, shape (11,), optional
        What to fit; default all.

    Returns
    -------
    values : ndarray, shape (11,)
    covariance : ndarray, shape (11, 11)
        From how much the scores of blocks of BLOCK vary, at least that of independent parabolas.

    """
    moved = motion(record)
    every = np.concatenate([np.arange(part.start, part.stop, STRIDE) for part in parts])
    free = np.ones(len(start), bool) if free is None else free
    ranges = np.array([quantity.range for quantity in QUANTITIES])
    low, high = bounds(configuration, moved.q[every, 0].min())
    limits = ((low - start) / ranges)[free], ((high - start) / ranges)[free]

    def misfit(x, chosen, scale):
        z = np.zeros(len(start))
        z[free] = x
        try:
            trial = configured(configuration, start + z * ranges)
            found = residuals(record, moved, chosen, trial) / scale[:, None]
        except (PegOnHoleError, np.linalg.LinAlgError):
            return np.full(3 * len(chosen) + len(x), LARGE)
        found = np.clip(np.nan_to_num(found, nan=LARGE), -LARGE, LARGE)
        return np.concatenate([found.T.ravel(), x])

    def search(x, *rest, evaluations=15):
        x = np.clip(x, *limits)
        return least_squares(
            misfit, x, args=rest, bounds=limits, loss="soft_l1", max_nfev=evaluations,
            x_scale="jac", diff_step=1e-4,
        )  # fmt: skip

    few, scale = every[:: max(1, min(COARSE, len(every) // 30))], np.full(3, 1e-2)
    found = []
    for friction in {float(start[0]), *FRICTIONS} if free[0] else {float(start[0])}:
        z = np.zeros(len(start))
        z[0] = (friction - start[0]) / ranges[0]
        found.append(search(z[free], few, scale))
    x = min(found, key=lambda one: one.cost).x
    for _ in range(2):
        z = np.zeros(len(start))
        z[free] = x
        best = configured(configuration, start + z * ranges)
        lacking = np.abs(residuals(record, moved, every, best))
        scale = np.maximum(1.4826 * np.median(lacking, axis=1), 1e-7)
        x = search(x, every, scale, evaluations=40).x
    z = np.zeros(len(start))
    z[free] = x
    spread = np.zeros((len(start), len(start)))
    spread[np.ix_(free, free)] = _covariance(lambda x: misfit(x, every, scale), x)
    spread = spread * np.outer(ranges, ranges)
    at = NAMES.index("delay")
    if free[at] and spread[at, at] < DELAY_STDDEV**2:
        gain = spread[:, at] / spread[at, at]
        spread = spread + np.outer(gain, gain) * (DELAY_STDDEV**2 - spread[at, at])
    return start + z * ranges, spread


def _covariance(misfit, x):
    base = misfit(x)
    slopes = np.empty((len(base), len(x)))
    for i in range(len(x)):
        step = np.where(np.arange(len(x)) == i, 1e-4, 0.0)
        slopes[:, i] = (misfit(x + step) - misfit(x - step)) / 2e-4
    rows = slopes / np.sqrt(1 + base**2)[:, None]
    inverse = np.linalg.inv(rows.T @ slopes)
    scores = (rows * base[:, None])[: len(base) - len(x)]
    blocks = np.add.reduceat(scores, np.arange(0, len(scores), 3 * BLOCK), axis=0)
    blocks = blocks - blocks.mean(axis=0)
    few = len(blocks) / max(len(blocks) - 1, 1)
    sandwich = few * inverse @ (blocks.T @ blocks) @ inverse
    shared = (2 * HALF_WINDOW + 1) / STRIDE
    ratio = np.sqrt(np.maximum(np.diagonal(sandwich) / np.diagonal(inverse), shared))
    return inverse * np.outer(ratio, ratio)


def bounds(configuration: Configuration, least_tilt: float):
    """Return the least and the greatest values that QUANTITIES may take."""
    scene = configuration.scene
    low = np.array([-np.inf] * len(QUANTITIES))
    high = -low
    low[NAMES.index("friction")], high[NAMES.index("friction")] = 1e-4, 2.0
    low[NAMES.index("delay")], high[NAMES.index("delay")] = -0.1, 0.1
    # The least tilt that was seen on three contacts is above gamma0.
    most = scene.hole_diameter * (1 - np.cos(0.99 * least_tilt))
    clearance = scene.hole_diameter - scene.peg_diameter
    low[NAMES.index("clearance")] = 0.05 * clearance
    high[NAMES.index("clearance")] = max(most, 1.001 * clearance)
    return low, high
