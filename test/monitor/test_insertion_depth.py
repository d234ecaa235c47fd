"""Whether a depth is published: tilt, load at the rim and load at the wall have to be certain."""

from math import isfinite

import numpy as np
import pytest

from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.estimator.hole_geometry import depth_at
from peg_on_hole_ros.monitor.insertion_depth import insertion_depth
from peg_on_hole_ros.typed_record import new

D_PEG, D_HOLE = 0.0298, 0.03
# By how many standard deviations each of them is above zero.
CERTAIN, DOUBTFUL = 4.0, 2.0


def estimate(tilt=CERTAIN, rim=CERTAIN, wall=CERTAIN):
    made = new(Estimate)
    made.scene.d, made.scene.D = D_PEG, D_HOLE
    made.motion.gamma, made.motion.covariance[0, 0] = 0.02, (0.02 / tilt) ** 2
    made.reactions.normal[:2] = 12.0, 5.0
    variances = (12.0 / rim) ** 2, (5.0 / wall) ** 2
    made.reactions.covariance[:2, :2] = np.diag(variances)
    return made


def test_a_depth_that_is_certain_is_that_of_the_tilt():
    depth, by_tilt, by_diameter = depth_at(D_PEG, D_HOLE, 0.02)
    told, stddev = insertion_depth(estimate())
    assert told == pytest.approx(depth, rel=1e-12)
    # The diameter is as good as the surface, 1 um.
    expected = np.hypot(by_tilt * 0.02 / CERTAIN, by_diameter * 1e-6)
    assert stddev == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("quantity", ["tilt", "rim", "wall"])
def test_one_quantity_in_doubt_leaves_the_depth_open(quantity):
    told, stddev = insertion_depth(estimate(**{quantity: DOUBTFUL}))
    assert not isfinite(told) and not isfinite(stddev)
