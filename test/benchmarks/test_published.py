"""What docs show of chart and stability is what their CSV files hold."""

import runpy

import numpy as np
import pytest

from simulated import ROOT

pytest.importorskip("matplotlib.figure")
Image = pytest.importorskip("PIL.Image")

from pictures import DRAWN, apart  # noqa: E402
from tiers import nightly  # noqa: E402

TOOL = runpy.run_path(str(ROOT / "tools" / "figures.py"))
PAGES = "chart", "stability"
SIZE = (900, 900)


@pytest.fixture(scope="module")
def made():
    return TOOL["made"](ROOT / "docs" / "figures")


def test_every_page_is_looked_at(made):
    assert tuple(made) == PAGES


@pytest.mark.parametrize("name", PAGES)
def test_tables_are_those_of_the_files(made, name):
    page = (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
    table, _ = made[name]
    assert f"{TOOL['BEGIN']}{table}{TOOL['END']}" in page, "run tools/figures.py"


@pytest.mark.parametrize(
    ("name", "end"),
    [
        *((name, "") for name in PAGES),
        ("chart", "_kinds"),
        ("chart", "_cycle"),
        ("stability", "_equations"),
        *nightly(
            ("chart", "_cycle_narrow"),
            ("chart", "_narrow"),
            ("chart", "_kinds_narrow"),
            ("stability", "_narrow"),
            ("stability", "_equations_narrow"),
        ),
    ],
)
def test_pictures_are_those_of_the_files(made, name, end, tmp_path):
    """Another release of matplotlib may set a letter otherwise, and nothing more."""
    drawn = tmp_path / "drawn.png"
    made[name][1][end].savefig(drawn)
    kept = ROOT / "docs" / "figures" / f"{name}{end}.png"
    both = [Image.open(path).convert("RGB") for path in (drawn, kept)]
    assert both[0].size == both[1].size
    one, other = (np.asarray(image.resize(SIZE, Image.Resampling.BOX)) for image in both)
    assert apart(one, other) <= DRAWN
    # A point of another place is more than that.
    assert apart(one, np.roll(other, 10, axis=1)) > DRAWN
