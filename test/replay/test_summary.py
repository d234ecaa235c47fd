"""Summary and stamps: known outputs in, known figures out."""

import pickle

import numpy as np
import pytest

from peg_on_hole_ros.messages.beside_estimates import BOOL, DIAGNOSTICS, STRING
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.monitor.output_row import NOTHING
from peg_on_hole_ros.records import ACCURACIES, UNOBSERVABLE_SETTINGS, Rows
from peg_on_hole_ros.replay import summary as module
from peg_on_hole_ros.replay.stamp_statistics import StampStatistics
from peg_on_hole_ros.replay.summary import Summary

MS = 1_000_000


def columns(t_ns, messages, normal=0.0, determined=0.0):
    """Return the outputs of one stamp, with messages beside."""
    rows = NOTHING.copy()
    rows["normal"], rows["reactions_determined"] = normal, determined
    return OutputColumns(Rows(np.array([t_ns], np.int64), rows), [(0, messages)])


def alarms(**levels):
    status = [
        {"name": n, "level": level, "message": f"{n} {level}"} for n, level in levels.items()
    ]
    return "alarms", DIAGNOSTICS, {"status": status}


def test_figures_are_those_of_the_outputs():
    summary = Summary()
    start = 5_000_000_000
    rows = [
        (
            [
                ("transition", BOOL, {"data": False}),
                ("contact_mode", STRING, {"data": "three_point"}),
                alarms(jamming=0, overload=1),
            ],
            [1.0, 20.0, 3.0],
            1.0,
        ),
        ([alarms(jamming=2, overload=1)], [4.0, 2.0, -3.0], 1.0),
        (
            [
                ("transition", BOOL, {"data": True}),
                ("contact_mode", STRING, {"data": "two_point"}),
            ],
            [900.0, 0.0, 500.0],
            0.0,
        ),
        ([("transition", BOOL, {"data": False}), alarms(jamming=0)],),
        ([("transition", BOOL, {"data": True})],),
    ]
    for i, told in enumerate(rows):
        summary.take(columns(start + i * MS, *told))
    content = summary.content()
    times = [alarm.pop("time") for alarm in content["alarms"]]
    assert times == pytest.approx([0.0, 0.001, 0.003], abs=1e-12)
    assert content == {
        "outputs": 5,
        "start_time": 5.0,
        "duration": pytest.approx(0.004, abs=1e-12),
        "transition_time": pytest.approx(0.002, abs=1e-12),
        "max_normal": {"K": 4.0, "B1": 20.0, "B2": 3.0},
        "untold": dict.fromkeys(UNOBSERVABLE_SETTINGS),
        "accuracies": dict.fromkeys(ACCURACIES),
        "contact_mode": {"three_point": 0.4, "two_point": 0.6},
        "alarms": [
            {"name": "overload", "level": "WARN", "message": "overload 1"},
            {"name": "jamming", "level": "ERROR", "message": "jamming 2"},
            {"name": "jamming", "level": "OK", "message": "jamming 0"},
        ],
        "alarm_changes": 3,
    }


def test_a_clock_that_goes_back_takes_no_time():
    summary = Summary()
    rows = [(10_000, alarms(jamming=1)), (10_500, alarms(jamming=2))]
    rows += [(0, alarms(jamming=1)), (300, alarms(jamming=0))]
    rows += [(400, ("transition", BOOL, {"data": True})), (500, alarms(jamming=1))]
    for t_ms, message in rows:
        summary.take(columns(t_ms * MS, [message]))
    content = summary.content()
    # Half a second before the fall and half a second after it.
    assert content["start_time"] == 10.0
    assert content["duration"] == pytest.approx(1.0, abs=1e-12)
    assert content["transition_time"] == pytest.approx(0.9, abs=1e-12)
    times = [alarm["time"] for alarm in content["alarms"]]
    assert times == pytest.approx([0.0, 0.5, 0.5, 0.8, 1.0], abs=1e-12)


def test_alarms_that_flicker_are_counted_but_not_all_listed(monkeypatch):
    monkeypatch.setattr(module, "MOST_ALARM_CHANGES", 4)
    summary = Summary()
    for i in range(10):
        summary.take(columns(i * MS, [alarms(jamming=(i + 1) % 2)]))
    content = summary.content()
    assert (len(content["alarms"]), content["alarm_changes"]) == (4, 10)
    assert content["transition_time"] is None


@pytest.mark.nightly
@pytest.mark.parametrize("count", [20_000, 100_000])
def test_median_period_of_a_long_recording_needs_little_memory(count):
    statistics = StampStatistics(max_gap=0.1)
    t_ns = 0
    for i in range(count):
        # Every third period is 3 ms, the others 1 ms.
        t_ns += 3 * MS if i % 3 == 0 else MS
        statistics.add(t_ns, t_ns + 5 * MS)
    # Of 100 000 periods it would be ten times as much.
    assert len(pickle.dumps(statistics)) < 60_000
    summary = statistics.summary()
    assert summary["stamps"] == count
    assert summary["median_period"] == pytest.approx(1e-3, abs=1e-12)
    offset = summary["log_minus_stamp"]
    assert offset["least"] == offset["greatest"] == pytest.approx(5e-3, abs=1e-12)
    assert offset["mean"] == pytest.approx(5e-3, abs=1e-9)
    assert summary["trouble"] == []


def test_stamps_that_were_never_set_are_trouble():
    statistics = StampStatistics(max_gap=0.1)
    for i in range(3):
        statistics.add(0, 10**18 + i)
    trouble = statistics.summary()["trouble"]
    assert any(text.startswith("3 stamps are zero") for text in trouble)
    assert any(text.startswith("2 stamps repeat the one before") for text in trouble)
    assert any(text.startswith("log time and stamp differ by 1000000000.000") for text in trouble)


def test_no_stamps_at_all():
    assert StampStatistics(0.1).summary() == {"stamps": 0, "trouble": []}
