"""The ladder of models: rungs against their twins, bounds, and the choice among them."""

import numpy as np
import pytest
from peg_on_hole_ros.ladder import choice, domain, reference, rungs
from scipy.interpolate import CubicSpline

import ladder
from ladder_run import score
from ladder_scenes import INTERVAL, SAMPLES, draw
from peg_on_hole_ros.mechanics.kernel import accelerate, scene_scalars, workspace
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.study.problems import Problem, balancing_wrench, by_scipy

SCALE = 2e-5
SCENES = [
    Scene(gravity=(0.5, -0.3, -9.7)),
    Scene(hole_diameter=0.02, peg_diameter=0.0199, peg_height=0.05, peg_mass=0.2, friction=0.4),
]


def random_states(scene, seed, count):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        q = np.array([scene.gamma0 * (1 + 10 ** rng.uniform(-2, 0.5)), *rng.uniform(-3, 3, 2)])
        rates = rng.normal(size=3) * 10 ** rng.uniform(-2, 0.3)
        yield q, rates, np.concatenate([20 * rng.normal(size=3), 0.5 * rng.normal(size=3)])


def compiled(rung, scene, q, rates, u):
    y = np.zeros(6)
    x, scales = np.concatenate([q, rates]), np.full(3, SCALE)
    rungs.answer(rungs.RUNGS.index(rung), scene_scalars(scene), scales, x, u, workspace(), y)
    return y


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("rung", rungs.RUNGS)
def test_compiled_rungs_are_their_numpy_twins(rung, scene):
    # The tilt's distance from gamma0 and matrices near singular cost up to four digits.
    opened = 0
    for q, rates, u in random_states(scene, 1, 60):
        expected = reference.answer(rung, scene, q, rates, u, SCALE)
        found = compiled(rung, scene, q, rates, u)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
        opened += rung == "modes" and expected[3:].min() == 0
    assert rung != "modes" or opened > 10


def wrench_for(scene, q, rates, acceleration, normal=(40.0, 25.0, 30.0)):
    return balancing_wrench(scene, np.concatenate([q, rates]), normal, acceleration, SCALE)


@pytest.mark.parametrize(
    ("rung", "rates", "acceleration"),
    [
        ("align", (-0.16, 0.0, 0.0), (20.0, 0.0, 0.0)),
        ("align_slip", (-0.16, 0.0, 2.0), (20.0, 0.0, -30.0)),
        ("quasi_static", (-1e-3, 0.01, 0.02), (0.0, 0.0, 0.0)),
    ],
)
def test_a_rung_is_the_full_model_where_nothing_is_left_out(rung, rates, acceleration):
    scene, q, rates = SCENES[1], np.array([0.13, 0.3, -1.1]), np.array(rates)
    # Pushed aside, a peg held by gamma alone needs B1 and B2 alike to be kept from turning.
    normal = (40.0, 25.0, 25.0) if rung == "align" else (40.0, 25.0, 30.0)
    u = wrench_for(scene, q, rates, acceleration, normal)
    found = compiled(rung, scene, q, rates, u)
    # Of the velocity terms 1e-3 rad/s leave 1e-8 N.
    np.testing.assert_allclose(found[3:], normal, rtol=1e-7)
    np.testing.assert_allclose(found[:3], acceleration, rtol=1e-7, atol=1e-7)


def test_the_small_angle_form_errs_by_no_less_than_the_square_of_the_tilt():
    errors = []
    for part in (1.0, 0.5, 0.25):
        gamma0 = 0.2 * part
        scene = Scene(hole_diameter=0.05, peg_diameter=0.05 * np.cos(gamma0), friction=0.3)
        off = []
        for slip in (-1.0, -0.1, 0.0, 0.2, 0.5):
            q, rates = np.array([1.3 * gamma0, 0.2, 0.5]), np.array([-0.1, 0.2, slip])
            u = wrench_for(scene, q, rates, (0.0, 0.0, 0.0))
            off.append(
                compiled("small_angle", scene, q, rates, u)[3:]
                - compiled("quasi_static", scene, q, rates, u)[3:]
            )
        errors.append(np.sqrt(np.mean(np.square(off))))
    assert errors[0] < 0.05 * 40
    # The powers above the square are felt at the first; a term of first order would leave 1.
    orders = np.log2(errors[:2]) - np.log2(errors[1:])
    assert np.all(orders > 1.8), orders


