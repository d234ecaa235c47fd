"""A real browser, where the machine has one, and a report to look at."""

import os
import shutil

import pytest

from cli_helpers import ROOT
from peg_on_hole_ros.cli.main import main

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
WHY_NOT = "no browser: install one (apt-get install chromium) to test the report in it"


@pytest.fixture(scope="session")
def browser():
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip(WHY_NOT)
    sync_api = pytest.importorskip("playwright.sync_api")
    # Chromium's sandbox does not start as root.
    arguments = ["--no-sandbox"] if os.geteuid() == 0 else []
    with sync_api.sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=path, args=arguments)
        yield launched
        launched.close()


@pytest.fixture(scope="session")
def working_cycle(tmp_path_factory):
    """Return the report of a shipped bag."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    bag = ROOT / "bags" / "working_cycle.mcap"
    assert main(["replay", str(bag), "--report", str(path)]) == 0
    return path


class Opened:
    """A page in a browser, with what it complained of and asked for."""

    def __init__(self, browser, path, width=1280, height=900, scheme="light", touch=False):
        self.context = browser.new_context(
            viewport={"width": width, "height": height}, color_scheme=scheme, has_touch=touch
        )
        # A machine may have other things to do.
        self.context.set_default_timeout(120_000)
        self.page = self.context.new_page()
        self.complaints, self.requests = [], []
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(path.as_uri())
        self.page.wait_for_selector("html[data-ready]")

    def reading(self, name):
        return self.page.inner_text(f'[data-reading="{name}"]')

    def ranges(self):
        """Return the spans of time that the plots show, each once."""
        return self.page.evaluate(
            "[...new Set([...document.querySelectorAll('.plot')]"
            ".map((p) => p.layout.xaxis.range.map((x) => x.toFixed(6)).join()))]"
        )

    def span(self):
        (only,) = self.ranges()
        return tuple(map(float, only.split(",")))

    def on_plot(self, name, x, y=0.5):
        """Return the place on the screen at shares of a plot's width and height."""
        plot = self.page.locator(f'.plot[data-panel="{name}"]')
        plot.scroll_into_view_if_needed()
        box = plot.locator(".nsewdrag").first.bounding_box()
        return box["x"] + x * box["width"], box["y"] + y * box["height"]


@pytest.fixture
def opened(browser):
    """Open a report; what it complained of fails the test in the end."""
    all_opened = []

    def open_(path, **options):
        all_opened.append(Opened(browser, path, **options))
        return all_opened[-1]

    yield open_
    for one in all_opened:
        one.context.close()
        assert one.complaints == []
        assert all(url.startswith(("file:", "data:", "blob:")) for url in one.requests)
