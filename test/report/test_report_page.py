"""What a report says, whatever the bag is called and holds; and that it loads nothing."""

import gzip
import hashlib
import json
import re
from base64 import b64decode
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from cli_helpers import config, fails
from estimates import SCENE, changed, columns, estimate
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.messages.beside_estimates import OutputStream
from peg_on_hole_ros.records import ACCURACIES
from peg_on_hole_ros.report.inputs import Inputs
from peg_on_hole_ros.report.page import library
from peg_on_hole_ros.report.replay_page import Replay, replay_page
from peg_on_hole_ros.report.tracks import Tracks
from small_bags import JOINTS, MS, WRENCH, joints, wrench, write_bag

MODES = {"three_point": 1.0}
MESSAGES = {"read": 3, "used": 2, "dropped": {"wrench_dropped_late": 1}, "events": {}}
CONTENT = {
    "damage": None, "messages": MESSAGES, "outputs": 2, "start_time": 1.0, "duration": 0.5,
    "contact_mode": MODES, "alarms": [], "alarm_changes": 0, "cycles": [], "realtime_factor": 2.0,
    "reactions_void": None, "accuracies": dict.fromkeys(ACCURACIES),
}  # fmt: skip


def unpacked(text, name="data"):
    packed = re.search(rf'<script type="text/plain" id="{name}">([^<]+)</script>', text)[1]
    return gzip.decompress(b64decode(packed))


def replay_of(path, tracks=None, configuration=None, **more):
    """Return what a replay has found, of outputs made by hand."""
    configuration = configuration or Configuration()
    if tracks is None:
        tracks = Tracks()
        tracks.take(columns(OutputStream(SCENE), estimate(t_ns=10**9)))
    inputs = Inputs(configuration, tracks)
    content = CONTENT | more
    return Replay(
        path, (), content, tracks, inputs, None, ["first doubt", "second"], configuration
    )


