"""Wrenches whose frame_id is not that of the first: counted and told, live and in a replay."""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.messages.stream import message_stream
from small_bags import JOINTS, MS, WRENCH, header, joints, wrench

BEGIN, COUNT, CHANGE = 10**9, 400, 300


def framed(t_ns, frame):
    return wrench(t_ns) | {"header": header(t_ns, frame)}


def frames_of(after):
    """Return the frame of each wrench: from CHANGE on those of `after`, in turns."""
    return ["sensor"] * CHANGE + [after[i % len(after)] for i in range(COUNT - CHANGE)]


def bag_of(path, frames):
    with BagWriter(path) as bag:
        for i, frame in enumerate(frames):
            t_ns = BEGIN + i * MS
            if i % 2 == 0:
                bag.write("/joint_states", JOINTS, joints(t_ns), t_ns)
            bag.write("/wrench", WRENCH, framed(t_ns, frame), t_ns)
    return path


def attributes(fields):
    if isinstance(fields, dict):
        return SimpleNamespace(**{name: attributes(value) for name, value in fields.items()})
    return fields


def live(frames, configuration=None):
    stream = message_stream(configuration or Configuration())
    for i, frame in enumerate(frames):
        t_ns = BEGIN + i * MS
        if i % 2 == 0:
            stream.on_joints(attributes(joints(t_ns)))
        stream.on_wrench(attributes(framed(t_ns, frame)))
    return stream


def replayed(tmp_path, frames, *arguments):
    path = bag_of(tmp_path / "a.mcap", frames)
    assert main(["replay", str(path), "--summary", str(tmp_path / "s.json"), *arguments]) == 0
    return json.loads((tmp_path / "s.json").read_text())["messages"]


CASES = {
    "other axes": (["turned"], COUNT - CHANGE, "since 0.300 s, 'sensor' before"),
    "two sensors": (["turned", "sensor"], (COUNT - CHANGE) // 2, "two publish on one topic"),
}


@pytest.mark.parametrize("case", CASES)
def test_another_frame_is_counted_and_told_live_and_in_a_replay(case, tmp_path, capsys):
    after, dropped, words = CASES[case]
    frames = frames_of(after)
    stream = live(frames)
    assert stream.counts["wrench_dropped_other_frame"] == dropped
    # One wrench waits for what may come late.
    assert stream.counts["wrench_used"] >= COUNT - dropped - 1
    (line,) = (cause for cause in stream.causes if "frame_id" in cause)
    assert words in line and f"'turned' ({dropped})" in line
    found = replayed(tmp_path, frames)
    assert found["dropped"]["wrench_dropped_other_frame"] == dropped
    assert found["used"] >= COUNT - dropped
    told = [x for x in capsys.readouterr().out.splitlines() if "frame_id" in x or "clocks" in x]
    assert told == [line]
    assert main(["inspect", str(tmp_path / "a.mcap")]) == 0
    out = capsys.readouterr().out
    assert f"/{line}" in out and f"other_frame: {dropped}" in out


def test_all_are_used_where_the_pose_is_stated_whatever_the_frame():
    configuration = Configuration()
    stated = replace(configuration.wrench, sensor_pose="stated")
    stream = live(frames_of(["turned"]), replace(configuration, wrench=stated))
    assert "wrench_dropped_other_frame" not in stream.counts
    assert not any("frame_id" in cause for cause in stream.causes)


def test_a_wrench_without_a_frame_is_of_the_same_sensor(tmp_path):
    frames = ["", *frames_of(["", "sensor"])[1:]]
    assert "wrench_dropped_other_frame" not in live(frames).counts
    assert "wrench_dropped_other_frame" not in replayed(tmp_path, frames)["dropped"]
    assert len(Bag(tmp_path / "a.mcap").topics) == 2
