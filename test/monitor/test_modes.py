"""Contact hypotheses, declared mode and flag, each against what it is defined to say."""

from dataclasses import replace
from itertools import product
from math import erf, exp, sqrt

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.grid.cells import Motion, truth_of, with_noise
from inputs import hanging, joints
from judging import Flag, Mode, Shown
from late_samples import ordered
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.options import Configuration, JointInput, MonitorOptions, WrenchInput
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.monitor.contact_load import ContactLoad, carried_load, stands_out
from peg_on_hole_ros.monitor.contact_probabilities import (
    CLOSED,
    COUNT,
    FREE,
    LOST_B1,
    LOST_K,
    OTHER,
    ContactEvidence,
    load_evidence,
    misfit_evidence,
    no_knowledge,
    opening_evidence,
    weigh,
)
from peg_on_hole_ros.monitor.evidence import new_share, wedged_load, weigh_wrench
from peg_on_hole_ros.monitor.memory import Memory, begin_memory
from peg_on_hole_ros.monitor.motion_now import Passed
from peg_on_hole_ros.monitor.motion_trend import follow_motion
from peg_on_hole_ros.monitor.settings import monitor_settings
from peg_on_hole_ros.monitor.tuned import EVIDENCE_WEIGHTS, FREE_PEG_LOAD
from peg_on_hole_ros.records import ANGLES, JointSample, WrenchSample
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate
from peg_on_hole_ros.typed_record import new
from simulated import truth
from tiers import nightly
from two_points import samples
from under_way import move, placed, press

MOST = EVIDENCE_WEIGHTS.most
OPTIONS = MonitorOptions()
SCENE = Scene()
PRESSED = Shown(0.95, 0, 0.01, 0.0, 0.01, 0.03, 0.0, 0.99, 0.0, -1, 0, 0, 1, 0, 0, 0)
RECENT = Passed(1e-3, 0.0)


@pytest.mark.parametrize("threshold", [1.0, 51.0, 80.0])
def test_the_threshold_is_one_of_the_whole_load_and_closes_no_contact(threshold):
    """K carries 49 N, B1 and B2 113 N each; what of that the peg feels is some 54 N."""
    configuration = truth("closing_with_slip").plan.configuration
    options = replace(configuration.monitor, contact_force_threshold=threshold)
    line = Pipeline(replace(configuration, monitor=options))
    *_, last = line.play(ordered(200))
    if threshold < 54.0:
        assert last.contact_mode == "three_point"
        assert (last.normal > 0.0).all()
    else:
        assert last.contact_mode == "open"
        assert (last.normal == 0.0).all()
    np.testing.assert_array_equal(last.closed, last.normal > 0.0)


def test_probabilities_are_those_of_the_sum_over_all_paths():
    # No recursion: every sequence of hypotheses with its probability written out.
    rate, correlation, dt = 20.0, 5e-3, 3e-3
    evidence = [
        (2.0, -1.0, 0.5, 0.2, -2.0),
        (-1.5, 3.0, 0.0, 0.0, 1.0),
        (0.3, 0.1, -3.0, 2.0, 0.7),
        (1.0, -2.0, 0.4, 0.1, -0.3),
    ]
    prior = no_knowledge()
    change, again = 1 - exp(-rate * dt), 1 - exp(-dt / EVIDENCE_WEIGHTS.retry)
    changed = change * np.tile(prior, (COUNT, 1)) + (1 - change) * np.eye(COUNT)
    tried = np.eye(COUNT)
    tried[OTHER, OTHER], tried[OTHER, CLOSED] = 1 - again, again
    step = changed @ tried
    share = dt / correlation
    total = np.zeros(COUNT)
    for path in product(range(COUNT), repeat=5):
        weight = prior[path[0]]
        for k in range(1, 5):
            load, lost_K, lost_B1, lost_B2, other = evidence[k - 1]
            free = max(lost_K, lost_B1, lost_B2, 0) - load
            log = np.array([free, 0, lost_K, lost_B1, lost_B2, other])
            weight *= step[path[k - 1], path[k]] * exp(share * log[path[k]])
        total[path[-1]] += weight
    p = no_knowledge()
    for row in evidence:
        weigh(p, ContactEvidence(*row), dt, rate, correlation)
    np.testing.assert_allclose(p, total / total.sum(), rtol=1e-12)


