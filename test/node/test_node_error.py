"""An error in the program itself does not end the node: it is counted, told, and left behind."""

import pytest
import rclpy
from rclpy.serialization import deserialize_message
from std_srvs.srv import Trigger

from dds_peer import Peer, node_process, stop
from inputs import joints, wrench
from peg_on_hole_ros.bags.arrival_record import EVENT_TOPIC
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.messages.beside_estimates import DIAGNOSTICS
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.ros_messages import message_class, to_ros
from peg_on_hole_ros.ros.node import PegOnHoleNode
from peg_on_hole_ros.ros.process import init
from tiers import nightly

pytestmark = pytest.mark.xdist_group("dds")

MS = 1_000_000
BAD_NS = range(5_100 * MS, 5_103 * MS)
# The node with a pipeline that three wrenches and a tare make fail.
PROGRAM = f"""
from peg_on_hole_ros.ros.node import main
from peg_on_hole_ros.engine.pipeline import Pipeline

def take_wrench(self, sample, whole=Pipeline.take_wrench):
    if {BAD_NS.start} <= sample.t_ns < {BAD_NS.stop}:
        raise RuntimeError("made up")
    return whole(self, sample)

def tare(self):
    raise ZeroDivisionError("made up too")

Pipeline.take_wrench, Pipeline.tare = take_wrench, tare
main()
"""


def estimates(peer, start_ns, count=20):
    """Publish a stretch of input until estimates come of it."""
    before = len(peer.received["state"])
    peer.joints.publish(to_ros(JOINTS_TYPE, joints(start_ns)))
    stamps = iter(range(start_ns, start_ns + 90 * MS, MS))

    def answered():
        if (t_ns := next(stamps, None)) is not None:
            peer.wrench.publish(to_ros(WRENCH_TYPE, wrench(t_ns)))
        return len(peer.received["state"]) >= before + count

    peer.spin_until(answered, "estimates")


def reports(peer, name):
    """Return (level, message, values) of all /diagnostics so far."""
    for payload in peer.received["/diagnostics"]:
        array = deserialize_message(payload, message_class(DIAGNOSTICS))
        for status in array.status:
            if status.name == f"peg_on_hole: {name}":
                values = {item.key: item.value for item in status.values}
                yield status.level[0], status.message, values


def test_an_error_costs_the_estimate_and_not_the_node(tmp_path):
    path, peer = tmp_path / "arrivals.mcap", Peer()
    with node_process("-p", f"record_arrivals:={path}", program=("-c", PROGRAM)) as process:
        peer.wait_for_matching()
        estimates(peer, 5_000 * MS)
        for t_ns in BAD_NS[::MS]:
            peer.wrench.publish(to_ros(WRENCH_TYPE, wrench(t_ns)))
        key = "wrench_dropped_internal_error"
        peer.spin_until(
            lambda: any(values.get(key) == "3" for _, _, values in reports(peer, "input")),
            "three errors",
        )
        told = [message for level, message, _ in reports(peer, "filter") if level == 2]
        assert told and all(
            message
            == "an error of the program: the filter was restarted, its log has the traceback"
            for message in told
        )
        estimates(peer, 5_200 * MS)
        answer = peer.call("tare", Trigger.Request())
        assert (answer.success, answer.message) == (
            False,
            "an error of the program: ZeroDivisionError('made up too'); the filter was restarted",
        )
        peer.received["/diagnostics"].clear()
        estimates(peer, 5_300 * MS)
        peer.spin_until(
            lambda: any(level == 0 for level, _, _ in reports(peer, "filter")), "a good report"
        )
        text = stop(process)
    peer.close()
    assert text.count("Traceback") == 1 and text.count("RuntimeError: made up\n") == 1
    assert "[ERROR]" in text[: text.index("Traceback")].splitlines()[-1]
    assert "wrench dropped internal error: 3 times" in text
    # What restarted the filter is part of what arrived.
    events = [event.message.data for event in Bag(path).messages([EVENT_TOPIC])]
    assert events == ["reset", "reset", "reset", "tare", "reset"]


@pytest.mark.parametrize("stop", [KeyboardInterrupt, *nightly(SystemExit)])
def test_what_is_to_end_the_program_does(stop):
    def take_wrench(sample):
        raise stop

    init([])
    try:
        node = PegOnHoleNode([])
        node.trigger_configure()
        node.trigger_activate()
        node._stream.pipeline.take_wrench = take_wrench
        node.arrivals.joints(Encoder(JOINTS_TYPE)(joints(MS)))
        node.arrivals.wrench(Encoder(WRENCH_TYPE)(wrench(MS)))
        with pytest.raises(stop):
            node.process()
        node.close()
        node.destroy_node()
    finally:
        rclpy.shutdown()


def test_an_error_in_the_diagnostics_is_told_and_ends_nothing(capfd):
    def report(*_):
        raise ZeroDivisionError("made up as well")

    init([])
    try:
        node = PegOnHoleNode([])
        node.trigger_configure()
        node.trigger_activate()
        node._diagnostics.report = report
        node._report()
        node.close()
        node.destroy_node()
    finally:
        rclpy.shutdown()
    text = capfd.readouterr().err
    assert "an error of the program at the diagnostics: ZeroDivisionError('made up" in text
    assert text.count("Traceback") == 1
