"""More publish on a topic of the node than should."""

import inspect

import pytest
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.serialization import deserialize_message

from dds_peer import Peer, node_process, stop, wait_until
from inputs import joints, wrench
from peg_on_hole_ros.messages.beside_estimates import DIAGNOSTICS
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.cdr_layout import stamp_ns
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.ros_messages import message_class
from peg_on_hole_ros.ros.diagnostics import Diagnostics
from peg_on_hole_ros.ros.node import PegOnHoleNode
from peg_on_hole_ros.ros.process import init

pytestmark = pytest.mark.xdist_group("dds")

MS = 1_000_000
ALONE = "published by this node alone"


@pytest.mark.parametrize("remapped", [[], ["-r", "/wrench:=/ft"]])
def test_wrenches_of_two_are_told_while_they_come(remapped):
    arguments = ["--ros-args", *remapped]
    init(arguments)
    try:
        node = PegOnHoleNode(arguments)
        node.trigger_configure()
        node.trigger_activate()
        told, topic = [], "/ft" if remapped else "/wrench"
        node._outputs.diagnostics = told.append
        for count in (1, 2):
            node.create_publisher(message_class(WRENCH_TYPE), topic, 1)
            node.arrivals.joints(Encoder(JOINTS_TYPE)(joints(count * MS)))
            node.arrivals.wrench(Encoder(WRENCH_TYPE)(wrench(count * MS)))
            node.process()
            node._report()
        node.close()
        node.destroy_node()
    finally:
        rclpy.shutdown()
    found = [fields["status"][0] for fields in told]
    assert [(status["level"], status["message"]) for status in found] == [
        (0, "all messages used"),
        (1, "2 publish on the topic of the wrench, which has to be one sensor's"),
    ]


def output(report):
    """Return (level, begin of the message) of who publishes the outputs."""
    (status,) = [s for s in report["status"] if s["name"] == "peg_on_hole: output"]
    return status["level"], status["message"]


def test_a_second_node_of_the_name_is_logged_once_each_time_it_comes():
    here = [1]
    diagnostics = Diagnostics(output_publishers=lambda: here[-1])
    found = []
    # No publisher is known yet, alone, two, still two, three, one that leaves, alone, again two.
    for count in (0, 1, 2, 2, 3, 2, 1, 2):
        here.append(count)
        for source in ("wrench", "joints"):
            diagnostics.received(source, 1)
        report, lines = diagnostics.report(0, 10**9, {}, {})
        found.append((*output(report), lines))
    told = [lines for *_, lines in found]
    assert [len(lines) for lines in told] == [0, 0, 1, 0, 1, 0, 0, 1]
    assert [line[:2] for lines in told for line in lines] == ["2 ", "3 ", "2 "]
    assert [level for level, *_ in found] == [0, 0, 1, 1, 1, 1, 0, 1]
    assert {text for level, text, _ in found if level == 0} == {ALONE}


@pytest.mark.nightly
def test_two_nodes_of_one_name_tell_of_each_other():
    peer = Peer()

    def told(expected):
        """Wait until the last two reports, of whomever, are so, and new."""
        peer.received["/diagnostics"].clear()

        def arrived():
            texts = []
            for payload in peer.received["/diagnostics"][-2:]:
                array = deserialize_message(payload, message_class(DIAGNOSTICS))
                texts += [s.message for s in array.status if s.name == "peg_on_hole: output"]
            return len(texts) == 2 and all(text.startswith(expected) for text in texts)

        peer.spin_until(arrived, expected)

    try:
        with node_process() as first, node_process() as second:
            told("2 publish on the topics of this node")
            stop(second)
            told(ALONE)
            log = stop(first)
    finally:
        peer.close()
    assert log.count("2 publish on the topics of this node: another of its name") == 1


def test_what_nobody_listens_to_is_not_given_to_dds():
    """The numbers of what is published begin with who listens."""
    init([])
    context, came = rclpy.Context(), []
    rclpy.init(context=context)
    listener = rclpy.create_node("listener", context=context)
    executor = EventsExecutor(context=context)
    executor.add_node(listener)
    node = PegOnHoleNode([])

    def feed(first, last):
        for k in range(first, last + 1):
            node.arrivals.joints(Encoder(JOINTS_TYPE)(joints(k * MS)))
            node.arrivals.wrench(Encoder(WRENCH_TYPE)(wrench(k * MS)))
            node.process()

    def take(payload, known):
        came.append((stamp_ns(payload) // MS, known["publication_sequence_number"]))

    def take_pair(given):
        take(*given)

    take_pair.__signature__ = inspect.signature(take)
    try:
        node.trigger_configure()
        node.trigger_activate()
        feed(1, 20)
        listener.create_subscription(
            message_class(JOINTS_TYPE), "/peg_on_hole/state", take_pair, 100, raw=True
        )
        wait_until(
            lambda: (
                node.count_subscribers("/peg_on_hole/state")
                and node._outputs._outputs["state"].get_subscription_count()
            ),
            "the listener to match",
            executor,
        )
        feed(21, 30)
        wait_until(lambda: len(came) == 10, "ten states", executor)
    finally:
        node.close()
        node.destroy_node()
        listener.destroy_node()
        rclpy.shutdown(context=context)
        rclpy.shutdown()
    assert came == [(20 + k, k) for k in range(1, 11)]
