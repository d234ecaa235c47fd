"""The contact filter by itself: derivatives, orders, covariance, failures."""

from dataclasses import replace

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.contact import Prediction
from peg_on_hole_ros.estimation.filters.methods import FILTERS, make_filter
from peg_on_hole_ros.estimation.kernel import prediction
from peg_on_hole_ros.estimation.kernel.held_wrench import JUMP_LIMIT
from peg_on_hole_ros.estimation.kernel.memory import part
from peg_on_hole_ros.estimation.kernel.parameters import BENT
from peg_on_hole_ros.estimation.kernel.reactions import react
from peg_on_hole_ros.estimation.steps.implicit_euler import CONVERGED, FAILED, implicit_euler
from peg_on_hole_ros.estimation.steps.second_order import SHARE, sdirk2
from scipy.integrate import solve_ivp

from peg_on_hole_ros.estimation.measurement import angle_covariance
from peg_on_hole_ros.mechanics.kernel import WIDTH, accelerate, scene_scalars, workspace
from peg_on_hole_ros.options import FilterOptions
from sliding_filter import PLAIN, SCENE, WRENCH_NOISE, P, balanced, sliding


def one_step(x, u, h, scales, p=P):
    x1, y, dy, slopes = np.zeros(6), np.zeros(6), np.zeros((6, WIDTH)), np.zeros((3, WIDTH))
    status, _ = implicit_euler(p, scales, x, u, h, x1, y, dy, slopes, workspace())
    return status, x1, slopes


@pytest.mark.parametrize("seed", range(5))
def test_slopes_of_a_step_are_those_of_its_differences(seed):
    rng = np.random.default_rng(seed)
    x = np.array([rng.uniform(0.08, 0.3), *rng.uniform(-3, 3, 2), *rng.normal(size=3)])
    u, scales, h = balanced(x), np.array([1e-3, 3e-3, 2e-3]), 1e-3
    _, _, slopes = one_step(x, u, h, scales)
    for j in range(12):
        # Slips change by some 0.1 m/s per unit of the rates: far within the friction's scale.
        small = 1e-5
        ends = []
        for sign in (1, -1):
            moved = np.concatenate([x, u])
            moved[j] += sign * small
            status, x1, _ = one_step(moved[:6], moved[6:], h, scales)
            assert status == CONVERGED
            ends.append(x1)
        difference = (ends[0] - ends[1])[3:] / (2 * small)
        # Newton's residual of 1e-11 over the step of 1e-5, and as much again for curvature.
        size = max(1.0, np.abs(slopes).max())
        np.testing.assert_allclose(slopes[:, j], difference, rtol=0, atol=5e-6 * size)


def test_slopes_by_friction_and_diameter_are_those_of_its_differences():
    rng = np.random.default_rng(21)
    x = np.array([0.12, 0.3, -0.4, *rng.normal(size=3)])
    u, scales, h = balanced(x), np.array([1e-3, 3e-3, 2e-3]), 1e-3
    _, _, slopes = one_step(x, u, h, scales)
    # Mass and inertia stay: the step by the diameter is one of the clearance alone.
    fixed = {"transverse_inertia": SCENE.transverse_inertia, "axial_inertia": SCENE.axial_inertia}
    for column, name, small in ((12, "friction", 1e-5), (13, "peg_diameter", 1e-8)):
        ends = []
        for sign in (1, -1):
            value = getattr(SCENE, name) + sign * small
            p = scene_scalars(replace(SCENE, **{name: value}, **fixed))
            ends.append(one_step(x, u, h, scales, p)[1])
        difference = (ends[0] - ends[1])[3:] / (2 * small)
        # 1e-11 of Newton's residual over the step, and 1e-6 of curvature.
        atol = 1e-11 / small + 1e-5 * np.abs(difference).max()
        np.testing.assert_allclose(slopes[:, column], difference, rtol=0, atol=atol)


SCALE = np.array([1e-4] * 3 + [1e-2] * 3 + [0.2] * 3 + [5e-3] * 3 + [0.02, 2e-6])


