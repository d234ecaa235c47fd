"""Risk and alarms, each against what it is defined to say."""

import numpy as np
import pytest

from peg_on_hole_ros.mechanics.kernel import scene_scalars
from peg_on_hole_ros.mechanics.reference import solve_contact
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitoring.alarms import ERROR, OK, WARN, Alarms, Level
from peg_on_hole_ros.monitoring.jamming import WedgingMargin, jamming_risk
from peg_on_hole_ros.options import MonitorOptions

OPTIONS = MonitorOptions()


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
        "mode": "three_point", "risk": 0.0, "determinant": 1.0, "lost": [0.0, 0.0, 0.0],
        "normal": [20.0, 30.0, 30.0], **given,
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
    loss = updates(Alarms(OPTIONS), mode="unknown", lost=[0.0, 0.0, 0.995])["contact_loss"]
    assert loss.level == ERROR
    assert "B2" in loss.message
    assert dict(loss.values)["open_probability_B2"] == 0.995
    overload = updates(Alarms(OPTIONS), normal=[20.0, limit * 0.9, 30.0])["overload"]
    assert overload.level == WARN
    assert "B1" in overload.message
    assert "reduce" in overload.message
