"""Records of tries: known messages in, known records out."""

import json
import pickle
import re

import numpy as np
import pytest

from cli_helpers import ROOT, SCHEMA
from json_schema import check
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.simulated_bag import write_bag
from peg_on_hole_ros.cli.replay import replay
from peg_on_hole_ros.config.options import NodeOptions
from peg_on_hole_ros.messages.beside_estimates import BOOL, DIAGNOSTICS, STRING
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.messages.tries import PAUSE_NS, PEG_CHANGE_NS, Tries, json_line
from peg_on_hole_ros.monitor.output_row import NOTHING
from peg_on_hole_ros.records import Rows
from simulated import truth

MS = 1_000_000
START = 7_000_000_000


def said(mode=None, flag=None, normal=np.nan, determined=1.0, contact=None, **levels):
    """Return what one stamp says: numbers of its row, and the messages beside."""
    messages = []
    if flag is not None:
        messages.append(("transition", BOOL, {"data": flag}))
    if mode is not None:
        messages.append(("contact_mode", STRING, {"data": mode}))
    if levels:
        status = [{"name": n, "level": v, "message": f"{n} {v}"} for n, v in levels.items()]
        messages.append(("alarms", DIAGNOSTICS, {"status": status}))
    known = 0.0 if normal is np.nan else determined
    return {"reactions_determined": known, "normal": normal, **(contact or {})}, messages


def take(cycles, t_ns, told):
    """Hand over one stamp; return the records of tries that end with it."""
    values, messages = told
    rows = NOTHING.copy()
    for name, value in values.items():
        rows[name] = value
    columns = OutputColumns(Rows(np.array([t_ns], np.int64), rows), [(0, messages)])
    return [record for _, records in cycles.take(columns) for record in records]


class Told:
    """The tries of messages by stamp [ms], up to now."""

    def __init__(self, rows):
        self._cycles, self.records = Tries(), []
        for t_ms, messages in rows:
            self.records += take(self._cycles, START + t_ms * MS, messages)

    def finish(self):
        self.records += self._cycles.finish()


told = Told


PAUSE_MS = PAUSE_NS // MS


def test_a_try_that_goes_in():
    came = {"contact_age": 0.02, "contact_latency": 0.02}
    rows = [
        (0, said("open", flag=False)),
        (50, said("three_point", normal=[1.0, 2.0, 3.0], contact=came)),
        # As beside the tilt at which it wedges: a number, and one that says nothing.
        (55, said(normal=[800.0, 600.0, 400.0], determined=0.0)),
        (60, said(normal=[5.0, 2.0, 1.0], overload=1)),
        (70, said(normal=[3.0, 8.0, 2.0], overload=2)),
        (80, said(flag=True, overload=0)),
        (90, said("two_point", normal=[0.0, 0.0, 0.0])),
        (200, said("open")),
        (200 + PAUSE_MS, said()),
    ]
    cycles = told(rows)
    (record,) = cycles.records
    cycles.finish()
    assert len(cycles.records) == 1
    alarms = record.pop("alarms")
    assert [(alarm["name"], alarm["level"]) for alarm in alarms] == [
        ("overload", "WARN"),
        ("overload", "ERROR"),
    ]
    assert alarms[0]["time"] == pytest.approx(0.03, abs=1e-9)
    assert record == {
        "start_time": pytest.approx(7.03, abs=1e-9),
        "contact_latency": 0.02,
        "search_time": 0.0,
        "duration": pytest.approx(0.06, abs=1e-9),
        "outcome": "inserted",
        "transition_time": pytest.approx(0.05, abs=1e-9),
        "peak_normal": {"K": 5.0, "B1": 8.0, "B2": 3.0},
        "mean_normal": {"K": 3.0, "B1": 4.0, "B2": 2.0},
        "alarm_count": 2,
    }