def put_joint(kalman, joint):
    """Set the joint covariance of state, wrench, friction and peg diameter."""
    kalman.Z[:] = joint[:12, :12]
    part(kalman._memory, "CROSS", (2, 12))[:] = joint[12:, :12]
    kalman.spread[:] = joint[12:, 12:]


def random_joint(seed, size=14):
    root = np.random.default_rng(seed).normal(size=(size, size)) * SCALE[:size, None]
    joint = np.zeros((14, 14))
    joint[:size, :size] = root @ root.T
    return joint


@pytest.mark.parametrize("size", [12, 14])
def test_covariance_is_carried_by_the_slopes_of_the_step(size):
    kalman, before, h = sliding(), random_joint(1, size), 2e-3
    put_joint(kalman, before)
    _, _, G = one_step(kalman.x.copy(), kalman.u, h, np.full(3, PLAIN.slip_velocity_scale))
    F, noise = np.eye(14), np.zeros((14, 3))
    F[3:6], F[:3] = G, np.eye(14)[:3] + h * G
    noise[3:6], noise[:3] = np.eye(3), h * np.eye(3)
    expected = F @ before @ F.T + PLAIN.contact_rate_noise**2 * h * noise @ noise.T
    expected[12, 12] += (size > 12) * PLAIN.friction_noise**2 * h
    assert kalman.predict(h, True) is Prediction.CONTACT
    # Sums of a dozen products, whose rounding the correlation may enlarge.
    found, scale = kalman.joint_covariance(), np.outer(SCALE, SCALE)
    np.testing.assert_allclose(found / scale, expected / scale, rtol=1e-10, atol=1e-11)
    np.testing.assert_array_equal(kalman.Z, kalman.Z.T)


@pytest.mark.parametrize("learnt", [(1, 1), (1, 0), (0, 1), (0, 0)])
def test_parameters_are_corrected_or_considered_as_by_schmidt(learnt):
    kalman, before = sliding(), random_joint(4)
    put_joint(kalman, before)
    part(kalman._memory, "LEARNT")[:] = learnt
    part(kalman._memory, "SLIDING")[:] = 1.0
    R = angle_covariance(kalman.x[0], 1e-4)
    H = np.eye(14)[:3]
    gain = before @ H.T @ np.linalg.inv(H @ before @ H.T + R)
    gain[12:] *= np.array(learnt)[:, None]
    residual = np.array([2e-5, -4e-5, 3e-5])
    values = np.array([kalman.friction[0], kalman.peg_diameter[0]])
    kalman.correct(kalman.x[:3] + residual, R)
    moved = np.array([kalman.friction[0], kalman.peg_diameter[0]]) - values
    np.testing.assert_allclose(moved, gain[12:] @ residual, rtol=1e-8, atol=1e-15)
    rest = np.eye(14) - gain @ H
    expected = rest @ before @ rest.T + gain @ R @ gain.T
    scale = np.outer(SCALE, SCALE)
    np.testing.assert_allclose(
        kalman.joint_covariance() / scale, expected / scale, rtol=1e-8, atol=1e-9
    )
    expected_gamma0 = 2 * np.arcsin(
        np.sqrt((SCENE.hole_diameter - kalman.peg_diameter[0]) / (2 * SCENE.hole_diameter))
    )
    assert kalman.gamma0 == pytest.approx(expected_gamma0, rel=1e-12)


@pytest.mark.parametrize("method", ["extended", "square_root"])
@pytest.mark.parametrize("size, bent", [(1.0, False), (119.0, True), (300.0, True)])
def test_what_moves_friction_far_has_told_less_than_its_tangent_says(method, size, bent):
    options = replace(PLAIN, method=method, inflation_threshold=np.inf, gate_threshold=np.inf)
    kalman, before = make_filter(SCENE, options, WRENCH_NOISE), random_joint(4)
    kalman.start(np.array([0.15, 0.3, -0.4]), np.eye(3))
    put_joint(kalman, before)
    if method == "square_root":
        kalman._set_anew()
    part(kalman._memory, "LEARNT")[:] = 1.0, 0.0
    part(kalman._memory, "SLIDING")[:] = 1.0
    R = angle_covariance(kalman.x[0], 1e-4)
    told = before[12, :3] @ np.linalg.solve(before[:3, :3] + R, before[:3, 12])
    friction, tangent = kalman.friction[0], before[12, 12] - told
    kalman.correct(kalman.x[:3] + size * np.array([2e-5, -4e-5, 3e-5]), R)
    least = (BENT * (kalman.friction[0] - friction)) ** 2
    assert (tangent < least) == bent
    expected = min(least, before[12, 12]) if bent else tangent
    assert kalman.spread[0, 0] == pytest.approx(expected, rel=1e-8)
    if method == "square_root":
        assert (kalman._root @ kalman._root.T)[12, 12] == pytest.approx(expected, rel=1e-8)


