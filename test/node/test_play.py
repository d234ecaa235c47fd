"""`peg-on-hole play`: who listens gets the bag's messages, byte for byte and at their pace."""

import signal
import subprocess
import sys
import time

import pytest
from rclpy.qos import QoSProfile

from dds_peer import Peer
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.ros_messages import message_class
from simulated import ROOT

pytestmark = pytest.mark.xdist_group("dds")
BAG = ROOT / "bags" / "closing_with_slip.mcap"
TOPICS = {"/wrench": WRENCH_TYPE, "/joint_states": JOINTS_TYPE}


def played(*options):
    """Start the command."""
    command = [sys.executable, "-m", "peg_on_hole_ros.cli.main", "play", str(BAG), *options]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


@pytest.fixture
def taken():
    """Return a peer and what comes on each topic."""
    peer, got = Peer(), {topic: [] for topic in TOPICS}
    for topic, ros_type in TOPICS.items():
        peer.node.create_subscription(
            message_class(ros_type), topic, got[topic].append, QoSProfile(depth=20_000), raw=True
        )
    yield peer, got
    peer.close()


def test_what_is_played_is_what_was_recorded(taken):
    peer, got = taken
    recorded = {topic: [] for topic in TOPICS}
    for message, payload in Bag(BAG).with_payloads(TOPICS):
        recorded[message.topic].append(bytes(payload))
    process = played("--rate", "0.5")
    try:
        peer.spin_until(lambda: process.poll() is not None, "the end of playing")
    finally:
        process.kill()
    text, _ = process.communicate()
    assert process.returncode == 0, text
    for topic, payloads in recorded.items():
        assert got[topic] == payloads
    assert f"played {sum(map(len, recorded.values()))} messages" in text


def test_it_begins_where_it_is_told_and_goes_on_until_it_is_ended(taken):
    peer, got = taken
    wrenches = [payload for _, payload in Bag(BAG).with_payloads(["/wrench"])]
    begun = time.monotonic()
    process = played("--start", "0.3", "--loop")
    try:
        peer.spin_until(lambda: len(got["/wrench"]) > 1.5 * len(wrenches), "a second turn")
        process.send_signal(signal.SIGINT)
        peer.spin_until(lambda: process.poll() is not None, "the end")
    finally:
        process.kill()
    text, _ = process.communicate()
    assert process.returncode == 130 and "round 2 begins" in text and "Traceback" not in text
    left = len(wrenches) - wrenches.index(bytes(got["/wrench"][0]))
    assert got["/wrench"][left] == got["/wrench"][0]
    # At the pace of the recording: no sooner than what it lasts.
    assert time.monotonic() - begun > 1e-3 * len(got["/wrench"])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--rate", "20"], "--rate = 20 is not within 0.01 to 10"),
        (["--start", "100"], "--start = 100 s is not within the recording: 0 to below 0.666 s"),
        (["--start", "-1"], "--start = -1 s is not within"),
        (["--wrench-topic", "/none"], "/none"),
    ],
)
def test_what_cannot_be_played_is_refused(options, said, capsys):
    assert main(["play", str(BAG), *options]) in (2, 3)
    assert said in capsys.readouterr().err
