"""A measured motion as a filter takes it."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.sim.measure import measure, sensor_wrench
from peg_on_hole_ros.sim.truth import Truth


class Recording(NamedTuple):
    """
    A measured motion as a filter takes it, a row a wrench; every row has an orientation or none.

    Attributes
    ----------
    dt : float
        Between two wrenches [s].
    wrench : ndarray, shape (n, 6)
        On the peg about its mass centre, peg axes [N], [N m].
    angles : ndarray, shape (n, 3)
        gamma, psi, phi [rad]; NaN where none was measured.
    covariances : ndarray, shape (n, 3, 3)
        [rad^2].

    """

    dt: float
    wrench: np.ndarray
    angles: np.ndarray
    covariances: np.ndarray


def recorded(truth: Truth, seed: int) -> Recording:
    """Return what the sensors say of a truth, reduced to the mass centre."""
    configuration = truth.plan.configuration
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    orientation = PegJoints(configuration.joints)
    n = len(truth.t_ns)
    wrench, angles = np.empty((n, 6)), np.full((n, 3), np.nan)
    covariances = np.full((n, 3, 3), np.nan)
    row, q = 0, None
    for sample in measure(truth, seed, exact=sensor_wrench(truth)):
        if isinstance(sample, JointSample):
            q = orientation(sample)
            continue
        if q is not None:
            angles[row], covariances[row] = q.q, q.covariance
        wrench[row] = reduction.on_peg(sample.force, sample.torque, None if q is None else q.q)
        row, q = row + 1, None
    return Recording(1.0 / truth.plan.wrench_rate, wrench, angles, covariances)
