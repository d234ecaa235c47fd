"""Noise of the sensors, from what differences of neighbouring samples leave."""

from math import log, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.identification.low_pass import white_ratio
from peg_on_hole_ros.identification.recording import Recording
from peg_on_hole_ros.identification.tuned import NOISE_BLOCKS

# Fourth differences of white noise have 70 times its variance (the squares of 1 4 6 4 1), and
# those of a motion that is smooth over five samples are nothing beside it.
WEIGHTS = np.array([1.0, -4.0, 6.0, -4.0, 1.0])


class NoiseLevel(NamedTuple):
    """Logarithm of a standard deviation, and how well it is known."""

    log: float
    stddev: float


def noise_levels(
    record: Recording, pole: float = 0.0
) -> tuple[NoiseLevel | None, NoiseLevel | None, NoiseLevel | None]:
    """
    Return the noise of force [N], torque [N m], and of the orientation.

    The last in units of the covariance in the recording: 1 if that is right. None where there are
    too few samples in a row.

    Parameters
    ----------
    record : Recording
    pole : float
        Of a low-pass before the wrench, whose noise is stated as white noise of its density.

    """
    force, torque = (
        _wider(_level(record.wrench_t, record.wrench[:, part]), pole)
        for part in (slice(0, 3), slice(3, 6))
    )
    # The orientation's error is isotropic, that of (gamma, psi, phi) is not.
    root = np.linalg.inv(np.linalg.cholesky(record.covariance))
    return force, torque, _level(record.joint_t, record.q, root)


def _wider(level: NoiseLevel | None, pole: float) -> NoiseLevel | None:
    return level and level._replace(log=level.log + log(white_ratio(pole, WEIGHTS)))


def _level(t, values, root=None):
    n, block, fewest = len(t), NOISE_BLOCKS.block, NOISE_BLOCKS.fewest_blocks
    if n < fewest * block:
        return None
    differences = sum(weight * values[i : n - 4 + i] for i, weight in enumerate(WEIGHTS))
    if root is not None:
        differences = np.einsum("nij,nj->ni", root[2:-2], differences)
    # Differences of samples that are not evenly spaced are not those of the table.
    gap = np.diff(t) > NOISE_BLOCKS.gap_periods * np.median(np.diff(t))
    regular = np.convolve(gap, np.ones(4), "valid") == 0
    variances = (differences[regular] ** 2).mean(axis=1) / (WEIGHTS**2).sum()
    blocks = len(variances) // block
    if blocks < fewest:
        return None
    means = variances[: blocks * block].reshape(blocks, -1).mean(axis=1)
    middle = float(np.median(means))
    if not middle > 0.0:
        return None
    # A normal spread by its quartiles, and of a median what it leaves of that of a mean. The
    # median of so wide a mean lies below it by 1 %.
    spread = np.subtract(*np.quantile(means, (0.75, 0.25))) / 1.349
    stddev = 0.5 * 1.2533 * float(spread) / middle / sqrt(blocks) + NOISE_BLOCKS.floor
    return NoiseLevel(0.5 * log(middle), stddev)
