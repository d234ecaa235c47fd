"""One level and one friction, by sigma points in place of tangents."""

from numpy.typing import ArrayLike

from peg_on_hole_ros.estimator.methods import one_level
from peg_on_hole_ros.estimator.methods.method import of_settings

# The level is the best of `python -m benchmarks rivals`.
SETTINGS: dict[str, ArrayLike] = one_level.SETTINGS | {
    "mode_stddev": (10.0,), "sigma_points": 1.0,
}  # fmt: skip
METHOD = of_settings(SETTINGS)
