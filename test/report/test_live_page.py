"""The live page: a real node, the real command, a real browser."""

import json
import socket

import numpy as np
import pytest

from browsing import Page
from cli_helpers import ROOT, command, fails, watching
from dds_peer import node_process

pytest.importorskip("rclpy")
pytest.importorskip("websockets")

from rclpy.serialization import deserialize_message  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from websockets.sync.client import connect  # noqa: E402

from peg_on_hole_ros.bags.reader import Bag  # noqa: E402
from peg_on_hole_ros.messages.beside_estimates import PREFIX  # noqa: E402
from peg_on_hole_ros.ros.player import Player  # noqa: E402
from pictures import differing, parts  # noqa: E402
from tiers import nightly  # noqa: E402

pytestmark = [pytest.mark.xdist_group("dds"), pytest.mark.timeout(600)]
BAG = ROOT / "bags" / "closing_with_slip.mcap"
# Not the default, so that what the page knows comes from the node.
WARN = 0.625


def page_served(port=0):
    return watching("the page of /peg_on_hole: ", "--port", str(port))


class Live:
    """A node that plays, and what it has published."""

    def __init__(self):
        self.running = node_process("-p", f"monitor.jamming_warn:={WARN}")
        self.node = self.running.__enter__()
        self.player = Player("/wrench", "/joint_states", self.node)

    def play(self, bag=BAG, rate=1.0):
        self.player.wait_for_node()
        self.player.play(Bag(bag), rate)

    def published(self, topic):
        return [
            deserialize_message(payload, JointState)
            for name, _, _, payload in self.player.received
            if name == PREFIX + topic
        ]

    def close(self):
        self.player.close()
        self.running.__exit__(None, None, None)


@pytest.fixture(scope="module")
def address():
    with page_served() as found:
        assert found.startswith("http://127.0.0.1:")
        yield found


@pytest.fixture(scope="module")
def live(address):
    # The page is there before the node.
    made = Live()
    try:
        made.play()
        yield made
    finally:
        made.close()


def stream(address, **options):
    return connect(address.replace("http", "ws") + "stream", max_size=None, **options)


def first(address):
    with stream(address) as socket_:
        return json.loads(socket_.recv(timeout=60))


class Shown(Page):
    """The page in a browser."""

    def __init__(self, browser, address, **options):
        super().__init__(browser, address, height=844, **options)

    def wait_for_status(self, text):
        self.page.wait_for_function(
            "(text) => document.querySelector('#status').textContent.includes(text)", arg=text
        )


@pytest.fixture
def shown(browser):
    made = []

    def show(*arguments, **options):
        made.append(Shown(browser, *arguments, **options))
        return made[-1]

    yield show
    for one in made:
        one.context.close()


@pytest.mark.nightly
def test_without_a_node_it_says_so(shown, address):
    page = shown(address)
    page.wait_for_status("no node /peg_on_hole is active: start it, or name another with --node")
    assert page.page.inner_text("#said") == "No estimate yet"
    assert page.complaints == []


# How many pixels of a strip have the colour of a line, nearly.
PIXELS = """([strip, name]) => {
  const canvas = document.querySelector(`[data-strip=${strip}]`);
  const probe = document.createElement("i");
  probe.style.color = `var(--${name})`;
  document.body.append(probe);
  const want = getComputedStyle(probe).color.match(/\\d+/g).slice(0, 3).map(Number);
  probe.remove();
  const data = canvas.getContext("2d").getImageData(0, 16, canvas.width, canvas.height - 16).data;
  let found = 0;
  for (let i = 0; i < data.length; i += 4) {
    found += data[i + 3] > 200 && want.every((c, k) => Math.abs(c - data[i + k]) < 24);
  }
  return found;
}"""


