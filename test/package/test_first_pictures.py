"""The pictures of README and guide are what their scripts draw today."""

import re

import numpy as np
import pytest

from scripts import loaded
from simulated import ROOT

pytest.importorskip("matplotlib.figure")
Image = pytest.importorskip("PIL.Image")

from pictures import DRAWN, apart  # noqa: E402

FIGURES = ROOT / "docs" / "figures"
SET_UP = loaded(FIGURES / "set_up.py")
SHOWN = re.compile(r"<text[^>]*>([^<]+)</text>")
SIZE = (900, 900)
MOST_BYTES = 300_000


def texts(path):
    return SHOWN.findall(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", SET_UP.PICTURES)
def test_settings_are_drawn(tmp_path, name):
    assert texts(SET_UP.draw(tmp_path, name)) == texts(FIGURES / f"{name}.svg")


def test_chamfers_have_the_same_words_on_a_phone(tmp_path):
    drawn = loaded(FIGURES / "chamfers.py").draw(tmp_path, narrow=True)
    assert (
        texts(drawn) == texts(FIGURES / "chamfers_narrow.svg") == texts(FIGURES / "chamfers.svg")
    )


def assert_alike(drawn, name):
    """Another release of matplotlib may set a letter otherwise, and nothing more."""
    kept = FIGURES / name
    assert kept.stat().st_size < MOST_BYTES
    both = [Image.open(path).convert("RGB") for path in (drawn / name, kept)]
    assert both[0].size == both[1].size
    one, other = (np.asarray(image.resize(SIZE, Image.Resampling.BOX)) for image in both)
    assert apart(one, other) <= DRAWN
    # A line in another place is more than that.
    assert apart(one, np.roll(other, 10, axis=1)) > DRAWN


def test_what_the_monitor_saves_is_drawn_of_its_figures(tmp_path):
    loaded(FIGURES / "loop.py").draw(tmp_path)
    for name in ("loop.png", "loop_narrow.png"):
        assert_alike(tmp_path, name)


def test_the_film_is_small_enough_for_a_first_page():
    film = FIGURES / "loop_film.gif"
    assert film.stat().st_size < 2_000_000
    assert Image.open(film).n_frames > 30


@pytest.mark.nightly
def test_the_first_picture_is_that_of_today_s_replays(tmp_path):
    loaded(FIGURES / "first_page.py").main(tmp_path)
    for name in ("first_page.png", "first_page_narrow.png"):
        assert_alike(tmp_path, name)
