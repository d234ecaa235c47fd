"""Messages of all output topics: contents against other constructions, and when they are sent."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from estimates import ALARMS, SCENE, changed, estimate, messages
from inputs import joints, wrench
from peg_on_hole_ros.config.options import Configuration, Frames
from peg_on_hole_ros.messages.beside_estimates import (
    STRING,
    TOPICS,
    UNSTAMPED,
    WRENCH,
    OutputStream,
)
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.plain import quaternion, stamp
from peg_on_hole_ros.messages.ros_messages import message_class, to_ros
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.messages.transforms import TRANSFORMS, Transforms
from peg_on_hole_ros.monitor.alarm_text import PLAIN
from peg_on_hole_ros.monitor.closed_contacts import are_closed
from peg_on_hole_ros.monitor.output_row import MONITOR_NAMES
from peg_on_hole_ros.monitor.output_view import OutputView
from peg_on_hole_ros.monitor.states import MODES
from plain_messages import to_plain


def by_topic(messages):
    return {suffix: message for suffix, _, message in messages}


def first(**more):
    return by_topic(messages(OutputStream(SCENE), estimate(**more)))


def topics_of(stream, **more):
    return {suffix for suffix, _, _ in messages(stream, estimate(**more))}


def test_first_estimate_gives_every_topic_with_its_type():
    said = messages(OutputStream(SCENE), estimate())
    # A record of a try comes when the try has ended.
    assert {suffix: ros_type for suffix, ros_type, _ in said} | {"cycle": STRING} == TOPICS


def test_stamp_and_frame_are_on_every_message_with_a_header():
    for suffix, message in first(t_ns=12_000_000_034).items():
        if suffix == "markers":
            headers = [marker["header"] for marker in message["markers"]]
        else:
            headers = [message["header"]] if suffix not in UNSTAMPED else []
        for header in headers:
            assert header == {"stamp": {"sec": 12, "nanosec": 34}, "frame_id": "hole"}


def test_each_message_is_in_the_frame_that_is_stated_for_the_hole():
    line = message_stream(Configuration(frames=Frames(hole="left_hole")))
    said, written = [], []
    for k in range(1, 120):
        line.on_joints(joints(k * 1_000_000))
        said += line.on_wrench(wrench(k * 1_000_000))
    assert {suffix for suffix, _, _ in said} | {"cycle"} == set(TOPICS)
    for suffix, ros_type, message in said:
        if suffix not in UNSTAMPED:
            made = message["markers"] if suffix == "markers" else [message]
            assert {each["header"]["frame_id"] for each in made} == {"left_hole"}
            written.append((suffix, Encoder(ros_type)(message)))
    # The node's bytes are those of the same messages.
    line, raw = message_stream(Configuration(frames=Frames(hole="left_hole"))), []
    for k in range(1, 120):
        line.on_joints(joints(k * 1_000_000))
        published = line.take_wrench_bytes(Encoder(WRENCH)(wrench(k * 1_000_000)), lambda _: None)
        raw += published.estimate if published else []
    assert raw == [each for each in written if each[0] in dict(raw)]


def test_joint_states_hold_the_estimate():
    outputs, found = estimate(), first()
    assert found["state"]["name"] == ["gamma", "psi", "phi"]
    assert found["state"]["position"] == outputs.state[:3].tolist()
    assert found["state"]["velocity"] == outputs.state[3:].tolist()
    stddev = found["state_stddev"]
    assert stddev["position"] == pytest.approx([1e-5, 2**0.5 * 1e-5, 3**0.5 * 1e-5], rel=1e-12)
    assert found["contacts"]["name"] == ["K", "B1", "B2"]
    assert found["contacts"]["effort"] == [20.0, 9.0, 11.0]
    assert found["contacts"]["velocity"] == [0.05, 0.04, 0.03]
    assert found["contacts"]["position"] == [1.0, 1.0, 1.0]
    assert found["contacts_stddev"]["effort"] == [0.5, 0.3, 0.4]
    told = dict(zip(found["monitor"]["name"], found["monitor"]["position"]))
    known = {"transition_probability": 0.25, "jamming_risk": 0.5, "reactions_determined": 1.0}
    assert {name: value for name, value in told.items() if not np.isnan(value)} == known


def test_the_monitor_has_one_list_of_names_whatever_is_known():
    stream = OutputStream(SCENE)
    for told in ({}, {"friction": 0.3}, {"time_to_transition": 0.1, "bias_force_x": 1.0}):
        monitor = told | {"reactions_determined": 0.0}
        found = by_topic(messages(stream, estimate(monitor=monitor)))["monitor"]
        assert tuple(found["name"]) == MONITOR_NAMES
        values = dict(zip(found["name"], found["position"], strict=True))
        assert {name: x for name, x in values.items() if not np.isnan(x)} == monitor


def numbers(value):
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [number for item in value for number in numbers(item)]
    return [value] if isinstance(value, float) else []


@pytest.mark.parametrize(
    ("mode", "determined", "known"),
    [
        ("three_point", 1.0, True),
        ("three_point", 0.0, False),
        ("unknown", 0.0, False),
        ("two_point", 0.0, False),
        # Nothing touches: a force of 0 N is known.
        ("open", 0.0, True),
    ],
)
def test_what_is_not_determined_is_nan_and_nothing_else_is(mode, determined, known):
    told = {"reactions_determined": determined}
    found = first(contact_mode=mode, monitor=told)
    unknown = {"monitor"}
    if not known:
        unknown |= {"contacts", "contact/k", "contact/b1", "contact/b2"}
        assert np.isnan(found["contacts"]["effort"]).all()
        for name in ("k", "b1", "b2"):
            assert np.isnan(numbers(found[f"contact/{name}"]["wrench"])).all()
    assert np.isfinite(found["contacts"]["velocity"]).all()
    for topic, message in found.items():
        assert np.isnan(numbers(message)).any() == (topic in unknown), topic
    drawn = {m["ns"] for m in found["markers"]["markers"] if m["action"] == 0}
    assert ("contact_force" in drawn) == known
    # Without a place that is known the peg is an outline.
    (peg,) = (m for m in found["markers"]["markers"] if m["ns"] == "peg")
    assert peg["type"] == (3 if mode in ("three_point", "two_point") else 5)
    ends = np.array([list(point.values()) for point in peg.get("points", [])])
    if len(ends):
        assert len(ends) % 2 == 0
        rings = np.hypot(ends[:, 0], ends[:, 1])
        np.testing.assert_allclose(rings, SCENE.peg_diameter / 2, rtol=1e-12)
        assert set(np.abs(ends[:, 2])) == {SCENE.peg_height / 2}


@pytest.mark.parametrize(
    ("mode", "closed"),
    [
        ("three_point", [1.0, 1.0, 1.0]),
        # In the hole B1 and B2 are halves of one contact.
        ("two_point", [1.0, 1.0, 1.0]),
        ("open", [0.0, 0.0, 0.0]),
        # Nothing is judged there: what carries is all that is known.
        ("unknown", [1.0, 0.0, 1.0]),
    ],
)
def test_contacts_are_closed_as_the_mode_says(mode, closed):
    found = are_closed(np.array([MODES.index(mode)])[:, None], np.array([[5.0, 0.0, 0.1]]))
    assert found.tolist() == [[each == 1.0 for each in closed]]
    assert first(closed=closed)["contacts"]["position"] == closed


def test_the_worst_level_of_all_alarms_is_sent_on_change():
    stream = OutputStream(SCENE)

    def sent(t_ms, *levels):
        alarms = dict(zip(ALARMS, levels))
        found = by_topic(messages(stream, estimate(t_ns=t_ms * 1_000_000, alarms=alarms)))
        return found.get("alarm_level", {}).get("data")

    told = [
        sent(1, 0, 0),
        sent(2, 0, 1),
        sent(3, 1, 0),
        sent(4, 1, 2),
        sent(5, 0, 0),
        sent(900, 0),
    ]
    assert told == [0, 1, None, 2, 0, None]
    # Nobody looks after alarms (monitor.modes: false): no level, rather than a good one.
    assert first(alarms={}).get("alarm_level") is None


def test_the_transform_is_the_pose_at_a_rate_of_its_own():
    transforms = Transforms()
    sent = []
    for k in range(100):
        pose = first(t_ns=k * 1_000_000)["pose"]
        message = transforms.message(k * 1_000_000, lambda pose=pose: pose)
        sent += [] if message is None else [(k, pose["pose"]["pose"], message)]
    assert [k for k, _, _ in sent] == [0, 20, 40, 60, 80]
    store = get_typestore(Stores.ROS2_JAZZY)
    for k, pose, message in sent:
        # As another implementation reads it from the definition that ROS has.
        (read,) = store.deserialize_cdr(Encoder(TRANSFORMS)(message), TRANSFORMS).transforms
        assert (read.header.frame_id, read.child_frame_id) == ("hole", "peg")
        assert read.header.stamp.nanosec == k * 1_000_000
        there = read.transform.translation
        assert {"x": there.x, "y": there.y, "z": there.z} == pose["position"]
        assert read.transform.rotation.w == pose["orientation"]["w"]
    # A clock that jumps back.
    pose = first(t_ns=3_000_000)["pose"]
    assert transforms.message(3_000_000, lambda: pose) is not None


def test_contact_wrenches_are_those_of_the_estimate():
    outputs, found = estimate(), first()
    for i, name in enumerate(("k", "b1", "b2")):
        wrench = found[f"contact/{name}"]["wrench"]
        assert list(wrench["force"].values()) == outputs.contact_force[i].tolist()
        assert list(wrench["torque"].values()) == outputs.contact_wrench[i, 3:].tolist()


@given(st.lists(st.floats(-4, 4), min_size=3, max_size=3))
def test_quaternion_is_the_rotation(vector):
    rotation = Rotation.from_rotvec(vector)
    q = quaternion(rotation.as_matrix())
    assert q["w"] >= 0
    back = Rotation.from_quat([q["x"], q["y"], q["z"], q["w"]])
    assert (back.inv() * rotation).magnitude() < 1e-14


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0.8, 0)])
def test_quaternion_of_half_a_turn(axis):
    rotation = Rotation.from_rotvec(np.pi * np.array(axis))
    q = quaternion(rotation.as_matrix())
    back = Rotation.from_quat([q["x"], q["y"], q["z"], q["w"]])
    assert (back.inv() * rotation).magnitude() < 1e-14


def test_latched_topics_are_sent_on_change_only():
    stream = OutputStream(SCENE)
    assert {"transition", "contact_mode"} <= topics_of(stream)
    assert not {"transition", "contact_mode"} & topics_of(stream, t_ns=1_501_000_000)
    sent = topics_of(stream, t_ns=1_502_000_000, contact_mode="two_point", transition=True)
    assert {"transition", "contact_mode"} <= sent
    sent = topics_of(stream, t_ns=1_503_000_000, contact_mode="open", transition=True)
    assert "contact_mode" in sent and "transition" not in sent


def test_alarms_are_sent_at_10_hz_of_stamp_time_and_on_change_of_level():
    stream = OutputStream(SCENE)
    sent = [k for k in range(1000) if "alarms" in topics_of(stream, t_ns=k * 1_000_000)]
    assert sent == list(range(0, 1000, 100))
    jams = estimate(t_ns=999_500_000, alarms={"jamming": 2})
    jams.row["alarms"]["kind"][0] = PLAIN
    jams.row["alarms"]["numbers"][0] = 0.97
    status = by_topic(messages(stream, jams))["alarms"]["status"][0]
    assert (status["name"], status["level"]) == ("jamming", 2)
    assert status["values"][0] == {"key": "jamming_wedging", "value": "0.97"}
    # Other numbers at the same level are no change.
    calmer = changed(OutputView(999_700_000, jams.row))
    calmer.row["alarms"]["numbers"][0] = 0.96
    assert "alarms" not in {suffix for suffix, _, _ in messages(stream, calmer)}


def test_markers_keep_their_rate_and_survive_time_jumping_back():
    stream = OutputStream(SCENE, markers_rate=20.0)
    sent = [k for k in range(200) if "markers" in topics_of(stream, t_ns=k * 1_000_000)]
    assert sent == [0, 50, 100, 150]
    assert "markers" in topics_of(stream, t_ns=10_000_000)
    assert "markers" not in topics_of(OutputStream(SCENE, markers_rate=0.0))


@pytest.mark.parametrize(("told", "friction"), [({}, SCENE.friction), ({"friction": 0.45}, 0.45)])
def test_friction_cone_opens_by_atan_f_about_the_normal(told, friction):
    outputs = estimate()
    markers = first(monitor=outputs.monitor | told)["markers"]["markers"]
    cones = [marker for marker in markers if marker["ns"] == "friction_cone"]
    assert [cone["id"] for cone in cones] == [0, 1, 2]
    for i, cone in enumerate(cones):
        # The forces of the sample are along the normals.
        axis = outputs.contact_force[i] / np.linalg.norm(outputs.contact_force[i])
        points = np.array([list(point.values()) for point in cone["points"]])
        rays = points[1::3] - points[0::3]
        along = rays @ axis / np.linalg.norm(rays, axis=1)
        np.testing.assert_allclose(along, np.cos(np.arctan(friction)), rtol=1e-12)


def test_marker_of_an_open_contact_is_deleted():
    for marker in first(closed=[1.0, 0.0, 1.0])["markers"]["markers"]:
        if marker["ns"] in ("contact_force", "friction_cone"):
            assert marker["action"] == (2 if marker["id"] == 1 else 0)


def test_two_point_pose_has_no_cones_and_does_not_fail():
    markers = first(state=[0.05, 0, 0, 0, 0, 0.0])["markers"]["markers"]
    assert {m["action"] for m in markers if m["ns"] == "friction_cone"} == {2}


@pytest.mark.parametrize("suffix", TOPICS)
def test_ros_serialises_every_message_without_loss(suffix):
    # rclpy turns an int or numpy scalar in a float64 field into rubbish: only the way back shows.
    ros_type = TOPICS[suffix]
    message = {"data": "{}"} if suffix == "cycle" else first()[suffix]
    ros = to_ros(ros_type, message)
    back = to_plain(deserialize_message(serialize_message(ros), message_class(ros_type)))
    assert_contains(back, message)


def assert_contains(full, part):
    if isinstance(part, dict):
        for name, value in part.items():
            assert_contains(full[name], value)
    elif isinstance(part, list):
        assert len(full) == len(part)
        for left, right in zip(full, part):
            assert_contains(left, right)
    elif isinstance(part, float):
        assert type(part) is float
        if not (np.isnan(full) and np.isnan(part)):
            assert full in (part, float(np.float32(part)))  # colours are float32
    else:
        assert full == part and type(full) is type(part)


def test_stamp_of_negative_time_is_floored():
    assert stamp(-1) == {"sec": -1, "nanosec": 999_999_999}


def test_every_number_is_python_own():
    def walk(value):
        if isinstance(value, dict):
            for item in value.values():
                walk(item)
        elif isinstance(value, list):
            for item in value:
                walk(item)
        elif not isinstance(value, str):
            assert type(value) in (int, float, bool)

    for message in first().values():
        walk(message)


def test_unknown_field_is_an_error():
    with pytest.raises(KeyError, match="data_"):
        to_ros("std_msgs/msg/Bool", {"data_": True})
    assert isinstance(to_plain(to_ros("std_msgs/msg/Bool", {"data": True})), dict)