def test_a_search_beside_the_hole_is_no_try_and_its_time_is_that_of_the_next():
    came = {"contact_age": 0.3, "contact_latency": 0.02}
    rows = [
        (0, said("open", flag=False)),
        # For a moment the plate is taken for the rim.
        (20, said("three_point", normal=[1.0, 2.0, 3.0])),
        (100, said("elsewhere")),
        (150, said()),
        (250, said("open")),
        (300, said("elsewhere")),
        (400, said("three_point", contact=came)),
        (450, said("two_point", flag=True)),
        (500, said("open")),
        (500 + PAUSE_MS, said()),
        (900, said("three_point")),
        (1000, said("open")),
        (1000 + PAUSE_MS, said()),
    ]
    first, second = told(rows).records
    assert (first["search_time"], first["outcome"]) == (0.25, "inserted")
    # It begins where the search ends, however long the peg has touched.
    assert first["start_time"] == pytest.approx(7.4, abs=1e-9)
    assert first["peak_normal"]["K"] is None
    assert second["search_time"] == 0.0


def test_numbers_have_no_more_digits_than_they_mean():
    """Microseconds and millinewtons, whatever sums and stamps come to."""
    tries = Tries()
    came = {"contact_age": 1.0 / 3.0, "contact_latency": 1.0 / 3.0}
    take(tries, START, said("three_point", False, [100.0 / 3.0, 1e-4 / 3.0, 2.0], contact=came))
    take(tries, START + 333_333_333, said(normal=[1.0, 2.0, 2.0], overload=1))
    take(tries, START + 666_666_667, said("two_point", True))
    (record,) = tries.finish()
    assert re.findall(r"\d+\.\d{7,}|e-\d+", json_line(record)) == []
    assert (record["start_time"], record["contact_latency"]) == (6.666667, 0.333333)
    assert (record["duration"], record["transition_time"]) == (1.0, 1.0)
    assert record["peak_normal"] == {"K": 33.333, "B1": 2.0, "B2": 2.0}
    assert record["mean_normal"] == {"K": 17.167, "B1": 1.0, "B2": 2.0}
    assert record["alarms"][0]["time"] == 0.666667


def test_short_losses_of_contact_do_not_end_a_try_and_long_ones_do():
    rows = [(0, said("three_point", flag=False)), (10, said("open"))]
    rows += [(PAUSE_MS, said("three_point")), (PAUSE_MS + 10, said("open"))]
    assert told(rows).records == []
    rows += [(2 * PAUSE_MS + 10, said()), (2 * PAUSE_MS + 20, said("three_point"))]
    cycles = told(rows)
    assert [record["outcome"] for record in cycles.records] == ["aborted"]
    cycles.finish()
    assert [record["outcome"] for record in cycles.records] == ["aborted", "unfinished"]


def test_a_clock_that_goes_back_ends_a_try():
    rows = [(0, said("three_point", flag=False, normal=[1.0, 1.0, 1.0]))]
    rows += [(400, said()), (500, said())]
    # As after a restart of the filter; 490 ms below the last stamp, then again.
    rows += [(10, said("unknown")), (20, said("three_point", normal=[2.0, 2.0, 2.0]))]
    rows += [(30, said(flag=True)), (15, said(flag=False)), (40, said("open"))]
    cycles = told(rows)
    cycles.finish()
    times = [(record["start_time"], record["duration"]) for record in cycles.records]
    assert times == [
        (pytest.approx(7.0, abs=1e-9), pytest.approx(0.5, abs=1e-9)),
        (pytest.approx(7.02, abs=1e-9), pytest.approx(0.01, abs=1e-9)),
        (pytest.approx(7.015, abs=1e-9), pytest.approx(0.0, abs=1e-9)),
    ]
    outcomes = [record["outcome"] for record in cycles.records]
    assert outcomes == ["unfinished", "inserted", "unfinished"]
    assert [record["peak_normal"]["K"] for record in cycles.records] == [1.0, 2.0, None]
    # The one that ends is handed out where the fall is seen.
    cycles = Tries()
    assert take(cycles, START, said("three_point")) == []
    (record,) = take(cycles, START - MS, said())
    assert record["outcome"] == "unfinished"


