"""A node that is deactivated and activated again, and one whose transitions fail."""

from contextlib import contextmanager

import pytest
import rclpy

from inputs import joints, wrench
from peg_on_hole_ros.edges.live.process import init
from peg_on_hole_ros.edges.messages.cdr import Encoder
from peg_on_hole_ros.edges.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.edges.node import PegOnHoleNode

pytestmark = pytest.mark.xdist_group("dds")

MS = 1_000_000
OK, ERROR = 0, 2


@contextmanager
def configured(*arguments):
    """Give a node in this process that is configured."""
    words = ["--ros-args", *arguments]
    init(words)
    try:
        node = PegOnHoleNode(words)
        node.trigger_configure()
        yield node
        node.close()
        node.destroy_node()
    finally:
        rclpy.shutdown()


def feed(node, *stamps_ms):
    """Let the node work off a joint state and a wrench of each stamp."""
    for t_ms in stamps_ms:
        node.arrivals.joints(Encoder(JOINTS_TYPE)(joints(t_ms * MS)))
        node.arrivals.wrench(Encoder(WRENCH_TYPE)(wrench(t_ms * MS)))
    node.process()


def report(node):
    """Return {status name: (level, message)} of a report now."""
    told, diagnostics = [], node._outputs.diagnostics
    node._outputs.diagnostics = told.append
    node._report()
    node._outputs.diagnostics = diagnostics
    (fields,) = told
    return {
        status["name"].removeprefix("peg_on_hole: "): (status["level"], status["message"])
        for status in fields["status"]
    }


def fail(sample):
    raise RuntimeError("made up")


def test_what_was_lost_before_is_not_reported_again_and_what_no_report_told_is(capfd):
    with configured() as node:
        node.trigger_activate()
        feed(node, 1000)
        feed(node, 1000)
        whole, node._stream.pipeline.on_wrench = node._stream.pipeline.on_wrench, fail
        feed(node, 1001)
        node._stream.pipeline.on_wrench = whole
        assert report(node)["filter"][0] == ERROR
        feed(node, 1002)
        node.arrivals.wrench(b"")
        node.trigger_deactivate()
        told = capfd.readouterr().err
        node.trigger_activate()
        feed(node, 1003)
        status = report(node)
        again = capfd.readouterr().err
        assert node._stream.counts["wrench_dropped_internal_error"] == 1
    assert (status["filter"][0], status["input"][0]) == (OK, OK)
    assert told.count("wrench dropped internal error: 1 times") == 1
    assert told.count("wrench dropped malformed unreadable: 1 times") == 1
    assert "times" not in again
