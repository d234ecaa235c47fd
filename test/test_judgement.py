"""The one compiled call on one memory does, to the last bit, what its parts do on their own."""

from itertools import islice

import numpy as np

from peg_on_hole_ros.monitoring import assessment, jamming
from peg_on_hole_ros.monitoring.carried import new_means
from peg_on_hole_ros.monitoring.contacts import no_knowledge
from peg_on_hole_ros.monitoring.evidence import WIDTH, Shown, force_noise, settings, show
from peg_on_hole_ros.monitoring.jamming import Risk
from peg_on_hole_ros.monitoring.judgement import KNOWN, MOTION, RISK, SHOWN, forget, judge
from peg_on_hole_ros.monitoring.known import Known
from peg_on_hole_ros.monitoring.trend import SIZE, follow, new_trend
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.simulation.measure import measure
from simulated import truth


def test_one_call_does_what_its_parts_do(monkeypatch):
    motion = truth("closing_with_slip")
    line = Pipeline(motion.plan.configuration)
    options, scene = line.configuration.monitor, line.scene
    noise = force_noise(scene, line.processor.reduction.covariance)
    o = settings(options, noise, scene.clearance_stddev)
    limits = jamming.limits(options)
    hypotheses, means, trend, j = no_knowledge(), new_means(), new_trend(), jamming.new_memory()
    ratio = scene.peg_diameter / scene.hole_diameter
    stddev, memory = options.forecast_acceleration_stddev, options.forecast_acceleration_time
    found = []

    def oriented(m, since, q, R):
        follow_orientation(m, since, q, R)
        follow(trend, since, q, R, ratio, stddev, memory)
        np.testing.assert_array_equal(m[MOTION : MOTION + SIZE], trend)

    def judged(f, m, dt, since, nis, determinant, displaced):
        judge(f, m, dt, since, nis, determinant, displaced)
        shown, risk = np.zeros(WIDTH), np.zeros(len(Risk._fields))
        show(f, hypotheses, means, trend, o, dt, since, nis, determinant, displaced, shown)
        s = Shown(*shown.tolist())
        jamming.assess(
            f, trend, j, limits, dt, since, 1.0 - s.free, s.below, s.time, s.usable > 0.0, risk
        )
        np.testing.assert_array_equal(m[SHOWN:RISK], shown)
        np.testing.assert_array_equal(m[RISK:KNOWN], risk)
        known = Known(*m[KNOWN:].tolist())
        assert known[:4] == (*line.filter.friction, *line.filter.clearance)
        found.append((m, s, known))

    follow_orientation = assessment.follow_orientation
    monkeypatch.setattr(assessment, "follow_orientation", oriented)
    monkeypatch.setattr(assessment, "judge", judged)
    outputs = list(islice(line.play(measure(motion, 6)), 500))
    assert len(found) == 500
    for row, (_, s, known) in zip(outputs, found):
        assert row.monitor["transition_probability"] == s.below
        if row.contact_mode == "three_point" and s.usable:
            mean, most = row.normal.mean(), row.normal_stddev.max()
            known_enough = most <= mean / 3 and row.monitor["determinant"] > options.singular_band
            assert row.monitor["reactions_determined"] == known.reactions
            assert known.reactions <= known_enough
    m = found[-1][0]
    was = m[MOTION : MOTION + SIZE].copy()
    forget(m)
    np.testing.assert_array_equal(m[: len(hypotheses)], no_knowledge())
    np.testing.assert_array_equal(m[MOTION : MOTION + SIZE], was)
