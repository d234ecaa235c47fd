"""The smooth trend against motions drawn from its own model, and by other numerics."""

from math import exp, sqrt

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from peg_on_hole_ros.config.options import MonitorOptions
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitor.motion_trend import (
    MotionTrend,
    follow_motion,
    rest_probability,
    time_to_reach,
)
from peg_on_hole_ros.monitor.settings import monitor_settings
from peg_on_hole_ros.monitor.trend import Trend, rate_after, value_after
from peg_on_hole_ros.monitor.tuned import RATE_TREND
from peg_on_hole_ros.typed_record import new

NOISE, ACCELERATION, MEMORY = 1e-4, 0.3, 0.2
RATIO = 0.998


def settings(acceleration=ACCELERATION):
    """Return settings of a motion whose acceleration has a spread and lasts for MEMORY."""
    options = MonitorOptions(
        forecast_acceleration_stddev=acceleration, forecast_acceleration_time=MEMORY
    )
    return monitor_settings(options, Scene(hole_diameter=0.05, peg_diameter=RATIO * 0.05), 0.3)


def trend_of(value, rate, drive):
    trend = new(Trend)
    trend.value, trend.rate, trend.drive = value, rate, drive
    return trend


def track(rng, seconds, dt=2e-3, rate=-0.1):
    """Draw tilts with an Ornstein-Uhlenbeck acceleration, by steps a twentieth of dt long."""
    fine = dt / 20
    x, v, a = 0.2, rate, rng.normal(0, ACCELERATION)
    kept = exp(-fine / MEMORY)
    kicks = rng.normal(0, ACCELERATION * sqrt(1 - kept**2), round(seconds / fine))
    xs, vs = [], []
    for i, kick in enumerate(kicks):
        if i % 20 == 0:
            xs.append(x)
            vs.append(v)
        x, v, a = x + fine * v + fine**2 / 2 * a, v + fine * a, kept * a + kick
    return np.array(xs), np.array(vs)


def learn(tilts, rng, dt=2e-3, spread=ACCELERATION):
    m = new(MotionTrend)
    for k, tilt in enumerate(tilts):
        q = np.array([tilt + rng.normal(0, NOISE), 0.0, 0.0])
        R = np.eye(3) * NOISE**2
        follow_motion(m, -1.0 if k == 0 else dt, q, R, settings(spread))
    return m


def test_rate_and_forecast_keep_to_their_bounds():
    rng = np.random.default_rng(8)
    rates, ahead = [], []
    for _ in range(150):
        xs, vs = track(rng, 0.4)
        m = learn(xs[:150], rng)
        # What the acceleration has lately been widens the forecast; here it is known beforehand.
        rates.append((m.tilt.rate - vs[149]) / sqrt(m.tilt.p11))
        x, variance = value_after(m.tilt, 0.1, ACCELERATION, MEMORY)
        ahead.append((x - xs[199]) / sqrt(variance))
    for errors in (rates, ahead):
        # Chi-square of 150 tracks: 99.9 % lie within 0.65 to 1.4; the trend itself counts on a
        # little more acceleration than there is.
        assert 0.5 < np.mean(np.square(errors)) < 1.4


def driven(t):
    """Return what the noise behind rate and acceleration adds to the position's variance."""
    density = 2 * ACCELERATION**2 / MEMORY

    def weight(s):
        return MEMORY * s - MEMORY**2 * (1 - exp(-s / MEMORY))

    white = density * quad(lambda s: weight(s) ** 2, 0, t)[0]
    return white + RATE_TREND.tremble**2 * t**3 / 3


def test_forecast_without_orientation_is_the_integral_of_the_model():
    trend, t = trend_of(0.2, -0.1, 0.4), 0.13
    x, variance = value_after(trend, t, ACCELERATION, MEMORY)

    def a(s):
        return 0.4 * exp(-s / MEMORY)

    expected = 0.2 - 0.1 * t + quad(lambda s: (t - s) * a(s), 0, t)[0]
    assert x == pytest.approx(expected, rel=1e-10)
    # The white noise behind the acceleration, each piece carried on to the end.
    assert variance == pytest.approx(driven(t), rel=1e-6)
    rate, _ = rate_after(trend, t, MEMORY)
    assert rate == pytest.approx(-0.1 + quad(a, 0, t)[0], rel=1e-10)


