"""Faults that reach the real node over DDS: what is wrong is told, and what is true stays told."""

import pytest

from benchmarks.faults import live
from benchmarks.faults.expected import BY_NAME
from benchmarks.faults.injector import inject
from benchmarks.faults.scenes import scene

pytestmark = pytest.mark.xdist_group("dds")


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        pytest.param("jam", "encoders stand still", marks=pytest.mark.nightly),
        pytest.param("jam", "wrench noise x 5", marks=pytest.mark.nightly),
        ("closing", "no messages for a while"),
    ],
)
def test_a_fault_is_told_by_the_node_and_neither_flag_nor_jam_is_wrong(tmp_path, name, fault):
    assert live.run(name, BY_NAME[fault], tmp_path) == []


def test_a_bag_of_a_fault_holds_its_messages_in_their_order(tmp_path):
    from peg_on_hole_ros.bags.reader import Bag

    recorded = scene("closing", tmp_path)
    late = inject(recorded.recording, "late", share=0.05)
    live.write(tmp_path / "late.mcap", recorded, late)
    bag = Bag(tmp_path / "late.mcap")
    read = [(row.topic, row.message.header.stamp) for row in bag.messages(bag.topics)]
    sent = [
        ("/wrench" if hasattr(item.sample, "force") else "/joint_states", item.sample.t_ns)
        for item in late
    ]
    assert [(topic, stamp.sec * 10**9 + stamp.nanosec) for topic, stamp in read] == sent
    assert sent != sorted(sent, key=lambda row: row[1])
