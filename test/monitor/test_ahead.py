"""What is foreseen of a stall and of a load, on courses whose end is known."""

from math import sqrt

import numpy as np
import pytest

from judging import risk_of
from peg_on_hole_ros.config.options import MonitorOptions
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitor.assessment import follow_orientation
from peg_on_hole_ros.monitor.dangers.load import follow_load, over_limit
from peg_on_hole_ros.monitor.dangers.registry import assess_dangers
from peg_on_hole_ros.monitor.dangers.stall import Stall, follow_push, follow_tilt, stops_ahead
from peg_on_hole_ros.monitor.memory import Memory
from peg_on_hole_ros.monitor.motion_now import Passed
from peg_on_hole_ros.monitor.settings import monitor_settings
from peg_on_hole_ros.monitor.trend import Trend
from peg_on_hole_ros.monitor.tuned import LOAD_AHEAD
from peg_on_hole_ros.typed_record import new
from under_way import move, placed, press

HELD, PUSH_NOISE, TILT_NOISE = 1.0, 0.007, 1e-4
RATE, GIVES_WAY, BEGIN = 0.1, 0.006, 0.3
REST = 0.01


def stopping(growth, duration=0.8, seed=5):
    """
    Return times and the probability that the tilt stands still within 0.2 s.

    The holder closes at RATE and gives way by GIVES_WAY a newton metre; the push grows as told
    from BEGIN on.
    """
    draw = np.random.default_rng(seed)
    stall, t = new(Stall), np.arange(int(duration * 1000)) * 1e-3
    found = np.zeros(len(t))
    for k, now in enumerate(t):
        push = 0.5 + growth(max(now - BEGIN, 0.0))
        measured = push + PUSH_NOISE * draw.standard_normal()
        follow_push(stall, measured, PUSH_NOISE**2, HELD, 1e-3)
        if k % 2 == 0:
            tilt = 0.2 - RATE * now + GIVES_WAY * push + TILT_NOISE * draw.standard_normal()
            since = -1.0 if k == 0 else 2e-3
            follow_tilt(stall, tilt, TILT_NOISE**2, HELD, since, 0.0)
        found[k] = stops_ahead(stall, 0.2, REST)
    return t, found


@pytest.mark.parametrize("seed", range(3))
def test_a_push_that_grows_ever_faster_stops_the_peg_and_that_is_seen_ahead(seed):
    # RATE = GIVES_WAY a t: at rest 0.28 s after the begin, and nearly so (REST) at 0.25 s.
    a = 60.0
    stop = BEGIN + RATE / (GIVES_WAY * a)
    t, found = stopping(lambda s: 0.5 * a * s * s, seed=seed)
    assert found[(t > 0.1) & (t < BEGIN)].max() < 0.05
    ahead = found[(t > stop - 0.05) & (t < stop)]
    assert ahead.min() > 0.6 and ahead.mean() > 0.9
    # It cannot be told when the push has hardly begun to grow.
    assert found[t < BEGIN + 0.05].max() < 0.5


@pytest.mark.parametrize("seed", range(3))
def test_a_push_whose_growth_ends_in_time_does_not(seed):
    # Half of RATE is left.
    a, end = 60.0, 0.14
    t, found = stopping(
        lambda s: 0.5 * a * min(s, end) ** 2 + a * end * max(s - end, 0), seed=seed
    )
    later = found[t > BEGIN + end + 0.1]
    assert later.max() < 0.5 and np.median(later) < 0.05


def loaded(course, stddev, duration=0.5, limit=500.0, horizon=0.1, noise=1.0):
    """Return times and how far the probability goes that a reaction is over its limit."""
    draw = np.random.default_rng(4)
    trend, t = new(Trend), np.arange(int(duration * 1000)) * 1e-3
    found = np.zeros(len(t))
    for k, now in enumerate(t):
        normal = course(now) + noise * draw.standard_normal()
        follow_load(trend, normal, stddev**2, limit, 1e-3)
        found[k] = over_limit(trend, stddev**2, limit, horizon)
    return t, found


def test_a_load_that_rises_is_seen_to_pass_its_limit_ahead():
    # 500 N are passed at 0.4 s.
    t, z = loaded(lambda now: 100.0 + 1000.0 * now, 1.0)
    assert z[(t > 0.05) & (t < 0.25)].max() < -1.3
    # That the rise goes on is likely, not sure, until the limit is passed.
    assert 1.0 < np.median(z[(t > 0.34) & (t < 0.4)]) < 4.0
    assert z[t > 0.41].min() > 3.0
    # One that stays below, however fast it came there, does not.
    t, z = loaded(lambda now: 100.0 + 1000.0 * min(now, 0.25), 1.0)
    assert z[t > 0.3].max() < -1.3


