"""A sensor that sends one wrench for long, bit for bit: it is told, and nothing is learnt."""

import numpy as np
import pytest

from inputs import hanging
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.messages.decode import wrench_sample
from peg_on_hole_ros.records import JointSample, WrenchSample
from recorded_faults import BAGS, samples

# Touches down at 1.2 s, is on three contacts until 5.7 s, pressed and at rest until 6.85 s.
CYCLE = BAGS[2]


def dead(recorded, begin, end, zeros=True):
    """Yield samples with wrenches that are zero, or one value, between two times [s]."""
    begun, last = recorded[0].t_ns, None
    for sample in recorded:
        if isinstance(sample, WrenchSample):
            if not begin <= (sample.t_ns - begun) * 1e-9 < end:
                last = None
            elif zeros:
                sample = WrenchSample(sample.t_ns, (0.0,) * 3, (0.0,) * 3)
            else:
                last = last or sample
                sample = last._replace(t_ns=sample.t_ns)
        yield sample


def played(recorded):
    """Return outputs by time [s], causes with the time at which each was told, and the line."""
    line, begun, told, outputs = Pipeline(from_parameters({})), None, {}, []
    for sample in recorded:
        begun = sample.t_ns if begun is None else begun
        seconds = (sample.t_ns - begun) * 1e-9
        found = line.on_sample(sample)
        if found is not None:
            outputs.append((seconds, found))
        for cause in line.causes:
            told.setdefault(cause.split(" for ")[0], (seconds, cause))
    return outputs, told, line


def between(outputs, begin, end):
    return [out for seconds, out in outputs if begin <= seconds < end]


def only_told(told):
    """Return when, and in which words, the one cause was told."""
    ((cause, (seconds, text)),) = told.items()
    assert cause == "wrench: wrenches that do not change"
    return seconds, text


@pytest.mark.parametrize(("zeros", "believed"), [(True, 0.01), (False, 0.1)])
def test_dead_wrenches_in_contact_are_told_and_teach_nothing(zeros, believed):
    recorded = samples(CYCLE, 2.5, 4.1)
    undisturbed, nothing, _ = played(recorded)
    assert nothing == {}
    outputs, told, line = played(dead(recorded, 0.5, 1.1, zeros))
    seconds, text = only_told(told)
    assert 0.5 < seconds <= 0.7
    assert "from 0.500 s on" in text and "wrenches stand still" in text
    assert ("all six components zero" in text) == zeros
    # A few repeat by chance; another value than zero is true for a moment.
    during = between(outputs, 0.5 + believed, 1.1)
    assert {out.contact_mode for out in during} == {"unknown"}
    assert {out.monitor["reactions_determined"] for out in during} == {0.0}
    assert not [a for _, out in outputs for a in out.alarms if a.level]
    assert line.counts["wrench_stands_still"] >= len(during)
    assert line.configuration == from_parameters({})
    # The one finding is that they stand still.
    assert line.counts["setting_contradicted"] == 1 and line.counts["setting_adopted"] == 0
    # A mode is declared anew within 0.1 s, and says what it would have said.
    after, same = (between(each, 1.2, 1.6) for each in (outputs, undisturbed))
    assert {out.contact_mode for out in after} == {"three_point"}
    assert {out.monitor["reactions_determined"] for out in after} == {1.0}
    for out, known in zip(after, same, strict=True):
        # Both are within their bounds of one truth.
        assert (np.abs(out.normal - known.normal) < 2.0 * known.normal_stddev).all()
    last, known = after[-1].monitor, same[-1].monitor
    assert abs(last["friction"] - known["friction"]) < 2.0 * known["friction_stddev"]


def test_a_sensor_that_sends_zeros_at_first_is_told_and_contacts_are_not():
    outputs, told, line = played(dead(samples(CYCLE, 0.0, 1.6), 0.0, 0.9))
    seconds, text = only_told(told)
    assert seconds <= 0.3 and "from 0.000 s on" in text
    assert {out.contact_mode for out in between(outputs, 0.0, 0.9)} == {"unknown"}
    assert {out.contact_mode for out in between(outputs, 0.95, 1.19)} == {"open"}
    assert {out.contact_mode for out in between(outputs, 1.3, 1.6)} == {"three_point"}
    assert line.configuration == from_parameters({})
    assert line.counts["setting_adopted"] == 0


