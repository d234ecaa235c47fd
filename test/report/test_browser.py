"""The report in a real browser: what a hand on mouse, keys and paper finds."""

import re

import pytest

from browsing import Opened
from tiers import nightly

pytestmark = [pytest.mark.xdist_group("browser"), pytest.mark.timeout(600)]

WHOLE = (0.0, 11.7)
# What was asked for is on the screen, were it late.
FRAMES = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


@pytest.fixture(scope="module")
def wide(browser, working_cycle):
    """Return a wide page that is open for several tests, and the time it shows at first."""
    shown = Opened(browser, working_cycle)
    yield shown, shown.page.input_value("#time")
    shown.context.close()
    shown.hold()


@pytest.fixture
def shown(wide):
    """Return that page as it was opened."""
    shown, begin = wide
    shown.page.mouse.move(0, 0)
    shown.page.click("#all")
    shown.page.locator("#time").fill(begin)
    return shown


@pytest.mark.parametrize(
    ("width", "scheme"), [(390, "dark"), *nightly((1280, "light"), (1280, "dark"), (390, "light"))]
)
def test_everything_is_there_and_fits_the_width(opened, working_cycle, width, scheme):
    shown = opened(working_cycle, width=width, height=844, scheme=scheme, touch=width < 500)
    page = shown.page
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    titles = page.locator(".panel h3").all_inner_texts()
    assert titles[:5] == [
        *("Tilt", "Turns", "Normal reactions", "Contact mode"),
        "Risk of jamming and transition",
    ]
    assert {"Friction as estimated", "Innovations", "Gaps in the input"} < set(titles)
    # The clearance is stated to be known: nothing of it is learnt.
    assert "Clearance as estimated" not in titles
    assert page.locator(".plot .main-svg").count() >= len(titles)
    wide = page.evaluate(
        "[...document.querySelectorAll('.plot svg.main-svg')]"
        ".map((svg) => svg.getBoundingClientRect().right)"
    )
    assert max(wide) <= width


@pytest.mark.nightly
def test_the_first_lines_say_what_happened(shown):
    page = shown.page
    lead = page.inner_text(".lead")
    assert re.match(
        r"The peg went in, in the second of 2 tries: transition at 10\.2\d\d s\.", lead
    )
    summary = page.inner_text("#summary")
    assert re.search(r"Worst load: \d+ N at K, \d+% of its limit of 500 N\.", summary)
    assert "the peg has left the rim: begin again from free air, or press it on" in summary
    assert "Nothing was dropped: all 17552 messages were used." in summary
    assert "The data do not contradict the settings." in summary


def test_the_cursor_follows_the_mouse_through_all_plots_and_the_drawing(shown):
    seen = []
    for share, mode in ((0.05, "open"), (0.4, "three_point"), (0.95, "two_point")):
        shown.page.mouse.move(*shown.on_plot("tilt", share))
        at = share * WHOLE[1]
        shown.page.wait_for_function(
            "([at]) => Math.abs(parseFloat(document.querySelector('[data-reading=t]').textContent)"
            " - at) < 0.1",
            arg=[at],
        )
        assert shown.reading("mode") == mode
        lines = shown.page.evaluate(
            "[...document.querySelectorAll('.cursor')].filter((c) => c.style.display === 'block')"
            ".map((c) => Math.round(c.getBoundingClientRect().left))"
        )
        assert len(lines) == shown.page.locator(".plot").count()
        # Margins differ with the width of what stands at the axis.
        assert max(lines) - min(lines) < 40
        seen.append(
            (shown.page.inner_html("#side"), shown.page.inner_html("#top"), shown.reading("gamma"))
        )
    for one, other in zip(seen, seen[1:]):
        assert all(a != b for a, b in zip(one, other))
    assert shown.page.locator(".hoverlayer .legend, .hoverlayer .hovertext").count() > 0