@pytest.mark.parametrize("dt", [1e-3, 0.05, 0.1, 0.15, 0.3, 10.0])
@pytest.mark.parametrize("rest", [0.0, 1.0])
def test_probabilities_stay_between_none_and_one_over_any_silence(dt, rest):
    """Contacts that have changed meanwhile are not given up a second time."""
    for likely in range(COUNT):
        p = np.full(COUNT, 1e-3)
        p[likely] = 1.0 - p.sum() + p[likely]
        nothing = ContactEvidence(0.0, 0.0, 0.0, 0.0, 0.0, rest=rest)
        weigh(p, nothing, dt, OPTIONS.mode_change_rate, OPTIONS.evidence_time)
        assert (p >= 0.0).all() and (p <= 1.0).all(), p
        assert p.sum() == pytest.approx(1.0, rel=1e-12)


def test_after_a_wrench_gap_no_probability_is_negative():
    """A peg that no mode fits well, and a wrench that is silent for a moment."""
    random, line, told = np.random.default_rng(1), Pipeline(from_parameters({})), []
    t_ns = 10_000_000_000
    for k in range(40):
        t_ns += 300_000_000 if k == 3 else 1_000_000
        angles = np.array([0.15, 0.0, 0.0]) + random.normal(0, 1, 3) * [1e-4, 6e-4, 6e-4]
        line.on_joints(JointSample(t_ns, ANGLES, tuple(angles)))
        force = np.array([0.0, 0.0, -8.0]) + random.normal(0, 0.2, 3)
        torque = np.array([0.0, 0.3, 0.0]) + random.normal(0, 0.005, 3)
        told.append(line.on_wrench(WrenchSample(t_ns, tuple(force), tuple(torque))).monitor)
    assert line.counts["gap"] == 1
    for monitor in told:
        names = [name for name in monitor if name.startswith("mode_probability")]
        for name in [*names, "three_point_validity", "transition_probability"]:
            assert 0.0 <= monitor[name] <= 1.0 + 1e-12, (name, monitor[name])
        # One of them holds; which of two points touches is a part of one.
        whole = [monitor[name] for name in names if not name.endswith("_alone")]
        assert sum(whole) == pytest.approx(1.0, abs=1e-9)


def test_evidence_is_the_ratio_of_its_probabilities_and_bounded():
    for z in (-1.2, 0.0, 0.4, 1.5):
        closed = 0.5 * (1 + erf(z / sqrt(2)))
        expected = np.log((1 - closed) / closed)
        assert opening_evidence(3.0 * z, 9.0) == pytest.approx(expected, rel=1e-12, abs=1e-14)
    assert opening_evidence(1e6, 1.0) == -MOST
    assert opening_evidence(-1e6, 0.0) == MOST
    assert load_evidence(1.0) == 0.0
    assert load_evidence(1e18) == -load_evidence(0.0) == MOST
    assert misfit_evidence(3.0) < 0.0 < misfit_evidence(50.0) <= MOST


def settle(p, seconds=0.1, **given):
    """Show one piece of evidence for a while; none for an opening, and against another contact."""
    values = {
        "load": MOST,
        "lost_K": -MOST,
        "lost_B1": -MOST,
        "lost_B2": -MOST,
        "other": -MOST,
    }
    evidence = ContactEvidence(**values | given)
    for _ in range(round(seconds * 1e3)):
        weigh(p, evidence, 1e-3, OPTIONS.mode_change_rate, OPTIONS.evidence_time)
    return p


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, CLOSED),
        ({"load": -2.0}, FREE),
        ({"lost_K": MOST}, LOST_K),
        ({"lost_B1": 2.0}, LOST_B1),
        ({"other": MOST}, OTHER),
    ],
)
def test_lasting_evidence_decides_and_can_be_turned(given, expected):
    p = settle(no_knowledge())
    assert p[CLOSED] > 0.95
    settle(p, **given)
    assert p.argmax() == expected
    assert p[expected] > 0.8
    assert p.sum() == pytest.approx(1.0, abs=1e-12)
    # However long it lasted: the other side is found again as soon.
    settle(p, seconds=5.0, **given)
    assert settle(p)[CLOSED] > 0.95


