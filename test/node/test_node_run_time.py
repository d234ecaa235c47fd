"""What can be set in a node that runs, what its descriptors say, and what a record keeps."""

import json

import pytest
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.serialization import deserialize_message
from std_srvs.srv import Trigger

from dds_peer import Peer, node_process, stop
from peg_on_hole_ros.bags.arrival_record import EVENT_TOPIC
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import CONFIGURATION_METADATA
from peg_on_hole_ros.config.parameter_table import PARAMETERS
from peg_on_hole_ros.messages.ros_messages import message_class
from peg_on_hole_ros.replay.run import replay_bag, stored_configuration
from simulated import ROOT

MISSED = 100  # wrenches without an estimate, or on their way; half of the node's queue

pytestmark = pytest.mark.xdist_group("dds")


@pytest.fixture
def peer():
    made = Peer()
    yield made
    made.close()


def double(name, value):
    kind = ParameterType.PARAMETER_DOUBLE
    return Parameter(name=name, value=ParameterValue(type=kind, double_value=value))


def put(peer, *parameters):
    answer = peer.call("set_parameters", SetParameters.Request(parameters=list(parameters)))
    return [(result.successful, result.reason) for result in answer.results]


def descriptors(peer):
    names = [row.name for row in PARAMETERS]
    answer = peer.call("describe_parameters", DescribeParameters.Request(names=names))
    return dict(zip(names, answer.descriptors, strict=True))


def pressed():
    """Yield the messages of a peg that is pressed on the rim and closes with slip, as bytes."""
    bag = Bag(ROOT / "bags" / "closing_with_slip.mcap")
    for item, payload in bag.with_payloads(["/wrench", "/joint_states"]):
        yield "wrench" if item.topic == "/wrench" else "joints", bytes(payload)


def publish(peer, messages):
    """Publish messages no faster than the node takes them, but for what its queue holds."""
    states, sent = peer.received["state"], len(peer.received["state"])
    for source, message in messages:
        if source == "joints":
            peer.joints.publish(message)
            continue
        peer.wrench.publish(message)
        sent += 1
        # The first wrenches may come before the first joint state, and give none.
        peer.spin_until(lambda: len(states) >= sent - MISSED, "estimates")  # noqa: B023


@pytest.mark.nightly
def test_descriptors_say_what_can_be_set(peer):
    with node_process("-p", "autostart:=false") as process:
        assert peer.state() == State.PRIMARY_STATE_UNCONFIGURED
        before = descriptors(peer)
        # What is read when the process starts alone.
        assert [name for name, found in before.items() if found.read_only] == ["autostart"]
        request = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_CONFIGURE))
        assert peer.call("change_state", request).success
        after = descriptors(peer)
        for row in PARAMETERS:
            found = after[row.name]
            # Offered is what is taken, and no more: the present value is set once again.
            assert found.read_only == (not row.live), row.name
            assert (f"[{row.unit}]" in found.description) == bool(row.unit)
            if row.type == "double" and row.low is not None:
                (limits,) = found.floating_point_range
                assert (limits.from_value, limits.to_value) == (row.low, row.high)
                if found.read_only:
                    continue
                (done, reason), (out, why) = put(
                    peer,
                    double(row.name, float(row.default)),
                    double(row.name, row.high * 2.0 + 1.0),
                )
                assert done, reason
                assert not out and why.startswith(f"{row.name} = ") and "is not within" in why
            elif row.choices:
                assert row.choices[0] in found.additional_constraints
        stop(process)


def test_what_cannot_be_set_says_why(peer):
    with node_process() as process:
        peer.wait_for_matching()
        answers = put(
            peer,
            double("scene.frictoin", 0.3),
            double("scene.friction", 0.3),
            double("monitor.jamming_warn", 0.95),
            Parameter(name="markers_rate", value=ParameterValue(type=99)),
            double("qos_overrides./x.depth", 1.0),
        )
        # As small as a double can be: no more markers than one.
        assert put(peer, double("markers_rate", 5e-324)) == [(True, "")]
        stop(process)
    assert [done for done, _ in answers] == [False] * 5
    unknown, fixed, together, untyped, undeclared = (reason for _, reason in answers)
    assert "99 is not a valid" in untyped and "qos_overrides./x.depth" in undeclared
    assert unknown.startswith("unknown parameter 'scene.frictoin'; the nearest are: scene.fri")
    assert fixed.startswith("scene.friction: the estimator is built with it")
    assert "deactivate and clean up the node first" in fixed
    assert together.startswith("monitor.jamming_warn = 0.95 is above monitor.jamming_error = 0.9")


