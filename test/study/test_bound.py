"""The bound against a Kalman filter built another way, and against the estimator's own errors."""

from dataclasses import asdict, replace
from types import SimpleNamespace

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from measured import recorded
from peg_on_hole_ros.config.options import WrenchInput
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.methods.registry import make_filter
from peg_on_hole_ros.measurements.angles import angle_covariance
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.reference import six_equations
from peg_on_hole_ros.study.bound import (
    Meaning,
    Sensors,
    Smoothness,
    TrueMotion,
    posterior_bound,
    smoothness,
)
from peg_on_hole_ros.study.scenes import first_samples, true_wrench
from simulated import truth

SCALE, STEP, STDDEV, RATE_STDDEV = 1e-5, 1e-3, 1e-4, 1.0
HOLDER = Smoothness(np.array([3.0, 5.0, 8.0]), np.array([0.05, 0.02, 0.1]))


def motion(name="closing_with_slip", count=120, known=(0.0, 0.0)):
    """Scene, motion and sensors of the first samples of a truth."""
    cut = first_samples(truth(name), count)
    scene = replace(
        cut.plan.configuration.scene, friction_stddev=known[0], clearance_stddev=known[1]
    )
    noise = WrenchReduction(WrenchInput(), scene).covariance
    sensors = Sensors(noise, STDDEV, np.arange(count) % 2 == 0)
    state = np.hstack([cut.q, cut.rates])
    return scene, TrueMotion(cut.t_ns * 1e-9, state, true_wrench(cut)), sensors


def equations(scene, full):
    """Accelerations and reactions by the numpy model; full: state, wrench, friction, diameter."""
    values = {**asdict(scene), "friction": full[12], "peg_diameter": full[13]}
    clearance = scene.hole_diameter - full[13]
    gamma0 = 2 * np.arcsin(np.sqrt(clearance / (2 * scene.hole_diameter)))
    here = SimpleNamespace(**values, gamma0=gamma0)
    A, r = six_equations(here, full[:3], full[3:6], full[6:12], SCALE)
    return np.linalg.solve(A, r)


def slopes(scene, x, u):
    full, dy = np.concatenate([x, u, [scene.friction, scene.peg_diameter]]), np.empty((6, 14))
    for i in range(14):
        moved = full.astype(complex)
        moved[i] += 1e-30j
        dy[:, i] = equations(scene, moved).imag / 1e-30
    return dy


def singer(level, time):
    """Transition and covariance over STEP (Singer, IEEE Trans. AES 6, 1970)."""
    b = STEP / time
    e, e2 = np.exp(-b), np.exp(-2 * b)
    F = np.array([[1, STEP, time**2 * (b - 1 + e)], [0, 1, time * (1 - e)], [0, 0, e]])
    q11 = time**4 * (1 - e2 + 2 * b + 2 * b**3 / 3 - 2 * b**2 - 4 * b * e)
    q12 = time**3 * (e2 + 1 - 2 * e + 2 * b * e - 2 * b + b**2)
    q13 = time**2 * (1 - e2 - 2 * b * e)
    q22 = time**2 * (4 * e - 3 - e2 + 2 * b)
    q23, q33 = time * (e2 + 1 - 2 * e), 1 - e2
    return F, level**2 * np.array([[q11, q12, q13], [q12, q22, q23], [q13, q23, q33]])


