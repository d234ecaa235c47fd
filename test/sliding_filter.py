"""A contact filter under way, and a wrench that presses the peg on all contacts."""

import numpy as np
from peg_on_hole_ros.estimation.filters.contact import ContactFilter

from peg_on_hole_ros.estimation.measurement import angle_covariance
from peg_on_hole_ros.mechanics.kernel import accelerate, scene_scalars, workspace
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.options import FilterOptions

SCENE = Scene(friction_stddev=0.0)
P = scene_scalars(SCENE)
# Friction without its memory of the covariance, so that a prediction is a function of the state.
# Nor is a step divided for its error: what one step does is looked at here.
PLAIN = FilterOptions(slip_widening=0.0, slow_slip=0.0, step_tolerance=1e3)
WRENCH_NOISE = np.diag([0.2**2] * 3 + [0.005**2] * 3)


def balanced(x):
    """Return a wrench that presses the peg on all contacts at x, with accelerations below 1."""
    u, y, work = np.zeros(6), np.zeros(6), workspace()
    target = np.array([0.1, -0.2, 0.3, 25.0, 15.0, 12.0])
    A = np.empty((6, 6))
    for j in range(6):
        unit = np.zeros(6)
        accelerate(P, np.full(3, 2e-5), x, unit, work, y)
        nothing = y.copy()
        unit[j] = 1.0
        accelerate(P, np.full(3, 2e-5), x, unit, work, y)
        A[:, j] = y - nothing
    u[:] = np.linalg.solve(A, target - nothing)
    return u


def sliding(options=PLAIN, x=(0.15, 0.3, -0.4, -0.16, 0.4, 2.0), noise=WRENCH_NOISE):
    """A filter under way: all contacts slide, all carry load."""
    kalman = ContactFilter(SCENE, options, noise)
    x = np.array(x)
    kalman.start(x[:3], angle_covariance(x[0], 1e-4))
    kalman.x[3:] = x[3:]
    kalman.Z[3:6, 3:6] = np.diag([1e-3, 2e-3, 3e-3]) ** 2
    kalman.hold(balanced(x))
    return kalman
