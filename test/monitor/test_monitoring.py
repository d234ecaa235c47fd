"""Alarms: when they rise and fall, and what they say."""

import pytest

from judging import Alarms, Level, Risk, Shown
from peg_on_hole_ros.config.options import MonitorOptions
from peg_on_hole_ros.monitor.alarm_text import HELD_PREFIX
from peg_on_hole_ros.monitor.states import AlarmLevel

OPTIONS = MonitorOptions()
OK, WARN, ERROR = AlarmLevel


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
    # It is a probability: 0.85 and 0.6, where shares of the thresholds would be 0.855 and 0.63.
    level = Level(0.7, 0.95, OPTIONS)
    run(level, [1.0] * 50)
    assert [level.update(10.0 * k, 0.852) for k in (1, 2)] == [ERROR, ERROR]
    assert [level.update(10.0 * k, 0.84) for k in (3, 4)] == [ERROR, WARN]
    assert [level.update(10.0 * k, 0.61) for k in (5, 6)] == [WARN, WARN]
    assert [level.update(10.0 * k, 0.59) for k in (7, 8)] == [WARN, OK]


RISK = Risk(0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
CONTACT = Shown(*[0.0] * len(Shown._fields))._replace(three_point=1.0, time=-1.0)
K_OPEN = CONTACT._replace(three_point=0.0, opened=0.99, lost_K=0.95)


def updates(alarms, duration=0.05, begin=0.0, **given):
    values = {
        "mode": "three_point", "risk": RISK, "shown": CONTACT, "normal": [20.0, 30.0, 30.0],
        **given,
    }  # fmt: skip
    for k in range(int(duration * 1000)):
        found = alarms.update(begin + k * 1e-3, *values.values())
    return {alarm.name: alarm for alarm in found}


def test_each_alarm_has_its_cause_its_numbers_and_a_remedy():
    alarms, limit = Alarms(OPTIONS), OPTIONS.max_normal[1]
    quiet = updates(alarms, 0.1)
    assert {alarm.level for alarm in quiet.values()} == {OK}
    one = CONTACT._replace(three_point=0.0, opened=0.995, lost_B2=0.995)
    loss = updates(alarms, begin=0.1, mode="unknown", shown=one)["contact_loss"]
    assert loss.level == ERROR
    assert "B2" in loss.message and "press" in loss.message
    assert dict(loss.values)["open_probability_B2"] == 0.995
    # What is foreseen counts, and that contact is named of which it is, which need not be the
    # most loaded one yet.
    near = {"risk": RISK._replace(load=0.8, risk=0.8, loaded=1.0), "normal": [limit, 90.0, 30.0]}
    overload = updates(Alarms(OPTIONS), **near)["overload"]
    assert overload.level == WARN
    assert "B1" in overload.message
    assert "reduce" in overload.message
    assert dict(overload.values)["jamming_load"] == 0.8


@pytest.mark.parametrize(
    ("mode", "shown", "says"),
    [
        ("unknown", K_OPEN, "contact K is open"),
        ("unknown", K_OPEN._replace(lost_K=0.4, lost_B1=0.3, lost_B2=0.29), "a contact is open"),
        ("open", CONTACT._replace(three_point=0.0, opened=0.3, free=0.7), "left the rim"),
    ],
)
def test_contact_that_was_there_is_lost(mode, shown, says):
    alarms = Alarms(OPTIONS)
    # Never on three contacts: nothing is lost.
    assert updates(alarms, mode=mode, shown=shown)["contact_loss"].level == OK
    updates(alarms, 0.1, 0.1)
    loss = updates(alarms, 0.05, 0.2, mode=mode, shown=shown)["contact_loss"]
    assert loss.level == ERROR and says in loss.message


def test_three_contacts_for_a_moment_are_none_to_lose():
    alarms = Alarms(OPTIONS)
    updates(alarms, 0.03)
    assert updates(alarms, 0.1, 0.03, mode="unknown", shown=K_OPEN)["contact_loss"].level == OK


@pytest.mark.parametrize(("rested", "level"), [(0.9, OK), (1.1, ERROR)])
def test_a_touch_down_that_bounces_had_no_three_contacts_to_lose(rested, level):
    """At rest one contact looks like three, until the peg has settled."""
    alarms, lasts = Alarms(OPTIONS), rested * OPTIONS.alarm_hold
    updates(alarms, lasts, shown=CONTACT._replace(three_point=0.2, stuck=0.8))
    off = {"mode": "open", "shown": CONTACT._replace(three_point=0.0, free=1.0)}
    assert updates(alarms, 0.05, lasts, **off)["contact_loss"].level == level


def test_what_is_no_loss_of_contact():
    # A contact that opens just before gamma0 opens on the way into the hole, one before that does
    # not.
    for time, level in ((0.0, OK), (0.025, OK), (0.04, ERROR), (-1.0, ERROR)):
        alarms = Alarms(OPTIONS)
        updates(alarms, 0.1)
        shown = K_OPEN._replace(time=time)
        assert updates(alarms, 0.05, 0.1, shown=shown)["contact_loss"].level == level
    # The reactions of a peg that jams say nothing of its contacts.
    alarms = Alarms(OPTIONS)
    updates(alarms, 0.1, risk=RISK._replace(wedging=1.0, risk=1.0))
    assert updates(alarms, 0.05, 0.1, shown=K_OPEN)["contact_loss"].level == OK


def test_air_is_a_state_and_no_event():
    alarms = Alarms(OPTIONS)
    updates(alarms, 0.1)
    free = {"mode": "open", "shown": CONTACT._replace(three_point=0.0, free=1.0)}
    assert updates(alarms, 0.1, 0.1, **free)["contact_loss"].level == ERROR
    assert updates(alarms, 0.8, 0.2, **free)["contact_loss"].level == OK


def test_a_loss_that_is_held_says_which_contact_it_was():
    """B1 opens and closes again; what little is left speaks of a peg that is clear of the rim."""
    alarms = Alarms(OPTIONS)
    updates(alarms, 0.1)
    one = CONTACT._replace(three_point=0.0, opened=0.99, lost_B1=0.99)
    assert updates(alarms, 0.1, 0.1, mode="unknown", shown=one)["contact_loss"].level == ERROR
    again = CONTACT._replace(three_point=0.998, opened=1e-4, lost_B1=1e-4, free=2e-4)
    held, levels = set(), []
    for k in range(1200):
        loss = updates(alarms, 1e-3, 0.2 + k * 1e-3, shown=again)["contact_loss"]
        levels.append(loss.level)
        if loss.level:
            held.add((loss.message.startswith(HELD_PREFIX), "B1" in loss.message, loss.numbers[1]))
    assert held == {(True, True, 0.99)}
    assert levels[0] == ERROR and WARN in levels and levels[-1] == OK
    # Nothing is held: the numbers are those of now.
    assert loss.message == "no contact is being lost" and loss.numbers[-1] == 2e-4


@pytest.mark.parametrize("mode", ["three_point", "unknown"])
def test_an_overload_that_is_held_says_which_contact_it_was_with_its_numbers(mode):
    """Then the reactions are no longer told: all of them are zero."""
    alarms, limit = Alarms(OPTIONS), OPTIONS.max_normal[1]
    over = {
        "risk": RISK._replace(load=0.99, risk=0.99, loaded=1.0), "normal": [20.0, limit, 30.0]
    }  # fmt: skip
    now = updates(alarms, 0.1, **over)["overload"]
    assert now.level == ERROR and "B1 is over" in now.message
    for begin in (0.1, 0.11):
        held = updates(alarms, 0.01, begin, mode=mode, normal=[0.0] * 3)["overload"]
        assert held == now._replace(message=HELD_PREFIX + now.message)
    later = updates(alarms, 1.5, 0.2, mode=mode, normal=[0.0] * 3)["overload"]
    assert later.level == OK and later.message == "every contact is within its allowed load"
    assert dict(later.values).get("normal_B1", 0.0) == 0.0
    # A new cause is a new one.
    again = {"risk": RISK._replace(load=0.99, risk=0.99), "normal": [1e6, limit, 30.0]}
    assert "contact K is over" in updates(alarms, 0.1, 1.8, **again)["overload"].message


def test_jamming_that_is_held_says_so():
    alarms = Alarms(OPTIONS)
    now = updates(alarms, 0.1, risk=RISK._replace(stall=0.99, risk=0.99))["jamming"]
    held = updates(alarms, 0.1, 0.1)["jamming"]
    assert held.level == ERROR and held.message == HELD_PREFIX + now.message
    # By hysteresis too: it is no longer as likely as an alarm takes.
    near = updates(alarms, 0.1, 0.2, risk=RISK._replace(stall=0.65, risk=0.65))["jamming"]
    assert near.level == ERROR and near.message.startswith(HELD_PREFIX)
    # Another cause, which would give WARN alone, is not what the ERROR was raised for.
    load = updates(alarms, 5.0, 0.3, risk=RISK._replace(load=0.81, risk=0.81))["jamming"]
    assert load.level == ERROR and load.message == HELD_PREFIX + now.message


def test_what_means_nothing_is_not_among_the_numbers():
    above = updates(Alarms(OPTIONS))["jamming"]
    assert "determinant" in above.names
    assert "insertion_ratio" not in above.names
    in_hole = RISK._replace(determinant=0.0, insertion=0.3, margin=7.0)
    alarm = updates(Alarms(OPTIONS), mode="two_point", risk=in_hole)["jamming"]
    assert "determinant" not in alarm.names
    assert dict(alarm.values)["insertion_ratio"] == 0.3
    assert dict(alarm.values)["whitney_margin"] == 7.0


@pytest.mark.parametrize(
    ("given", "level", "says"),
    [
        ({"wedging": 0.8, "risk": 0.8}, WARN, ("wedges", "do not continue this closing")),
        ({"wedging": 1.0, "risk": 1.0}, ERROR, ("wedges", "reverse")),
        ({"stall": 0.99, "wedging": 0.5, "risk": 0.99}, ERROR, ("stalls", "less force")),
        ({"load": 0.99, "risk": 0.99}, ERROR, ("load", "reduce the force")),
        ({"stall": 0.99, "risk": 0.99, "insertion": 0.1}, ERROR, ("in the hole", "pull back")),
    ],
)
def test_jamming_says_its_cause_and_what_helps(given, level, says):
    alarm = updates(Alarms(OPTIONS), risk=RISK._replace(**given))["jamming"]
    assert alarm.level == level
    assert all(part in alarm.message for part in says), alarm.message
    assert dict(alarm.values)["jamming_risk"] == given["risk"]


def test_the_cause_is_kept_while_the_alarm_is_held():
    alarms = Alarms(OPTIONS)
    updates(alarms, risk=RISK._replace(load=1.0, risk=1.0))
    for k in range(100):
        found = alarms.update(0.05 + k * 1e-3, "three_point", RISK, CONTACT, [1.0] * 3)
    assert found[0].level == ERROR
    assert "load" in found[0].message
