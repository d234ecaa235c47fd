"""Steps whose innovations lean one way: when they are doubted, and what comes of it."""

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.contact import Prediction
from peg_on_hole_ros.estimation.kernel.lean import (
    AS_STATED,
    DOUBTED_ABOVE,
    FORGOTTEN_OVER,
    FRICTION_KNOWN,
    LEANT_OVER,
    MOST_SURPRISE,
    TRUSTED_BELOW,
    follow_steps,
)
from peg_on_hole_ros.estimation.kernel.memory import SIZE, STEPS_LEAN, part

from engine_traces import trace
from peg_on_hole_ros.options import FilterOptions
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.simulation.measure import measure
from simulated import truth
from sliding_filter import SCENE, sliding

# Speed of the peg's contacts in `sliding` is some 50 mm/s.
UNSURE = [1e-4, 0.4**2, 0.4**2]  # (rad/s)^2: 3.5 standard deviations of it
SURE = [1e-4, 0.2**2, 0.2**2]  # 7 of them


@pytest.fixture
def memory():
    memory = np.zeros(SIZE)
    part(memory, "S")[[0, 4, 8]] = 1.0
    part(memory, "SLIDING")[0] = 1.0
    return memory


def follow(memory, white, dt=2e-3):
    for one in white:
        part(memory, "RESIDUAL")[:] = one
        follow_steps(memory, dt)


def size(memory):
    mean = part(memory, "STEPS_LEAN")
    return mean @ mean * (2 * LEANT_OVER - 1) / 3


def doubting(variance, friction_stddev=0.0, **options):
    kalman = sliding(FilterOptions(**options))
    kalman.Z[range(3, 6), range(3, 6)] = variance
    kalman.spread[0, 0] = friction_stddev**2
    part(kalman.memory, "DOUBT")[0] = 1.0
    return kalman


def test_white_innovations_lean_nowhere(memory):
    sizes = []
    for white in np.random.default_rng(5).normal(size=(40_000, 3)):
        follow(memory, [white])
        sizes.append(size(memory))
    # One in 20 of them is independent: 2000, of a mean of 1 and a variance of 2/3.
    assert np.mean(sizes[100:]) == pytest.approx(1.0, abs=4 * np.sqrt(2 / 3 / 2000))
    assert np.mean(np.array(sizes) > DOUBTED_ABOVE) < 0.002


def test_what_leans_by_a_deviation_is_doubted_and_tried_again_later(memory):
    white = np.tile([1.0, -0.8, 0.6], (40, 1))
    follow(memory, white[:5])
    assert not part(memory, "DOUBT")[0]
    follow(memory, white)
    assert part(memory, "DOUBT")[0] == 1.0
    assert size(memory) == pytest.approx(2.0 * 19 / 3, rel=0.02)
    # While nothing slides in a step innovations tell of no step, and the lean is forgotten.
    part(memory, "SLIDING")[0] = 0.0
    lasts = FORGOTTEN_OVER * 0.5 * np.log(size(memory) / TRUSTED_BELOW)
    follow(memory, white[:1], 0.98 * lasts)
    assert part(memory, "DOUBT")[0] == 1.0
    follow(memory, white[:1], 0.04 * lasts)
    assert part(memory, "DOUBT")[0] == 0.0


def test_one_outlier_is_no_lean_and_one_that_is_no_number_is_none(memory):
    follow(memory, [np.array([1e6, 0.0, 0.0])])
    most = 3.0 * MOST_SURPRISE / LEANT_OVER**2
    assert size(memory) == pytest.approx(most * 19 / 3) and size(memory) < TRUSTED_BELOW
    before = memory[STEPS_LEAN : STEPS_LEAN + 3].copy()
    follow(memory, [np.full(3, np.nan)])
    assert (memory[STEPS_LEAN : STEPS_LEAN + 3] == before).all()


def test_a_doubt_is_about_slow_slips_where_friction_is_known():
    known = 0.9 * FRICTION_KNOWN * SCENE.friction
    assert doubting(UNSURE).predict(1e-3, True) is Prediction.DOUBTED
    assert doubting(UNSURE, known).predict(1e-3, True) is Prediction.DOUBTED
    assert doubting(SURE).predict(1e-3, True) is Prediction.CONTACT
    # Until it is known, friction makes innovations lean,
    assert doubting(UNSURE, known / 0.8).predict(1e-3, True) is Prediction.CONTACT
    # and where it is not as stated it may be farther yet.
    for deviations, expected in ((0.9, Prediction.DOUBTED), (1.1, Prediction.CONTACT)):
        learnt = doubting(UNSURE, known)
        off = deviations * AS_STATED * 0.04
        part(learnt.memory, "STATED")[:] = SCENE.friction - off, 0.04**2
        assert learnt.predict(1e-3, True) is expected
    # So it is where every step is to be believed, and where nothing but steps tells of what is
    # learnt.
    assert doubting(UNSURE, slow_slip=0.0).predict(1e-3, True) is Prediction.CONTACT
    learns = doubting(UNSURE)
    learns.spread[1, 1] = 1e-12
    assert learns.predict(1e-3, True) is Prediction.CONTACT


def test_a_doubted_step_is_bridged_with_friction_in_no_sure_direction():
    kalman = doubting(UNSURE)
    rates = kalman.x[3:].copy()
    assert kalman.predict(1e-3, True) is Prediction.DOUBTED
    assert (kalman.x[3:] == rates).all()
    assert kalman._bridged.item() == kalman._slow.item() == 1.0
    kalman.trust_steps()
    kalman._slow[0] = 0.0
    assert kalman.predict(1e-3, True) is Prediction.CONTACT


def test_contacts_that_give_are_told_and_counted():
    """MuJoCo's: accelerations are off by some 4 rad/s^2, all one way."""
    found = trace("driven_slip")
    pipeline = Pipeline(found.plan.configuration)
    last = None
    for sample in measure(found, 7000, exact=found.wrench):
        if isinstance(sample, WrenchSample):
            last = pipeline.on_wrench(sample) or last
        else:
            pipeline.on_joints(sample)
    assert pipeline.counts["step_doubted"] > 30
    assert np.isfinite(last.normal).all()


@pytest.mark.parametrize("name", ["closing_with_slip", "working_cycle"])
def test_steps_that_fit_are_not_doubted(name):
    moved = truth(name)
    pipeline = Pipeline(moved.plan.configuration)
    for _ in pipeline.play(measure(moved, 11)):
        pass
    assert pipeline.counts["step_doubted"] == 0