@pytest.mark.parametrize(
    ("width", "scheme"), [(1280, "light"), *nightly((390, "dark"), (1280, "dark"), (390, "light"))]
)
def test_drawing_strips_and_numbers_are_the_node_s(shown, live, address, width, scheme):
    seen = shown(address, width=width, scheme=scheme)
    page = seen.page
    page.wait_for_function("document.querySelector('#said').textContent === 'Three-point contact'")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    for view in ("#side", "#top"):
        assert page.locator(f"{view} .peg").count() == 1
        assert page.locator(f"{view} .head").count() == 3
        assert page.locator(f"{view} .cone").count() == 3
    last = live.published("state")[-1]
    reading = page.inner_text("[data-reading=gamma]")
    assert float(reading.split()[0]) == pytest.approx(1e3 * last.position[0], rel=1e-3)
    for strip, colour in (("tilt", "c0"), ("reactions", "c0"), ("modes", "three_point")):
        assert page.evaluate(PIXELS, [strip, colour]) > 20, strip
    # All has been played: it says that nothing comes any more, and nothing moves.
    seen.wait_for_status("no estimate for")
    # And so do the diagnostics, above the drawing.
    page.wait_for_function(
        "document.querySelector('#banners').textContent.includes('no messages of wrench')"
    )
    name = "_".join(["live", *(["dark"] if scheme == "dark" else []), str(width)])
    assert differing(name, parts(page)) == {}
    assert seen.complaints == []
    assert {url.split("/")[2] for url in seen.requests} == {address.split("/")[2]}


def test_peaks_stay_though_frames_are_few(live, address):
    frames = first(address)["frames"]
    contacts = live.published("contacts")
    assert len(contacts) > 600 and len(frames) < 100
    for i, name in enumerate(("K", "B1", "B2")):
        told = [v for frame in frames for _, v in frame["lines"].get(name, []) if v is not None]
        published = np.array([message.effort[i] for message in contacts])
        assert max(told) == pytest.approx(np.nanmax(published), rel=1e-5)
        assert min(told) == pytest.approx(np.nanmin(published), rel=1e-5, abs=1e-9)
    risks = [m.position[list(m.name).index("jamming_risk")] for m in live.published("monitor")]
    told = [
        v for frame in frames for _, v in frame["lines"].get("jamming_risk", []) if v is not None
    ]
    assert max(told) == pytest.approx(np.nanmax(risks), rel=1e-5)


def test_it_draws_with_the_settings_of_the_node(live, address):
    settings = first(address)["settings"]
    assert settings["jamming_warn"] == WARN
    assert settings["gamma0"] == pytest.approx(np.arccos(0.0499 / 0.05))


def test_frames_come_some_twenty_times_a_second(live, address):
    with stream(address) as socket_:
        socket_.recv(timeout=60)
        got = [json.loads(socket_.recv(timeout=60)) for _ in range(5)]
    assert all(set(frame) >= {"status"} for frame in got)


@pytest.mark.nightly
def test_it_comes_back_by_itself(shown, live):
    with page_served() as address:
        port = int(address.split(":")[-1].strip("/"))
        seen = shown(address)
    seen.wait_for_status("does not answer: has it ended?")
    with page_served(port):
        # It has found the node again, of which nothing comes.
        seen.wait_for_status("no estimate for")
        # Longer than what was played; to stamps of before it the node says nothing.
        live.play(BAG.with_name("working_cycle.mcap"), 4.0)
        seen.page.wait_for_function(
            "document.querySelector('#said').textContent.startsWith('Two-point')"
        )
        assert seen.page.locator("#side .peg").count() == 1
    # A browser says of each attempt in vain that it was one.
    assert all("WebSocket connection to" in text for text in seen.complaints)


def test_what_cannot_be_is_refused_in_a_line(capsys):
    fails(capsys, 2, "--port = 70000 is not within 0 to 65535", "watch", "--port", 70000)
    told = "--node = peg is not the full name of a node, such as /cell/peg_on_hole"
    fails(capsys, 2, told, "watch", "--node", "peg")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        done = command("watch", "--port", port)
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        f"peg-on-hole: error: --port {port} on 127.0.0.1 cannot be had: Address already in use; "
        "name another, or 0 for any that is free"
    ]