def test_each_service_of_parameters_answers_what_does_not_exist(peer):
    """As the services that rclpy makes: all that is asked for, or nothing."""
    known, absent = ["markers_rate", "scene.friction"], ["markers_rate", "scene.frictoin"]
    doubles = [ParameterType.PARAMETER_DOUBLE] * 2
    with node_process("-p", "autostart:=false") as process:
        assert peer.state() == State.PRIMARY_STATE_UNCONFIGURED
        nothing = Parameter(name="markers_rate", value=ParameterValue())
        alien = Parameter(name="markers_rate", value=ParameterValue(type=255))
        ((done, reason),) = put(peer, nothing)
        assert not done and reason.startswith("markers_rate has no value (null); it is a double")
        for wrong, told in ((nothing, "has no value"), (alien, "255 is not a valid")):
            request = SetParametersAtomically.Request(
                parameters=[double("scene.friction", 0.4), wrong]
            )
            result = peer.call("set_parameters_atomically", request).result
            assert not result.successful and told in result.reason
        for names, types, values in ((known, doubles, [10.0, 0.2]), (absent, [], [])):
            got = peer.call("get_parameters", GetParameters.Request(names=names))
            assert [each.double_value for each in got.values] == values
            kinds = peer.call("get_parameter_types", GetParameterTypes.Request(names=names))
            assert list(kinds.types) == types
            told = peer.call("describe_parameters", DescribeParameters.Request(names=names))
            assert [each.name for each in told.descriptors] == names[: len(values)]
        listed = peer.call("list_parameters", ListParameters.Request(prefixes=["joints"])).result
        assert set(listed.names) == {
            row.name for row in PARAMETERS if row.name.startswith("joints.")
        }
        assert listed.prefixes == ["joints"]
        stop(process)


def test_what_is_set_holds_from_then_on_and_a_replay_takes_it_there(peer, tmp_path):
    path, messages = tmp_path / "arrivals.mcap", list(pressed())
    with node_process("-p", f"record_arrivals:={path}") as process:
        peer.wait_for_matching()
        publish(peer, messages[:500])
        (done,) = put(peer, double("markers_rate", 0.0))
        assert done == (True, "")
        limits = ParameterValue(
            type=ParameterType.PARAMETER_DOUBLE_ARRAY, double_array_value=[1e-3] * 3
        )
        assert put(peer, Parameter(name="monitor.max_normal", value=limits)) == [(True, "")]
        before = len(peer.received["markers"])
        publish(peer, messages[500:800])
        assert len(peer.received["markers"]) == before > 0
        text = stop(process)
    assert "set monitor.max_normal" in text
    levels = [
        {s.name: s.level[0] for s in deserialize_message(p, kind).status}["overload"]
        for kind in [message_class("diagnostic_msgs/msg/DiagnosticArray")]
        for p in peer.received["alarms"]
    ]
    assert levels[0] == 0 and levels[-1] == 2
    bag = Bag(path)
    events = [event.message.data for event in bag.messages([EVENT_TOPIC])]
    assert [json.loads(event.removeprefix("set ")) for event in events] == [
        {"markers_rate": 0.0},
        {"monitor.max_normal": [1e-3] * 3},
    ]

    class Alarms:
        found = []

        def take(self, columns):
            for _, messages in columns.beside:
                self.found += [fields for suffix, _, fields in messages if suffix == "alarms"]

    sink = Alarms()
    assert CONFIGURATION_METADATA in bag.metadata
    replayed = replay_bag(bag, stored_configuration(bag), 10.0, [sink])
    assert replayed.events["settings_changed"] == 2
    told = [{s["name"]: s["level"] for s in fields["status"]}["overload"] for fields in sink.found]
    # What the node had published last has not reached the peer by its end.
    assert len(levels) > 2 and told[: len(levels)] == levels


@pytest.mark.nightly
def test_a_tare_in_contact_is_refused_and_names_the_mode(peer):
    messages = list(pressed())
    with node_process() as process:
        peer.wait_for_matching()
        publish(peer, messages[:600])
        kind, modes = message_class("std_msgs/msg/String"), peer.received["contact_mode"]

        def in_contact():
            return modes and deserialize_message(modes[-1], kind).data == "three_point"

        peer.spin_until(in_contact, "three-point contact")
        answer = peer.call("tare", Trigger.Request())
        assert not answer.success
        assert answer.message.startswith(
            "nothing taken: the peg touches, contact mode three_point; call again once it hangs"
        )
        yes = ParameterValue(type=ParameterType.PARAMETER_BOOL, bool_value=True)
        assert put(peer, Parameter(name="wrench.tare_in_contact", value=yes)) == [(True, "")]
        publish(peer, messages[600:750])
        answer = peer.call("tare", Trigger.Request())
        assert answer.success and answer.message.startswith("tare over 101 samples")
        text = stop(process)
    assert "tare refused: 1 time" in text
