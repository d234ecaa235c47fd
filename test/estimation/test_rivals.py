"""Filters that begin with other frictions find the one that fits, and no other wins."""

from dataclasses import replace
from functools import cache
from math import exp

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters import rivals
from peg_on_hole_ros.estimation.filters.contact import ContactFilter
from peg_on_hole_ros.estimation.filters.outcomes import Correction, Prediction, Reactions
from peg_on_hole_ros.estimation.filters.rivals import (
    BALANCED,
    CONVINCING,
    HOPELESS,
    MOST,
    NO_STEP_FOR,
    UNBALANCED,
    Rivals,
)
from peg_on_hole_ros.estimation.filters.smoother import SmoothingFilter
from peg_on_hole_ros.estimation.kernel import friction_doubt
from peg_on_hole_ros.estimation.steps.choice import LONG_STEP

from grid_cells import Motion, truth_of, with_noise
from peg_on_hole_ros.options import FilterOptions
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.simulation.measure import START_NS, measure

FRICTION, STATED, STDDEV = 0.5, 0.75, 0.125
MS = 1_000_000
Q, R = np.array([0.02, 0.1, 0.2]), 1e-8 * np.eye(3)


@cache
def closing():
    return with_noise(truth_of(Motion(5e-4, FRICTION, 0.16, "align"))[0], "nominal", STDDEV)


def told(coefficient=STATED, **filter_options):
    configuration = closing().plan.configuration
    return replace(
        configuration,
        scene=replace(configuration.scene, friction=coefficient),
        filter=replace(configuration.filter, **filter_options),
    )


def played(pipeline, seed, least=None):
    """Return the outputs, of the first `least` samples."""
    outputs = []
    for sample in measure(closing(), seed):
        outputs += [given] if (given := pipeline.on_sample(sample)) else []
        if len(outputs) == least:
            break
    return outputs


# From one and a half of it the estimate runs to one that is greater, by five of its deviations.
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_friction_stated_far_too_high_is_found_where_a_motion_fits_two(seed, monkeypatch):
    pipeline = Pipeline(told())
    outputs = played(pipeline, seed)
    friction, stddev = pipeline.filter.friction
    assert pipeline.counts["friction_replaced"] >= 1
    assert abs(friction - FRICTION) < min(3 * stddev, 0.05 * FRICTION)
    # While it is not told which fits, that is told; and it costs nothing any more once it is.
    rival_counts = [given.monitor.get("friction_rivals", 0.0) for given in outputs]
    assert max(rival_counts) == 2.0 and rival_counts[-1] == 0.0
    monkeypatch.setattr(Rivals, "begin", lambda *arguments: None)
    alone = Pipeline(told())
    after = played(alone, seed)[250].monitor
    assert abs(after["friction"] - FRICTION) > 5 * after["friction_stddev"]
    assert "friction_rivals" not in after and not alone.counts["friction_replaced"]


def test_a_friction_stated_as_it_is_keeps_its_estimate():
    for seed in (1, 2, 3):
        pipeline = Pipeline(told(FRICTION))
        played(pipeline, seed)
        assert not pipeline.counts["friction_replaced"]
        friction, stddev = pipeline.filter.friction
        assert abs(friction - FRICTION) < 3 * stddev


# The unscented filter has the extended one's memory.
@pytest.mark.parametrize("method", ["extended", "iterated", "square_root"])
def test_each_method_goes_on_from_the_one_that_fits(method):
    pipeline = Pipeline(told(method=method))
    played(pipeline, 1, 350)
    assert pipeline.counts["friction_replaced"] >= 1
    assert abs(pipeline.filter.friction[0] - FRICTION) < 0.05
    if method == "square_root":
        kalman = pipeline.filter
        np.testing.assert_allclose(
            kalman._root @ kalman._root.T, kalman.joint_covariance(), atol=1e-15
        )


