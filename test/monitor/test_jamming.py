"""The risk of jamming by its causes, against the mechanics and along simulated motions."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.scenes.draw import Case, plan_of
from judging import risk_of
from paper.wedging import wedging
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.options import MonitorOptions
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.mechanics.reference import solve_contact
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.mechanics.whitney import jamming_margin
from peg_on_hole_ros.messages.decode import joint_sample, wrench_sample
from peg_on_hole_ros.monitor.assessment import follow_orientation
from peg_on_hole_ros.monitor.dangers.registry import assess_dangers
from peg_on_hole_ros.monitor.memory import Memory
from peg_on_hole_ros.monitor.motion_now import Passed
from peg_on_hole_ros.monitor.settings import monitor_settings
from peg_on_hole_ros.replay.run import stored_configuration
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate
from peg_on_hole_ros.typed_record import new
from simulated import ROOT, truth
from tiers import nightly
from under_way import placed, press

SCENE = Scene(friction_stddev=0.0)


def risk(
    gamma, rates, scene=SCENE, wrench=(0, 0, -20, 0, 0, 0), under=0.0, options=None, times=100
):
    """Return the risk of a peg that has moved at given rates for a while, by orientations."""
    options = options or MonitorOptions()
    noise = np.diag([1e-4] * 3 + [1e-7] * 3)
    memory, settings = new(Memory), monitor_settings(options, scene, 0.0)
    R, rates = np.eye(3) * 1e-10, np.array(rates, float)
    end = np.array([gamma, 0.0, 0.0])
    for k in range(200):
        q = end - (199 - k) * 2e-3 * rates
        since = -1.0 if k == 0 else 2e-3
        follow_orientation(memory, since, q, R, settings)
    kalman = placed(end, rates, scene, noise, 1e-10, 1e-6)
    record = press(kalman, wrench)
    shown, dangers = memory.evidence.shown, memory.dangers
    shown.below, shown.time, shown.usable = under, -1.0, under < 0.5
    shown.on_hole, shown.two_point = 1.0, under
    for _ in range(times):
        assess_dangers(
            record, dangers, memory.motion, memory.depth, shown, settings, Passed(1e-3, 0.0)
        )
    return risk_of(dangers)


@pytest.mark.parametrize("rates", [(-0.16, 0, 0), (-0.16, 0, 2.0), (0.1, 0, 0), (-0.1, 0.6, -0.4)])
def test_determinant_is_that_of_the_six_equations(rates):
    found = risk(0.13, rates).determinant
    expected = solve_contact(SCENE, [0.13, 0, 0], rates, [0, 0, 0], [0, 0, 0]).determinant
    # The slip is known to 1e-3 rad/s, and turning estimated to as much.
    assert found == pytest.approx(expected, rel=2e-3)


def test_wedging_is_seen_along_the_way_and_not_where_the_motion_does_not_lead():
    # Closing without slip is singular at 0.0652 rad; 0.16 rad/s take 0.2 s from 0.097.
    assert risk(0.085, (-0.16, 0, 0)).wedging > 0.99
    assert risk(0.115, (-0.16, 0, 0)).wedging < 0.01
    assert risk(0.085, (-0.02, 0, 0)).wedging < 0.01
    assert risk(0.068, (-0.1, 0, 0)).wedging > 0.99
    # So slow a peg creeps through: K slides at some 1e-5 m/s only.
    assert risk(0.0655, (-0.02, 0, 0)).wedging < 0.01
    assert risk(0.085, (-0.16, 0, 2.0)).wedging < 0.01
    assert risk(0.085, (-0.16, 0, 0), replace(SCENE, friction=0.1)).wedging < 0.01


def test_spread_of_friction_is_carried():
    scene = replace(SCENE, friction=0.14, friction_stddev=0.03)
    found = risk(0.07, (-0.16, 0, 0), scene).wedging
    # The share of coefficients that make the determinant negative on the way.
    draws = np.random.default_rng(9).normal(0.14, 0.03, 200)
    ahead = SCENE.gamma0 * (1 + np.array([3e-3, 8e-3, 0.015, 0.025, 0.04]))
    singular = [
        min(
            wedging(replace(scene, friction=f), [g, 0, 0], [-0.16, 0, 0], 1e-5).determinant
            for g in ahead
        )
        < 0
        for f in draws
    ]
    # The determinant is taken as linear in friction, and as known to 0.03 only.
    assert found == pytest.approx(np.mean(singular), abs=0.12)


def axes(gamma):
    """Return the peg's axes as columns in (h, e, z)."""
    s, c = np.sin(gamma), np.cos(gamma)
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def test_combined_risk_is_that_of_any_cause_and_finite_everywhere():
    for gamma in (0.01, SCENE.gamma0, SCENE.gamma0 * (1 + 1e-9), 0.0652, 0.3, 1.2):
        for rates in ((0, 0, 0), (-0.16, 0, 0), (5.0, -3.0, 9.0)):
            under = float(gamma <= SCENE.gamma0)
            found = risk(gamma, rates, under=under)
            assert np.isfinite(found).all()
            causes = np.array(found[:3])
            assert (causes >= 0).all() and (causes <= 1).all()
            assert found.risk == pytest.approx(1 - np.prod(1 - causes), abs=1e-12)


