"""Comparison with truth, thinning and picture: against numbers worked out by hand."""

import struct
from math import pi

import numpy as np
import pytest

from estimates import SCENE, columns, estimate
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.score import Score, flag_lines, score_lines, score_table
from peg_on_hole_ros.bags.truth import RecordedTruth, read_truth
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.messages.beside_estimates import (
    JOINT_STATE,
    STRING,
    OutputStream,
    joint_state,
)
from peg_on_hole_ros.plots import series as series_module
from peg_on_hole_ros.plots.replay import figure, png
from peg_on_hole_ros.plots.series import Series
from small_bags import write_bag

S = 1_000_000_000
ONES = np.ones(6)


def truth(modes=((0, "three_point"),), seconds=10):
    """All six values are the time in seconds; the angles therefore run through turns."""
    t_ns = np.arange(seconds + 1) * S
    values = np.repeat(t_ns[:, None] * 1e-9, 6, axis=1)
    values[:, :3] = (values[:, :3] + pi) % (2 * pi) - pi
    return RecordedTruth(t_ns, values, *zip(*modes))


def test_truth_is_linear_between_stamps_and_unwrapped():
    assert truth().at(4 * S + S // 4) == pytest.approx(4.25 * ONES, rel=1e-12)
    assert truth().at(4 * S) == pytest.approx(4 * ONES, rel=1e-12)
    assert truth().at(0) == pytest.approx(0 * ONES)
    assert truth().at(-1) is None
    assert truth().at(10 * S + 1) is None


def test_in_the_hole_the_lower_edge_has_one_contact_under_two_names():
    values = [[0.1, 0.0, 0.0, 5.0, 6.0, 8.0], [0.1, 0.0, 0.0, 5.0, 0.0, 8.0]]
    truth = RecordedTruth([0, 10], values, [0, 5], ["three_point", "two_point"])
    assert truth.values[:, 3:].tolist() == [[5.0, 6.0, 8.0], [5.0, 4.0, 4.0]]


def test_error_spread_and_coverage():
    score = Score(truth())
    # Off by 1, 2 and 3 standard deviations of 0.5: the last lies outside 95 %.
    for k, error in enumerate((0.5, -1.0, 0.9, 1.5)):
        stddev = np.full(6, 0.5)
        score.row(k * S, k + error * ONES, stddev, "three_point", False)
    rmse = np.sqrt((0.25 + 1.0 + 0.81 + 2.25) / 4)
    assert list(score.rmse().values()) == pytest.approx([rmse] * 6, rel=1e-12)
    assert list(score.stddev().values()) == [0.5] * 6
    # 1.0 is two standard deviations: outside of 1.96
    assert list(score.coverage95().values()) == [0.5] * 6
    assert list(score.mean().values()) == [1.5] * 6


def test_angles_are_compared_modulo_turns_and_reactions_are_not():
    score = Score(truth())
    values = np.full(6, 7.0 - 2 * pi) + 0.1
    score.row(7 * S, values, ONES, "three_point", False)
    rmse = score.rmse()
    assert rmse["psi"] == pytest.approx(0.1, rel=1e-9)
    assert rmse["K"] == pytest.approx(2 * pi - 0.1, rel=1e-9)


def test_reactions_count_only_where_truth_and_estimate_have_three_points():
    score = Score(truth([(0, "open"), (2 * S, "three_point"), (5 * S, "two_point")]))
    for k, mode in enumerate(
        ("open", "three_point", "three_point", "unknown", "three_point", "three_point")
    ):
        score.row(k * S, k * ONES, ONES, mode, False)
    # stamps 2 and 4 only
    assert score.count.tolist() == [6, 6, 6, 2, 2, 2]


@pytest.mark.parametrize("stated", [True, False])
def test_reactions_that_are_not_determined_are_counted_apart(stated):
    score = Score(truth())
    for k in range(6):
        determined = k % 3 == 0
        values = k + np.array([0, 0, 0, 1, 1, 1]) * (0.5 if determined else 9.0)
        if not (determined or stated):
            values[3:] = np.nan
        score.row(k * S, values, ONES, "three_point", False, determined)
    rows = {row[0]: row[2:] for row in score_table(score)}
    assert rows["N_K"] == ("0.5", "1", "100.0%", "2")
    apart = ("9", "1", "0.0%", "4") if stated else ("-", "-", "-", "4")
    assert rows["N_K, not determined"] == rows["N_B2, not determined"] == apart
    assert rows["gamma"][3] == "6"
    said = " ".join(score_lines(score))
    assert "95 % is right" in said and "not determined" in said


def test_where_all_are_determined_nothing_is_said_of_others():
    score = Score(truth())
    score.row(S, ONES, ONES, "three_point", False)
    assert len(score_table(score)) == 7
    assert "not determined" not in " ".join(score_lines(score))


def test_without_three_point_contact_there_is_no_figure_for_reactions():
    score = Score(truth([(0, "open")]))
    score.row(S, ONES, ONES, "open", False)
    assert score.rmse()["K"] is None and score.coverage95()["B2"] is None
    assert score_table(score)[4] == ("N_K", "N", "-", "-", "-", "0")


def test_flag_against_the_true_transition():
    score = Score(truth([(0, "three_point"), (5 * S, "two_point")]))
    for k in range(10):
        score.row(k * S, k * ONES, ONES, "three_point", k >= 6)
    assert score.flag_delays() == pytest.approx([1.0])
    assert score.flag_agreement() == pytest.approx(0.9)
    assert flag_lines(score) == [
        "transition flag right in 90.00% of three- and two-point contact",
        "true transition at 5.000 s: flagged 1000 ms after it",
    ]


def test_missed_and_false_flags_are_said():
    score = Score(truth([(0, "three_point"), (5 * S, "two_point")]))
    for k in range(10):
        score.row(k * S, k * ONES, ONES, "three_point", False)
    assert flag_lines(score)[1] == "true transition at 5.000 s: not flagged"
    score = Score(truth())
    for k in range(10):
        score.row(k * S, k * ONES, ONES, "three_point", k == 4)
    assert flag_lines(score)[1:] == [
        "the flag rose 1 more time",
        "there is no transition in the truth",
    ]


def test_a_flag_that_never_had_to_rise_and_never_did_is_not_called_right():
    score = Score(truth())
    for k in range(10):
        score.row(k * S, k * ONES, ONES, "three_point", False)
    assert flag_lines(score) == ["there is no transition in the truth"]


def test_score_takes_the_outputs_of_a_replay():
    outputs = estimate(t_ns=S, psi=0.4)
    values = [*outputs.state[:3], *outputs.normal]
    score = Score(RecordedTruth([0, 2 * S], [values, values], [0], ["three_point"]))
    score.take(columns(OutputStream(SCENE), outputs))
    assert list(score.rmse().values()) == pytest.approx([0.0] * 6, abs=1e-12)
    assert score.stddev()["gamma"] == pytest.approx(1e-5, rel=1e-12)
    assert score.stddev()["B1"] == pytest.approx(0.3, rel=1e-12)


def truth_bag(path, topics=("state", "contacts", "contact_mode")):
    with BagWriter(path) as bag:
        for k in range(3):
            angles, normals = (0.1 * k, 3.0 + k, 0.0), (1.0 * k, 2.0 * k, 3.0 * k)
            state = joint_state(k * S, ("psi", "gamma", "phi"), angles)
            contacts = joint_state(k * S, ("K", "B1", "B2"), effort=normals)
            mode = {"data": "open" if k < 2 else "three_point"}
            for suffix, ros_type, message in (
                ("state", JOINT_STATE, state),
                ("contacts", JOINT_STATE, contacts),
                ("contact_mode", STRING, mode),
            ):
                if suffix in topics:
                    bag.write(f"/truth/{suffix}", ros_type, message, k * S)
    return Bag(path)


def test_truth_is_read_by_name(tmp_path):
    found = read_truth(truth_bag(tmp_path / "truth.mcap"))
    assert found.values[1] == pytest.approx([4.0, 0.1, 0.0, 1.0, 2.0, 3.0])
    assert [found.mode_at(k * S) for k in range(-1, 3)] == ["", "open", "open", "three_point"]


@pytest.mark.parametrize("first", [True, False])
@pytest.mark.parametrize(("began", "pace"), [(0, 1), (1_700_000_000 * S, 3)])
def test_a_mode_has_the_stamp_of_its_state(tmp_path, first, began, pace):
    # As written, its stamps the log times; and as played at a third of its pace and recorded anew,
    # where messages of one stamp come shortly after one another.
    way = S // 1000 if began else 0
    modes = {0: "open", 2: "three_point", 5: "two_point", 6: "two_point"}
    with BagWriter(tmp_path / "truth.mcap") as bag:
        for k in range(8):
            state = joint_state(k * S, ("gamma", "psi", "phi"), (1.0, 1.0, 1.0))
            contacts = joint_state(k * S, ("K", "B1", "B2"), effort=(1.0, 1.0, 1.0))
            messages = [("state", JOINT_STATE, state), ("contacts", JOINT_STATE, contacts)]
            if k in modes:
                mode = ("contact_mode", STRING, {"data": modes[k]})
                messages.insert(0 if first else 2, mode)
            for i, (suffix, ros_type, message) in enumerate(messages):
                bag.write(f"/truth/{suffix}", ros_type, message, began + pace * k * S + i * way)
    found = read_truth(Bag(tmp_path / "truth.mcap"))
    assert found.mode_ns.tolist() == [0, 2 * S, 5 * S]
    assert found.modes == ["open", "three_point", "two_point"]


def test_where_truth_is_silent_on_reactions_only_angles_count(tmp_path):
    path = tmp_path / "silent.mcap"
    with BagWriter(path) as bag:
        bag.write("/truth/contact_mode", STRING, {"data": "three_point"}, 0)
        for k in range(4):
            state = joint_state(k * S, ("gamma", "psi", "phi"), (1.0, 1.0, 1.0))
            bag.write("/truth/state", JOINT_STATE, state, k * S)
            if k != 2:
                contacts = joint_state(k * S, ("K", "B1", "B2"), effort=(1.0, 1.0, 1.0))
                bag.write("/truth/contacts", JOINT_STATE, contacts, k * S)
    score = Score(read_truth(Bag(path)))
    for k in range(0, 4 * S, S // 2):
        score.row(k, 1.5 * ONES, ONES, "three_point", False)
    # Stamps 0 to 3 s in halves; 1.5, 2 and 2.5 s have no reactions, beyond 3 s there is nothing.
    assert score.count.tolist() == [7, 7, 7, 4, 4, 4]
    assert list(score.rmse().values()) == [0.5] * 6


def test_reading_a_long_truth_tells_how_far_it_is(tmp_path):
    path, shares = tmp_path / "long.mcap", []
    with BagWriter(path) as bag:
        bag.write("/truth/contact_mode", STRING, {"data": "three_point"}, 0)
        for k in range(600):
            state = joint_state(k, ("gamma", "psi", "phi"), (1.0, 1.0, 1.0))
            contacts = joint_state(k, ("K", "B1", "B2"), effort=(1.0, 1.0, 1.0))
            bag.write("/truth/state", JOINT_STATE, state, k)
            bag.write("/truth/contacts", JOINT_STATE, contacts, k)
    read_truth(Bag(path), shares.append)
    assert shares == pytest.approx([256 * i / 1201 for i in range(5)])


def test_bag_without_truth_has_none(tmp_path):
    assert read_truth(Bag(write_bag(tmp_path / "plain.mcap"))) is None


def test_bag_with_half_a_truth_is_an_error(tmp_path):
    bag = truth_bag(tmp_path / "half.mcap", ("state",))
    with pytest.raises(BagError, match="has no messages on /truth/contacts"):
        read_truth(bag)


def test_series_is_thinned_evenly(monkeypatch):
    monkeypatch.setattr(series_module, "MOST_ROWS", 100)
    series = Series()
    for k in range(1000):
        series.row(k, np.full(6, k), ONES, {"jamming_risk": 0.5})
    t_ns, values, _, monitor = series.arrays()
    assert 50 <= len(t_ns) <= 101
    assert set(np.diff(t_ns)) == {16}
    assert (values[:, 0] == t_ns).all()
    assert np.isnan(monitor[:, 0]).all() and (monitor[:, 1] == 0.5).all()
    assert series.passed_ns == 999


def test_picture_has_every_part():
    series, made = Series(), estimate()
    values = [*made.state[:3], *made.normal]
    for k in range(20):
        mode, t_ns = "three_point" if k < 10 else "two_point", k * S // 10
        series.declared(t_ns, mode, k >= 10)
        series.row(t_ns, values, 0.1 * ONES, made.monitor)
    assert series.modes == [(0, "three_point"), (S, "two_point")]
    assert series.flags == [(0, False), (S, True)]
    fig = figure(series, "a title", SCENE.gamma0, truth([(0, "three_point"), (S, "two_point")]))
    labels = [axis.get_ylabel().split("\n")[0] for axis in fig.axes]
    assert labels == [
        "tilt [rad]",
        "turns [rad]",
        "normal reactions [N]",
        "contact mode",
        "probability, risk",
    ]
    line = fig.axes[2].lines[0]
    assert line.get_label() == "N_K" and (line.get_ydata() == 20.0).all()
    bars = [bar for collection in fig.axes[3].collections for bar in collection.get_paths()]
    assert len(bars) == 4
    data = png(fig)
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", data[16:24]) == (1210, 1320)


def test_reactions_that_are_not_determined_have_bounds_and_no_line():
    series = Series()
    rows = [(1.0, 2.0), (0.0, 2.0), (0.0, 0.0), (1.0, 0.0)]
    for k, (determined, spread) in enumerate(rows):
        series.row(
            k * S, np.full(6, 5.0), np.full(6, spread), {"reactions_determined": determined}
        )
    # At the second, forces say little; at the third, no contact carries anything.
    shown = figure(series, "a title", SCENE.gamma0).axes[2]
    for line in shown.lines:
        assert np.isnan(line.get_ydata()).tolist() == [False, True, False, False]
    assert len(shown.collections) == 3


def test_time_goes_on_where_the_clock_goes_back():
    series = Series()
    stamps = [*range(2, 8), *range(2, 6)]
    for t in stamps:
        angles = (np.full(3, t) + pi) % (2 * pi) - pi
        mode = "two_point" if t >= 5 else "three_point"
        series.declared(t * S, mode, mode == "two_point")
        series.row(t * S, np.array([*angles, t, t, t]), ONES, {})
    assert series.modes == [
        (0, "three_point"), (3 * S, "two_point"), (5 * S, "three_point"), (8 * S, "two_point"),
    ]  # fmt: skip
    known = truth([(0, "open"), (2 * S, "three_point"), (5 * S, "two_point")])
    fig = figure(series, "a title", SCENE.gamma0, known)
    assert fig.axes[4].get_xlim() == (0.0, 8.0)
    passed = [0, 1, 2, 3, 4, 5, 5, 6, 7, 8]
    for axis, i in ((fig.axes[1], 0), (fig.axes[1], 1), (fig.axes[2], 0)):
        # The truth lies below the lines of the estimate.
        below = [line for line in axis.lines if line.get_zorder() < axis.lines[0].get_zorder()]
        (estimated, *_), count = axis.lines[i:], len(below) // 2
        ways = below[i], below[i + count]
        assert estimated.get_xdata().tolist() == passed
        assert np.concatenate([way.get_xdata() for way in ways]).tolist() == passed
        expected = np.concatenate([way.get_ydata() for way in ways])
        assert estimated.get_ydata() == pytest.approx(expected, abs=1e-9)
    bars = [c.get_paths()[0].get_extents() for c in fig.axes[3].collections]
    assert [(bar.x0, bar.x1) for bar in bars] == 2 * [(0, 3), (3, 5), (5, 8), (8, 8)]


def test_an_estimate_of_a_stamp_that_was_wrong_is_let_go():
    series = Series()
    # The fourth was 900 s ahead, and was undone by the wrench after it.
    for t, mode in ((1, "open"), (2, "open"), (3, "open"), (903, "unknown"), (4, "three_point")):
        series.declared(t * S, mode, mode == "unknown")
        series.row(t * S, np.full(6, t), ONES, {})
    assert (series.arrays()[0] / S).tolist() == [0, 1, 2, 3]
    assert series.arrays()[1][:, 0].tolist() == [1, 2, 3, 4]
    assert series.passed_ns == 3 * S
    assert series.modes == [(0, "open"), (3 * S, "unknown"), (3 * S, "three_point")]
    assert series.flags == [(0, False), (3 * S, True), (3 * S, False)]
    assert [(run.first_ns, run.last_ns) for run in series.runs] == [(S, 4 * S)]
