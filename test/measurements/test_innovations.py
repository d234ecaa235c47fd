"""Wrong settings of a cell show in the innovations, a right one does not."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import chi2

from benchmarks.grid.cells import SMALLEST, truth_of
from benchmarks.grid.misstated import tilted
from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.measurements.innovations import (
    MEDIAN,
    Innovations,
    add_innovation,
    forget_innovations,
)
from peg_on_hole_ros.measurements.tuned import INNOVATION_WINDOW
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.ros.diagnostics import ERROR, OK, Diagnostics
from peg_on_hole_ros.sim.measure import START_NS, measure, sensor_wrench
from peg_on_hole_ros.typed_record import new
from simulated import truth
from tiers import nightly

MS = 1_000_000
WINDOW, FEWEST = INNOVATION_WINDOW.settings_count, INNOVATION_WINDOW.fewest


def watched(values, white):
    """Yield what is told after each innovation of a peg that touches."""
    told = new(Innovations)
    forget_innovations(told)
    for value, row in zip(values, white):
        large = add_innovation(told, value, row, True, True, True)
        yield told, large
    forget_innovations(told)
    assert np.isnan(told.median) and np.isnan(told.drift)


def larges(values):
    """Return after each innovation whether they are too large."""
    return [large for _, large in watched(values, np.zeros((len(values), 3)))]


def test_the_median_is_that_of_the_window():
    values = np.random.default_rng(4).chisquare(3, 1000)
    for n, (told, _) in enumerate(watched(values, np.zeros((1000, 3))), 1):
        expected = np.median(values[max(n - WINDOW, 0) : n])
        assert told.median == pytest.approx(expected if n >= WINDOW else np.nan, nan_ok=True)
        assert told.average == pytest.approx(
            values[max(n - INNOVATION_WINDOW.mode_count, 0) : n].mean()
        )


def test_the_drift_is_that_of_the_window():
    white = np.random.default_rng(4).normal(0.2, 1.0, (1000, 3))
    for n, (told, large) in enumerate(watched(np.zeros(1000), white), 1):
        expected = (white[max(n - WINDOW, 0) : n].sum(axis=0) ** 2).sum() / WINDOW
        assert told.drift == pytest.approx(expected if n >= WINDOW else np.nan, nan_ok=True)
        assert large == (n >= WINDOW and expected > INNOVATION_WINDOW.drift)


@pytest.mark.parametrize("friction", ["estimated", "considered"])
def test_a_friction_that_is_as_stated_alarms_nobody(friction):
    """Told off by one deviation: only considered, it pushes every innovation one way."""
    configuration = truth("closing_with_slip").plan.configuration
    true = configuration.scene.friction
    scene = replace(configuration.scene, friction=true + 0.003, friction_stddev=0.003)
    options = replace(configuration.filter, friction=friction)
    pipeline = Pipeline(replace(configuration, scene=scene, filter=options))
    for outputs in pipeline.play(measure(truth("closing_with_slip"), 3)):
        assert outputs.monitor.get("nis_drift", 0.0) < INNOVATION_WINDOW.drift
    assert pipeline.counts["innovations_too_large"] == 0


@pytest.mark.parametrize("count", [FEWEST, WINDOW])
def test_noise_alone_is_not_too_large(count):
    # Half of a window above the limit, by chance: once in 1e6 windows.
    share = chi2(3).sf(
        MEDIAN + (INNOVATION_WINDOW.large_median - MEDIAN) * np.sqrt(WINDOW / count)
    )
    assert (0.5 - share) / np.sqrt(share * (1 - share) / count) > 4
    assert chi2(3).sf(INNOVATION_WINDOW.drift) < 2e-6


@pytest.mark.parametrize(("times", "most"), [(4.0, FEWEST), (2.0, 1.2 * FEWEST)])
def test_what_is_far_too_large_is_so_before_the_window_is_full(times, most):
    draws = (np.random.default_rng(seed).chisquare(3, WINDOW) for seed in range(20))
    first = [larges(times * values).index(True) + 1 for values in draws]
    assert min(first) == FEWEST and np.median(first) <= most


def test_what_was_too_large_and_is_over_is_forgotten_before_the_window_is():
    draw = np.random.default_rng(2)
    before, over, again = (draw.chisquare(3, n) for n in (WINDOW, WINDOW, FEWEST))
    told = larges(np.concatenate([9.0 * before, over, 9.0 * again]))
    assert told[WINDOW - 1] and told[WINDOW + FEWEST // 4]
    assert not any(told[WINDOW + FEWEST : 2 * WINDOW])
    # Another such fault is told as the first was.
    assert told[-1]


def test_an_innovation_is_whitened_by_its_covariance():
    P, R = (
        np.diag([1e-4, 4e-4, 9e-4]),
        1e-4 * np.array([[2.0, 0.3, 0.1], [0.3, 3.0, 0.2], [0.1, 0.2, 1.0]]),
    )
    P[0, 1] = P[1, 0] = 1e-4
    kalman, q = ContactFilter(Scene(), FilterOptions(), np.eye(6)), np.array([0.1, 0.2, 0.3])
    kalman.start(q, P)
    moved = np.array([0.01, -0.02, 0.03])
    kalman.correct(q + moved, R)
    expected = np.linalg.solve(np.linalg.cholesky(P + R), moved)
    np.testing.assert_allclose(kalman.state.innovation, expected, rtol=1e-12)


@cache
def motion(kind):
    return truth_of(SMALLEST[kind])[0]


CLOSING, REVERSING = 0, 1
LEARNT = Scene().friction_stddev


# Friction that is learnt makes up for a tilt of the hole, until its effect grows near gamma0.
@pytest.mark.parametrize(
    "kind, wrong, friction_stddev, within",
    [
        (CLOSING, "nothing", 0.0, 0.5),
        (CLOSING, "hole", LEARNT, 0.8),
        (CLOSING, "lever", LEARNT, 0.5),
        *nightly(
            *((CLOSING, wrong, 0.0, 0.5) for wrong in ("lever", "tare", "hole")),
            *((CLOSING, wrong, LEARNT, 0.5) for wrong in ("nothing", "tare")),
            *((REVERSING, wrong, LEARNT, 0.5) for wrong in ("nothing", "lever", "tare", "hole")),
        ),
    ],
)
def test_what_is_wrong_is_seen_within_half_a_second(kind, wrong, friction_stddev, within):
    truth = motion(kind)
    configuration, exact = truth.plan.configuration, sensor_wrench(truth)
    scene = replace(configuration.scene, friction_stddev=friction_stddev)
    configuration = replace(configuration, scene=scene)
    if wrong == "lever":
        x, y, z = configuration.wrench.sensor_xyz
        moved = replace(configuration.wrench, sensor_xyz=(x + 0.001, y, z))
        configuration = replace(configuration, wrench=moved)
    elif wrong == "tare":
        exact = exact + [2.0, 0, 0, 0, 0, 0]
    pipeline, first_ns = Pipeline(configuration), None
    for sample in measure(truth, 7, exact=exact):
        if wrong == "hole":
            sample = tilted(sample, (0.0, np.radians(0.2)))
        pipeline.on_sample(sample)
        if first_ns is None and pipeline.counts["innovations_too_large"]:
            first_ns = sample.t_ns - START_NS
    report, _ = Diagnostics().report(0, 10**9, dict(pipeline.counts), pipeline.health)
    status = next(item for item in report["status"] if item["name"].endswith("filter"))
    if wrong == "nothing":
        assert first_ns is None and pipeline.health["nis_median"] == pytest.approx(2.37, abs=0.5)
        assert status["level"] == OK
    else:
        assert first_ns <= within * 1e9, first_ns
        assert status["level"] == ERROR and "sensor_xyz" in status["message"]
