"""The three steps: orders, slopes, the stiff limit, where the cheap one fails, long intervals."""

from dataclasses import replace

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.contact import ContactFilter, Correction, Prediction
from peg_on_hole_ros.estimation.kernel.bridging import TILT_WALK
from peg_on_hole_ros.estimation.kernel.friction_doubt import LEARNT_WRONG
from peg_on_hole_ros.estimation.kernel.memory import part
from peg_on_hole_ros.estimation.steps.choice import INTEGRATORS, LONG_STEP, step_error, take_step
from peg_on_hole_ros.estimation.steps.implicit_euler import CONVERGED
from peg_on_hole_ros.estimation.steps.second_order import SHARE
from scipy.integrate import solve_ivp

from peg_on_hole_ros.mechanics.kernel import WIDTH, accelerate, scene_scalars, workspace
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.options import FilterOptions
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.simulation.measure import START_NS, measure
from simulated import SAMPLES, truth
from sliding_filter import PLAIN, WRENCH_NOISE, balanced, sliding

P = scene_scalars(Scene())
SLIDING = np.array([0.15, 0.3, -0.4, -0.16, 0.4, 2.0])
METHODS = tuple(INTEGRATORS)


def one_step(method, x, u, h, scales):
    """Return status, end and the derivatives (6, 12) of the state, angles first."""
    x1, y, dy, slopes = np.zeros(6), np.zeros(6), np.zeros((6, WIDTH)), np.zeros((6, WIDTH))
    status, _ = take_step(
        INTEGRATORS[method], P, scales, x, u, u, h, x1, y, dy, slopes, np.zeros(96), workspace()
    )
    by_angles = slopes[3:] if method == "second_order" else np.eye(3, WIDTH) + h * slopes[:3]
    return status, x1, np.vstack([by_angles, slopes[:3]])


def steps(method, x, u, duration, count, scales):
    for _ in range(count):
        status, x, _ = one_step(method, x, u, duration / count, scales)
        assert status == CONVERGED
    return x


def motion(x, u, duration, scales):
    """The same equations by scipy, far more closely than any step here; u may go with time."""
    work, y = workspace(), np.zeros(6)

    def rates(t, state):
        accelerate(P, scales, state, u(t) if callable(u) else u, work, y)
        return np.concatenate([state[3:], y[:3]])

    return solve_ivp(rates, (0, duration), x, method="Radau", rtol=1e-11, atol=1e-13).y[:, -1]


@pytest.mark.parametrize(
    "method, order",
    [("implicit_euler", 1), ("linearly_implicit", 1), ("second_order", 2)],
)
def test_order_of_convergence(method, order):
    scales, u = np.full(3, 2e-5), 1.2 * balanced(SLIDING)
    expected = motion(SLIDING, u, 0.02, scales)
    counts = (4, 8, 16, 32)
    ends = [steps(method, SLIDING, u, 0.02, count, scales) for count in counts]
    errors = np.array([np.abs(end - expected).max() for end in ends])
    # The next order's share of the error is that of the step in the motion's time scale: 10 %.
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:])[1:], order, atol=0.15)
    if order == 2:
        first = steps("implicit_euler", SLIDING, u, 0.02, 32, scales)
        assert errors[-1] < 0.05 * np.abs(first - expected).max()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", range(3))
def test_slopes_are_those_of_differences(method, seed):
    rng = np.random.default_rng(seed)
    x = np.array([rng.uniform(0.08, 0.3), *rng.uniform(-3, 3, 2), *rng.normal(size=3)])
    u, scales, h = 1.1 * balanced(x), np.array([1e-3, 3e-3, 2e-3]), 2e-3
    _, _, slopes = one_step(method, x, u, h, scales)
    found = np.empty((6, 12))
    for j in range(12):
        small, ends = 1e-5, []
        for sign in (1, -1):
            moved = np.concatenate([x, u])
            moved[j] += sign * small
            status, x1, _ = one_step(method, moved[:6], moved[6:], h, scales)
            assert status == CONVERGED
            ends.append(x1)
        found[:, j] = (ends[0] - ends[1]) / (2 * small)
    # Newton's residual of 1e-11 over the difference of 1e-5, and as much again for curvature.
    for rows in (slice(0, 3), slice(3, 6)):
        size = np.maximum(1.0, np.abs(found[rows]).max())
        np.testing.assert_allclose(slopes[rows, :12], found[rows], rtol=0, atol=5e-6 * size)


