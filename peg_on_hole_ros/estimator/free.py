"""The wrench of a peg that hangs free as a measurement: what it weighs, and the sensor's bias."""

from math import cos, sin

import numpy as np

from peg_on_hole_ros.estimator.state import BIAS, TILT
from peg_on_hole_ros.estimator.update import update
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled
from peg_on_hole_ros.record_types import ScratchRecord, SettingsRecord, StateRecord

# A wrench is not taken for more frequent than this [s].
LEAST_STEP = 1e-4
# Rows of `air` of STATE, each a stretch of wrenches: one is being filled, one waits until no touch
# follows it, one is told.
_FILLED, _WAITS, _TOLD = range(3)
# Its columns: time [s], number, and sums of a wrench less the weight and of its slopes by a tilt.
_TIME, _NUMBER, _WRENCH, _SLOPES = 0, 1, 2, 8


@compiled
def moved_force(p: SceneScalars, o: SettingsRecord, dt: float) -> float:
    """Return the variance of the force of a holder that moves the peg, over a sample [N^2]."""
    return (p.m * o.free_walk) ** 2 / max(dt, LEAST_STEP)


@compiled
def hang(
    s: StateRecord, scratch: ScratchRecord, o: SettingsRecord, p: SceneScalars, at: np.ndarray,
    n: int, learnt: np.ndarray, u: np.ndarray, noise: np.ndarray, bias_map: np.ndarray,
    walk: np.ndarray,
) -> None:  # fmt: skip
    """
    Take a wrench of a peg that hangs free: it tells the bias.

    A touch is seen late, and what it carries until then is no bias. So a stretch of wrenches waits
    until the peg has hung free for another `touch_time`.

    Parameters
    ----------
    s : record of STATE
        Changed; a combination of the mixture is left to do.
    scratch, o, p, at, n, learnt, noise, bias_map
        As for `step.weigh`.
    u : ndarray, shape (6,)
        On the peg about its mass centre, peg axes [N], [N m].
    walk : ndarray, shape (6,)
        Variance that the bias gains in a second.

    """
    _gather(s.air[_FILLED], s.mean, p, u, s.step[0])
    if s.air[_FILLED, _TIME] < o.touch_time:
        return
    for row in (_TOLD, _WAITS):
        for i in range(s.air.shape[1]):
            s.air[row, i] = s.air[row - 1, i]
    s.air[_FILLED, :] = 0.0
    if s.air[_TOLD, _NUMBER] == 0.0:
        return
    # How far the bias has walked from its mean over the stretch.
    since = s.air[_WAITS, _TIME] + s.air[_TOLD, _TIME] / 3.0
    first = at[BIAS]
    for j in range(s.components):
        if s.alive[j // o.levels] == 0.0:
            continue
        x, P = s.x[j], s.P[j]
        _balance(s.air[_TOLD], x, p, o, at, n, noise, bias_map, scratch)
        for i in range(6):
            P[first + i, first + i] -= since * walk[i]
        update(
            P, n, learnt, 0.0, scratch.residual, scratch.E, scratch.R, 6,
            scratch.root, scratch.gain, scratch.white, scratch.step,
        )  # fmt: skip
        for i in range(6):
            P[first + i, first + i] += since * walk[i]
        for i in range(n):
            x[i] += scratch.step[i]


@compiled
def _gather(row, x, p, u, dt):
    """Take a wrench, less the weight at the stated tilt of the hole, into a stretch."""
    s, c, sp, cp, sps, cps = sin(x[0]), cos(x[0]), sin(x[2]), cos(x[2]), sin(x[1]), cos(x[1])
    weight = in_peg_axes(s, c, sp, cp, sps, cps, p.m * p.g_x, p.m * p.g_y, p.m * p.g_z)
    first = in_peg_axes(s, c, sp, cp, sps, cps, 0.0, p.m * p.g_z, -p.m * p.g_y)
    second = in_peg_axes(s, c, sp, cp, sps, cps, -p.m * p.g_z, 0.0, p.m * p.g_x)
    row[_TIME] += dt
    row[_NUMBER] += 1.0
    for i in range(6):
        row[_WRENCH + i] += u[i]
    for i in range(3):
        row[_WRENCH + i] += weight[i]
        row[_SLOPES + i] += first[i]
        row[_SLOPES + 3 + i] += second[i]


@compiled
def _balance(row, x, p, o, at, n, noise, bias_map, scratch):
    """Fill in residual, slopes and noise of a stretch; how the holder moves the peg is noise."""
    E, residual, R, number = scratch.E, scratch.residual, scratch.R, row[_NUMBER]
    dt = max(row[_TIME] / number, LEAST_STEP)
    moved = moved_force(p, o, dt) / number
    turned = max(o.time[o.levels - 1] / dt, 1.0) * (p.Ie * o.level[o.levels // 2]) ** 2 / number
    for i in range(6):
        for k in range(n):
            E[i, k] = 0.0
        for k in range(6):
            R[i, k] = noise[i, k] / number
            E[i, at[BIAS] + k] = -bias_map[i, k]
        R[i, i] += moved if i < 3 else turned
        if at[TILT] >= 0 and i < 3:
            E[i, at[TILT]] = row[_SLOPES + i] / number
            E[i, at[TILT] + 1] = row[_SLOPES + 3 + i] / number
        residual[i] = -row[_WRENCH + i] / number
        for k in range(n):
            residual[i] -= E[i, k] * x[k]


@compiled
def in_peg_axes(
    s: float, c: float, sp: float, cp: float, sps: float, cps: float, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """Return a vector of the hole's axes in those of the peg."""
    h, e = cps * x + sps * y, cps * y - sps * x
    across = c * h + s * z
    return cp * across + sp * e, cp * e - sp * across, c * z - s * h
