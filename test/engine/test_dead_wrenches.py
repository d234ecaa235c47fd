"""A sensor that sends one wrench for long, bit for bit: it is told, and nothing is learnt."""

import numpy as np
import pytest

from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.records import WrenchSample
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


@pytest.mark.parametrize("zeros", [True, False])
def test_dead_wrenches_in_contact_are_told_and_teach_nothing(zeros):
    recorded = samples(CYCLE, 2.5, 4.1)
    undisturbed, nothing, _ = played(recorded)
    assert nothing == {}
    outputs, told, line = played(dead(recorded, 0.5, 1.1, zeros))
    seconds, text = only_told(told)
    assert 0.5 < seconds <= 0.7
    assert "from 0.500 s after the first on" in text
    assert ("(all six components are zero)" in text) == zeros
    # A few repeat by chance: 10 ms.
    during = between(outputs, 0.51, 1.1)
    assert {out.contact_mode for out in during} == {"unknown"}
    assert {out.monitor["reactions_determined"] for out in during} == {0.0}
    assert not [a for _, out in outputs for a in out.alarms if a.level]
    assert line.configuration == from_parameters({})
    assert not {"setting_adopted", "setting_contradicted"} & line.counts.keys()
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
    assert seconds <= 0.3 and "from 0.000 s after the first on" in text
    assert {out.contact_mode for out in between(outputs, 0.0, 0.9)} == {"unknown"}
    assert {out.contact_mode for out in between(outputs, 0.95, 1.19)} == {"open"}
    assert {out.contact_mode for out in between(outputs, 1.3, 1.6)} == {"three_point"}
    assert line.configuration == from_parameters({})
    assert not {"setting_adopted", "setting_contradicted"} & line.counts.keys()


def test_a_peg_at_rest_does_not_explain_a_wrench_that_stands_still():
    """A sensor has noise, whatever the peg does."""
    outputs, told, _ = played(dead(samples(CYCLE, 5.8, 6.6), 0.3, 0.6, zeros=False))
    assert only_told(told)[0] <= 0.5
    assert {out.contact_mode for out in between(outputs, 0.31, 0.6)} == {"unknown"}
    assert {out.contact_mode for out in between(outputs, 0.7, 0.8)} == {"three_point"}


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
    outputs, told, _ = played(coarse(recorded, 0.5, 0.02))
    assert not [cause for cause in told if "do not change" in cause]
    assert {out.contact_mode for out in between(outputs, 0.5, 1.1)} == {"open"}
    held, last = [], None
    for k, sample in enumerate(s for s in recorded if isinstance(s, WrenchSample)):
        last = last if k % 50 else sample
        held.append(last._replace(t_ns=sample.t_ns))
    others = [sample for sample in recorded if not isinstance(sample, WrenchSample)]
    outputs, told, _ = played(sorted([*others, *held], key=lambda sample: sample.t_ns))
    assert [cause[:43] for cause in told] == ["wrench: values repeat: each comes 50 times "]
    assert {out.contact_mode for out in between(outputs, 0.6, 1.1)} == {"open"}


def test_a_tare_takes_no_wrench_that_stood_still():
    recorded = samples(CYCLE, 7.6, 8.3)
    _, _, line = played(list(dead(recorded, 0.3, 0.65)))
    answer = line.tare()
    assert not answer.success and "or since one value stood still" in answer.message
    _, _, line = played(dead(samples(CYCLE, 7.6, 8.5), 0.3, 0.65))
    assert line.tare().success
    assert line.processor.reduction.taken_off[:3] == pytest.approx(0.0, abs=0.1)
