"""Alarms: when they rise and fall, and what they say."""

import pytest

from peg_on_hole_ros.monitoring.alarms import ERROR, OK, WARN, Alarms, Level
from peg_on_hole_ros.monitoring.jamming import Risk
from peg_on_hole_ros.options import MonitorOptions

OPTIONS = MonitorOptions()


def run(level, values):
    return [level.update(k * 1e-3, value) for k, value in enumerate(values)]


def test_one_sample_raises_no_alarm_and_clears_none():
    level = Level(0.7, 0.95, OPTIONS)
    assert set(run(level, [0, 0, 1.0, 0, 0])) == {OK}
    level = Level(0.7, 0.95, OPTIONS)
    seen = run(level, [1.0] * 50 + [0.0] * 3 + [1.0] * 50)
    assert seen[:10] == [OK] * 10
    assert seen[11:] == [ERROR] * len(seen[11:])


def test_alarm_falls_level_by_level_after_its_hold():
    level = Level(0.7, 0.95, OPTIONS)
    run(level, [1.0] * 50)
    steps = [level.update(0.05 + k * 1e-3, 0.2) for k in range(600)]
    hold = round(OPTIONS.alarm_hold * 1000)
    assert steps[hold - 1] == ERROR
    assert steps[hold + 1] == WARN
    assert steps[2 * hold + 2] == OK
    # Within the hysteresis it stays.
    level = Level(0.7, 0.95, OPTIONS)
    run(level, [0.8] * 50)
    assert level.update(10.0, 0.65) == WARN
    assert level.update(20.0, 0.65) == WARN


RISK = Risk(0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0)


def updates(alarms, duration=0.05, **given):
    values = {
        "mode": "three_point", "risk": RISK, "lost": [0.0, 0.0, 0.0],
        "normal": [20.0, 30.0, 30.0], **given,
    }  # fmt: skip
    for k in range(int(duration * 1000)):
        found = alarms.update(k * 1e-3, *values.values())
    return {alarm.name: alarm for alarm in found}


def test_each_alarm_has_its_cause_its_numbers_and_a_remedy():
    limit = OPTIONS.max_normal[1]
    quiet = updates(Alarms(OPTIONS))
    assert {alarm.level for alarm in quiet.values()} == {OK}
    loss = updates(Alarms(OPTIONS), mode="unknown", lost=[0.0, 0.0, 0.995])["contact_loss"]
    assert loss.level == ERROR
    assert "B2" in loss.message
    assert dict(loss.values)["open_probability_B2"] == 0.995
    overload = updates(Alarms(OPTIONS), normal=[20.0, limit * 0.9, 30.0])["overload"]
    assert overload.level == WARN
    assert "B1" in overload.message
    assert "reduce" in overload.message


@pytest.mark.parametrize(
    ("given", "level", "says"),
    [
        ({"wedging": 0.8, "risk": 0.8, "with_slip": 1.5}, WARN, ("turn it", "slip")),
        ({"wedging": 1.0, "risk": 1.0, "with_slip": 1.5}, ERROR, ("reverse", "slip")),
        ({"wedging": 1.0, "risk": 1.0, "with_slip": -0.2}, ERROR, ("reverse",)),
        ({"stall": 0.99, "wedging": 0.5, "risk": 0.99}, ERROR, ("stalls", "less force")),
        ({"load": 0.99, "risk": 0.99}, ERROR, ("load", "reduce the force")),
        ({"stall": 0.99, "risk": 0.99, "insertion": 0.1}, ERROR, ("in the hole", "pull back")),
    ],
)
def test_jamming_says_its_cause_and_what_helps(given, level, says):
    alarm = updates(Alarms(OPTIONS), risk=RISK._replace(**given))["jamming"]
    assert alarm.level == level
    assert all(part in alarm.message for part in says), alarm.message
    assert ("slip takes" in alarm.message) == (given.get("with_slip", 0) > 0.25)
    assert dict(alarm.values)["jamming_risk"] == given["risk"]


def test_the_cause_is_kept_while_the_alarm_is_held():
    alarms = Alarms(OPTIONS)
    updates(alarms, risk=RISK._replace(load=1.0, risk=1.0))
    for k in range(100):
        found = alarms.update(0.05 + k * 1e-3, "three_point", RISK, [0.0] * 3, [1.0] * 3)
    assert found[0].level == ERROR
    assert "load" in found[0].message
