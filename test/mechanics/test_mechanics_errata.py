"""
Each mistake of the print in docs/errata.md: the printed form misses the numeric body, the true one
does not. The body of `rigid_body_oracle` uses none of the package's closed forms.
"""

import re
from pathlib import Path

import numpy as np
import pytest

import rigid_body_oracle as oracle
from paper import printed, small_tilt, velocities
from peg_on_hole_ros.mechanics import geometry, reference
from peg_on_hole_ros.mechanics.any_side import frame_axes
from peg_on_hole_ros.mechanics.scene import Scene
from simulated import ROOT

SCENE = Scene(peg_diameter=0.047)
GAMMA, PSI = 0.5, 0.7
RATES = np.array([0.3, 0.5, 0.9])
CLOSING = RATES * [-1, 1, 1]
NORMAL = np.array([4.0, 5.0, 7.0])


def body(rates=RATES, psi=PSI, gamma=GAMMA, scene=SCENE):
    return oracle.Body(scene, [gamma, psi, 0.2], rates, np.zeros(3), np.zeros(3))


def alone(rate):
    """Return the body moving with one rate, 0 gamma', 1 psi', 2 phi'."""
    return body(np.eye(3)[rate])


def friction_work(one):
    """Return friction's generalised forces over f N, [coordinate, contact]."""
    work = []
    for point, force in zip(one.points, one.friction, strict=True):
        virtual = one.dC + np.cross(one.E.T, point - one.C).T
        work.append(virtual.T @ force / one.scene.friction)
    return np.array(work).T


def test_closing_speed():
    """(10)-(12): the printed velocities are for gamma' = -dgamma/dt; friction feeds energy."""
    tilting = alone(0)
    found = printed.planar_velocities(SCENE, GAMMA, PSI, 1.0)
    np.testing.assert_allclose(found, -tilting.velocity, atol=1e-10)
    # Used with +dgamma/dt, as in the examples, they push friction along with the motion.
    force = -NORMAL[:, None] * found / np.linalg.norm(found, axis=1)[:, None]
    assert np.sum(force * tilting.velocity) > 0.1


def test_sign_within_12():
    """(12), middle expression: -V_Bh cos(psi) with V_Bh of (11) is not the last expression."""
    g = geometry.contact_geometry(SCENE, GAMMA)
    V_Bh = -2 * g.a1
    last = printed.planar_velocities(SCENE, GAMMA, PSI, 1.0)[1, 0]
    assert last == pytest.approx(V_Bh * np.cos(PSI)) and last != pytest.approx(-V_Bh * np.cos(PSI))


def test_slide_velocities():
    """(13) is right; (14) means -e by e; (15) has the sign of V_B2zeta wrong half-way."""
    turning = alone(1)
    np.testing.assert_allclose(
        printed.slide_velocities(SCENE, GAMMA, PSI, 1.0), turning.velocity, atol=1e-10
    )
    Rz = oracle.rotation([0, PSI, 0])
    true = (turning.velocity @ Rz)[1:, :2]
    found = printed.slide_velocities_auxiliary(SCENE, GAMMA, 1.0)
    np.testing.assert_allclose(found * [1, -1], true, atol=1e-10)
    assert np.all(np.abs(found[:, 1] - true[:, 1]) > 0.01)
    zeta = oracle.rotation([GAMMA, PSI, 0])[:, 2]
    along = turning.velocity[2] @ zeta
    assert printed.slide_velocity_B2_zeta(SCENE, GAMMA, 1.0) == pytest.approx(-along, abs=1e-10)


def test_slip_velocities():
    """(18.1 z), (18.2 x, y), middle expressions: sin(psi) for sin(gamma); signs of V_B2h."""
    true = alone(2).velocity[1:]
    found = printed.slip_velocities(SCENE, GAMMA, PSI, 1.0)
    wrong = np.abs(found - true) > 1e-3
    np.testing.assert_array_equal(wrong, [[False, False, True], [True, True, False]])
    np.testing.assert_allclose(
        velocities.contact_velocities(SCENE, [GAMMA, PSI, 0], [0, 0, 1])[1:], true, atol=1e-10
    )


