"""A sensor whose zero jumps in mid-run: it is told, and no contact is lost or found by it."""

import numpy as np
import pytest

from inputs import hanging
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.messages.decode import wrench_sample
from peg_on_hole_ros.records import JointSample, WrenchSample
from recorded_faults import BAGS, samples, spoilt, without_weight

# Touches down at 1.2 s, slides on three contacts until 5.7 s, lifts off at 6.856 s.
CYCLE = BAGS[2]
COMPENSATED = {"wrench.gravity": "compensated"}


def jumped(recorded, seconds, jump):
    """Return samples whose wrenches have a jump, shape (6,), from so many seconds on."""
    begun, found = recorded[0].t_ns, []
    for sample in recorded:
        if isinstance(sample, WrenchSample) and sample.t_ns - begun >= round(seconds * 1e9):
            force, torque = np.add(sample.force, jump[:3]), np.add(sample.torque, jump[3:])
            sample = WrenchSample(sample.t_ns, tuple(force.tolist()), tuple(torque.tolist()))
        found.append(sample)
    return found


def last_mean(recorded, seconds):
    """Return the mean of the last 0.1 s, which a driver's service takes as the zero."""
    begun = recorded[0].t_ns
    rows = [
        (*sample.force, *sample.torque)
        for sample in recorded
        if isinstance(sample, WrenchSample)
        and seconds - 0.1 <= (sample.t_ns - begun) * 1e-9 < seconds
    ]
    return np.mean(rows, axis=0)


def zeroed(recorded, seconds):
    return jumped(recorded, seconds, -last_mean(recorded, seconds))


def played(recorded, parameters=None):
    """Return outputs by time [s], when a jump was told [s] and how, and the line."""
    line, begun, told, outputs = Pipeline(from_parameters(parameters or {})), None, [], []
    for sample in recorded:
        begun = sample.t_ns if begun is None else begun
        seconds = (sample.t_ns - begun) * 1e-9
        found = line.on_sample(sample)
        if found is not None:
            outputs.append((seconds, found))
        jumps = [cause for cause in line.causes if "has jumped" in cause]
        if jumps and not told:
            told = [seconds, jumps[0]]
    return outputs, told, line


def between(outputs, begin, end):
    return [out for seconds, out in outputs if begin <= seconds < end]


def modes(outputs, begin, end):
    return {out.contact_mode for out in between(outputs, begin, end)}


def raised(outputs):
    return [alarm for _, out in outputs for alarm in out.alarms if alarm.level > 0]


def size_of(text):
    return float(text.split("jumped by ")[1].split(" N")[0])


@pytest.mark.parametrize("gravity", ["included", "compensated"])
def test_a_sensor_that_is_zeroed_in_contact_loses_no_contact(gravity):
    """Where a controller takes the weight off, a free peg would read zero as well."""
    recorded, parameters = samples(CYCLE, 3.2, 5.4), {}
    if gravity == "compensated":
        recorded, parameters = list(spoilt(recorded, without_weight)), COMPENSATED
    size = np.linalg.norm(last_mean(recorded, 0.6)[:3])
    outputs, (seconds, text), line = played(zeroed(recorded, 0.6), parameters)
    assert 0.6 < seconds <= 0.8
    assert "the driver zeroes its sensor" in text and "at 0.600 s" in text and "Tare it" in text
    # Lines through 30 wrenches on each side, of loads that go on.
    assert size_of(text) == pytest.approx(size, rel=0.1)
    assert raised(outputs) == []
    # A step is doubted at the next look, 20 ms later.
    assert modes(outputs, 0.63, 0.95) == {"unknown"}
    assert modes(outputs, 1.2, 2.2) == {"three_point"}
    later = between(outputs, 0.63, 2.2)
    assert {out.monitor["reactions_determined"] for out in later} == {0.0}
    # What the wrong zero taught is forgotten: friction is 0.2, and stated so with 0.05.
    assert abs(later[200].monitor["friction"] - 0.2) < 0.05
    assert line.counts["zero_jumped"] == 1 and line.counts["setting_adopted"] == 0


def test_a_step_to_another_level_is_no_zero():
    """Friction that steps, and a touch of hard parts, step from one wrench to the next as well."""
    jump = np.array([5.0, -6.0, 2.0, 0.1, 0.1, 0.0])
    _, told, line = played(jumped(samples(CYCLE, 3.4, 4.6), 0.5, jump))
    assert told == [] and line.counts["zero_jumped"] == 0


def hung(seconds):
    """Return samples of a peg that hangs free and still, with noise, at 500 Hz."""
    random, found = np.random.default_rng(3), []
    for k in range(1, round(seconds * 500)):
        t_ns = 10**9 + 2_000_000 * k
        angles = random.normal((0.15, 0.0, 0.0), 1e-4)
        found.append(JointSample(t_ns, ("gamma", "psi", "phi"), tuple(angles.tolist())))
        found.append(wrench_sample(hanging(t_ns, 0.15)))
    return found


@pytest.mark.parametrize("automatically", [False, True])
def test_a_sensor_that_is_zeroed_in_free_air_is_tared_there(automatically):
    """It reads zero, where its weight hangs: no contact, and a tare ends the doubt."""
    recorded = hung(3.5)
    zero = -last_mean(recorded, 1.0)
    parameters = {"wrench.tare_automatically": automatically}
    # One before the jump, as it has hung free for a second, would not be needed.
    outputs, (seconds, text), line = played(zeroed(recorded, 0.9), parameters)
    assert 0.9 < seconds <= 1.1
    assert size_of(text) == pytest.approx(np.linalg.norm(zero[:3]), abs=0.3)
    assert modes(outputs, 0.93, 3.5) == {"unknown", "open"}
    assert modes(outputs, 1.6, 3.5) == {"open"}
    assert raised(outputs) == []
    if not automatically:
        answer = line.tare()
        assert answer.success, answer.message
    # A mean of 100 wrenches of 0.2 N and 5 mN m.
    assert line.processor.reduction.taken_off[:3] == pytest.approx(zero[:3], abs=0.1)
    assert line.causes == []


def test_what_is_found_may_be_told_alone():
    parameters = {"wrench.adopt_found": False}
    outputs, (_, text), line = played(zeroed(samples(CYCLE, 3.4, 4.6), 0.5), parameters)
    assert "the contact mode is unknown until then" in text
    assert modes(outputs, 0.53, 1.2) <= {"unknown", "open"}
    assert np.all(line.processor.reduction.taken_off == 0.0)


@pytest.mark.parametrize("weight", ["included", "compensated"])
@pytest.mark.parametrize("bag", BAGS, ids=lambda path: path.stem)
def test_loads_that_come_and_go_are_no_jump(bag, weight):
    """Touch-down, reversal of slip, rest, lift-off, wedging, the way into the hole."""
    recorded, parameters = samples(bag), {}
    if weight == "compensated":
        recorded, parameters = list(spoilt(recorded, without_weight)), COMPENSATED
    _, told, line = played(recorded, parameters)
    assert told == [] and line.counts["zero_jumped"] == 0
    assert line.counts["contact_doubted"] == 0


def test_a_spike_is_no_jump():
    recorded = samples(CYCLE, 3.4, 4.2)
    wrenches = [i for i, sample in enumerate(recorded) if isinstance(sample, WrenchSample)]
    for i in wrenches[400:403]:
        recorded[i] = recorded[i]._replace(force=(0.0, 0.0, 0.0), torque=(0.0, 0.0, 0.0))
    assert played(recorded)[1] == []
