"""Stuck in the hole: pushed and not moving along it, whatever friction is stated."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from benchmarks.harness.exact import exactly
from benchmarks.harness.truths import play
from benchmarks.insertion.labels import labels_of
from benchmarks.insertion.scenes import Case, plan_of
from insertions import inserted
from peg_on_hole_ros.config.options import Configuration, JointInput, MonitorOptions, WrenchInput
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.estimator.hole_geometry import depth_at
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitor.rest_in_hole import DepthTrend, follow_depth, rests
from peg_on_hole_ros.monitor.settings import monitor_settings
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.sim.truth import integrate
from peg_on_hole_ros.typed_record import new
from tiers import at_push, nightly
from two_points import length_inside, samples, tilt_at

WARN, ERROR = 1, 2
PEGS = {
    "wide": Scene(hole_diameter=0.050, peg_diameter=0.0499, friction=0.2),
    "loose": Scene(hole_diameter=0.030, peg_diameter=0.0298, peg_height=0.06, friction=0.3),
    "small": Scene(
        hole_diameter=0.012, peg_diameter=0.01196, peg_height=0.03, peg_mass=0.2, friction=0.15
    ),
}


def configuration(scene, stated, position_stddev=1e-4):
    return Configuration(
        scene=replace(scene, friction=stated * scene.friction),
        # Tared: what it reads from the start on is no zero that nobody has taken.
        wrench=WrenchInput(sensor_xyz=(0.0, 0.0, 1.2 * scene.peg_height), bias_force_stddev=0.01),
        joints=JointInput(position_stddev=position_stddev),
    )


def played(told, tilts, loads, friction, share=1.0):
    """Return mode, risk and level of the alarm `jamming` at each wrench."""
    line = Pipeline(told)
    rows = list(line.play(samples(told, tilts, loads, friction, share)))
    level = [alarm.level for row in rows for alarm in row.alarms if alarm.name == "jamming"]
    risk = [row.monitor.get("jamming_risk", np.nan) for row in rows]
    return np.array([row.contact_mode for row in rows]), np.array(risk), np.array(level)


@pytest.mark.parametrize("stated", [1.5, *nightly(0.5, 1.1)])
@pytest.mark.parametrize(
    ("peg", "loads", "depth", "speed"),
    [
        ("wide", (30.0, 30.0), 0.0155, 0.010),
        ("loose", (15.0, 40.0), 0.012, 0.030),
        ("small", (8.0, 8.0), 0.006, 0.008),
    ],
)
def test_a_peg_that_slides_in_is_not_stuck(peg, loads, depth, speed, stated):
    scene = PEGS[peg]
    tilts = [tilt_at(scene, depth + speed * 1e-3 * i) for i in range(350)]
    mode, risk, level = played(configuration(scene, stated), tilts, loads, scene.friction)
    assert set(mode[20:]) == {"two_point"}
    assert risk[100:].max() < 0.5
    assert level.max() == 0


@pytest.mark.parametrize("stated", [0.75, *nightly(0.5, 1.5)])
@pytest.mark.parametrize(
    ("peg", "loads", "depth", "share"),
    [
        ("wide", (30.0, 30.0), 0.0167, 0.8),
        ("loose", (40.0, 25.0), 0.012, 0.6),
        ("small", (20.0, 25.0), 0.006, 0.6),
    ],
)
def test_a_peg_that_is_pushed_and_rests_is_stuck(peg, loads, depth, share, stated):
    scene = PEGS[peg]
    tilts = [tilt_at(scene, depth)] * 450
    _, risk, level = played(configuration(scene, stated), tilts, loads, scene.friction, share)
    assert (level[300:] == ERROR).all()
    assert np.nanmax(risk) <= 1.0


@pytest.mark.parametrize("share", [0.0, -0.5])
def test_at_rest_without_a_push_nothing_is_an_alarm(share):
    """Both contacts carry 30 N, the wrench pushes nowhere along the hole, or out of it."""
    scene = PEGS["wide"]
    told = configuration(scene, 1.0)
    _, _, level = played(told, [0.006] * 400, (30.0, 30.0), scene.friction, share)
    assert level.max() == 0


@pytest.mark.parametrize(("holds", "level"), [(0.0, 0), (0.1, ERROR)])
def test_a_pressed_peg_whose_holder_keeps_its_tilt_is_not_stuck(holds, level):
    """K's normal leans with the peg and lifts it by 15 N: stuck is what friction holds beside."""
    scene = Scene(hole_diameter=0.050, peg_diameter=0.0498, friction=0.2)
    tilts = [tilt_at(scene, 0.0045)] * 400
    assert 200.0 * np.sin(tilts[0]) > 14.0
    _, _, found = played(configuration(scene, 1.0), tilts, (200.0, 200.0), holds)
    assert (found[300:] == level).all() and found.max() == level


