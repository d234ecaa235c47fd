"""Slopes and peaks of a likelihood whose innovations are known, within limits and at them."""

import numpy as np
import pytest
from peg_on_hole_ros.estimation.identification.runs import Runs

from peg_on_hole_ros.estimation.identification.likelihood import (
    IS_NOISE,
    QUANTITIES,
    Innovations,
    measures,
)
from peg_on_hole_ros.estimation.identification.scoring import Likelihood, greatest, tangent

SIZE = len(QUANTITIES)
SCALE = measures(0.05, 25.0)
COUNT = 200
# Friction and the delay, which have limits.
FIRST, SECOND = 0, 9
DIRECTIONS = np.random.default_rng(3).normal(size=(2, COUNT, 3))


def innovations_of(x, top, bend=0.0):
    """Residuals that go with two coordinates, least at a top, of covariance one."""
    off = [(x[i] - top[i]) / SCALE.useful[i] for i in (FIRST, SECOND)]
    residual = sum((d + bend * d**2) * direction for d, direction in zip(off, DIRECTIONS))
    return Innovations(residual, np.broadcast_to(np.eye(3), (COUNT, 3, 3)), 0.0)


def limits(**of):
    low, high = np.full(SIZE, -np.inf), np.full(SIZE, np.inf)
    for name, (least, most) in of.items():
        i = [one.name for one in QUANTITIES].index(name)
        low[i], high[i] = least, most
    return low, high


def within(bounds, run):
    """Refuse what a configuration would refuse."""

    def checked(x):
        assert (x >= bounds[0]).all() and (x <= bounds[1]).all()
        return run(x)

    return checked


def likelihood(run, bounds, quiet=None):
    return Likelihood(run, quiet, np.zeros(SIZE), SCALE, bounds)


@pytest.mark.parametrize("at", [0.0, 3e-5, 2.0 - 3e-5, 2.0, 0.7])
def test_slopes_at_a_limit_are_taken_within_it_and_are_those_of_the_function(at):
    x, top, bend = np.zeros(SIZE), np.zeros(SIZE), 0.05
    x[FIRST], top[FIRST] = at, at - 0.02
    bounds = limits(friction=(0.0, 2.0))
    run = within(bounds, lambda x: innovations_of(x, top, bend))
    scores, information = likelihood(run, bounds).slopes(run(x), x, np.array([FIRST]))
    off = 0.02 / SCALE.useful[FIRST]
    slope = DIRECTIONS[0] * (1 + 2 * bend * off) / SCALE.useful[FIRST]
    # To one side it is off by half a step of the curvature: 1e-4 of the slope.
    assert information[0, 0] == pytest.approx((slope**2).sum(), rel=5e-4)
    expected = -(slope * run(x).residual).sum(axis=1)
    assert scores[:, 0] == pytest.approx(expected, rel=5e-4)


@pytest.mark.parametrize("finite_from", [0.0, 5e-5])
def test_a_difference_to_one_side_ends_on_the_quiet_motion_as_well(finite_from):
    x, top = np.zeros(SIZE), np.zeros(SIZE)
    x[FIRST] = finite_from
    noise = np.random.default_rng(4).normal(size=(COUNT, 3))

    def quiet(x):
        return innovations_of(x, top) if x[FIRST] >= finite_from else None

    def loud(x):
        clean = quiet(x)
        return clean._replace(residual=clean.residual + noise)

    # Noise over a step of 1e-4 would be slopes of 1e4.
    one = likelihood(loud, limits(), quiet)
    _, information = one.slopes(loud(x), x, np.array([FIRST]))
    assert information[0, 0] == pytest.approx(
        ((DIRECTIONS[0] / SCALE.useful[FIRST]) ** 2).sum(), rel=1e-6
    )


def test_where_neither_side_is_finite_nothing_is_told():
    x, top = np.zeros(SIZE), np.zeros(SIZE)
    found = innovations_of(x, top)
    one = likelihood(lambda x: None, limits())
    scores, information = one.slopes(found, x, np.array([FIRST]))
    assert not scores.any() and not information.any()