@pytest.mark.parametrize("method", METHODS)
def test_stiff_friction_is_damped_in_one_step(method):
    """L-stability: the stiffer the friction, the less of a rate's error is left."""
    x = np.array([0.15, 0.0, 0.0, 0.0, 0.0, 0.0])
    u = balanced(x + [0, 0, 0, -1e-3, 1e-3, 3e-3])
    left = []
    for scale in (1e-3, 1e-4, 1e-5):
        scales = np.full(3, scale)
        # Where the regularised motion creeps: its rates are in equilibrium.
        start = steps("implicit_euler", x, u, 1e-2, 4, scales)
        status, _, slopes = one_step(method, start, u, 1e-2, scales)
        assert status == CONVERGED
        left.append(np.abs(np.linalg.eigvals(slopes[3:, 3:6])).max())
    assert left[-1] < 0.05, left
    assert left[-1] < 0.3 * left[0], left


def test_the_linearly_implicit_step_overshoots_where_the_default_comes_to_rest():
    scales = np.full(3, 2e-5)
    slow = np.array([0.15, 0.3, -0.4, 0.0, 0.02, 0.02])
    # What holds the peg at rest, and the same peg still turning: friction stops it.
    u = balanced(np.array([0.15, 0.3, -0.4, -1e-7, 0, 0]))
    expected = steps("implicit_euler", slow, u, 0.01, 4096, scales)
    ends = {method: one_step(method, slow, u, 0.01, scales) for method in METHODS}
    off = {name: np.abs(end[1][3:] - expected[3:]).max() for name, end in ends.items()}
    begin = np.abs(slow[3:]).max()
    assert np.abs(expected[3:]).max() < 1e-2 * begin
    assert off["implicit_euler"] < 0.5 * begin and off["second_order"] < 0.5 * begin, off
    assert off["linearly_implicit"] > 100 * begin, off


def test_an_estimated_error_is_near_the_true_one():
    scales, u, h = np.full(3, 2e-5), 1.2 * balanced(SLIDING), 0.01
    expected = motion(SLIDING, u, h, scales)
    x1, y, dy, slopes = np.zeros(6), np.zeros(6), np.zeros((6, WIDTH)), np.zeros((6, WIDTH))
    stage, work = np.zeros(96), workspace()
    for method in ("implicit_euler", "linearly_implicit"):
        number = INTEGRATORS[method]
        take_step(number, P, scales, SLIDING, u, u, h, x1, y, dy, slopes, stage, work)
        error, _ = step_error(number, P, scales, SLIDING, u, u, h, x1, y, slopes, stage, work)
        true = np.abs(x1 - expected)[3:].max()
        assert 0.5 < error / true < 2.0


RISE = np.array([0.0, 0.0, 0.0, 0.02, 0.02, 0.02])


def test_on_a_ramp_an_estimated_error_is_that_of_the_ramp():
    """The begin of the step is under the wrench that is there, not under that at its end."""
    scales, u, h = np.full(3, 2e-5), balanced(SLIDING), 0.005
    x1, y, dy, slopes = np.zeros(6), np.zeros(6), np.zeros((6, WIDTH)), np.zeros((6, WIDTH))
    stage, work = np.zeros(96), workspace()
    begin, number = u - RISE, INTEGRATORS["second_order"]
    on_the_way = begin + SHARE * RISE
    take_step(number, P, scales, SLIDING, on_the_way, u, h, x1, y, dy, slopes, stage, work)
    found, _ = step_error(number, P, scales, SLIDING, begin, u, h, x1, y, slopes, stage, work)
    expected = motion(SLIDING, lambda t: begin + t / h * RISE, h, scales)
    true = np.abs(x1 - expected)[3:].max()
    # Under the wrench at its end 20 times.
    assert 0.3 < found / true < 3.0


