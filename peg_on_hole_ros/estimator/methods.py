"""Estimators by name: the default, and settings of it that leave something out."""

from math import inf

import numpy as np

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.held_peg import HeldPeg
from peg_on_hole_ros.estimator.offsets import Offsets
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.mechanics.scene import Scene

# Accelerations so wide that the wrench alone gives them, held until the next: the process is that
# of the dynamic equations. All noise is white, also that of friction.
_DRIVEN = {"level": (1e6,), "time": (inf,), "direction_time": 0.0}
_ONE_LEVEL = {"level": (30.0,), "time": (0.05,), "up": (0.0,), "frictions": 1}
CONSTANTS = {
    "mixture": {},
    "one_level": _ONE_LEVEL,
    "dde_driven": _ONE_LEVEL | _DRIVEN,
    "quasi_static": _ONE_LEVEL | {"inertia": 0.0},
}


def make_filter(
    scene: Scene, options: FilterOptions, wrench_noise: np.ndarray, offsets: Offsets | None = None
) -> HeldPeg:
    """Return the estimator that the options name; parameters as for `HeldPeg`."""
    constants = default_settings(**CONSTANTS[options.method])
    return HeldPeg(scene, options, wrench_noise, offsets, constants)
