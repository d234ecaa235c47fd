"""Estimates read back from a bag: what another program wrote under their names is refused."""

import re

import numpy as np
import pytest

from estimates import estimate, messages
from peg_on_hole_ros.bags.estimates import Output, estimates
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.beside_estimates import OutputStream, joint_state
from small_bags import MS

T_NS = 10**9


def bag(path, **others):
    """Return a bag of two estimates; at the second stamp, messages of others by topic."""
    output = OutputStream(Scene())
    with BagWriter(path) as writer:
        for t_ns in (T_NS, T_NS + MS):
            for topic, ros_type, message in messages(output, estimate(t_ns)):
                if t_ns > T_NS and topic in others:
                    message = others[topic]
                writer.write(f"/peg_on_hole/{topic}", ros_type, message, t_ns)
    return Bag(path)


def test_each_stamp_has_the_values_that_were_written(tmp_path):
    rows, expected = list(estimates(bag(tmp_path / "own.mcap"))), estimate()
    assert [row.t_ns for row in rows] == [T_NS, T_NS + MS]
    for row in rows:
        assert row.values.tolist() == [*expected.state, *expected.normal, *expected.slip_speed]
        assert row.stddev[6:9].tolist() == expected.normal_stddev.tolist()
        known = {name: value for name, value in row.monitor.items() if not np.isnan(value)}
        assert (known, row.mode) == (expected.monitor, expected.contact_mode)


@pytest.mark.parametrize("topic", ["state", "state_stddev", "contacts", "contacts_stddev"])
def test_messages_of_another_program_are_refused(tmp_path, topic):
    other = joint_state(T_NS + MS, ["x", "y"], [0.0, 1.0])
    # Of the six values of its own the other has two where a state is, and none where contacts are.
    count = 8 if topic.startswith("state") else 6
    path = tmp_path / "other.mcap"
    rows = estimates(bag(path, **{topic: other}))
    assert next(rows).t_ns == T_NS
    stddev = "_stddev" if topic.endswith("_stddev") else ""
    topics = f"state{stddev} and contacts{stddev}"
    message = (
        f"{path} is no output of replay or node: {topics} of the stamp 1.001000000 s "
        f"have {count} values, not 12"
    )
    with pytest.raises(BagError, match=re.escape(message)):
        next(rows)


def test_topics_that_a_recorder_mixed_come_in_the_order_of_publication(tmp_path):
    output, path, written = OutputStream(Scene(), 500.0), tmp_path / "mixed.mcap", []
    for i in range(20):
        t_ns = T_NS + i * MS
        for number, (topic, ros_type, message) in enumerate(messages(output, estimate(t_ns))):
            # Every topic has its own way; markers, of every second stamp, come before all else.
            way = 0 if topic == "markers" else 3 + number % 4
            written.append((t_ns + way * MS, topic, ros_type, message))
    with BagWriter(path) as writer:
        for log_ns, topic, ros_type, message in sorted(written, key=lambda item: item[0]):
            writer.write(f"/peg_on_hole/{topic}", ros_type, message, log_ns)
    found = Output(Bag(path), rest=True)
    rows = list(found)
    assert [row.t_ns for row in rows] == [T_NS + i * MS for i in range(20)]
    assert found.incomplete == 0
    assert sorted(rows[0].messages) == sorted(found.topics)


def test_a_stamp_that_was_lost_in_part_holds_up_no_other(tmp_path, monkeypatch):
    monkeypatch.setattr("peg_on_hole_ros.bags.estimates._MOST_PENDING", 4)
    output, path = OutputStream(Scene()), tmp_path / "lost.mcap"
    lost = {5: "state", 9: "monitor", 19: "state"}
    with BagWriter(path) as writer:
        for i in range(20):
            t_ns = T_NS + i * MS
            for topic, ros_type, message in messages(output, estimate(t_ns)):
                if topic != lost.get(i):
                    writer.write(f"/peg_on_hole/{topic}", ros_type, message, t_ns)
    found = Output(Bag(path))
    assert [row.t_ns for row in found] == [T_NS + i * MS for i in range(20) if i not in lost]
    assert found.incomplete == 3


def test_a_clock_that_goes_back_repeats_stamps(tmp_path):
    output, path = OutputStream(Scene()), tmp_path / "back.mcap"
    stamps = [T_NS + i * MS for i in (0, 1, 2, 1, 2, 3)]
    with BagWriter(path) as writer:
        for log_ns, t_ns in enumerate(stamps):
            for topic, ros_type, message in messages(output, estimate(t_ns, phi=0.1 * log_ns)):
                writer.write(f"/peg_on_hole/{topic}", ros_type, message, log_ns)
    found = Output(Bag(path), rest=True)
    assert [(row.t_ns, row.values[2]) for row in found] == [
        (t_ns, 0.1 * log_ns) for log_ns, t_ns in enumerate(stamps)
    ]
    assert found.incomplete == 0
