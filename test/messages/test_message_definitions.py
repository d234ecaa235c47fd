"""The definitions are those of ROS 2: their type hashes (REP-2011) agree."""

import pytest

from peg_on_hole_ros.messages.definitions import definition

rosbags = pytest.importorskip("rosbags.typesys")

TYPES = [
    "diagnostic_msgs/msg/DiagnosticArray",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "geometry_msgs/msg/WrenchStamped",
    "sensor_msgs/msg/JointState",
    "std_msgs/msg/Bool",
    "std_msgs/msg/String",
    "visualization_msgs/msg/MarkerArray",
]


@pytest.mark.parametrize("distro", ["ROS2_JAZZY", "ROS2_KILTED"])
@pytest.mark.parametrize("ros_type", TYPES)
def test_type_hash_is_that_of_the_distribution(ros_type, distro):
    official = rosbags.get_typestore(getattr(rosbags.Stores, distro))
    ours = rosbags.get_typestore(rosbags.Stores.EMPTY)
    ours.register(rosbags.get_types_from_msg(definition(ros_type), ros_type))
    assert ours.hash_rihs01(ros_type) == official.hash_rihs01(ros_type)


def test_type_unknown_here_is_a_key_error():
    with pytest.raises(KeyError):
        definition("sensor_msgs/msg/Image")