def test_at_rest_a_lost_contact_is_forgotten_and_in_motion_it_is_not():
    even = {"lost_K": 0.0, "lost_B1": -MOST, "lost_B2": -MOST}
    moves = settle(settle(no_knowledge(), lost_K=MOST), **even)
    assert moves[LOST_K] > 0.8
    rests = settle(settle(no_knowledge(), lost_K=MOST), **even, displaced=0.0, rest=1.0)
    # Two times `retry`: a seventh is left.
    assert rests[LOST_K] < 0.25 and rests[CLOSED] > 0.7
    # And as soon as it shows again, it is lost again.
    assert settle(rests, lost_K=MOST)[LOST_K] > 0.8


def test_evidence_counts_by_time_and_not_by_messages():
    often, seldom = no_knowledge(), no_knowledge()
    evidence = ContactEvidence(-1.0, 0.5, -1.0, -1.0, -1.0)
    for _ in range(64):
        weigh(often, evidence, 2.5e-4, 1.0, 5e-3)
    for _ in range(16):
        weigh(seldom, evidence, 1e-3, 1.0, 5e-3)
    # The two differ by what changes within a step.
    np.testing.assert_allclose(often, seldom, atol=2e-3)


def begun():
    memory = new(Memory)
    begin_memory(memory)
    return memory


def shown(gamma, force=-30.0, scene=SCENE):
    """What a pressed peg at rest shows after a while."""
    record = press(placed([gamma, 0.3, 0.1], scene=scene), [0.0, 0.0, force, 0.0, 0.0, 0.0])
    memory, settings = begun(), monitor_settings(OPTIONS, scene, 0.3)
    evidence, motion, place = memory.evidence, memory.motion, memory.place
    for _ in range(100):
        weigh_wrench(record, evidence, motion, settings, RECENT, -1.0, place, False)
    return Shown(*memory.evidence.shown.item())


def test_probabilities_of_the_modes_add_up_and_follow_tilt_and_load():
    gamma0 = SCENE.gamma0
    for gamma in (gamma0 - 0.01, gamma0, gamma0 + 1e-4, gamma0 + 0.02, 0.3):
        for force in (0.0, 4.9, -30.0):
            s = shown(gamma, force=force)
            assert sum(s[:7]) == pytest.approx(1.0, abs=1e-12)
            assert np.isfinite(s).all()
    assert shown(gamma0 - 0.01).two_point > 0.9
    # 0.5 kg carried by the sensor: nothing is left for the rim.
    assert shown(0.1, force=0.5 * 9.80665).free > 0.9
    assert shown(gamma0).below == pytest.approx(0.5, abs=1e-9)


def test_clearance_spread_reaches_the_probability():
    scene = Scene(clearance_stddev=2e-5)
    # One standard deviation of the clearance as a change of gamma0, by the exact formula.
    wide = np.arccos((scene.peg_diameter - 1e-6) / scene.hole_diameter)
    slope = (wide - scene.gamma0) / 1e-6
    sigma = sqrt((slope * 2e-5) ** 2 + 1e-8)
    found = shown(scene.gamma0 + sigma, scene=scene).below
    # One-sided difference over a twentieth of the clearance's standard deviation.
    assert found == pytest.approx(0.5 * (1 - erf(1 / sqrt(2))), rel=0.02)


def carried(kalman, wrenches, rates=None, dt=1e-3, time=5e-3):
    """Return carried load and its variance after wrenches in a row, turning along with rates."""
    means = new(ContactLoad)
    for k, wrench in enumerate(wrenches):
        if rates is not None:
            move(kalman, rates[k], 0.0, kalman.x[:3] + dt * kalman.x[3:])
        found = carried_load(press(kalman, wrench), means, dt, time)
    return found


def test_noise_is_averaged_out_and_what_is_left_is_foretold():
    rng = np.random.default_rng(4)
    noise = np.diag([0.04] * 3 + [2.5e-5] * 3)
    kalman = placed([0.1, 0.3, 0.7], scene=SCENE, noise=noise, rate_variance=0.0)
    hanging = -0.5 * np.array(SCENE.gravity) @ peg_axes(kalman.x[:3])
    weight = np.array([*hanging, 0.0, 0.0, 0.0])
    squares, foretold = [], 0.0
    for _ in range(400):
        wrenches = weight + rng.standard_normal((40, 6)) * np.sqrt(np.diagonal(noise))
        load, foretold = carried(kalman, wrenches)
        squares.append(load**2)
    # A sixth and less of one wrench's; the mean of 400 is good to some 4 %, the jumps add.
    assert foretold < 0.16 * (3 * 0.04 + 3 * 2.5e-5 * (2 / SCENE.peg_diameter) ** 2)
    assert np.mean(squares) == pytest.approx(foretold, rel=0.15)


