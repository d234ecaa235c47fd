"""A peg that slides on three contacts at steady rates, and the samples that this motion makes."""

from functools import cache

import numpy as np

from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.mechanics.any_side import quantities, solve_any
from peg_on_hole_ros.records import ANGLES, JointSample, WrenchSample

MS = 1_000_000
BEGIN = 10_000_000_000
CONFIGURATION = from_parameters({})
# Of the mass centre from the sensor, along the peg [m].
CENTRE = CONFIGURATION.scene.mass_center_height - CONFIGURATION.wrench.sensor_xyz[2]


def motion(k, rate=-0.05):
    """Return angles [rad] and rates [rad/s] after k milliseconds; the tilt turns at `rate`."""
    return np.array([0.15 + rate * k * 1e-3, 0.0, 1e-3 * k]), np.array([rate, 0.0, 1.0])


@cache
def balanced(k, rate, load):
    """Return force and torque [N, N m] at the sensor after k milliseconds; solved once each."""
    names, at_rim = quantities("peg")[-6:], {"N_K": load, "N_B1": load / 2, "N_B2": load / 2}
    found = solve_any(CONFIGURATION.scene, *motion(k, rate), names, at_rim, "peg").values
    force, torque = np.array([found[name] for name in names]).reshape(2, 3)
    return force, torque + np.cross([0.0, 0.0, CENTRE], force)


def wrench(k, random, moved=0, rate=-0.05, load=6.0):
    """
    Return a wrench of the stamp k [ms]: what the motion at another asks for under a load at K [N].

    Any other contradicts the motion, which then begins anew for ever.
    """
    force, torque = balanced(moved, rate, load)
    force, torque = force + random.normal(0, 0.2, 3), torque + random.normal(0, 0.005, 3)
    return WrenchSample(BEGIN + k * MS, tuple(force), tuple(torque))


def orientation(k, random, rate=-0.05):
    """Return an orientation of the stamp k [ms], with the noise that is stated."""
    q, off = motion(k, rate)[0], random.normal(0, 1e-4, 3)
    # As is stated, by a rotation of the peg: psi and phi share a turn about a tilted axis.
    turned = off[1] / np.sin(q[0])
    q = q + [off[0], turned, off[2] - turned * np.cos(q[0])]
    return JointSample(BEGIN + k * MS, ANGLES, tuple(map(float, q)))
