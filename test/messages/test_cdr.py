"""The encoder gives the bytes that the libraries give."""

import numpy as np
import pytest
from mcap_ros2._dynamic import serialize_dynamic

from peg_on_hole_ros.messages.beside_estimates import JOINT_STATE, POSE, WRENCH, joint_state
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.definitions import definition
from peg_on_hole_ros.messages.plain import header

ARRAY = "diagnostic_msgs/msg/DiagnosticArray"
MARKERS = "visualization_msgs/msg/MarkerArray"


def library(ros_type, message):
    return serialize_dynamic(ros_type, definition(ros_type))[ros_type](message)


def wrench(t_ns, frame, numbers):
    force, torque = dict(zip("xyz", numbers[:3])), dict(zip("xyz", numbers[3:]))
    return {"header": header(t_ns, frame), "wrench": {"force": force, "torque": torque}}


def pose(t_ns, frame, numbers):
    orientation = dict(zip("xyzw", numbers[3:7]))
    inner = {"position": dict(zip("xyz", numbers[:3])), "orientation": orientation}
    return {"header": header(t_ns, frame), "pose": {"pose": inner, "covariance": numbers[7:]}}


@pytest.mark.parametrize("frame", ["", "a", "ab", "abc", "abcd", "ä", "hole/lengthy_frame"])
def test_what_recurs_is_packed_as_the_library_packs_it(frame):
    rng = np.random.default_rng(1)
    joints, wrenches, poses = Encoder(JOINT_STATE), Encoder(WRENCH), Encoder(POSE)
    for k in range(12):
        t_ns = int(rng.integers(0, 2**31)) * 10**9 + int(rng.integers(0, 10**9))
        numbers = rng.normal(size=43).tolist()
        for n in range(4):
            names = [f"joint{'x' * (k % 3)}{i}" for i in range(n)]
            for lengths in ((n, n, n), (n, 0, 0), (0, n, n), (0, 0, n)):
                parts = [numbers[:size] for size in lengths]
                message = joint_state(t_ns, names, *parts, frame=frame)
                assert joints(message) == library(JOINT_STATE, message)
        for encoder, ros_type, message in (
            (wrenches, WRENCH, wrench(t_ns, frame, numbers[:6])),
            (poses, POSE, pose(t_ns, frame, numbers)),
        ):
            assert encoder(message) == encoder.walk(message) == library(ros_type, message)


@pytest.mark.parametrize(
    ("ros_type", "message"),
    [
        ("std_msgs/msg/Bool", {"data": True}),
        ("std_msgs/msg/String", {"data": "three_point"}),
        (
            ARRAY,
            {
                "header": header(5),
                "status": [
                    {
                        "level": 2,
                        "name": "jamming",
                        "message": "é",
                        "hardware_id": "p",
                        "values": [{"key": "a", "value": "1"}, {"key": "", "value": "22"}],
                    },
                    {"values": []},
                ],
            },
        ),
        (
            MARKERS,
            {
                "markers": [
                    {
                        "header": header(7, "hole"),
                        "ns": "n",
                        "id": -3,
                        "type": 5,
                        "scale": {"x": 0.5},
                        "color": {"r": 0.25, "a": 1.0},
                        "lifetime": {"sec": 1},
                        "frame_locked": True,
                        "points": [{"x": 1.0, "y": 2.0, "z": 3.0}, {"z": 4.0}],
                        "text": "t",
                    },
                    {"texture": {"format": "png", "data": [1, 2, 255]}},
                ]
            },
        ),
    ],
)
def test_all_other_types_are_encoded_as_the_library_does(ros_type, message):
    assert Encoder(ros_type)(message) == library(ros_type, message)


@pytest.mark.parametrize("ros_type", [JOINT_STATE, WRENCH, POSE, ARRAY, MARKERS])
def test_fields_left_out_have_their_defaults(ros_type):
    # The library writes an unset pose's quaternion as its definition says: w is 1.
    assert Encoder(ros_type)({}) == library(ros_type, {})


def test_covariance_of_a_wrong_length_is_refused():
    with pytest.raises(ValueError, match="35 values for a field of 36"):
        Encoder(POSE)(pose(1, "hole", [0.0] * 42))


def test_texts_that_never_recur_do_not_fill_the_memory():
    encoder = Encoder(JOINT_STATE)
    for i in range(1000):
        encoder(joint_state(1, [f"j{i}"], [0.0]))
    assert len(encoder._known) <= 256
