"""Samples that nothing around them explains, left out before anything is made of a recording."""

from collections.abc import Sequence

import numpy as np

from peg_on_hole_ros.identification.tuned import SPIKE_TEST
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample

# A sample is held against lines through two others each, so many samples before or after it. One
# of them at least passes by an outlier, or two in a row; three in a row are a motion or a load.
_LINES = ((-3, -2), (-2, -1), (-1, 1), (1, 2), (2, 3))


def without_spikes(wrenches: Sequence[WrenchSample]) -> list[WrenchSample]:
    """Return wrenches in the order of their stamps without those that are far off for a moment."""
    t = _seconds(wrenches)
    values = np.array([[*sample.force, *sample.torque] for sample in wrenches]).reshape(-1, 6)
    return _sound(wrenches, outliers(t, values[:, :3]) | outliers(t, values[:, 3:]))


def without_jumps(measurements: Sequence[AngleMeasurement]) -> list[AngleMeasurement]:
    """Return orientations in the order of their stamps without those that are far off."""
    if not measurements:
        return []
    q = np.array([each.q for each in measurements])
    q[:, 1:] = np.unwrap(q[:, 1:], axis=0)
    covariance = np.array([each.covariance for each in measurements])
    # psi and phi alone are noise near the upright.
    white = np.linalg.inv(np.linalg.cholesky(covariance))
    return _sound(measurements, outliers(_seconds(measurements), q, white))


def outliers(t: np.ndarray, values: np.ndarray, white: np.ndarray | None = None) -> np.ndarray:
    """
    Return which samples are far off what those around them make of them, shape (n,).

    No model is asked: a calibration begins with one that is wrong. A value that repeats bit for
    bit, as of a slower sensor, is one sample.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Stamps, rising [s].
    values : ndarray, shape (n, k)
    white : ndarray, shape (n, k, k), optional
        What makes the noise of each sample that of unit variance.

    """
    found = np.zeros(len(t), bool)
    if len(t) < 2 * SPIKE_TEST.beside:
        return found
    first = np.r_[True, (np.diff(values, axis=0) != 0.0).any(axis=1)]
    place, rows = np.cumsum(first) - 1, np.flatnonzero(first)
    left = rows
    while len(left) >= 2 * SPIKE_TEST.beside:
        away = _away(t[left], values[left], None if white is None else white[left])
        far = away > SPIKE_TEST.far * np.maximum(np.median(away), _usual(away))
        if not far.any():
            break
        left = left[~far]
    kept = np.zeros(len(rows), bool)
    kept[place[left]] = True
    return ~kept[place]


def _away(t, values, white):
    """Return how far off the nearest of its lines each sample is, shape (n,)."""
    n, nearest = len(t), np.full(len(t), np.inf)
    for a, b in _LINES:
        i = np.arange(max(0, -a), n - max(0, b))
        share = (t[i] - t[i + a]) / (t[i + b] - t[i + a])
        off = values[i] - values[i + a] - share[:, None] * (values[i + b] - values[i + a])
        if white is not None:
            off = np.einsum("nij,nj->ni", white[i], off)
        nearest[i] = np.minimum(nearest[i], np.linalg.norm(off, axis=1))
    return nearest


def _usual(away):
    """Return the median over some samples on either side of each, shape (n,)."""
    padded = np.pad(away, SPIKE_TEST.beside, mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * SPIKE_TEST.beside + 1)
    return np.median(windows, axis=1)


def _seconds(samples):
    t_ns = np.array([sample.t_ns for sample in samples], np.int64)
    return (t_ns - t_ns[:1]) * 1e-9


def _sound(samples, found):
    return [sample for sample, off in zip(samples, found) if not off]
