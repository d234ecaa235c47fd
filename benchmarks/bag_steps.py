"""The steps of a bag: each wrench, reduced, with the orientation of its stamp."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.messages.decode import joint_sample, wrench_sample
from peg_on_hole_ros.records import JointSample


class Step(NamedTuple):
    """
    One wrench of a bag, reduced, and the orientation of the same stamp.

    Attributes
    ----------
    dt : float
        Since the wrench before [s].
    u : ndarray, shape (6,)
        Wrench on the peg about its mass centre, peg axes [N], [N m].
    q : ndarray, shape (3,), or None
        gamma, psi, phi [rad].
    R : ndarray, shape (3, 3), or None
        Covariance of q [rad^2].

    """

    dt: float
    u: np.ndarray
    q: np.ndarray | None
    R: np.ndarray | None


def bag_samples(path: str | Path, configuration: Configuration):
    """Yield the joint and wrench samples of a bag."""
    topics = configuration.topics
    for item in Bag(path).messages([topics.wrench, topics.joint_states]):
        decode = wrench_sample if item.topic == topics.wrench else joint_sample
        yield decode(item.message)


def bag_steps(path: str | Path, configuration: Configuration) -> list[Step]:
    """Return the steps of a bag whose joint states carry the stamps of wrenches."""
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    orientation = PegJoints(configuration.joints)
    waiting, steps, last = None, [], None
    for sample in bag_samples(path, configuration):
        if isinstance(sample, JointSample):
            waiting = orientation(sample)
            continue
        q = R = None
        if waiting is not None and waiting.t_ns == sample.t_ns:
            q, R = waiting.q, waiting.covariance
        u = reduction.on_peg(sample.force, sample.torque, q)
        steps.append(Step((sample.t_ns - (last or sample.t_ns)) * 1e-9, u, q, R))
        last = sample.t_ns
    return steps
