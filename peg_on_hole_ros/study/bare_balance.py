"""A balance of forces as one would write it in numpy, with nothing around it: to compare with."""

from collections import deque
from collections.abc import Callable, Sequence

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.reference import six_equations
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.sim.measure import START_NS
from peg_on_hole_ros.study.runs import Track

# Rates are differences over so long [ns].
_WINDOW_NS = 10_000_000
# Friction is Coulomb's [m/s], and the equations end at gamma0 [rad].
_SHARP, _NEAREST = 1e-6, 1e-5


def bare_balance(
    configuration: Configuration, samples: Sequence, clock: Callable[[], float]
) -> Track:
    """
    Return what least squares make of each wrench: the last angles, and their differences.

    `seconds` is the time of the balances alone: samples are in peg axes, and in order. Bounds are
    those of the wrench's noise, and nothing is told as not determined.

    Parameters
    ----------
    configuration : Configuration
    samples : sequence
        Joint and wrench samples.
    clock : callable
        Returns a time [s].

    """
    scene, joints = configuration.scene, PegJoints(configuration.joints)
    reduction, last = WrenchReduction(configuration.wrench, scene), deque(maxlen=2)
    angles, rows, seconds = deque(), [], 0.0
    weights = np.linalg.inv(reduction.covariance)
    for sample in samples:
        if not isinstance(sample, WrenchSample):
            angles.append((sample.t_ns, joints(sample)))
            while angles[-1][0] - angles[0][0] > _WINDOW_NS:
                angles.popleft()
            last.append(sample.t_ns)
            continue
        if len(angles) < 2:
            continue
        (t_0, first), (t_1, now) = angles[0], angles[-1]
        u = reduction.on_peg(sample.force, sample.torque, None)
        begun = clock()
        dt = (t_1 - t_0) * 1e-9
        rates = (np.unwrap([first.q, now.q], axis=0)[1] - first.q) / dt
        reactions, spread = balanced(scene, now.q, rates, u, weights)
        seconds += clock() - begun
        angle = np.sqrt(np.diagonal(now.covariance))
        rows.append(
            (sample.t_ns - START_NS, [*now.q, *rates, *reactions],
             [*angle, *(np.sqrt(2.0) * angle / dt), *spread])
        )  # fmt: skip
    if not rows:
        # Orientations further apart than the window give no rates.
        nothing = np.empty((0, 9))
        return Track(np.empty(0, np.int64), nothing, nothing, np.empty(0, bool), seconds)
    t_ns, values, stddev = (np.array(each) for each in zip(*rows))
    return Track(t_ns, values, stddev, np.ones(len(t_ns), bool), seconds)


def balanced(
    scene: Scene, q: np.ndarray, rates: np.ndarray, u: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the three reactions that fit a wrench best, without inertia, and their deviations [N].

    Parameters
    ----------
    scene : Scene
    q, rates : ndarray, shape (3,)
        [rad], [rad/s].
    u : ndarray, shape (6,)
        Force and moment about the mass centre, peg axes [N], [N m].
    weights : ndarray, shape (6, 6)
        Inverse of the wrench's covariance.

    """
    at = np.array([max(q[0], scene.gamma0 + _NEAREST), q[1], q[2]])
    A, r = six_equations(scene, at, rates, u, _SHARP)
    # The right side is linear in the wrench: by a wrench of each unit, what its noise is there.
    columns = np.column_stack([u + unit for unit in np.eye(6)])
    W = six_equations(scene, at[:, None], rates[:, None], columns, _SHARP)[1] - r[:, None]
    back = np.linalg.inv(W)
    information = back.T @ weights @ back
    C = A[:, 3:]
    told = np.linalg.inv(C.T @ information @ C)
    return told @ C.T @ information @ r, np.sqrt(np.diagonal(told))
