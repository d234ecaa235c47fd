"""Mode, transition, risk and alarms, each against what it is defined to say."""

from dataclasses import replace
from math import erf, sqrt

import numpy as np
import pytest

from peg_on_hole_ros.mechanics.kernel import scene_scalars
from peg_on_hole_ros.mechanics.reference import solve_contact
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitoring.alarms import ERROR, OK, WARN, Alarms, Level
from peg_on_hole_ros.monitoring.jamming import WedgingMargin, jamming_risk
from peg_on_hole_ros.monitoring.mode import ContactMode, Evidence
from peg_on_hole_ros.monitoring.transition import (
    TransitionFlag,
    gamma0_stddev,
    time_to_transition,
    transition_probability,
)
from peg_on_hole_ros.options import MonitorOptions

OPTIONS = MonitorOptions()
PRESSED = Evidence(0.0, 20.0, 0.3, 0.05, 1e-4, (20.0, 30.0, 30.0), (1.0, 1.0, 1.0), 3.0)


def settle(mode, evidence, duration=0.2, start=0.0):
    """Show one piece of evidence for a while; return when the mode changed last."""
    changed, before = None, mode.mode
    for k in range(int(duration * 1000) + 1):
        t = start + k * 1e-3
        if mode.update(evidence._replace(t=t)) != before:
            changed, before = t, mode.mode
    return changed


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({}, "three_point"),
        ({"contact_force": 0.2}, "open"),
        ({"tilt_margin": -0.01}, "two_point"),
        ({"nis": 50.0}, "unknown"),
        ({"normal": (20.0, -30.0, 30.0)}, "unknown"),
        ({"normal": None}, "unknown"),
    ],
)
def test_mode_is_what_the_evidence_fits(change, expected):
    mode = ContactMode(OPTIONS)
    settle(mode, PRESSED._replace(**change))
    assert mode.mode == expected


def test_a_mode_must_last_for_its_dwell():
    mode = ContactMode(OPTIONS)
    settle(mode, PRESSED)
    for k in range(10):
        mode.update(PRESSED._replace(t=0.3 + k * 1e-3, tilt_margin=-0.01))
    assert mode.mode == "three_point"
    settle(mode, PRESSED, start=0.31, duration=0.08)
    changed = settle(mode, PRESSED._replace(tilt_margin=-0.01), start=0.4)
    assert mode.mode == "two_point"
    assert changed == pytest.approx(0.4 + OPTIONS.mode_dwell, abs=1.5e-3)


def test_transition_probability_is_the_share_of_draws_below_gamma0():
    rng = np.random.default_rng(2)
    gamma, spread, gamma0, gamma0_spread = 0.0640, 8e-4, 0.0633, 6e-4
    draws = rng.normal(gamma, spread, 200_000) < rng.normal(gamma0, gamma0_spread, 200_000)
    found = transition_probability(gamma, spread, gamma0, gamma0_spread)
    # Four standard deviations of the share.
    assert found == pytest.approx(draws.mean(), abs=4 * sqrt(0.25 / 200_000))


def test_clearance_spread_reaches_gamma0():
    scene, step = Scene(), 1e-8
    thinner = replace(scene, peg_diameter=scene.peg_diameter - step)
    slope = (thinner.gamma0 - scene.gamma0) / step
    expected = abs(slope) * 2e-5
    # One-sided difference over 1e-4 of the clearance.
    found = gamma0_stddev(scene.gamma0, scene.hole_diameter, 2e-5)
    assert found == pytest.approx(expected, rel=1e-3)


def test_time_to_transition_and_its_spread():
    margin, rate = 0.01, -0.16
    covariance = np.array([[1e-8, 4e-7], [4e-7, 4e-4]])
    time, spread = time_to_transition(
        margin, rate, covariance[0, 0], covariance[1, 1], covariance[0, 1]
    )
    draws = np.random.default_rng(3).multivariate_normal([margin, rate], covariance, 100_000)
    times = -draws[:, 0] / draws[:, 1]
    assert time == pytest.approx(np.median(times), rel=2e-3)
    # The ratio of two normal variables has a tail that the linear spread leaves out.
    assert spread == pytest.approx(
        (np.quantile(times, 0.84) - np.quantile(times, 0.16)) / 2, rel=0.1
    )


@pytest.mark.parametrize(("margin", "rate"), [(0.01, 0.1), (0.01, -0.01), (-0.001, -0.16)])
def test_without_a_closing_motion_there_is_no_time(margin, rate):
    assert time_to_transition(margin, rate, 1e-8, 1e-4, 0.0) is None


def test_flag_keeps_between_its_thresholds():
    flag = TransitionFlag(OPTIONS)
    assert not flag.update(0.8, touching=True)
    assert not flag.update(0.95, touching=False)
    assert flag.update(0.95, touching=True)
    assert flag.update(0.6, touching=True)
    assert not flag.update(0.4, touching=True)