def test_slip_velocities_on_moving_axes():
    """(16), first expressions: the signs of V_B1eps and V_B2eta; the last ones are right."""
    moving = frame_axes("moving", [GAMMA, PSI, 0.2]) @ oracle.rotation([0, PSI, 0]).T
    true = (alone(2).velocity @ moving.T)[1:, :2]
    found = printed.slip_velocities_moving(SCENE, GAMMA, 1.0)
    np.testing.assert_allclose(found * [[-1, 1], [1, -1]], true, atol=1e-10)
    assert np.all(np.abs(true) > 1e-3)


def test_absolute_velocities():
    """(19), what is legible of it: right for the closing speed, the sum of (12), (13), (18)."""
    found = printed.absolute_velocities(SCENE, GAMMA, PSI, CLOSING)
    np.testing.assert_allclose(found, body().velocity[1:, :2], atol=1e-10)


def test_inertia_about_z():
    """Below (5): I_z is not about the hole's axis but about its parallel through C."""
    one = body()
    found = printed.inertia_about_z(SCENE, GAMMA)
    assert found == pytest.approx(one.inertia[2, 2], rel=1e-9)
    about_hole = one.inertia[2, 2] + SCENE.peg_mass * (one.C[0] ** 2 + one.C[1] ** 2)
    assert about_hole > 1.05 * found
    # (6) counts m h_c^2 apart: with what the text says it would be counted twice.
    turning = alone(1)
    v = turning.dC[:, 1]
    true = (SCENE.peg_mass * v @ v + turning.omega @ turning.inertia @ turning.omega) / 2
    assert printed.kinetic_energy(SCENE, GAMMA, [0, 1, 0]) == pytest.approx(true, rel=1e-9)


def test_moving_velocities():
    """(20.2): the sign of S1 psi' at B2."""
    found = printed.moving_velocities(SCENE, GAMMA, CLOSING)
    moving = frame_axes("moving", [GAMMA, PSI, 0.2]) @ oracle.rotation([0, PSI, 0]).T
    true = (body().velocity @ moving.T)[:, :2]
    g = geometry.contact_geometry(SCENE, GAMMA)
    np.testing.assert_allclose(found - true, [[0, 0], [0, 0], [2 * g.S1 * 0.5, 0]], atol=1e-10)


def test_kinetic_energy():
    """(5), (6): the coupling Iz psi' phi' cos(gamma) is missing."""
    one = body()
    v = one.dC @ one.rates
    true = SCENE.peg_mass * v @ v / 2 + one.omega @ one.inertia @ one.omega / 2
    missing = SCENE.axial_inertia * RATES[1] * RATES[2] * np.cos(GAMMA)
    assert true - printed.kinetic_energy(SCENE, GAMMA, RATES) == pytest.approx(missing, rel=1e-8)
    assert missing > 1e-6


def lagrange_left(rates, accelerations):
    """Return the left sides from the numeric energy."""
    one = body(rates)
    frictionless = np.zeros(3)

    def mass(q):
        dC, wE = one.center_jacobian(q), oracle.rotation(q).T @ oracle.spin_axes(q)
        return SCENE.peg_mass * dC.T @ dC + wE.T @ one.inertia_P @ wE

    M_dot = oracle.along(lambda t: mass(one.path(t)))
    for k in range(3):
        frictionless[k] = oracle.along(
            lambda t, k=k: one.rates @ mass(one.q + t * np.eye(3)[k]) @ one.rates / 2
        )
    return mass(one.q) @ accelerations + M_dot @ one.rates - frictionless


def test_left_sides():
    """(7.1)-(7.3), (28.1)-(28.3): psi'^2 term, 2 m h_c h_c' gamma' psi', the couplings of phi."""
    g = geometry.contact_geometry(SCENE, GAMMA)
    m, Iz = SCENE.peg_mass, SCENE.axial_inertia
    acceleration = np.array([2.0, 3.0, 5.0])
    p, y, w = RATES
    missing = lagrange_left(RATES, acceleration) - printed.left_sides(
        SCENE, GAMMA, RATES, acceleration
    )
    stated = [
        -m * (g.h_c - g.ddh_c) * g.dh_c * y**2 + Iz * g.s * y * w,
        2 * m * g.h_c * g.dh_c * p * y + Iz * g.c * acceleration[2] - Iz * g.s * p * w,
        Iz * (g.c * acceleration[1] - g.s * p * y),
    ]
    np.testing.assert_allclose(missing, stated, atol=1e-9)
    assert np.all(np.abs(stated) > 1e-5)


