"""Values that repeat bit for bit under fresh stamps: told, and not taken for news."""

import json

import numpy as np
import pytest

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.records import JointSample, WrenchSample
from recorded_faults import BAGS, samples
from small_bags import WRENCH, wrench

CYCLE = BAGS[2]


def held(recorded, times, kind=WrenchSample):
    """Yield samples with each value of a kind sent so many times, under the stamps as they are."""
    count, last = 0, None
    for sample in recorded:
        if isinstance(sample, kind):
            last = last if count % times else sample
            count += 1
            sample = last._replace(t_ns=sample.t_ns)
        yield sample


def frozen(recorded, seconds, kind=JointSample):
    """Yield samples of which those of a kind keep one value from so many seconds on."""
    begun, last = recorded[0].t_ns, None
    for sample in recorded:
        if isinstance(sample, kind) and (sample.t_ns - begun) * 1e-9 >= seconds:
            last = last or sample
            sample = last._replace(t_ns=sample.t_ns)
        yield sample


def told_after(recorded, parameters=None):
    """Return the causes with the time at which each was told first [s], and the outputs."""
    line, begun, told, outputs = Pipeline(from_parameters(parameters or {})), None, {}, []
    for sample in recorded:
        begun = sample.t_ns if begun is None else begun
        outputs += filter(None, [line.on_sample(sample)])
        for cause in line.causes:
            told.setdefault(cause.split(" for ")[0], (sample.t_ns - begun) * 1e-9)
    return told, outputs, line


@pytest.mark.parametrize("times", [2, 4, 10])
def test_a_hold_of_the_wrench_is_told_with_how_often(times):
    told, _, _ = told_after(held(samples(CYCLE, 2.0, 2.3), times))
    ((cause, seconds),) = told.items()
    assert cause == (
        f"wrench: values repeat: each comes {times} times in a row, new ones at "
        f"{1000 / times:.3g} Hz, as where a driver holds those of a slower sensor; they count as "
        "one"
    )
    assert seconds < 0.1


def test_joint_states_that_are_held_are_used_once():
    told, _, line = told_after(held(samples(CYCLE, 2.0, 2.3), 5, JointSample))
    assert [cause[:46] for cause in told] == ["joints: values repeat: each comes 5 times in a"]
    used, dropped = line.counts["joints_used"], line.counts["joints_dropped_repeated_value"]
    assert 27 <= used <= 35 and dropped >= 110 and dropped + used > 140


@pytest.mark.parametrize("times", [4, 10])
def test_bounds_hold_under_a_hold(tmp_path, capsys, times):
    path, count = tmp_path / "held.mcap", 0
    source = Bag(BAGS[1])
    with BagWriter(path) as bag:
        for topic, log_ns, message in source.messages(list(source.topics)):
            name, fields = source.topics[topic].types[0], message
            if topic == "/wrench":
                if count % times == 0:
                    values = message.wrench
                count += 1
                vectors = ((v.x, v.y, v.z) for v in (values.force, values.torque))
                name, fields = WRENCH, wrench(log_ns, *vectors)
            bag.write(topic, name, plain(fields), log_ns)
    summary = tmp_path / "summary.json"
    assert main(["replay", str(path), "--summary", str(summary)]) == 0
    told = capsys.readouterr().out.splitlines()
    assert [f"each comes {times} times" in line for line in told].count(True) == 1
    assert not [line for line in told if "check sensor_xyz" in line]
    covered = json.loads(summary.read_text())["coverage95"]
    assert len(covered) == 6 and min(covered.values()) >= 0.9, covered
    assert main(["inspect", str(path)]) == 0
    assert f"/wrench: values repeat: each comes {times} times" in capsys.readouterr().out


def plain(message):
    """Return a message as fields."""
    if isinstance(message, dict):
        return message
    names = getattr(message, "__slots__", None)
    if names is None:
        return [plain(item) for item in message] if isinstance(message, list) else message
    return {name.removeprefix("_"): plain(getattr(message, name)) for name in names}


def test_encoders_that_stand_still_are_told_and_not_believed():
    told, outputs, line = told_after(frozen(samples(CYCLE, 8.9, 10.4), 0.4))
    ((cause, seconds),) = told.items()
    assert cause == "joints: joint states that do not change" and 0.4 < seconds < 0.5
    after = [out for out in outputs if out.t_ns > outputs[0].t_ns + 500_000_000]
    assert {out.contact_mode for out in after} == {"unknown"}
    assert {out.monitor["reactions_determined"] for out in after} == {0.0}
    assert not [a for out in after for a in out.alarms if a.name == "jamming" and a.level]
    assert line.counts["joints_dropped_repeated_value"] > 490


def test_a_sensor_that_stands_still_is_told_and_not_believed():
    told, outputs, line = told_after(frozen(samples(CYCLE, 8.9, 10.4), 0.4, WrenchSample))
    ((cause, seconds),) = told.items()
    assert cause == "wrench: wrenches that do not change" and 0.4 < seconds < 0.5
    after = [out for out in outputs if out.t_ns > outputs[0].t_ns + 500_000_000]
    assert {out.contact_mode for out in after} == {"unknown"}
    assert {out.monitor["reactions_determined"] for out in after} == {0.0}
    assert not [a for out in after for a in out.alarms if a.name == "jamming" and a.level]
    # At rest, and without noise, a wrench that stays is true.
    rest = samples(CYCLE, 5.8, 6.4)
    assert told_after(frozen(rest, 0.2, WrenchSample))[0] == {}
    # What goes on is believed again.
    again = [*frozen(samples(CYCLE, 8.9, 9.5), 0.4, WrenchSample), *samples(CYCLE, 9.5, 9.8)]
    _, outputs, _ = told_after(again)
    assert outputs[599].contact_mode == "unknown" and outputs[-1].contact_mode == "three_point"


def test_a_peg_at_rest_and_coarse_encoders_are_believed():
    rest = samples(CYCLE, 5.8, 6.4)
    # Encoders without noise: at rest one value.
    assert told_after(frozen(rest, 0.2))[0] == {}

    def rounded(sample):
        position = tuple(np.round(np.array(sample.position) / 1e-4) * 1e-4)
        return sample._replace(position=position)

    moving = samples(CYCLE, 2.0, 2.4)
    coarse = [rounded(s) if isinstance(s, JointSample) else s for s in moving]
    told, _, line = told_after(coarse)
    assert told == {} and line.counts["joints_used"] == 200
