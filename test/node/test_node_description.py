"""The robot's description by a topic, and the sensor's frame, in the running node over DDS."""

import json
from dataclasses import replace

import numpy as np
import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message
from scipy.spatial.transform import Rotation

from arm import BENT, JOINTS, OPTIONS, URDF, Arm
from dds_peer import Peer, node_process, stop
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import URDF_METADATA
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.config.options import Configuration, WrenchInput
from peg_on_hole_ros.config.parameters_file import write_parameters
from peg_on_hole_ros.messages.beside_estimates import DIAGNOSTICS, STRING, joint_state
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.plain import header
from peg_on_hole_ros.messages.ros_messages import message_class, to_ros
from peg_on_hole_ros.replay.run import replay_bag, stored_configuration

pytest.importorskip("pinocchio")
pytestmark = pytest.mark.xdist_group("dds_starts")
MS = 1_000_000
TEXT = URDF.read_text(encoding="utf-8")


@pytest.fixture
def peer():
    made = Peer()
    yield made
    made.close()


def parameters_file(tmp_path, **wrench):
    found = Configuration(wrench=WrenchInput(**wrench), joints=replace(OPTIONS, urdf="topic"))
    path = tmp_path / "cell.yaml"
    path.write_text(write_parameters(to_parameters(found)), encoding="utf-8")
    return path


class Cell:
    """An arm that holds the peg still in the air."""

    def __init__(self, peer, frame):
        self.peer, self.frame, self.t_ns = peer, frame, 10**9
        self.q = Arm().joints_at(np.zeros(3), Rotation.from_euler("y", -0.2), BENT)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.description = peer.node.create_publisher(
            message_class(STRING), "/robot_description", latched
        )

    def send(self):
        self.t_ns += MS
        self.peer.joints.publish(to_ros(JOINTS_TYPE, joint_state(self.t_ns, JOINTS, self.q)))
        zero = dict.fromkeys("xyz", 0.0)
        wrench = {"force": zero, "torque": zero}
        fields = {"header": header(self.t_ns, self.frame), "wrench": wrench}
        self.peer.wrench.publish(to_ros(WRENCH_TYPE, fields))

    def filter_status(self):
        """Level and message of the latest report of the filter."""
        reports = self.peer.received["/diagnostics"]
        if not reports:
            return None
        latest = deserialize_message(reports[-1], message_class(DIAGNOSTICS))
        (found,) = (s for s in latest.status if s.name == "peg_on_hole: filter")
        return found.level, found.message

    def until(self, done, what):
        def sent():
            self.send()
            return done()

        self.peer.spin_until(sent, what)


def told(cell, words):
    def there():
        found = cell.filter_status()
        return found is not None and words in found[1]

    return there


def level_of(text, words):
    """Return the level at which a log has the one line with these words."""
    (line,) = (line for line in text.splitlines() if words in line)
    return line.split()[0]


@pytest.mark.nightly
def test_the_node_waits_for_the_description_and_then_goes_on(peer, tmp_path):
    record = tmp_path / "record.mcap"
    arguments = "--params-file", str(parameters_file(tmp_path)), "-p", f"record_arrivals:={record}"
    with node_process(*arguments) as process:
        cell = Cell(peer, "ft_sensor")
        peer.wait_for_matching()
        cell.until(told(cell, "has not come on /robot_description"), "what is waited for")
        assert cell.filter_status()[0] == b"\x02" and not peer.received["state"]
        cell.description.publish(to_ros(STRING, {"data": ""}))
        cell.until(told(cell, "cannot be used: the robot's description is empty"), "a refusal")
        cell.description.publish(to_ros(STRING, {"data": "<robot name='a'/>"}))
        cell.until(told(cell, "cannot be used: joints.tip_frame = 'tool' is no link"), "a refusal")
        assert not peer.received["state"]
        cell.description.publish(to_ros(STRING, {"data": TEXT}))
        cell.until(lambda: len(peer.received["state"]) > 20, "estimates")
        cell.description.publish(to_ros(STRING, {"data": TEXT.replace("0.1575", "0.2")}))
        cell.until(lambda: cell.filter_status()[0] != b"\x02", "a report without the error")
        text = stop(process)
    assert text.count("waiting for the robot's description on /robot_description") == 1
    assert text.count("the robot's description has come on /robot_description") == 1
    assert text.count("another description has come") == 1
    # As it should be: nothing to warn of.
    assert level_of(text, "sensor: at 'ft_sensor', wrench.sensor_xyz: [") == "[INFO]"
    # The record has the description, and gives again what the node gave.
    bag = Bag(record)
    assert bag.metadata[URDF_METADATA]["text"] == TEXT
    stamps = []

    class Sink:
        def take(self, columns):
            for i in range(len(columns)):
                found = columns.messages(i)
                stamps.extend(fields for suffix, _, fields in found if suffix == "state")

    replayed = replay_bag(bag, stored_configuration(bag), 10.0, [Sink()])
    assert "joints_dropped_without_description" not in replayed.dropped
    first = deserialize_message(peer.received["state"][0], message_class(JOINTS_TYPE))
    assert first.header.stamp.nanosec == stamps[0]["header"]["stamp"]["nanosec"]
    assert list(first.position) == stamps[0]["position"]
    assert json.loads(bag.metadata["peg_on_hole_configuration"]["joints.urdf"]) == "topic"


@pytest.mark.nightly
def test_a_pose_that_the_description_contradicts_is_refused_by_the_node(peer, tmp_path):
    path = parameters_file(tmp_path, sensor_xyz=(0.0, 0.0, 0.17))
    with node_process("--params-file", str(path)) as process:
        cell = Cell(peer, "ft_sensor")
        cell.description.publish(to_ros(STRING, {"data": TEXT}))
        peer.wait_for_matching()
        words = "wrench.sensor_xyz = [0.0, 0.0, 0.17] is not where the robot's description has"
        cell.until(told(cell, words), "the refusal")
        assert cell.filter_status()[0] == b"\x02" and not peer.received["state"]
        text = stop(process)
    assert level_of(text, words) == "[WARN]"
    assert "wrench dropped sensor contradicted" in text


@pytest.mark.nightly
def test_a_frame_that_is_no_link_is_told_once(peer, tmp_path):
    with node_process("--params-file", str(parameters_file(tmp_path))) as process:
        cell = Cell(peer, "somewhere")
        cell.description.publish(to_ros(STRING, {"data": TEXT}))
        peer.wait_for_matching()
        cell.until(lambda: len(peer.received["state"]) > 20, "estimates")
        text = stop(process)
    words = "frame_id 'somewhere' of the wrench is no link of the robot's descri"
    assert level_of(text, words) == "[WARN]"