@pytest.mark.parametrize("variance", [1e-4, 4e-2])
def test_rates_that_are_hardly_known_leave_a_couple_open(variance):
    """An error w of a rate across the axis, within the time of the mean, takes Ie w / time."""
    time, wrench = 5e-3, np.array([1.0, -2.0, 0.5, 0.01, 0.02, 0.0])
    foretold = []
    for each in (0.0, variance):
        kalman = placed([0.4, 0.2, 0.9], scene=SCENE, noise=1e-6, rate_variance=each)
        foretold.append(carried(kalman, [wrench], time=time)[1])
    # gamma turns the axis by itself, psi by sin(gamma).
    across = variance * (1.0 + np.sin(0.4) ** 2)
    couple = (SCENE.transverse_inertia / time) ** 2 * across
    added = couple * (2 / SCENE.peg_diameter) ** 2
    assert foretold[1] - foretold[0] == pytest.approx(added, rel=1e-6)


def peg_axes(q):
    """Return the peg's axes in those of the hole, from three turns by scipy."""
    return Rotation.from_euler("ZYZ", [q[1], -q[0], q[2]]).as_matrix()


def test_a_load_that_changes_is_seen_at_once():
    kalman = placed([0.1, 0.0, 0.0], scene=SCENE, noise=1e-6, rate_variance=0.0)
    pressed = [np.array([0.0, 0.0, -30.0, 0.0, 0.0, 0.0])] * 20
    hanging = np.array([*(-0.5 * np.array(SCENE.gravity) @ peg_axes(kalman.x[:3])), 0, 0, 0])
    assert carried(kalman, pressed)[0] == pytest.approx(30 + 0.5 * 9.80665, rel=0.01)
    assert carried(kalman, [*pressed, hanging])[0] == pytest.approx(0.0, abs=1e-9)


def test_a_free_peg_that_turns_carries_nothing():
    # Euler's equations about the body's own axes, by scipy's rotations and a midpoint rule.
    Ie, Iz = SCENE.transverse_inertia, SCENE.axial_inertia
    inertia, dt = np.diag([Ie, Ie, Iz]), 2e-4
    rng = np.random.default_rng(2)
    axes, spin = peg_axes([0.4, 0.2, 0.9]), np.array([1.0, -2.0, 3.0])
    noise = np.diag([0.04] * 3 + [2.5e-5] * 3)
    kalman = placed([0.4, 0.2, 0.9], scene=SCENE, noise=noise, rate_variance=0.0)
    means, couple = new(ContactLoad), rng.uniform(-0.05, 0.05, 3)
    for k in range(121):
        moment = couple * np.sin(2 * np.pi * k * dt / 0.06)
        q, rates = euler_state(axes, spin)
        move(kalman, rates, 0.0, q)
        record = press(kalman, [*(-0.5 * np.array(SCENE.gravity) @ axes), *moment])
        load, _ = carried_load(record, means, dt, 2e-3)
        change = np.linalg.solve(inertia, moment - np.cross(spin, inertia @ spin))
        middle = spin + 0.5 * dt * change
        change = np.linalg.solve(inertia, moment - np.cross(middle, inertia @ middle))
        axes = axes @ Rotation.from_rotvec(dt * middle).as_matrix()
        spin = spin + dt * change
    # The lag of the means is the same on both sides; half a step's is left.
    assert np.linalg.norm(moment) * 2 / SCENE.peg_diameter > 1.0
    assert load < 0.05


def euler_state(axes, spin):
    """Return gamma, psi, phi and their rates from axes and angular velocity in peg axes."""
    zeta = axes[:, 2]
    gamma, psi = np.arccos(zeta[2]), np.arctan2(-zeta[1], -zeta[0])
    flat = peg_axes([gamma, psi, 0.0]).T @ axes
    phi = np.arctan2(flat[1, 0], flat[0, 0])
    eps = np.array([np.sin(psi), -np.cos(psi), 0.0])
    turns = np.column_stack([eps, [0.0, 0.0, 1.0], zeta])
    return [gamma, psi, phi], np.linalg.solve(turns, axes @ spin)


