"""What a run of a cell leaves; needs no MuJoCo."""

from typing import NamedTuple

import numpy as np

D, d, H, PEG_MASS, GRAVITY = 0.050, 0.0498, 0.070, 0.5, 9.80665
GAMMA0 = float(np.arccos(d / D))


class Rows(NamedTuple):
    """
    What a run leaves, one row for each millisecond.

    Attributes
    ----------
    t : ndarray, shape (n,)
        [s]
    drives : ndarray, shape (n, joints)
        Angles at the drives, where encoders are [rad].
    sensor : ndarray, shape (n, 6)
        Mean force and torque of the robot's side on the peg's over the millisecond, sensor axes.
    axes : ndarray, shape (n, 3, 3)
        Of the sensor in the base.
    q : ndarray, shape (n, 3)
        gamma, psi, phi of the peg in the hole.
    rates : ndarray, shape (n, 3)
    normal : ndarray, shape (n, 3)
        At K, B1, B2, mean over the millisecond [N].
    place : ndarray, shape (n, 3)
        Of the peg's lower end in the hole [m].

    """

    t: np.ndarray
    drives: np.ndarray
    sensor: np.ndarray
    axes: np.ndarray
    q: np.ndarray
    rates: np.ndarray
    normal: np.ndarray
    place: np.ndarray
