"""A side look that fails ends itself alone: the run goes on, with the same estimates."""

import json
from itertools import cycle

import numpy as np
import pytest
import rclpy

from cli_helpers import SCHEMA
from json_schema import check
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.diagnosis.suspected.registry import SUSPECTED
from peg_on_hole_ros.diagnosis.suspected.suspect import has_part
from peg_on_hole_ros.identification.likelihood import Likelihood
from peg_on_hole_ros.monitor import still_possible
from peg_on_hole_ros.replay.looped_recording import LoopedRecording
from peg_on_hole_ros.replay.topic_findings import TopicOddities
from peg_on_hole_ros.ros.node import PegOnHoleNode
from peg_on_hole_ros.ros.process import init
from recorded_faults import BAGS
from tiers import at_push

ERRORS = cycle(
    [np.linalg.LinAlgError("not positive\ndefinite"), KeyError("made up"), TypeError("made up")]
)
# Where each look is entered; the last of a recording's looks are asked after its last message.
ENTERED = "take", "take_every_wrench", "take_estimate"
MADE = {
    member.NAME: (member, next(part for part in ENTERED if has_part(member, part)))
    for member in SUSPECTED
}
ENGINE_MEMORY_BYTES = {"still_possible": (still_possible, "possible")}
LOOKS = (
    MADE
    | ENGINE_MEMORY_BYTES
    | {"oddities": (TopicOddities, "lines"), "loops": (LoopedRecording, "add")}
)
NODE_LOOKS = {name: at for name, at in MADE.items() if not at[0].OFFLINE} | ENGINE_MEMORY_BYTES
ESTIMATE = [
    f"/peg_on_hole/{name}"
    for name in ("state", "state_stddev", "contacts", "contacts_stddev", "contact_mode", "pose")
]


def raising(monkeypatch, owner, name, calls=5):
    """Let a function fail from its fifth call on; return how often it was called."""
    whole, error, called = getattr(owner, name), next(ERRORS), []

    def fail(*arguments):
        called.append(1)
        if len(called) >= calls:
            raise error
        return whole(*arguments)

    monkeypatch.setattr(owner, name, fail)
    return called


def replayed(folder, name, capsys, *more):
    out, summary = folder / f"{name}.mcap", folder / f"{name}.json"
    code = main(["replay", str(BAGS[0]), "--out", str(out), "--summary", str(summary), *more])
    text, content = capsys.readouterr().out, json.loads(summary.read_text(encoding="utf-8"))
    check(content, SCHEMA)
    return code, text, content, out


def estimates(path):
    messages = Bag(path).with_payloads(ESTIMATE)
    return [(item.topic, item.log_ns, bytes(payload)) for item, payload in messages]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    out = tmp_path_factory.mktemp("whole") / "out.mcap"
    assert main(["replay", str(BAGS[0]), "--out", str(out)]) == 0
    return estimates(out)


def says_once(text, content, name):
    (line,) = [line for line in text.splitlines() if line.startswith(f"look_failed_{name}: ")]
    assert "Error: " in line and " at test_fence.py:" in line and "report it" in line
    assert content["messages"]["events"][f"look_failed_{name}"] == 1
    assert content["failed_looks"] == [line]


@pytest.mark.parametrize("name", LOOKS)
def test_a_replay_goes_on_without_a_look_that_fails(name, tmp_path, capsys, monkeypatch, whole):
    once = name in ("still_possible", "oddities", "loops")
    called = raising(monkeypatch, *LOOKS[name], calls=1 if once else 5)
    code, text, content, out = replayed(tmp_path, name, capsys)
    # Once it has failed it is let alone, here and in what is run to have all compiled.
    assert code == 0 and 1 <= len(called) <= 10
    says_once(text, content, name)
    assert estimates(out) == whole


@pytest.mark.parametrize("name", at_push(["wrong_wrench", "free_air", "delay"], list(MADE)))
def test_a_look_that_cannot_even_begin(name, tmp_path, capsys, monkeypatch, whole):
    raising(monkeypatch, LOOKS[name][0], "__init__", calls=1)
    code, text, content, out = replayed(tmp_path, name, capsys)
    assert code == 0 and estimates(out) == whole
    says_once(text, content, name)


