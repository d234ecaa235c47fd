"""Over real DDS: what the node published is, bit for bit, what its record of arrivals replays."""

import gc
import json

import pytest
from mcap.reader import make_reader
from mcap.records import ChunkIndex
from mcap.writer import Writer
from rclpy.serialization import deserialize_message, serialize_message
from std_srvs.srv import Trigger

from dds_peer import Peer, node_process, stop
from inputs import closing, joints, wrench
from peg_on_hole_ros.bags.arrival_record import (
    CHUNK_BYTES,
    EVENT_TOPIC,
    ArrivalRecord,
)
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.beside_estimates import JOINT_STATE, TOPICS, UNSTAMPED
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.definitions import definition
from peg_on_hole_ros.messages.ros_messages import message_class, to_ros
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.replay.run import (
    check_bag,
    hand_over,
    replay_bag,
    sources_of,
    stored_configuration,
    stored_options,
)
from plain_messages import to_plain

pytestmark = pytest.mark.xdist_group("dds")

NAN = float("nan")
BURST = 20  # wrenches in flight, far below any queue


def last_state_ns(peer):
    payloads = peer.received["state"]
    if not payloads:
        return 0
    stamp = deserialize_message(payloads[-1], message_class(JOINT_STATE)).header.stamp
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def play(peer, messages):
    """Publish; wait after each burst for the estimate of its last wrench."""
    wrenches = 0
    for source, message in messages:
        if source == "joints":
            peer.joints.publish(to_ros(JOINTS_TYPE, message))
            continue
        peer.wrench.publish(to_ros(WRENCH_TYPE, message))
        wrenches += 1
        if wrenches % BURST == 0:
            stamp = message["header"]["stamp"]
            t_ns = stamp["sec"] * 1_000_000_000 + stamp["nanosec"]
            peer.spin_until(lambda t_ns=t_ns: last_state_ns(peer) >= t_ns, "estimate of a burst")