SILENCE_MS = PEG_CHANGE_NS // MS


def inserted():
    rows = [(0, said("three_point", flag=False)), (10, said(flag=True)), (20, said("two_point"))]
    return [*rows, (30, said())]


@pytest.mark.parametrize(
    "after",
    [
        # The peg hangs free, or nobody knows, or the mode is carried on for a moment.
        [said("open", flag=False), said()],
        [said("unknown", flag=False), said("open")],
        [said(), said("open", flag=False)],
    ],
)
def test_a_try_ends_where_the_wrench_fell_silent(after):
    later = 3_600_000
    rows = inserted()
    tries = told([*rows, (later, after[0])])
    # One stamp alone may be wrong.
    assert tries.records == []
    tries = told([*rows, (later, after[0]), (later + 1, after[1])])
    (record,) = tries.records
    assert (record["outcome"], record["duration"]) == ("inserted", pytest.approx(0.03, abs=1e-9))
    assert record["transition_time"] == pytest.approx(0.01, abs=1e-9)
    # The next begins with the next contact, not with what was carried over the silence.
    contact = (later + 500, said("three_point", flag=False))
    tries = told([*rows, (later, after[0]), (later + 1, after[1]), contact, (later + 600, said())])
    tries.finish()
    first, second = tries.records
    assert second["start_time"] == pytest.approx(START * 1e-9 + contact[0] * 1e-3, abs=1e-6)
    assert (second["outcome"], second["duration"]) == ("unfinished", pytest.approx(0.1, abs=1e-6))


def test_a_try_ends_where_the_wrench_fell_silent_though_only_one_more_came():
    tries = told([*inserted(), (3_600_000, said("open", flag=False))])
    tries.finish()
    (record,) = tries.records
    assert (record["outcome"], record["duration"]) == ("inserted", pytest.approx(0.03, abs=1e-9))


def test_a_single_stamp_ahead_and_a_short_silence_end_no_try():
    tries = told([*inserted(), (3_600_000, said()), (31, said()), (40, said())])
    tries.finish()
    (record,) = tries.records
    assert (record["outcome"], record["duration"]) == ("inserted", pytest.approx(0.04, abs=1e-9))
    tries = told([*inserted(), (30 + SILENCE_MS, said()), (31 + SILENCE_MS, said())])
    tries.finish()
    (record,) = tries.records
    assert record["duration"] == pytest.approx((31 + SILENCE_MS) * 1e-3, abs=1e-9)


def test_outcomes_of_tries_that_do_not_go_in():
    jammed = told([(0, said("three_point", flag=False)), (10, said("unknown", jamming=2))])
    jammed.finish()
    assert jammed.records[0]["outcome"] == "jammed"
    # In and out again: the flag has fallen.
    back = told([(0, said("three_point")), (10, said(flag=True)), (20, said(flag=False))])
    back.finish()
    (record,) = back.records
    assert record["outcome"] == "unfinished"
    assert record["transition_time"] == pytest.approx(0.01, abs=1e-9)
    # What touches from the start on in no known way is no try yet.
    no_try = told([(0, said("unknown"))])
    no_try.finish()
    assert no_try.records == []


def test_the_node_keeps_nothing_of_a_try_that_has_ended():
    cycles, sizes, ended = Tries(), [], 0
    for k in range(3):
        start = START + k * 4 * PAUSE_NS
        take(cycles, start, said("three_point", flag=False, normal=[1.0, 2.0, 3.0], overload=2))
        take(cycles, start + MS, said("open", overload=0))
        ended += len(take(cycles, start + 2 * PAUSE_NS, said()))
        # Whatever it is kept in: a pickle holds all that the object does.
        sizes.append(len(pickle.dumps(cycles)))
    assert ended == 3
    assert sizes[0] == sizes[1] == sizes[2]