def test_in_the_hole_depth_and_margin_are_those_of_tilt_and_load():
    scene, gamma = replace(SCENE, friction=0.2, gravity=(0.0, 0.0, 0.0)), 0.004
    inward = (0.0, 0.0, -20.0, 0.0, 0.0, 0.0)
    found = risk(gamma, (0, 0, 0), scene, inward, under=1.0)
    length = scene.peg_diameter * found.insertion
    D, d = scene.hole_diameter, scene.peg_diameter
    assert length == pytest.approx((D - d * np.cos(gamma)) / np.sin(gamma), rel=1e-9)
    # A moment about e at the mass centre, and a force that has an arm to the lower end.
    F, M = np.array([5.0, 0.0, -20.0]), np.array([0.0, 2.0, 0.0])
    R = axes(gamma)
    side = risk(gamma, (0, 0, 0), scene, (*(R.T @ F), *(R.T @ M)), under=1.0)
    about_end = M + np.cross(scene.mass_center_height * R[:, 2], F)
    expected = jamming_margin(d / 2, length, scene.friction, 5.0, 20.0, -about_end[1])
    assert side.margin == pytest.approx(expected, rel=1e-9)


def test_an_estimate_below_zero_in_the_hole_leans_to_the_other_side():
    """It had a peg that leans by 0.2 mrad 2000 diameters deep."""
    wrench = np.array([3.0, -1.0, -20.0, 0.1, 0.4, -0.05])
    # Leaning to the other side is half a turn of psi, and phi back: axes of the peg stay.
    below = risk(-2e-4, (0, 0, 0), SCENE, tuple(wrench), under=1.0)
    turned = risk(2e-4, (0, 0, 0), SCENE, tuple(wrench * [-1, -1, 1, -1, -1, 1]), under=1.0)
    assert below.insertion == pytest.approx(turned.insertion, rel=1e-12)
    assert below.margin == pytest.approx(turned.margin, rel=1e-12)
    assert below.stall == pytest.approx(turned.stall, abs=1e-12)


def played(scene, seed=1):
    """Return times [s] and the outputs of a pipeline over one measurement of a truth."""
    found = list(Pipeline(scene.plan.configuration).play(measure(scene, seed)))
    return np.array([(outputs.t_ns - START_NS) * 1e-9 for outputs in found]), found


def seen(outputs, name, above=0.7):
    return np.array([row.monitor.get(name, 0.0) > above for row in outputs])


def test_a_closing_that_wedges_is_alarmed_before_and_says_that_slip_helps():
    scene = truth("closing_without_slip")
    wedged = next(t_ns for t_ns, text in scene.events if text.startswith("wedged")) * 1e-9
    t, outputs = played(scene)
    raised = [i for i, row in enumerate(outputs) if row.alarms[0].level]
    # The horizon is 0.2 s; the dwell and the friction that is still being learnt take some of it.
    assert wedged - 0.21 < t[raised[0]] < wedged - 0.1
    assert "slip takes" in outputs[raised[-1]].alarms[0].message or t[raised[-1]] > wedged


