"""Wrong settings of a cell show in the innovations, a right one does not."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.contact import ContactFilter
from peg_on_hole_ros.estimation.filters.square_root import SquareRootFilter
from peg_on_hole_ros.estimation.kernel.memory import SIZE, part
from peg_on_hole_ros.estimation.kernel.parameters import learning_shares
from scipy.stats import chi2

from grid_cells import SMALLEST, truth_of
from peg_on_hole_ros.edges.live.diagnostics import WARN, Diagnostics
from peg_on_hole_ros.estimation.innovations import Innovations
from peg_on_hole_ros.estimation.watches import (
    DRIFTS,
    TOO_LARGE,
    WINDOW,
    BalanceWatch,
    InnovationWatch,
    SurpriseWatch,
)
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.options import FilterOptions
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.simulation.measure import START_NS, measure, sensor_wrench
from simulated import truth
from wrong_settings import tilted

MS = 1_000_000


def test_the_median_is_that_of_the_window():
    values = np.random.default_rng(4).chisquare(3, 1000)
    watch = InnovationWatch()
    for n, value in enumerate(values, 1):
        watch.add(value)
        expected = np.median(values[max(n - WINDOW, 0) : n])
        assert watch.median == (pytest.approx(expected) if n >= WINDOW else None)
    watch.restart()
    assert watch.median is None


def test_the_drift_is_that_of_the_window():
    white = np.random.default_rng(4).normal(0.2, 1.0, (1000, 3))
    watch = InnovationWatch()
    for n, row in enumerate(white, 1):
        watch.add(0.0, tuple(row))
        expected = (white[max(n - WINDOW, 0) : n].sum(axis=0) ** 2).sum() / WINDOW
        assert watch.drift == (pytest.approx(expected) if n >= WINDOW else None)
        assert watch.too_large == (n >= WINDOW and expected > DRIFTS)
    watch.restart()
    assert watch.drift is None and not watch.too_large


@pytest.mark.parametrize(
    ("held_back", "used", "drifts"),
    [(0.0, True, True), (1.0, True, False), (0.0, False, False)],
)
def test_innovations_drift_only_where_the_gain_is_the_optimal_one(held_back, used, drifts):
    kalman = ContactFilter(Scene(), FilterOptions(), np.eye(6) * 1e-6)
    kalman.start(np.array([0.2, 0.0, 0.0]), np.eye(3) * 1e-8)
    part(kalman.memory, "HELD_BACK")[0] = held_back
    kalman.innovation(kalman.x[:3] + 1e-4)
    innovations = Innovations(white=True)
    for k in range(WINDOW):
        innovations.add(k, 2.0, kalman, used, in_contact=True, touching=True)
    size = np.sum(np.square(kalman.white_innovation()))
    expected = WINDOW * size if drifts else 0.0
    assert innovations.told() == {"nis_median": 2.0, "nis_drift": pytest.approx(expected)}


@pytest.mark.parametrize(
    ("friction", "clearance", "learnt", "held_back"),
    [
        (0.05, 0.0, (1.0, 1.0), 0.0),
        (0.05, 0.0, (0.0, 0.0), 1.0),
        (0.0, 1e-6, (1.0, 0.0), 1.0),
        (0.0, 0.0, (0.0, 0.0), 0.0),
    ],
)
def test_what_is_only_considered_is_held_back(friction, clearance, learnt, held_back):
    m = np.zeros(SIZE)
    part(m, "SPREAD")[[0, 3]] = friction**2, clearance**2
    part(m, "LEARNT")[:] = learnt
    part(m, "S", (3, 3))[:] = 1e-4 * np.eye(3)
    for sliding in (1.0, 0.0):
        part(m, "SLIDING")[0] = sliding
        learning_shares(m)
        assert part(m, "HELD_BACK").item() == held_back * sliding


@pytest.mark.parametrize("friction", ["estimated", "considered"])
def test_a_friction_that_is_as_stated_alarms_nobody(friction):
    """Told off by one deviation: only considered, it pushes every innovation one way."""
    configuration = truth("closing_with_slip").plan.configuration
    true = configuration.scene.friction
    scene = replace(configuration.scene, friction=true + 0.003, friction_stddev=0.003)
    options = replace(configuration.filter, friction=friction)
    pipeline = Pipeline(replace(configuration, scene=scene, filter=options))
    for outputs in pipeline.play(measure(truth("closing_with_slip"), 3)):
        assert outputs.monitor.get("nis_drift", 0.0) < DRIFTS
    assert pipeline.counts["innovations_too_large"] == 0


def test_noise_alone_is_not_too_large():
    # Half of a window above the limit, by chance: once in 1e6 windows.
    share = chi2(3).sf(TOO_LARGE)
    assert (0.5 - share) / np.sqrt(share * (1 - share) / WINDOW) > 4
    assert chi2(3).sf(DRIFTS) < 2e-6


def test_large_innovations_on_end_tell_and_single_ones_do_not():
    watch = SurpriseWatch()
    # Four of the largest that count pass the limit; then it begins anew.
    assert [watch.add(nis) for nis in (1e9, 14.0, 50.0, 20.0)] == [False, False, False, True]
    assert watch.total == 0.0
    for _ in range(100):
        assert not watch.add(1e9) and not watch.add(3.0) and not watch.add(1.0)
        watch.add(0.5)
        watch.add(0.5)


def test_innovations_of_the_stated_size_are_hardly_ever_too_large_on_end():
    """Six minutes of them, and a tenth of a second of some that are two and a half times that."""
    watch = SurpriseWatch()
    told = sum(watch.add(nis) for nis in np.random.default_rng(5).chisquare(3, 200_000))
    assert told == 0
    larger = np.random.default_rng(6).chisquare(3, 50) * 2.5
    assert any(watch.add(nis) for nis in larger)


def test_the_balance_drifts_as_chi_squared_and_one_burst_is_no_wrong_setting():
    watch, rng, drifts = BalanceWatch(), np.random.default_rng(4), []
    for i, white in enumerate(rng.standard_normal((20000, 3)).tolist()):
        watch.add(i * MS, white)
        assert (watch.drift is None) == (i < BalanceWatch.FEWEST)
        if i > 2000 and i % 300 == 0:
            drifts.append(watch.drift)
    # The mean of 60, each with a variance of 6, scatters by 0.3.
    assert np.mean(drifts) == pytest.approx(3.0, abs=1.0) and not watch.too_far
    now = 20000 * MS
    for i in range(20):
        watch.add(now + i * MS, (50.0, -50.0, 50.0))
    assert not watch.too_far
    before, now = watch.snapshot(), now + 20 * MS
    for i in range(300):
        watch.add(now + i * MS, (0.8, -0.8, 0.0))
    assert watch.too_far
    # Of a contact before nothing is left.
    watch.add(now + 5000 * MS, (0.1, 0.1, 0.1))
    assert watch.drift < 1.0
    watch.restore(before)
    assert not watch.too_far
    for i in range(2000):
        watch.add(now + i * MS, (0.0, 0.0, 0.0))
    assert watch.drift < 3.0


def test_an_innovation_is_whitened_by_its_covariance():
    kalman = ContactFilter(Scene(), FilterOptions(), np.eye(6))
    kalman.start(np.array([0.1, 0.2, 0.3]), np.diag([1e-4, 4e-4, 9e-4]))
    kalman.Z[0, 1] = kalman.Z[1, 0] = 1e-4
    R = 1e-4 * np.array([[2.0, 0.3, 0.1], [0.3, 3.0, 0.2], [0.1, 0.2, 1.0]])
    S, moved = kalman.P[:3, :3] + R, np.array([0.01, -0.02, 0.03])
    kalman.correct(np.array([0.1, 0.2, 0.3]) + moved, R)
    expected = np.linalg.solve(np.linalg.cholesky(S), moved)
    np.testing.assert_allclose(kalman.white_innovation(), expected, rtol=1e-12)


@cache
def motion(kind):
    return truth_of(SMALLEST[kind])[0]


CLOSING, REVERSING = 0, 1
LEARNT = Scene().friction_stddev


# Friction that is learnt makes up for a tilt of the hole, until its effect grows near gamma0.
@pytest.mark.parametrize(
    "kind, wrong, friction_stddev, within",
    [
        *((CLOSING, wrong, 0.0, 0.5) for wrong in ("nothing", "lever", "tare", "hole")),
        *((CLOSING, wrong, LEARNT, 0.5) for wrong in ("nothing", "lever", "tare")),
        (CLOSING, "hole", LEARNT, 0.8),
        *((REVERSING, wrong, LEARNT, 0.5) for wrong in ("nothing", "lever", "tare", "hole")),
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
        assert status["level"] != WARN
    else:
        assert first_ns <= within * 1e9, first_ns
        assert status["level"] == WARN and "sensor_xyz" in status["message"]


def test_friction_that_is_doubted_is_as_it_was_stated():
    scene = Scene(friction=0.3, friction_stddev=0.05, clearance_stddev=2e-6)
    kalman = ContactFilter(scene, FilterOptions(), np.eye(6))
    kalman.start(np.array([0.1, 0.2, 0.3]), 1e-6 * np.eye(3))
    assert not kalman.doubt()
    kalman.scene_values[7] = 0.4
    kalman.spread[:] = [[1e-6, 1e-10], [1e-10, 4e-12]]
    part(kalman.memory, "CROSS")[:] = 1e-9
    before = kalman.Z.copy()
    assert kalman.doubt()
    assert kalman.friction == pytest.approx((0.3, 0.05))
    assert not kalman.spread[[0, 1], [1, 0]].any() and kalman.spread[1, 1] == 4e-12
    cross = part(kalman.memory, "CROSS", (2, 12))
    assert not cross[0].any() and (cross[1] == 1e-9).all()
    assert (before == kalman.Z).all()
    # And so again by the square root.
    root = SquareRootFilter(scene, FilterOptions(), np.eye(6))
    root.start(np.array([0.1, 0.2, 0.3]), 1e-6 * np.eye(3))
    root.spread[0, 0] = 1e-6
    assert root.doubt()
    np.testing.assert_allclose(root._root @ root._root.T, root.joint_covariance(), atol=1e-18)
    assert root.friction == pytest.approx((0.3, 0.05))


@pytest.mark.parametrize("friction_stddev", [0.05, 0.0])
def test_friction_that_no_longer_fits_is_learnt_anew(friction_stddev):
    truth = motion(CLOSING)
    configuration = truth.plan.configuration
    scene = replace(configuration.scene, friction_stddev=friction_stddev)
    pipeline = Pipeline(replace(configuration, scene=scene))
    for sample in measure(truth, 1):
        k = round((sample.t_ns - START_NS) * 1e-6)
        if k == 300:
            # As if it had been learnt on another surface, and surely. Farther off it would soon
            # leave no step, and be forgotten for that.
            pipeline.filter.take_friction(0.185, min(friction_stddev**2, 1e-8))
        if isinstance(sample, JointSample):
            pipeline.on_joints(sample)
        else:
            outputs = pipeline.on_wrench(sample)
    friction = outputs.monitor["friction"]
    if friction_stddev:
        assert pipeline.counts["friction_doubted"] > 0
        assert abs(friction - 0.2) < 4 * outputs.monitor["friction_stddev"] < 0.02
        assert outputs.contact_mode == "three_point"
    else:
        # What is stated as known is not doubted.
        assert pipeline.counts["friction_doubted"] == 0
        assert friction == 0.185
