"""What all members are given of a wrench."""

from typing import NamedTuple

from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.measurements.freshness import Oriented
from peg_on_hole_ros.typed_record import Floats


class Received(NamedTuple):
    """
    A wrench as it was received, and what is known at its stamp.

    Attributes
    ----------
    t_ns : int
        Stamp [ns].
    values : ndarray, shape (6,)
        Force and torque as received [N], [N m].
    variance : ndarray, shape (6,)
        As stated [N^2], [N^2 m^2].
    in_air : bool
        Whether the contact mode is `open`.
    oriented : Oriented
        The latest orientation.
    settings : Settings
        Of the estimator: how fast a ratio of variances is tracked.

    """

    t_ns: int
    values: Floats
    variance: Floats
    in_air: bool
    oriented: Oriented
    settings: Settings
