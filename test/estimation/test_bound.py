"""The bound against Kalman filters built another way, and against the filter's own errors."""

from dataclasses import replace

import numpy as np
import pytest
from bound_reached import particles
from filterpy.kalman import KalmanFilter
from peg_on_hole_ros.estimation.kernel.acceleration import LEAST, acceleration_variance
from peg_on_hole_ros.estimation.reference.steps import solve_with_slopes
from scipy.linalg import solve_discrete_are

from benchmarks.grid.cells import first_samples, with_noise
from benchmarks.grid.score import bound_of, peg_wrench, run_seeds
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimation.bound import Meaning, Sensors, posterior_bound
from peg_on_hole_ros.estimation.measurement import WrenchReduction, angle_covariance
from peg_on_hole_ros.options import WrenchInput
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.simulation.measure import measure
from simulated import truth

SCALE, STEP, STDDEV, RATE_STDDEV = 1e-5, 1e-3, 1e-4, 1.0


def motion(name="closing_with_slip", count=120, known=(0.0, 0.0)):
    """Scene, times, states, wrenches and sensors of the first samples of a truth."""
    cut = first_samples(truth(name), count)
    scene = replace(
        cut.plan.configuration.scene, friction_stddev=known[0], clearance_stddev=known[1]
    )
    noise = WrenchReduction(WrenchInput(), scene).covariance
    sensors = Sensors(noise, STDDEV, np.arange(count) % 2 == 0)
    return scene, cut.t_ns * 1e-9, np.hstack([cut.q, cut.rates]), peg_wrench(cut), sensors


def step_matrices(scene, x, u):
    """F, G of the implicit step that ends at x, and dy, from the numpy model by complex steps."""
    full = np.concatenate([x, u, [scene.friction, scene.peg_diameter]])
    _, dy = solve_with_slopes(scene, full, SCALE)
    a_q, a_v, a_u = dy[:3, :3], dy[:3, 3:6], dy[:3, 6:]
    # v = v0 + h a(q0 + h v, v, u), differentiated as a whole.
    left = np.block([[np.eye(3), -STEP * np.eye(3)], [-STEP * a_q, np.eye(3) - STEP * a_v]])
    right = np.hstack([np.eye(6), np.vstack([np.zeros((3, 8)), STEP * a_u])])
    both = np.linalg.solve(left, right)
    return both[:, :6], both[:, 6:], dy


def test_particles_that_make_no_tangents_spread_as_wide():
    cut = first_samples(truth("closing_with_slip"), 81)
    cut = with_noise(cut, "nominal", 0.0)
    track = particles(cut, 0, 2000, 81, pieces=1)
    bound = bound_of(cut)
    assert (bound.meaning[40:] == Meaning.SOUND).all()
    parts = bound.state, bound.reactions
    stddev = np.sqrt(np.hstack([np.diagonal(part, axis1=1, axis2=2) for part in parts]))
    ratio = np.sqrt(((track.stddev[:, :9] / stddev)[40:] ** 2).mean(axis=0))
    # What particles say of their own spread depends on what they drew: by 2 % rms, over seeds.
    np.testing.assert_allclose(ratio, 1.0, atol=0.1)
    # One run errs as one may.
    assert (np.abs(track.error[:, :9] / stddev)[40:].mean(axis=0) < 2.0).all()
    # Friction is known.
    assert np.abs([track.error[40:, 9], track.stddev[40:, 9]]).max() < 1e-12


@pytest.mark.parametrize("known, walk", [((0.0, 0.0), 0.0), ((0.05, 2e-6), 0.002)])
def test_equals_kalman_covariance_of_the_linearised_motion(known, walk):
    given = motion(known=known)
    scene, t, state, wrench, sensors = given
    bound = posterior_bound(*given, RATE_STDDEV, SCALE, friction_noise=walk)
    prior = posterior_bound(*given, RATE_STDDEV, SCALE, 20.0, friction_noise=walk)
    kalman = KalmanFilter(dim_x=14, dim_z=3)
    kalman.H = np.eye(3, 14)
    kalman.P = np.zeros((14, 14))
    kalman.P[:3, :3] = angle_covariance(state[0, 0], STDDEV)
    kalman.P[range(3, 6), range(3, 6)] = RATE_STDDEV**2
    kalman.P[12:, 12:] = np.diag(np.square(known))
    kalman.Q = np.zeros((14, 14))
    kalman.Q[12, 12] = walk**2 * STEP
    for k in range(1, len(t)):
        F, G, dy = step_matrices(scene, state[k], wrench[k])
        kalman.P[6:12, :], kalman.P[:, 6:12] = 0, 0
        kalman.P[6:12, 6:12] = sensors.wrench_noise
        kalman.F = np.vstack([np.hstack([F, G]), np.eye(8, 14, 6)])
        kalman.predict()
        if sensors.measured[k]:
            kalman.update(np.zeros(3), R=angle_covariance(state[k, 0], STDDEV))
        # Two ways to the same numbers differ by rounding times the condition of the innovation.
        np.testing.assert_allclose(bound.state[k], kalman.P[:6, :6], rtol=1e-6, atol=1e-15)
        np.testing.assert_allclose(bound.parameters[k], kalman.P[12:, 12:], rtol=1e-6, atol=1e-18)
    C = dy @ kalman.P @ dy.T
    np.testing.assert_allclose(bound.reactions[-1], C[3:, 3:], rtol=1e-6)
    # What is known of the accelerations, in information form.
    information = np.linalg.inv(C) + np.diag([20.0**-2] * 3 + [0] * 3)
    np.testing.assert_allclose(prior.reactions[-1], np.linalg.inv(information)[3:, 3:], rtol=1e-6)
    assert (np.diagonal(prior.reactions[-1]) < np.diagonal(bound.reactions[-1])).all()


