"""A sensor on its first day, which nobody has tared: it says so, and can be tared."""

from dataclasses import replace

import numpy as np
import pytest

from inputs import hanging
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.messages.decode import wrench_sample
from peg_on_hole_ros.records import JointSample, WrenchSample
from recorded_faults import BAGS, samples

MS = 1_000_000
ZERO = np.array([3.0, -2.0, 5.0, 0.10, -0.05, 0.02])
CYCLE, SLIP = BAGS[2], BAGS[0]


def hung(seconds, zero=ZERO, moves=lambda t: 0.0):
    """Yield samples of a peg that hangs free, from a sensor with a zero, and turns as told."""
    random = np.random.default_rng(3)
    for k in range(1, round(seconds * 500)):
        t_ns, gamma = 10**9 + 2 * k * MS, 0.15 + moves(k / 500)
        angles = random.normal((gamma, 0.0, 0.0), 1e-4)
        yield JointSample(t_ns, ("gamma", "psi", "phi"), tuple(angles.tolist()))
        read = wrench_sample(hanging(t_ns, gamma))
        force, torque = np.add(read.force, zero[:3]), np.add(read.torque, zero[3:])
        yield WrenchSample(t_ns, tuple(force.tolist()), tuple(torque.tolist()))


def line_of(**wrench):
    stated = Configuration()
    return Pipeline(replace(stated, wrench=replace(stated.wrench, **wrench)))


def after(outputs, seconds):
    return [out for out in outputs if out.t_ns >= 10**9 + round(seconds * 1e9)]


def test_a_zero_that_nobody_has_taken_is_no_contact_and_is_told():
    line, told = line_of(), {}
    modes, known = set(), set()
    for sample in hung(1.2):
        out = line.on_sample(sample)
        if out is not None:
            modes.add(out.contact_mode)
            known.add(out.monitor["reactions_determined"])
            for cause in line.causes:
                told.setdefault(cause, (out.t_ns - 10**9) * 1e-9)
    assert modes == {"unknown"} and known == {0.0}
    ((cause, seconds),) = told.items()
    assert seconds < 1.0
    assert "wrench.bias_force_stddev: a peg at rest reads [3, -2, 5] N" in cause
    assert "Tare it where it hangs free (~/tare, wrench.tare_automatically)" in cause


def test_it_is_tared_where_it_has_hung_still_for_a_second():
    line = line_of()
    list(line.play(hung(0.6)))
    answer = line.tare()
    assert not answer.success and "wrench.bias_force_stddev" in answer.message
    line = line_of()
    recorded = list(hung(2.0))
    middle = len(recorded) * 3 // 4
    list(line.play(recorded[:middle]))
    answer = line.tare()
    assert answer.success, answer.message
    assert "since the start, and the reading is assumed to be the bias" in answer.message
    # A mean of half a second, 250 wrenches of 0.2 N and 5 mN m.
    assert answer.message.startswith("tare over 25")
    taken = line.processor.reduction.taken_off
    assert taken[:3] == pytest.approx(ZERO[:3], abs=0.06)
    assert taken[3:] == pytest.approx(ZERO[3:], abs=0.003)
    outputs = list(line.play(recorded[middle:]))
    assert {out.contact_mode for out in after(outputs, 1.6)} == {"open"}
    assert not [alarm for out in outputs for alarm in out.alarms if alarm.level]
    assert line.causes == []


def test_it_is_tared_automatically_and_no_try_begins():
    line = line_of(tare_automatically=True)
    outputs = list(line.play(hung(3.5)))
    # After two seconds, and again after one that it hung free by its contact mode.
    assert line.counts["tare_automatic"] == line.counts["tare"] == 2
    assert line.processor.reduction.taken_off[:3] == pytest.approx(ZERO[:3], abs=0.1)
    assert {out.contact_mode for out in outputs} == {"unknown", "open"}
    assert {out.contact_mode for out in after(outputs, 3.0)} == {"open"}
    assert line.causes == [] and line.counts["tare_refused"] == 0


@pytest.mark.parametrize(
    ("zero", "moves"),
    [
        pytest.param(5.0 * ZERO, lambda t: 0.0, id="more than a zero is"),
        pytest.param(ZERO, lambda t: 0.02 * max(t - 1.0, 0.0), id="it has moved"),
    ],
)
def test_what_may_be_a_contact_is_tared_by_nobody(zero, moves):
    line = line_of(tare_automatically=True)
    list(line.play(hung(1.4, zero, moves)))
    # Half a second of rest behind the motion is no rest from the start on.
    assert line.counts["tare"] == 0
    assert not line.tare().success


def test_a_load_that_changes_at_rest_is_no_zero():
    recorded = list(hung(2.0))
    for k, sample in enumerate(recorded):
        if isinstance(sample, WrenchSample) and sample.t_ns > 10**9 + 800 * MS:
            x, y, z = sample.force
            recorded[k] = sample._replace(force=(x, y, z - 3.0))
    line = line_of(tare_automatically=True)
    list(line.play(recorded))
    assert line.counts["tare"] == 0 and not line.tare().success


def test_a_sensor_that_was_tared_is_believed_from_the_start_on():
    """In free air, and on three contacts that slide."""
    for bag, mode in ((CYCLE, "open"), (SLIP, "three_point")):
        line = Pipeline(Configuration())
        outputs = list(line.play(samples(bag, 0.0, 0.3)))
        begun = outputs[0].t_ns
        found = {out.contact_mode for out in outputs if out.t_ns > begun + 40 * MS}
        assert found == {mode}, bag
        assert line.causes == []


def test_a_zero_that_is_stated_to_be_uncertain_is_left_to_the_filter():
    line = line_of(bias_force_stddev=5.0, bias_torque_stddev=0.1)
    outputs = list(line.play(hung(0.5)))
    assert outputs[-1].contact_mode == "open" and line.causes == []