def test_a_long_step_on_a_ramp_is_not_divided_for_the_rise_of_its_wrench():
    kalman = sliding(replace(FilterOptions(), slow_slip=0.0))
    kalman.hold(kalman.u - RISE)
    kalman.hold(kalman.u + RISE)
    assert part(kalman.memory, "RAMP")[:6].any()
    assert kalman.predict(0.005, True) is Prediction.CONTACT
    assert (kalman.pieces, kalman.inaccurate) == (1, 0)


@pytest.mark.parametrize("method", METHODS)
def test_long_steps_are_divided_until_they_are_good(method):
    tolerances = (1e3, 1e-3)
    pieces, errors = [], []
    for tolerance in tolerances:
        steps = {"max_step": 0.05, "max_evaluations": 10_000}
        options = replace(PLAIN, integrator=method, step_tolerance=tolerance, **steps)
        kalman = sliding(options)
        kalman.u *= 1.2
        expected = motion(kalman.x.copy(), kalman.u, 0.05, np.full(3, 2e-5))
        assert kalman.predict(0.05, True) is Prediction.CONTACT
        assert kalman.pieces == 2 ** (kalman.refused + kalman.inaccurate)
        pieces.append(kalman.pieces)
        errors.append(np.abs(kalman.x - expected)[3:].max())
    assert pieces[0] < pieces[1]
    assert errors[1] < 0.5 * errors[0]
    # Every piece may err by the tolerance.
    assert errors[1] < pieces[1] * tolerances[1] or 0.05 / pieces[1] <= LONG_STEP


def test_steps_at_the_rates_of_force_sensors_have_no_error_estimate():
    ends = []
    for tolerance in (1e-6, 1e3):
        kalman = sliding(replace(FilterOptions(), step_tolerance=tolerance))
        for dt in (1e-4, 1e-3, 2e-3):
            kalman.predict(dt, True)
            assert kalman.pieces == 1 and kalman.inaccurate == 0
        ends.append(np.concatenate([kalman.x, kalman.Z.ravel()]))
    np.testing.assert_array_equal(*ends)


def test_covariance_of_the_second_order_step_is_carried_by_its_slopes():
    kalman = sliding(replace(PLAIN, integrator="second_order"))
    before, x, u, h = kalman.Z.copy(), kalman.x.copy(), kalman.u.copy(), 2e-3
    _, _, slopes = one_step("second_order", x, u, h, np.full(3, PLAIN.slip_velocity_scale))
    F = np.vstack([slopes[:, :12], np.eye(12)[6:]])
    walk = np.kron([[h**3 / 3, h**2 / 2], [h**2 / 2, h]], np.eye(3))
    expected = F @ before @ F.T
    expected[:6, :6] += PLAIN.contact_rate_noise**2 * walk
    kalman.predict(h, True)
    stddev = np.sqrt(np.diagonal(expected))
    # Sums of a dozen products, whose rounding the correlation may enlarge.
    np.testing.assert_allclose(
        kalman.Z / np.outer(stddev, stddev), expected / np.outer(stddev, stddev), atol=1e-12
    )
    np.testing.assert_array_equal(kalman.Z, kalman.Z.T)


def at_interval(samples, dt_ns):
    """Yield samples thinned to an interval, or with wrenches between those that were measured."""
    last, before = {}, None
    for sample in sorted(samples, key=lambda s: (s.t_ns, isinstance(s, WrenchSample))):
        kind = type(sample)
        if dt_ns >= 1_000_000:
            if kind in last and sample.t_ns - last[kind] < dt_ns:
                continue
            last[kind] = sample.t_ns
        elif kind is WrenchSample:
            if before is not None:
                for t_ns in range(before.t_ns + dt_ns, sample.t_ns, dt_ns):
                    yield before._replace(t_ns=t_ns)
            before = sample
        yield sample


