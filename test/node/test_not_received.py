"""Messages that were sent and never came are counted, over real DDS and by numbers alone."""

import time

import pytest
import rclpy

from dds_peer import PATIENCE
from inputs import joints, wrench
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.ros_messages import message_class, to_ros
from peg_on_hole_ros.ros import process
from peg_on_hole_ros.ros.inputs import Numbered
from peg_on_hole_ros.ros.node import PegOnHoleNode

MS = 1_000_000
MESSAGES = {"wrench": (WRENCH_TYPE, wrench), "joints": (JOINTS_TYPE, joints)}


@pytest.mark.xdist_group("dds")
@pytest.mark.parametrize("executor", ["EventsExecutor", "SingleThreadedExecutor"])
def test_what_dds_lets_go_of_is_counted(executor):
    arguments = ["--ros-args", "-p", "qos_depth:=5"]
    process.init(arguments)
    try:
        node = PegOnHoleNode(arguments)
        node.trigger_configure()
        node.trigger_activate()
        publishers = {
            source: node.create_publisher(message_class(kind), topic, 100)
            for (source, (kind, _)), topic in zip(MESSAGES.items(), ("/wrench", "/joint_states"))
        }
        chosen = rclpy.experimental if executor == "EventsExecutor" else rclpy.executors
        turns = getattr(chosen, executor)()
        turns.add_node(node)

        def spin_until(done):
            end = time.monotonic() + PATIENCE
            while not done():
                assert time.monotonic() < end, node._stream.counts
                turns.spin_once(timeout_sec=0.02)
                node.process()

        spin_until(lambda: all(p.get_subscription_count() for p in publishers.values()))
        for count in (1, 50):
            for source in ("joints", "wrench"):
                made = MESSAGES[source][1]
                for t_ms in range(count, 2 * count):
                    publishers[source].publish(to_ros(MESSAGES[source][0], made(t_ms * MS)))
            # The last of each stays in its queue, so that all before it are known to be missing.
            expected = 1 if count == 1 else 51
            spin_until(lambda n=expected: arrived(node, n))
        counts = node._stream.counts
        turns.shutdown()
        node.close()
        node.destroy_node()
    finally:
        rclpy.shutdown()
    for source in MESSAGES:
        assert counts[f"{source}_dropped_not_received"] == 45


def arrived(node, sent):
    """Return whether every message of both topics has come or is known to be missing."""
    missing = sum(n for name, n in node._stream.counts.items() if name.endswith("not_received"))
    return node.arrivals.received + missing == 2 * sent


def known(number, publisher=b"a"):
    given = {"publication_sequence_number": number}
    return given | ({"publisher_gid": {"data": publisher}} if publisher else {})


def counted(rows, alone=True):
    """Return what is taken and how many are missing of messages with what is known of them."""
    taken, missing = [], []
    numbered = Numbered(taken.append, missing.append, lambda: alone)
    for row in rows:
        numbered(b"", row)
    assert len(taken) == len(rows)
    return missing


def test_each_publisher_counts_for_itself_and_may_have_begun_before():
    rows = [known(7), known(100, b"b"), known(8), known(103, b"b"), known(12)]
    assert counted(rows) == [2, 3]
    # One that begins anew, and a message that comes twice.
    assert counted([known(7), known(1), known(1), known(2)]) == []


def test_without_names_the_numbers_of_several_count_nothing():
    rows = [known(7, b""), known(100, b""), known(8, b"")]
    assert counted(rows) == [92] and counted(rows, alone=False) == []
    assert counted([known(None), known(None), {}]) == []
