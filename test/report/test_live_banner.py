"""The live page without a node: what stands above the drawing, and gaps in its strips."""

import json

import pytest

from browsing import Page
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.report.live_page import drawn, live_page

pytestmark = [pytest.mark.xdist_group("browser"), pytest.mark.timeout(600)]

# A stream that the test writes.
STREAM = """
window.WebSocket = class {
  constructor() { window.stream = this; }
};
"""
MOMENT = {
    "t": 1.0, "gamma": 0.2, "psi": 0.3, "phi": 0.1, "psi_stddev": 0.01, "phi_stddev": None,
    "p_h": 0.0, "p_e": 0.0, "p_z": 0.0, "S1": None, "b": None, "a1": None, "friction": 0.2,
    "jamming_risk": 0.1,
    **dict.fromkeys(("K", "B1", "B2"), 20.0),
    **{f"{name}_stddev": 90.0 for name in ("K", "B1", "B2")},
    **{f"{name}_closed": 1.0 for name in ("K", "B1", "B2")},
    **{f"{axis}_{name}": 1.0 for axis in "hez" for name in ("K", "B1", "B2")},
}  # fmt: skip
JAM = {"name": "jamming", "level": "ERROR", "said": "the peg wedges: stop, and lift it"}
LOSS = {"name": "contact_loss", "level": "WARN", "said": "the peg leaves the rim: press it on"}
QUIET = {"name": "overload", "level": "OK", "said": "no overload"}
SIGN = {
    "about": "filter", "level": "WARN", "headline": "the sign of the wrench is reversed",
    "lines": ["Set wrench.acts_on: robot"],
}  # fmt: skip


class Live(Page):
    """The page, with frames of the test's own."""

    def __init__(self, browser, path, width, scheme):
        self.context = browser.new_context(
            viewport={"width": width, "height": 844}, color_scheme=scheme
        )
        self.context.add_init_script(STREAM)
        self.page = self.context.new_page()
        self.complaints = []
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.goto(path.as_uri())
        self.send(settings=drawn(Configuration()), frames=[])
        self.page.wait_for_selector("html[data-ready]")

    def send(self, **message):
        self.page.evaluate(
            "(data) => { window.stream.onmessage({ data }); return new Promise((done) => "
            "requestAnimationFrame(() => requestAnimationFrame(done))); }",
            json.dumps(message),
        )

    def banners(self):
        return [
            [one.get_attribute("class"), one.inner_text().split("\n")[0]]
            for one in self.page.locator("#banners .banner").all()
        ]


@pytest.fixture
def live(browser, tmp_path):
    path, opened = tmp_path / "live.html", []
    path.write_text(live_page("/peg_on_hole"), encoding="utf-8")

    def open_(width=1280, scheme="light"):
        opened.append(Live(browser, path, width, scheme))
        return opened[-1]

    yield open_
    for one in opened:
        one.context.close()
        assert one.complaints == []


@pytest.mark.parametrize(("width", "scheme"), [(390, "light"), (1280, "dark")])
def test_alarms_and_causes_are_seen_without_scrolling(live, width, scheme):
    shown = live(width, scheme)
    page = shown.page
    shown.send(t=1.0, lines={}, moment=MOMENT, modes=[[0.0, "three_point"]])
    assert shown.banners() == []
    shown.send(t=1.1, lines={}, moment=MOMENT, alarms=[LOSS, JAM, QUIET], causes=[SIGN])
    assert shown.banners() == [
        ["banner alarm error", "ERROR: jamming"],
        ["banner alarm warn", "WARN: contact loss"],
        ["banner cause warn", "Suspected: the sign of the wrench is reversed"],
    ]
    assert "the peg wedges: stop, and lift it" in page.inner_text("#banners")
    assert "Set wrench.acts_on: robot" in page.inner_text("#banners")
    assert page.evaluate("scrollY") == 0
    bottom = page.evaluate(
        "Math.max(...[...document.querySelectorAll('.banner')]"
        ".map((b) => b.getBoundingClientRect().bottom))"
    )
    assert bottom < 500 and page.evaluate("document.documentElement.scrollWidth") <= width
    red, amber = (
        page.evaluate("(s) => getComputedStyle(document.querySelector(s)).backgroundColor", kind)
        for kind in (".alarm.error", ".alarm.warn")
    )
    assert (red, amber) == ("rgb(179, 38, 30)", "rgb(255, 207, 128)")
    # What has gone is withdrawn.
    shown.send(t=1.2, lines={}, moment=MOMENT, alarms=[QUIET], causes=[])
    assert shown.banners() == []


def test_readings_that_nothing_determines_are_no_numbers(live):
    shown = live()
    shown.send(t=1.0, lines={}, moment=MOMENT | {"K": None}, modes=[[0.0, "three_point"]])
    read = {
        name: shown.page.inner_text(f"[data-reading={name}]")
        for name in ("psi", "phi", "K", "B1", "friction")
    }
    assert read == {
        "psi": "0.3 rad", "phi": "not determined", "K": "not determined", "B1": "20 ± 180 N",
        "friction": "0.2",
    }  # fmt: skip


# Whether any pixel of a line's colour is in the column of a time.
DRAWN_AT = """([strip, t, end]) => {
  const canvas = document.querySelector(`[data-strip=${strip}]`), ratio = devicePixelRatio || 1;
  const x = Math.round((46 + t / 20 * (canvas.clientWidth - 46 - 8)) * ratio);
  const data = canvas.getContext("2d").getImageData(x, 20 * ratio, 1, canvas.height - 40 * ratio).data;
  const colours = new Set();
  for (let i = 0; i < data.length; i += 4) if (data[i + 3] > 200) colours.add([...data.slice(i, i + 3)].join());
  return [...colours];
}"""  # noqa: E501


def test_strips_have_a_gap_where_no_estimate_came(live):
    shown = live()
    lines = {"gamma": [[0.05 * k, 0.2] for k in range(61)]}
    shown.send(t=3.0, lines=lines, moment=MOMENT, modes=[[0.0, "three_point"]])
    lines = {"gamma": [[9.0 + 0.05 * k, 0.2] for k in range(21)]}
    shown.send(t=10.0, lines=lines, moment=MOMENT)

    def at(strip, t):
        return shown.page.evaluate(DRAWN_AT, [strip, t, 10.0])

    blue = "11,92,173"
    assert [blue in at("tilt", t) for t in (2.1, 6.1, 9.6)] == [True, False, True]
    assert [bool(at("modes", t)) for t in (2.1, 6.1, 9.6)] == [True, False, True]