def run_at(name, method, dt, seconds, slow_slip=None, **scene):
    """Return counts, and error and standard deviation of the angles in three-point contact."""
    result = truth(name)
    configuration = result.plan.configuration
    options = replace(configuration.filter, integrator=method)
    if slow_slip is not None:
        options = replace(options, slow_slip=slow_slip)
    scene = replace(configuration.scene, **scene)
    pipeline = Pipeline(replace(configuration, scene=scene, filter=options))
    samples = [s for s in measure(result, 31) if s.t_ns - START_NS < seconds * 1e9]
    errors, stddevs = [], []
    for outputs in pipeline.play(at_interval(samples, round(dt * 1e9))):
        assert np.isfinite(outputs.state).all() and np.isfinite(outputs.state_covariance).all()
        assert np.isfinite(outputs.normal).all() and np.isfinite(outputs.normal_stddev).all()
        row = np.searchsorted(result.t_ns, outputs.t_ns - START_NS)
        if row < len(result.t_ns) and result.t_ns[row] == outputs.t_ns - START_NS:
            error = outputs.state[:3] - result.q[row]
            error[1:] -= 2 * np.pi * np.round(error[1:] / (2 * np.pi))
            errors.append(error)
            variance = np.diagonal(outputs.state_covariance)[:3]
            stddevs.append(np.sqrt(np.maximum(variance, 0.0)))
    return pipeline, np.array(errors), np.array(stddevs)


@pytest.mark.parametrize("method", ["implicit_euler", "second_order"])
@pytest.mark.parametrize("dt", [1e-4, 2e-3, 5e-3, 2e-2, 5e-2])
@pytest.mark.parametrize("name", SAMPLES)
def test_no_interval_from_a_tenth_to_fifty_milliseconds_diverges(name, dt, method):
    pipeline, error, stddev = run_at(name, method, dt, 0.5 if dt < 1e-3 else 4.0)
    assert pipeline.counts["filter_restarted"] == 0
    # A wrench held for 50 ms is no longer the motion's: what it leads to may be off by what a
    # rate of 1 rad/s makes of an interval, and is back with the next orientation.
    assert np.abs(error[:, 0]).max() < 3e-3 + dt
    assert (np.abs(error) < 4 * stddev + 1e-6).mean() > 0.9
    assert np.abs(error[-1, 0]) < 5 * stddev[-1, 0] + 1e-4


@pytest.mark.parametrize("dt, given_back", [(2e-3, True), (5e-3, False)])
def test_a_step_that_is_not_found_says_little_of_friction_over_a_long_interval(dt, given_back):
    kalman = ContactFilter(Scene(), FilterOptions(), WRENCH_NOISE)
    # Below gamma0 there is no three-point contact, and no step.
    kalman.start(np.array([0.5 * kalman.gamma0, 0.3, -0.4]), 1e-8 * np.eye(3))
    kalman.spread[0, 0] = before = 1e-6
    for share in (0.4, 0.6):
        # An orientation between two wrenches does not make the interval a short one.
        kalman.hold(np.zeros(6))
        kalman.predict(share * dt, False)
        kalman.predict((1 - share) * dt, False)
    enough = round(LEARNT_WRONG / dt)
    for k in range(enough + 1):
        kalman.hold(np.zeros(6))
        assert kalman.predict(0.4 * dt, True) is Prediction.FAILED
        assert kalman.predict(0.6 * dt, True) is Prediction.FAILED
        assert k >= enough - 1 or kalman.spread[0, 0] == before
    assert (kalman.spread[0, 0] > before) == given_back


def test_a_covariance_that_has_lost_its_meaning_restarts_the_filter():
    kalman = sliding()
    for bridged in (False, True):
        kalman.Z[0, 0] = -1.0
        part(kalman.memory, "BRIDGED")[0] = bridged
        result, _ = kalman.correct(np.array([0.15, 0.3, -0.4]), 1e-8 * np.eye(3))
        assert result is Correction.RESET
        assert np.isfinite(kalman.Z).all() and (np.linalg.eigvalsh(kalman.P) > 0).all()
        # Nor does anything of it last.
        assert np.isfinite(part(kalman.memory, "RATE_NOISE")).all()


def test_what_the_steps_did_is_counted():
    configuration = truth("closing_with_slip").plan.configuration
    # A prediction that then is given up for its slow slip counts as that alone.
    options = replace(configuration.filter, slow_slip=0.0)
    pipeline = Pipeline(replace(configuration, filter=options))
    samples = at_interval(measure(truth("closing_with_slip"), 31), 20_000_000)
    health = [pipeline.health for _ in pipeline.play(samples)]
    divided = [item for item in health if item["steps_refused"]]
    assert len(divided) > 5
    assert all(item["evaluations"] >= item["sub_steps"] >= 2 for item in divided)
    names = ("divided_inaccurate", "divided_no_solution", "without_solution", "limited")
    # Each refusal is of one prediction; there is one for each wrench here.
    assert sum(pipeline.counts[f"step_{name}"] for name in names) == len(divided)


