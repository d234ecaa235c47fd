"""A real browser, where the machine has one, and a report to look at."""

import os
import shutil

import pytest

from browsing import Opened
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
        one.hold()
