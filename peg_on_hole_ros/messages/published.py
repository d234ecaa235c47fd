"""The numbers of what is published with every estimate, out of its row by one compiled call."""

from math import nan, sqrt

import numpy as np

from peg_on_hole_ros.estimator import description as at
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.messages.output import POSE_FLOOR
from peg_on_hole_ros.messages.plain import fill_quaternion
from peg_on_hole_ros.monitor.output_row import AT, MODE, MONITOR, MONITOR_NAMES
from peg_on_hole_ros.monitor.outputs import are_closed
from peg_on_hole_ros.monitor.states import Mode

# How many numbers each topic has, in the order in which they are published.
WIDTHS = {
    "state": 6,
    "state_stddev": 6,
    "contacts": 9,
    "contacts_stddev": 6,
    "monitor": len(MONITOR_NAMES),
    "contact/k": 6,
    "contact/b1": 6,
    "contact/b2": 6,
    "pose": 43,
}
_STATE_STDDEV, _CONTACTS, _CONTACTS_STDDEV, _MONITOR, _WRENCHES, _, _, POSE, SIZE = np.cumsum(
    list(WIDTHS.values())
).tolist()
_NAMES, _DETERMINED = len(MONITOR_NAMES), AT.reactions_determined
_closed = compiled(are_closed)
_FLOOR = np.ascontiguousarray(np.diagonal(POSE_FLOOR))


def published(rows: np.ndarray) -> np.ndarray:
    """
    Return the numbers of the messages of many stamps, in their order, shape (n, SIZE).

    Parameters
    ----------
    rows : ndarray, shape (n, output_row.SIZE)

    """
    out = np.empty((len(rows), SIZE))
    _fill_all(np.ascontiguousarray(rows), _FLOOR, out)
    return out


def publish_row(row: np.ndarray, out: np.ndarray) -> None:
    """Fill in the same of one stamp, shape (SIZE,)."""
    fill_published(row, _FLOOR, out)


@compiled
def fill_published(row: np.ndarray, floor: np.ndarray, out: np.ndarray) -> None:
    """Fill in the numbers of one stamp; `floor` is added to the variances of the pose."""
    known = row[_DETERMINED] == 1.0 or row[MODE] == Mode.OPEN.value
    for i in range(6):
        out[i] = row[at.STATE + i]
        # Rounding may leave a variance of zero a hair below it.
        out[_STATE_STDDEV + i] = sqrt(max(row[at.COVARIANCE + 7 * i], 0.0))
    for i in range(3):
        out[_CONTACTS + i] = 1.0 if _closed(row[MODE], row[at.NORMAL + i]) else 0.0
        out[_CONTACTS + 3 + i] = row[at.SLIP + i]
        out[_CONTACTS + 6 + i] = row[at.NORMAL + i] if known else nan
        out[_CONTACTS_STDDEV + i] = row[at.SLIP_STDDEV + i]
        out[_CONTACTS_STDDEV + 3 + i] = row[at.STDDEV + i]
        X, Y, Z = row[at.FORCE + 3 * i], row[at.FORCE + 3 * i + 1], row[at.FORCE + 3 * i + 2]
        if not known:
            X = Y = Z = nan
        x, y, z = row[at.POINT + 3 * i], row[at.POINT + 3 * i + 1], row[at.POINT + 3 * i + 2]
        to = _WRENCHES + 6 * i
        out[to], out[to + 1], out[to + 2] = X, Y, Z
        out[to + 3], out[to + 4], out[to + 5] = y * Z - z * Y, z * X - x * Z, x * Y - y * X
        out[POSE + i] = row[at.POSITION + i]
    for i in range(_NAMES):
        out[_MONITOR + i] = row[MONITOR + i]
    fill_quaternion(row, at.ROTATION, out, POSE + 3)
    for i in range(36):
        out[POSE + 7 + i] = row[at.POSE + i]
    for i in range(6):
        out[POSE + 7 + 7 * i] += floor[i]


@compiled
def _fill_all(rows, floor, out):
    for n in range(len(rows)):
        fill_published(rows[n], floor, out[n])
