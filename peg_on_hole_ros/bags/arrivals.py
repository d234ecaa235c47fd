"""Wrenches and orientations of a batch, as the pipeline takes many of them at once."""

from collections.abc import Mapping

import numpy as np

from peg_on_hole_ros.bags.batch import Batch
from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.measurements.measurement import sound_wrenches
from peg_on_hole_ros.measurements.orientation import ROW, JointOrientation, Outcome
from peg_on_hole_ros.records import Arrivals


def arrivals_of(
    batch: Batch, sources: Mapping[str, str], joints: JointInput, orientation: JointOrientation
) -> Arrivals:
    """
    Return the messages of a batch in their order; those of other topics are not sound.

    Parameters
    ----------
    batch : Batch
    sources : mapping of str to str
        Which topics are `wrench` and `joints`.
    joints : JointInput
    orientation : JointOrientation

    """
    source = np.array([sources.get(topic, "") for topic in batch.types] or [""])[batch.topic]
    of_wrench, of_joints = source == "wrench", source == "joints"
    sound = np.zeros(len(batch), bool)
    rows = np.full((len(batch), ROW), np.nan)
    for number, layout in enumerate(batch.layouts):
        fits = batch.layout == number
        at = np.flatnonzero(fits & of_wrench)
        if len(at):
            sound[at] = sound_wrenches(batch.values[at, :6])
        at = np.flatnonzero(fits & of_joints)
        if len(at):
            sound[at], rows[at] = _orientations(
                layout.names, batch.t_ns[at], batch.values[at, : layout.width], joints, orientation
            )
    t_ns = np.where(of_wrench, batch.t_ns, batch.t_ns - round(joints.delay * 1e9))
    # A batch without any wrench that can be read may be narrower.
    wrenches = np.full((np.count_nonzero(of_wrench), 6), np.nan)
    read = batch.values[of_wrench, :6]
    wrenches[:, : read.shape[1]] = read
    return Arrivals(of_wrench, t_ns, sound, wrenches, rows[~of_wrench])


def _orientations(names, t_ns, positions, joints, orientation):
    """Return which joint states of one order are sound, and their rows."""
    needed = [i for i, name in enumerate(names) if not joints.names or name in joints.names]
    sound = np.isfinite(positions[:, needed]).all(axis=1)
    sound &= len(set(names)) == len(names) == positions.shape[1]
    found = orientation.rows(names, positions)
    return sound & (found.outcome == Outcome.orientation), found.rows