def test_the_drawing_has_arrows_and_cones_where_there_is_contact(shown):
    # It begins where the load is greatest, in the hole.
    for name in ("#side", "#top"):
        assert shown.page.locator(name).locator(".head").count() == 3
    shown.page.locator("#time").fill("2.5")
    for name in ("#side", "#top"):
        picture = shown.page.locator(name)
        assert picture.locator(".head").count() == 3
        assert picture.locator(".cone").count() == 3
        assert picture.locator(".dot").count() == 3
    shown.page.locator("#time").fill("0.1")
    assert shown.reading("mode") == "open"
    assert shown.page.locator(".head, .cone, .dot:not(.open)").count() == 0
    assert "no contact: place not known" in shown.page.text_content("#side")
    assert shown.reading("K") == "no contact"
    shown.page.locator("#time").fill("11.5")
    # In the hole B1 and B2 are one contact on the wall.
    assert "B1, B2" in shown.page.text_content("#side")
    # At rest it touches, and nobody knows with which forces: places and cones, but no arrows.
    shown.page.locator("#time").fill("6.1")
    assert shown.reading("K") == "not determined"
    assert shown.page.locator(".head").count() == 0
    assert shown.page.locator("#side .cone, #top .cone").count() == 6
    # Forces lie within their cones, as far as a drawing tells.
    shown.page.locator("#time").fill("2.5")
    inside = shown.page.evaluate(
        """() => {
          const all = (kind) => [...document.querySelectorAll("#top " + kind)];
          const [lines, heads, cones] = [".force", ".head", ".cone"].map(all);
          return lines.map((line, i) => {
            const from = [Number(line.getAttribute("x1")), Number(line.getAttribute("y1"))];
            const tip = heads[i].points[0];
            const way = [tip.x - from[0], tip.y - from[1]], size = Math.hypot(...way);
            // On the mantle, where it slides: a cone of a polygon lies a little within.
            return [[0, 0], [0.4, 0], [-0.4, 0], [0, 0.4], [0, -0.4]].some(([x, y]) => {
              const point = line.ownerSVGElement.createSVGPoint();
              point.x = from[0] + 10 * way[0] / size + x;
              point.y = from[1] + 10 * way[1] / size + y;
              return cones[i].isPointInFill(point);
            });
          });
        }"""
    )
    assert inside == [True] * 3


def test_a_drag_zooms_all_plots_and_all_goes_back(shown):
    mouse = shown.page.mouse
    mouse.move(*shown.on_plot("reactions", 0.2))
    mouse.down()
    mouse.move(*shown.on_plot("reactions", 0.4), steps=5)
    mouse.up()
    shown.page.wait_for_function(
        "document.querySelector('.plot[data-panel=intervals]').layout.xaxis.range[1] < 11"
    )
    assert shown.span() == pytest.approx((2.34, 4.68), abs=0.05)
    shown.page.click("#closer")
    begin, end = shown.span()
    assert end - begin == pytest.approx(1.17, abs=0.03)
    shown.page.click("#wider")
    shown.page.click("#all")
    assert shown.span() == pytest.approx(WHOLE, abs=1e-6)
    shown.page.click("#closer")
    mouse.dblclick(*shown.on_plot("reactions", 0.5))
    shown.page.wait_for_function(
        "document.querySelector('.plot[data-panel=tilt]').layout.xaxis.range[1] > 11.6"
    )
    assert shown.span() == pytest.approx(WHOLE, abs=1e-6)


def test_a_try_brings_plots_and_drawing_to_its_place(shown):
    second = shown.page.locator("#tries tr").nth(2)
    begins = float(second.locator("a").first.inner_text().removesuffix(" s"))
    assert begins == pytest.approx(8.75, abs=0.05)
    second.locator("a").first.click()
    low, high = shown.span()
    assert low == pytest.approx(begins - 0.16, abs=0.05) and high == pytest.approx(11.7)
    assert shown.reading("t") == f"{begins:.3f} s"
    assert shown.page.evaluate("document.querySelector('#plots').getBoundingClientRect().top") < 5
    second.locator("a").nth(1).click()
    assert shown.reading("t").startswith("10.28")


