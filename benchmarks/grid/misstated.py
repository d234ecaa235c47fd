"""Truths of which something else is stated, and samples of sensors and cells that are off."""

from dataclasses import replace

import numpy as np

from peg_on_hole_ros.measurements.rotations import tilt_axes
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.sim.measure import measured_angles


def with_sections(truth, **sections):
    """Return a truth of whose configuration other sections are stated."""
    configuration = replace(truth.plan.configuration, **sections)
    return replace(truth, plan=replace(truth.plan, configuration=configuration))


def with_values(truth, section: str, **values):
    """Return a truth of which other values of a section are stated."""
    changed = replace(getattr(truth.plan.configuration, section), **values)
    return with_sections(truth, **{section: changed})


def with_scene(truth, **values):
    """Return a truth of whose scene something else is stated."""
    return with_values(truth, "scene", **values)


def with_lever(configuration, axis):
    """Return a configuration whose sensor is 2 % of the diameter away from where it is."""
    at = np.array(configuration.wrench.sensor_xyz)
    at[axis] += 0.02 * configuration.scene.hole_diameter
    wrench = replace(configuration.wrench, sensor_xyz=tuple(at.tolist()))
    return replace(configuration, wrench=wrench)


def with_tare(sample, off):
    """Return a wrench whose force is off by so much [N]; others as they are."""
    if not isinstance(sample, WrenchSample):
        return sample
    return sample._replace(force=tuple((np.array(sample.force) + off).tolist()))


def tilted(sample, tilt):
    """Return a joint state in axes turned about x and y by a tilt [rad]; others as they are."""
    if not isinstance(sample, JointSample):
        return sample
    q = measured_angles(np.array([sample.position]), np.zeros((1, 3)), tilt_axes(tilt))[0]
    return sample._replace(position=tuple(q.tolist()))