def test_a_rim_pushes_and_does_not_pull():
    kalman = placed([0.1, 0.2, 0.3], scene=SCENE, noise=1e-6, rate_variance=0.0)
    axes = peg_axes(kalman.x[:3])
    for force, counted in ((3.0, 3.0 / FREE_PEG_LOAD.lift), (-3.0, 3.0)):
        total = np.array([0.0, 0.0, force]) - 0.5 * np.array(SCENE.gravity)
        load, _ = carried(kalman, [np.array([*(total @ axes), 0, 0, 0])])
        assert load == pytest.approx(counted, rel=1e-9)


def declare(mode, given, start, duration=0.1):
    """Show probabilities for a while; return when the mode changed last."""
    changed, before = None, mode.mode
    for k in range(round(duration * 1e3) + 1):
        t = start + k * 1e-3
        if mode.update(t, given) != before:
            changed, before = t, mode.mode
    return changed


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, "three_point"),
        ({"three_point": 0.0, "stuck": 0.95}, "three_point"),
        ({"three_point": 0.0, "two_point": 0.95}, "two_point"),
        ({"three_point": 0.0, "free": 0.95}, "open"),
        ({"three_point": 0.0, "opened": 0.5, "other": 0.45}, "unknown"),
        ({"three_point": 0.5, "two_point": 0.45}, "unknown"),
    ],
)
def test_mode_is_the_probable_one(given, expected):
    mode = Mode(OPTIONS)
    declare(mode, PRESSED._replace(**given), 0.0)
    assert mode.mode == expected


def test_a_mode_must_last_for_its_dwell_and_is_kept_between_the_thresholds():
    mode = Mode(OPTIONS)
    inside = PRESSED._replace(three_point=0.0, two_point=0.9)
    changed = declare(mode, PRESSED, 0.0)
    assert changed == pytest.approx(OPTIONS.mode_dwell, abs=1.5e-3)
    declare(mode, inside, 1.0, duration=OPTIONS.mode_dwell - 2e-3)
    assert mode.mode == "three_point"
    # Neither is likely enough: what was declared stays, whichever leads.
    for k in range(200):
        three = 0.45 if k % 2 else 0.5
        mode.update(2.0 + k * 1e-3, PRESSED._replace(three_point=three, two_point=0.9 - three))
    assert mode.mode == "three_point"
    assert declare(mode, inside, 3.0) == pytest.approx(3.0 + OPTIONS.mode_dwell, abs=1.5e-3)
    assert mode.mode == "two_point"


def test_contact_that_comes_and_goes_has_a_time_and_a_latency():
    mode = Mode(OPTIONS)
    free = PRESSED._replace(three_point=0.01, free=0.97)
    doubt = PRESSED._replace(three_point=0.5, free=0.47)
    declare(mode, free, 0.0)
    assert mode.touch is None
    declare(mode, doubt, 0.101, duration=0.004)
    declare(mode, PRESSED, 0.106)
    onset, t, latency = mode.touch
    assert onset
    assert t == pytest.approx(0.1, abs=1.5e-3)
    assert latency == pytest.approx(0.006 + OPTIONS.mode_dwell, abs=3e-3)
    # And goes the same way, a millisecond after the last that was shown.
    declare(mode, doubt, 0.207, duration=0.004)
    declare(mode, free, 0.212)
    onset, t, latency = mode.touch
    assert not onset
    assert t == pytest.approx(0.206, abs=1.5e-3)
    assert latency == pytest.approx(0.006 + OPTIONS.mode_dwell, abs=3e-3)


def test_flag_rises_out_of_contact_above_gamma0_only():
    flag = Flag(OPTIONS)
    assert not flag.update(0.0, 0.99, 0.99)
    assert not flag.update(0.1, 0.0, 0.0)
    assert not flag.update(0.2, 0.99, 0.99)
    assert not flag.update(0.3, 0.01, 0.99)
    assert not flag.update(0.4, 0.85, 0.99)
    assert not flag.update(0.5, 0.99, 0.2)
    assert flag.update(0.6, 0.95, 0.99)


def test_a_peg_that_left_the_rim_has_to_touch_it_again_above_gamma0():
    def after(free, above):
        flag = Flag(OPTIONS)
        flag.update(0.0, 0.0, 1.0)
        for k in range(1, round(free * 1000)):
            flag.update(k * 1e-3, 0.0 if above else 1.0, 0.0)
        # Straightened, it touches in the hole.
        return flag.update(free, 1.0, 1.0), flag

    # A bounce, or a load that is gone on the way through gamma0, is part of a closing.
    assert after(0.15, above=True)[0] and after(3.0, above=False)[0]
    raised, flag = after(3.0, above=True)
    assert not raised
    assert not flag.update(3.1, 0.0, 1.0) and flag.update(3.2, 1.0, 1.0)