def test_going_back_before_another_friction_won_is_bit_for_bit():
    configuration, samples = told(late_window=0.05), list(measure(closing(), 1))
    pipeline, outputs, replaced = Pipeline(configuration), {}, None
    for sample in samples:
        given = pipeline.on_sample(sample)
        if given is not None:
            outputs[given.t_ns] = given
            if replaced is None and pipeline.counts["friction_replaced"]:
                replaced = given.t_ns
    # A wrench from before comes after it.
    late = next(
        sample
        for sample in samples
        if isinstance(sample, WrenchSample) and sample.t_ns > replaced - 10 * MS
    )
    rest = [sample for sample in samples if sample is not late]
    at = next(k for k, sample in enumerate(rest) if sample.t_ns > replaced + 10 * MS)
    again, seen = Pipeline(configuration), 0
    for given in again.play([*rest[:at], late, *rest[at:]]):
        if given.t_ns > replaced + 11 * MS:
            assert given.state.tolist() == outputs[given.t_ns].state.tolist()
            assert given.monitor == outputs[given.t_ns].monitor
            seen += 1
    assert again.counts["went_back"] == 1 and seen > 100
    assert again.counts["friction_replaced"] == pipeline.counts["friction_replaced"]


def test_a_smoother_estimates_the_same_and_passes_nothing_back_through_the_exchange():
    live = Pipeline(told())
    smoothing = Pipeline(told(), make=SmoothingFilter)
    for one, other in zip(played(live, 1), played(smoothing, 1), strict=True):
        assert one.state.tolist() == other.state.tolist()
    assert smoothing.counts["friction_replaced"] == 1
    cuts = [k for k, record in enumerate(smoothing.filter._records) if record.F is None]
    assert len(cuts) == 1
    smoothed = smoothing.filter.smooth()
    assert all(np.isfinite(mean).all() for _, mean, *_ in smoothed)


def test_none_begin_where_friction_is_known_or_more_is_learnt_or_none_are_wanted():
    scene = closing().plan.configuration.scene
    known = replace(told(), scene=replace(scene, friction_stddev=0.0))
    biased = replace(told(), wrench=replace(told().wrench, bias_force_stddev=0.5))
    wide = replace(told(), scene=replace(told().scene, clearance_stddev=1e-5))
    alone = told(friction_rivals=False)
    for configuration in (known, biased, wide, told(friction="considered"), alone):
        for given in played(Pipeline(configuration), 1, 100):
            assert "friction_rivals" not in given.monitor


def test_a_reset_gives_them_up_and_a_restart_keeps_them():
    pipeline = Pipeline(told())
    played(pipeline, 1, 40)
    assert pipeline.processor._rivals.count == 2
    snapshot = pipeline.processor.snapshot()
    pipeline.processor.restart()
    assert pipeline.processor._rivals.count == 2
    pipeline.processor.restore(snapshot)
    pipeline.reset()
    assert pipeline.processor._rivals.count == 0


class Foretelling:
    """A filter that foretells as well as it is told to."""

    options = FilterOptions()

    def __init__(self, friction=(0.2, 0.01)):
        self.friction, self.stated_friction = friction, (0.2, 0.05)
        self.friction_is_open, self.learns_clearance = True, False
        self.nis, self.root, self.found, self.trusted = 3.0, 1.0, None, 0
        self.result, self.steps = Correction.USED, Prediction.CONTACT
        self.unbalance = None

    def estimate(self):
        return self.friction

    def go_on_from(self, estimate):
        self.friction = estimate

    def take_friction(self, value, variance):
        self.friction = value, variance**0.5

    def predict(self, dt, in_contact):
        return self.steps

    def correct(self, q, R):
        return self.result, self.nis

    def reactions(self):
        return self.found

    def trust_steps(self):
        self.trusted += 1

    def last_innovation(self):
        return [0.0] * 3, [self.root, 0, 0, 0, self.root, 0, 0, 0, self.root]


def beside(own):
    """Return rivals that have begun beside a filter, and their filters."""
    made = []
    found = Rivals(lambda: made.append(Foretelling()) or made[-1])
    found.begin(own)
    return found, made


def corrected(found, own, prediction=Prediction.CONTACT):
    found.predict(1e-3, True, own, prediction)
    return found.correct(Q, R, own, own.result, own.nis)


