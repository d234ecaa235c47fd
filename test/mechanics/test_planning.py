"""The motion that does not jam: loads by another way, what a plan keeps, advice from a state."""

from dataclasses import replace

import numpy as np
import pytest

import rigid_body_oracle as oracle
from benchmarks.plans import Drawn, foreseen, simulated
from paper.wedging import wedging
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.planning.cell import Cell
from peg_on_hole_ros.mechanics.planning.holder_lag import followed
from peg_on_hole_ros.mechanics.planning.load_profile import profile
from peg_on_hole_ros.mechanics.planning.motion import motion_of, path_of
from peg_on_hole_ros.mechanics.planning.outlook import Cause
from peg_on_hole_ros.mechanics.planning.search import judge, kept, plan_motion, remedies
from peg_on_hole_ros.mechanics.planning.spread import probability_below, quantile, spread_of
from peg_on_hole_ros.mechanics.planning.steady import steady_loads
from peg_on_hole_ros.mechanics.planning.words import advice, as_data, in_words
from peg_on_hole_ros.mechanics.scene import Scene

SCENE, CELL = Scene(friction_stddev=0.03), Cell()
LIMITS = (200.0, 200.0, 200.0)
KNOWN = replace(SCENE, friction_stddev=0.0)


@pytest.mark.parametrize("rates", [(-0.16, 0.0, 0.0), (-0.16, 0.0, 2.0), (-0.16, 0.4, 0.3)])
def test_a_steady_motion_is_balanced_by_its_reactions_and_its_spring(rates):
    gamma = 0.12
    found = steady_loads(SCENE, CELL, np.array([gamma]), rates, [SCENE.friction])
    normal, lag = found.normal[:, 0, 0], found.lag[:, 0, 0]
    weight = -SCENE.peg_mass * np.array(SCENE.gravity)
    # The numeric body at the true pose, and one at the commanded pose.
    body = oracle.Body(SCENE, [gamma, 0, 0], rates, np.zeros(3), np.zeros(3))
    led = oracle.Body(SCENE, np.array([gamma, 0, 0]) + lag, rates, np.zeros(3), np.zeros(3))
    reach = CELL.grip_height - SCENE.mass_center_height
    grip, led_grip = (x.C + reach * x.R[:, 2] for x in (body, led))
    force = np.array(CELL.press) + CELL.stiffness * (led_grip - grip)
    turn = led.R @ body.R.T
    spin = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    moment = CELL.rotational_stiffness * spin / 2 + np.cross(grip - body.C, force)
    moved = oracle.Body(SCENE, [gamma, 0, 0], rates, force + weight, moment)
    accelerations, reactions = np.split(oracle.newton_euler(moved), 2)
    # Linear in the lag, 1e-3 rad of it: of second order are 1e-3 of the loads.
    np.testing.assert_allclose(reactions, normal, rtol=3e-3)
    # What is left turns the peg by less than a thousandth of the moment.
    left = SCENE.transverse_inertia * np.max(np.abs(accelerations))
    assert left < 1e-3 * np.linalg.norm(moment)
    assert found.torque[0, 0] == pytest.approx(np.linalg.norm(moment), rel=0.01)
    assert found.force[0, 0] == pytest.approx(np.linalg.norm(force + weight), rel=0.01)


def test_the_determinant_is_that_of_the_six_equations():
    for gamma, rates in (
        (0.0645, (-0.16, 0.0, 0.0)),
        (0.0645, (-0.16, 0.0, 0.3)),
        (0.2, (-1, 0, 0)),
    ):
        found = steady_loads(SCENE, CELL, np.array([gamma]), rates, [0.1, 0.2])
        for k, friction in enumerate((0.1, 0.2)):
            true = wedging(replace(SCENE, friction=friction), [gamma, 0, 0], rates).determinant
            assert found.determinant[k, 0] == pytest.approx(true, rel=1e-6, abs=1e-9)


