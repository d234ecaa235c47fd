"""The one compiled call on one memory does, to the last bit, what its parts do on their own."""

import numpy as np

from benchmarks.harness.exact import exactly
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.monitor.contact_probabilities import no_knowledge
from peg_on_hole_ros.monitor.dangers.registry import assess_dangers
from peg_on_hole_ros.monitor.evidence import weigh_wrench
from peg_on_hole_ros.monitor.memory import (
    Memory,
    begin_memory,
    forget_contacts_and_loads,
    restart,
    restart_mode,
)
from peg_on_hole_ros.monitor.motion_now import Passed
from peg_on_hole_ros.monitor.motion_trend import follow_motion
from peg_on_hole_ros.monitor.rest_in_hole import follow_depth
from peg_on_hole_ros.monitor.settings import force_noise, monitor_settings
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.typed_record import new
from simulated import truth


def test_one_call_does_what_its_parts_do():
    motion = truth("closing_with_slip")
    line = Pipeline(exactly(motion.plan.configuration))
    options, scene = line.configuration.monitor, line.scene
    noise = force_noise(scene, line.processor.reduction.covariance)
    settings = monitor_settings(options, scene, noise)
    orientation = PegJoints(line.configuration.joints)
    m, own = line.processor.engine.memory, new(Memory)
    begin_memory(own)
    evidence, dangers = own.evidence, own.dangers
    oriented_ns = last_ns = None
    on_contacts, waiting, found = False, [], 0
    for sample in measure(motion, 6):
        if not isinstance(sample, WrenchSample):
            # The first starts the filter.
            waiting += [orientation(sample)] if line.filter.state.time_since_start else []
            line.on_joints(sample)
            continue
        row = line.on_wrench(sample)
        for t_ns, q, R, *_ in waiting:
            since = -1.0 if oriented_ns is None else (t_ns - oriented_ns) * 1e-9
            R = line.filter.orientation_noise * R
            follow_motion(own.motion, since, q, R, settings)
            follow_depth(own.depth, q[0], R[0, 0], since, settings)
            oriented_ns = t_ns
        waiting = []
        dt = 0.0 if last_ns is None else (row.t_ns - last_ns) * 1e-9
        since = 0.0 if oriented_ns is None else (row.t_ns - oriented_ns) * 1e-9
        last_ns, passed = row.t_ns, Passed(dt, since)
        nis = float(line.processor.engine.innovations.misfit) if on_contacts else -1.0
        f, shown = line.filter.record, evidence.shown
        weigh_wrench(f, evidence, own.motion, settings, passed, nis, own.place, False)
        assess_dangers(f, dangers, own.motion, own.depth, shown, settings, passed)
        for part in ("motion", "depth", "evidence", "dangers"):
            assert getattr(m, part).tobytes() == getattr(own, part).tobytes(), part
        known = m.known
        value, spread = line.filter.friction
        assert known.friction == value
        assert (known.clearance, known.clearance_stddev) == line.filter.clearance
        assert known.friction_stddev >= spread
        if line.filter.x[0] >= scene.gamma0:
            assert known.friction_stddev == spread
        assert row.monitor["transition_probability"] == shown.below
        on_contacts = row.contact_mode == "three_point"
        if on_contacts and shown.usable:
            mean, most = row.normal.mean(), row.normal_stddev.max()
            known_enough = most <= mean / 3 and row.monitor["determinant"] > options.singular_band
            assert row.monitor["reactions_determined"] == known.reactions_determined
            assert known.reactions_determined <= known_enough
        found += 1
    assert found > 600
    was = m.motion.tobytes()
    forget_contacts_and_loads(m)
    np.testing.assert_array_equal(m.evidence.hypotheses, no_knowledge())
    assert m.motion.tobytes() == was


def fill(record, value):
    for name in record.dtype.names:
        if record.dtype[name].names:
            fill(record[name], value)
        else:
            record[name] = value


def test_what_an_estimate_before_showed_is_forgotten_with_it():
    memory, begun = new(Memory), new(Memory)
    forget_contacts_and_loads(begun)
    for part in (memory.evidence, memory.points, memory.motion, memory.depth, memory.dangers):
        if part.dtype.names:
            fill(part, 0.7)
        else:
            part[:] = 0.7
    moves = memory.motion.tobytes()
    restart_mode(memory)
    np.testing.assert_array_equal(memory.evidence.hypotheses, no_knowledge())
    assert memory.dangers.tobytes() == begun.dangers.tobytes()
    # The peg moves on.
    assert memory.motion.tobytes() == moves
    restart(memory)
    restart(begun)
    assert memory.motion.tobytes() == begun.motion.tobytes()
