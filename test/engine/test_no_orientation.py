"""Without any orientation what the peg is doing is a guess, and is not told as known."""

from dataclasses import replace

import numpy as np
import pytest

from late_samples import MS, ordered, pipeline
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.monitor.states import AlarmLevel
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.study import scenes

CUT, BACK = 0.15, 0.35


@pytest.fixture(scope="module")
def truth():
    case = next(case for case in scenes.CASES if case.name == "reversals")
    return scenes.truth_of(case, Configuration())


def played(truth, max_joint_gap, late=False, **monitor):
    """Return counts and outputs of a run whose joint states are silent for a while."""
    configuration = truth.plan.configuration
    options = replace(configuration.filter, max_joint_gap=max_joint_gap)
    monitor = replace(configuration.monitor, **monitor)
    pipeline = Pipeline(replace(configuration, filter=options, monitor=monitor))

    def silent(sample):
        t = (sample.t_ns - START_NS) * 1e-9
        return isinstance(sample, JointSample) and CUT < t < BACK

    samples = [each for each in measure(truth, 5) if not silent(each)]
    if late:
        # One wrench of the silence comes 10 ms late.
        place = next(
            k for k, each in enumerate(samples) if (each.t_ns - START_NS) * 1e-9 > CUT + 0.08
        )
        samples.insert(place + 10, samples.pop(place))
    outputs = list(pipeline.play(samples))
    return pipeline.counts, {round((o.t_ns - START_NS) * 1e-6): o for o in outputs}


@pytest.mark.parametrize("late", [False, True])
def test_mode_is_unknown_while_orientations_are_silent_and_told_again_after(truth, late):
    counts, outputs = played(truth, 0.05, late)
    assert counts["joints_gap"] == 1
    modes = {k: each.contact_mode for k, each in outputs.items()}
    assert modes[145] == modes[195] == "three_point"
    assert {modes[k] for k in range(202, 350) if k in modes} == {"unknown"}
    # As after a start, in which a mode takes some 20 ms.
    assert {modes[k] for k in range(400, 440)} == {"three_point"}


def test_a_vague_tilt_far_above_gamma0_shows_three_points_still():
    """A tilt without orientations is vague after some 190 ms, at 0.06 rad above gamma0."""
    configuration = pipeline().configuration
    options = replace(configuration.filter, max_joint_gap=0.5)
    line, gamma0 = Pipeline(replace(configuration, filter=options)), configuration.scene.gamma0
    samples = ordered()
    silent_ns = samples[0].t_ns + 90 * MS
    modes = []
    for told in line.play(
        s for s in samples if isinstance(s, WrenchSample) or s.t_ns <= silent_ns
    ):
        spread = np.sqrt(told.state_covariance[0, 0])
        above = told.state[0] - gamma0 > 3.0 * spread
        if told.t_ns > silent_ns and spread > 0.1 * gamma0 and above:
            modes.append(told.contact_mode)
    assert set(modes) == {"three_point"} and len(modes) > 5


@pytest.mark.parametrize("modes", [True, False])
def test_reactions_are_not_told_as_known(truth, modes):
    """Also where nobody looks for the mode."""
    _, outputs = played(truth, 0.05, modes=modes)
    told = [outputs[k] for k in range(210, 350) if k in outputs]
    assert len(told) > 100
    assert not any(row.monitor["reactions_determined"] for row in told)
    before = np.array(outputs[195].normal_stddev)
    assert all((row.normal_stddev > 3.0 * before).all() for row in told)
    assert outputs[430].monitor["reactions_determined"]


@pytest.mark.parametrize("modes", [True, False])
def test_no_wrench_moves_a_peg_that_is_not_seen(modes):
    """Whatever a wrench would make of a peg that slides, nobody knows where."""
    samples = ordered()
    configuration = pipeline().configuration
    options = replace(configuration.filter, max_joint_gap=0.05)
    monitor = replace(configuration.monitor, modes=modes)
    begin = samples[0].t_ns

    def end(pressed_from_ms):
        line = Pipeline(replace(configuration, filter=options, monitor=monitor))
        for sample in samples:
            t = sample.t_ns - begin
            if isinstance(sample, WrenchSample):
                share = 3.0 if t > pressed_from_ms * MS else 1.0
                line.on_wrench(sample._replace(force=tuple(share * f for f in sample.force)))
            elif t <= 120 * MS:
                line.on_joints(sample)
        return line.filter.x.copy(), line.filter.P.copy()

    whole = end(300)
    for one, other in zip(whole, end(180), strict=True):
        np.testing.assert_array_equal(other, one)
    assert (end(140)[0] != whole[0]).any()


def test_flag_and_alarms_stay_and_no_risk_is_told(truth):
    """A load that is over its limit before the silence is so to its end, though nobody knows."""
    _, outputs = played(truth, 0.05, max_normal=(1.0, 1.0, 1.0))
    assert any(alarm.level == AlarmLevel.ERROR for alarm in outputs[195].alarms)
    told = [outputs[k] for k in range(202, 350) if k in outputs]
    last = max(k for k in outputs if k < 202 and outputs[k].contact_mode != "unknown")
    assert {row.alarms for row in told} == {outputs[last].alarms}
    assert not any(name.startswith("jamming") for row in told for name in row.monitor)
    assert "jamming_risk" in outputs[last].monitor and "jamming_risk" in outputs[430].monitor


def test_no_transition_is_told_of_a_guess():
    """Constant rates lead on through gamma0 while the peg stands still above it."""
    configuration = Configuration()
    options = replace(configuration.filter, max_joint_gap=0.05)
    monitor = replace(configuration.monitor, modes=False)
    pipeline = Pipeline(replace(configuration, filter=options, monitor=monitor))
    gamma0 = configuration.scene.gamma0
    names, flags = tuple(configuration.joints.names), []
    for k in range(400):
        if k < 100:
            gamma = gamma0 + 0.03 - 0.2e-3 * k
            pipeline.on_joints(JointSample(START_NS + k * 1_000_000, names, (gamma, 0.0, 0.0)))
        wrench = WrenchSample(START_NS + k * 1_000_000, (0.0, 0.0, -5.0), (0.0, 0.0, 0.0))
        outputs = pipeline.on_wrench(wrench)
        flags.append(outputs.transition)
    assert pipeline.counts["joints_gap"] == 1
    assert outputs.state[0] < gamma0 and not any(flags)


def test_a_silence_that_is_allowed_changes_nothing_while_the_tilt_is_known(truth):
    _, outputs = played(truth, 0.5)
    assert {outputs[k].contact_mode for k in range(150, 240) if k in outputs} == {"three_point"}


@pytest.mark.parametrize("ends", [0.2, 0.45])
def test_no_transition_is_told_by_a_tilt_that_nobody_measures(ends):
    """Closing, the joint states end: the wrench alone tells neither side of gamma0."""
    line, samples = pipeline(), ordered(650)
    begun = samples[0].t_ns
    left = [s for s in samples if isinstance(s, WrenchSample) or s.t_ns < begun + ends * 1e3 * MS]
    outputs = list(line.play(left))
    gamma0 = line.scene.gamma0
    told = [o for o in outputs if o.contact_mode != "unknown" and o.t_ns > begun + ends * 1e3 * MS]
    # Its tilt was measured well above, and goes on for some time without.
    assert told and not any(o.transition for o in outputs)
    assert all(o.state[0] > gamma0 for o in told)
    assert outputs[-1].contact_mode == "unknown" and line.counts["joints_gap"] == 1
