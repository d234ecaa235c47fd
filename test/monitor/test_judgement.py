"""The one compiled call on one memory does, to the last bit, what its parts do on their own."""

import numpy as np

from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.monitor import down_the_hole, jamming
from peg_on_hole_ros.monitor.assessment import restart, restart_mode
from peg_on_hole_ros.monitor.contacts import no_knowledge
from peg_on_hole_ros.monitor.down_the_hole import follow_depth
from peg_on_hole_ros.monitor.evidence import WIDTH, Shown, force_noise, settings, show
from peg_on_hole_ros.monitor.jamming import Risk
from peg_on_hole_ros.monitor.judgement import JAMMING, KNOWN, MEMORY, MOTION, RISK, SHOWN, forget
from peg_on_hole_ros.monitor.known_quantities import Known
from peg_on_hole_ros.monitor.leftover_wrench import new_means
from peg_on_hole_ros.monitor.trend import SIZE, TURN_SHARE, follow, new_trend
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.sim.measure import measure
from simulated import truth


def test_one_call_does_what_its_parts_do():
    motion = truth("closing_with_slip")
    line = Pipeline(motion.plan.configuration)
    options, scene = line.configuration.monitor, line.scene
    noise = force_noise(scene, line.processor.reduction.covariance)
    o = settings(options, noise, scene.clearance_stddev)
    limits, orientation = jamming.limits(options), PegJoints(line.configuration.joints)
    hypotheses, means, j = no_knowledge(), new_means(), jamming.new_memory()
    trend = np.concatenate([new_trend(), np.zeros(down_the_hole.SIZE)])
    d, D = scene.peg_diameter, scene.hole_diameter
    stddev, memory = options.forecast_acceleration_stddev, options.forecast_acceleration_time
    m = line.processor.engine["memory"]["numbers"]
    oriented_ns = last_ns = None
    on_contacts, waiting, found = False, [], 0
    for sample in measure(motion, 6):
        if not isinstance(sample, WrenchSample):
            # The first starts the filter.
            waiting += [orientation(sample)] if line.filter.state.since[0] else []
            line.on_joints(sample)
            continue
        row = line.on_wrench(sample)
        for t_ns, q, R, *_ in waiting:
            since = -1.0 if oriented_ns is None else (t_ns - oriented_ns) * 1e-9
            R = line.filter.orientation_noise * R
            follow(trend, since, q, R, d / D, stddev, memory)
            follow_depth(
                trend, SIZE, d, D, q[0], R[0, 0], since, TURN_SHARE * stddev
            )  # fmt: skip
            oriented_ns = t_ns
        waiting = []
        dt = 0.0 if last_ns is None else (row.t_ns - last_ns) * 1e-9
        since = 0.0 if oriented_ns is None else (row.t_ns - oriented_ns) * 1e-9
        last_ns = row.t_ns
        f, determinant = line.filter.record.copy(), line.filter.record.determinant
        nis = (
            line.processor.engine["innovations"]["told"]["misfit"].item() if on_contacts else -1.0
        )
        shown, risk = np.zeros(WIDTH), np.zeros(len(Risk._fields))
        show(f, hypotheses, means, trend, o, dt, since, nis, determinant, 0.0, shown)
        s = Shown(*shown.tolist())
        contact, usable = 1.0 - s.free, s.usable > 0.0
        jamming.assess(
            f, trend, j, limits, dt, since, contact, s.below, s.time, usable, risk
        )  # fmt: skip
        np.testing.assert_array_equal(m[MOTION:JAMMING], trend)
        np.testing.assert_array_equal(m[SHOWN:RISK], shown)
        np.testing.assert_array_equal(m[RISK:KNOWN], risk)
        known = Known(*m[KNOWN:].tolist())
        value, spread = line.filter.friction
        assert (known.friction, *known[2:4]) == (value, *line.filter.clearance)
        assert known.friction_stddev >= spread
        if line.filter.x[0] >= scene.gamma0:
            assert known.friction_stddev == spread
        assert row.monitor["transition_probability"] == s.below
        on_contacts = row.contact_mode == "three_point"
        if on_contacts and usable:
            mean, most = row.normal.mean(), row.normal_stddev.max()
            known_enough = most <= mean / 3 and row.monitor["determinant"] > options.singular_band
            assert row.monitor["reactions_determined"] == known.reactions
            assert known.reactions <= known_enough
        found += 1
    assert found > 600
    was = m[MOTION : MOTION + SIZE].copy()
    forget(m)
    np.testing.assert_array_equal(m[: len(hypotheses)], no_knowledge())
    np.testing.assert_array_equal(m[MOTION : MOTION + SIZE], was)


def test_what_an_estimate_before_showed_is_forgotten_with_it():
    memory = np.zeros(1, MEMORY)[0]
    memory["numbers"] = 0.7
    restart_mode(memory)
    m = memory["numbers"]
    np.testing.assert_array_equal(m[: len(no_knowledge())], no_knowledge())
    np.testing.assert_array_equal(m[JAMMING : JAMMING + jamming.SIZE], jamming.new_memory())
    # The peg moves on.
    assert (m[MOTION:JAMMING] == 0.7).all()
    restart(memory)
    assert (m[MOTION:JAMMING] == 0.0).all()
