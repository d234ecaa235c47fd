"""The ladder of models: rungs against their twins, bounds, and the choice among them."""

import numpy as np
import pytest

from peg_on_hole_ros.ladder import domain, reference, rungs
from peg_on_hole_ros.mechanics.kernel import accelerate, scene_scalars, workspace
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.study.problems import balancing_wrench

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
