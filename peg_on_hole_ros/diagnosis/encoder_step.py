"""The step of an encoder: the grid on which all values of a joint lie."""

import numpy as np

from peg_on_hole_ros.diagnosis.tuned import ENCODER_STEP


def encoder_steps(values: np.ndarray) -> np.ndarray:
    """
    Return the step of each joint.

    Joints whose least distances agree are of one grid, and count together: an arm that hardly
    moves shows few steps of each.

    Parameters
    ----------
    values : ndarray, shape (n, joints)
        As received, in the order in which they came [rad or m]; NaN: not read.

    Returns
    -------
    ndarray, shape (joints,)
        [rad or m]; 0: there is none, or it does not show.

    """
    apart = [_distances(column) for column in values.T]
    least = np.array([each.min() if len(each) else 0.0 for each in apart])
    steps = np.zeros(len(apart))
    for i, step in enumerate(least):
        if step == 0.0:
            continue
        alike = [k for k, other in enumerate(least) if abs(other - step) < ENCODER_STEP.off * step]
        together = np.concatenate([apart[k] for k in alike])
        off = np.abs(together / step - np.round(together / step))
        if len(together) >= ENCODER_STEP.distances and off.max() < ENCODER_STEP.off:
            steps[i] = step
    return steps


def _distances(values):
    """Return the distances between distinct values; none where they hardly repeat."""
    distinct = np.unique(values[np.isfinite(values)])
    apart = np.diff(distinct)
    # Values of one step that differ by rounding are one.
    apart = apart[apart > ENCODER_STEP.rounding]
    # A motion without noise at one speed lies on a grid too, but comes to a value only once.
    return apart if len(apart) + 1 <= ENCODER_STEP.distinct * len(values) else apart[:0]