def test_z_force():
    """(23.3): beta for lambda; (28.6): friction without f."""
    one = body(psi=0.0)
    true = NORMAL @ one.reaction[:, 2]
    found = printed.z_force(SCENE, GAMMA, NORMAL, one.friction / SCENE.friction)
    beta = NORMAL @ one.reaction[:, 1]
    assert found["(23.3)"] == pytest.approx(beta, abs=1e-9) and abs(beta - true) > 0.1
    without = true + (1 - SCENE.friction) / SCENE.friction * NORMAL @ one.friction[:, 2]
    assert found["(28.6)"] == pytest.approx(without, abs=1e-9) and abs(without - true) > 0.1


def test_gravity_moment():
    """(24), middle expression: S1 - h_c for S1 + h_c."""
    one = body()
    true = one.dC[:, 0] @ one.force
    g = geometry.contact_geometry(SCENE, GAMMA)
    weight = -SCENE.peg_mass * SCENE.gravity[2]
    assert -weight * (g.S1 + g.h_c) == pytest.approx(true, abs=1e-10)
    assert printed.gravity_moment(SCENE, GAMMA) == pytest.approx(true + 2 * weight * g.h_c)


def test_friction_terms():
    """(27.1), (27.3), m_zeta, (28.1)-(28.3): signs, and a1 for a2; (27.2), m_Ll, m_z are right."""
    one = body()
    speed = np.linalg.norm(one.velocity, axis=1)
    true = friction_work(one) * speed
    found = printed.friction_terms(SCENE, GAMMA, CLOSING)
    right = {
        "moments": [[1, 1, 1], [1, 1, 1], [1, 0, 0]],
        "generalized": [[1, 0, 1], [1, 1, 1], [1, 0, 0]],
        "equations": [[1, 0, 1], [1, 1, 0], [1, 0, 0]],
    }
    for place, expected in right.items():
        close = np.abs(getattr(found, place) - true) < 1e-12
        np.testing.assert_array_equal(close, np.array(expected, bool), err_msg=place)


def test_axis_offset():
    """(29) and its stages (iii), (iv)."""
    scene = Scene()
    for excess in (0.003, 0.02, 0.06, 0.2):
        # From the numeric body: where the peg's axis meets the hole's.
        one = body(gamma=scene.gamma0 + excess, scene=scene)
        zeta = one.R[:, 2]
        true = one.C[2] + np.hypot(one.C[0], one.C[1]) / np.hypot(zeta[0], zeta[1]) * zeta[2] * (
            np.sign(one.C[:2] @ zeta[:2]) * -1
        )
        stated = small_tilt.axis_offset(scene, excess, small_tilt.Stage.MEDIUM)
        # Leading order in gamma: what is left out is of the order of gamma^2.
        assert stated == pytest.approx(true, rel=(scene.gamma0 + excess) ** 2)
        ratio = stated / printed.axis_offset(scene, excess)["(29)"]
        assert ratio == pytest.approx(1 + excess / (2 * scene.gamma0), rel=1e-12)
        assert printed.axis_offset(scene, excess)["(iv)"] != pytest.approx(true, rel=0.2)
    small, larger = small_tilt.Stage.SMALL, small_tilt.Stage.LARGER
    g = geometry.contact_geometry_above(scene, 1e-4)
    assert small_tilt.axis_offset(scene, 1e-4, small) == pytest.approx(g.a1, rel=5e-3)
    thin = Scene(peg_diameter=0.05 - 1e-7)
    g = geometry.contact_geometry_above(thin, 0.1)
    assert small_tilt.axis_offset(thin, 0.1, larger) == pytest.approx(g.a1, rel=0.03)
    assert printed.axis_offset(thin, 0.1)["(iii)"] < 0.05 * g.a1
    exact = small_tilt.axis_offset(scene, 0.7, small_tilt.Stage.LARGE)
    assert exact == geometry.contact_geometry_above(scene, 0.7).a1


