"""What the node makes of bytes is what a stream makes of the messages that ROS reads of them."""

import random

import pytest

from cli_helpers import ROOT
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.messages.beside_estimates import TOPICS
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.replay.run import stored_configuration

pytest.importorskip("rclpy")

from rclpy.serialization import deserialize_message  # noqa: E402

from peg_on_hole_ros.messages.ros_messages import message_class  # noqa: E402
from tiers import nightly

BAG = ROOT / "bags" / "closing_with_slip.mcap"
WRENCH, JOINTS = message_class(WRENCH_TYPE), message_class(JOINTS_TYPE)


class Both:
    """Two streams with the same input: the one reads bytes itself, the other has ROS read them."""

    def __init__(self):
        configuration = stored_configuration(Bag(BAG))
        self.own, self.other = message_stream(configuration), message_stream(configuration)
        self._encoders = {suffix: Encoder(kind) for suffix, kind in TOPICS.items()}
        self.read_by_ros = 0

    def _read(self, stream, kind, source, payload):
        try:
            return deserialize_message(payload, kind)
        except Exception:  # rmw's own error type, which has no public name
            stream.unreadable(source)
            return None

    def _asked(self, kind, source):
        def read(payload):
            self.read_by_ros += 1
            return self._read(self.own, kind, source, payload)

        return read

    def wrench(self, payload):
        """Return the messages of both, as bytes."""
        published = self.own.take_wrench_bytes(payload, self._asked(WRENCH, "wrench"))
        message = self._read(self.other, WRENCH, "wrench", payload)
        wanted = [] if message is None else self.other.on_wrench(message)
        given = [] if published is None else [*published.estimate, *self._bytes(published.beside)]
        return given, self._bytes(wanted)

    def joints(self, payload):
        self.own.take_joints_bytes(payload, self._asked(JOINTS, "joints"))
        message = self._read(self.other, JOINTS, "joints", payload)
        if message is not None:
            self.other.on_joints(message)

    def event(self, name):
        assert self.own.on_event(name) == self.other.on_event(name)

    def _bytes(self, messages):
        return [(suffix, self._encoders[suffix](fields)) for suffix, _, fields in messages]


def recorded():
    return [(m.topic, p) for m, p in Bag(BAG).with_payloads(["/wrench", "/joint_states"])]


def test_bytes_in_and_out_are_those_of_messages():
    both, told = Both(), set()
    for i, (topic, payload) in enumerate(recorded()):
        if i == 600:
            both.event("expect lift_off")
        if topic == "/wrench":
            given, wanted = both.wrench(payload)
            assert given == wanted
            told |= {suffix for suffix, _ in given}
        else:
            both.joints(payload)
    # What is said now and then is among them.
    assert told >= {"state", "pose", "monitor", "alarms", "contact_mode", "markers", "transition"}
    assert both.own.counts == both.other.counts
    # The first of each alone.
    assert both.read_by_ros == 2


@pytest.mark.parametrize("seed", [0, *nightly(1, 2, 3)])
def test_damaged_bytes_have_the_same_fate(seed):
    both, random_ = Both(), random.Random(seed)
    for topic, payload in recorded()[:900]:
        kind = random_.random()
        if kind < 0.2:
            # Most of what tells a message's layout is in its first bytes.
            changed, at = bytearray(payload), random_.randrange(min(len(payload), 90))
            changed[at] = random_.choice((0, 1, 2, 255, changed[at] ^ 1, changed[at] ^ 128))
            payload = bytes(changed)
        elif kind < 0.25:
            payload = payload[: random_.randrange(len(payload))]
        elif kind < 0.3:
            payload += bytes(random_.randrange(1, 9))
        if topic == "/wrench":
            given, wanted = both.wrench(payload)
            assert given == wanted
        else:
            both.joints(payload)
    assert both.own.counts == both.other.counts
    assert any(count for name, count in both.own.counts.items() if "malformed" in name)


def test_other_texts_and_lengths_are_read_anew():
    both = Both()
    names = ["gamma", "psi", "phi"]
    encode = Encoder(JOINTS_TYPE)

    def joints(t_ns, names, *rest, frame=""):
        header = {"stamp": {"sec": t_ns // 10**9, "nanosec": t_ns % 10**9}, "frame_id": frame}
        fields = dict(zip(("position", "velocity", "effort"), rest))
        both.joints(encode({"header": header, "name": names, **fields}))
        return both.read_by_ros

    angles = [0.2, 0.0, 0.0]
    reads = [
        joints(1_000_000, names, angles),
        joints(2_000_000, names, angles),
        joints(3_000_000, names[::-1], angles[::-1]),
        joints(4_000_000, names[::-1], angles[::-1]),
        joints(5_000_000, names, angles, angles),
        joints(6_000_000, names, angles, [], angles),
        joints(7_000_000, names, angles, [], angles, frame="arm"),
        joints(8_000_000, names, angles, [], angles, frame="arm"),
        # No sample, so nothing is learnt of it.
        joints(9_000_000, names, angles[:2]),
        joints(10_000_000, names, angles, [], angles, frame="arm"),
    ]
    assert reads == [1, 1, 2, 2, 3, 4, 5, 5, 6, 6]
    assert both.own.counts == both.other.counts
    assert both.own.counts["joints_dropped_malformed_length_mismatch"] == 1