def error_leads_by(scene, event, horizon):
    """Return how long before an event [s] `jamming` becomes ERROR with a horizon."""
    configuration = scene.plan.configuration
    monitor = replace(configuration.monitor, jamming_horizon=horizon)
    for outputs in Pipeline(replace(configuration, monitor=monitor)).play(measure(scene, 1)):
        if outputs.alarms[0].level == 2:
            return event - (outputs.t_ns - START_NS) * 1e-9
    return -np.inf


# An arm needs some 30 ms to stop, one with a slow controller 0.1 s and more.
@pytest.mark.parametrize("stops_within", [0.03, *nightly(0.1, 0.3)])
def test_a_horizon_that_is_set_by_the_arm_gives_it_the_time_to_stop_before_a_wedge(stops_within):
    scene = truth("closing_without_slip")
    wedged = next(t_ns for t_ns, text in scene.events if text.startswith("wedged")) * 1e-9
    # As docs/jamming.md says; from the threshold on the level takes its dwell.
    horizon = stops_within + scene.plan.configuration.monitor.alarm_dwell + 0.01
    assert stops_within <= error_leads_by(scene, wedged, horizon) <= horizon
    # A horizon that the level's dwell takes up leaves nothing.
    assert error_leads_by(scene, wedged, 0.0) < 0.0


def test_a_closing_with_slip_raises_no_alarm():
    _, outputs = played(truth("closing_with_slip"))
    assert not any(row.alarms[0].level for row in outputs)
    assert not seen(outputs, "jamming_risk", 0.5).any()


@cache
def pressed_until_it_stops():
    configuration = from_parameters({"scene.friction": 0.25, "scene.peg_diameter": 0.0498})
    rates = [-0.06, 0.0, 0.05]
    phases = {
        "steady": {"kind": "contact", "duration": 0.2, "rates": rates},
        "press": {
            "kind": "contact", "duration": 0.5, "rates": rates, "offset": [0.0, 0.0, -0.006],
        },
    }  # fmt: skip
    holder = {"rotational_stiffness": 12.0, "force_limit": 2000.0, "torque_limit": 100.0}
    start = {"angles": [0.17, 0.0, 0.0], "rates": rates, "offset": [0.0, 0.0, -0.0008]}
    tree = {"lead_in": 0.05, "holder": holder, "start": start, "phases": phases}
    return integrate(plan_from_tree(configuration, tree))


def stands_still_from(scene):
    still = (np.abs(scene.rates[:, 0]) < 2e-3) & (scene.t_ns > 1e8)
    return scene.t_ns[still][0] * 1e-9


def test_a_stall_is_foreseen_by_the_push_and_no_earlier_with_a_longer_horizon():
    """The push shows where it goes for a tenth of a second, however far one looks ahead."""
    scene = pressed_until_it_stops()
    still = stands_still_from(scene)
    near, usual, far = (error_leads_by(scene, still, horizon) for horizon in (0.02, 0.2, 0.4))
    assert 0.0 < near < usual <= far < 0.06


def test_a_peg_that_is_pressed_until_friction_stops_it_is_alarmed_before_it_stops():
    scene = pressed_until_it_stops()
    still = stands_still_from(scene)
    t, outputs = played(scene)
    stall = t[seen(outputs, "jamming_stall")]
    assert still - 0.2 < stall[0] < still - 0.02
    assert seen(outputs, "jamming_stall")[(t > still) & (t < still + 0.15)].all()


@pytest.mark.nightly
def test_a_peg_that_its_holder_brings_to_rest_is_no_stall():
    t, outputs = played(truth("working_cycle"))
    # It comes to rest from 5.2 s on, and is held still until 6.3 s.
    held = (t > 1.5) & (t < 6.3)
    assert not (seen(outputs, "jamming_stall") & held).any()