def test_a_sensor_that_has_had_noise_and_has_none_is_dead_at_rest_as_well():
    outputs, told, _ = played(dead(samples(CYCLE, 5.7, 6.7), 0.1, 0.8, zeros=False))
    seconds, text = only_told(told)
    # A lost packet that a driver bridges is in order.
    assert 0.55 < seconds < 0.65 and "while the peg turns" not in text
    assert {out.contact_mode for out in between(outputs, 0.21, 0.8)} == {"unknown"}
    assert {out.contact_mode for out in between(outputs, 0.9, 1.0)} == {"three_point"}


def test_a_sensor_without_noise_is_believed_at_rest():
    """Whether it reads the weight or, where a controller takes that off, zero."""
    for gravity, force in (("measured", 0.5 * 9.80665), ("compensated", 0.0)):
        line = Pipeline(from_parameters({"wrench.gravity": gravity}))
        outputs = list(
            line.play(
                WrenchSample(sample.t_ns, (0.0, 0.0, force), (0.0, 0.0, 0.0))
                if isinstance(sample, WrenchSample)
                else sample._replace(position=(0.0, 0.0, 0.0))
                for sample in samples(CYCLE, 0.0, 0.7)
            )
        )
        assert {out.contact_mode for out in outputs[100:]} == {"open"}
        assert line.counts["wrench_stands_still"] == 0 and line.causes == []


def held(recorded, times):
    """Yield samples with each wrench sent so many times, under the stamps as they are."""
    count, last = 0, None
    for sample in recorded:
        if isinstance(sample, WrenchSample):
            last = last if count % times else sample
            count += 1
            sample = last._replace(t_ns=sample.t_ns)
        yield sample


def coarse(recorded, force, torque):
    """Yield samples with wrenches rounded to steps [N], [N m]."""
    for sample in recorded:
        if isinstance(sample, WrenchSample):
            values = [
                tuple((np.round(np.array(each) / step) * step).tolist())
                for each, step in ((sample.force, force), (sample.torque, torque))
            ]
            sample = WrenchSample(sample.t_ns, *values)
        yield sample


def test_values_that_repeat_for_a_while_do_not_stand_still():
    """Of a sensor with steps above its noise, and of one that is slower than its publisher."""
    recorded = samples(CYCLE, 0.0, 1.1)
    outputs, told, line = played(coarse(recorded, 0.5, 0.02))
    assert not [cause for cause in told if "do not change" in cause]
    assert line.counts["wrench_stands_still"] == 0
    assert {out.contact_mode for out in between(outputs, 0.5, 1.1)} == {"open"}
    outputs, told, line = played(held(recorded, 50))
    assert [cause[:43] for cause in told] == ["wrench: values repeat: each comes 50 times "]
    assert {out.contact_mode for out in between(outputs, 0.6, 1.1)} == {"open"}
    assert line.counts["wrench_stands_still"] == 0


def hung(seconds):
    """Return samples of a peg that hangs free and still, with noise, at 500 Hz."""
    random, found = np.random.default_rng(3), []
    for k in range(round(seconds * 500)):
        t_ns = 10**9 + 2_000_000 * k
        found.append(JointSample(t_ns, ("gamma", "psi", "phi"), (0.15, 0.0, 0.0)))
        found.append(wrench_sample(hanging(t_ns, 0.15)))
        noise = random.normal(size=6) * ([0.2] * 3 + [0.005] * 3)
        force, torque = np.add(found[-1].force, noise[:3]), np.add(found[-1].torque, noise[3:])
        found[-1] = WrenchSample(t_ns, tuple(force.tolist()), tuple(torque.tolist()))
    return found


@pytest.mark.parametrize(("seconds", "taken"), [(0.7, False), (0.9, True)])
def test_a_tare_takes_no_wrench_that_stood_still(seconds, taken):
    _, _, line = played(dead(hung(seconds), 0.3, 0.65))
    answer = line.tare()
    assert answer.success == taken, answer.message
    assert taken or "or since the wrench changed again" in answer.message
    if taken:
        # A mean of 100 wrenches of 0.2 N.
        assert line.processor.reduction.taken_off[:3] == pytest.approx(0.0, abs=0.08)
