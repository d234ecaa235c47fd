"""A recording that pauses behind an insertion: the try ends where its motion ended."""

import json

import pytest

from cli_helpers import ROOT
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE

SECOND = 10**9
HOUR = 3600


def plain(item):
    """A message as the writer takes it."""
    stamp = item.message.header.stamp
    header = {"stamp": {"sec": stamp.sec, "nanosec": stamp.nanosec}, "frame_id": ""}
    if item.topic == "/joint_states":
        names = list(item.message.name)
        return JOINTS_TYPE, {
            "header": header, "name": names, "position": list(item.message.position)
        }  # fmt: skip
    vectors = {
        name: {axis: getattr(getattr(item.message.wrench, name), axis) for axis in "xyz"}
        for name in ("force", "torque")
    }
    return WRENCH_TYPE, {"header": header, "wrench": vectors}


def test_a_pause_behind_an_insertion_is_no_part_of_the_try(tmp_path, capsys):
    source = Bag(ROOT / "bags" / "working_cycle.mcap")
    rows = list(source.messages(["/wrench", "/joint_states"]))
    path, cycles, summary = tmp_path / "p.mcap", tmp_path / "c.jsonl", tmp_path / "s.json"
    out = tmp_path / "out.mcap"
    with BagWriter(path) as bag:
        # The second try up to its end in the hole, an hour of nothing, the beginning once more.
        for begin, end, later in ((8.5, 11.7, 0), (0.0, 2.5, HOUR)):
            for item in rows:
                if begin <= (item.log_ns - rows[0].log_ns) / SECOND <= end:
                    kind, message = plain(item)
                    stamp = message["header"]["stamp"]
                    stamp["sec"] += later
                    t_ns = stamp["sec"] * SECOND + stamp["nanosec"]
                    bag.write(item.topic, kind, message, t_ns)
    told = ["--cycles", str(cycles), "--summary", str(summary), "--out", str(out)]
    assert main(["replay", str(path), *told]) == 0
    first, second = map(json.loads, cycles.read_text().splitlines())
    assert (first["outcome"], second["outcome"]) == ("inserted", "unfinished")
    # From 8.75 s, through gamma0 at 10.287 s, to the end of the recording.
    assert first["duration"] == pytest.approx(2.946, abs=0.1)
    assert first["transition_time"] == pytest.approx(1.534, abs=0.05)
    begun = rows[0].log_ns / SECOND
    assert second["start_time"] - begun - 8.5 == pytest.approx(3592.75, abs=0.1)
    assert second["duration"] == pytest.approx(1.25, abs=0.1)
    content = json.loads(summary.read_text())
    assert content["messages"]["events"]["gap"] == 1
    assert content["cycles"] == [first, second]
    # As the node publishes them: the first before the second begins, as soon as the clock goes on.
    published = list(Bag(out).messages(["/peg_on_hole/cycle"]))
    assert [json.loads(item.message.data) for item in published] == [first, second]
    resumed = rows[0].log_ns + HOUR * SECOND
    assert resumed < published[0].log_ns < resumed + 0.1 * SECOND
    table = capsys.readouterr().out
    assert "inserted" in table and "unfinished" in table
