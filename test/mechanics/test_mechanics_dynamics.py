"""The six equations against three constructions of the same body that share no closed form."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import rigid_body_oracle as oracle
from peg_on_hole_ros.mechanics import geometry, reference
from peg_on_hole_ros.mechanics.scene import Scene
from tiers import nightly

SCENES = {
    "paper": Scene(),
    "wide clearance": Scene(peg_diameter=0.045, friction=0.1),
    "tilted hole, no solid cylinder": Scene(
        mass_center_height=0.05,
        transverse_inertia=4e-4,
        axial_inertia=9e-4,
        gravity=(3.0, -2.0, -9.0),
    ),
    "no friction": Scene(friction=0.0, peg_diameter=0.048),
}


def states(scene, count, seed):
    rng = np.random.default_rng(seed)
    low = 1.15 * scene.gamma0
    for _ in range(count):
        q = np.array([rng.uniform(low, 1.2), *rng.uniform(-3, 3, 2)])
        rates = rng.uniform(-2, 2, 3)
        yield q, rates, rng.uniform(-5, 5, 3), rng.uniform(-0.2, 0.2, 3)


def six(scene, q, rates, force_H, moment_H):
    R = reference.peg_axes(q)
    wrench = np.concatenate([R.T @ force_H, R.T @ moment_H])
    return np.linalg.solve(*reference.six_equations(scene, q, rates, wrench, 0.0))


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize(
    "construction", [oracle.newton_euler, *nightly(oracle.lagrange, oracle.multipliers)]
)
def test_six_equations_equal_an_independent_construction(name, construction):
    scene = SCENES[name]
    for q, rates, force, moment in states(scene, 6, seed=len(name)):
        y = six(scene, q, rates, force, moment)
        z = construction(oracle.Body(scene, q, rates, force, moment))
        for part in (slice(0, 3), slice(3, 6)):
            # 1e-9 of the largest: sixth-order differences keep 1e-11, the 6x6 loses two digits.
            np.testing.assert_allclose(
                z[part], y[part], rtol=0, atol=1e-9 * max(1, np.max(np.abs(y[part])))
            )


def test_states_in_an_array_give_what_each_gives_alone():
    scene = SCENES["tilted hole, no solid cylinder"]
    rows = list(states(scene, 5, seed=3))
    q, rates, force, moment = (np.array(column).T for column in zip(*rows, strict=True))
    wrench = np.concatenate([force, moment])
    A, r = reference.six_equations(scene, q, rates, wrench, 1e-4)
    assert A.shape == (6, 6, 5) and r.shape == (6, 5)
    for k in range(5):
        A_k, r_k = reference.six_equations(scene, q[:, k], rates[:, k], wrench[:, k], 1e-4)
        # Another order of summation, nothing else.
        np.testing.assert_allclose(A[..., k], A_k, rtol=1e-13, atol=1e-15)
        np.testing.assert_allclose(r[:, k], r_k, rtol=1e-13, atol=1e-13)
    # One state against an array of wrenches.
    A, r = reference.six_equations(scene, q[:, 0], rates[:, 0], wrench, 1e-4)
    assert A.shape == (6, 6, 5)


@pytest.mark.nightly
def test_energy_is_kept_for_a_second_without_friction():
    # A spring on the tilt keeps the peg between gamma0 and a level peg; all three angles move.
    scene = Scene(friction=0.0, gravity=(2.0, 1.0, -9.0), axial_inertia=3e-4)
    stiffness, rest = 30.0, 0.5

    def slope(t, x):
        sp, cp = np.sin(x[2]), np.cos(x[2])
        # eps = -e in peg axes is (-sin phi, -cos phi, 0).
        moment_P = -stiffness * (x[0] - rest) * np.array([-sp, -cp, 0])
        A, r = reference.six_equations(scene, x[:3], x[3:], [0, 0, 0, *moment_P], 0.0)
        return np.concatenate([x[3:], np.linalg.solve(A, r)[:3]])

    def energy(x):
        body = oracle.Body(scene, x[:3], x[3:], np.zeros(3), np.zeros(3))
        v = body.dC @ body.rates
        kinetic = scene.peg_mass * v @ v / 2 + body.omega @ body.inertia @ body.omega / 2
        height = -scene.peg_mass * np.array(scene.gravity) @ body.C
        return kinetic + height + stiffness * (x[0] - rest) ** 2 / 2

    start = np.array([0.4, 0.3, -0.2, 0.5, 3.0, 8.0])
    run = solve_ivp(slope, (0, 1), start, method="DOP853", rtol=1e-12, atol=1e-13)
    energies = [energy(x) for x in run.y.T[::20]] + [energy(run.y[:, -1])]
    assert np.ptp(run.y[0]) > 0.02 and abs(run.y[1, -1] - 0.3) > 1
    np.testing.assert_allclose(energies, energies[0], rtol=1e-9)


@given(
    gamma=st.floats(0.0633, 1.5),
    rates=st.tuples(*[st.floats(-20, 20)] * 3),
    normal=st.tuples(*[st.floats(0, 1e3)] * 3),
    scale=st.sampled_from([0.0, 1e-5, 1e-3]),
)
@settings(max_examples=150, deadline=None)
def test_friction_never_feeds_power(gamma, rates, normal, scale):
    scene = Scene()
    A, _ = reference.six_equations(scene, [gamma, 0.2, 0.4], rates, np.zeros(6), scale)
    power = -(A[:3, 3:] @ normal) @ np.array(rates)
    J = geometry.velocity_jacobians(geometry.contact_geometry(scene, gamma), 0.0499, 0.05)
    v = np.linalg.norm(J @ np.array(rates), axis=1)
    expected = -scene.friction * np.sum(normal * v**2 / np.sqrt(v**2 + scale**2 + 1e-300))
    assert power <= 0
    assert power == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_turning_hole_axes_about_the_hole_changes_nothing():
    scene = Scene(gravity=(1.0, -2.0, -9.0))
    for turn in (0.7, 2.9, -1.3):
        Rz = oracle.rotation(np.array([0.0, turn, 0.0]))
        turned = Scene(gravity=tuple(float(x) for x in Rz @ np.array(scene.gravity)))
        for q, rates, force, moment in states(scene, 4, seed=9):
            y = six(scene, q, rates, force, moment)
            z = six(turned, q + [0, turn, 0], rates, Rz @ force, Rz @ moment)
            np.testing.assert_allclose(z, y, rtol=1e-11, atol=1e-10)


def test_a_mirrored_state_exchanges_B1_and_B2():
    scene = Scene(gravity=(1.0, -2.0, -9.0))
    # The mirror at the plane y = 0: vectors lose the sign of y, axial vectors of x and z.
    mirrored = Scene(gravity=(1.0, 2.0, -9.0))
    flip = np.array([1, -1, 1])
    for q, rates, force, moment in states(scene, 6, seed=5):
        y = six(scene, q, rates, force, moment)
        z = six(mirrored, q * [1, -1, -1], rates * [1, -1, -1], force * flip, -moment * flip)
        np.testing.assert_allclose(z, y[[0, 1, 2, 3, 5, 4]] * [1, -1, -1, 1, 1, 1], rtol=1e-10)