@pytest.mark.parametrize("number", [13, *nightly(9, 38)])
def test_a_press_at_rest_is_no_jam(number):
    """Set down, pressed more, closed, stopped, and pressed again, all by the holder's program."""
    scene = integrate(plan_of(Case("held", number, "tuning")))
    t, outputs = played(scene)
    rest = np.abs(scene.rates[np.searchsorted(scene.t_ns, np.round(t * 1e9)), 0]) < 1e-3
    push = np.linalg.norm(scene.force, axis=1)
    assert rest.sum() > 200 and push.max() > 2.0 * push[0]
    assert {row.alarms[0].level for row in outputs} == {0}


@cache
def closed_over_an_edge_of_friction():
    configuration = from_parameters({"scene.friction": 0.19, "scene.peg_diameter": 0.0499})
    rates = [-0.065, -0.225, 0.87]
    smooth = {"kind": "contact", "duration": 0.1, "rates": rates}
    phases = {"smooth": smooth, "rough": {**smooth, "duration": 0.06, "friction": 0.4}}
    start = {"angles": [0.12, 0.0, 0.0], "rates": rates, "offset": [0.0, 0.0, -0.001]}
    tree = {"lead_in": 0.0, "start": start, "phases": phases}
    return integrate(plan_from_tree(configuration, tree))


def limited(limits, seed=1):
    """Alarms of overload of a closing under other limits of the reactions [N]."""
    scene = truth("closing_with_slip")
    configuration = scene.plan.configuration
    monitor = replace(configuration.monitor, max_normal=tuple(map(float, limits)))
    line = Pipeline(replace(configuration, monitor=monitor))
    return [row.alarms[2] for row in line.play(measure(scene, seed))]


@pytest.mark.parametrize("contact", [0, *nightly(1, 2)])
def test_a_load_is_of_the_contact_that_passes_its_own_limit(contact):
    normal = truth("closing_with_slip").normal
    limits = 10.0 * normal.max(axis=0)
    limits[contact] = 0.6 * normal[:, contact].min()
    alarms = limited(limits)
    # From when reactions are told, over its limit all along.
    assert {alarm.level for alarm in alarms[150:]} == {2}
    name = ("K", "B1", "B2")[contact]
    assert {alarm.message.split(" is ")[0] for alarm in alarms[150:]} == {f"contact {name}"}


def test_loads_below_their_limits_are_none():
    alarms = limited(2.0 * truth("closing_with_slip").normal.max(axis=0))
    assert {alarm.level for alarm in alarms} == {0}


@pytest.mark.parametrize("seed", [0, *nightly(1, 2)])
def test_no_load_is_foreseen_where_friction_jumps(seed):
    """The old friction makes twice the reactions of the wrench, until the new one is learnt."""
    scene = closed_over_an_edge_of_friction()
    _, outputs = played(scene, seed)
    # Of a limit of 500 N.
    assert scene.normal.max() < 130
    assert max(row.monitor.get("jamming_load", 0.0) for row in outputs) < 0.1


def test_no_load_is_foreseen_where_reactions_jump_to_another_level():
    """The shipped cycle reverses at 3.0 s: within 10 ms friction turns and the loads double."""
    bag = Bag(ROOT / "bags" / "working_cycle.mcap")
    pipeline = Pipeline(stored_configuration(bag))
    seen, begin = [], None
    for topic, t_ns, message in bag.messages(["/wrench", "/joint_states"]):
        begin = begin or t_ns
        if not 2.7 <= (t_ns - begin) * 1e-9 <= 3.1:
            continue
        if topic == "/joint_states":
            pipeline.on_joints(joint_sample(message))
            continue
        outputs = pipeline.on_wrench(wrench_sample(message))
        if outputs is not None:
            seen.append((outputs.normal.max(), outputs.monitor.get("jamming_load", 0.0)))
    normal, load = np.array(seen[150:]).T
    assert normal.max() > max(120.0, 1.7 * normal.min())
    # A quarter of the limit of 500 N.
    assert load.max() < 0.1
