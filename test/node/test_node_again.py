"""A node that is activated again, one whose transitions fail, and one whose disk is full."""

import os
from contextlib import contextmanager
from math import isnan

import pytest
import rclpy
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from dds_peer import PATIENCE, node_process
from inputs import closing, hanging, joints
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.ros.node import PegOnHoleNode
from peg_on_hole_ros.ros.process import init
from tiers import nightly

pytestmark = pytest.mark.xdist_group("dds_starts")

MS = 1_000_000
OK, ERROR = 0, 2
ENCODE = {"wrench": Encoder(WRENCH_TYPE), "joints": Encoder(JOINTS_TYPE)}


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
        node.arrivals.joints(ENCODE["joints"](joints(t_ms * MS)))
        node.arrivals.wrench(ENCODE["wrench"](hanging(t_ms * MS)))
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
        whole, node._stream.pipeline.take_wrench = node._stream.pipeline.take_wrench, fail
        feed(node, 1001)
        node._stream.pipeline.take_wrench = whole
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
    assert told.count("wrench dropped internal error: 1 time") == 1
    assert told.count("wrench dropped malformed unreadable: 1 time") == 1
    assert "times" not in again


@pytest.mark.parametrize("topic", ["topics.wrench", *nightly("topics.joint_states")])
def test_an_activation_that_fails_says_why_and_leaves_nothing(topic, capfd):
    # ROS 2 has one type for a topic, and this one is an output's.
    with configured("-p", f"{topic}:=/peg_on_hole/pose") as node:
        assert node.trigger_activate() != TransitionCallbackReturn.SUCCESS
        assert state(node) == "unconfigured"
        assert "cannot activate: " in (told := capfd.readouterr().err)
        assert "/peg_on_hole/pose" in told
        made = [*node.subscriptions, *node.services, *node.timers]
        assert not [one for one in made if named(one) in ("/wrench", "~/reset", "~/tare", None)]
        # Nothing stands in the way of a remedy.
        default = f"/{topic.removeprefix('topics.')}"
        (answer,) = node.set_parameters([Parameter(topic, value=default)])
        assert answer.successful, answer.reason
        assert node.trigger_configure() == TransitionCallbackReturn.SUCCESS
        assert node.trigger_activate() == TransitionCallbackReturn.SUCCESS


def monitored(node, *stamps_ms):
    """Return the values that exist on ~/monitor after a joint state and a wrench of each stamp."""
    told, publish = [], node._outputs.publish
    node._outputs.publish = told.append
    feed(node, *stamps_ms)
    node._outputs.publish = publish
    last = deserialize_message(dict(told[-1].estimate)["monitor"], JointState)
    values = zip(last.name, last.position, strict=True)
    return {name: value for name, value in values if not isnan(value)}


def test_a_cleanup_forgets_a_tare_and_a_deactivation_does_not():
    with configured() as node:
        node.trigger_activate()
        assert "bias_force_x" not in monitored(node, *range(1000, 1150))
        answer = node._service("tare")(None, Trigger.Response())
        assert answer.success, answer.message
        assert "bias_force_x" in monitored(node, 1150)
        node.trigger_deactivate()
        node.trigger_activate()
        assert "bias_force_x" in monitored(node, 1151)
        node.trigger_deactivate()
        node.trigger_cleanup()
        node.trigger_configure()
        node.trigger_activate()
        assert "bias_force_x" not in monitored(node, 1152, 1153)


def state(node):
    return node._state_machine.current_state[1]


def named(one):
    return getattr(one, "topic", None) or getattr(one, "srv_name", None)


@pytest.mark.nightly
def test_a_node_that_cannot_be_activated_ends_with_a_word():
    with node_process("-p", "topics.wrench:=/peg_on_hole/pose") as process:
        text, _ = process.communicate(timeout=PATIENCE)
        assert process.returncode == 2
    assert "cannot activate: " in text


@pytest.mark.parametrize(
    "end", ["trigger_cleanup", *nightly("trigger_deactivate", "trigger_shutdown")]
)
def test_an_error_at_an_end_is_said_and_leaves_nothing(end, capfd):
    with configured() as node:
        if end != "trigger_cleanup":
            node.trigger_activate()
        failures = [RuntimeError("made up")]
        node.arrivals.take = lambda: raised(failures)
        getattr(node, end)()
        assert not failures
        assert state(node) == "unconfigured"
        name = end.removeprefix("trigger_")
        assert f"cannot {name}: RuntimeError('made up')" in capfd.readouterr().err
        assert not [one for one in node.services if named(one) in ("~/reset", "~/tare")]


def raised(errors):
    """Raise each error once."""
    if errors:
        raise errors.pop()
    return []


@pytest.mark.parametrize("end", ["close", *nightly("trigger_cleanup", "trigger_shutdown")])
def test_a_disk_that_is_full_at_the_end_of_a_record_costs_the_record_alone(end, tmp_path, capfd):
    path = tmp_path / "arrivals.mcap"
    with configured("-p", f"record_arrivals:={path}") as node:
        node.trigger_activate()
        for source, message in closing(80):
            getattr(node.arrivals, source)(ENCODE[source](message))
        node.process()
        fill_disk(node)
        if end == "trigger_cleanup":
            node.trigger_deactivate()
        answer = getattr(node, end)()
        told = capfd.readouterr().err
        assert answer in (None, TransitionCallbackReturn.SUCCESS)
        assert (node._outputs is None) == (end != "close")
    assert f"recording to {path} ended: No space left on device" in told
    assert '"outcome": "unfinished"' in told


def test_a_disk_that_fills_up_ends_the_record_and_not_the_node(tmp_path, capfd):
    path = tmp_path / "arrivals.mcap"
    with configured("-p", f"record_arrivals:={path}") as node:
        node.trigger_activate()
        fill_disk(node)
        for source, message in closing(400):
            getattr(node.arrivals, source)(ENCODE[source](message))
            if source == "wrench":
                node.process()
        counts = node._stream.counts
    assert counts["wrench_used"] == 400 and "reset" not in counts
    told = capfd.readouterr().err
    assert told.count(f"recording to {path} ended: No space left on device") == 1


def test_what_is_stated_by_half_is_told(capfd):
    with configured("-p", "wrench.bias_torque_stddev:=0.01"):
        pass
    assert "unless the bias of the forces is known" in capfd.readouterr().err


def fill_disk(node):
    """Let nothing more be written to the record."""
    with open("/dev/full", "wb") as full:
        os.dup2(full.fileno(), node._recording._record._stream.fileno())


def test_what_a_change_throws_refuses_it_and_leaves_the_node_as_it_was(monkeypatch):
    with configured() as node:
        gates = node.get_parameter("filter.gate_threshold").value
        taken, retune = [], node._stream.pipeline.retune

        def throws_once(configuration, orientation):
            taken.append(configuration.filter.gate_threshold)
            if len(taken) == 1:
                raise OverflowError("cannot convert float infinity to integer")
            retune(configuration, orientation)

        monkeypatch.setattr(node._stream.pipeline, "retune", throws_once)
        answer = node.set_parameters_atomically([Parameter("filter.gate_threshold", value=60.0)])
        assert not answer.successful and "cannot convert float infinity" in answer.reason
        # What it had taken of the change by then is put back, in the node as in its stream.
        assert node.get_parameter("filter.gate_threshold").value == gates
        assert taken == [60.0, gates]
        answer = node.set_parameters_atomically([Parameter("filter.gate_threshold", value=70.0)])
        assert answer.successful and taken[-1] == 70.0
