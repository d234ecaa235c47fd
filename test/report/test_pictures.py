"""The pages as they were last looked at: wide, narrow, dark, on paper; and what changes them."""

import numpy as np
import pytest
from test_comparison_page import output
from test_report_page import replay_of

from browsing import Opened
from estimates import SCENE, changed, columns, estimate
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.messages.beside_estimates import OutputStream
from peg_on_hole_ros.records import ANGLES, JointSample, WrenchSample
from peg_on_hole_ros.report.replay_page import replay_page
from peg_on_hole_ros.report.tracks import Tracks
from pictures import allowed, apart, differing, parts
from small_bags import MS

pytestmark = [pytest.mark.xdist_group("browser"), pytest.mark.timeout(600)]

COUNT, TOUCHES, UNTOLD = 1200, 200, range(600, 750)
CONTENT = {
    "outputs": COUNT, "duration": 1.199, "contact_mode": {"three_point": 0.8, "open": 0.2},
    "alarms": [{"time": 0.9, "name": "jamming", "level": "WARN", "message": "turn the peg"}],
    "alarm_changes": 1,
    "cycles": [
        {
            "start_time": 1.2, "duration": 0.999, "outcome": "unfinished", "transition_time": None,
            "peak_normal": {"K": 90.0, "B1": 52.0, "B2": 60.0}, "alarm_count": 1,
        }
    ],
}  # fmt: skip


def moment(k):
    """A peg that touches, closes and turns; in the middle its reactions are not told."""
    s = k / COUNT
    made = estimate(10**9 + k * MS, 0.2 - 0.1 * s, 0.4 + s, -1.1 + 2.0 * s)
    told = made.monitor | {
        "jamming_risk": s**4,
        "jamming_wedging": s**4,
        "jamming_stall": 0.1 * s,
        "jamming_load": 0.2 * s,
        "transition_probability": s**8,
        "three_point_validity": 1.0,
        "nis_median": 2.4,
        "nis_drift": 3.0,
        "friction": 0.2 + 0.02 * np.sin(9 * s),
        "friction_stddev": 0.02 * (1.1 - s),
        "reactions_determined": float(k not in UNTOLD),
    }
    normal = np.array([20.0 + 70.0 * s**2, 9.0 + 40.0 * s, 11.0 + 40.0 * s])
    if k < TOUCHES:
        return changed(
            made, contact_mode="open", normal=0.0, closed=0.0, contact_wrench=0.0, monitor=told
        )
    warned = {"jamming": int(k > 900)}
    return changed(made, normal=normal, normal_stddev=0.03 * normal, alarms=warned, monitor=told)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    tracks, stream = Tracks(), OutputStream(SCENE)
    found = replay_of(tmp_path_factory.mktemp("pictures") / "cell 4.mcap", tracks, **CONTENT)
    for k in range(COUNT):
        made = moment(k)
        load = 30.0 * (k > TOUCHES) * np.sin(5e-3 * k)
        found.inputs.read(WrenchSample(made.t_ns, (load, 5.0, -load), (0.1, 1e-3 * k, 0.0)))
        # A gap of 60 ms in what the joints say.
        if k % 2 == 0 and not 400 < k < 460:
            found.inputs.read(JointSample(made.t_ns, ANGLES, tuple(made.state[:3])))
        told = columns(stream, made)
        tracks.take(told)
        found.inputs.take(told)
    path = found.path.with_suffix(".html")
    path.write_text(replay_page(found), encoding="utf-8")
    return path


VIEWS = {
    "report": {"width": 1280},
    "report_dark": {"width": 1280, "scheme": "dark"},
    "report_390": {"width": 390, "touch": True},
    "report_paper": {"width": 718},
}


@pytest.fixture(scope="module")
def wide(browser, report):
    """Return a wide page that is open for several tests, and its parts."""
    shown = Opened(browser, report, **VIEWS["report"])
    yield shown.page, parts(shown.page)
    shown.context.close()
    shown.hold()


def test_a_wide_report_is_as_it_was_looked_at(wide):
    assert differing("report", wide[1]) == {}


@pytest.mark.nightly
@pytest.mark.parametrize("view", [view for view in VIEWS if view != "report"])
def test_a_report_is_as_it_was_looked_at(opened, report, view):
    page = opened(report, **VIEWS[view]).page
    page.emulate_media(media="print" if view == "report_paper" else "screen")
    assert differing(view, parts(page)) == {}


@pytest.mark.nightly
def test_a_comparison_is_as_it_was_looked_at(opened, tmp_path):
    def heavier(made):
        return changed(made, normal=made.normal + [2.0, 0.0, 0.0])

    a, b = output(tmp_path / "a.mcap"), output(tmp_path / "b.mcap", heavier)
    path = tmp_path / "c.html"
    assert main(["compare", str(a), str(b), "--report", str(path)]) == 0
    page = opened(path, width=1280).page
    assert differing("comparison", parts(page)) == {}


STYLE = "(text) => document.head.insertAdjacentHTML('beforeend', `<style>${text}</style>`)"
PLAIN = "() => document.head.lastElementChild.remove()"
CHANGES = [
    ("* { font-family: 'DejaVu Serif' !important }", set()),
    (".force, .head { display: none }", {".views svg 0", ".views svg 1"}),
    (".plot[data-panel=tilt] .lines { visibility: hidden }", {".plot 0"}),
    (".plot[data-panel=modes] .bars { visibility: hidden }", {".plot 3"}),
    ("#summary { display: none }", None),
]


def test_a_letter_is_no_change_and_a_lost_line_is(wide):
    page, before = wide
    for style, named in CHANGES:
        page.evaluate(STYLE, style)
        after = parts(page)
        page.evaluate(PLAIN)
        if named is None:
            assert before.keys() != after.keys()
            continue
        shares = {name: apart(before[name], after[name]) for name in before}
        assert {name for name, share in shares.items() if share > allowed(name)} == named, shares
