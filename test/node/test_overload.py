"""A node that is too slow for its input: everything is counted, told, and calls are answered."""

from collections import Counter, deque

import pytest
import rclpy

from inputs import joints, wrench
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.cdr_layout import stamp_ns
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.ros import process
from peg_on_hole_ros.ros.diagnostics import Diagnostics
from peg_on_hole_ros.ros.inputs import WaitingMessages

ENCODE = {"wrench": Encoder(WRENCH_TYPE), "joints": Encoder(JOINTS_TYPE)}
MS = 1_000_000
ASKED = 2000


class Events:
    """An executor that has its events in one row, as EventsExecutor does."""

    def __init__(self, node):
        self.node, self.waiting = node, deque()

    def add_node(self, node):
        pass

    remove_node = add_node

    def spin_once(self, timeout_sec):
        if self.waiting:
            self.waiting.popleft()()


class Busy:
    """A node to which `rate` messages come while it works one off, and a call in between."""

    def __init__(self, rate, stopping):
        self.arrivals = WaitingMessages(200)
        self.rate, self.stopping = rate, stopping
        self.worked, self.answered_after = 0, None
        self.events = Events(self)
        self.held = deque()
        self.t_ns = 0

    def come(self):
        for _ in range(self.rate):
            self.t_ns += MS
            self.held.append(ENCODE["wrench"](wrench(self.t_ns)))
            self.events.waiting.append(self.take)

    def take(self):
        if self.held:
            self.arrivals.wrench(self.held.popleft())

    def take_waiting(self):
        count = len(self.held)
        while self.held:
            self.take()
        return count

    def answer(self):
        self.answered_after = self.worked - ASKED
        self.stopping.append(0)

    def process(self, most=None):
        for count, _ in enumerate(self.arrivals.take(), 1):
            self.worked += 1
            self.come()
            if self.worked == ASKED:
                self.events.waiting.append(self.answer)
            if self.worked > 10 * ASKED:
                self.stopping.append(0)
            if count == most:
                return


@pytest.mark.parametrize("rate", [9, 30])
def test_a_call_does_not_wait_behind_the_messages_of_an_overloaded_node(rate, monkeypatch):
    stopping = []
    node = Busy(rate, stopping)
    node.come()
    monkeypatch.setattr(process, "_executor", lambda: node.events)
    monkeypatch.setattr(rclpy, "ok", lambda: True)
    process.spin(node, stopping)
    # What came during one turn of work is all that stands before it.
    assert node.answered_after is not None and node.answered_after <= process.MOST_WORK


def test_what_there_is_no_room_for_is_pushed_out_in_the_order_of_stamps_and_counted():
    lost = []
    arrivals = WaitingMessages(3, lost.append)
    for t in range(1, 5):
        arrivals.joints(ENCODE["joints"](joints(2 * t)))
        arrivals.wrench(ENCODE["wrench"](wrench(2 * t - 1)))
        arrivals.wrench(ENCODE["wrench"](wrench(2 * t)))
    assert arrivals.received == 12
    # Joint states as old as the wrenches go with them: else these alone would wait, and be lost.
    assert "".join(source[0] for source in lost) == "wjwwjww"
    left = [(source[0], stamp_ns(payload)) for source, payload in arrivals.take()]
    assert left == [("j", 6), ("w", 6), ("w", 7), ("j", 8), ("w", 8)]


def test_diagnostics_say_who_is_too_slow_by_the_nodes_own_work():
    counts = {"wrench_dropped_overload": 30, "joints_dropped_overload": 5}
    diagnostics = Diagnostics()
    for source, count in (("wrench", 10), ("joints", 5)):
        for _ in range(count):
            diagnostics.received(source, 1, outputs=source == "wrench")
    report, lines = diagnostics.report(0, 10**9, counts, {})
    entries, timing = report["status"][:2]
    values = {item["key"]: item["value"] for item in entries["values"]}
    assert (values["wrench_rate"], values["joints_rate"]) == ("40", "10")
    assert entries["level"] == timing["level"] == 1
    # It had next to nothing to do: the machine did not let it.
    assert timing["message"].startswith("other programs take the processor from the node: ")
    assert lines[0] == f"{timing['message']} (the node was busy for 0 % of the time)"
    # Nothing of it is left in the next second.
    report, lines = diagnostics.report(0, 10**9, counts, {})
    assert report["status"][1]["message"] == "keeping up" and lines == []
    diagnostics.received("wrench", 950_000_000)
    report, lines = diagnostics.report(0, 10**9, counts, {})
    timing = report["status"][1]
    assert timing["message"].startswith("too slow for this input rate")
    assert lines == [f"{timing['message']} (the node was busy for 95 % of the time)"]


@pytest.mark.parametrize(
    ("age_s", "told"),
    [
        (0.9, ""),
        (-0.9, ""),
        (12.5, "; stamps are 12.5 s behind this node's clock"),
        (-3.6e3, "; stamps are 3600.0 s ahead of this node's clock"),
    ],
)
def test_stamps_of_another_clock_are_told_beside_the_latency(age_s, told):
    diagnostics = Diagnostics()
    diagnostics.aged(round(age_s * 1e9))
    report, lines = diagnostics.report(0, 10**9, {}, {})
    timing = report["status"][1]
    assert timing["message"] == f"keeping up{told}" and timing["level"] == 0 and lines == []
    # A node that has no clock yet tells none.
    diagnostics.aged(None)
    report, _ = diagnostics.report(0, 10**9, {}, {})
    assert report["status"][1]["message"] == "keeping up"


def test_each_entry_begins_with_the_name_of_its_node():
    for diagnostics, begin in (
        (Diagnostics(), "peg_on_hole"),
        (Diagnostics(name="left/peg_on_hole"), "left/peg_on_hole"),
    ):
        report, _ = diagnostics.report(0, 10**9, {}, {})
        names = [status["name"] for status in report["status"]]
        assert names == [f"{begin}: {part}" for part in ("input", "timing", "output", "filter")]


def test_a_gripper_on_the_topic_of_the_joint_states_is_no_trouble():
    diagnostics, total, found = Diagnostics(), Counter(), []
    # Seconds of: both, the gripper alone, the robot alone.
    for used, missing in ((100, 50), (0, 50), (100, 0)):
        total.update(joints_used=used, joints_dropped_missing_joint=missing, wrench_used=1000)
        for source in ("wrench", "joints"):
            diagnostics.received(source, 1)
        report, lines = diagnostics.report(0, 10**9, total, {})
        status = report["status"][0]
        values = {item["key"]: item["value"] for item in status["values"]}
        assert values["joints_dropped_missing_joint"] == str(total["joints_dropped_missing_joint"])
        found.append((status["level"], status["message"], lines))
    assert found == [
        (0, "all messages used, but 50 joint states of another driver", []),
        (
            1,
            "not used: 50 joints_dropped_missing_joint",
            ["joints dropped missing joint: 50 times"],
        ),
        (0, "all messages used", []),
    ]
    total.update(joints_used=1, joints_dropped_missing_joint=1)
    assert diagnostics.rest(total) == []