def malformed(t_ns):
    yield "joints", joints(t_ns) | {"name": ["gamma"]}
    yield "joints", joints(t_ns, psi=NAN)
    yield "wrench", wrench(t_ns, force=(NAN, 0.0, 0.0))
    yield "wrench", wrench(9_000_000_000)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Run a node: stream, tare, malformed messages, more, reset, more."""
    path = tmp_path_factory.mktemp("record") / "arrivals.mcap"
    peer = Peer()
    # The peg of this stream moves all the time.
    arguments = ["-p", f"record_arrivals:={path}", "-p", "wrench.tare_in_contact:=true"]
    with node_process(*arguments) as process:
        peer.wait_for_matching()
        # Joint state and wrench go by two topics: the estimate starts when one is there.
        play(peer, [("joints", joints(9_999_000_000))])
        first = [("wrench", wrench(9_999_000_000 + k * 1_000)) for k in range(500)]
        for source, message in first:
            play(peer, [(source, message)])
            peer.executor.spin_once(timeout_sec=0.05)
            if peer.received["state"]:
                break
        messages = list(closing(700))
        play(peer, messages[:300])
        tare = peer.call("tare", Trigger.Request())
        play(peer, malformed(10_190_000_000))
        play(peer, messages[300:600])
        reset = peer.call("reset", Trigger.Request())
        play(peer, [("joints", joints(10_399_500_000, 0.11, 0.08, 0.8))])
        play(peer, messages[600:])
        # The answer comes after all that was published before it.
        peer.call("reset", Trigger.Request())
        print(stop(process))
    expected = replayed(path)
    for suffix, messages in expected.items():
        received = peer.received[suffix]
        peer.spin_until(lambda r=received, m=messages: len(r) >= len(m), f"all of ~/{suffix}")
    peer.close()
    assert tare.success and reset.success
    return path, expected, peer.received


def replayed(path):
    """Return what the record makes the shared path publish, by topic."""
    bag = Bag(path)
    configuration = stored_configuration(bag)
    stream = message_stream(configuration)
    expected, sources = {suffix: [] for suffix in TOPICS}, sources_of(configuration)
    for item in bag.items(check_bag(bag, configuration)):
        columns = hand_over(stream, item, sources)
        for suffix, ros_type, fields in columns.messages(0) if columns else ():
            expected[suffix].append(exact(ros_type, serialize_message(to_ros(ros_type, fields))))
    return expected


def test_record_replays_bit_for_bit(run):
    _, expected, received = run
    assert len(expected["state"]) > 600
    for suffix, ros_type in TOPICS.items():
        assert [exact(ros_type, payload) for payload in received[suffix]] == expected[suffix]


def test_compare_finds_no_difference_between_record_and_what_was_published(run, tmp_path, capsys):
    path, _, received = run
    live, out = tmp_path / "live.mcap", tmp_path / "replay.mcap"
    with live.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2")
        for suffix, ros_type in TOPICS.items():
            if suffix in UNSTAMPED:  # these have no stamp to go by
                continue
            schema = writer.register_schema(ros_type, "ros2msg", definition(ros_type).encode())
            channel = writer.register_channel(f"/peg_on_hole/{suffix}", "cdr", schema)
            for number, payload in enumerate(received[suffix]):
                writer.add_message(channel, number, bytes(payload), number)
        writer.finish()
    assert main(["replay", str(path), "--out", str(out)]) == 0
    capsys.readouterr()
    assert main(["compare", str(live), str(out), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    for suffix in set(TOPICS) - set(UNSTAMPED):
        stamps = len(received[suffix])
        assert result["topics"][suffix] == {"stamps": stamps, "differ": 0}, suffix
    assert result["incomplete_a"] == result["incomplete_b"] == 0


def exact(ros_type, payload):
    """Return all fields as text; repr keeps every bit. The bytes have garbage as padding."""
    return repr(to_plain(deserialize_message(payload, message_class(ros_type))))


def test_record_holds_every_arrival_in_order_and_the_configuration(run):
    path, _, _ = run
    bag = Bag(path)
    arrivals = list(bag.messages(("/wrench", "/joint_states", EVENT_TOPIC)))
    times = [arrival.log_ns for arrival in arrivals]
    assert all(late > early for early, late in zip(times, times[1:]))
    events = [arrival.message.data for arrival in arrivals if arrival.topic == EVENT_TOPIC]
    assert events == ["tare", "reset", "reset"]
    assert bag.metadata["peg_on_hole_configuration"]["scene.friction"] == "0.2"
    assert bag.damage == ""


REMAPPED = ["-r", "/wrench:=/ft/wrench"]
NAMESPACED = [
    "-r",
    "__ns:=/cell",
    "-p",
    "topics.wrench:=wrench",
    "-p",
    "topics.joint_states:=joint_states",
]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("node", "arguments", "topics"),
    [
        ("peg_on_hole", REMAPPED, ("/ft/wrench", "/joint_states")),
        ("cell/peg_on_hole", NAMESPACED, ("/cell/wrench", "/cell/joint_states")),
    ],
)
def test_record_of_a_node_with_other_names_replays_as_it_is(node, arguments, topics, tmp_path):
    path, peer = tmp_path / "arrivals.mcap", Peer(node)
    kinds = (message_class(WRENCH_TYPE), message_class(JOINTS_TYPE))
    peer.wrench, peer.joints = (peer.node.create_publisher(*it, 1000) for it in zip(kinds, topics))
    record = ["-p", f"record_arrivals:={path}", "-p", "markers_rate:=50.0"]
    with node_process(*arguments, *record) as process:
        peer.wait_for_matching()
        play(peer, [("joints", joints(9_999_000_000))])
        play(peer, closing(200))
        print(stop(process))
    published = peer.received["markers"]
    assert main(["replay", str(path), "--summary", str(tmp_path / "s.json")]) == 0
    bag, markers = Bag(path), []
    configuration, rate = stored_configuration(bag), stored_options(bag).markers_rate
    assert (configuration.topics.wrench, configuration.topics.joint_states) == topics
    replay_bag(bag, configuration, rate, [Markers(markers)])
    peer.spin_until(lambda: len(published) >= len(markers), "all markers")
    peer.close()
    assert len(markers) == len(published) >= 9


class Markers:
    def __init__(self, found):
        self.found = found

    def take(self, columns):
        for _, messages in columns.beside:
            self.found += [fields for suffix, _, fields in messages if suffix == "markers"]


def test_noise_that_is_set_in_a_stream_is_set_at_the_same_message_of_its_record(tmp_path):
    """All orientations behind it have the new noise, also those read in one go with the others."""
    record = ArrivalRecord(tmp_path / "record.mcap", Configuration(), 10.0)
    stream, live = message_stream(Configuration()), []
    encoders = {"wrench": Encoder(WRENCH_TYPE), "joints": Encoder(JOINTS_TYPE)}
    change = 'set {"joints.position_stddev": 0.003}'
    for number, (source, message) in enumerate(closing(400)):
        if number == 300:
            record.event(change, 1000 * number - 500)
            assert stream.on_event(change).success
        getattr(record, source)(encoders[source](message), 1000 * number)
        columns = (stream.on_wrench if source == "wrench" else stream.on_joints)(message)
        live += [columns] if source == "wrench" and columns else []
    record.close()
    replayed_ones = _Outputs([])
    bag = Bag(record.path)
    replay_bag(bag, stored_configuration(bag), 10.0, [replayed_ones])
    assert len(live) > 300
    assert [repr(each) for each in live] == [repr(each) for each in replayed_ones.found]


class _Outputs:
    def __init__(self, found):
        self.found = found

    def take(self, columns):
        self.found += [columns.messages(i) for i in range(len(columns))]


def test_existing_record_is_kept(tmp_path):
    path = tmp_path / "record.mcap"
    path.write_bytes(b"precious")
    record = ArrivalRecord(path, Configuration(), 10.0)
    record.event("tare", 5)
    record.event("reset", 5)
    record.close()
    assert path.read_bytes() == b"precious"
    assert record.path.name == "record_1.mcap"
    events = Bag(record.path).messages([EVENT_TOPIC])
    assert [(event.log_ns, event.message.data) for event in events] == [(5, "tare"), (6, "reset")]


def test_a_record_of_days_keeps_no_place_of_every_chunk_in_memory(tmp_path, monkeypatch):
    monkeypatch.setattr("peg_on_hole_ros.bags.arrival_record.MOST_INDEXED", 4)
    record = ArrivalRecord(tmp_path / "record.mcap", Configuration(), 10.0)
    before = places_kept()
    payload = Encoder(WRENCH_TYPE)(wrench(5))
    count = 40 * CHUNK_BYTES // len(payload)
    for t_ns in range(count):
        record.wrench(payload, t_ns)
    record.event("reset", count)
    # Four and what the writer's own part of each message adds, for forty.
    assert places_kept() - before < 10
    record.close()
    bag = Bag(record.path)
    assert not bag.damage
    assert bag.metadata["peg_on_hole_configuration"]["scene.friction"] == "0.2"
    topics = ("/wrench", "/joint_states", EVENT_TOPIC)
    found = [(arrival.topic, arrival.log_ns) for arrival in bag.messages(topics)]
    assert found == [
        *(("/wrench", t_ns) for t_ns in range(1, count + 1)),
        (EVENT_TOPIC, count + 1),
    ]
    with record.path.open("rb") as stream:
        # What other programs do.
        assert sum(1 for _ in make_reader(stream).iter_messages()) == count + 1


def places_kept():
    return sum(isinstance(item, ChunkIndex) for item in gc.get_objects())


@pytest.mark.parametrize(
    ("place", "reason"), [("no/x.mcap", "No such file or directory"), ("", "Is a directory")]
)
def test_record_that_cannot_be_a_file_there_is_refused(place, reason, tmp_path):
    with pytest.raises(PegOnHoleError) as caught:
        ArrivalRecord(f"{tmp_path}/{place}", Configuration(), 10.0)
    assert str(caught.value) == (
        f"record_arrivals = '{tmp_path}/{place}' cannot be written: {reason}; name a file in a "
        "folder that exists and may be written to"
    )
    assert not list(tmp_path.parent.glob(f"{tmp_path.name}_*"))
