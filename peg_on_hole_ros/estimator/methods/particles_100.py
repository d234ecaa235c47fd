"""One level and one friction, by a hundred particles at each wrench."""

from numpy.typing import ArrayLike

from peg_on_hole_ros.estimator.methods import one_level
from peg_on_hole_ros.estimator.methods.method import of_settings

SETTINGS: dict[str, ArrayLike] = one_level.SETTINGS | {"particles": 100}
METHOD = of_settings(SETTINGS)
