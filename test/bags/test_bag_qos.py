"""Latched topics of an output are played as the node publishes them; read by rosbags."""

import pytest
import yaml
from rclpy.qos import (
    DurabilityPolicy,
    Duration,
    HistoryPolicy,
    LivelinessPolicy,
    ReliabilityPolicy,
)

from peg_on_hole_ros.bags.writer import LATCHED_QOS
from peg_on_hole_ros.cli.main import main
from small_bags import write_bag

rosbag2 = pytest.importorskip("rosbags.rosbag2")


@pytest.fixture(scope="module")
def profiles(tmp_path_factory):
    """QoS profiles by topic of a replay's output."""
    folder = tmp_path_factory.mktemp("qos")
    bag, out = write_bag(folder / "a.mcap", count=50), folder / "out.mcap"
    assert main(["replay", str(bag), "--out", str(out)]) == 0
    with rosbag2.Reader(out) as reader:
        return {c.topic: c.ext.offered_qos_profiles for c in reader.connections}


@pytest.mark.parametrize("topic", ["transition", "contact_mode", "alarm_level"])
def test_latched_topics_are_kept_for_late_subscribers(profiles, topic):
    (profile,) = profiles[f"/peg_on_hole/{topic}"]
    assert profile.durability.name == "TRANSIENT_LOCAL"
    assert profile.reliability.name == "RELIABLE"
    assert (profile.history.name, profile.depth) == ("KEEP_LAST", 1)
    assert profile.liveliness.name == "AUTOMATIC"


def test_streams_are_played_with_the_players_own_profile(profiles):
    assert len(profiles) == 15
    assert [topic for topic, found in profiles.items() if found] == [
        "/peg_on_hole/transition",
        "/peg_on_hole/contact_mode",
        "/peg_on_hole/alarm_level",
    ]


def test_numbers_are_those_of_ros():
    # Humble reads only the numbers, so a wrong one would be another policy without a word.
    (profile,) = yaml.safe_load(LATCHED_QOS)
    assert profile["history"] == HistoryPolicy.KEEP_LAST
    assert profile["reliability"] == ReliabilityPolicy.RELIABLE
    assert profile["durability"] == DurabilityPolicy.TRANSIENT_LOCAL
    assert profile["liveliness"] == LivelinessPolicy.AUTOMATIC
    for name in ("deadline", "lifespan", "liveliness_lease_duration"):
        ns = profile[name]["sec"] * 10**9 + profile[name]["nsec"]
        assert ns == Duration(nanoseconds=2**63 - 1).nanoseconds
