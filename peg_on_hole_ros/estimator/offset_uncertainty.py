"""What is not known of the sensor's bias, of the hole's direction and of the clocks."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.typed_record import Floats


class OffsetUncertainty(NamedTuple):
    """
    What is not known of the sensor's bias, of the hole's direction and of the clocks.

    Attributes
    ----------
    variance : ndarray, shape (8,)
        Of force bias [N^2], torque bias [N^2 m^2], as the sensor reports them, and of the tilt of
        the hole about its configured x and y [rad^2]; 0: known.
    load : ndarray, shape (6, 6)
        From a bias to what has to be added to the wrench about the mass centre, peg axes.
    bias_drift : ndarray, shape (6,)
        By which the bias walks [N], [N m] per root second.
    bias_learnt, tilt_learnt : bool
        Whether they are estimated, or only widen the bounds.
    delay_stddev : float
        Of the delay between joint states and wrench [s].

    """

    variance: Floats
    load: Floats
    bias_drift: Floats
    bias_learnt: bool = True
    tilt_learnt: bool = True
    delay_stddev: float = 0.0

    @staticmethod
    def all_known() -> "OffsetUncertainty":
        """Return the offsets of a cell in which all of them are known."""
        return OffsetUncertainty(np.zeros(8), np.zeros((6, 6)), np.zeros(6))