def test_the_likelier_takes_the_place_once_it_is_convincing():
    own = Foretelling()
    found, (low, high) = beside(own)
    assert low.friction == pytest.approx((0.1, 0.05)) and high.friction[0] == pytest.approx(0.3)
    # By their spread about the stated value they begin two behind; each correction gives one.
    own.nis, high.nis, low.nis = 5.0, 3.0, 5.0
    replaced = [corrected(found, own) for _ in range(int(CONVINCING) + 3)]
    assert replaced == [False] * (len(replaced) - 1) + [True]
    assert own.friction[0] == pytest.approx(0.3) and high.friction[0] == 0.2
    # What was replaced is as far behind now.
    own.nis, high.nis = 3.0, 5.0
    left = [corrected(found, own) or found.count for _ in range(6)]
    assert left[-1] < left[0] <= 2


def test_a_wider_spread_is_less_likely_by_its_volume():
    own = Foretelling()
    found, (low, _) = beside(own)
    low.root = exp(-0.5)
    for _ in range(6):
        assert not corrected(found, own)
    assert corrected(found, own) and own.friction[0] == pytest.approx(0.1)


@pytest.mark.parametrize("result", [Prediction.FAILED, Prediction.SLOW, Prediction.FREE])
def test_what_leaves_no_step_may_lose_and_not_win(result):
    own = Foretelling()
    found, (low, high) = beside(own)
    own.nis, low.nis, high.nis = 9.0, 3.0, 14.0
    low.steps = high.steps = result
    for _ in range(int(HOPELESS)):
        assert not corrected(found, own)
    assert found.count == 1
    # Nor has it gained by that once there is a step again.
    low.steps, own.nis = Prediction.CONTACT, 3.0
    assert not corrected(found, own)


def test_while_friction_may_be_another_no_step_is_doubted():
    own = Foretelling()
    found, (low, high) = beside(own)
    corrected(found, own)
    assert own.trusted == low.trusted == high.trusted == 1
    for _ in range(10):
        own.nis, low.nis, high.nis = 3.0, 20.0, 20.0
        corrected(found, own)
    asked = own.trusted
    assert found.count == 0
    corrected(found, own)
    assert own.trusted == asked


def test_an_estimate_that_is_bridged_gains_and_loses_nothing():
    own = Foretelling()
    found, (low, high) = beside(own)
    own.nis, low.nis, high.nis = 9.0, 3.0, 15.0
    for _ in range(int(HOPELESS)):
        assert not corrected(found, own, Prediction.SLOW)
    assert found.count == 2
    own.nis, low.nis = 3.0, 3.0
    assert not corrected(found, own)


@pytest.mark.parametrize(
    ("steps", "its"), [(Prediction.CONTACT, None), (Prediction.SLOW, (1.0, 1.0, 1.0))]
)
def test_bridged_they_are_told_apart_by_how_their_forces_balance(steps, its):
    own = Foretelling()
    found, (low, high) = beside(own)
    # One has steps or is in balance, the other has no step and its forces are not weighed.
    low.steps, low.unbalance, high.steps = steps, its, Prediction.SLOW
    own.unbalance = 3.0, 0.0, 0.0
    gain = 0.5 * (9.0 - 3.0 - BALANCED)
    needed = int((CONVINCING + 2.0) / gain) + 1
    told = [corrected(found, own, Prediction.SLOW) for _ in range(needed)]
    assert told == [False] * (needed - 1) + [True]
    assert own.friction[0] == pytest.approx(0.1)
    assert [rival.balanced for rival in found._all] == [0.0, 0.0]


def test_forces_that_balance_again_take_back_what_was_said_for_a_rival():
    own = Foretelling()
    found, (low, _) = beside(own)
    own.unbalance = 3.0, 0.0, 0.0
    assert not any(corrected(found, own, Prediction.SLOW) for _ in range(5))
    assert found._all[0].balanced > 0.0
    own.unbalance = None
    assert not any(corrected(found, own) for _ in range(5))
    assert found._all[0].balanced == 0.0
    # An outlier is bounded.
    own.unbalance = 100.0, 0.0, 0.0
    assert not corrected(found, own, Prediction.SLOW)
    assert found._all[0].balanced == 0.5 * (UNBALANCED - 2.0 * BALANCED)


