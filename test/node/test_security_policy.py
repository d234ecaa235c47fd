"""The SROS2 policy lets the node do all that it does, and nothing that it does not."""

from time import monotonic, sleep
from xml.etree import ElementTree

import pytest

from dds_peer import Peer, node_process, stop
from simulated import ROOT

pytestmark = pytest.mark.xdist_group("dds_starts")
# Opened where the settings or the installation ask for it.
AT_TIMES = {
    "/tf", "/tf_static", "/clock", "/robot_description", "/parameter_events",
    "/peg_on_hole/get_type_description",
}  # fmt: skip


def allowed(kind, action):
    policy = ElementTree.parse(ROOT / "config" / "sros2_policy.xml")
    (profile,) = policy.iter("profile")
    assert profile.attrib == {"ns": "/", "node": "peg_on_hole"}
    names = [
        entry.text for group in profile.findall(f"{kind}[@{action}='ALLOW']") for entry in group
    ]
    return {
        name.replace("~", "/peg_on_hole") if name.startswith("~") else f"/{name}" for name in names
    }


def topics(node, ends):
    """Return the topics at which the node has an end; another of its name may be leaving."""
    named = (name for name, _ in node.get_topic_names_and_types())
    full = "/", "peg_on_hole"
    return {
        name
        for name in named
        if any((end.node_namespace, end.node_name) == full for end in ends(name))
    }


def test_policy_is_what_the_node_opens():
    peer = Peer()
    try:
        with node_process() as process:
            peer.wait_for_matching()
            node = peer.node
            of = "/peg_on_hole/"
            opened = {
                ("topics", "publish"): lambda: topics(node, node.get_publishers_info_by_topic),
                ("topics", "subscribe"): lambda: topics(
                    node, node.get_subscriptions_info_by_topic
                ),
                ("services", "reply"): lambda: {
                    name for name, _ in node.get_service_names_and_types() if name.startswith(of)
                },
            }
            for (kind, action), found in opened.items():
                # What a node opens becomes known to another one by one.
                names, ends = set(), monotonic() + 60.0
                while allowed(kind, action) - names - AT_TIMES and monotonic() < ends:
                    sleep(0.1)
                    names = found()
                assert len(names) >= 2
                assert names - allowed(kind, action) == set()
                assert allowed(kind, action) - names - AT_TIMES == set()
            assert node.get_client_names_and_types_by_node("peg_on_hole", "/") == []
            stop(process)
    finally:
        peer.close()