class Played:
    """A node that was given a bag, without DDS: what it published, logged and counted."""

    def __init__(self):
        arguments = []
        init(arguments)
        try:
            node = PegOnHoleNode(arguments)
            node.trigger_configure()
            node.trigger_activate()
            self.lines, self.estimates, self.reports = [], [], []
            node._warn = lambda said: self.lines.extend(said)
            node._outputs.publish = lambda published: self.estimates.append(
                [(topic, payload) for topic, payload in published.estimate if topic != "monitor"]
            )
            node._outputs.diagnostics = self.reports.append
            take = {"/wrench": node.arrivals.wrench, "/joint_states": node.arrivals.joints}
            for count, (item, payload) in enumerate(Bag(BAGS[0]).with_payloads(list(take))):
                take[item.topic](payload)
                node.process()
                if count % 300 == 299:
                    node._report()
            self.counts = dict(node._stream.counts)
            node.close()
            node.destroy_node()
        finally:
            rclpy.shutdown()

    @property
    def filter(self):
        """Level and message of the filter's last status."""
        (status,) = [
            each for each in self.reports[-1]["status"] if each["name"].endswith(": filter")
        ]
        return status["level"], status["message"]


@pytest.fixture(scope="module")
def live():
    return Played()


@pytest.mark.xdist_group("dds_starts")
@pytest.mark.parametrize(
    "name", at_push(["wrong_wrench", "unobservable", "still_possible"], list(NODE_LOOKS))
)
def test_a_node_goes_on_without_a_look_that_fails(name, monkeypatch, live):
    once = name == "still_possible"
    raising(monkeypatch, *NODE_LOOKS[name], calls=1 if once else 5)
    node = Played()
    assert node.estimates == live.estimates and len(live.estimates) > 500
    key = f"look_failed_{name}"
    # Nothing restarts the filter, and nothing else is counted.
    assert node.counts == live.counts | {key: 1}
    level, message = node.filter
    assert level == 1 and f"{key}: " in message and live.filter[0] == 0
    assert len([line for line in node.lines if line.startswith(key)]) == 1
    assert not [line for line in live.lines if "look_failed" in line]


@pytest.mark.parametrize("part", ["tracks", "inputs", "page"])
def test_a_report_that_fails_costs_the_report_alone(part, tmp_path, capsys, monkeypatch, whole):
    from peg_on_hole_ros.report import replay_page
    from peg_on_hole_ros.report.inputs import Inputs
    from peg_on_hole_ros.report.tracks import Tracks

    owner, name = {
        "tracks": (Tracks, "take"),
        "inputs": (Inputs, "take_inputs"),
        "page": (replay_page, "_model"),
    }[part]
    raising(monkeypatch, owner, name, calls=1)
    page, out, summary = (tmp_path / each for each in ("r.html", "o.mcap", "s.json"))
    to = "--report", str(page), "--out", str(out), "--summary", str(summary)
    assert main(["replay", str(BAGS[0]), *to]) == 70
    said = capsys.readouterr()
    lines = [each for each in said.err.splitlines() if each.startswith("peg-on-hole: ")]
    assert len(lines) == 1 and "error: a fault of the program, please report it: " in lines[0]
    assert "contact mode: " in said.out and not page.exists()
    content = json.loads(summary.read_text(encoding="utf-8"))
    check(content, SCHEMA)
    says_once(said.out, content, "report")
    assert estimates(out) == whole


def test_a_covariance_that_is_not_positive_definite_is_no_error(tmp_path, capsys, monkeypatch):
    """Rounding leaves such ones of a scene that is far off: calibrate then answers in a line."""
    whole = Likelihood.run

    def run(self, x, chosen=None, detailed=False):
        found = whole(self, x, chosen, detailed)
        if detailed and found is not None:
            # Its trace stays: one without any is of no innovation.
            middle = found.innovations.covariance[len(found.innovations.covariance) // 2]
            middle[0, 1] = middle[1, 0] = 10.0 * np.trace(middle)
        return found

    monkeypatch.setattr(Likelihood, "run", run)
    out = tmp_path / "c.yaml"
    path = next(each for each in BAGS if each.stem == "closing_with_slip")
    assert main(["calibrate", str(path), "--out", str(out)]) == 3
    (line,) = [each for each in capsys.readouterr().err.splitlines() if "error: " in each]
    assert "the sensor's pose" in line and not out.exists()
