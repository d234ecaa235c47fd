"""The shipped working cycle as a recording, with what a cell may add to it put in exactly."""

from dataclasses import replace
from functools import cache

import numpy as np

from peg_on_hole_ros.cli.calibrate import read_recording
from peg_on_hole_ros.edges.bag_reader import Bag
from peg_on_hole_ros.edges.replay import stored_configuration
from peg_on_hole_ros.estimation.measurement import WrenchReduction
from peg_on_hole_ros.mechanics.reference import peg_axes
from simulated import ROOT

G = 9.80665


@cache
def bag(name):
    bag = Bag(ROOT / "bags" / f"{name}.mcap")
    configuration = stored_configuration(bag)
    return read_recording(bag, configuration), configuration


def disturbed(name, bias=(0.0,) * 6, tilt=(0.0, 0.0), delay=0.0, noise=(0.0, 0.0), seed=1):
    """
    The recording under another gravity, sensor and clock; the motion is the same.

    Gravity acts at the mass centre like a force: where it is another, the same motion takes
    another force there, and all reactions stay. Noise is added to that of the recording.
    """
    record, configuration = bag(name)
    scene, reduction = (
        configuration.scene,
        WrenchReduction(configuration.wrench, configuration.scene),
    )
    t, q = record.joint_t, record.q
    angles = np.array([np.interp(record.wrench_t, t, column) for column in q.T])
    weight = -scene.peg_mass * G * np.array([*tilt, 0.0])
    force_P = np.einsum("ijk,i->kj", peg_axes(angles), weight)
    at_center = np.column_stack([force_P, np.zeros_like(force_P)])
    wrench = record.wrench + np.linalg.solve(reduction.matrix, at_center.T).T + bias
    wrench = wrench + np.random.default_rng(seed).normal(size=wrench.shape) * np.repeat(noise, 3)
    return record._replace(wrench=wrench, joint_t=t + delay), configuration


def between(record, begin, end):
    """The samples between two times [s]."""
    w = (record.wrench_t > begin) & (record.wrench_t < end)
    j = (record.joint_t > begin) & (record.joint_t < end)
    return record._replace(
        wrench_t=record.wrench_t[w],
        wrench=record.wrench[w],
        joint_t=record.joint_t[j],
        q=record.q[j],
        covariance=record.covariance[j],
    )


def with_friction(configuration, friction):
    return replace(configuration, scene=replace(configuration.scene, friction=friction))
