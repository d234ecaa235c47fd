"""The wide-prior limit: the dynamic differential equations, driven by the wrench alone."""

from math import inf

from numpy.typing import ArrayLike

from peg_on_hole_ros.estimator.methods import one_level
from peg_on_hole_ros.estimator.methods.method import of_settings

# Accelerations so wide that the wrench alone gives them, held until the next: the process is that
# of the dynamic equations. All noise is white, also that of friction.
_DRIVEN: dict[str, ArrayLike] = {
    "mode_stddev": (1e6,), "mode_time": (inf,), "direction_time": 0.0,
}  # fmt: skip
SETTINGS: dict[str, ArrayLike] = one_level.SETTINGS | _DRIVEN
METHOD = of_settings(SETTINGS)