@pytest.mark.parametrize("known, walk", [((0.0, 0.0), 0.0), ((0.05, 2e-6), 0.002)])
def test_equals_kalman_covariance_of_the_linearised_motion(known, walk):
    given = motion(count=60, known=known)
    scene, (t, state, wrench), sensors = given
    bound = posterior_bound(*given, RATE_STDDEV, SCALE, HOLDER, walk)
    # Angles, rates, accelerations, friction, diameter; reactions, of which nothing is known.
    kalman = KalmanFilter(dim_x=14, dim_z=6)
    kalman.F, kalman.Q = np.eye(14), np.zeros((14, 14))
    for i in range(3):
        at = np.ix_(range(i, 9, 3), range(i, 9, 3))
        kalman.F[at], kalman.Q[at] = singer(HOLDER.level[i], HOLDER.time[i])
    kalman.Q[9, 9] = walk**2 * STEP
    kalman.P = np.diag(
        [0.0] * 3 + [RATE_STDDEV**2] * 3 + [*HOLDER.level**2, *np.square(known)] + [0] * 3
    )
    kalman.P[:3, :3] = angle_covariance(state[0, 0], STDDEV)
    for k in range(len(t)):
        if k > 0:
            kalman.predict()
        kalman.P[11:, :], kalman.P[:, 11:] = 0.0, 0.0
        kalman.P[11:, 11:] = 1e8 * np.eye(3)
        if sensors.measured[k] and k > 0:
            R = angle_covariance(state[k, 0], STDDEV)
            kalman.update(np.zeros((3, 1)), R=R, H=np.eye(3, 14))
        dy = slopes(scene, state[k], wrench[k])
        H = np.hstack([-dy[:, :6], np.eye(6, 3), -dy[:, 12:], np.eye(6, 3, -3)])
        kalman.update(np.zeros((6, 1)), R=dy[:, 6:12] @ sensors.wrench_noise @ dy[:, 6:12].T, H=H)
        # Two ways to the same numbers differ by rounding times the condition of the innovation.
        np.testing.assert_allclose(bound.state[k], kalman.P[:6, :6], rtol=1e-4, atol=1e-14)
        np.testing.assert_allclose(
            bound.parameters[k], kalman.P[9:11, 9:11], rtol=1e-4, atol=1e-16
        )
        np.testing.assert_allclose(bound.reactions[k], kalman.P[11:, 11:], rtol=1e-4, atol=1e-8)


def test_level_and_time_are_those_of_a_drawn_process():
    rng, n = np.random.default_rng(3), 40000
    kept = np.exp(-STEP / np.array([0.02, 0.05, 0.1]))
    a = np.zeros((n, 3))
    for k in range(1, n):
        a[k] = kept * a[k - 1] + np.sqrt(1 - kept**2) * [1.0, 3.0, 10.0] * rng.normal(size=3)
    found = smoothness(np.arange(n) * STEP, a)
    # 40 s are 400 to 2000 times: their mean square is known to 7 % and better.
    np.testing.assert_allclose(found.level, [1.0, 3.0, 10.0], rtol=0.1)
    np.testing.assert_allclose(found.time, [0.02, 0.05, 0.1], rtol=0.25)


def test_a_steadier_holder_leaves_less():
    given = motion(count=80, known=(0.05, 0.0))
    steady, wild = (
        posterior_bound(*given, 1.0, SCALE, HOLDER._replace(level=size * HOLDER.level))
        for size in (1.0, 10.0)
    )
    assert (np.linalg.eigvalsh(wild.state - steady.state) > -1e-12).all()
    assert (np.linalg.eigvalsh(wild.reactions - steady.reactions) > -1e-9).all()
    # Where nothing else is said, the holder is as steady as the motion was.
    own = posterior_bound(*given, 1.0, SCALE)
    t, state, _ = given[1]
    said = smoothness(t, np.gradient(state[:, 3:], t, axis=0))
    np.testing.assert_array_equal(own.state, posterior_bound(*given, 1.0, SCALE, said).state)


def test_friction_is_learnt_and_costs():
    known = motion()
    unknown = motion(known=(0.05, 0.0))
    with_it, without = (posterior_bound(*given, 1.0, SCALE, HOLDER) for given in (unknown, known))
    learnt = np.sqrt(with_it.parameters[:, 0, 0])
    assert (np.diff(learnt) <= 1e-12).all()
    assert learnt[-1] < 0.2 * learnt[0]
    assert (np.linalg.eigvalsh(with_it.state - without.state) > -1e-12).all()


def test_scales_with_the_noise():
    scene, moved, sensors = motion(count=40)
    one = posterior_bound(scene, moved, sensors, 1.0, SCALE, HOLDER)
    twice = Sensors(4 * sensors.wrench_noise, 2 * STDDEV, sensors.measured)
    wilder = HOLDER._replace(level=2 * HOLDER.level)
    two = posterior_bound(scene, moved, twice, 2.0, SCALE, wilder)
    np.testing.assert_allclose(two.state, 4 * one.state, rtol=1e-6, atol=1e-16)
    np.testing.assert_allclose(two.reactions, 4 * one.reactions, rtol=1e-6, atol=1e-10)