def test_correction_is_the_textbooks():
    kalman = sliding()
    for _ in range(5):
        kalman.predict(1e-3, True)
    Z, xu = kalman.Z.copy(), np.concatenate([kalman.x, kalman.u])
    R = angle_covariance(kalman.x[0], 1e-4)
    q = kalman.x[:3] + [5e-5, -3e-4, 4e-4]
    kalman.correct(q, R)
    gain = Z[:, :3] @ np.linalg.inv(Z[:3, :3] + R)
    stddev = np.sqrt(np.diagonal(Z))
    # The innovation's covariance has a condition number of some 1e3 (psi and phi at a small tilt).
    expected = xu + gain @ (q - xu[:3])
    error = (np.concatenate([kalman.x, kalman.u]) - expected) / stddev
    assert np.abs(error).max() < 1e-11
    error = (kalman.Z - (Z - gain @ Z[:3])) / np.outer(stddev, stddev)
    assert np.abs(error).max() < 1e-11
    np.testing.assert_array_equal(kalman.Z, kalman.Z.T)


def test_an_angle_off_by_turns_corrects_alike():
    ends = []
    for turns in ([0, 0, 0], [0, 2 * np.pi, -6 * np.pi]):
        kalman = sliding()
        kalman.predict(1e-3, True)
        kalman.correct(kalman.x[:3] + [1e-5, 1e-4, -1e-4] + turns, angle_covariance(0.15, 1e-4))
        ends.append(kalman.x.copy())
    # A turn is known to 1e-15 rad; the gain for the rates is below 100 1/s.
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-12)


def test_covariance_stays_symmetric_and_positive_over_a_run():
    kalman = sliding(FilterOptions())
    rng = np.random.default_rng(5)
    R = angle_covariance(0.15, 1e-4)
    u = kalman.u.copy()
    for k in range(3000):
        kalman.hold(u + rng.normal(size=6) * np.sqrt(np.diagonal(WRENCH_NOISE)))
        kalman.predict(1e-3, True)
        # Measurements where the filter is: the motion turns round, slips pass zero.
        if k % 2 == 0:
            q = [0.15 + 0.02 * np.cos(8e-3 * k), 0.3 * np.sin(6e-3 * k), 0.8 * np.cos(5e-3 * k)]
            kalman.correct(q + np.linalg.cholesky(R) @ rng.normal(size=3), R)
        np.testing.assert_array_equal(kalman.Z, kalman.Z.T)
        stddev = np.sqrt(np.diagonal(kalman.P))
        assert np.linalg.eigvalsh(kalman.P / np.outer(stddev, stddev))[0] > 1e-9


def test_longer_steps_converge_at_first_order():
    ends = []
    pieces = (2, 4, 8, 16, 2048)
    for count in pieces:
        kalman = sliding(replace(PLAIN, max_step=0.02 / count))
        assert kalman.predict(0.02, True) is Prediction.CONTACT
        assert kalman.pieces == count
        ends.append(kalman.x.copy())
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    # The reference of 2048 pieces has an error of its own, 1/128 of the last one's.
    np.testing.assert_allclose(orders, 1.0, atol=0.15)


def test_pieces_of_one_prediction_are_as_many_predictions():
    whole, many = sliding(replace(PLAIN, max_step=1e-3)), sliding()
    whole.predict(0.02, True)
    for _ in range(20):
        many.predict(0.001, True)
    assert whole.pieces == 20
    # 0.02 / 20 and 0.001 differ by rounding.
    np.testing.assert_allclose(whole.x, many.x, rtol=1e-12)
    stddev = np.sqrt(np.diagonal(many.Z))
    np.testing.assert_allclose(
        whole.Z / np.outer(stddev, stddev), many.Z / np.outer(stddev, stddev), atol=1e-10
    )


