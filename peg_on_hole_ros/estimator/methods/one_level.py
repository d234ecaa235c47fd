"""One process-noise mode and one friction hypothesis in place of the mixture."""

from numpy.typing import ArrayLike

from peg_on_hole_ros.estimator.methods.method import of_settings

SETTINGS: dict[str, ArrayLike] = {
    "mode_stddev": (30.0,), "mode_time": (0.05,), "mode_rate": (0.0,), "friction_hypotheses": 1,
}  # fmt: skip
METHOD = of_settings(SETTINGS)
