"""The node over real DDS: lifecycle, parameters, services, diagnostics, sim time."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import rclpy
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.serialization import deserialize_message
from std_srvs.srv import Trigger

from dds_peer import PATIENCE, Peer, node_process, stop
from inputs import closing, joints, wrench
from peg_on_hole_ros.config.parameter_table import PARAMETERS
from peg_on_hole_ros.messages.beside_estimates import DIAGNOSTICS, STRING
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.ros_messages import message_class, to_ros
from peg_on_hole_ros.ros.node import PegOnHoleNode
from peg_on_hole_ros.ros.process import init

pytestmark = pytest.mark.xdist_group("dds")


@pytest.fixture
def peer():
    made = Peer()
    yield made
    made.close()


def send(peer, start_ns, count=40):
    """Publish a stretch of input until estimates come of it."""
    before = len(peer.received["state"])
    peer.joints.publish(to_ros(JOINTS_TYPE, joints(start_ns)))
    stamps = iter(range(start_ns, start_ns + 10_000_000_000, 1_000_000))

    def answered():
        peer.wrench.publish(to_ros(WRENCH_TYPE, wrench(next(stamps))))
        return len(peer.received["state"]) >= before + count

    peer.spin_until(answered, "estimates")


def transition(peer, number):
    request = ChangeState.Request(transition=Transition(id=number))
    return peer.call("change_state", request).success


def set_double(peer, name, value):
    parameter = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
    request = SetParameters.Request(parameters=[Parameter(name=name, value=parameter)])
    return peer.call("set_parameters", request).results[0]


def diagnostics(peer, accept, what):
    """Wait for a report that fits; return it as {status name: (level, message, values)}."""
    found = []

    def arrived():
        while peer.received["/diagnostics"]:
            payload = peer.received["/diagnostics"].pop(0)
            array = deserialize_message(payload, message_class(DIAGNOSTICS))
            report = {
                status.name.removeprefix("peg_on_hole: "): (
                    status.level[0],
                    status.message,
                    {item.key: item.value for item in status.values},
                )
                for status in array.status
            }
            if accept(report):
                found.append(report)
        return found

    peer.spin_until(arrived, what)
    return found[0]


def test_lifecycle_by_hand(peer):
    with node_process("-p", "autostart:=false") as process:
        assert peer.state() == State.PRIMARY_STATE_UNCONFIGURED
        # Before it is configured, parameters may change; checked as at the start.
        assert set_double(peer, "scene.friction", 0.3).successful
        refused = set_double(peer, "scene.friction", 30.0)
        assert not refused.successful
        assert refused.reason.startswith("scene.friction = 30 is not within 0 to 2")

        assert transition(peer, Transition.TRANSITION_CONFIGURE)
        assert peer.state() == State.PRIMARY_STATE_INACTIVE
        answer = peer.call("tare", Trigger.Request())
        assert (answer.success, answer.message) == (False, "the node is not active")
        refused = set_double(peer, "scene.friction", 0.2)
        assert not refused.successful
        assert "deactivate and clean up the node first" in refused.reason

        assert transition(peer, Transition.TRANSITION_ACTIVATE)
        peer.wait_for_matching()
        send(peer, 1_000_000_000)

        assert transition(peer, Transition.TRANSITION_DEACTIVATE)
        peer.spin_until(lambda: not peer.wrench.get_subscription_count(), "end of listening")
        assert transition(peer, Transition.TRANSITION_CLEANUP)
        assert peer.state() == State.PRIMARY_STATE_UNCONFIGURED
        # A second life begins with earlier stamps and no memory of the first.
        assert transition(peer, Transition.TRANSITION_CONFIGURE)
        assert transition(peer, Transition.TRANSITION_ACTIVATE)
        peer.wait_for_matching()
        send(peer, 500_000_000)
        assert "Traceback" not in stop(process)


def test_diagnostics_count_what_is_discarded_and_why(peer):
    with node_process() as process:
        peer.wait_for_matching()
        report = diagnostics(peer, lambda report: True, "first report")
        level, text, _ = report["input"]
        assert level == 1 and text.startswith("no messages of wrench and joints: check topic")
        send(peer, 2_000_000_000)
        peer.joints.publish(to_ros(JOINTS_TYPE, joints(2_100_000_000) | {"name": ["gamma"]}))
        key = "joints_dropped_malformed_length_mismatch"
        report = diagnostics(peer, lambda report: key in report["input"][2], "the malformed one")
        assert report["input"][2][key] == "1"
        report = diagnostics(peer, lambda report: True, "one more report")
        assert report["input"][2][key] == "1"
        assert "load" in report["timing"][2]
        text = stop(process)
        line = "joints dropped malformed length mismatch: 1 time"
        assert text.count(line) == 1
        assert "sim_time" not in text


@pytest.mark.nightly
def test_sim_time_without_clock_is_said_and_estimates_go_on(peer):
    with node_process("-p", "use_sim_time:=true") as process:
        peer.wait_for_matching()
        send(peer, 3_000_000_000)
        diagnostics(peer, lambda report: "stamp_age_s" not in report["timing"][2], "a report")
        diagnostics(peer, lambda report: True, "one more report")
        assert stop(process).count("use_sim_time is set, but no /clock has come") == 1


def test_sigterm_ends_it_cleanly_with_a_record_of_the_try_under_way(peer):
    with node_process() as process:
        peer.wait_for_matching()
        send(peer, 4_000_000_000, 80)
        process.send_signal(signal.SIGTERM)
        text, _ = process.communicate(timeout=PATIENCE)
        assert process.returncode == 0
    assert cycles(text) == ["unfinished"]


@pytest.mark.nightly
@pytest.mark.parametrize("end", ["cleanup", "shutdown", "inactive shutdown"])
def test_a_try_that_a_transition_ends_is_published(peer, end):
    with node_process() as process:
        peer.wait_for_matching()
        send(peer, 5_000_000_000, 80)
        assert peer.received["cycle"] == []
        if end != "shutdown":
            assert transition(peer, Transition.TRANSITION_DEACTIVATE)
        numbers = {
            "cleanup": Transition.TRANSITION_CLEANUP,
            "shutdown": Transition.TRANSITION_ACTIVE_SHUTDOWN,
            "inactive shutdown": Transition.TRANSITION_INACTIVE_SHUTDOWN,
        }
        assert transition(peer, numbers[end])
        peer.spin_until(lambda: peer.received["cycle"], "the record of the try")
        text = stop(process)
    (payload,) = peer.received["cycle"]
    told = deserialize_message(payload, message_class(STRING)).data
    # The log has the same line, and once.
    assert re.findall("cycle: (.*)", text) == [told]
    assert cycles(text) == ["unfinished"]


def cycles(text):
    """Return the outcomes of the tries that were logged."""
    return [json.loads(line)["outcome"] for line in re.findall("cycle: (.*)", text)]


@pytest.mark.parametrize("end", ["close", "trigger_deactivate", "trigger_shutdown"])
def test_what_waits_at_the_end_is_worked_off(end, capfd):
    init(["--ros-args"])
    try:
        node = PegOnHoleNode([])
        node.trigger_configure()
        node.trigger_activate()
        encode = {"wrench": Encoder(WRENCH_TYPE), "joints": Encoder(JOINTS_TYPE)}
        for source, message in closing(200):
            getattr(node.arrivals, source)(encode[source](message))
        getattr(node, end)()
        assert not node.arrivals
        node.close()
        node.destroy_node()
    finally:
        rclpy.shutdown()
    assert cycles(capfd.readouterr().err) == ["unfinished"]


@pytest.mark.nightly
def test_all_parameters_of_the_table_are_declared(peer):
    with node_process("-p", "autostart:=false"):
        assert peer.state() == State.PRIMARY_STATE_UNCONFIGURED
        names = [row.name for row in PARAMETERS]
        request = GetParameters.Request(names=names)
        answer = peer.ask("get_parameters", request)
        kinds = {
            "bool": ParameterType.PARAMETER_BOOL,
            "integer": ParameterType.PARAMETER_INTEGER,
            "double": ParameterType.PARAMETER_DOUBLE,
            "string": ParameterType.PARAMETER_STRING,
            "double[]": ParameterType.PARAMETER_DOUBLE_ARRAY,
            "string[]": ParameterType.PARAMETER_STRING_ARRAY,
        }
        found = {name: value.type for name, value in zip(names, answer.values)}
        assert found == {row.name: kinds[row.type] for row in PARAMETERS}


def test_nothing_is_compiled_once_the_node_is_warm():
    # In a process of its own: here other tests may have compiled already.
    # Overloads are counted, since one that is loaded from the cache is not compiled.
    script = """
import gc
from numba.core.dispatcher import Dispatcher
from inputs import closing
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.messages.warm_up import warm
from peg_on_hole_ros.config.options import Configuration

def overloads():
    found = (item for item in gc.get_objects() if isinstance(item, Dispatcher))
    # What compiled code calls is counted apart from what Python calls by the same name.
    return {(item.py_func.__qualname__, type(item)): len(item.overloads) for item in found}

warm(Configuration())
before = overloads()
assert sum(before.values()) > 0
stream = message_stream(Configuration())
for source, message in closing(1000):
    (stream.on_joints if source == "joints" else stream.on_wrench)(message)
assert stream.counts["wrench_used"] > 900
assert stream.pipeline.health and stream.pipeline.causes is not None
after = overloads()
assert after == before, {name for name in after if after[name] != before.get(name)}
"""
    here = str(Path(__file__).parents[1])
    path = os.pathsep.join([here, *filter(None, sys.path)])
    run = subprocess.run(
        [sys.executable, "-c", script],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
