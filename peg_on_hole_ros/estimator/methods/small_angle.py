"""The balance of forces, with the lengths of a small tilt."""

from numpy.typing import ArrayLike

from peg_on_hole_ros.estimator.methods import balance
from peg_on_hole_ros.estimator.methods.method import of_settings

SETTINGS: dict[str, ArrayLike] = balance.SETTINGS | {"small_tilt": 1.0}
METHOD = of_settings(SETTINGS)
