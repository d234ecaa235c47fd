"""Estimators by name: the default, and settings of it that leave something out."""

from peg_on_hole_ros.estimator.held_peg import HeldPeg
from peg_on_hole_ros.estimator.settings import default_settings

# Accelerations so wide that the wrench alone gives them: the process is the dynamic equations'.
_WIDE = 1e6
_ONE_LEVEL = {"level": (30.0,), "time": (0.05,), "up": (0.0,), "frictions": 1}
CONSTANTS = {
    "mixture": {},
    "one_level": _ONE_LEVEL,
    "dde_driven": {"level": (_WIDE,), "time": (0.02,), "up": (0.0,), "frictions": 1},
    "quasi_static": _ONE_LEVEL | {"inertia": 0.0},
}


def make_filter(scene, options, wrench_noise, offsets=None) -> HeldPeg:
    """Return the estimator that the options name; parameters as for `HeldPeg`."""
    constants = default_settings(**CONSTANTS[options.method])
    return HeldPeg(scene, options, wrench_noise, offsets, constants)
