"""A peg that tilts and turns about its own axis: it does not slide round the rim."""

from numpy.typing import ArrayLike

from peg_on_hole_ros.estimator.methods import one_level
from peg_on_hole_ros.estimator.methods.method import of_settings

SETTINGS: dict[str, ArrayLike] = one_level.SETTINGS | {"psi_moves": 0.0}
METHOD = of_settings(SETTINGS)