def test_one_whose_forces_balance_is_not_given_up_for_its_innovations_alone():
    own = Foretelling()
    found, (low, high) = beside(own)
    own.unbalance, low.unbalance, low.steps = (2.9, 0.0, 0.0), (0.0, 0.0, 0.0), Prediction.SLOW
    high.steps = Prediction.SLOW
    for _ in range(2):
        assert not corrected(found, own, Prediction.SLOW)
    gained = found._all[0].balanced
    assert gained > 4.0
    # Ten behind and more by its steps, as the other is, whose forces were not weighed.
    own.unbalance = low.unbalance = None
    low.steps = high.steps = own.steps
    low.nis = high.nis = 3.0 + 2.0 * (HOPELESS - 1.5)
    assert not corrected(found, own)
    assert [rival.filter for rival in found._all] == [low]
    assert found._all[0].ahead < -HOPELESS < found._all[0].lead


def test_one_that_was_as_near_keeps_what_its_forces_told():
    own = Foretelling()
    found, (low, high) = beside(own)
    own.unbalance = 3.0, 0.0, 0.0
    low.unbalance, high.unbalance = (0.5, 0.0, 0.0), (0.0, 0.0, 0.0)
    low.steps = high.steps = Prediction.SLOW
    while not corrected(found, own, Prediction.SLOW):
        near = found._all[0].lead - found._all[1].lead
    assert own.friction[0] == pytest.approx(0.3)
    # The one beside the likeliest is as far behind as it was, and no farther.
    assert near - 0.5 < found._all[0].lead < 0.0
    assert found._all[1].lead < -CONVINCING


def friction_after(motion, stated, stddev, seed, ms):
    """Return friction as it is learnt after a time, and the deviation that is given out."""
    truth = with_noise(truth_of(motion)[0], "nominal", stddev)
    configuration = truth.plan.configuration
    scene = replace(configuration.scene, friction=stated)
    pipeline = Pipeline(replace(configuration, scene=scene))
    for outputs in pipeline.play(measure(truth, seed)):
        if outputs.t_ns - START_NS >= ms * MS:
            return outputs.monitor["friction"], outputs.monitor["friction_stddev"]
    return None


@pytest.mark.parametrize("seed", [700, 704])
def test_a_friction_that_is_bridged_and_out_of_balance_gives_way(seed, monkeypatch):
    """Three quarters in pure align, where K has to pull: its steps find no slip to be told."""
    told = Motion(5e-4, 0.5, 0.16, "align"), 0.75, 0.125, seed, 400
    friction, stddev = friction_after(*told)
    assert abs(friction - 0.5) < 3.5 * stddev < 0.05
    monkeypatch.setattr(rivals, "_unbalance", lambda *of: None)
    assert friction_after(*told)[0] > 0.7


def test_a_friction_far_below_is_found_where_none_above_leaves_a_step(monkeypatch):
    told = Motion(1e-4, 0.5, 0.16, "slip"), 0.75, 0.05, 1, 200
    friction, stddev = friction_after(*told)
    assert abs(friction - 0.5) < 3.5 * stddev < 0.01
    monkeypatch.setattr(friction_doubt, "SEEK_FARTHER", np.inf)
    assert friction_after(*told) == pytest.approx((0.65, 0.05), abs=1e-3)


def test_what_rivals_say_is_in_the_spreads_by_their_probability():
    own = Foretelling((0.3, 0.01))
    found, (low, high) = beside(own)
    low.friction, high.friction = (0.2, 0.02), (0.34, 0.03)
    low.found = Reactions((8.0, 4.0, 0.0), (2.0, 3.0, 4.0), 0.5)
    normal, stddev = np.array([10.0, 20.0, 30.0]), np.array([1.0, 50.0, 1.0])
    # Both begin two behind; one has no reactions.
    weight = exp(-2.0)
    spread = 0.01**2 + weight * (0.02**2 + 0.1**2 + 0.03**2 + 0.04**2)
    friction, widened = found.widened(own, normal, stddev)
    assert friction == pytest.approx((spread / (1 + 2 * weight)) ** 0.5)
    forces = [1 + weight * (4 + 4), 50**2 + weight * (9 + 256), 1 + weight * (16 + 900)]
    expected = np.sqrt(np.array(forces) / (1 + weight))
    # No less than the estimate's own.
    np.testing.assert_allclose(widened, [expected[0], 50.0, expected[2]])
    # As long as friction is as it was stated, its own spread says it all.
    own.friction = 0.3, 0.049
    assert found.widened(own, normal, stddev) == (0.049, stddev)
    found.restart()
    own.friction = 0.3, 0.01
    assert found.widened(own, normal, stddev) == (0.01, stddev)