@pytest.mark.parametrize("allowed, outcome", [(100, prediction.LIMITED), (10_000, FAILED)])
def test_a_failed_prediction_leaves_state_and_covariance(allowed, outcome):
    # Half of the way that 20 ms take is there until gamma0: pieces succeed before one fails.
    options = replace(PLAIN, max_step=1e-3, max_evaluations=allowed)
    kalman = sliding(options, (SCENE.gamma0 + 1.6e-3, 0.3, -0.4, -0.16, 0.4, 2.0))
    assert kalman.predict(1e-3, True) is Prediction.CONTACT
    memory = [part(kalman._memory, name) for name in ("X", "U", "Z")]
    before = [view.copy() for view in memory]
    status, evaluations, pieces = prediction.predict_contact(
        kalman._memory, kalman._dy, kalman._slopes, 0.019
    )
    assert status == outcome and evaluations > pieces >= 19
    for view, kept in zip(memory, before):
        np.testing.assert_array_equal(view, kept)


def test_below_gamma0_a_prediction_says_that_it_failed_and_stays_finite():
    kalman = sliding(x=(SCENE.gamma0 + 1e-3, 0.3, -0.4, -0.16, 0.4, 2.0))
    kalman.x[0] = SCENE.gamma0 * 0.99
    before = kalman.x.copy()
    assert kalman.predict(1e-3, True) is Prediction.FAILED
    # At constant rates, then.
    np.testing.assert_allclose(kalman.x[:3], before[:3] + 1e-3 * before[3:], rtol=1e-15)
    np.testing.assert_array_equal(kalman.x[3:], before[3:])
    assert np.isfinite(kalman.Z).all()
    assert kalman.reactions() is None
    estimate = kalman.describe(False, 30.0)
    assert all(np.isfinite(values).all() for values in estimate)


def test_wrench_noise_drives_the_state_and_enters_the_reactions():
    """What is stated of the reactions is their spread over noise that acts in both ways."""
    # Near stick, where friction answers to what the same noise does to the slip.
    options = replace(
        PLAIN, acceleration_stddev=1e6, contact_rate_noise=1e-9, slip_velocity_scale=1e-3
    )
    # So little noise that all is straight lines in it.
    noise = np.diag([2e-3**2] * 3 + [5e-5**2] * 3)
    kalman = sliding(options, (0.15, 0.3, -0.4, -0.01, 0.01, 0.03), noise)
    spread = np.array([1e-8, 1e-7, 1e-7, 1e-6, 2e-6, 3e-6])
    kalman.Z[:6, :6] = np.diag(spread**2)
    x, u, Z = kalman.x.copy(), kalman.u.copy(), kalman.Z.copy()
    kalman.predict(1e-3, True)
    cross = kalman.Z[:6, 6:].copy()
    kalman.reactions()
    stated = part(kalman._memory, "REACTIONS", (6, 6))[3:, 3:].copy()
    kalman.Z[:6, 6:] = kalman.Z[6:, :6] = 0.0
    kalman.reactions()
    without = part(kalman._memory, "REACTIONS", (6, 6))[3:, 3:].copy()

    rng = np.random.default_rng(3)
    count = 20_000
    found, ends = np.empty((count, 3)), np.empty((count, 6))
    errors = rng.normal(size=(count, 6)) * np.sqrt(np.diagonal(noise))
    for k in range(count):
        # The true motion, from a true state and a true wrench; what is known of it is x and u.
        kalman.Z[:] = Z
        kalman.x[:] = x + rng.normal(size=6) * spread
        kalman.u[:] = u + errors[k]
        kalman.predict(1e-3, True)
        react(kalman._memory, kalman._dy, 1e6)
        found[k], ends[k] = kalman._normal, kalman.x
    sample = np.cov(found.T)
    stddev = np.sqrt(np.diagonal(sample))
    # A sampled covariance is known to sqrt(2 / 20000) = 1 %.
    error = np.abs(stated - sample) / np.outer(stddev, stddev)
    assert error.max() < 0.04
    assert (np.abs(without - sample) / np.outer(stddev, stddev)).max() > 0.1
    joint = np.cov(ends.T, errors.T)
    size = np.sqrt(np.diagonal(joint))
    error = np.abs(joint[:6, 6:] - cross) / np.outer(size[:6], size[6:])
    assert error.max() < 0.04
    assert (np.abs(cross) / np.outer(size[:6], size[6:])).max() > 0.1


