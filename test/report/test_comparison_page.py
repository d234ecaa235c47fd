"""Two outputs over each other: what the page says of them, and what it draws."""

import gzip
import json
import re
from base64 import b64decode

import numpy as np
import pytest

from cli_helpers import config, fails
from estimates import SCENE, changed, estimate, messages
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.messages.beside_estimates import OutputStream
from small_bags import MS, write_bag
from tiers import nightly


def output(path, change=None, psi=0.4):
    """Write an output of 50 stamps; `change` alters those from 20 to 29."""
    stream = OutputStream(SCENE)
    with BagWriter(path, Configuration()) as writer:
        for k in range(50):
            made = estimate(t_ns=k * MS, psi=psi)
            if change and 20 <= k < 30:
                made = change(made)
            for topic, ros_type, fields in messages(stream, made):
                writer.write(f"/peg_on_hole/{topic}", ros_type, fields, k * MS)
    return path


def compared(tmp_path, a, b):
    path = tmp_path / "c.html"
    assert main(["compare", str(a), str(b), "--report", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    packed = re.search(r'id="data">([^<]+)<', text)[1]
    return text, json.loads(gzip.decompress(b64decode(packed)))


def test_both_are_drawn_and_how_far_they_are_apart(tmp_path):
    def heavier(made):
        return changed(made, normal=made.normal + [2.0, 0.0, 0.0])

    a, b = output(tmp_path / "a.mcap"), output(tmp_path / "b.mcap", heavier)
    text, model = compared(tmp_path, a, b)
    lead = re.search('<p class="lead">([^<]*)</p>', text)[1]
    assert lead == "The outputs differ, most in N_K: by up to 2 N, 4 standard deviations."
    reactions = next(one for one in model["panels"] if one["name"] == "reactions")
    assert [line["name"] for line in reactions["lines"][::3]] == ["N_K A", "N_K B"]
    apart = np.array(model["tables"]["difference"]["K"], float)
    assert apart[20:30] == pytest.approx(4.0) and not apart[:20].any() and not apart[30:].any()
    assert [row["name"] for row in model["modes"]] == ["A", "B"]
    assert "moving" not in model
    # Settings and what differs come before the plots; what is the same has no row and no line.
    quantities = text[text.index('id="quantities"') : text.index('id="plots"')]
    assert text.index('id="changed"') < text.index('id="quantities"')
    assert re.findall(r"<tr><td>([^<]*)</td>", quantities) == ["N_K"]
    assert "The same in both: gamma, psi, phi," in quantities
    assert set(model["tables"]["difference"]) == {"t", "K"}


def test_outputs_that_are_the_same_are_said_to_be(tmp_path):
    a, b = output(tmp_path / "a.mcap"), output(tmp_path / "b.mcap")
    assert "Both outputs are the same, bit for bit." in compared(tmp_path, a, b)[0]


def test_turns_on_both_sides_of_half_a_turn_are_drawn_beside_each_other(tmp_path):
    a = output(tmp_path / "a.mcap", psi=np.pi - 1e-3)
    b = output(tmp_path / "b.mcap", psi=-np.pi + 1e-3)
    tables = compared(tmp_path, a, b)[1]["tables"]
    assert np.subtract(tables["b"]["psi"], tables["a"]["psi"]) == pytest.approx(2e-3, abs=1e-5)
    assert max(np.abs(tables["difference"]["psi"])) < 1e3


def test_two_configurations_are_named_with_what_differs(tmp_path):
    bag, path = write_bag(tmp_path / "bag.mcap"), tmp_path / "c.html"
    a = config(tmp_path, "scene: {friction: 0.2}", "a.yaml")
    b = config(tmp_path, "scene: {friction: 0.3}", "<b>.yaml")
    assert main(["compare", str(a), str(b), "--bag", str(bag), "--report", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    changed = text[text.index('id="changed"') : text.index('id="origin"')]
    assert "<td>scene.friction</td>" in changed and "0.3</td>" in changed
    assert "&lt;b&gt;.yaml" in text and "<b>.yaml" not in text


def test_a_report_is_not_written_over_what_is_compared(tmp_path, capsys):
    a, b = output(tmp_path / "a.mcap"), output(tmp_path / "b.mcap")
    message = f"cannot write {a}: it is the file that is read"
    fails(capsys, 2, message, "compare", a, b, "--report", a)


@pytest.mark.xdist_group("browser")
@pytest.mark.parametrize("width", [390, *nightly(1280)])
def test_it_opens_in_a_browser_and_fits(opened, tmp_path, width):
    a, b = output(tmp_path / "a.mcap"), output(tmp_path / "b.mcap")
    compared(tmp_path, a, b)
    shown = opened(tmp_path / "c.html", width=width, touch=width < 500)
    assert shown.page.evaluate("document.documentElement.scrollWidth") <= width
    shown.page.click("#closer")
    assert len(shown.ranges()) == 1
    assert shown.page.locator("#side").count() == 0