def test_what_is_not_determined_says_nothing():
    # Reactions jump about by hundreds of newtons, and are said to be known to thousands.
    assert loaded(lambda now: 300.0, 3000.0, noise=300.0)[1].max() == LOAD_AHEAD.nothing
    # Nor does it undo what was known.
    trend = new(Trend)
    for k in range(100):
        normal, stddev = (200.0, 1.0) if k < 50 else (900.0, 3000.0)
        follow_load(trend, normal, stddev**2, 500.0, 1e-3)
    assert LOAD_AHEAD.nothing < over_limit(trend, 3000.0**2, 500.0, 0.0) < -1.3


def test_a_reaction_that_is_not_determined_for_long_foretells_nothing():
    """At rest: 150 N of 500, known to 1 N, then only to 300 N."""
    trend, after = new(Trend), []
    for k in range(700):
        stddev = 1.0 if k < 100 or k >= 600 else 300.0
        follow_load(trend, 150.0, stddev**2, 500.0, 1e-3)
        after.append(over_limit(trend, stddev**2, 500.0, 0.2))
    # Two standard deviations below the limit until it is forgotten, after a fifth of a second.
    assert min(after[100:250]) > LOAD_AHEAD.nothing and max(after[150:]) < -1.9
    assert after[599] == LOAD_AHEAD.nothing
    assert LOAD_AHEAD.nothing < after[-1] < -3.0


@pytest.mark.parametrize(("stddev", "counts"), [(20.0, 20.0), (100.0, 46.0)])
def test_a_mean_over_time_does_not_make_a_reaction_known_better_than_it_is(stddev, counts):
    """460 N of 500: all its samples may be off by the same, but by no more than a tenth of it."""
    _, z = loaded(lambda now: 460.0, stddev, horizon=0.0, noise=0.1)
    # The mean of the samples is known to less than a third of each.
    spread = -40.0 / z[300:]
    assert (spread > 0.99 * counts).all()
    assert (spread < sqrt(counts**2 + (stddev / 3.0) ** 2)).all()


def foreseen(time, wrench, tilt, slip, limit):
    """
    Return the risks of a peg on three contacts, once a millisecond for 0.3 s.

    Parameters
    ----------
    time : float
        Until gamma0, all along [s]; below zero: not known.
    wrench, tilt : callable
        Of the time [s]: on the peg [N], [N m], and its angle [rad].
    slip : float
        Rate about its axis [rad/s].
    limit : float
        Of each reaction [N].

    """
    scene, options = Scene(friction_stddev=0.0), MonitorOptions(max_normal=(limit,) * 3)
    memory, draw, found = new(Memory), np.random.default_rng(2), []
    settings, shown = monitor_settings(options, scene, 0.0), memory.evidence.shown
    shown.time, shown.usable, shown.on_hole = time, True, 1.0
    noise = np.diag([1e-4] * 3 + [1e-7] * 3)
    kalman = placed([tilt(0.0), 0.0, 0.0], scene=scene, noise=noise, variance=1e-10)
    for k in range(300):
        now = k * 1e-3
        q = np.array([tilt(now), 0.0, slip * now])
        move(kalman, [(tilt(now + 1e-4) - tilt(now - 1e-4)) / 2e-4, 0.0, slip], 1e-6, q)
        if k % 2 == 0:
            q[0] += TILT_NOISE * draw.standard_normal()
            since, R = -1.0 if k == 0 else 2e-3, TILT_NOISE**2 * np.eye(3)
            follow_orientation(memory, since, q, R, settings)
        record = press(kalman, wrench(now), ContactSet.THREE)
        passed = Passed(1e-3, k % 2 * 1e-3)
        dangers = memory.dangers
        assess_dangers(record, dangers, memory.motion, memory.depth, shown, settings, passed)
        found.append(risk_of(dangers))
    return found


UNTIL_GAMMA0 = pytest.mark.parametrize(
    ("time", "seen"), [(-1.0, True), (0.5, True), (0.02, False)]
)


@UNTIL_GAMMA0
def test_a_load_is_foreseen_as_far_as_three_contacts_last(time, seen):
    """B1 passes 36 N at 0.28 s."""

    def wrench(t):
        return 0, 0, -20 - 100 * t, 0, 0, 0

    found = foreseen(time, wrench, lambda t: 0.12 - 0.05 * t, 2.0, 36.0)
    load = np.array([risk.load for risk in found])
    assert load[:100].max() < 0.1 and load[290:].min() > 0.9
    assert load[235:245].min() > 0.8 if seen else load[:245].max() < 0.1


@UNTIL_GAMMA0
def test_a_stall_is_foreseen_as_far_as_three_contacts_last(time, seen):
    """A push that grows ever faster stops the peg at 0.38 s."""

    def push(t):
        return 0.5 + 30.0 * max(t - 0.1, 0.0) ** 2

    def tilt(t):
        return 0.15 - RATE * t + GIVES_WAY * push(t)

    found = foreseen(time, lambda t: (0, 0, -20, 0, push(t), 0), tilt, 0.3, 5000.0)
    stall = np.array([risk.stall for risk in found])
    assert stall[280:290].min() > 0.9 if seen else stall[:290].max() < 0.1
