"""Estimators by name: the default, and settings of it that leave something out."""

from math import inf

from numpy.typing import ArrayLike

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.offsets import Offsets
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.typed_record import Floats

# Accelerations so wide that the wrench alone gives them, held until the next: the process is that
# of the dynamic equations. All noise is white, also that of friction.
_DRIVEN: dict[str, ArrayLike] = {
    "mode_stddev": (1e6,), "mode_time": (inf,), "direction_time": 0.0,
}  # fmt: skip
_ONE_MODE: dict[str, ArrayLike] = {
    "mode_stddev": (30.0,), "mode_time": (0.05,), "mode_rate": (0.0,), "friction_hypotheses": 1,
}  # fmt: skip
SETTINGS: dict[str, dict[str, ArrayLike]] = {
    "mixture": {},
    "one_level": _ONE_MODE,
    "dde_driven": _ONE_MODE | _DRIVEN,
    "quasi_static": _ONE_MODE | {"inertia": 0.0},
}


def make_filter(
    scene: Scene, options: FilterOptions, wrench_noise: Floats, offsets: Offsets | None = None
) -> ContactFilter:
    """Return the estimator that the options name; parameters as for `ContactFilter`."""
    settings = default_settings(**SETTINGS[options.method])
    return ContactFilter(scene, options, wrench_noise, offsets, settings)
