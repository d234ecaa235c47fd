"""Methods by the names that `filter.method` takes: the one place that lists them."""

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.methods import (
    balance,
    dde_driven,
    mixture,
    one_dof,
    one_level,
    particles_100,
    particles_1000,
    quasi_static,
    small_angle,
    two_dof,
    unscented,
)
from peg_on_hole_ros.estimator.methods.method import Method
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.typed_record import Floats

# The default comes first.
METHODS: dict[str, Method] = {
    "mixture": mixture.METHOD,
    "one_level": one_level.METHOD,
    "dde_driven": dde_driven.METHOD,
    "quasi_static": quasi_static.METHOD,
    "balance": balance.METHOD,
    "small_angle": small_angle.METHOD,
    "one_dof": one_dof.METHOD,
    "two_dof": two_dof.METHOD,
    "unscented": unscented.METHOD,
    "particles_100": particles_100.METHOD,
    "particles_1000": particles_1000.METHOD,
}


def make_filter(
    scene: Scene,
    options: FilterOptions,
    wrench_noise: Floats,
    offsets: OffsetUncertainty | None = None,
) -> ContactFilter:
    """Return the estimator that the options name, see `method.Make`."""
    return METHODS[options.method].make(scene, options, wrench_noise, offsets)