# By (N, N m), the last two by more than twice the noise of two wrenches.
CHANGES = (
    np.array([0.3, -0.2, 0.4, 4e-3, 0.0, -5e-3]),
    np.array([0.0, 0.8, 1.0, 0.0, 0.0, 0.0]),
    np.array([0.0, 1.4, 1.4, 0.0, 0.0, 0.0]),
)


def ramp_share(change):
    size = change @ np.linalg.solve(WRENCH_NOISE, change) / 2
    return np.sqrt(max(0.0, 1 - JUMP_LIMIT / size))


@pytest.mark.parametrize("change", CHANGES)
def test_when_a_wrench_jumped_within_its_interval_is_unknown(change):
    grown = []
    for jump in (True, False):
        kalman = sliding()
        kalman.hold(kalman.u + change)
        part(kalman._memory, "JUMP")[:] *= jump
        kalman.predict(1e-3, True)
        grown.append(kalman.Z[:6, :6].copy())
    grown = grown[0] - grown[1]
    if not ramp_share(change):
        # A change within the noise of two wrenches tells nothing.
        assert not grown.any()
        return
    kalman = sliding()
    u, scales = kalman.u + change, np.full(3, PLAIN.slip_velocity_scale)
    ramp = ramp_share(change) * change
    x1, y, dy, slopes = np.zeros(6), np.zeros(6), np.zeros((6, WIDTH)), np.zeros((6, WIDTH))
    sdirk2(
        P, scales, kalman.x, u - (1 - SHARE) * ramp, u, 1e-3, x1, y, dy, slopes, np.zeros(96),
        workspace(),
    )  # fmt: skip
    # The mean of a change that comes at any one time differs from that of a ramp by a twelfth.
    moved = slopes[:, 6:12] @ ramp / np.sqrt(12)
    moved = np.concatenate([moved[3:], moved[:3]])
    np.testing.assert_allclose(grown, np.outer(moved, moved), rtol=1e-6, atol=1e-15)


@pytest.mark.parametrize("model", ["dynamic", "quasi_static"])
@pytest.mark.parametrize(("friction", "walks"), [("estimated", True), ("considered", False)])
def test_a_friction_that_is_only_considered_does_not_walk(friction, walks, model):
    kalman = sliding(replace(PLAIN, friction=friction, model=model))
    kalman.spread[0, 0] = 0.01**2
    expected = Prediction.CONTACT if model == "dynamic" else Prediction.HELD
    assert kalman.predict(1e-3, True) is expected
    walk = PLAIN.friction_noise**2 * 1e-3
    assert kalman.spread[0, 0] - 0.01**2 == pytest.approx(walk if walks else 0.0, rel=1e-6)


def test_a_wrench_that_jumps_is_a_ramp():
    """Against scipy under the same ramp, and against the wrench as it is at the end."""
    change = CHANGES[2]
    kalman = sliding()
    begin, before, work = kalman.x.copy(), kalman.u.copy(), workspace()
    scales = np.full(3, PLAIN.slip_velocity_scale)
    end, ramp = before + change, ramp_share(change) * change

    def rates(t, x):
        y = np.zeros(6)
        accelerate(P, scales, x, end - (1 - t / 1e-3) * ramp, work, y)
        return np.concatenate([x[3:], y[:3]])

    truth = solve_ivp(rates, (0, 1e-3), begin, method="Radau", rtol=1e-11, atol=1e-13).y[:, -1]
    errors = {}
    for share in (1.0, 0.0):
        kalman = sliding(replace(PLAIN, wrench_jump=share))
        kalman.hold(end)
        assert kalman.predict(1e-3, True) is Prediction.CONTACT
        errors[share] = np.abs(kalman.x - truth)[3:].max()
    moved = np.abs(truth - begin)[3:].max()
    # One step of second order over a ramp, and one of first under its end: half of what moves.
    assert errors[1.0] < 0.05 * moved
    assert errors[0.0] > 0.3 * moved


