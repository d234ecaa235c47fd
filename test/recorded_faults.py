"""Shipped and simulated bags as they are, and as a driver or a setting spoils them."""

from functools import cache

import numpy as np

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.messages.decode import joint_sample, wrench_sample
from peg_on_hole_ros.records import WrenchSample
from simulated import ROOT, SAMPLES

BAGS = [ROOT / "bags" / f"{name}.mcap" for name in SAMPLES]


@cache
def recording(path):
    """Return wrenches and joint states of a bag with their log times [ns], in its order."""
    takes = {"/wrench": wrench_sample, "/joint_states": joint_sample}
    found = Bag(path).messages(list(takes))
    return [(log_ns, takes[topic](message)) for topic, log_ns, message in found]


def samples(path, begin=0.0, end=99.0):
    """Return those of so many seconds."""
    found = recording(path)
    first = found[0][0]
    return [sample for log_ns, sample in found if begin <= (log_ns - first) * 1e-9 < end]


def from_zero(path, end):
    """Return those of so many seconds, their stamps from 0 on."""
    found = samples(path, end=end)
    first = found[0].t_ns
    return [sample._replace(t_ns=sample.t_ns - first) for sample in found]


def is_wrench(sample):
    return isinstance(sample, WrenchSample)


def turned(R):
    """Return what makes every force and torque R times what it is."""
    return lambda force, torque, q: (R @ force, R @ torque)


def in_base(force, torque, q):
    R = peg_axes(q)
    return R @ force, R @ torque


def without_weight(force, torque, q):
    """Take off what hangs at the sensor, as a controller does: the sample's peg of 0.5 kg."""
    weight = peg_axes(q).T @ [0.0, 0.0, -0.5 * 9.80665]
    return force + weight, torque + np.cross([0.0, 0.0, -0.035], weight)


class Filtered:
    """A low-pass of first order, as drivers have, over wrenches that come at 1 kHz."""

    def __init__(self, cutoff):
        self._share, self._last = 1.0 - np.exp(-2.0 * np.pi * cutoff * 1e-3), None

    def __call__(self, force, torque, q):
        now = np.array([*force, *torque])
        self._last = now if self._last is None else self._last + self._share * (now - self._last)
        return tuple(self._last[:3]), tuple(self._last[3:])


def spoilt(recorded, change):
    """Yield samples with wrenches as `change(force, torque, q)` makes them, q as measured last."""
    q = None
    for sample in recorded:
        if isinstance(sample, WrenchSample):
            if q is not None:
                values = change(np.array(sample.force), np.array(sample.torque), q)
                force, torque = (tuple(map(float, value)) for value in values)
                sample = sample._replace(force=force, torque=torque)
        else:
            q = sample.position
        yield sample


def first_cause(recorded, parameters=None):
    """Return the pipeline once it has named a cause, or at the end, and when [s]; None: never."""
    configuration = parameters or {}
    if not isinstance(parameters, Configuration):
        configuration = from_parameters(configuration)
    line, begun = Pipeline(configuration), None
    for sample in recorded:
        begun = sample.t_ns if begun is None else begun
        line.on_sample(sample)
        if line.causes:
            return line, (sample.t_ns - begun) * 1e-9
    return line, None
