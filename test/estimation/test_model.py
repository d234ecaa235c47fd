"""The model that the filter uses: chosen by its error, told in one line, without a jump."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.contact import Prediction
from peg_on_hole_ros.estimation.filters.model import MODELS
from peg_on_hole_ros.ladder.rungs import DYNAMIC, QUASI_STATIC

from peg_on_hole_ros.edges.live.diagnostics import Diagnostics
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.simulation.measure import measure
from simulated import truth

SCENE = "closing_with_slip"
MS = 1_000_000


def pipeline(model, tolerance=0.05):
    configuration = truth(SCENE).plan.configuration
    options = replace(configuration.filter, model=model, reaction_tolerance=tolerance)
    return Pipeline(replace(configuration, filter=options))


def samples(duration_ms=600):
    found = list(measure(truth(SCENE), 5))
    return [s for s in found if s.t_ns - found[0].t_ns < duration_ms * MS]


def play(line, given):
    return list(line.play(given))


@cache
def played(model, tolerance=0.05):
    line = pipeline(model, tolerance)
    return line, play(line, samples())


def errors(outputs):
    """Return errors of the determined reactions over the largest, and over their stated spread."""
    true = truth(SCENE)
    found, over = [], []
    for k, out in enumerate(outputs):
        if out.contact_mode == "three_point" and out.monitor["reactions_determined"]:
            off = out.normal - true.normal[k]
            found.append(off / np.abs(true.normal[k]).max())
            over.append(off / out.normal_stddev)
    return np.array(found), np.array(over)


def test_without_being_asked_for_all_is_as_ever():
    configuration = truth(SCENE).plan.configuration
    assert configuration.filter.model == "dynamic"
    _, asked = played("dynamic")
    assert not any(name.startswith("model") for out in asked for name in out.monitor)


@pytest.mark.parametrize("model", ["small_angle", "quasi_static", "align_slip"])
def test_a_model_that_is_asked_for_is_used_and_says_how_it_errs(model):
    line, outputs = played(model)
    used = [out.monitor["model"] for out in outputs]
    # Before contact is certain there is nothing to choose.
    assert used.count(MODELS[model]) > 0.9 * len(outputs)
    off, over = errors(outputs)
    assert len(off) > 0.9 * len(outputs)
    told = np.array(
        [out.monitor["model_error"] for out in outputs if "model_error" in out.monitor]
    )
    # Sensor noise is in both; what a rung leaves out and says so is in its spread as well.
    assert np.sqrt(np.mean(off**2)) < 0.03 and 0 < told.max() < 0.2
    assert np.mean(np.abs(over) < 1.96) > 0.9
    assert line.model.startswith(f"{model}: asked for; error ")


def test_the_rung_above_is_better():
    rms = [np.sqrt(np.mean(errors(played(model)[1])[0] ** 2)) for model in ("auto", "dynamic")]
    assert rms[1] < 0.5 * rms[0] < 0.5 * 0.05


CHANGING = 0.016


@pytest.fixture(scope="module")
def changing():
    """A tolerance at which the choice changes again and again."""
    return played("auto", CHANGING)


def test_auto_changes_its_model_and_counts_it(changing):
    line, outputs = changing
    used = np.array([out.monitor["model"] for out in outputs])
    assert set(used) >= {QUASI_STATIC, DYNAMIC}
    assert line.counts["model_changed"] == np.count_nonzero(np.diff(used)) > 5
    # Looser: cheaper, and tighter: never anything but the full equations.
    cheap, dear = (
        np.mean([out.monitor["model"] <= QUASI_STATIC for out in played("auto", t)[1]])
        for t in (0.1, 1e-4)
    )
    assert dear == 0 < np.mean(used <= QUASI_STATIC) < cheap


def test_a_change_of_model_leaves_the_estimate_where_it_is(changing):
    outputs = changing[1]
    used = np.array([out.monitor["model"] for out in outputs])
    states = np.array([out.state for out in outputs])
    t = np.array([out.t_ns for out in outputs]) * 1e-9
    # How far the angles are from where the rates just published lead.
    off = np.abs(np.diff(states[:, :3], axis=0) - np.diff(t)[:, None] * states[1:, 3:])
    settled = np.arange(len(off)) > 50
    change = (np.diff(used) != 0) & settled
    rest = ~change & settled
    assert change.sum() > 5
    # Corrections move the angles more than any change of model does.
    assert np.all(off[change].max(axis=0) <= off[rest].max(axis=0))
    # Nor do the reactions move by more than what is stated of them before and after.
    normal = np.array([out.normal for out in outputs])
    variance = np.array([out.normal_stddev for out in outputs]) ** 2
    moved = np.abs(np.diff(normal, axis=0)) / np.sqrt(variance[1:] + variance[:-1])
    assert moved[change].max() < 1.96


def test_both_predictions_from_one_state_lie_within_their_spread():
    """The strict form: what a change of model does to the state within one step."""
    # By the dynamic model so far: it has learnt friction, without which it has no step.
    line = pipeline("auto", 1e-3)
    play(line, samples(300))
    kalman = line.filter
    start, ends = kalman.snapshot(), {}
    for rung in (QUASI_STATIC, DYNAMIC):
        kalman.restore(start)
        kalman.hold(kalman.u.copy())
        kalman.model.choice[:] = 0.0
        kalman.model._fresh, kalman.model.rung = False, rung
        result = kalman.predict(1e-3, True)
        assert result is (Prediction.CONTACT if rung == DYNAMIC else Prediction.HELD)
        ends[rung] = kalman.x.copy(), kalman.P.copy()
    apart = np.abs(ends[QUASI_STATIC][0] - ends[DYNAMIC][0])
    variances = [np.diagonal(end[1]) for end in ends.values()]
    # A third of all draws pass one standard deviation, one in twenty 1.96 of them.
    assert np.all(apart < 1.96 * np.sqrt(np.sum(variances, axis=0))) and apart.max() > 0
    # The noise of a torque turns the peg about its axis by as much as it knows.
    assert np.all(apart[:3] < 5e-4)


def test_late_messages_end_where_the_ordered_ones_do():
    given = samples(250)
    late = [s for s in given if type(s) is JointSample][-30:-10]
    early = [s for s in given if s not in late]
    cut = next(i for i, s in enumerate(early) if s.t_ns > late[-1].t_ns + 10 * MS)
    first, second = pipeline("auto", 0.02), pipeline("auto", 0.02)
    expected = play(first, given)
    found = play(second, [*early[:cut], *late, *early[cut:]])
    assert second.counts["went_back"] > 0
    np.testing.assert_array_equal(found[-1].state, expected[-1].state)
    assert found[-1].monitor == expected[-1].monitor
    assert second.counts["model_changed"] == first.counts["model_changed"]


@pytest.mark.parametrize("model", ["auto", "dynamic", "quasi_static"])
def test_diagnostics_tell_the_model_in_one_line(model):
    """Of the full one nothing is ever decided, and nothing told."""
    line, _ = played(model)
    diagnostics = Diagnostics()
    diagnostics.received("wrench", 1000, True)
    report, _ = diagnostics.report(1, 10**9, {}, line.health, line.model)
    text = report["status"][-1]["message"]
    if model == "dynamic":
        assert (text, line.model) == ("running", "")
        return
    assert text == f"running; {line.model}" and "\n" not in text
    assert line.model.split(":")[0] in MODELS
