"""The default: a mixture of friction hypotheses and of process-noise modes."""

from numpy.typing import ArrayLike

from peg_on_hole_ros.estimator.methods.method import of_settings

SETTINGS: dict[str, ArrayLike] = {}
METHOD = of_settings(SETTINGS)