def test_probabilities_and_quantiles_of_a_known_margin():
    rng = np.random.default_rng(1)
    scene = replace(SCENE, clearance_stddev=5e-6)
    spread = spread_of(scene)
    clearance = np.array([s.hole_diameter - s.peg_diameter for s in spread.scenes])

    def margin(friction, gap):
        return 0.24 - friction + 300 * (gap - 1e-4)

    values = margin(spread.frictions[None, :], clearance[:, None])
    drawn = margin(rng.normal(0.2, 0.03, 400_000), rng.normal(1e-4, 5e-6, 400_000))
    assert probability_below(spread, values) == pytest.approx(np.mean(drawn < 0), abs=0.003)
    assert quantile(spread, values, 0.95) == pytest.approx(np.quantile(drawn, 0.95), abs=0.01)


@pytest.fixture(scope="module")
def plan():
    return plan_motion(SCENE, CELL, LIMITS)


def test_a_plan_keeps_its_limits_where_plain_closing_does_not(plan):
    assert plan.possible
    assert plan.outlook.wedge <= CELL.wedge_probability
    assert plan.outlook.overload <= CELL.overload_probability
    assert max(plan.outlook.peak_high) < 200 and plan.outlook.least_determinant > 0.5
    assert plan.plain_outlook.wedge > 0.5 and plan.plain_outlook.overload > 0.9
    assert plan.plain_outlook.expected is Cause.K
    # The stages follow each other down to gamma0, within the rates allowed.
    assert plan.motion.stages[-1].tilt == pytest.approx(SCENE.gamma0)
    tilt, rates = plan.motion.start_tilt, np.zeros(3)
    for stage in plan.motion.stages:
        mean = (rates[0] + stage.rates[0]) / 2
        assert stage.tilt == pytest.approx(tilt + mean * stage.duration)
        change = np.abs(np.array(stage.rates) - rates).max()
        assert 1.5 * change <= CELL.max_acceleration * stage.duration + 1e-9
        assert -CELL.max_closing_rate <= stage.rates[0] <= -CELL.min_closing_rate
        assert 0 <= stage.rates[2] <= CELL.max_slip_rate and stage.rates[1] == 0
        tilt, rates = stage.tilt, np.array(stage.rates)


def test_the_aim_is_what_is_least():
    # With little slip allowed fast closing and little turning exclude each other.
    cell = replace(CELL, max_slip_rate=0.03)
    fast, still = (
        plan_motion(SCENE, replace(cell, aim=aim), LIMITS) for aim in ("time", "turning")
    )
    assert fast.possible and still.possible
    assert fast.motion.duration <= still.motion.duration + 1e-9
    assert still.motion.turning <= fast.motion.turning + 1e-9
    roomy = plan_motion(SCENE, CELL, (1e4,) * 3)
    assert roomy.possible and roomy.motion.turning < fast.motion.turning


def test_no_turning_where_none_is_needed():
    scene = Scene(friction=0.05, friction_stddev=0.005)
    found = plan_motion(scene, CELL, (1e4,) * 3)
    assert found.possible and found.motion.turn_tilt is None and found.motion.turning == 0
    assert "No turning is needed." in in_words(found, CELL, (1e4,) * 3)


def test_slide_takes_the_place_of_slip_where_that_is_not_allowed():
    cell = replace(CELL, max_slip_rate=0.0, max_slide_rate=1.0)
    found = plan_motion(SCENE, cell, LIMITS)
    assert found.possible
    closing, slide, slip = found.motion.stages[-1].rates
    assert slide > 0 and slip == 0


WOULD_DO = ("push with at most 40% of plan.press",)


@pytest.mark.nightly
def test_what_would_do_is_found_and_does():
    assert remedies(SCENE, CELL, (80.0,) * 3) == WOULD_DO
    lighter = replace(CELL, press=tuple(0.4 * x for x in CELL.press))
    assert plan_motion(SCENE, lighter, (80.0,) * 3).possible