class Counted(ContactFilter):
    """The filter, with what became of each prediction and what it took."""

    predictions: list

    def predict(self, dt, in_contact):
        result = super().predict(dt, in_contact)
        started = max(1, int(np.ceil(dt / self.options.max_step - 1e-9)))
        self.predictions.append((result, self.evaluations, started))
        return result


@pytest.mark.parametrize("method", ["implicit_euler", "second_order"])
@pytest.mark.parametrize("dt", [1e-3, 5e-3, 2e-2, 5e-2])
def test_no_prediction_takes_more_evaluations_than_are_allowed(method, dt):
    # It wedges in the end; long before, the noise of a long interval's wrench leaves no step.
    result = truth("closing_without_slip")
    configuration = result.plan.configuration
    # At 1 ms hardly a step is asked for, unless a slip is followed however slow it is.
    slow = 0.0 if dt == 1e-3 else configuration.filter.slow_slip
    options = replace(configuration.filter, integrator=method, slow_slip=slow)
    Counted.predictions = []
    pipeline = Pipeline(
        replace(configuration, filter=options),
        make=lambda scene, options, noise, offsets: Counted(scene, options, noise),
    )
    for sample in at_interval(measure(result, 31), round(dt * 1e9)):
        if not isinstance(sample, WrenchSample):
            pipeline.on_joints(sample)
            continue
        outputs = pipeline.on_wrench(sample)
        assert outputs is None or np.isfinite(outputs.state_covariance).all()
    limited = [item for item in Counted.predictions if item[0] is Prediction.LIMITED]
    assert len(limited) == pipeline.counts["step_limited"]
    # At 1 ms the second-order step finds one within what is allowed.
    assert limited or (method, dt) == ("second_order", 1e-3)
    # A step may begin with one left: two stages of 24, as on ramps, its error estimate and the
    # look past the kink.
    allowed, more = options.max_evaluations, 48
    for result, evaluations, started in Counted.predictions:
        assert evaluations <= allowed * started + more + 2, (result, evaluations, started)


@pytest.mark.parametrize("allowed", [30, 100_000])
def test_a_limited_prediction_is_one_at_constant_rates(allowed):
    # Friction far above what a sliding peg can have: no step, however short.
    options = replace(FilterOptions(), max_evaluations=allowed, slow_slip=0.0)
    kalman = ContactFilter(Scene(friction=1.5, friction_stddev=0.0), options, WRENCH_NOISE)
    kalman.start(np.array([0.12, 0.3, -0.4]), 1e-8 * np.eye(3))
    kalman.x[3:], kalman.Z[range(3, 6), range(3, 6)] = (-0.16, 0.4, 2.0), 1e-4
    free = ContactFilter(Scene(friction=1.5, friction_stddev=0.0), options, WRENCH_NOISE)
    free.restore(kalman.snapshot())
    for each in (kalman, free):
        each.hold(np.array([0.0, 0.0, -60.0, 0.0, 0.3, 0.0]))
    expected = Prediction.LIMITED if allowed == 30 else Prediction.FAILED
    assert kalman.predict(1e-3, True) is expected
    assert free.predict(1e-3, False) is Prediction.FREE
    np.testing.assert_array_equal(kalman.x, free.x)
    # On its contacts the tilt changes less than that of a free peg.
    less = 1e-3 * (1.0 - TILT_WALK**2) * options.free_rate_noise**2
    free.Z[0, 0] -= less * 1e-6 / 3.0
    free.Z[0, 3] = free.Z[3, 0] = free.Z[0, 3] - less * 1e-3 / 2.0
    free.Z[3, 3] -= less
    np.testing.assert_allclose(kalman.Z, free.Z, rtol=1e-12)
    free.Z[np.ix_([0, 3], [0, 3])] = kalman.Z[np.ix_([0, 3], [0, 3])]
    np.testing.assert_allclose(kalman.Z, free.Z, rtol=1e-15, atol=0.0)