@pytest.mark.parametrize("bend", [0.0, 0.3, -0.4])
def test_of_a_change_that_goes_on_only_what_is_new_is_uncertain(bend):
    """Against scipy under a wrench that bends, and is the samples' at the samples."""
    change, h = CHANGES[2], 1e-3
    stated = {}
    for goes_on in (True, False):
        kalman = sliding(noise=WRENCH_NOISE / 9)
        begin, now = kalman.x.copy(), kalman.u.copy()
        if goes_on:
            kalman.hold(now - change)
            kalman.hold(now)
        kalman.hold(now + (1 + bend) * change)
        assert kalman.predict(h, True) is Prediction.CONTACT
        stated[goes_on] = part(kalman._memory, "JUMPED")[3:].copy()
        end = kalman.x.copy()
    # All of it is new, or only what it bends.
    np.testing.assert_allclose(stated[True] * (1 + bend), abs(bend) * stated[False], 1e-9, 1e-12)

    scales, work = np.full(3, PLAIN.slip_velocity_scale), workspace()

    def rates(t, x):
        y, s = np.zeros(6), t / h
        accelerate(P, scales, x, now + change * s * (1 + bend * (1 + s) / 2), work, y)
        return np.concatenate([x[3:], y[:3]])

    truth = solve_ivp(rates, (0, h), begin, method="Radau", rtol=1e-11, atol=1e-13).y[:, -1]
    off = np.linalg.norm((end - truth)[3:])
    # What a step of second order is off by itself, by a wrench that does not bend: 2 %.
    assert off < 0.02 * np.linalg.norm((truth - begin)[3:]) + np.linalg.norm(stated[True])


def test_an_interval_in_two_predictions_goes_up_one_ramp():
    ends = []
    for parts in (1, 2):
        kalman = sliding()
        before, begin = kalman.u.copy(), kalman.x.copy()
        # An interval before, so that its length is known.
        kalman._held = 1e-3
        kalman.hold(before + CHANGES[2])
        for _ in range(parts):
            kalman.predict(1e-3 / parts, True)
        ends.append(kalman.x.copy())
    moved = np.abs(ends[0] - begin)[3:].max()
    assert np.abs(ends[1] - ends[0])[3:].max() < 0.05 * moved


@pytest.mark.parametrize("method", ["extended", "square_root"])
@pytest.mark.parametrize("dt", [0.001, 0.01, 0.1])
def test_a_peg_whose_rates_walk_as_stated_is_followed_at_any_interval(method, dt):
    """By a walk that moves angle and rate by one number a rate is known at once: NEES 8700."""
    options, generator = FilterOptions(), np.random.default_rng(3)
    kalman = FILTERS[method](SCENE, options, WRENCH_NOISE)
    R, nees = 1e-8 * np.eye(3), []
    q, rates = np.array([0.3, 0.1, -0.2]), np.array([0.1, -0.2, 0.3])
    kalman.start(q + 1e-4 * generator.standard_normal(3), R)
    for _ in range(300):
        # Of an exact walk over dt: the change of the rate, and of the angle given it.
        change, beside = options.free_rate_noise * generator.standard_normal((2, 3)) * dt**0.5
        q = q + dt * rates + dt * (change / 2 + beside / 12**0.5)
        rates = rates + change
        assert kalman.predict(dt, False) is Prediction.FREE
        # No widening: what is told here is the prediction.
        kalman.correct(q + 1e-4 * generator.standard_normal(3), R)
        error = kalman.x[:6] - np.concatenate([q, rates])
        error[1:3] -= 2 * np.pi * np.round(error[1:3] / (2 * np.pi))
        nees.append(error @ np.linalg.solve(kalman.P, error))
    # Of 300 values, correlated over a few of them, the mean of 6 scatters by some 0.4.
    assert np.mean(nees[20:]) == pytest.approx(6.0, abs=1.5)