def test_an_impossible_plan_is_an_answer_with_what_would_do():
    found, would = plan_motion(SCENE, CELL, (80.0,) * 3), WOULD_DO
    assert not found.possible and found.outlook.overload > 0.5
    text = in_words(found, CELL, (80.0,) * 3, would)
    assert text.startswith("No motion within these limits is safe; the nearest is this one.")
    assert text.endswith(
        "Each of these changes makes a motion possible: push with at most 40% of plan.press."
    )
    assert as_data(found, CELL, would)["remedies"] == list(would)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("friction", "limit"), [(0.2, 1e4), (0.26, 200.0), (0.2, 200.0), (0.15, 200.0)]
)
def test_simulated_a_plan_goes_through_and_plain_closing_does_not(friction, limit):
    """The holder leads a peg over rigid contacts; friction is off by up to two deviations."""
    limits = (limit,) * 3
    plan = plan_motion(SCENE, CELL, limits)
    drawn = Drawn(SCENE, CELL, limits, replace(KNOWN, friction=friction))
    came = simulated(drawn, plan.motion)
    assert came.outcome == "through" and np.all(came.peak < limits)
    said, tilt = foreseen(drawn, plan.plain)
    came = simulated(drawn, plan.plain)
    assert came.outcome == said == ("overload" if limit == 200 else "wedge")
    assert came.tilt == pytest.approx(tilt, abs=1e-3)


def test_loads_foreseen_are_those_simulated():
    plan = plan_motion(SCENE, CELL, LIMITS)
    drawn = Drawn(SCENE, CELL, LIMITS, KNOWN)
    came = simulated(drawn, plan.motion)
    ahead = judge(KNOWN, CELL, LIMITS, plan.motion)
    # A peg that is led has no ramps but these; at B the last millirad runs into the transition.
    assert came.peak[0] == pytest.approx(ahead.peak[0], rel=0.03)
    assert max(came.peak[1:]) == pytest.approx(max(ahead.peak[1:]), rel=0.05)


@pytest.mark.nightly
def test_a_soft_holder_takes_up_the_turn_at_first(plan):
    soft = replace(CELL, rotational_stiffness=600.0)
    stiff, wound = (judge(KNOWN, cell, LIMITS, plan.motion).peak[0] for cell in (CELL, soft))
    assert wound > 1.02 * stiff
    came = simulated(Drawn(SCENE, soft, LIMITS, KNOWN), plan.motion)
    assert came.outcome == "through" and came.peak[0] == pytest.approx(wound, rel=0.02)
    # Softer still, what turns the stiff holder's peg in time comes too late.
    late = replace(CELL, rotational_stiffness=200.0)
    assert judge(KNOWN, late, LIMITS, plan.motion).expected is not None
    assert simulated(Drawn(SCENE, late, LIMITS, KNOWN), plan.motion).outcome != "through"


def test_what_is_wound_up_and_turned_together_is_what_was_commanded():
    """From the first of a turn on, and with the loads that its rates have by themselves."""
    cell = replace(CELL, rotational_stiffness=600.0)
    legs = [((-0.2, 0.0, 0.0), 0.14), ((-0.2, 0.0, 1.0), KNOWN.gamma0)]
    motion = motion_of(0.2, (0, 0, 0), legs, KNOWN.gamma0, cell.max_acceleration)
    path = path_of(motion, KNOWN.gamma0)
    path = type(path)(*(part[..., path.gamma > KNOWN.gamma0 + 2e-3] for part in path))
    loads, rates = followed(KNOWN, cell, path, path.gamma, np.array([KNOWN.friction]))
    direct = steady_loads(KNOWN, cell, path.gamma, rates[:, 0], [KNOWN.friction])
    np.testing.assert_allclose(loads.normal[:, 0], direct.normal[:, 0], rtol=0.03)
    lag = direct.lag[1:, 0].sum(axis=0)
    behind = (path.rates[1:] - rates[1:, 0]).sum(axis=0)[1:] @ np.diff(path.time)
    assert np.ptp(lag) > 2e-3
    assert behind == pytest.approx(lag[-1] - lag[0], abs=0.04 * np.ptp(lag))