def test_bounds_hold_and_say_something():
    rng, sharp, held = np.random.default_rng(5), {}, {}
    y, scales, work = np.zeros(6), np.full(3, SCALE), workspace()
    for _ in range(400):
        scene = Scene(friction=float(rng.uniform(0.02, 0.5)), peg_mass=float(rng.uniform(0.2, 5)))
        q = np.array([scene.gamma0 * (1 + 10 ** rng.uniform(-1.5, 0.6)), *rng.uniform(-3, 3, 2)])
        rates = np.array([-1, *rng.normal(size=2)]) * 10 ** rng.uniform(-2.5, 0.2, 3)
        normal = 50 * 10 ** rng.uniform(-1, 0, 3)
        u = wrench_for(scene, q, rates, rng.normal(size=3) * 10 ** rng.uniform(-1, 1.5), normal)
        x, p = np.concatenate([q, rates]), scene_scalars(scene)
        margin = accelerate(p, scales, x, u, work, y)
        n = domain.numbers(p, scales, x, y, margin)
        gain = domain.gain(scene, q, rates, SCALE)
        for rung in range(rungs.DYNAMIC):
            if not domain.in_domain(rung, n):
                continue
            found = compiled(rungs.RUNGS[rung], scene, q, rates, u)[3:]
            error = np.abs(found - normal).max() / normal.max()
            ratio = domain.bound(rung, n, scene.friction, gain) / error
            held.setdefault(rung, []).append(ratio >= 1 - 1e-6)
            sharp.setdefault(rung, []).append(ratio)
    assert all(len(held[rung]) > 30 for rung in range(4)), {r: len(v) for r, v in held.items()}
    assert np.mean(held[rungs.SMALL_ANGLE]) > 0.97
    assert all(all(held[rung]) for rung in (1, 2, 3)), {r: np.mean(v) for r, v in held.items()}
    # A bound a hundred times too large would choose nothing.
    assert np.median(sharp[rungs.QUASI_STATIC]) < 5
    assert np.median(sharp[rungs.ALIGN]) < 20


def decided(scene, q, rates, u, tolerance, asked=choice.AUTO):
    memory = choice.new_choice(tolerance, asked)
    x, y = np.concatenate([q, rates]), np.zeros(6)
    used = choice.answer_by_choice(
        memory, scene_scalars(scene), np.full(3, SCALE), x, u, workspace(), y
    )
    return rungs.RUNGS[used], choice.explained(memory), y


def test_the_choice_is_the_cheapest_that_does_and_says_why_in_one_line():
    scene, rates = SCENES[0], np.array([-0.16, 0.1, 1.0])
    q = np.array([1.5 * scene.gamma0, 0.2, 0.3])
    held = wrench_for(scene, q, rates, (0.0, 0.0, 0.0))
    shaken = wrench_for(scene, q, rates, (150.0, 0.0, 0.0))
    name, line, y = decided(scene, q, rates, held, 0.05)
    assert name == "small_angle" and line.startswith("small_angle: error ")
    assert np.abs(y[3:] - (40.0, 25.0, 30.0)).max() < 0.05 * 40
    name, line, _ = decided(scene, q, rates, held, 0.003)
    assert name == "quasi_static" and "; small_angle " in line
    name, line, y = decided(scene, q, rates, shaken, 0.003)
    assert name == "modes" and "no cheaper one is sure to keep to 0.30%" in line
    np.testing.assert_allclose(y[3:], (40.0, 25.0, 30.0), rtol=1e-9)
    name, line, _ = decided(scene, q, rates, shaken, 0.003, rungs.ALIGN_SLIP)
    assert name == "align_slip" and line.startswith("align_slip: asked for; error ")
    assert "\n" not in line and "inertia " in line and "margin " in line


def test_a_contact_about_to_open_is_left_to_the_full_model():
    scene, rates = SCENES[0], np.array([-0.16, 0.1, 1.0])
    q = np.array([1.5 * scene.gamma0, 0.2, 0.3])
    u = wrench_for(scene, q, rates, (0.0, 0.0, 0.0), (40.0, 25.0, -5.0))
    name, _, y = decided(scene, q, rates, u, 0.5)
    assert name == "modes" and y[5] == 0 < y[3]


def test_truth_of_a_scene_is_that_of_another_integrator():
    scene = next(s for s in (draw(11, i) for i in range(20)) if len(s.states) == SAMPLES + 1)
    t = INTERVAL * np.arange(SAMPLES + 1)
    spline = CubicSpline(t, scene.wrenches)
    cubics = np.ascontiguousarray(np.transpose(spline.c[::-1], (1, 0, 2)))
    count = 40
    problem = Problem(
        scene.p, np.full(3, SCALE), cubics, INTERVAL, 0.0, scene.states[0], count * INTERVAL
    )
    found = by_scipy(problem, "Radau", 1e-9).state
    # Reactions agree to 1e-4 in the scene; angles and rates are smoother than they.
    np.testing.assert_allclose(found, scene.states[count], rtol=1e-5, atol=1e-7)


def test_the_benchmark_in_small():
    rows = [score((11, index)) for index in range(6)]
    assert all(row["auto"] <= row["tolerance"] for row in rows)
    assert all(sum(row["used"]) == row["samples"] for row in rows)
    # Not the full model throughout, and not one alone.
    used = np.sum([row["used"] for row in rows], axis=0)
    assert np.count_nonzero(used) >= 2 and used[rungs.MODES] < 0.7 * used.sum()
    again = score((11, 2))
    assert {k: again[k] for k in ("errors", "auto", "used")} == {
        k: rows[2][k] for k in ("errors", "auto", "used")
    }
    text = ladder.summary(rows)
    assert "auto within its tolerance: 6 of 6" in text and "| `quasi_static` |" in text