def test_a_peg_that_stops_while_it_is_pushed_is_told_soon():
    scene = PEGS["wide"]
    tilts = [tilt_at(scene, 0.015 + 20e-6 * min(i, 250)) for i in range(500)]
    _, risk, level = played(configuration(scene, 1.5), tilts, (30.0, 30.0), scene.friction)
    assert risk[100:250].max() < 0.5
    assert level[350] >= WARN and (level[450:] == ERROR).all()


def test_rest_and_motion_are_told_by_the_tilt():
    """0.2 s of orientations, drawn 40 times: at least a WARN's worth of rest, and hardly any."""
    scene, noise, speed = PEGS["wide"], 1e-4, 0.010
    settings, draw = monitor_settings(MonitorOptions(), scene, 0.0), np.random.default_rng(3)
    slope = (length_inside(scene, 0.0061) - length_inside(scene, 0.0059)) / -2e-4
    told = {0.0: [], -speed / slope: []}
    for rate, found in told.items():
        for _ in range(40):
            depth = new(DepthTrend)
            for i in range(100):
                tilt = 0.006 + rate * 2e-3 * i + noise * draw.standard_normal()
                since = -1.0 if i == 0 else 2e-3
                follow_depth(depth, tilt, noise**2, since, settings)
            found.append(rests(depth))
    at_rest, sliding = map(np.sort, told.values())
    assert at_rest[8] > 0.7
    assert sliding[20] < 0.05 and sliding[-1] < 0.7


@pytest.mark.parametrize(
    ("kind", "stated"),
    at_push([("goes_on", 0.5), ("jams", 1.5)], product(("goes_on", "jams"), (0.5, 1.0, 1.5))),
)
def test_a_simulated_insertion_is_alarmed_where_it_jams(kind, stated):
    truth = inserted(kind)
    told, scene = truth.plan.configuration, truth.plan.configuration.scene
    told = replace(told, scene=replace(scene, friction=stated * scene.friction))
    rows = list(Pipeline(told).play(measure(truth, 4)))
    t = np.array([(row.t_ns - START_NS) * 1e-9 for row in rows])
    level = np.array([row.alarms[0].level for row in rows])
    push = -(truth.force[:, 2] - scene.peg_mass * 9.80665)
    still = (np.abs(truth.place_rate[:, 2]) < 5e-5) & (push > 5.0)
    if kind == "goes_on":
        assert not still[truth.t_ns > 2e8].any()
        assert level.max() < ERROR
        return
    since = truth.t_ns[np.flatnonzero(~still)[-1]] * 1e-9
    assert t[-1] - since > 0.25
    assert (level[t > since + 0.1] >= WARN).all() and level[-1] == ERROR
    assert not (level[t < since - 0.1] == ERROR).any()


@pytest.mark.parametrize("number", [12, *nightly(8, 9)])
def test_the_alarm_of_a_jammed_peg_ends_soon_after_it_is_wiggled_free(number):
    """Between two swings it rests under a push: that is stuck, so WARN waits for the last."""
    truth = integrate(plan_of(Case("freed", number, "tuning")))
    level = play(truth, truth.plan.configuration, [[4]]).alarms["jamming"]
    t, stop = truth.t_ns * 1e-9, labels_of(truth).events[0]
    on = t[np.flatnonzero(truth.phase == "go_on")[0]]
    assert stop.cause == "jammed" and stop.freed and stop.end < on
    assert level[np.searchsorted(t, stop.end)] == ERROR
    # Of either time `monitor.alarm_hold` is 0.2 s.
    assert (level[(t > stop.end + 0.25) & (t < on)] < ERROR).all()
    assert level[(t > on) & (t < on + 0.35)].min() == 0