def test_small_tilt_geometry():
    """(30): signs of the second derivatives; 2.6.2: gamma0 is sqrt(2 (D - d)/D)."""
    scene = Scene()
    one = body(np.array([1.0, 0, 0]), 0.0, 1.02 * scene.gamma0, scene)
    second = oracle.along(lambda t: one.center_jacobian(one.path(t / 10))[:, 0]) * 10
    h, z = second[0], second[2]
    claimed, stated = printed.small_tilt(scene), small_tilt.geometry_at_gamma0(scene)
    # To leading order: z_c'' also has -H_c, 4 % of D/gamma0.
    assert stated["ddh_c"] == pytest.approx(h, rel=0.2) and claimed["ddh_c"] == -stated["ddh_c"]
    assert stated["ddz_c"] == pytest.approx(z, rel=0.1) and claimed["ddz_c"] == -stated["ddz_c"]
    assert claimed["gamma0"] == pytest.approx(0.002)
    assert np.sqrt(2 * 0.0001 / 0.05) == pytest.approx(scene.gamma0, rel=1e-3)
    g = geometry.contact_geometry_above(scene, 1e-9)
    for name in ("a1", "a2", "S1", "S2", "b", "h_c", "dh_c", "dz_c"):
        assert stated[name] == pytest.approx(getattr(g, name), abs=0.1 * scene.hole_diameter), name


def test_small_tilt_velocities():
    """(33): V_KY, V_BY; (34): V_KY, and cos for sin in V_BX; (35) is right; (36): the modulus."""
    scene, psi = Scene(peg_diameter=0.049999), 0.7
    gamma = scene.gamma0 * (1 + 1e-7)
    wrong = {"(33)": [[0, 1], [0, 1]], "(34)": [[0, 1], [1, 0]]}
    for rate, (name, expected) in zip((1, 2), wrong.items(), strict=True):
        one = body(np.eye(3)[rate], psi, gamma, scene)
        true = one.velocity[:2, :2]
        found = printed.small_tilt_velocities(scene, psi, *np.eye(3)[rate][1:])[name]
        np.testing.assert_array_equal(np.abs(found - true) > 1e-3, np.array(expected, bool))
        stated = small_tilt.velocities(scene, psi, np.eye(3)[rate])[:, :2]
        np.testing.assert_allclose(stated, true, atol=1e-4)
    rates = np.array([-0.3, 0.2, -0.9])
    one = body(rates, psi, gamma, scene)
    np.testing.assert_allclose(
        small_tilt.velocities(scene, psi, rates), one.velocity[:2], atol=1e-4
    )
    speeds = np.linalg.norm(one.velocity[:2], axis=1)
    np.testing.assert_allclose(small_tilt.speeds(scene, rates), speeds, rtol=1e-2)
    found = printed.small_tilt_speeds(scene, rates)
    assert found[0] == pytest.approx(-speeds[0], rel=1e-2) and found[0] < 0


def test_momentum_rates():
    """(37.1), (37.2), (38.1), (38.2): signs; the two lines for y contradict each other."""
    scene, psi = Scene(), 0.7
    rates = np.array([-0.16, 0.5, 0.0])
    one = body(rates, psi, 1.0001 * scene.gamma0, scene)
    dC = oracle.along(lambda t: one.center_jacobian(one.path(t / 100)) @ one.rates) * 100
    true = scene.peg_mass * dC[:2]
    D, H, m = scene.hole_diameter, scene.peg_height, scene.peg_mass
    c, s, p, y = np.cos(psi), np.sin(psi), -0.16, 0.5
    stated = m * np.array([D / 2 * c * p**2 + H * s * p * y, D / 2 * s * p**2 - H * c * p * y])
    # Left out: h_c psi'^2, and gamma0 of the rest.
    np.testing.assert_allclose(stated, true, atol=0.25 * np.max(np.abs(true)))
    found = printed.momentum_rates(scene, psi, rates)
    np.testing.assert_allclose(found[0] - stated[0], -m * D * c * p**2, rtol=1e-9)
    np.testing.assert_allclose(
        found[1] - stated[1], -m * D * s * p**2 + 2 * m * H * c * p * y, rtol=1e-9
    )
    along = printed.momentum_rates(scene, 0.0, rates)
    assert along[1] == pytest.approx(-along[3])


def exact_reactions(scene, excess, rates):
    """Return N of uniform motion under a couple at gamma0 + excess, from the numeric body."""
    one = oracle.Body(scene, [scene.gamma0 + excess, 0, 0], rates, np.zeros(3), np.zeros(3))
    h = 0.02 * excess
    weights = {1: 45, 2: -9, 3: 1}
    second = sum(
        w * (one.center_jacobian(one.path(k * h)) - one.center_jacobian(one.path(-k * h)))
        for k, w in weights.items()
    ) / (60 * h)
    return np.linalg.solve(
        one.reaction.T,
        scene.peg_mass * second @ one.rates - scene.peg_mass * np.array(scene.gravity),
    )