def test_information_form_gives_the_same():
    scene, t, state, wrench, sensors = motion(count=60)
    bound = posterior_bound(scene, t, state, wrench, sensors, RATE_STDDEV, SCALE)
    prior = [*np.diagonal(angle_covariance(state[0, 0], STDDEV)), *[RATE_STDDEV**2] * 3]
    P0 = np.diag(prior)
    P0[:3, :3] = angle_covariance(state[0, 0], STDDEV)
    J, Q = np.linalg.inv(P0), sensors.wrench_noise
    for k in range(1, len(t)):
        F, G, _ = step_matrices(scene, state[k], wrench[k])
        back = np.linalg.inv(F)
        G = G[:, :6]
        M = back.T @ J @ back
        J = M - M @ G @ np.linalg.inv(G.T @ M @ G + np.linalg.inv(Q)) @ G.T @ M
        if sensors.measured[k]:
            J[:3, :3] += np.linalg.inv(angle_covariance(state[k, 0], STDDEV))
        spread = np.sqrt(np.diagonal(bound.state[k]))
        # Information spans ten decades (rates against angles), and leaves six digits.
        np.testing.assert_allclose(np.sqrt(np.diagonal(np.linalg.inv(J))), spread, rtol=1e-5)


def test_steady_state_solves_the_riccati_equation():
    scene, _, state, wrench, sensors = motion()
    n = 1500
    x, u = state[50], wrench[50]
    always = sensors._replace(measured=np.ones(n, bool))
    bound = posterior_bound(
        scene, np.arange(n) * STEP, np.tile(x, (n, 1)), np.tile(u, (n, 1)), always,
        RATE_STDDEV, SCALE,
    )  # fmt: skip
    F, G, _ = step_matrices(scene, x, u)
    G = G[:, :6]
    R, H = angle_covariance(x[0], STDDEV), np.eye(3, 6)
    P = solve_discrete_are(F.T, H.T, G @ sensors.wrench_noise @ G.T, R)
    P = P - P @ H.T @ np.linalg.solve(H @ P @ H.T + R, H @ P)
    np.testing.assert_allclose(bound.state[-1], P, rtol=1e-5, atol=1e-14)


def test_friction_is_learnt_and_costs():
    known = motion()
    unknown = motion(known=(0.05, 0.0))
    with_it, without = (posterior_bound(*given, 1.0, SCALE) for given in (unknown, known))
    learnt = np.sqrt(with_it.parameters[:, 0, 0])
    assert (np.diff(learnt) <= 1e-12).all()
    assert learnt[-1] < 0.2 * learnt[0]
    assert (np.linalg.eigvalsh(with_it.state - without.state) > -1e-12).all()


def test_scales_with_the_noise():
    scene, t, state, wrench, sensors = motion(count=40)
    one = posterior_bound(scene, t, state, wrench, sensors, 1.0, SCALE, 20.0)
    twice = Sensors(4 * sensors.wrench_noise, 2 * STDDEV, sensors.measured)
    two = posterior_bound(scene, t, state, wrench, twice, 2.0, SCALE, 40.0)
    np.testing.assert_allclose(two.state, 4 * one.state, rtol=1e-7, atol=1e-18)
    np.testing.assert_allclose(two.reactions, 4 * one.reactions, rtol=1e-7, atol=1e-12)


