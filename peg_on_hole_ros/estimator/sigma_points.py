"""A measurement at sigma points in place of tangents: the unscented update (Julier, Uhlmann)."""

from math import sqrt

from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.scratch import PointScratch
from peg_on_hole_ros.estimator.update import apply_gain
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.linear_algebra import factor_cholesky
from peg_on_hole_ros.typed_record import Floats

# Of the mean among the points, in what they differ by: 3 - 1, as of a normal distribution. Its
# weight in their mean is zero, so that all weights are positive and no covariance is lost.
_MEANS_WEIGHT = 2.0


@compiled
def draw_sigma_points(points: PointScratch, x: Floats, P: Floats, w: int) -> None:
    """
    Fill in the mean and w points either way of it, at sqrt(w) deviations along a root's columns.

    Parameters
    ----------
    points : PointScratch
        `x` is filled in, 2 w + 1 rows, and `root`.
    x, P : ndarray
        Mean and covariance of a component.
    w : int
        How many values are drawn.

    """
    root, far = points.root, sqrt(float(w))
    for i in range(w):
        points.x[0, i] = x[i]
        for j in range(i + 1):
            root[i, j] = P[i, j]
    factor_cholesky(root, w)
    for k in range(w):
        above, below = points.x[1 + k], points.x[1 + w + k]
        for i in range(w):
            off = far * root[i, k] if i >= k else 0.0
            above[i], below[i] = x[i] + off, x[i] - off


@compiled
def update_by_sigma_points(
    kalman: FilterRecord, estimated: Floats, P: Floats, w: int, k: int
) -> tuple[float, float]:
    """
    Update a covariance by how much a measurement is off at each sigma point.

    Parameters
    ----------
    kalman : FilterRecord
        `scratch.points` has them and their `residual`, which the truth makes zero but for noise of
        the covariance `scratch.noise`; filled is what `update` fills.
    estimated, P, w, k
        As for `update`.

    Returns
    -------
    log_likelihood, nis : float

    """
    scratch, points = kalman.scratch, kalman.scratch.points
    off, gain, S, innovation = points.residual, scratch.gain, scratch.cholesky, scratch.residual
    weight = 0.5 / w
    for a in range(k):
        t = 0.0
        for i in range(1, 2 * w + 1):
            t += off[i, a]
        innovation[a] = -weight * t
    for a in range(k):
        for b in range(a + 1):
            t = _MEANS_WEIGHT * (off[0, a] + innovation[a]) * (off[0, b] + innovation[b])
            for i in range(1, 2 * w + 1):
                t += weight * (off[i, a] + innovation[a]) * (off[i, b] + innovation[b])
            S[a, b] = scratch.noise[a, b] + t
        row = gain[a]
        for j in range(w):
            row[j] = 0.0
        for i in range(w):
            # Of two points that are opposite.
            change, above = weight * (off[1 + i, a] - off[1 + w + i, a]), points.x[1 + i]
            for j in range(w):
                row[j] += change * (above[j] - points.x[0, j])
    return apply_gain(kalman, estimated, P, w, k, 0.0)