def test_a_peg_that_straightens_in_the_air_raises_no_flag():
    stream, flags = message_stream(Configuration()), []
    for k in range(1200):
        t_ns, gamma = 10**9 + k * 1_000_000, 0.1 - 5e-5 * k
        stream.on_joints(joints(t_ns, gamma))
        told = stream.on_wrench(hanging(t_ns, gamma))
        flags += [fields["data"] for suffix, _, fields in told if suffix == "transition"]
    assert flags == [False]


def test_flag_does_not_flicker():
    rng = np.random.default_rng(5)
    flag = Flag(OPTIONS)
    flag.update(0.0, 0.0, 1.0)
    # At gamma0 the probability is anywhere, from one sample to the next.
    seen = [flag.update(k * 1e-3, p, 1.0) for k, p in enumerate(rng.uniform(0, 1, 5000))]
    assert sum(a != b for a, b in zip(seen, seen[1:])) == 1
    hold = OPTIONS.transition_hold
    low = [flag.update(6.0 + k * 1e-3, 0.05, 1.0) for k in range(300)]
    assert low.index(False) * 1e-3 == pytest.approx(hold, abs=2e-3)


def test_dwell_and_thresholds_are_those_of_the_options():
    slow = replace(OPTIONS, mode_dwell=0.05, mode_probability_on=0.97)
    assert declare(Mode(slow), PRESSED, 0.0) is None
    likely = PRESSED._replace(three_point=0.98)
    assert declare(Mode(slow), likely, 0.0) == pytest.approx(0.05, abs=1.5e-3)


def test_a_forecast_knows_no_learnt_clearance_better_than_a_share_of_its_spread():
    motion, rate, gamma0 = begun().motion, -0.16, SCENE.gamma0
    settings = monitor_settings(OPTIONS, SCENE, 0.3)
    for k in range(200):
        gamma = gamma0 + 0.05 + rate * 2e-3 * k / 2
        since, q = 2e-3 if k else -1.0, np.array([gamma, 0, 0])
        follow_motion(motion, since, q, np.eye(3) * 1e-10, settings)
    found = []
    for clearance_stddev in (0.0, 2e-5):
        record = press(placed([gamma, 0.3, 0.1], scene=SCENE), np.zeros(6))
        scene, evidence = replace(SCENE, clearance_stddev=clearance_stddev), begun().evidence
        settings = monitor_settings(OPTIONS, scene, 0.3)
        weigh_wrench(record, evidence, motion, settings, RECENT, -1.0, begun().place, False)
        found.append(evidence.shown)
    by_clearance = 0.05 * 2e-5 / (SCENE.hole_diameter * np.sin(gamma0)) / (-rate / 2)
    more = np.sqrt(found[1].time_stddev ** 2 - found[0].time_stddev ** 2)
    # The speed at gamma0 is that of a trend.
    assert more == pytest.approx(by_clearance, rel=0.05)
    assert found[0].time == found[1].time and found[0].below == found[1].below


def test_what_friction_makes_of_a_reaction_opens_no_contact():
    """Friction is stated two deviations too high: K, light, would pull, at every sample anew."""
    truth = with_noise(truth_of(Motion(1e-4, 0.05, 1.0, "align"))[0], "low", 0.05)
    configuration = truth.plan.configuration
    pipeline = Pipeline(replace(configuration, scene=replace(configuration.scene, friction=0.15)))
    modes = [outputs.contact_mode for outputs in pipeline.play(measure(truth, 1))]
    assert set(modes[30:]) == {"three_point"}


@pytest.mark.parametrize("contact", range(3))
def test_what_is_news_of_a_reaction_is_what_friction_and_clearance_leave(contact):
    estimate = new(Estimate)
    reactions = estimate.reactions
    reactions.covariance[contact, contact] = 4.0
    reactions.by_friction[contact], reactions.by_diameter[contact] = 1.0, np.sqrt(2.0)
    reactions.normal[contact] = -5.9
    assert new_share(estimate, contact) == pytest.approx(0.25)
    # They do not explain a pull of more than three deviations, whatever is stated of them.
    reactions.normal[contact] = -6.1
    assert new_share(estimate, contact) == 1.0
    reactions.normal[contact] = 6.1
    assert new_share(estimate, contact) == pytest.approx(0.25)