@pytest.mark.parametrize("begin", [-0.3, 0.0, 0.2])
def test_a_top_beyond_a_limit_leaves_it_there_and_the_others_at_their_best(begin):
    x, top = np.zeros(SIZE), np.zeros(SIZE)
    x[FIRST], top[FIRST], top[SECOND] = begin, -0.05, 4e-3
    bounds = limits(friction=(0.0, 2.0))
    run = within(bounds, lambda x: innovations_of(x, top))
    free = np.isin(np.arange(SIZE), (FIRST, SECOND))
    peak = greatest(likelihood(run, bounds), x, free)
    assert peak.converged
    assert peak.x[FIRST] == 0.0
    # By hand: the least squares of the second where the first is held, with the prior.
    a, b = (d.ravel() / SCALE.useful[i] for d, i in zip(DIRECTIONS, (FIRST, SECOND)))
    best = (b @ (b * top[SECOND] + a * top[FIRST])) / (b @ b + SCALE.range[SECOND] ** -2.0)
    # The search ends where less than 0.05 of the logarithm is promised.
    assert peak.x[SECOND] == pytest.approx(best, abs=0.4 / np.linalg.norm(b))


def test_a_tangent_at_a_limit_points_beyond_it_if_the_recording_does():
    x, top = np.zeros(SIZE), np.zeros(SIZE)
    top[FIRST] = -0.05
    bounds = limits(friction=(0.0, 2.0))
    run = within(bounds, lambda x: innovations_of(x, top))
    found = tangent(likelihood(run, bounds), x, np.array([FIRST]))
    assert found.step[0] == pytest.approx(-0.05, rel=0.01)


def test_a_search_that_goes_to_and_fro_over_the_top_comes_to_it():
    """Two halves of a recording disagree, and where one is believed the other one is right."""

    def run(x):
        off = x[SECOND] / SCALE.useful[SECOND]
        side = np.where(np.arange(COUNT) % 2, 1.0, -1.0)
        residual = (off - side)[:, None] * DIRECTIONS[1]
        # The best under given covariances is at -tanh(1.5 off): beyond the top, and farther.
        root = np.exp(0.75 * side * off)[:, None, None] * np.eye(3)
        return Innovations(residual, root, 0.0)

    x, free = np.zeros(SIZE), np.arange(SIZE) == SECOND
    x[SECOND] = 0.9 * SCALE.useful[SECOND]
    peak = greatest(likelihood(run, limits(), run), x, free)
    assert peak.converged
    assert abs(peak.x[SECOND]) < 0.1 * SCALE.useful[SECOND]


def test_two_likelihoods_that_take_turns_without_an_end_are_left(monkeypatch):
    calls = []

    def turn(one, x, free):
        calls.append(free)
        assert len(calls) < 100, "it goes on for ever"
        x = x.copy()
        if free[IS_NOISE].any():
            x[IS_NOISE] = (-1.0) ** len(calls[::2])
        return x

    runs = object.__new__(Runs)
    runs._motion = runs._noise = likelihood(None, limits())
    monkeypatch.setattr(Runs, "_greatest", staticmethod(turn))
    assert runs.peak(np.zeros(SIZE), np.ones(SIZE, bool)) is None


@pytest.mark.parametrize("motion", [0.0, 1.0, 3.0])
def test_what_noise_makes_of_the_slope_of_a_delay_tells_nothing(motion):
    """The step from 0 is to the truth, not short of it, and known as well as it varies."""
    rng = np.random.default_rng(7)
    signal = motion * DIRECTIONS[1]
    top, steps, stated = 2e-3, [], []

    def slope_of(direction):
        return lambda x: Innovations(
            x[SECOND] / SCALE.useful[SECOND] * direction,
            np.broadcast_to(np.eye(3), (COUNT, 3, 3)),
            0.0,
        )

    for _ in range(40):
        own, again, loud = rng.normal(size=(3, COUNT, 3))
        run = slope_of(signal)
        one = likelihood(run, limits(), slope_of(signal + own))
        one = one._replace(anew=slope_of(signal + own + again))
        found = run(np.zeros(SIZE) - top * np.eye(SIZE)[SECOND])
        found = found._replace(residual=found.residual + loud)
        chosen = np.array([FIRST, SECOND])
        scores, information = one.slopes(found, np.zeros(SIZE), chosen, told=True)
        if not motion:
            # 600 numbers tell the size of noise to 6 %, and the share goes in by its square.
            assert information[1, 1] < 0.05 * (own**2).sum() / SCALE.useful[SECOND] ** 2
            continue
        steps.append(scores[:, 1].sum() / information[1, 1])
        stated.append(information[1, 1] ** -0.5)
    if motion:
        # With noise counted as motion it was short by a half where the two are as large.
        assert np.mean(steps) == pytest.approx(top, abs=4 * np.std(steps) / np.sqrt(40) + 1e-5)
        assert np.std(steps) == pytest.approx(np.mean(stated), rel=0.5)
