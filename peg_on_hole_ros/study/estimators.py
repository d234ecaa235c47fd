"""The estimators that are charted: methods by name, parts of the default left out, and others."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.methods import dde_driven
from peg_on_hole_ros.estimator.methods.method import Method, of_settings
from peg_on_hole_ros.estimator.methods.registry import METHODS, make_filter
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.study.smoothed import make_fixed_lag, make_smoothed

# Thousands of times what one wrench tells of an acceleration [rad/s^2].
DDE_LEVEL = 1e5
# Of the default's levels the one in the middle [rad/s^2].
MIDDLE_LEVEL = 30.0


class Estimator(NamedTuple):
    """
    A row of the chart's table.

    Attributes
    ----------
    name : str
        Of `filter.method`, where it is one.
    rate : int
        Wrenches that it is given [Hz], and as many orientations, at most 500.
    method : Method or None
        None: the bare balance, which is no estimator of the pipeline.
    shown : bool
        It is a point of the pictures.
    part : bool
        It is the default with a part left out.

    """

    name: str
    rate: int
    method: Method | None
    shown: bool = True
    part: bool = False

    @property
    def judges(self) -> bool:
        """Whether it may be run without being told that the peg is on three contacts."""
        return self.method is not None and self.method.settings is not None

    def __str__(self) -> str:
        """Return what it is called in tables."""
        return f"{self.name}, {'1 kHz' if self.rate == 1000 else f'{self.rate} Hz'}"


def by_method(
    method: str,
    scene: Scene,
    options: FilterOptions,
    wrench_noise: np.ndarray,
    offsets: OffsetUncertainty | None = None,
) -> ContactFilter:
    """Return the estimator of a method, whatever the options name."""
    return make_filter(scene, replace(options, method=method), wrench_noise, offsets)


# The estimator in which the wrench alone drives the motion. With the level of the method, 1e6,
# rates are lost before the first wrench is used.
DDE_DRIVEN = of_settings(dde_driven.SETTINGS | {"mode_stddev": (DDE_LEVEL,)})
WRENCH_RATES = (1000, 500, 100)
DEFAULT = Estimator("mixture", WRENCH_RATES[0], METHODS["mixture"])
BARE = "bare balance"
# The level of accelerations with which each is nearest while the bounds of its reactions hold
# [rad/s^2], by `python -m benchmarks rivals`. Those of `filter.method`, 30, hold in more motions.
NEAREST_LEVELS = {
    "one_level": 3.0, "quasi_static": 3.0, "balance": 3.0, "small_angle": 3.0, "one_dof": 3.0,
    "two_dof": 3.0, "unscented": 10.0, "particles_100": 3.0, "particles_1000": 3.0,
}  # fmt: skip
_OTHERS: dict[str, Method | None] = {
    **{
        name: of_settings({**(METHODS[name].settings or {}), "mode_stddev": (level,)})
        for name, level in NEAREST_LEVELS.items()
    },
    "dde_driven": DDE_DRIVEN,
    "fixed lag": Method(make_fixed_lag),
    "smoother": Method(make_smoothed),
    BARE: None,
}
# What a part of the default earns: the default without it.
LEFT_OUT: dict[str, Method] = {
    "one level": of_settings(
        {"mode_stddev": (MIDDLE_LEVEL,), "mode_time": (0.05,), "mode_rate": (0.0,)}
    ),
    "one friction": of_settings({"friction_hypotheses": 1}),
    "no products": of_settings({"products": 0.0}),
    "mean slip": of_settings({"direction_share": 0.0}),
}
# Smoothers have no step to be a point, and the others are no more than one point among them.
_NOT_SHOWN = ("quasi_static", "particles_100", "fixed lag", "smoother")
# Of all but the default the fastest alone is drawn.
ESTIMATORS = (
    *(DEFAULT._replace(rate=rate) for rate in WRENCH_RATES),
    *(
        Estimator(name, rate, method, rate == WRENCH_RATES[0] and name not in _NOT_SHOWN)
        for name, method in _OTHERS.items()
        for rate in WRENCH_RATES
    ),
    *(Estimator(name, WRENCH_RATES[0], part, part=True) for name, part in LEFT_OUT.items()),
)