@pytest.mark.nightly
def test_a_turn_too_slow_chatters_where_one_not_much_faster_does_not():
    """The determinant stays far above 0 in both: it is the motion's steadiness that is lost."""
    limits, known = (1e5,) * 3, KNOWN
    outcomes = {}
    for slip in (0.046, 0.1):
        legs = [((-0.2, 0.0, 0.0), 0.1), ((-0.2, 0.0, slip), known.gamma0)]
        motion = motion_of(0.2, (0, 0, 0), legs, known.gamma0, CELL.max_acceleration)
        ahead = judge(known, CELL, limits, motion)
        assert ahead.least_determinant > 0.5
        came = simulated(Drawn(known, CELL, limits, known), motion)
        outcomes[slip] = ahead.expected, came
    assert outcomes[0.1][0] is None and outcomes[0.1][1].outcome == "through"
    assert outcomes[0.046][0] is Cause.CHATTERS
    # It hammers on its contacts: several times the load, until one of them parts.
    assert outcomes[0.046][1].outcome != "through"
    assert outcomes[0.046][1].peak[0] > 3 * outcomes[0.1][1].peak[0]


def test_a_profile_ends_where_three_point_contact_does(plan):
    found = profile(SCENE, CELL, LIMITS, plan.motion)
    assert np.all(np.diff(found.gamma) < 0) and found.gamma[0] < CELL.start_tilt
    assert found.gamma[-1] - SCENE.gamma0 < 2e-3
    inner = slice(None, -1)
    assert np.all(found.low[0, inner] <= found.normal[0, inner])
    assert np.all(found.normal[0, inner] <= found.high[0, inner])
    assert np.all(found.least[inner] <= found.determinant[inner])


def test_advice_from_a_present_state():
    scene = Scene(friction_stddev=0.01)
    safe = advice(Scene(friction=0.05, friction_stddev=0.005), CELL, (1e4,) * 3, 0.1, [-0.1, 0, 0])
    assert safe.startswith("continue this motion and do not push harder, so that the load at ")
    turn = advice(scene, CELL, LIMITS, 0.1, [-0.16, 0, 0])
    rate, load = turn.split()[2], turn.split()[-2]
    assert turn == f"turn at {rate} rad/s, so that the load at K stays under {load} N"
    assert float(load) <= 200
    # What it says holds: the same closing with that turn, judged anew.
    legs = [((-0.16, 0, float(rate)), scene.gamma0)]
    again = motion_of(0.1, (-0.16, 0, 0), legs, scene.gamma0, CELL.max_acceleration)
    ahead = judge(scene, CELL, LIMITS, again)
    assert kept(ahead, CELL) and ahead.peak_high[0] <= float(load)
    lighter = advice(scene, CELL, (100.0,) * 3, 0.08, [-0.16, 0, 0])
    assert lighter.startswith("push with at most ")
    none = advice(scene, CELL, (3.0,) * 3, 0.07, [-0.16, 0, 0])
    assert none.startswith(
        "lift the peg off, as no turning up to 2 rad/s keeps the limits (overload "
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"aim": "speed"}, "plan.aim = 'speed' is not one of time, turning"),
        (
            {"min_closing_rate": 0.3},
            "plan.min_closing_rate = 0.3 rad/s is above plan.max_closing_rate = 0.2 rad/s",
        ),
        ({"start_tilt": 0.05}, "plan.start_tilt = 0.05 rad is not between gamma0 = 0.0632561 rad"),
    ],
)
def test_a_cell_that_contradicts_itself_is_refused(change, message):
    with pytest.raises(PegOnHoleError, match=message.replace(".", r"\.")):
        plan_motion(SCENE, replace(CELL, **change), LIMITS)


def test_a_present_tilt_in_the_hole_is_refused():
    with pytest.raises(PegOnHoleError, match=r"^gamma = 0\.06 rad is not between gamma0"):
        advice(SCENE, CELL, LIMITS, 0.06, [-0.1, 0, 0])
