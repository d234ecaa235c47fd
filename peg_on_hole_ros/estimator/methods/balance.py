"""A balance of forces: motion from orientations, and the reactions that each wrench leaves."""

from numpy.typing import ArrayLike

from peg_on_hole_ros.estimator.methods import one_level
from peg_on_hole_ros.estimator.methods.method import of_settings

SETTINGS: dict[str, ArrayLike] = one_level.SETTINGS | {"inertia": 0.0, "wrench_moves": 0.0}
METHOD = of_settings(SETTINGS)
