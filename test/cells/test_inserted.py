"""The mode `inserted` of a robot cell of another engine, by a depth of formulas of their own."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from arm import Arm
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.messages.stream import SET, message_stream
from peg_on_hole_ros.replay.run import replay_bag
from simulated import ROOT

pytest.importorskip("pinocchio")

BAG, CONFIG = ROOT / "bags" / "cell_ur_like.mcap", ROOT / "config" / "cell_ur_like.yaml"
TOPICS = ["/wrench", "/joint_states"]
# The peg is let go of at 5.9 s, 6 mm deep; it is carried deeper after that, and touches nothing.
DEPTH, TOO_DEEP = 0.005, 0.012


def stated(depth):
    configuration, _ = load(CONFIG)
    return replace(configuration, monitor=replace(configuration.monitor, inserted_depth=depth))


def replayed(depth):
    """Return the contact mode by stamp, and the records of tries."""
    modes, tries = {}, []

    class Sink:
        def take(self, columns):
            modes.update(zip(columns.t_ns.tolist(), columns.modes))
            for _, messages in columns.beside:
                tries.extend(json.loads(m["data"]) for topic, _, m in messages if topic == "cycle")

    found = replay_bag(Bag(BAG), stated(depth), 0.0, [Sink()])
    tries += [json.loads(fields["data"]) for topic, _, fields in found.ending if topic == "cycle"]
    return modes, tries


def depths():
    """Return stamps and depths of the peg's lower end by the robot's joints."""
    joints = load(CONFIG)[0].joints
    arm = Arm(Path(joints.urdf).read_text(encoding="utf-8"), joints.tip_frame)
    hole, found = Rotation.from_euler("xyz", joints.hole_rpy), []
    for item in Bag(BAG).messages(["/joint_states"]):
        stamp, read = item.message.header.stamp, item.message
        position, rotation, _ = arm.tip(dict(zip(read.name, read.position)))
        place = hole.inv().apply(position + rotation.apply(joints.peg_xyz) - joints.hole_xyz)
        found.append((stamp.sec * 10**9 + stamp.nanosec, -place[2]))
    return np.array(found).T


def test_a_peg_that_is_as_deep_as_stated_is_inserted_until_it_is_let_go_of():
    modes, tries = replayed(DEPTH)
    before, unstated = replayed(0.0)
    at = [t for t, mode in modes.items() if mode == "inserted"]
    t_ns, depth = depths()
    # Joints tell the depth to 0.3 mm, and two standard deviations of 1 mm keep it.
    assert np.interp(at[0], t_ns, depth) == pytest.approx(DEPTH, abs=1e-3)
    assert np.interp(at, t_ns, depth).min() > DEPTH - 2.5e-3
    assert len(at) > 50 and all(before[t] in ("two_point", "unknown") for t in at)
    # All else is as it was, and nothing but the mode differs.
    assert all(modes[t] == before[t] for t in modes if modes[t] != "inserted")
    assert "inserted" not in before.values()
    assert [each["outcome"] for each in tries] == ["inserted"]
    assert tries == unstated


def test_a_peg_that_never_gets_as_deep_has_not_gone_in():
    modes, tries = replayed(TOO_DEEP)
    assert "inserted" not in modes.values()
    # It passed gamma0, which is no insertion where a depth is stated.
    assert [each["outcome"] for each in tries] == ["aborted"]
    assert tries[0]["transition_time"] is not None


def test_one_by_one_as_in_the_node_it_is_the_same_and_can_be_set_there():
    at_once, _ = replayed(DEPTH)
    stream, modes, mode = message_stream(stated(0.0), 0.0), {}, ""
    stream.on_event(SET + json.dumps({"monitor.inserted_depth": DEPTH}))
    # The sensor's pose follows from the frame of the first wrench, as the node takes it.
    first = next(iter(Bag(BAG).messages(["/wrench"]))).message
    assert stream.take_frame(first.header.frame_id).success
    for item in Bag(BAG).messages(TOPICS):
        if item.topic == "/joint_states":
            stream.on_joints(item.message)
            continue
        told = stream.on_wrench(item.message)
        mode = next((f["data"] for topic, _, f in told if topic == "contact_mode"), mode)
        if told:
            modes[stream.t_ns] = mode
    assert modes == at_once


def test_the_summary_and_the_index_of_many_bags_have_it(tmp_path):
    path = tmp_path / "cell.yaml"
    text = CONFIG.read_text(encoding="utf-8").replace("urdf: ", f"urdf: {CONFIG.parent}/")
    path.write_text(text + f"    monitor: {{inserted_depth: {DEPTH}}}\n", encoding="utf-8")
    out = tmp_path / "out"
    report, summary = tmp_path / "r.html", tmp_path / "s.json"
    words = ["--config", str(path), "--report", str(report), "--summary", str(summary)]
    assert main(["replay", str(BAG), *words]) == 0
    found = json.loads(summary.read_text(encoding="utf-8"))
    assert 0.0 < found["contact_mode"]["inserted"] < 0.2
    assert [each["outcome"] for each in found["cycles"]] == ["inserted"]
    assert "contact mode inserted" in report.read_text(encoding="utf-8")
    assert main(["replay", str(BAG), "--config", str(path), "--jobs", "1", "--out", str(out)]) == 0
    index = (out / "index.html").read_text(encoding="utf-8")
    assert "1 of 1 tries went in" in index


def test_a_depth_is_asked_of_a_place_that_is_known():
    with pytest.raises(PegOnHoleError, match="inserted_depth = 0.03 m needs the measured place"):
        from_parameters({"monitor.inserted_depth": 0.03})