def test_what_a_rim_may_wedge_is_never_below_what_it_carries():
    """A tilt beyond a right angle is none, and has no negative sine."""
    loads = []
    for gamma in (0.0, 0.15, 0.5 * np.pi, 4.0, -4.0):
        loads.append(wedged_load(press(placed([gamma, 0.0, 0.0]), np.zeros(6)), 0.2))
    # Gravity alone is carried.
    assert min(loads) == pytest.approx(0.5 * 9.80665 + 0.2, rel=1e-9)
    assert loads[2] == loads[3] and loads[0] == loads[4] > loads[1]


# A sensor 0.18 m from a small peg: 0.3 N of noise are 50 mN m about the mass centre.
LONG = Configuration(
    scene=Scene(
        hole_diameter=0.010,
        peg_diameter=0.00998,
        peg_height=0.030,
        peg_mass=0.020,
        friction=0.12,
    ),
    # Tared, so that what a peg at rest reads from the start on is no zero that nobody has taken.
    wrench=WrenchInput(
        sensor_xyz=(0.002, -0.003, 0.180), force_stddev=0.3, torque_stddev=0.01,
        bias_force_stddev=0.01,
    ),
    joints=JointInput(position_stddev=5e-5),
)  # fmt: skip


def modes_of(load, gamma, seed):
    line = Pipeline(LONG)
    rows = line.play(samples(LONG, [gamma] * 400, load, LONG.scene.friction, seed=seed))
    return np.array([row.contact_mode for row in rows])


@pytest.mark.parametrize("seed", [0, *nightly(1, 2)])
@pytest.mark.parametrize("gamma", [0.02, 0.055])
def test_what_both_walls_carry_is_contact_though_the_net_force_is_small(gamma, seed):
    """15 N at each wall are 3.6 N in sum; a peg that carries nothing stays open."""
    assert (modes_of(15.0, gamma, seed)[50:] == "two_point").all()
    assert (modes_of(0.0, gamma, seed)[50:] == "open").all()


@pytest.mark.parametrize("seed", [0, *nightly(1, 2)])
@pytest.mark.parametrize(("gamma", "loads"), [(0.055, (12.0, 3.0)), (0.02, (12.0, 0.0))])
def test_a_touch_in_the_hole_is_told_soon_by_the_couple_and_by_the_force(gamma, loads, seed):
    """
    A couple beside a force, and a force alone.

    The same 12 N at each wall of a peg as deep as f d are 3 N along the hole and no couple about
    the lowest point: of one that comes from the air that may be a plate.
    """
    carried = np.zeros((400, 2))
    carried[200:] = loads
    modes = modes_of(carried, gamma, seed)
    assert (modes[50:200] == "open").all()
    # 14 ms and the dwell.
    assert (modes[225:] == "two_point").all()


@pytest.mark.parametrize("seed", [0, *nightly(1, 2)])
@pytest.mark.parametrize("tilt", [0.1, 0.2])
def test_a_touch_on_the_rim_is_told_before_it_is_a_press(tilt, seed):
    """A stiff holder comes down to 12 N in 30 ms."""
    turning = [-0.05, 0.0, 1.0]
    down = {"kind": "free", "duration": 0.25, "rates": [0.0, 0.0, 1.0], "offset": [0.0] * 3}
    press = {"kind": "contact", "duration": 0.03, "rates": turning, "offset": [0.0, 0.0, -1.2e-3]}
    tree = {
        "holder": {"stiffness": 1e4, "rotational_stiffness": 30.0},
        "start": {
            "angles": [tilt, 0.0, 0.0],
            "rates": [0.0, 0.0, 1.0],
            "offset": [0.0, 0.0, 1e-3],
        },
        "phases": {"down": down, "press": press, "on": {**press, "duration": 0.1}},
    }
    motion = integrate(plan_from_tree(LONG, tree))
    (touch, _), *_ = motion.events
    rows = list(Pipeline(LONG).play(measure(motion, seed)))
    modes, since = np.array([row.contact_mode for row in rows]), motion.t_ns - touch
    load = np.linalg.norm(motion.contact_force.sum(axis=1)[-1])
    assert load == pytest.approx(12.0, abs=0.5)
    assert (modes[(since > -200_000_000) & (since <= 0)] == "open").all()
    assert (modes[since > 35_000_000] == "three_point").all()


