"""The first lines of a report: each outcome, load, alarm and drop in its words."""

import pytest

from peg_on_hole_ros.messages.passed_time import StampRun
from peg_on_hole_ros.report.tracks import PeakReaction
from peg_on_hole_ros.report.words import (
    alarm_lines,
    doubt,
    doubt_lines,
    dropped_line,
    headline,
    load_line,
    parts_of,
    risen,
    tries_at,
)

S = 1_000_000_000
LIMITS = (500.0, 200.0, 200.0)


def cycle(outcome, transition=None, start=0.0):
    return {"outcome": outcome, "transition_time": transition, "start_time": start}


@pytest.mark.parametrize(
    ("cycles", "expected"),
    [
        (
            [cycle("inserted", 1.5)],
            "The peg went in: transition at 3.500 s, 1.500 s after first contact.",
        ),
        (
            [cycle("aborted"), cycle("inserted", 1.5)],
            "The peg went in, in the second of 2 tries: transition at 3.500 s.",
        ),
        ([cycle("jammed")], "The peg did not go in: it jammed."),
        (
            [cycle("inserted", 1.0), cycle("aborted"), cycle("aborted")],
            "The peg did not go in: contact was given up, in the third of 3 tries.",
        ),
        ([cycle("unfinished")], "The recording ends before the peg was in."),
        ([], "No try to insert the peg: contact never came."),
    ],
)
def test_the_headline_is_the_last_tries_outcome(cycles, expected):
    assert headline(cycles, [2.0] * len(cycles), True).text == expected


def test_where_modes_are_off_the_headline_says_so():
    assert "monitor.modes is false" in headline([cycle("aborted")], [0.0], False).text


def test_the_worst_load_is_the_one_nearest_to_its_limit():
    # Not the greatest one.
    peaks = {"K": PeakReaction(210.0, 1.0, S), "B1": PeakReaction(150.0, 1.0, 2 * S)}
    found = load_line(peaks, LIMITS)
    assert found.text == "Worst load: 150 N at B1, 75% of its limit of 200 N."
    assert found.t == 2.0
    over = load_line({"B2": PeakReaction(250.0, 1.0, 0)}, LIMITS)
    assert over.text == "Worst load: 250 N at B2, over its limit of 200 N."
    assert "not determined anywhere" in load_line({}, LIMITS).text


def alarm(t, name, level):
    return {"time": t, "name": name, "level": level, "message": f"{name} {level} advice"}


def test_alarms_are_told_where_they_rise_at_their_highest_the_graver_first():
    alarms = [
        alarm(1.0, "overload", "WARN"),
        alarm(1.5, "jamming", "WARN"),
        alarm(2.0, "overload", "OK"),
        alarm(2.1, "jamming", "ERROR"),
        alarm(3.0, "jamming", "WARN"),
        alarm(3.5, "jamming", "OK"),
        alarm(4.0, "jamming", "ERROR"),
    ]
    assert risen(alarms) == [True, False, False, True, False, False, True]
    told = alarm_lines(alarms, len(alarms))
    assert [place.text for place in told] == [
        "jamming ERROR at 2.100 s and 1 more time: jamming ERROR advice.",
        "overload WARN at 1.000 s: overload WARN advice.",
    ]
    assert [place.t for place in told] == [2.1, 1.0]
    assert [place.text for place in alarm_lines([], 0)] == ["No alarm."]


def test_more_alarms_than_are_listed_are_counted():
    alarms = [alarm(float(k), f"alarm_{k}", "WARN") for k in range(11)]
    assert alarm_lines(alarms, 15)[-1].text == "And 7 more, in the table of alarms."


def test_without_doubts_it_says_that_nothing_speaks_against_the_settings():
    assert [place.text for place in doubt_lines([], None)] == [
        "The data do not contradict the settings."
    ]
    # The likeliest cause stands at the top of the page.
    told = doubt_lines(["check the tare", "two publish"], 0.125)
    assert [place.text for place in told[:-1]] == ["Two publish."]
    assert told[-1].text.startswith("In 12.5% of three-point contact")


def test_drops_have_their_reasons():
    messages = {"read": 5, "used": 5, "dropped": {}}
    assert dropped_line(messages).text == "Nothing was dropped: all 5 messages were used."


def test_tries_are_found_on_the_time_that_has_passed_where_the_clock_went_back():
    # Stamps of 10 to 20 s come twice.
    runs = [StampRun(10 * S, 20 * S, 0), StampRun(10 * S, 20 * S, 10 * S)]
    cycles = [
        cycle("aborted", start=12.0),
        cycle("aborted", start=19.0),
        cycle("aborted", start=11.0),
    ]
    assert tries_at(cycles[:2], runs) == pytest.approx([2.0, 9.0])
    # The third begins before the second: it is of the second run.
    assert tries_at(cycles, runs) == pytest.approx([2.0, 9.0, 11.0])


def test_what_the_data_contradict_comes_before_all_that_rests_on_it():
    assert doubt([], []) is None
    sign = (
        "wrench: the sign of the wrench is reversed: set wrench.acts_on: robot; with it the "
        "forces balance to 5.6 N instead of 21 N; used in place of what is stated "
        "(wrench.adopt_found)"
    )
    one = doubt([sign], [sign])
    assert one.headline == "Settings are contradicted: the sign of the wrench is reversed."
    assert one.lines[0] == "Set wrench.acts_on: robot."
    assert one.lines[1].startswith("With it the forces balance to 5.6 N instead of 21 N;")
    assert len(one.lines) == 2 and one.contradicted
    more = doubt([sign], [sign, "a", "b"])
    assert more.lines[-1] == "2 more below: correct the first one, then replay again."
    odd = doubt([], ["5 of 9 messages of joints were not used: the encoders stand still"])
    assert odd.headline == "These results are doubtful: 5 of 9 messages of joints were not used."
    assert odd.lines == ["The encoders stand still."] and not odd.contradicted


@pytest.mark.parametrize(
    ("line", "parts"),
    [
        ("a", ("a", "", "")),
        # A setting is a label, and the room in front of it is none.
        (
            "wrench: wrench.bias_force: a free peg reads [3, 0, 0] N: tare it",
            ("wrench.bias_force: a free peg reads [3, 0, 0] N", "Tare it", ""),
        ),
        (
            "joints: two publish on /joint_states: end one",
            ("two publish on /joint_states", "End one", ""),
        ),
        (
            "scene: the clearance is not the stated one: set hole_diameter - peg_diameter to 0.08 "
            "mm; with it the peg's path fits",
            (
                "the clearance is not the stated one",
                "Set hole_diameter - peg_diameter to 0.08 mm",
                "With it the peg's path fits",
            ),
        ),
    ],
)
def test_a_line_has_what_is_wrong_what_to_do_and_how_that_is_known(line, parts):
    assert tuple(parts_of(line)) == parts
