"""The page of many bags in a real browser: plots of all tries, and the way to each report."""

import re

import pytest

from cli_helpers import ROOT
from peg_on_hole_ros.cli.main import main
from recorded import motion, write

pytestmark = [pytest.mark.xdist_group("browser"), pytest.mark.timeout(600)]
HOSTILE = "<b>&x.mcap"


@pytest.fixture(scope="module")
def shift(tmp_path_factory):
    folder = tmp_path_factory.mktemp("shift")
    hostile = write(folder / HOSTILE, motion(30))
    (folder / "rubbish.mcap").write_bytes(b"no bag")
    out = folder / "out"
    bags = [ROOT / "bags" / "working_cycle.mcap", hostile, folder / "rubbish.mcap"]
    assert main(["replay", *map(str, bags), "--jobs", "2", "--out", str(out), "--report"]) == 3
    return out / "index.html"


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("width", "scheme"), [(1280, "light"), (390, "dark"), (1280, "dark"), (390, "light")]
)
def test_all_tries_are_drawn_and_fit_the_width(opened, shift, width, scheme):
    page = opened(shift, width=width, height=844, scheme=scheme, touch=width < 500).page
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    # What is wrong comes first.
    lead, verdict = (page.inner_text(part) for part in (".lead", ".verdict"))
    assert re.match(r"1 of 3 bags could not be read whole", lead)
    assert re.match(r"1 of 3 tries went in; 2 of 3 bags could be read whole", verdict)
    assert "not an MCAP file" in page.inner_text("#bags tr:nth-child(2)")
    drawn = page.evaluate(
        "Object.fromEntries([...document.querySelectorAll('.plot')].map((p) => "
        "[p.dataset.panel, p.data.map((t) => t.x.length)]))"
    )
    assert drawn == {"outcomes": [1, 0, 1, 1], "transition": [3], "peaks": [3, 3, 3]}
    bars = page.locator(".plot[data-panel=outcomes] .point").count()
    assert bars == 3
    # Names of files are text.
    assert HOSTILE in page.inner_text("#bags") and page.locator("#bags b").count() == 0


def test_each_bag_leads_to_its_report(opened, shift):
    shown = opened(shift)
    links = shown.page.locator("#bags a")
    assert links.count() == 2
    assert "not an MCAP file" in shown.page.inner_text("#bags")
    links.nth(1).click()
    shown.page.wait_for_selector("html[data-ready]")
    assert HOSTILE in shown.page.inner_text("h1")


@pytest.mark.nightly
def test_a_point_leads_to_the_report_of_its_bag(opened, shift):
    shown = opened(shift)
    plot = shown.page.locator(".plot[data-panel=transition]")
    plot.scroll_into_view_if_needed()
    box = plot.locator(".points .point").first.bounding_box()
    shown.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    shown.page.wait_for_url("**/working_cycle-*/report.html")
