"""The slip at the contacts of the reference filter, and how wide it makes friction's kink."""

import numpy as np

from peg_on_hole_ros.estimation.kernel.slip import SHARPEST, TURNED
from peg_on_hole_ros.estimation.reference.steps import (
    DIAMETER,
    FRICTION,
    RATES,
    with_parameters,
)
from peg_on_hole_ros.mechanics.geometry import contact_geometry, velocity_jacobians


def slip(kalman):
    """Return speed [m/s] at K, B1, B2 and its variance from that of the rates."""
    J, v = _velocities(kalman)
    speed = np.linalg.norm(v, axis=1)
    along = _along(J, v, speed)
    return speed, np.einsum("ij,jk,ik->i", along, kalman.P[RATES, RATES], along)


def slip_all_ways(kalman):
    """
    Return speed, and its variance along and across the slip, friction left out.

    And the part across by itself.
    """
    J, v = _velocities(kalman)
    P = kalman.P[RATES, RATES]
    if kalman.P[FRICTION, FRICTION] > 0:
        shared = kalman.P[RATES, FRICTION]
        P = P - np.outer(shared, shared) / kalman.P[FRICTION, FRICTION]
    speed, variance = np.linalg.norm(v, axis=1), np.array([np.trace(A @ P @ A.T) for A in J])
    along = _along(J, v, speed)
    across = np.maximum(variance - np.einsum("ij,jk,ik->i", along, P, along), 0.0)
    return speed, variance, across


def friction_scales(kalman):
    """Return the velocity scales of friction, wide where the slip may be zero [m/s]."""
    smallest, widening = kalman.process.slip_velocity_scale, kalman.process.slip_widening
    speed, variance = slip(kalman)
    return np.sqrt(smallest**2 + widening**2 * _near_zero(speed, variance))


def bridged_scales(kalman):
    """
    Return them where no step is taken: as small as a slip turned sideways lets them be.

    Below gamma0 nothing slips at three contacts, and they are the smallest.
    """
    if not _scene(kalman).gamma0 < kalman.x[0] < np.pi / 2:
        return np.full(3, kalman.process.slip_velocity_scale)
    speed, variance, kalman.across = slip_all_ways(kalman)
    widening = kalman.process.slip_widening
    return np.sqrt(turned_scales(kalman.across) ** 2 + widening**2 * _near_zero(speed, variance))


def turned_scales(across):
    """Return the velocity scales that leave friction its mean over a slip turned sideways."""
    return np.sqrt(TURNED * across + SHARPEST**2)


def _scene(kalman):
    return with_parameters(kalman.scene, kalman.x[FRICTION], kalman.x[DIAMETER])


def _velocities(kalman):
    here = _scene(kalman)
    g = contact_geometry(here, kalman.x[0])
    J = velocity_jacobians(g, here.peg_diameter, here.hole_diameter)
    return J, J @ kalman.x[RATES]


def _along(J, v, speed):
    # At rest no direction is along the slip: no variance then.
    slopes = np.array([J_i.T @ v_i for J_i, v_i in zip(J, v)])
    return slopes / np.maximum(speed, 1e-300)[:, None]


def _near_zero(speed, variance):
    """Return what of the variance counts, the less the farther a slip is from zero."""
    return variance * np.exp(-(speed**2) / (2 * np.maximum(variance, 1e-30)))