def test_a_try_whose_reactions_were_never_determined_has_none():
    rows = [(0, said("three_point", normal=[9.0] * 3, determined=0.0)), (10, said())]
    cycles = told(rows)
    cycles.finish()
    (record,) = cycles.records
    nothing = dict.fromkeys(("K", "B1", "B2"))
    assert record["peak_normal"] == record["mean_normal"] == nothing
    assert json.loads(json_line(record)) == record
    check(record, SCHEMA["properties"]["cycles"]["items"], SCHEMA)


def test_a_jammed_peg_has_no_peak_beyond_what_it_can_have_been():
    """Beside the singular set a reaction of 868 N was said, with a deviation of 695 N."""
    scene = truth("closing_without_slip")
    content, *_ = replay(
        Bag(ROOT / "bags/closing_without_slip.mcap"), scene.plan.configuration, NodeOptions()
    )
    three = scene.mode == "three_point"
    peak = scene.normal[three].max()
    (record,) = content["cycles"]
    assert record["outcome"] == "jammed"
    for figures in (record["peak_normal"], content["max_normal"]):
        assert 0.8 * peak < max(figures.values()) < 1.05 * peak
    assert 0.0 < max(record["mean_normal"].values()) < peak


@pytest.mark.nightly
def test_the_working_cycle_has_two_tries(tmp_path):
    scene = truth("working_cycle")
    path = tmp_path / "cycle.mcap"
    write_bag(path, scene)
    content, *_ = replay(Bag(path), scene.plan.configuration, NodeOptions())
    first, second = content["cycles"]
    assert (first["outcome"], second["outcome"]) == ("aborted", "inserted")
    down = [t_ns * 1e-9 for t_ns, text in scene.events if text.startswith("touch-down")]
    begin = content["start_time"]
    # Touch-down is gentle: the threshold of 1 N is reached 45 ms later.
    for record, t in zip((first, second), down):
        assert record["start_time"] - begin == pytest.approx(t + 0.045, abs=0.015)
    crossed = next(t for t, text in scene.events if text.startswith("transition")) * 1e-9
    at = second["start_time"] - begin + second["transition_time"]
    assert at == pytest.approx(crossed, abs=0.005)
    three = scene.mode == "three_point"
    peak = scene.normal[three & (scene.t_ns > 8_000_000_000)].max(axis=0)
    assert second["peak_normal"]["K"] == pytest.approx(peak[0], rel=0.05)
    assert json.loads(json_line(second)) == second


def stated_depth(rows):
    """Return the outcomes of tries where a depth is stated."""
    tries, found = Tries(depth_stated=True), []
    for t_ms, messages in rows:
        found += take(tries, START + t_ms * MS, messages)
    return [record["outcome"] for record in (*found, *tries.finish())]


def test_where_a_depth_is_stated_it_decides_what_went_in():
    begin = [(0, said("three_point", flag=False)), (10, said("two_point", flag=True))]
    let_go = [(60, said("unknown")), (70, said("open")), (70 + PAUSE_MS, said())]
    deep = (50, said("inserted"))
    assert stated_depth([*begin, deep, *let_go]) == ["inserted"]
    assert stated_depth([*begin, deep]) == ["inserted"]
    # Through gamma0 alone, or pulled back: it is not in.
    assert stated_depth([*begin, *let_go]) == ["aborted"]
    assert stated_depth([*begin, deep, (55, said("two_point")), *let_go]) == ["aborted"]
    assert stated_depth([*begin, (50, said(jamming=2)), *let_go]) == ["jammed"]
    # A peg that comes upright through the air is inserted without any transition.
    assert stated_depth([(0, said("open", flag=False)), deep, (60, said())]) == ["inserted"]
