"""Noise of the sensors from the noise itself: what differences of neighbouring samples leave."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.recording import Recording

# Fourth differences of white noise have 70 times its variance (the squares of 1 4 6 4 1), and
# those of a motion that is smooth over five samples are nothing beside it.
WEIGHTS = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
GAIN = float((WEIGHTS**2).sum())
# They overlap: so many of them tell as much as one independent value (sum of the squares of
# their autocorrelation, C(16,8)/C(8,4)^2).
OVERLAP = 12870 / 4900
BLOCK = 100
# A median over blocks ignores the blocks with impacts, and tells as much as 64 % of the samples.
MEDIAN_EFFICIENCY = 2 / np.pi
FEWEST_BLOCKS = 3


class Level(NamedTuple):
    """
    One noise level.

    Attributes
    ----------
    value, stddev : float
        Standard deviation of the noise, and that of this figure.

    """

    value: float
    stddev: float


def noise_levels(record: Recording) -> tuple[Level | None, Level | None, Level | None]:
    """
    Return the noise of force [N], torque [N m], and of the orientation.

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
    differences = sum(weight * values[i : n - 4 + i] for i, weight in enumerate(WEIGHTS)) / sqrt(
        GAIN
    )
    if root is not None:
        differences = np.einsum("nij,nj->ni", root[2:-2], differences)
    # Differences of samples that are not evenly spaced are not those of the table.
    period = np.median(np.diff(t))
    regular = np.convolve(np.diff(t) > 1.5 * period, np.ones(4), "valid") == 0
    if period <= 0:
        return None
    differences = differences[regular]
    blocks = len(differences) // BLOCK
    if blocks < FEWEST_BLOCKS:
        return None
    variances = (differences[: blocks * BLOCK] ** 2).reshape(blocks, -1).mean(axis=1)
    degrees = 3 * BLOCK / OVERLAP
    # Median of a chi-squared variable over its mean (Wilson and Hilferty).
    variance = np.median(variances) / (1 - 2 / (9 * degrees)) ** 3
    spread = sqrt(2 / (degrees * blocks * MEDIAN_EFFICIENCY))
    return Level(sqrt(variance), sqrt(variance) * spread / 2)