def test_it_stands_alone_and_is_well_formed(tmp_path):
    bag, path = write_bag(tmp_path / "a.mcap"), tmp_path / "r.html"
    assert main(["replay", str(bag), "--report", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    page = text[: text.index('id="library"')]
    # A link to a time leads to the page itself.
    assert not re.search(r"""(src|href)=["'](?!data:|#t=)|@import|url\(""", page)
    assert unpacked(text, "library") == library().read_bytes()
    parser = HTMLParser()
    parser.feed(page)
    for tag in ("table", "tr", "td", "th", "h2", "h3", "p", "section", "ul", "li", "button"):
        assert len(re.findall(f"<{tag}[ >]", page)) == page.count(f"</{tag}>"), tag
    model = json.loads(unpacked(text))
    assert {"tilt", "turns", "force", "intervals"} <= {one["name"] for one in model["panels"]}


def test_a_page_with_the_library_has_the_licences_of_all_that_is_in_it(tmp_path):
    """Whatever the installed library says that it contains."""
    bag, path = write_bag(tmp_path / "a.mcap"), tmp_path / "r.html"
    assert main(["replay", str(bag), "--report", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    licences = re.search(r'<script type="text/plain" id="licences">\n([^<]+)</script>', text)[1]
    # Beside the programs there are some lines of itself, within a string, with escapes.
    script = library().read_text(encoding="utf-8").replace("\\n", "\n")
    comments = re.findall(r"/\*[*!]\s.*?\*/", script, re.DOTALL)
    told = "\n".join(one for one in comments if re.search("licen[sc]e|copyright", one, re.I))
    programs = re.findall(r"^ *([\w.@-]+)/[\w./-]+:$", told, re.M)
    programs += re.findall(r"^ \* ([\w-]+) <https", told, re.M)
    programs += re.findall(r"plotly\.js", told)
    holders = re.findall(r"(?:copyright|@author|\(c\))[\d ,-]*([A-Z]\w+,? [A-Z]\w+)", told, re.I)
    assert {"plotly.js", "polybooljs", "maplibre-gl", "pad-left"} <= set(programs)
    assert {"Plotly, Inc", "Kyle Simpson", "Sean Connelly"} <= set(holders)
    assert [one for one in {*programs, *holders} if one not in licences] == []
    for demanded in (
        "Permission is hereby granted, free of charge, to any person obtaining a copy",
        "The above copyright notice and this permission notice shall be included in",
        'THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND',
        "Redistributions in binary form must reproduce the above copyright notice",
    ):
        assert demanded in licences


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (r"a$\frac{1}$b.mcap", r"a$\frac{1}$b.mcap"),
        ("<img src=x onerror=alert(1)>.mcap", "&lt;img src=x onerror=alert(1)&gt;.mcap"),
        # A file system has bytes, not letters: Python keeps what is no UTF-8 as surrogates.
        ("f\udcfcr.mcap", r"f\xfcr.mcap"),
        ("\x1b]0;title\x07.mcap", r"\x1b]0;title\x07.mcap"),
        ("für µm.mcap", "für µm.mcap"),
    ],
)
def test_names_stand_as_they_are_and_nothing_in_them_is_obeyed(tmp_path, name, expected):
    text = replay_page(replay_of(tmp_path / name))
    assert (
        f"<h1>Replay of {expected}</h1>" in text and f"<title>Replay of {expected}</title>" in text
    )
    assert text.encode("utf-8")
    assert name not in text or name == expected


def test_a_bag_with_a_formula_as_its_name_is_reported(tmp_path):
    bag, path = write_bag(tmp_path / r"a$\frac{1}$b.mcap"), tmp_path / "r.html"
    assert main(["replay", str(bag), "--report", str(path)]) == 0
    assert r"<h1>Replay of a$\frac{1}$b.mcap</h1>" in path.read_text(encoding="utf-8")


def test_doubts_come_with_the_likeliest_cause_first_and_drops_with_reasons(tmp_path):
    text = replay_page(replay_of(tmp_path / "a.mcap"))
    doubtful = text.index("These results are doubtful: first doubt.")
    assert doubtful < text.index("No try to insert the peg") < text.index("<li>Second.</li>")
    assert "2 of 3 messages were used. Dropped: 1 wrench_dropped_late." in text


def test_settings_that_differ_stand_apart_with_their_defaults(tmp_path, capsys):
    bag, path = write_bag(tmp_path / "a.mcap"), tmp_path / "r.html"
    given = config(tmp_path, "scene: {friction: 0.35}")
    assert main(["replay", str(bag), "--config", str(given), "--report", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    changed = text[text.index('id="changed"') : text.index('id="kept"')]
    kept = text[text.index('id="kept"') : text.index('id="origin"')]
    assert re.findall(r"<td>([a-z_]+\.[a-z_]+)</td>", changed) == ["scene.friction"]
    assert '<td class="number">0.35</td><td class="number">0.2</td>' in changed
    assert "scene.friction<" not in kept and "scene.peg_mass" in kept


def test_it_says_where_it_comes_from(tmp_path):
    bag, path = write_bag(tmp_path / "a.mcap"), tmp_path / "r.html"
    assert main(["replay", str(bag), "--report", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    origin = text[text.index('id="origin"') :]
    assert hashlib.sha256(bag.read_bytes()).hexdigest() in origin
    for name in ("peg_on_hole_ros", "Python", "numpy", "plotly"):
        assert f"<td>{name}</td>" in origin
    assert re.search(r"<td>\d{4}-\d\d-\d\d \d\d:\d\d:\d\d UTC</td>", origin)
    assert "Recorded from 1970-01-01 00:00:01 UTC" in text


def test_reactions_that_are_not_determined_are_gaps_whether_nan_or_flagged():
    tracks, stream = Tracks(), OutputStream(SCENE)
    for k in range(30):
        flagged, unstated = 10 <= k < 15, 20 <= k < 25
        made = estimate(t_ns=k * MS, monitor={"reactions_determined": float(not flagged)})
        if unstated:
            made = changed(made, normal=np.nan, contact_wrench=np.nan)
        tracks.take(columns(stream, made))
    drawn = tracks.columns()
    gaps = [k for k in range(30) if np.isnan(drawn["K"][k])]
    assert gaps == [*range(10, 15), *range(20, 25)]
    assert np.isnan(drawn["K_high"][gaps]).all()
    assert drawn["K_high"][0] == pytest.approx(20.0 + 1.96 * 0.5, abs=1e-3)
    assert tracks.peaks["K"].normal == 20.0
    assert tracks.undetermined == pytest.approx(10 / 30)
    moments = tracks.moments()
    assert np.isnan(moments["X_K"][12]) and np.isnan(moments["X_K"][22])
    # The page knows no NaN.
    found = json.loads(unpacked(replay_page(replay_of(Path("a.mcap"), tracks))))
    assert found["tables"]["estimate"]["K"][12] is None


def test_what_is_not_learnt_or_not_there_has_no_plot():
    def names(**monitor):
        made = estimate(t_ns=10**9)
        made = changed(made, monitor=made.monitor | monitor)
        tracks = Tracks()
        tracks.take(columns(OutputStream(SCENE), made))
        found = json.loads(unpacked(replay_page(replay_of(Path("a.mcap"), tracks))))
        return {one["name"] for one in found["panels"]}

    assert not {"friction", "clearance", "force"} & names()
    learnt = names(friction=0.2, friction_stddev=0.01, clearance=1e-4, clearance_stddev=1e-6)
    assert {"friction", "clearance"} <= learnt
    known = names(friction=0.2, friction_stddev=0.0, clearance=1e-4, clearance_stddev=0.0)
    assert not {"friction", "clearance"} & known


def test_gaps_and_misfits_of_the_input_are_drawn(tmp_path):
    bag, path = tmp_path / "a.mcap", tmp_path / "r.html"
    with BagWriter(bag) as writer:
        for i in [*range(100), *range(150, 250)]:
            t = 10**9 + i * MS
            # One orientation that no other fits.
            tilt = 0.4 if i == 200 else 0.3
            writer.write("/joint_states", JOINTS, joints(t, (tilt, 0.0, 0.0)), t)
            writer.write("/wrench", WRENCH, wrench(t, (1.0, 2.0, -10.0 - i)), t)
    assert main(["replay", str(bag), "--report", str(path)]) == 0
    tables = json.loads(unpacked(path.read_text(encoding="utf-8")))["tables"]
    for source in ("wrench_interval", "joints_interval"):
        table = tables[source]
        assert max(table["interval"]) == pytest.approx(51.0)
        assert table["t"][table["interval"].index(max(table["interval"]))] == pytest.approx(0.15)
    assert min(tables["wrench"]["Fz"]) == pytest.approx(-259.0)
    table = tables["innovations"]
    largest = table["squared"].index(max(table["squared"]))
    assert table["t"][largest] == pytest.approx(0.2, abs=1e-3)
    # 0.1 rad in deviations of 1e-4 rad, all but what it has moved the estimate.
    assert 5e5 < table["squared"][largest] < 1.1e6


def test_without_plotly_it_is_refused_before_the_work(tmp_path, capsys, monkeypatch):
    bag = write_bag(tmp_path / "a.mcap")
    monkeypatch.setattr("peg_on_hole_ros.report.page.find_spec", lambda name: None)
    message = "--report needs plotly: pip install plotly"
    fails(capsys, 2, message, "replay", bag, "--report", tmp_path / "r.html")
    assert not (tmp_path / "r.html").exists()


def test_settings_that_are_contradicted_come_before_what_happened(tmp_path):
    found = replay_of(tmp_path / "a.mcap")
    assert "Settings are contradicted" not in replay_page(found)
    contradicted = ("wrench: the force is in kN: the driver has to send N", "joints: two publish")
    text = replay_page(found._replace(contradicted=contradicted))
    said = text.index("Settings are contradicted: the force is in kN.")
    first = text.index("The driver has to send N.")
    assert said < first < text.index("No try to insert the peg") < text.index("two publish")