def hangs_upright(seed, count=400, noise=1e-4):
    """Measure a peg that hangs still and upright: its azimuth is that of the noise alone."""
    random, weight = np.random.default_rng(seed), SCENE.peg_mass * 9.80665
    for k in range(count):
        if k % 2 == 0:
            x, y, z = random.normal(0, noise, 3)
            q = (np.hypot(x, y), np.arctan2(-y, -x), z - np.arctan2(-y, -x))
            yield JointSample(k * 1_000_000, ANGLES, q)
        force = random.normal(0, 0.2, 3) + [0.0, 0.0, weight]
        yield WrenchSample(k * 1_000_000, tuple(force), tuple(random.normal(0, 0.005, 3)))


@pytest.mark.parametrize("seed", [0, *nightly(1)])
def test_a_free_peg_that_hangs_upright_touches_nothing(seed):
    """Its azimuth is told to turn by thousands of rad/s, and so would its angular momentum."""
    rows = list(Pipeline(from_parameters({})).play(hangs_upright(seed)))
    assert max(abs(row.state[4]) for row in rows) > 100.0
    assert {row.contact_mode for row in rows[100:]} == {"open"}


def test_a_load_counts_by_the_joint_noise_of_force_and_couple():
    covariance = WrenchReduction(LONG.wrench, LONG.scene).covariance
    kalman = placed((0.05, 0.4, 0.9), scene=LONG.scene, noise=covariance, rate_variance=0.0)
    over = np.array([1.0] * 3 + [2 / LONG.scene.peg_diameter] * 3)
    weight = kalman.scene.peg_mass * 9.80665
    rng = np.random.default_rng(2)
    for _ in range(5):
        wrench = rng.normal(0, 1, 6) * [3, 3, 1, 0.05, 0.05, 0.01] - [0, 0, 5, 0, 0, 0]
        record, means = press(kalman, wrench), new(ContactLoad)
        carried_load(record, means, 1e-3, 5e-3)
        found = stands_out(record, means, 1.0, 5e-3)
        # Gravity is along -z of the hole: in peg axes by the rotation of the frames' definition.
        g, f = np.cos([0.05, 0.9]), np.sin([0.05, 0.9])
        down = np.array([-f[0] * g[1], f[0] * f[1], -g[0]])
        x = over * (wrench + weight * np.array([*down, 0, 0, 0]))
        S = np.eye(6) + 6 * FREE_PEG_LOAD.room * over[:, None] * covariance * over
        assert found == pytest.approx(x @ np.linalg.solve(S, x), rel=1e-6)


def play_closing(change):
    """Modes of a closing whose samples are changed, and the pipeline's counts."""
    scene = truth("closing_with_slip")
    configuration = scene.plan.configuration
    line = Pipeline(
        replace(configuration, wrench=replace(configuration.wrench, adopt_found=False))
    )
    return [row.contact_mode for row in line.play(change(measure(scene, 1)))], line.counts


def test_what_orientations_refute_again_and_again_is_no_mode():
    """Of a wrench in other axes the contacts predict another motion, every 25 ms."""

    def turned(samples):
        for sample in samples:
            if isinstance(sample, WrenchSample):
                (a, b, c), (d, e, f) = sample.force, sample.torque
                sample = sample._replace(force=(b, c, a), torque=(e, f, d))
            yield sample

    modes, counts = play_closing(turned)
    assert counts["filter_restarted"] > 3
    # Until it is refuted for the first time it is believed.
    assert set(modes[50:150]) == {"unknown"}


def test_a_peg_that_was_set_elsewhere_has_its_mode_again_within_a_tenth_of_a_second():
    def without_a_part(samples):
        """From 0.2 s to 0.4 s nothing is recorded, and the clock stands."""
        samples = list(samples)
        begin = samples[0].t_ns + 200_000_000
        for sample in samples:
            if sample.t_ns >= begin + 200_000_000:
                yield sample._replace(t_ns=sample.t_ns - 200_000_000)
            elif sample.t_ns < begin:
                yield sample

    modes, counts = play_closing(without_a_part)
    assert counts["filter_restarted"] == 1
    assert set(modes[100:200]) == {"three_point"} and "unknown" in modes[200:300]
    assert set(modes[300:400]) == {"three_point"}