def test_more_orientations_and_finer_steps():
    scene, t, state, wrench, sensors = motion(count=80)
    some = posterior_bound(scene, t, state, wrench, sensors, 1.0, SCALE)
    every = sensors._replace(measured=np.ones(80, bool))
    more = posterior_bound(scene, t, state, wrench, every, 1.0, SCALE)
    assert (np.linalg.eigvalsh(some.state - more.state) > -1e-15).all()
    # Implicit Euler's error is of first order in the step: each halving halves what is left.
    spread = [
        np.sqrt(np.diagonal(posterior_bound(
            scene, t, state, wrench, sensors, 1.0, SCALE, pieces=pieces
        ).state[-1]))
        for pieces in (8, 16, 32)
    ]  # fmt: skip
    order = np.log2((spread[1] - spread[0]) / (spread[2] - spread[1]))
    assert (np.abs(order[3:] - 1) < 0.25).all(), order


def accelerations_said(cut, seed):
    """How far they may be from what one run has followed of them, shape (n, 3)."""
    stddev, said = cut.plan.configuration.filter.acceleration_stddev, []
    pipeline = Pipeline(cut.plan.configuration)
    for _ in pipeline.play(measure(cut, seed)):
        kalman = pipeline.filter
        said.append([acceleration_variance(kalman.memory, i, stddev, LEAST) for i in range(3)])
    missing = len(cut.t_ns) - len(said)
    return np.sqrt(np.vstack([np.full((missing, 3), stddev**2), said]))


def test_the_filter_reaches_it_in_steady_sliding():
    cut = with_noise(first_samples(truth("closing_with_slip"), 400), "nominal", 0.0)
    bound = bound_of(cut)
    runs = run_seeds(cut, range(8100, 8106))
    settled = slice(100, None)
    assert (bound.meaning[settled] == Meaning.SOUND).all()
    sigma = np.sqrt(np.diagonal(bound.state, axis1=1, axis2=2))[settled]
    ratio = np.sqrt(((runs.error[:, settled, :6] / sigma) ** 2).mean(axis=(0, 1)))
    # Errors keep for some 10 ms: 6 runs of 300 ms make about 180 independent ones, and their root
    # mean square is known to 1 / sqrt(360) = 5 %.
    assert (np.abs(ratio - 1) < 0.16).all(), ratio
    # The filter's own covariance follows another code; it is taken at the estimate, not the truth.
    # How steady the peg is it has seen: the reactions' bound is given what it says of that.
    bound = bound_of(cut, accelerations_said(cut, 8100))
    reactions = np.sqrt(np.diagonal(bound.reactions, axis1=1, axis2=2))[settled]
    stated = np.median(runs.stddev[:, settled], axis=(0, 1))
    np.testing.assert_allclose(stated[:6], np.median(sigma, axis=0), rtol=0.03)
    np.testing.assert_allclose(stated[6:], np.median(reactions, axis=0), rtol=0.05)


def test_says_where_it_means_nothing():
    scene, t, state, wrench, sensors = motion(count=40)
    still = state.copy()
    still[20:, 3:] = 1e-7
    bound = posterior_bound(scene, t, still, wrench, sensors, 1.0, SCALE)
    assert (bound.meaning[20:] == Meaning.SLOW).all()
    low = state.copy()
    low[30:, 0] = scene.gamma0 + 2e-5
    bound = posterior_bound(scene, t, low, wrench, sensors, 1.0, SCALE)
    assert np.isin(bound.meaning[30:], (Meaning.TRANSITION, Meaning.SLOW)).all()
    assert (bound.meaning[30:] == Meaning.TRANSITION).any()
    wedged = state.copy()
    wedged[30:, 0], wedged[30:, 3:] = 0.0645, (-16.0, 0.0, 0.0)
    bound = posterior_bound(scene, t, wedged, wrench, sensors, 1.0, SCALE)
    assert (bound.determinant[30:] < 0.05).all()
    assert (bound.meaning[30:] != Meaning.SOUND).all()


def test_slip_speed_is_the_truths():
    scene, t, state, wrench, sensors = motion(count=20)
    bound = posterior_bound(scene, t, state, wrench, sensors)
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
    scene, t, state, wrench, sensors = motion(count=30)
    with pytest.raises(PegOnHoleError, match=text):
        posterior_bound(
            scene, **({"t": t, "state": state, "wrench": wrench, "sensors": sensors} | change)
        )


def test_begins_at_an_orientation():
    scene, t, state, wrench, sensors = motion(count=30)
    later = sensors._replace(measured=np.arange(30) % 2 == 1)
    with pytest.raises(PegOnHoleError, match=r"measured\[0\] is False: .* cut the motion"):
        posterior_bound(scene, t, state, wrench, later)
    later = later._replace(measured=later.measured[1:])
    posterior_bound(scene, t[1:], state[1:], wrench[1:], later)
