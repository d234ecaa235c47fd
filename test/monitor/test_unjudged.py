"""Modes, forecast, risk and alarms left out: the estimate stays, and the topics say so."""

import json
from dataclasses import replace

import numpy as np
import pytest

from cli_helpers import SCHEMA, config
from estimates import columns, messages
from json_schema import check
from late_samples import ordered, shuffled
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.messages.beside_estimates import OutputStream
from peg_on_hole_ros.records import ACCURACIES
from peg_on_hole_ros.replay.summary import Summary
from peg_on_hole_ros.ros.diagnostics import Diagnostics
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.sim.truth import integrate
from simulated import contact_plan, truth

SCENE = "closing_with_slip"
SETTLED = 0.1
NUMBERS = {
    "transition_probability", "friction", "friction_stddev", "clearance", "clearance_stddev",
    "reactions_determined", "joints_noise",
}  # fmt: skip
AT_TIMES = {"nis_median", "nis_drift", *(f"doubt_{kind}" for kind in ACCURACIES)}


def pipeline(modes=False):
    configuration = truth(SCENE).plan.configuration
    return Pipeline(replace(configuration, monitor=replace(configuration.monitor, modes=modes)))


def played(modes):
    found = list(pipeline(modes).play(measure(truth(SCENE), 4)))
    return np.array([(row.t_ns - START_NS) * 1e-9 for row in found]), found


def test_the_estimate_is_that_of_the_whole_monitor_on_three_contacts():
    t, without = played(False)
    _, judged = played(True)
    steady = [
        i for i, row in enumerate(judged) if row.contact_mode == "three_point" and t[i] > SETTLED
    ]
    assert len(steady) > 300
    for i in steady:
        a, b = without[i], judged[i]
        # Until the mode was declared one was predicted at constant rates, the other on contacts;
        # what is left of that is far below the spread, and lasts in the friction learnt.
        spread = np.sqrt(np.diagonal(b.state_covariance))
        assert (np.abs(a.state - b.state) < 0.2 * spread).all()
        assert (np.abs(a.normal - b.normal) < 0.2 * b.normal_stddev + 1e-3).all()


def test_the_flag_rises_by_the_tilt_alone():
    rates = [-0.16, 0.0, 1.0]
    phases = {"enter": {"kind": "two_point", "duration": 0.08, "rates": rates}}
    plan = contact_plan([0.069, 0.0, 0.0], rates, [0.0, 0.0, -0.0005], phases=phases)
    motion, gamma0 = integrate(plan), plan.configuration.scene.gamma0
    options = replace(plan.configuration.monitor, modes=False)
    line = Pipeline(replace(plan.configuration, monitor=options))
    found = list(line.play(measure(motion, 4)))
    t = np.array([row.t_ns - START_NS for row in found])
    raised = t[[row.transition for row in found]]
    entered = motion.t_ns[np.argmax(motion.q[:, 0] < gamma0)]
    assert entered > 0
    assert raised[0] == pytest.approx(entered, abs=2e6)
    # Once in the hole there are no three contacts to speak of, whoever looks.
    assert t[-1] > entered + 2e7
    assert not found[-1].closed.any() and not found[-1].monitor["reactions_determined"]


def test_topics_and_diagnostics_say_that_nothing_was_judged():
    line = pipeline()
    stream, topics, modes = OutputStream(line.scene), set(), []
    for outputs in line.play(measure(truth(SCENE), 4)):
        assert set(outputs.monitor) - AT_TIMES == NUMBERS
        assert np.isfinite(list(outputs.monitor.values())).all()
        for topic, _, fields in messages(stream, outputs):
            topics.add(topic)
            modes += [fields["data"]] if topic == "contact_mode" else []
    assert modes == ["unknown"]
    assert "alarms" not in topics and {"state", "contacts", "transition"} <= topics
    diagnostics = Diagnostics()
    diagnostics.received("wrench", 1, outputs=True)
    report, _ = diagnostics.report(0, 10**9, {}, line.health, line.left_out)
    status = next(item for item in report["status"] if item["name"].endswith("filter"))
    assert "monitor.modes" in status["message"]
    assert "monitor.modes" not in pipeline(True).left_out


def test_a_replay_says_so_and_writes_no_alarms(bag, tmp_path, capsys):
    told = config(tmp_path, "monitor: {modes: false}")
    summary = tmp_path / "s.json"
    assert main(["replay", str(bag), "--config", str(told), "--summary", str(summary)]) == 0
    assert "(monitor.modes)" in capsys.readouterr().out
    found = json.loads(summary.read_text())
    check(found, SCHEMA)
    assert found["contact_mode"] == {"unknown": 1.0}
    assert found["alarms"] == found["cycles"] == []
    # The peg in this bag rests, and the wrench determines no reactions.
    assert found["max_normal"] == dict.fromkeys(("K", "B1", "B2"))


def test_a_summary_has_the_reactions_of_a_peg_that_slides():
    scene = truth(SCENE).plan.configuration.scene
    summary, stream = Summary(), OutputStream(scene, markers_rate=0.0)
    found = list(pipeline().play(ordered(200)))
    for row in found:
        summary.take(columns(stream, row))
    known = [row.normal for row in found if row.monitor["reactions_determined"]]
    assert len(known) > 100
    assert list(summary.content()["max_normal"].values()) == np.max(known, axis=0).tolist()


def test_late_messages_end_where_an_ordered_stream_does():
    samples = ordered()
    first, second = pipeline(), pipeline()
    expected, found = list(first.play(samples)), list(second.play(shuffled(samples, 10_000_000)))
    assert second.counts["went_back"] > 10
    np.testing.assert_array_equal(found[-1].state_covariance, expected[-1].state_covariance)
    np.testing.assert_array_equal(found[-1].normal, expected[-1].normal)
    assert found[-1].monitor == expected[-1].monitor
