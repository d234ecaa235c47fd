"""What the node logs of counts: what a user has to know, and not every second."""

from collections import Counter

from peg_on_hole_ros.ros.diagnostics import Diagnostics
from peg_on_hole_ros.ros.log_lines import CountLines


def logged(seconds, counted):
    """Return the lines of each second, of what `counted` says of it, with 1500 messages each."""
    lines = CountLines()
    return [lines.take(counted(second), 1500, 1.0) for second in range(seconds)], lines


def test_a_count_that_goes_on_is_logged_once():
    found, lines = logged(60, lambda second: {"wrench_dropped_late": 3})
    assert found[0] == ["wrench dropped late: 3 times"] and not any(found[1:])
    # Nothing is lost: the end has the rest.
    assert lines.rest({"wrench_dropped_late": 1}) == ["wrench dropped late: 178 times"]


def test_it_is_logged_again_where_it_has_grown_tenfold_at_most_every_ten_seconds():
    found, _ = logged(40, lambda second: {"joints_dropped_late": 2 if second < 15 else 40})
    at = [second for second, lines in enumerate(found) if lines]
    assert at == [0, 16] or at[1] - at[0] >= 10 and len(at) == 2
    assert "joints dropped late: " in found[at[1]][0]


def test_another_count_waits_until_ten_seconds_are_over():
    def counted(second):
        return {"gap": 1} if second == 0 else {"motion_lost": 1} if second == 3 else {}

    found, _ = logged(20, counted)
    at = {second: lines for second, lines in enumerate(found) if lines}
    assert at == {0: ["gap: 1 time"], 10: ["motion lost: 1 time"]}


def test_single_outliers_and_what_a_cause_explains_are_left_to_the_diagnostics():
    def counted(second):
        return {"joints_gated": 1, "wrench_spike": 2, "wrench_noisy": 900, "contact_doubted": 1000}

    found, lines = logged(60, counted)
    assert not any(found)
    assert lines.rest({}) == ["joints gated: 60 times", "wrench spike: 120 times"]
    # Many of them are no outliers.
    found, _ = logged(3, lambda second: {"joints_gated": 100})
    assert found[0] == ["joints gated: 100 times"]


def test_a_load_is_logged_once_as_well():
    diagnostics, total, found = Diagnostics(), Counter(), []
    for _ in range(15):
        for source in ("wrench", "joints"):
            diagnostics.received(source, 85_000_000)
        total["wrench_dropped_overload"] += 40
        found.append(diagnostics.report(0, 10**9, total, {})[1])
    # What is likely to be wrong comes before the counts that show it.
    cause, count = found[0]
    assert cause.startswith("other programs take the processor from the node: messages were lost")
    assert cause.endswith("(the node was busy for 17 % of the time)")
    assert count == "wrench dropped overload: 40 times"
    assert not any(found[1:])