def test_risk_is_one_where_the_six_equations_are_singular():
    scene = Scene()
    margin = WedgingMargin(np.array(scene_scalars(scene)))
    tight = np.diag([1e-8] * 3 + [1e-6] * 3)
    risks = {}
    for gamma in (0.0650, 0.0653, 0.15):
        x = np.array([gamma, 0, 0, -0.16, 0, 0])
        determinant = margin.determinant(x, tight)
        expected = solve_contact(scene, x[:3], x[3:], [0, 0, 0], [0, 0, 0]).determinant
        assert determinant == pytest.approx(expected, rel=1e-6, abs=1e-9)
        risks[gamma] = jamming_risk(determinant)
    assert risks[0.0650] == 1.0
    assert 0.9 < risks[0.0653] < 1.0
    slipping = margin.determinant(np.array([0.0650, 0, 0, -0.16, 0, 2.0]), tight)
    assert jamming_risk(slipping) < 0.1


def test_risk_of_a_peg_at_rest_is_that_of_closing_it():
    margin = WedgingMargin(np.array(scene_scalars(Scene())))
    P = np.diag([1e-8] * 3 + [1e-4] * 3)
    resting = margin.determinant(np.array([0.064, 0.3, 0.1, 1e-4, -2e-3, 1e-3]), P)
    closing = margin.determinant(np.array([0.064, 0.3, 0.1, -0.16, 0, 0]), P)
    assert resting == pytest.approx(closing, rel=1e-6)


def test_slip_counts_where_its_sum_is_known_and_its_parts_are_not():
    margin = WedgingMargin(np.array(scene_scalars(Scene())))
    P = np.diag([1e-8] * 3 + [1e-6, 1.0, 1.0])
    # At a small tilt psi' and phi' are known to 1 rad/s, and what they sum to to 0.01 rad/s.
    P[4, 5] = P[5, 4] = -(1.0 - 5e-5)
    rates = [-0.16, 0.3, 1.5]
    found = margin.determinant(np.array([0.064, 0, 0, *rates]), P)
    certain = margin.determinant(np.array([0.064, 0, 0, *rates]), np.eye(6) * 1e-10)
    assert found == pytest.approx(certain, rel=1e-12)
    P[4, 5] = P[5, 4] = 0.0
    alone = margin.determinant(np.array([0.064, 0, 0, -0.16, 0, 0]), np.eye(6) * 1e-10)
    assert margin.determinant(np.array([0.064, 0, 0, *rates]), P) == pytest.approx(alone)


def run(level, values):
    return [level.update(k * 1e-3, value) for k, value in enumerate(values)]


def test_one_sample_raises_no_alarm_and_clears_none():
    level = Level(0.7, 0.95, OPTIONS)
    assert set(run(level, [0, 0, 1.0, 0, 0])) == {OK}
    level = Level(0.7, 0.95, OPTIONS)
    seen = run(level, [1.0] * 50 + [0.0] * 3 + [1.0] * 50)
    assert seen[:10] == [OK] * 10
    assert seen[11:] == [ERROR] * len(seen[11:])


def test_alarm_falls_level_by_level_after_its_hold():
    level = Level(0.7, 0.95, OPTIONS)
    run(level, [1.0] * 50)
    steps = [level.update(0.05 + k * 1e-3, 0.2) for k in range(600)]
    hold = round(OPTIONS.alarm_hold * 1000)
    assert steps[hold - 1] == ERROR
    assert steps[hold + 1] == WARN
    assert steps[2 * hold + 2] == OK
    # Within the hysteresis it stays.
    level = Level(0.7, 0.95, OPTIONS)
    run(level, [0.8] * 50)
    assert level.update(10.0, 0.65) == WARN
    assert level.update(20.0, 0.65) == WARN


def updates(alarms, duration=0.05, **given):
    values = {
        "mode": "three_point", "risk": 0.0, "determinant": 1.0, "normal": [20.0, 30.0, 30.0],
        "normal_stddev": [1.0, 1.0, 1.0], **given,
    }  # fmt: skip
    for k in range(int(duration * 1000)):
        found = alarms.update(k * 1e-3, *values.values())
    return {alarm.name: alarm for alarm in found}


def test_each_alarm_has_its_cause_its_numbers_and_a_remedy():
    limit = OPTIONS.max_normal[1]
    quiet = updates(Alarms(OPTIONS))
    assert {alarm.level for alarm in quiet.values()} == {OK}
    jamming = updates(Alarms(OPTIONS), risk=1.0, determinant=-0.1)["jamming"]
    assert jamming.level == ERROR
    assert "reverse" in jamming.message
    assert dict(jamming.values)["determinant"] == -0.1
    loss = updates(Alarms(OPTIONS), normal=[20.0, 30.0, -5.0])["contact_loss"]
    assert loss.level == ERROR
    assert "B2" in loss.message
    expected = 0.5 * (1 + erf(5 / sqrt(2)))
    assert dict(loss.values)["open_probability_B2"] == pytest.approx(expected)
    overload = updates(Alarms(OPTIONS), normal=[20.0, limit * 0.9, 30.0])["overload"]
    assert overload.level == WARN
    assert "B1" in overload.message
    assert "reduce" in overload.message