@pytest.mark.parametrize(
    "rates",
    [(-0.16, 0, 0), (-0.16, 0, 2), (-0.16, 0.3, -1), (0.1, 0.2, 0.5), (-0.8, 0, 3)],
)
def test_small_tilt_reactions(rates):
    """(37)-(39): with (N_B1 - N_B2) b kept and K's friction turned as it slides."""
    scene = Scene(peg_diameter=0.04999)
    for excess in (1e-6, 1e-5):
        true = exact_reactions(scene, excess, np.array(rates))
        found = small_tilt.reactions(scene, excess, rates)
        # Leading order: gamma0 is 0.02.
        assert pytest.approx(true[0], rel=0.03) == found.K
        assert found.B_sum == pytest.approx(true[1] + true[2], rel=0.03)
        size = abs(true[1] - true[2])
        assert found.B_difference == pytest.approx(true[1] - true[2], abs=0.07 * size + 0.03)


@pytest.mark.parametrize("turn", [2.0, -2.0])
def test_sign_of_friction_at_K(turn):
    """(37.1), (37.2), (38.2): friction at K without the sign of psi' + phi'."""
    scene = Scene()
    one = body(np.array([-0.16, 0.0, turn]), PSI, scene.gamma0 * (1 + 1e-6), scene)
    true = one.friction[0, :2] / scene.friction
    found = printed.friction_at_K(PSI)
    # Left out near gamma0: what K slides along the peg's axis.
    np.testing.assert_allclose(np.sign(turn) * found, true, atol=1e-2)


def test_difference_of_B1_and_B2_diverges_with_slip():
    scene = Scene()
    found = small_tilt.reactions(scene, np.array([1e-8, 1e-6]), np.array([-0.16, 0, 0.1]))
    # b grows as the square root of the excess.
    assert found.B_difference[0] / found.B_difference[1] == pytest.approx(10, rel=0.05)
    quiet = small_tilt.reactions(scene, 1e-6, [-0.16, 0, 0])
    assert abs(quiet.B_difference) < 1e-9 * quiet.B_sum


def test_numbers_of_the_formula_as_printed():
    scene = Scene()
    weight = scene.peg_mass * 9.80665
    assert printed.reaction(scene, (0.16, 0, 0)) / weight == pytest.approx(3.80, abs=0.005)
    assert printed.reaction(scene, (0.16, 0, 1e6)) / weight == pytest.approx(15.81, abs=0.005)
    assert printed.reaction(scene, (0, 0, 0)) / weight == pytest.approx(15.81, abs=0.005)


def test_limit_at_gamma0_is_not_uniform():
    """(39), pure align: 3.8 m g holds at gamma0 alone; every tilt above gives 15.2 m g."""
    scene = Scene()
    weight = scene.peg_mass * 9.80665
    limit = 1 / (np.sin(scene.gamma0) * (1 + scene.friction**2))
    assert limit == pytest.approx(15.2, abs=0.05)
    inertia = 0.16**2 * 0.05 / scene.gamma0 / 9.80665
    for excess in (1e-7, 1e-5):
        N = exact_reactions(scene, excess, np.array([-0.16, 0, 0]))
        assert N[0] / weight == pytest.approx(limit, rel=2 * inertia + 0.01)
        assert (
            pytest.approx(N[0], rel=0.01) == small_tilt.reactions(scene, excess, [-0.16, 0, 0]).K
        )


def test_the_critical_friction_of_pure_alignment():
    nothing = np.zeros(3)
    found = reference.solve_contact(Scene(), [0.0634, 0, 0], [-0.16, 0, 0], nothing, nothing)
    assert found.critical_friction == pytest.approx(0.1407, abs=5e-5)


def test_every_test_named_in_the_errata_exists():
    text = (ROOT / "docs" / "errata.md").read_text()
    named = set(re.findall(r"`(test_\w+)`", text))
    sources = "".join(path.read_text() for path in Path(__file__).parent.glob("test_mech*.py"))
    assert len(named) > 12
    for name in named:
        assert f"def {name}(" in sources, name