# At a half of its friction the slide has no step at all, and friction would be sought lower still.
@pytest.mark.parametrize("seed", [1, 2])
def test_a_friction_that_leaves_no_step_gives_way_to_one_that_has_steps(seed, monkeypatch):
    told = Motion(1e-4, FRICTION, 0.16, "slip"), FRICTION / 2, 0.05, seed, 200
    friction, stddev = friction_after(*told)
    assert abs(friction - FRICTION) < 3 * stddev < 0.01
    monkeypatch.setattr(Rivals, "begin", lambda *arguments: None)
    friction, stddev = friction_after(*told)
    assert stddev == pytest.approx(0.05) and friction <= FRICTION / 2


def test_steps_where_the_estimate_has_none_soon_convince_but_not_at_long_intervals():
    for dt, wins in ((1e-3, True), (LONG_STEP, True), (1.01 * LONG_STEP, False)):
        own = Foretelling()
        found, (low, high) = beside(own)
        low.steps = Prediction.FAILED
        for _ in range(int(NO_STEP_FOR / dt) + 1):
            found.predict(dt, True, own, Prediction.FAILED)
        assert found.correct(Q, R, own, own.result, own.nis) == wins
        assert own.friction[0] == pytest.approx(0.3 if wins else 0.2)
        # One that has none either has not gained.
        assert low.friction[0] == pytest.approx(0.1)


# Told from above both frictions fit for a quarter of a second, and what balances after it wins:
# bounds that hold one of them hold nothing.
def test_while_two_frictions_fit_the_bounds_hold_the_true_one():
    truth = with_noise(truth_of(Motion(5e-4, FRICTION, 0.16, "align"))[0], "nominal", 0.125)
    configuration = truth.plan.configuration
    scene = replace(configuration.scene, friction=0.75)
    pipeline, inside, own = Pipeline(replace(configuration, scene=scene)), [], []
    for outputs in pipeline.play(measure(truth, 2)):
        k = round((outputs.t_ns - START_NS) * 1e-6)
        if not 50 <= k < 400:
            continue
        friction, stddev = pipeline.filter.friction
        if k < 230:
            own.append(abs(friction - FRICTION) < 2 * stddev)
        inside.append(abs(friction - FRICTION) < 2 * outputs.monitor["friction_stddev"])
        off = np.abs(outputs.normal - truth.normal[k])
        inside.append((off < 2 * outputs.normal_stddev).all())
    assert len(inside) == 700 and np.mean(inside) > 0.9 and np.mean(own) < 0.1


def test_an_outlier_decides_nothing_and_a_restart_says_nothing():
    own = Foretelling()
    found, (low, high) = beside(own)
    own.nis, low.nis, high.nis = 1e6, 2.0 + MOST - 2 * CONVINCING, MOST
    assert not corrected(found, own) and found.count == 2
    own.nis, low.nis, high.nis = 3.0, 3.0, 25.0
    high.result = Correction.RESET
    for _ in range(9):
        assert not corrected(found, own)
    assert found.count == 2


def test_two_that_have_come_together_are_one_once_friction_is_learnt():
    own = Foretelling((0.2, 0.049))
    found, (low, high) = beside(own)
    low.friction, high.friction = (0.201, 0.01), (0.21, 0.01)
    corrected(found, own)
    assert found.count == 2
    own.friction = 0.2, 0.01
    corrected(found, own)
    assert found.count == 1
    high.friction = 0.202, 0.01
    corrected(found, own)
    assert found.count == 0
    # What is settled is not asked for again, but after a doubt.
    found.begin(own)
    assert found.count == 0
    found.ask_again()
    found.begin(own)
    assert found.count == 2


def test_they_are_plain_filters_of_the_same_settings():
    class Watched(ContactFilter):
        """What somebody wants to know of the estimate, he does not want to know of others."""

    pipeline = Pipeline(told(), make=Watched)
    played(pipeline, 1, 40)
    found = [rival.filter for rival in pipeline.processor._rivals._all]
    assert len(found) == 2
    for kalman in found:
        assert type(kalman) is ContactFilter
        assert kalman.options == pipeline.filter.options
        assert (kalman.wrench_noise == pipeline.filter.wrench_noise).all()