def test_an_address_with_a_time_opens_there_and_marks_it(opened, working_cycle, tmp_path):
    shown = opened(working_cycle)
    page = shown.page
    assert page.locator(".mark-line:visible").count() == 0
    for hash_, time in (("#t=4.5", "4.500 s"), ("#t=2.25,3", "2.250 s")):
        page.evaluate("(hash) => { location.hash = hash; }", hash_)
        page.wait_for_function(
            "(t) => document.querySelector('[data-reading=t]').textContent === t", arg=time
        )
        assert page.locator(".mark-line:visible").count() == page.locator(".plot").count()
    low, high = shown.span()
    assert low < 2.25 and high == pytest.approx(3.0, abs=0.1)
    # As a link from elsewhere does; what is no time does nothing.
    page.goto(page.url.partition("#")[0] + "#t=7")
    page.reload()
    page.wait_for_selector("html[data-ready]")
    assert shown.reading("t") == "7.000 s"
    page.evaluate("location.hash = '#t=no'")
    page.evaluate(FRAMES)
    assert shown.reading("t") == "7.000 s"


def test_a_plot_can_be_had_as_a_picture_and_as_a_table(opened, working_cycle):
    page = opened(working_cycle).page
    with page.expect_download() as waiting:
        page.click("[data-get=csv][data-panel=reactions]")
    assert waiting.value.suggested_filename.endswith("_reactions.csv")
    head, *rows = waiting.value.path().read_text(encoding="utf-8").splitlines()
    assert head == "time_s,line,value [N],low,high"
    cells = [row.split(",") for row in rows]
    contacts = {"N_K", "N_B1", "N_B2"}
    assert {cell[1] for cell in cells} == contacts | {f"{name} truth" for name in contacts}
    worst = max(float(cell[2]) for cell in cells if cell[1] == "N_K" and cell[2])
    assert f"{worst:.3g} N at K" in page.inner_text("#summary")
    with page.expect_download() as waiting:
        page.click("[data-get=png][data-panel=tilt]")
    assert waiting.value.suggested_filename.endswith("_tilt.png")
    assert waiting.value.path().read_bytes().startswith(b"\x89PNG")
    with page.expect_download() as waiting:
        page.click("[data-get=csv][data-panel=modes]")
    text = waiting.value.path().read_text(encoding="utf-8")
    assert text.startswith("source,time_s,mode\nestimate,0,")


def test_the_truth_lies_below_the_estimate(shown):
    """What is drawn later lies above."""
    names = shown.page.evaluate(
        "document.querySelector('.plot[data-panel=tilt]').data.map((trace) => trace.name)"
    )
    assert names.index("truth") < names.index("gamma")


def test_it_plays_and_stops(shown):
    shown.page.locator("#time").fill("3")
    shown.page.select_option("#speed", "4")
    shown.page.click("#play")
    assert shown.page.inner_text("#play") == "Pause"
    shown.page.wait_for_function("Number(document.querySelector('#time').value) > 3.5")
    shown.page.click("#play")
    stopped = shown.reading("t")
    assert shown.page.inner_text("#play") == "Play"
    shown.page.evaluate(FRAMES)
    assert shown.reading("t") == stopped != "3.000 s"
    # By keys alone, too.
    shown.page.focus("#time")
    shown.page.keyboard.press("Home")
    assert shown.reading("t") == "0.000 s"


@pytest.mark.nightly
def test_colours_follow_the_theme_while_it_is_open_and_paper_is_light(shown):
    shown.page.emulate_media(color_scheme="dark")

    def colours():
        shown.page.evaluate(FRAMES)
        return shown.page.evaluate(
            "[getComputedStyle(document.body).backgroundColor,"
            " document.querySelector('.plot[data-panel=tilt] .xtick text').style.fill,"
            " document.querySelector('.plot[data-panel=tilt] .legendlines path').style.stroke]"
        )

    dark = colours()
    shown.page.emulate_media(color_scheme="light")
    light = colours()
    assert dark[0] == "rgb(20, 23, 26)" and light[0] == "rgb(255, 255, 255)"
    assert all(a != b for a, b in zip(dark, light))
    shown.page.emulate_media(color_scheme="dark", media="print")
    assert colours() == light
    assert shown.page.locator("#play").is_hidden()
    assert shown.page.pdf(format="A4").startswith(b"%PDF")
    shown.page.emulate_media(color_scheme="dark", media="screen")
    assert colours() == dark
    shown.page.emulate_media(color_scheme="light")


@pytest.mark.nightly
def test_paper_is_wide_enough(opened, working_cycle):
    # A4 less its margins, in the pixels of a print.
    shown = opened(working_cycle, width=718)
    shown.page.emulate_media(media="print")
    assert shown.page.evaluate("document.documentElement.scrollWidth") <= 718
