"""Arrivals of two topics are handed on in the order of their stamps."""

from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message

from inputs import joints, wrench
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.cdr_layout import stamp_ns
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.ros_messages import to_ros
from peg_on_hole_ros.ros.inputs import WaitingMessages

encode = {"wrench": Encoder(WRENCH_TYPE), "joints": Encoder(JOINTS_TYPE)}
times = st.lists(st.integers(0, 50), max_size=20)


def taken(wrenches, joint_states):
    """Return (source, stamp) as they are handed on, all wrenches having come first."""
    arrivals = WaitingMessages()
    for t in wrenches:
        arrivals.wrench(encode["wrench"](wrench(t)))
    for t in joint_states:
        arrivals.joints(encode["joints"](joints(t)))
    assert len(arrivals) == len(wrenches) + len(joint_states)
    found = [(source, stamp_ns(payload)) for source, payload in arrivals.take()]
    assert len(arrivals) == 0
    return found


@given(times, times)
def test_each_source_keeps_its_own_order(wrenches, joint_states):
    found = taken(wrenches, joint_states)
    assert [t for source, t in found if source == "wrench"] == wrenches
    assert [t for source, t in found if source == "joints"] == joint_states


@given(times.map(sorted), times.map(sorted))
def test_what_came_in_order_is_merged_by_stamp(wrenches, joint_states):
    both = [("wrench", t) for t in wrenches] + [("joints", t) for t in joint_states]
    # A joint state before the wrench of its stamp, which it then corrects.
    expected = sorted(both, key=lambda item: (item[1], item[0]))
    assert taken(wrenches, joint_states) == expected


def test_stamp_is_read_from_what_ros_serialises():
    message = to_ros(WRENCH_TYPE, wrench(12_345_678_901))
    assert stamp_ns(bytes(serialize_message(message))) == 12_345_678_901


def test_stamp_of_a_stump_is_zero():
    assert stamp_ns(b"\0\1\0\0\7") == 0
