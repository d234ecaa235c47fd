"""Noise of the sensors from what differences of neighbouring samples leave: a first guess."""

from math import sqrt

import numpy as np

from peg_on_hole_ros.estimation.identification.recording import Recording

# Fourth differences of white noise have 70 times its variance (the squares of 1 4 6 4 1), and
# those of a motion that is smooth over five samples are nothing beside it.
WEIGHTS = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
# A median over blocks of so many ignores the blocks with impacts.
BLOCK = 100
FEWEST_BLOCKS = 3


def noise_levels(record: Recording) -> tuple[float | None, float | None, float | None]:
    """
    Return the noise of force [N], torque [N m], and of the orientation, as standard deviations.

    The last in units of the covariance in the recording: 1 if that is right. None where there are
    too few samples in a row.
    """
    force, torque = (
        _level(record.wrench_t, record.wrench[:, part]) for part in (slice(0, 3), slice(3, 6))
    )
    # The orientation's error is isotropic, that of (gamma, psi, phi) is not.
    root = np.linalg.inv(np.linalg.cholesky(record.covariance))
    return force, torque, _level(record.joint_t, record.q, root)


def _level(t, values, root=None):
    n = len(t)
    if n < FEWEST_BLOCKS * BLOCK:
        return None
    differences = sum(weight * values[i : n - 4 + i] for i, weight in enumerate(WEIGHTS))
    if root is not None:
        differences = np.einsum("nij,nj->ni", root[2:-2], differences)
    # Differences of samples that are not evenly spaced are not those of the table.
    regular = np.convolve(np.diff(t) > 1.5 * np.median(np.diff(t)), np.ones(4), "valid") == 0
    variances = (differences[regular] ** 2).mean(axis=1) / (WEIGHTS**2).sum()
    blocks = len(variances) // BLOCK
    if blocks < FEWEST_BLOCKS:
        return None
    # The median of so wide a mean lies below it by 1 %.
    return sqrt(np.median(variances[: blocks * BLOCK].reshape(blocks, -1).mean(axis=1)))