@pytest.mark.parametrize("u", [0.0999, 0.1001])
def test_both_forms_of_the_forecast_s_variance_meet(u):
    t = u * MEMORY
    _, variance = value_after(new(Trend), t, ACCELERATION, MEMORY)
    # The first terms of the series are good to u.
    assert variance == pytest.approx(driven(t), rel=0.1)


@pytest.mark.parametrize("acceleration", [-0.3, 0.0, 0.25])
def test_time_to_reach_is_where_the_mean_motion_crosses(acceleration):
    m = new(MotionTrend)
    m.tilt = trend_of(0.2, -0.15, acceleration)
    m.tilt.p00, m.tilt.p11, m.tilt.p22 = 1e-10, 1e-6, 1e-4
    level = 0.18
    time, stddev = time_to_reach(m, level, 0.0, settings(0.05))

    def mean(t):
        return value_after(m.tilt, t, 0.05, MEMORY)[0] - level

    expected = brentq(mean, 0, 0.5)
    assert time == pytest.approx(expected, abs=1e-6)
    # Its spread to first order: that of the position over the speed there.
    speed = (mean(expected + 1e-5) - mean(expected - 1e-5)) / 2e-5
    least = sqrt(value_after(m.tilt, expected, 0.05, MEMORY)[1]) / -speed
    assert stddev == pytest.approx(least, rel=1e-4)
    wider = time_to_reach(m, level, 1e-6, settings(0.05))[1]
    assert wider == pytest.approx(sqrt(stddev**2 + 1e-6 / speed**2), rel=1e-4)


@pytest.mark.parametrize(
    ("tilt", "rate", "acceleration"),
    # Below the level, rising, not surely falling, at rest before, and after more than the longest.
    [
        (0.17, -0.1, 0.0),
        (0.2, 0.1, 0.0),
        (0.2, -0.001, 0.0),
        (0.2, -0.05, 0.5),
        (0.3, -0.003, 0.0),
    ],
)
def test_without_a_motion_that_arrives_there_is_no_time(tilt, rate, acceleration):
    m = new(MotionTrend)
    m.tilt = trend_of(tilt, rate, acceleration)
    m.tilt.p11 = 1e-6
    assert time_to_reach(m, 0.18, 0.0, settings(0.05))[0] == -1.0


def test_turn_goes_on_where_angles_wrap():
    m = new(MotionTrend)
    R = np.eye(3) * NOISE**2
    for k in range(800):
        t = 2e-3 * k
        # psi passes half a turn at 0.07 s, phi at 0.03 s, and again at 1.28 s.
        psi, phi = 3.0 + 2.0 * t, -3.0 - 5.0 * t
        wrapped = (np.array([psi, phi]) + np.pi) % (2 * np.pi) - np.pi
        since = -1.0 if k == 0 else 2e-3
        follow_motion(m, since, np.array([0.2, *wrapped]), R, settings(0.1))
        if k > 200:
            assert m.turn.rate == pytest.approx(2.0 - 5.0 * RATIO, abs=0.02)


def test_a_peg_that_sticks_is_seen_at_once():
    rng = np.random.default_rng(3)
    moving = 0.2 - 0.16 * np.arange(0, 0.3, 2e-3)
    m = learn(moving, rng, spread=0.04)
    assert rest_probability(m, 0.01) < 1e-6
    R = np.eye(3) * NOISE**2
    for _ in range(15):
        q = np.array([moving[-1] + rng.normal(0, NOISE), 0.0, 0.0])
        follow_motion(m, 2e-3, q, R, settings(0.04))
    assert abs(m.tilt.rate) < 0.02
    for _ in range(35):
        q = np.array([moving[-1] + rng.normal(0, NOISE), 0.0, 0.0])
        follow_motion(m, 2e-3, q, R, settings(0.04))
    assert rest_probability(m, 0.01) > 0.9


def test_rest_probability_is_the_share_of_draws():
    m = new(MotionTrend)
    m.quick_tilt.rate, m.quick_tilt.p11 = 0.008, 0.004**2
    m.turn.rate, m.turn.p11 = -0.015, 0.01**2
    rng = np.random.default_rng(4)
    tilt, turn = rng.normal(0.008, 0.004, 100_000), rng.normal(-0.015, 0.01, 100_000)
    share = np.mean((0.05 * np.abs(tilt) < 5e-4) & (0.025 * np.abs(turn) < 5e-4))
    # Four standard deviations of the share.
    assert rest_probability(m, 0.01) == pytest.approx(share, abs=4 * 0.5 / sqrt(1e5))
