"""Thinning: no peak is lost, whatever the data, and memory does not grow with the recording."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from peg_on_hole_ros.report.thinning import ThinnedRows, most_loaded, peaks, thinned

# Such as an array of float32 holds exactly.
NUMBERS = st.one_of(st.integers(-1000, 1000).map(float), st.just(float("nan")))


@given(
    arrays.arrays(float, st.tuples(st.integers(0, 300), st.integers(1, 3)), elements=NUMBERS),
    st.integers(4, 50),
)
def test_every_column_keeps_its_greatest_and_its_least(values, most):
    t = 1000 * np.arange(len(values))
    shown_t, shown = thinned(t, values, most)
    assert len(shown_t) == len(shown) <= max(most, 4)
    assert (np.diff(shown_t) > 0).all() and set(shown_t) <= set(t)
    for before, after in zip(values.T, shown.T):
        assert np.isnan(before).all() == np.isnan(after).all()
        if not np.isnan(before).all():
            assert np.nanmax(after) == np.nanmax(before)
            assert np.nanmin(after) == np.nanmin(before)


@given(arrays.arrays(float, st.integers(8, 400), elements=st.floats(-1e3, 1e3)))
def test_a_peak_stays_where_it_was(values):
    t = np.arange(len(values))
    shown_t, shown = thinned(t, values[:, None], 40)
    spacing = int(np.diff(shown_t).max())
    at = shown_t[shown[:, 0].argmax()]
    nearest = np.abs(np.flatnonzero(values == values.max()) - at).min()
    assert nearest <= 2 * spacing


def test_a_pair_keeps_its_order():
    rising, falling = (
        np.array([[0.0], [1.0], [5.0], [2.0]]),
        np.array([[2.0], [5.0], [1.0], [0.0]]),
    )
    assert peaks(np.arange(4), rising)[1].tolist() == [[0.0], [5.0]]
    assert peaks(np.arange(4), falling)[1].tolist() == [[5.0], [0.0]]


def test_a_gap_longer_than_what_is_put_together_stays_one():
    values = np.ones((1000, 1))
    values[400:600] = np.nan
    t, shown = thinned(np.arange(1000), values, 100)
    gap = t[np.isnan(shown[:, 0])]
    # Two rows are left of each 32.
    assert 400 <= gap[0] < 432 and 600 - 64 < gap[-1] < 600 and len(gap) > 8


def test_rows_of_the_drawing_stay_whole():
    rng = np.random.default_rng(1)
    values = rng.normal(size=(500, 3))
    values[123, 0] = 9.0
    t, shown = thinned(np.arange(500), values, 60, most_loaded)
    assert len(t) <= 60 and 123 in t
    assert (shown == values[t]).all()


@pytest.mark.parametrize("count", [5, 8192, 8193, 70_000])
def test_a_long_recording_is_held_evenly_and_with_its_peaks(count):
    rows = ThinnedRows(2, most=4000)
    for k in range(count):
        rows.add(1000 * k, (np.sin(k / 3e3), 50.0 if k == count // 3 else 1.0))
    t, values = rows.arrays(1000)
    assert len(t) <= 1000 and values[:, 1].max() == 50.0
    assert abs(t[values[:, 1].argmax()] / 1000 - count // 3) <= count / 100
    assert t[0] == 0 and t[-1] >= 1000 * (count - 1) - 8 * count
    spaces = np.diff(t)[:-8]
    assert len(spaces) == 0 or spaces.max() <= 2 * spaces.min()
    assert len(rows.arrays(count)[0]) <= 4000 + 8192


def test_a_row_of_a_stamp_that_was_wrong_is_let_go():
    rows = ThinnedRows(1)
    # The third had leapt ahead.
    for t, value in ((1, 10.0), (2, 20.0), (900, 99.0), (3, 30.0)):
        rows.add(t, (value,))
    t, values = rows.arrays(100)
    assert t.tolist() == [1, 2, 3] and values[:, 0].tolist() == [10.0, 20.0, 30.0]
