"""Where a rigid motion would run away, an implicit step is not believed."""

from functools import cache

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.outcomes import Prediction
from peg_on_hole_ros.estimation.kernel.memory import SIZE, part
from peg_on_hole_ros.estimation.kernel.runaway import FASTEST_GROWTH, runs_away
from peg_on_hole_ros.estimation.reference.steps import solve_with_slopes
from scipy.integrate import solve_ivp

from grid_cells import Motion, truth_of, with_noise
from grid_score import peg_wrench, run_seeds
from peg_on_hole_ros.mechanics.kernel import scene_of, scene_scalars
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.simulation.measure import measure


@cache
def turning():
    """Return a motion whose contact B1 slows down from 70 to 5 mm/s under 75 to 150 N."""
    return truth_of(Motion(2e-5, 0.2, 1.0, "sway"))[0]


def first_order(truth, k):
    """Return state, wrench, velocity scales and the matrix of the linearised motion, (6, 6)."""
    scales = np.full(3, truth.plan.slip_velocity_scale)
    full = np.concatenate([truth.q[k], truth.rates[k], peg_wrench(truth)[k]])
    scene = truth.plan.configuration.scene
    full = np.concatenate([full, [scene.friction, scene.peg_diameter]])
    _, slopes = solve_with_slopes(scene, full, scales)
    matrix = np.zeros((6, 6))
    matrix[:3, 3:], matrix[3:] = np.eye(3), slopes[:3, :6]
    return full, scales, matrix


def told_to_run_away(truth, full, scales, ramp=(0.0,) * 8):
    m = np.zeros(SIZE)
    part(m, "SCENE")[:] = scene_scalars(truth.plan.configuration.scene)
    part(m, "X")[:6], part(m, "U")[:6], part(m, "SCALES")[:3] = full[:6], full[6:12], scales
    part(m, "RAMP")[:] = ramp
    return runs_away(scene_of(m), m)


def test_it_is_told_by_the_fastest_growth_of_the_linearised_motion():
    truth, found = turning(), []
    for k in range(60, 160, 2):
        full, scales, matrix = first_order(truth, k)
        growth = np.linalg.eigvals(matrix).real.max()
        # A determinant that passes zero where the growth is the limit needs no tolerance
        # elsewhere: these grow by 40 to 5000 a second, none within a percent of the limit.
        assert abs(growth / FASTEST_GROWTH - 1.0) > 0.01
        told = told_to_run_away(truth, full, scales)
        assert told == (growth > FASTEST_GROWTH), (k, growth)
        found.append(told)
    assert 10 < sum(found) < len(found) - 10


def test_it_is_told_by_the_wrench_at_the_end_of_a_part_of_an_interval():
    truth, told = turning(), []
    for k in range(60, 160, 10):
        full, scales, _ = first_order(truth, k)
        # At its stamp it presses twice as much.
        later = np.concatenate([full[:6], 2.0 * full[6:12], full[12:]])
        told.append(told_to_run_away(truth, full, scales))
        at_its_end = told_to_run_away(truth, later, scales, (*(2.0 * full[6:12]), 0.0, 0.5))
        assert at_its_end == told[-1]
        told[-1] = told[-1], told_to_run_away(truth, later, scales)
    # Which is not the same.
    assert {(True, True), (False, True)} <= set(told)


@pytest.mark.parametrize("k", [120, 150])
def test_neighbouring_motions_part_as_fast_as_the_linearised_one_says(k):
    truth = turning()
    full, scales, matrix = first_order(truth, k)
    scene = truth.plan.configuration.scene
    values, vectors = np.linalg.eig(matrix)
    fastest = np.argmax(values.real)
    growth, along = values[fastest].real, np.real(vectors[:, fastest])

    def motion(_, x):
        y, _ = solve_with_slopes(scene, np.concatenate([x, full[6:]]), scales)
        return np.concatenate([x[3:], y[:3]])

    # So short that the slip, and with it the growth, change by a hundredth or two.
    duration, small = 0.05 / growth, 1e-6 / np.linalg.norm(along[3:])
    ends = [
        solve_ivp(motion, (0.0, duration), full[:6] + sign * small * along, rtol=1e-9, atol=1e-12)
        for sign in (1.0, -1.0)
    ]
    apart = np.linalg.norm(ends[0].y[3:, -1] - ends[1].y[3:, -1]) / 2e-6
    assert np.log(apart) / duration == pytest.approx(growth, rel=0.05)


def test_a_runaway_is_bridged_and_not_taken_for_known():
    # Steps were believed there, ended with the contact at rest or far off, and were stated as
    # known to some mrad/s, up to a thousand standard deviations off: a mean NIS of 5 to 57.
    truth = with_noise(turning(), "low", 0.05)
    runs = run_seeds(truth, range(40_000, 40_006))
    assert (runs.nis < 4.5).all() and runs.nis.mean() < 3.3, runs.nis
    closing = runs.nees[:, 140:160]
    assert np.nanmean(closing > 30.0) < 0.05, np.nanmax(closing)


def test_it_is_counted_and_hides_no_slip():
    truth = with_noise(turning(), "low", 0.05)
    pipeline = Pipeline(truth.plan.configuration)
    outcomes, predict = [], pipeline.filter.predict

    def noting(dt, in_contact):
        outcomes.append(predict(dt, in_contact))
        return outcomes[-1]

    pipeline.filter.predict = noting
    for _ in pipeline.play(measure(truth, 40_000)):
        # A slip that is well told is believed again at once, unlike one that noise has hidden.
        slow = part(pipeline.filter.memory, "SLOW")[0]
        assert slow == 0.0 or outcomes[-1] is Prediction.SLOW
    found = outcomes.count(Prediction.RUNAWAY)
    assert pipeline.counts["step_runs_away"] == found > 10