@pytest.mark.parametrize("kind", ["goes_on", "jams"])
def test_how_deep_the_peg_is_is_told_while_rim_and_wall_carry(kind):
    """The simulation has a depth of its own, and contacts that give."""
    truth = inserted(kind)
    rows = list(Pipeline(truth.plan.configuration).play(measure(truth, 4)))
    told = np.array([row.monitor.get("insertion_depth", np.nan) for row in rows])
    stddev = np.array([row.monitor.get("insertion_depth_stddev", np.nan) for row in rows])
    at = np.searchsorted(truth.t_ns, [row.t_ns - START_NS for row in rows])
    error, known = told - truth.place[at, 2], np.isfinite(told)
    assert known.sum() > 100
    assert (known == np.isfinite(stddev)).all()
    assert (truth.mode[at[known]] == "two_point").all()
    assert np.mean(np.abs(error[known]) <= 1.96 * stddev[known]) > 0.9
    assert np.median(stddev[known]) < 0.1 * truth.place[:, 2].max()


@pytest.mark.parametrize("scene", ["goes_on", *nightly("jams", "turns")])
def test_how_fast_the_peg_goes_in_is_told_with_its_depth(scene):
    """The simulation has a speed of its own; some 3 to 60 mm/s."""
    turns = Case("normal", 7, "tuning")
    truth = integrate(plan_of(turns)) if scene == "turns" else inserted(scene)
    record = play(truth, truth.plan.configuration, [[4]])
    speed, stddev = (record.monitor[f"insertion_speed{end}"] for end in ("", "_stddev"))
    known = np.isfinite(speed)
    assert (known == np.isfinite(stddev)).all()
    assert (known == np.isfinite(record.monitor["insertion_depth"])).all()
    true = truth.place_rate[:, 2]
    chosen = known & (np.abs(true) > 1e-3)
    assert chosen.sum() > 100
    error, spread = np.abs(speed - true)[chosen], stddev[chosen]
    assert 0.85 <= np.mean(error <= 1.96 * spread) <= 1.0
    # Deep in the hole, with little load, the tilt tells the speed no nearer than to 60 mm/s.
    near = spread < 5e-3
    assert near.sum() > 80
    assert np.sqrt(np.mean(error[near] ** 2)) < 3e-3


def test_the_spread_of_the_depth_is_that_of_tilt_and_clearance():
    d, D, gamma, step = 0.0298, 0.03, 0.02, 1e-6
    depth, by_tilt, by_diameter = depth_at(d, D, gamma)
    # Edge and side from the lower end's centre, across and up in the plane of the tilt.
    s, c = np.sin(gamma), np.cos(gamma)
    axis, across = np.array([s, c]), np.array([c, -s])
    B, K = -across * d / 2, across * d / 2 + axis * length_inside(Scene(D, d), gamma)
    assert (K - B)[0] == pytest.approx(D, rel=1e-9)
    assert K[1] == pytest.approx(depth, rel=1e-9)
    assert by_tilt == pytest.approx((depth_at(d, D, gamma + step)[0] - depth) / step, rel=1e-3)
    assert by_diameter == pytest.approx((depth_at(d + step, D, gamma)[0] - depth) / step, rel=1e-3)


@pytest.mark.parametrize("stated", [0.5, *nightly(1.0, 1.5)])
def test_friction_is_told_no_surer_in_the_hole_than_contacts_that_give_let_it_be(stated):
    """It was learnt on a rim that gives by 1 um for 100 N, with a clearance of 40 um."""
    truth = inserted("goes_on", 4e-5, 3e-3)
    told, scene = exactly(truth.plan.configuration), truth.plan.configuration.scene
    told = replace(told, scene=replace(scene, friction=stated * scene.friction))
    rows = list(Pipeline(told).play(measure(truth, 4)))
    late = [row for row in rows if row.contact_mode == "two_point"][100:]
    off = np.array([row.monitor["friction"] - scene.friction for row in late])
    stddev = np.array([row.monitor["friction_stddev"] for row in late])
    assert len(late) > 100
    assert np.mean(np.abs(off) <= 2.0 * stddev) > 0.95
    assert np.median(stddev) < 0.06 * scene.friction
