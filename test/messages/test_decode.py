"""Messages from ROS, a bag or a dict become the same sample; malformed ones a named reason."""

import io

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer

from peg_on_hole_ros.messages.decode import (
    JOINTS_TYPE,
    WRENCH_TYPE,
    Malformed,
    joint_sample,
    wrench_sample,
)
from peg_on_hole_ros.messages.ros_messages import to_ros
from peg_on_hole_ros.records import JointSample, WrenchSample

NAN, INF = float("nan"), float("inf")


def wrench(sec=3, nanosec=7, force=(1.0, 2.0, 3.0), torque=(0.1, 0.2, 0.3)):
    return {
        "header": {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": "sensor"},
        "wrench": {"force": dict(zip("xyz", force)), "torque": dict(zip("xyz", torque))},
    }


def joints(names=("phi", "gamma", "psi"), position=(0.3, 0.1, 0.2), **more):
    return {
        "header": {"stamp": {"sec": 3, "nanosec": 7}, "frame_id": ""},
        "name": list(names),
        "position": list(position),
    } | more


def test_three_forms_of_a_wrench_give_one_sample():
    expected = WrenchSample(3_000_000_007, (1.0, 2.0, 3.0), (0.1, 0.2, 0.3))
    assert wrench_sample(wrench()) == expected
    assert wrench_sample(to_ros(WRENCH_TYPE, wrench())) == expected
    assert wrench_sample(from_bag(WRENCH_TYPE, WRENCH_DEFINITION, wrench())) == expected


def test_three_forms_of_joint_states_give_one_sample():
    expected = JointSample(3_000_000_007, ("phi", "gamma", "psi"), (0.3, 0.1, 0.2))
    message = joints(velocity=[NAN, 0.0, 0.0])
    assert joint_sample(message) == expected
    assert joint_sample(to_ros(JOINTS_TYPE, message)) == expected
    assert joint_sample(from_bag(JOINTS_TYPE, JOINTS_DEFINITION, message)) == expected


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (wrench(force=(1.0, NAN, 3.0)), "not_finite"),
        (wrench(torque=(INF, 0.0, 0.0)), "not_finite"),
        (wrench(torque=(INF, 1e200, 0.0)), "not_finite"),
        (wrench(force=(0.0, 0.0, 2e6)), "out_of_range"),
        (wrench(nanosec=1_000_000_000), "bad_stamp"),
        (wrench(force=("one", 2.0, 3.0)), "unreadable"),
        (wrench(force=(1.0, 2.0)), "unreadable"),
        ({"wrench": {}}, "unreadable"),
        (None, "unreadable"),
    ],
)
def test_malformed_wrench_has_a_reason(message, reason):
    assert wrench_sample(message) == Malformed(reason)


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (joints(position=(0.3, 0.1)), "length_mismatch"),
        (joints(position=()), "length_mismatch"),
        (joints(position=(NAN, 0.1, 0.2)), "not_finite"),
        (joints(names=("phi", "phi", "psi")), "repeated_name"),
        (joints(position=(None, 0.1, 0.2)), "unreadable"),
        ("text", "unreadable"),
    ],
)
def test_malformed_joint_states_have_a_reason(message, reason):
    assert joint_sample(message) == Malformed(reason)


def test_joint_that_is_not_needed_may_hold_anything():
    message = joints(names=("finger", "gamma"), position=(NAN, 0.1))
    assert joint_sample(message, ("gamma",)).names == ("finger", "gamma")
    assert joint_sample(message, ("finger",)) == Malformed("not_finite")


_HEADER = """
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
"""
_LINE = "=" * 80
WRENCH_DEFINITION = f"""std_msgs/Header header
geometry_msgs/Wrench wrench
{_LINE}{_HEADER}{_LINE}
MSG: geometry_msgs/Wrench
geometry_msgs/Vector3 force
geometry_msgs/Vector3 torque
{_LINE}
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""
JOINTS_DEFINITION = f"""std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{_LINE}{_HEADER}"""


def from_bag(ros_type, definition, message):
    stream = io.BytesIO()
    with Writer(stream) as writer:
        schema = writer.register_msgdef(ros_type, definition)
        writer.write_message("/topic", schema, message, log_time=1)
    stream.seek(0)
    reader = make_reader(stream, decoder_factories=[DecoderFactory()])
    return next(reader.iter_decoded_messages()).decoded_message
