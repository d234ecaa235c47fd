"""What `peg-on-hole compare` says of two outputs that are the same, and of those that are not."""

import copy
import json

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from estimates import changed as changed_estimate
from estimates import estimate, messages
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.beside_estimates import TOPICS, UNSTAMPED, OutputStream
from small_bags import MS

COUNT = 5
CHANGES = {
    "contact/k": lambda message: message["wrench"]["force"].update(x=0.0),
    "contact/b2": lambda message: message["wrench"]["torque"].update(z=-0.0),
    "pose": lambda message: message["pose"]["covariance"].__setitem__(7, 1.0),
    "alarms": lambda message: message["status"][1].update(message="other words"),
    "markers": lambda message: message["markers"][-1]["points"][3].update(z=1.0),
    # No part of the numbers of an estimate.
    "contacts": lambda message: message["position"].__setitem__(0, 0.0),
}
# Without a stamp, published on change: they hold for all estimates that follow.
DECLARED = {
    "contact_mode": lambda message: message.update(data="two_point"),
    "transition": lambda message: message.update(data=True),
}


def output(path, changed=(), without=(), lost=(), more=0.0):
    """
    Write an output of some stamps.

    `lost` holds pairs of topic and number of the stamp; at K there is `more` load [N].
    """
    stream = OutputStream(Scene())
    with BagWriter(path) as writer:
        for i in range(COUNT):
            t_ns = 10**9 + i * MS
            made = estimate(t_ns)
            made = changed_estimate(made, normal=made.normal + [more, 0.0, 0.0])
            for topic, ros_type, fields in messages(stream, made):
                fields = copy.deepcopy(fields)
                if topic in changed:
                    (CHANGES | DECLARED)[topic](fields)
                if topic not in without and (topic, i) not in lost:
                    writer.write(f"/peg_on_hole/{topic}", ros_type, fields, t_ns)
    return path


@pytest.fixture
def own(tmp_path):
    return output(tmp_path / "own.mcap")


def compared(capsys, a, b):
    """Return the JSON, and the lines that say whether both are the same."""
    assert main(["compare", str(a), str(b), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert main(["compare", str(a), str(b)]) == 0
    lines = capsys.readouterr().out.splitlines()[2:]
    return result, lines[: lines.index("")]


def test_every_stamped_topic_is_compared(own, capsys):
    result, lines = compared(capsys, own, own)
    assert result["identical"] and not result["differs"]
    assert lines == ["bit for bit the same: yes"]
    stamps = {name: counts["stamps"] for name, counts in result["topics"].items()}
    rare = dict.fromkeys(("alarms", "markers"), 1)
    every = [name for name in TOPICS if name not in UNSTAMPED]
    assert stamps == dict.fromkeys(every, COUNT) | rare


@pytest.mark.parametrize("topic", CHANGES)
def test_a_difference_in_any_of_them_is_one(own, tmp_path, capsys, topic):
    other = output(tmp_path / "other.mcap", changed=[topic])
    result, lines = compared(capsys, own, other)
    assert result["differs"] and not result["identical"]
    at = 1 if topic in ("alarms", "markers") else COUNT
    assert {name: n["differ"] for name, n in result["topics"].items() if n["differ"]} == {
        topic: at
    }
    assert lines == [
        "bit for bit the same: no",
        f"  stamps at which messages differ: {topic} at {at}",
    ]


@pytest.mark.parametrize("topic", DECLARED)
def test_a_difference_in_what_is_declared_is_one(own, tmp_path, capsys, topic):
    other = output(tmp_path / "other.mcap", changed=[topic])
    result, lines = compared(capsys, own, other)
    assert result["differs"] and not result["identical"]
    assert lines == ["bit for bit the same: no"]
    agrees = {name: result[f"{name}_agrees"] for name in DECLARED}
    assert agrees == {name: float(name != topic) for name in DECLARED}


def test_a_message_that_one_side_lacks_is_a_difference(own, tmp_path, capsys):
    other = output(tmp_path / "other.mcap", lost=[("pose", 2)])
    for pair in ((own, other), (other, own)):
        result, _ = compared(capsys, *pair)
        assert result["differs"] and result["topics"]["pose"] == {"stamps": COUNT, "differ": 1}


def test_settings_come_first_and_what_is_the_same_has_no_row(own, tmp_path, capsys):
    other = output(tmp_path / "other.mcap", more=2.0)
    assert main(["compare", str(own), str(other)]) == 0
    text = capsys.readouterr().out
    rows = text[text.index("difference B - A") :].split("\n\n")[0].splitlines()[1:]
    assert [row.split()[:5] for row in rows] == [["N_K", "2", "N", "2", "N"]]
    assert "the same in both: " in text and "gamma" not in text
    assert main(["compare", str(own), str(own)]) == 0
    assert "difference B - A" not in capsys.readouterr().out


def test_what_one_side_does_not_have_is_left_out_and_told(own, tmp_path, capsys):
    other = output(tmp_path / "other.mcap", without=["markers", "contact/k"])
    result, lines = compared(capsys, own, other)
    assert (result["identical"], result["differs"]) == (False, False)
    assert result["topics_only_a"] == ["contact/k", "markers"]
    assert lines == [
        "bit for bit the same: all that both have",
        "  not compared: contact/k, markers, only in A",
    ]


def test_stamps_that_lack_a_part_are_counted(own, tmp_path, capsys):
    other = output(tmp_path / "other.mcap", lost=[("monitor", 1), ("state", 3)])
    result, lines = compared(capsys, other, other)
    assert result["stamps"] == {"common": COUNT - 2, "only_a": 0, "only_b": 0}
    assert (result["incomplete_a"], result["incomplete_b"]) == (2, 2)
    assert (result["identical"], result["differs"]) == (False, False)
    assert lines == [
        "bit for bit the same: all that both have",
        "  not compared: 2 stamps that lack a part in A",
        "  not compared: 2 stamps that lack a part in B",
    ]
    result, _ = compared(capsys, own, other)
    assert (result["incomplete_a"], result["incomplete_b"]) == (0, 2)
    assert result["stamps"]["only_a"] == 2 and result["differs"]


def test_rubbish_between_fields_is_no_difference(own, tmp_path, capsys):
    # Behind the header's text "hole" a pose has three bytes up to the next multiple of eight.
    other = tmp_path / "other.mcap"
    with own.open("rb") as stream, other.open("wb") as out:
        writer = Writer(out)
        writer.start(profile="ros2")
        channels = {}
        for schema, channel, message in make_reader(stream).iter_messages():
            if channel.id not in channels:
                kind = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, "cdr", kind)
            data = bytearray(message.data)
            if channel.topic.endswith("/pose"):
                assert data[16:24] == b"hole\0\0\0\0"
                data[21:24] = b"\xff\xff\xff"
            writer.add_message(channels[channel.id], message.log_time, bytes(data), 0)
        writer.finish()
    result, _ = compared(capsys, own, other)
    assert result["identical"]
