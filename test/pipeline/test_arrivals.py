"""Arrivals of two topics are handed on in the order of their stamps."""

from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message

from inputs import joints, wrench
from peg_on_hole_ros.edges.live.arrivals import Arrivals, stamp_ns
from peg_on_hole_ros.edges.messages.cdr import Encoder
from peg_on_hole_ros.edges.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.edges.messages.ros_messages import to_ros

encode = {"wrench": Encoder(WRENCH_TYPE), "joints": Encoder(JOINTS_TYPE)}
times = st.lists(st.integers(0, 50), max_size=20)


@given(times, times)
def test_merged_by_stamp_and_each_source_in_its_own_order(wrenches, joint_states):
    arrivals = Arrivals()
    for t in wrenches:
        arrivals.wrench(encode["wrench"](wrench(t)))
    for t in joint_states:
        arrivals.joints(encode["joints"](joints(t)))
    assert len(arrivals) == len(wrenches) + len(joint_states)
    taken = [(source, stamp_ns(payload)) for source, payload in arrivals.take()]
    assert [t for source, t in taken if source == "wrench"] == wrenches
    assert [t for source, t in taken if source == "joints"] == joint_states
    assert len(arrivals) == 0
    if wrenches == sorted(wrenches) and joint_states == sorted(joint_states):
        # A joint state before the wrench of its stamp, which it then corrects.
        assert taken == sorted(taken, key=lambda item: (item[1], item[0]))


def test_stamp_is_read_from_what_ros_serialises():
    message = to_ros(WRENCH_TYPE, wrench(12_345_678_901))
    assert stamp_ns(bytes(serialize_message(message))) == 12_345_678_901


def test_stamp_of_a_stump_is_zero():
    assert stamp_ns(b"\0\1\0\0\7") == 0
