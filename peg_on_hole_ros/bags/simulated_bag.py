"""Write a simulated truth and its noisy samples as a bag."""

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np

from peg_on_hole_ros.bags.reader import absolute
from peg_on_hole_ros.bags.truth import CONTACTS_TOPIC, MODE_TOPIC, STATE_TOPIC
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.messages.beside_estimates import JOINT_STATE, STRING, WRENCH, joint_state
from peg_on_hole_ros.messages.plain import header, xyz
from peg_on_hole_ros.records import ANGLES, CONTACTS, JointSample
from peg_on_hole_ros.sim.hole_steps import STEP
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.sim.truth import Truth

SENSOR_FRAME = "sensor"
# Of a peg that is inserted: where its lower end's centre is, and every place where it touches.
PLACE_TOPIC = "/truth/place"
HOLE_CONTACTS_TOPIC = "/truth/hole_contacts"
PLACE_NAMES = ("x", "y", "depth")
HOLE_CONTACTS = ("rim_1", "rim_2", "edge_1", "edge_2")
SIMULATION_METADATA = "peg_on_hole_simulation"


def write_bag(
    path: str | Path,
    truth: Truth,
    seed: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> None:
    """
    Write wrench, joint states, truth, and what the bag is, to an MCAP file.

    Of one stamp the joint states come first, then the wrench, then the truth. Where the reactions
    are not determined /truth/contacts is silent.

    Parameters
    ----------
    path : str or Path
    truth : Truth
    seed : int, optional
        Of the noise; None is the plan's own.
    progress : callable, optional
        Told the share done, 0 to 1.

    Raises
    ------
    PegOnHoleError
        The file cannot be written.

    """
    plan = truth.plan
    topics = plan.configuration.topics
    inserts = any(phase.kind == "insert" for phase in plan.phases)
    place, place_rate = truth.place, truth.place_rate
    metadata = {SIMULATION_METADATA: _metadata(truth, plan.seed if seed is None else seed)}
    with BagWriter(path, plan.configuration, metadata) as bag:
        rows, mode = iter(range(len(truth.t_ns))), None
        for sample in measure(truth, seed):
            t_ns = sample.t_ns
            if isinstance(sample, JointSample):
                message = joint_state(t_ns, sample.names, sample.position, frame="")
                bag.write(absolute(topics.joint_states), JOINT_STATE, message, t_ns)
                continue
            wrench = {"force": xyz(sample.force), "torque": xyz(sample.torque)}
            message = {"header": header(t_ns, SENSOR_FRAME), "wrench": wrench}
            bag.write(absolute(topics.wrench), WRENCH, message, t_ns)
            i = next(rows)
            bag.write(STATE_TOPIC, JOINT_STATE, _state(truth, i, t_ns), t_ns)
            if truth.known[i]:
                bag.write(CONTACTS_TOPIC, JOINT_STATE, _contacts(truth, i, t_ns), t_ns)
            if inserts:
                where = joint_state(t_ns, PLACE_NAMES, place[i], place_rate[i])
                bag.write(PLACE_TOPIC, JOINT_STATE, where, t_ns)
                bag.write(HOLE_CONTACTS_TOPIC, JOINT_STATE, _touching(truth, i, t_ns), t_ns)
            if truth.mode[i] != mode:
                mode = truth.mode[i]
                bag.write(MODE_TOPIC, STRING, {"data": str(mode)}, t_ns)
            if progress:
                progress((i + 1) / len(truth.t_ns))


def _state(truth, i, t_ns):
    q = truth.q[i].copy()
    q[1:] = np.pi - (np.pi - q[1:]) % (2 * np.pi)
    return joint_state(t_ns, ANGLES, q, truth.rates[i])


def _contacts(truth, i, t_ns):
    return joint_state(t_ns, CONTACTS, truth.closed[i], truth.slip_speed[i], truth.normal[i])


def _touching(truth, i, t_ns):
    azimuth, slip, normal = (
        values[i] for values in (truth.hole_azimuth, truth.hole_slip, truth.hole_normal)
    )
    return joint_state(t_ns, HOLE_CONTACTS, azimuth, slip, normal)


def _phase(phase):
    tree = asdict(phase)
    # Without a jump or a place there is nothing to say, and older bags say nothing.
    silent = [] if phase.friction is not None else ["friction"]
    silent += [] if phase.kind == "insert" else ["depth", "depth_rate", "place"]
    return {k: tree[k] for k in tree if k not in silent}


def _metadata(truth, seed):
    plan = truth.plan
    settings, joints = plan.configuration.wrench, plan.configuration.joints
    events = [{"stamp": START_NS + t_ns, "what": what} for t_ns, what in truth.events]
    return {
        "origin": plan.origin,
        "ended_by": truth.ended_by,
        "events": json.dumps(events),
        "noise": (
            f"white, seed {seed}: force {settings.force_stddev:g} N, torque "
            f"{settings.torque_stddev:g} N m, orientation {joints.position_stddev:g} rad about "
            f"each axis; wrench {plan.wrench_rate} Hz, joint states {plan.joint_rate} Hz"
        ),
        "holder": json.dumps(asdict(plan.holder)),
        "start": json.dumps(_phase(plan.start)),
        "phases": json.dumps([_phase(phase) for phase in plan.phases]),
        "integrator": (
            f"Radau IIA of order 5, rtol {plan.rtol:g}; friction regularised at "
            f"{plan.slip_velocity_scale:g} m/s"
            + (
                f"; in the hole TR-BDF2, steps of at most {STEP:g} s, contacts of "
                f"{plan.contact_stiffness:g} N/m with dry friction"
                if any(phase.kind == "insert" for phase in plan.phases)
                else ""
            )
        ),
    }
