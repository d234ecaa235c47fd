"""What a configuration leaves open, of the quantities that the estimator has places for."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.typed_record import Floats


class OpenQuantities(NamedTuple):
    """
    What a configuration leaves open, k values.

    Attributes
    ----------
    names : list of str
        Of `state.OPENABLE_QUANTITIES`, in their order.
    stddev : ndarray, shape (k,)
        Stated standard deviations.
    walk : ndarray, shape (k,)
        By how much each walks per root second.
    estimated : list of bool
        Whether each is estimated, or only considered.

    """

    names: list[str]
    stddev: Floats
    walk: Floats
    estimated: list[bool]


def open_quantities(
    scene: Scene, options: FilterOptions, offsets: OffsetUncertainty
) -> OpenQuantities:
    """Return what a configuration leaves open."""
    clearance = scene.hole_diameter - scene.peg_diameter
    rows: list[tuple[str, Sequence[float] | Floats, Sequence[float] | Floats, bool]] = [
        (
            "clearance",
            [scene.clearance_stddev / clearance],
            [scene.clearance_drift / clearance],
            options.clearance == "estimated",
        ),
        ("friction_k", [scene.friction_k_stddev], [0.0], True),
        ("bias", np.sqrt(offsets.variance[:6]), offsets.bias_drift, offsets.bias_learnt),
        ("tilt", np.sqrt(offsets.variance[6:]), [0.0] * 2, offsets.tilt_learnt),
        ("delay", [offsets.delay_stddev], [0.0], False),
        ("compliance", [scene.compliance_stddev], [0.0], True),
    ]
    found = OpenQuantities([], np.zeros(0), np.zeros(0), [])
    for name, stddev, walk, estimated in rows:
        if np.any(stddev) or np.any(walk):
            found = OpenQuantities(
                [*found.names, name],
                np.append(found.stddev, stddev),
                np.append(found.walk, walk),
                [*found.estimated, *[estimated] * len(stddev)],
            )
    return found
