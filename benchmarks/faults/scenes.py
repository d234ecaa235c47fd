"""The recordings that faults are put into, with their truth: sample bags, a cell, an insertion."""

import os
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.faults.injector import SAMPLE_BAGS, Cell, Recording, sent
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.simulated_bag import SIMULATION_METADATA, write_bag
from peg_on_hole_ros.bags.truth import THREE_POINT, read_truth
from peg_on_hole_ros.cli.simulation_file import read_plan
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.messages.decode import joint_sample, wrench_sample
from peg_on_hole_ros.replay.bag_settings import completed_settings
from peg_on_hole_ros.replay.run import stored_configuration
from peg_on_hole_ros.robot.kinematics import UrdfKinematics
from peg_on_hole_ros.robot.urdf_file import read_chain
from peg_on_hole_ros.sim.truth import integrate

ROOT = Path(__file__).parents[2]


class Scene(NamedTuple):
    """
    A recording and what truly happened.

    Attributes
    ----------
    name : str
    configuration : Configuration
    recording : list of Sent
    t_ns : ndarray of int, shape (n,)
        Stamps of the truth [ns].
    values : ndarray, shape (n, 6)
        gamma, psi, phi [rad], reactions at K, B1, B2 [N]; NaN where they are not known.
    mode : ndarray of str, shape (n,)
    part : tuple of float
        Begin and end of what a fault touches that does not last [s].
    crossed_ns, jams_ns : int or None
        Stamp of the transition, and of the jam [ns].
    frame : str
        frame_id of the wrench.
    cell : Cell

    """

    name: str
    configuration: Configuration
    recording: Recording
    t_ns: np.ndarray
    values: np.ndarray
    mode: np.ndarray
    part: tuple[float, float]
    crossed_ns: int | None
    jams_ns: int | None
    frame: str
    cell: Cell


class Part(NamedTuple):
    """
    What of a recording is played, and where a fault is that does not last.

    Attributes
    ----------
    source : str
        Name of a bag, or of a configuration of `simulate`.
    begin, end : float
        Of what is played [s].
    faulted : tuple of float
        After the begin [s].
    what : str
        What happens there.

    """

    source: str
    begin: float
    end: float
    faulted: tuple[float, float]
    what: str


# Of the cycle the second try: free air, touch-down, slide, transition, in the hole.
PARTS = {
    "closing": Part("closing_with_slip", 0.0, 9.0, (0.2, 0.4), "the peg slides"),
    "jam": Part("closing_without_slip", 0.0, 9.0, (0.2, 0.4), "the peg slides, before it jams"),
    "cycle": Part("working_cycle", 7.9, 99.0, (1.4, 1.8), "the peg slides"),
    "insertion": Part("insertion", 0.0, 9.0, (0.12, 0.3), "the peg slides"),
    "cell": Part("cell_ur_like", 1.0, 6.5, (1.6, 2.0), "the peg slides"),
    "jam_within": Part("closing_without_slip", 0.0, 9.0, (0.55, 9.0), "the peg jams"),
    "crossing_within": Part("working_cycle", 7.9, 99.0, (2.2, 2.5), "the transition"),
}
# What a fault that lasts does to them, others have shown.
WITHIN = ("jam_within", "crossing_within")
SIMULATED = ("insertion",)


@cache
def scene(name: str, folder: Path) -> Scene:
    """Return a scene; what is simulated is kept in a folder."""
    source = PARTS[name].source
    path = ROOT / "bags" / f"{source}.mcap"
    if source in SIMULATED:
        path = folder / f"{source}.mcap"
        if not path.exists():
            folder.mkdir(parents=True, exist_ok=True)
            # Several processes may come to write it.
            partial = folder / f"{source}.{os.getpid()}.mcap"
            write_bag(partial, integrate(read_plan(ROOT / "config" / f"{source}.yaml")))
            partial.replace(path)
    return read_part(name, PARTS[name], Bag(path))


def read_part(name: str, part: Part, bag: Bag) -> Scene:
    """Return the scene that a part of a bag with its truth is."""
    configuration, _ = completed_settings(bag, stored_configuration(bag, any_urdf=True))
    samples, frame = [], ""
    for topic, _, message in bag.messages(["/wrench", "/joint_states"]):
        if topic == "/wrench":
            frame = message.header.frame_id
            samples.append(wrench_sample(message))
        else:
            samples.append(joint_sample(message, configuration.joints.names))
    first_ns = samples[0].t_ns + round(part.begin * 1e9)
    last_ns = samples[0].t_ns + round(part.end * 1e9)
    recording = sent(each for each in samples if first_ns <= each.t_ns < last_ns)
    truth = read_truth(bag)
    keep = (first_ns <= truth.t_ns) & (truth.t_ns < last_ns)
    t_ns = truth.t_ns[keep]
    modes = np.array([truth.mode_at(int(each)) for each in t_ns])
    ended_by = bag.metadata.get(SIMULATION_METADATA, {}).get("ended_by")
    crossed = [each for each in truth.transitions_ns() if first_ns <= each < last_ns]
    if ended_by == "transition":
        crossed.append(int(t_ns[-1]))
    resting = np.flatnonzero((modes[:-1] == THREE_POINT) & (modes[1:] == "unknown"))
    return Scene(
        name,
        configuration,
        recording,
        t_ns,
        truth.values[keep],
        modes,
        part.faulted,
        crossed[0] if crossed else None,
        int(t_ns[resting[0] + 1]) if ended_by == "jammed" else None,
        frame,
        _cell(configuration, frame),
    )


def _cell(configuration, frame):
    """Return what faults need to know of the cell."""
    joints, wrench = configuration.joints, configuration.wrench
    if joints.source != "robot":
        return SAMPLE_BAGS
    # Of a wrist the last three joints turn the peg.
    count = len(joints.names)
    tip = replace(joints, tip_frame=frame)
    kinematics = UrdfKinematics(read_chain(tip), tip)
    return Cell(
        force=wrench.force_stddev,
        torque=wrench.torque_stddev,
        angle=joints.position_stddev,
        axes=lambda positions: kinematics.poses(np.array([positions], float)).rotation[0],
        weighs=wrench.gravity != "compensated",
        sign=-1.0 if wrench.acts_on == "robot" else 1.0,
        turning=(count - 3, count - 2, count - 1),
        angles=False,
    )