def test_more_orientations_leave_less():
    scene, moved, sensors = motion(count=80)
    some = posterior_bound(scene, moved, sensors, 1.0, SCALE, HOLDER)
    every = sensors._replace(measured=np.ones(80, bool))
    more = posterior_bound(scene, moved, every, 1.0, SCALE, HOLDER)
    assert (np.linalg.eigvalsh(some.state - more.state) > -1e-15).all()


def test_the_estimator_comes_near_it_in_steady_sliding_and_does_not_beat_it():
    cut = first_samples(truth("closing_with_slip"), 300)
    settings = cut.plan.configuration
    scene = replace(settings.scene, friction_stddev=0.0)
    sensors = Sensors(
        WrenchReduction(settings.wrench, scene).covariance,
        settings.joints.position_stddev,
        np.arange(300) % 2 == 0,
    )
    state = np.hstack([cut.q, cut.rates])
    moved = TrueMotion(cut.t_ns * 1e-9, state, true_wrench(cut))
    bound = posterior_bound(scene, moved, sensors)
    errors = []
    for seed in range(6):
        record = recorded(cut, 8100 + seed)
        peg = make_filter(scene, settings.filter, sensors.wrench_noise)
        peg.start(record.angles[0], record.covariances[0])
        rows = []
        for k in range(1, 300):
            peg.predict(record.dt)
            if np.isfinite(record.angles[k]).all():
                peg.correct(record.angles[k], record.covariances[k])
            peg.weigh(record.wrench[k], ContactSet.THREE)
            rows.append(peg.reactions()[0] - cut.normal[k])
        errors.append(rows)
    settled = slice(100, None)
    assert (bound.meaning[settled] == Meaning.SOUND).all()
    sigma = np.sqrt(np.diagonal(bound.reactions, axis1=1, axis2=2))[settled]
    ratio = np.sqrt(((np.array(errors)[:, 99:] / sigma) ** 2).mean(axis=(0, 1)))
    # Reactions follow the wrench's noise, which is white: 1200 draws, known to 3 %.
    assert (ratio > 0.92).all() and (ratio < 1.2).all(), ratio


def test_says_where_it_means_nothing():
    scene, moved, sensors = motion(count=40)
    state = moved.state
    still = state.copy()
    still[20:, 3:] = 1e-7
    bound = posterior_bound(scene, moved._replace(state=still), sensors, 1.0, SCALE, HOLDER)
    assert (bound.meaning[20:] == Meaning.SLOW).all()
    low = state.copy()
    low[30:, 0] = scene.gamma0 + 2e-5
    bound = posterior_bound(scene, moved._replace(state=low), sensors, 1.0, SCALE, HOLDER)
    assert np.isin(bound.meaning[30:], (Meaning.TRANSITION, Meaning.SLOW)).all()
    assert (bound.meaning[30:] == Meaning.TRANSITION).any()
    wedged = state.copy()
    wedged[30:, 0], wedged[30:, 3:] = 0.0645, (-16.0, 0.0, 0.0)
    bound = posterior_bound(scene, moved._replace(state=wedged), sensors, 1.0, SCALE, HOLDER)
    assert (bound.determinant[30:] < 0.05).all()
    assert (bound.meaning[30:] != Meaning.SOUND).all()


def test_slip_speed_is_the_truths():
    bound = posterior_bound(*motion(count=20))
    np.testing.assert_allclose(
        bound.slip_speed, truth("closing_with_slip").slip_speed[:20], rtol=1e-9
    )


@pytest.mark.parametrize(
    "change, text",
    [
        ({"t": np.zeros(30)}, "rise"),
        ({"wrench": np.zeros((30, 5))}, r"\(30, 5\)"),
        ({"state": np.full((30, 6), np.nan)}, "not finite"),
        ({"state": np.full((30, 6), 0.01)}, "not above gamma0"),
    ],
)
def test_refuses_what_is_no_motion(change, text):
    scene, moved, sensors = motion(count=30)
    with pytest.raises(PegOnHoleError, match=text):
        posterior_bound(scene, moved._replace(**change), sensors)


def test_begins_at_an_orientation():
    scene, moved, sensors = motion(count=30)
    later = sensors._replace(measured=np.arange(30) % 2 == 1)
    with pytest.raises(PegOnHoleError, match=r"measured\[0\] is False: .* cut the motion"):
        posterior_bound(scene, moved, later)
    later = later._replace(measured=later.measured[1:])
    posterior_bound(scene, TrueMotion(*(part[1:] for part in moved)), later)
