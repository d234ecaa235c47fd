"""Pegs and sensors unlike those that all thresholds were chosen with: size, mass, rate, noise."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.grid.misstated import with_scene, with_tare
from benchmarks.grid.pegs import PEGS, closing
from benchmarks.harness.errors import run_seeds
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.ros.diagnostics import Diagnostics
from peg_on_hole_ros.sim.measure import measure
from tiers import nightly


def covered(truth, seeds=3):
    """Return the shares of errors inside their 95 % bounds after 0.1 s, shape (9,)."""
    runs = run_seeds(truth, range(50, 50 + seeds))
    told = truth.t_ns >= 100_000_000
    assert not runs.diverged.any()
    inside = np.abs(runs.error[:, told]) <= 1.96 * runs.stddev[:, told]
    assert runs.contact[:, told].mean() > 0.9
    return inside[runs.contact[:, told]].mean(axis=0)


# Errors are correlated over some 20 ms: of 3 times 0.5 s a share of 0.95 scatters by 0.02 to 0.03.
LEAST = 0.88


@pytest.mark.parametrize(
    ("name", "wrench_rate", "joint_rate"),
    [
        ("4 mm", 1000, 500),
        ("150 mm", 100, 100),
        *nightly(
            *((name, 1000, 500) for name in PEGS if name != "4 mm"),
            ("4 mm", 100, 100),
            *((name, 5000, 500) for name in ("4 mm", "150 mm")),
        ),
    ],
)
def test_bounds_hold_for_other_pegs_and_rates(name, wrench_rate, joint_rate):
    share = covered(closing(name, wrench_rate, joint_rate))
    assert share.min() > LEAST, share.round(3)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("off", "name"),
    [(0.2, "4 mm"), (-0.2, "4 mm"), (-0.2, "10 mm"), (0.2, "10 mm")],
)
def test_a_clearance_is_learnt_or_left_and_never_run_away_with(name, off):
    """Of 4 mm a quarter of it was learnt, 15 deviations off: reactions covered in 3 %."""
    truth = closing(name, duration=1.2)
    configuration, clearance = truth.plan.configuration, PEGS[name].clearance
    told = replace(
        configuration.scene,
        peg_diameter=configuration.scene.peg_diameter - off * clearance,
        clearance_stddev=0.2 * clearance,
    )
    plan = replace(truth.plan, configuration=replace(configuration, scene=told))
    # At 10 mm N_K is covered in 91 to 93 % of 16 seeds, and in 78 to 96 % of two, as a run's error
    # lasts: learnt together, friction and clearance are not told well apart.
    share = covered(replace(truth, plan=plan), seeds=8)
    assert share[6:].min() > 0.8, share.round(3)


def test_friction_is_learnt_at_100_hz():
    truth = with_scene(closing("50 mm", 100, 100), friction=0.125)
    pipeline = Pipeline(truth.plan.configuration)
    for _ in pipeline.play(measure(truth, 3)):
        pass
    friction, stddev = pipeline.filter.friction
    assert stddev < 0.01 and abs(friction - 0.2) < 3 * stddev


SLOW_FOR_THEIR_SIZE = [
    ("4 mm", 1000, 500),
    ("10 mm", 250, 250),
    ("10 mm", 500, 500),
    ("50 mm", 100, 100),
    ("50 mm", 250, 250),
]
NOT_TOLD = pytest.mark.xfail(strict=True, reason="a wrong zero at 100 Hz is not told")
WRONG = ("innovations_too_large",)


@pytest.mark.parametrize(
    ("name", "wrench_rate", "joint_rate"),
    [
        case if case[1] > 100 else pytest.param(*case, marks=NOT_TOLD)
        for case in SLOW_FOR_THEIR_SIZE
    ],
)
def test_a_tare_that_is_off_is_told_at_few_wrenches(name, wrench_rate, joint_rate):
    truth = closing(name, wrench_rate, joint_rate)
    for off in (0.0, 10.0 * PEGS[name].force):
        pipeline = Pipeline(truth.plan.configuration)
        for sample in measure(truth, 5):
            pipeline.on_sample(with_tare(sample, np.array([off, 0.0, 0.0])))
        counts = pipeline.counts
        assert any(counts[name] for name in WRONG) == (off > 0), counts
        report, _ = Diagnostics().report(0, 10**9, dict(counts), pipeline.health)
        status = next(item for item in report["status"] if item["name"].endswith("filter"))
        assert ("the tare" in status["message"]) == (off > 0)
