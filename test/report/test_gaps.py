"""Where nothing came, no line is drawn and no mode holds."""

import json
from pathlib import Path

import numpy as np
import pytest
from test_report_page import replay_of, unpacked

from estimates import SCENE, changed, columns, estimate
from peg_on_hole_ros.messages.beside_estimates import OutputStream
from peg_on_hole_ros.plots.gaps import changes_with_gaps, with_gaps
from peg_on_hole_ros.report.replay_page import replay_page
from peg_on_hole_ros.report.tracks import Tracks
from small_bags import MS

S = 1_000_000_000


def test_a_silence_has_a_row_without_numbers():
    t = np.array([0.0, 0.01, 0.02, 2.0, 2.01])
    found = with_gaps({"t": t, "v": np.arange(5.0)}, 0.1)
    assert found["t"].tolist() == [0.0, 0.01, 0.02, 1.01, 2.0, 2.01]
    assert np.isnan(found["v"][3]) and np.isfinite(found["v"]).sum() == 5


def test_a_slow_topic_or_a_thinned_table_has_none():
    t = np.arange(10.0)
    assert with_gaps({"t": t}, 0.1)["t"] is t
    assert len(with_gaps({"t": np.empty(0)}, 0.1)["t"]) == 0


def test_a_mode_holds_in_no_silence():
    t = np.array([0.0, 0.01, 0.02, 2.0, 2.01])
    changes = [(0, "open"), (2 * S, "three_point")]
    assert changes_with_gaps(changes, t, 0.1) == [
        (0, "open"), (20 * MS, ""), (2 * S, "three_point"),
    ]  # fmt: skip
    # It goes on as before.
    assert changes_with_gaps(changes[:1], t, 0.1)[1:] == [(20 * MS, ""), (2 * S, "open")]


def drawn(*moments):
    tracks, stream = Tracks(), OutputStream(SCENE)
    for made in moments:
        tracks.take(columns(stream, made))
    return json.loads(unpacked(replay_page(replay_of(Path("a.mcap"), tracks)))), tracks


def test_the_report_of_a_bag_with_a_pause_has_it():
    first = [estimate(t_ns=k * MS) for k in range(20)]
    model, _ = drawn(*first, *(estimate(t_ns=3 * S + k * MS) for k in range(20)))
    table = model["tables"]["estimate"]
    assert table["gamma"].index(None) == 20 and table["K"][20] is None
    assert [mode for _, mode in model["modes"][0]["changes"]] == ["three_point", "", "three_point"]


def test_a_turn_that_may_be_any_is_not_drawn_as_a_number():
    """Near upright psi and phi are known in their sum alone."""

    def stated(k, stddev):
        made = estimate(t_ns=k * MS)
        spread = made.state_stddev.copy()
        spread[1:3] = stddev
        return changed(made, state_stddev=spread)

    model, tracks = drawn(*(stated(k, 50.0 if k > 10 else 0.01) for k in range(20)))
    table = model["tables"]["estimate"]
    for name in ("psi", "phi"):
        assert table[name][:11] == pytest.approx([table[name][0]] * 11)
        assert table[name][11:] == [None] * 9 == table[f"{name}_high"][11:]
        assert model["moving"][f"{name}_stddev"][15] is None
    assert None not in table["gamma"]
    assert np.isfinite(tracks.moments()["psi"]).all()
