"""One level and one friction, by sigma points in place of tangents."""

from numpy.typing import ArrayLike

from peg_on_hole_ros.estimator.methods import one_level
from peg_on_hole_ros.estimator.methods.method import of_settings

SETTINGS: dict[str, ArrayLike] = one_level.SETTINGS | {"sigma_points": 1.0}
METHOD = of_settings(SETTINGS)
