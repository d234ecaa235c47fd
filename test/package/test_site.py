"""The site of the documents is built without a warning: links, anchors, pages left out."""

import os
import re
import subprocess
import sys

import pytest

from peg_on_hole_ros.config.parameter_table import PARAMETERS
from simulated import ROOT

pytest.importorskip("mkdocstrings")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--site-dir", str(folder)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT), "NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr
    return folder


def test_every_parameter_is_in_the_reference(site):
    text = (site / "parameters.html").read_text(encoding="utf-8")
    assert {row.name for row in PARAMETERS} <= set(re.findall(r"<code>([\w.]+)</code>", text))


def test_the_python_reference_has_signatures_and_units(site):
    text = (site / "api.html").read_text(encoding="utf-8")
    assert "replay_bag" in text and "from_parameters" in text and "[ns]" in text


def test_pages_load_nothing_from_elsewhere(site):
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert not re.search(
            r"<(?:script|link|img)[^>]+(?:src|href)=\"https?://(?!example)", text
        ), page
