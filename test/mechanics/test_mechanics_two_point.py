"""Two-point contact below gamma0 against distances, a free body with two gaps, and both limits."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rigid_body_oracle as oracle
from paper import examples, small_tilt, two_point
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics import geometry, reference
from peg_on_hole_ros.mechanics.scene import Scene

SCENE = Scene(mass_center_height=0.033, axial_inertia=3e-4, gravity=(1.0, 2.0, -9.0))
PAPER = Scene()


def gaps(scene, C, R):
    """Return the distance of the rim from the peg's side, and of the lower edge from the wall."""
    gap_K, _ = oracle.contact_K(scene, C, R)
    end = C - scene.mass_center_height * R[:, 2]
    radius = scene.peg_diameter / 2
    # The edge point farthest from the hole's axis, by Newton's method from the plane of tilt.
    chi = np.arctan2(-R[0, 1].real * R[0, 2].real - R[1, 1].real * R[1, 2].real,
                     -R[0, 0].real * R[0, 2].real - R[1, 0].real * R[1, 2].real)  # fmt: skip
    for _ in range(200):
        p = end + radius * (np.cos(chi) * R[:, 0] + np.sin(chi) * R[:, 1])
        dp = radius * (-np.sin(chi) * R[:, 0] + np.cos(chi) * R[:, 1])
        ddp = end - p
        slope = p[:2] @ dp[:2]
        step = slope / (dp[:2] @ dp[:2] + p[:2] @ ddp[:2])
        chi = chi - step
        if abs(step) < 1e-15:
            break
    p = end + radius * (np.cos(chi) * R[:, 0] + np.sin(chi) * R[:, 1])
    return np.array([gap_K, scene.hole_diameter / 2 - np.sqrt(p[0] ** 2 + p[1] ** 2)]), p


def unit(x):
    return x / np.linalg.norm(x)


def placed(scene, q):
    """Return mass centre and axes of a state (gamma, psi, phi, beta) in hole axes."""
    pose = two_point.two_point_pose(scene, q[0], q[3])
    Rz = oracle.rotation(np.array([0.0, q[1], 0.0]))
    return Rz @ [x.v for x in pose.center], oracle.rotation(np.asarray(q[:3])), pose, Rz


STATES = [
    (0.9, [0.4, -1.0, 0.3], [-0.2, 0.5, 1.5, 0.4]),
    (0.5, [-2.0, 0.3, -0.5], [0.3, -0.7, 0.6, -0.8]),
    (0.97, [1.0, 0.0, 0.02], [-0.1, 0.0, 2.0, 0.1]),
    (0.6, [0.1, 0.2, 0.0], [-0.1, 0.4, -2.0, 0.0]),
]


@pytest.mark.parametrize("share, rest, rates", STATES)
def test_pose_touches_rim_and_wall(share, rest, rates):
    q = np.array([share * SCENE.gamma0, *rest])
    C, R, pose, Rz = placed(SCENE, q)
    found, edge = gaps(SCENE, C, R)
    np.testing.assert_allclose(found, 0, atol=2e-15)
    np.testing.assert_allclose(Rz @ pose.points[1], edge, atol=1e-9)
    K = Rz @ pose.points[0]
    assert np.hypot(K[0], K[1]) == pytest.approx(SCENE.hole_diameter / 2, rel=1e-14)
    local = R.T @ (K - C)
    assert np.hypot(local[0], local[1]) == pytest.approx(SCENE.peg_diameter / 2, rel=1e-13)


@pytest.mark.parametrize("share, rest, rates", STATES)
def test_solution_is_that_of_a_free_body_with_two_gaps(share, rest, rates):
    scene, m = SCENE, SCENE.peg_mass
    q, rates = np.array([share * scene.gamma0, *rest]), np.array(rates)
    wrench_P = np.array([1.0, -2, -5, 0.05, -0.1, 0.02])
    C, R, pose, Rz = placed(scene, q)
    E = oracle.spin_axes(q[:3])
    omega = E @ rates[:3]
    v = oracle.along(lambda t: placed(scene, q + t * rates * 0.01)[0]) * 100
    g_C = oracle.complex_step(lambda x: gaps(scene, x, R)[0], C)

    def turned(C, R):
        def by(w):
            W = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
            return gaps(scene, C + 0j, (np.eye(3) + W) @ R)[0]

        return oracle.complex_step(by, np.zeros(3))

    g_w = turned(C, R)
    # The motion keeps both gaps, and the normals are the gaps' gradients.
    np.testing.assert_allclose(g_C @ v + g_w @ omega, 0, atol=1e-11)
    stretch = np.linalg.norm(g_C, axis=1)
    normal = g_C / stretch[:, None]
    np.testing.assert_allclose(normal, pose.normals @ Rz.T, atol=1e-8)

    def gap_rate(t):
        angle = np.linalg.norm(omega) * t
        k = omega / np.linalg.norm(omega)
        W = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
        R_t = (np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W) @ R
        C_t = C + v * t
        return (
            oracle.complex_step(lambda x: gaps(scene, x, R_t)[0], C_t) @ v
            + turned(C_t, R_t) @ omega
        )

    inertia = R @ np.diag([scene.transverse_inertia] * 2 + [scene.axial_inertia]) @ R.T
    arms = pose.points @ Rz.T - C
    slide = v + np.cross(omega, arms)
    reaction = normal - scene.friction * slide / np.linalg.norm(slide, axis=1)[:, None]
    A = np.zeros((8, 8))
    A[:3, :3], A[3:6, 3:6] = m * np.eye(3), inertia
    A[:3, 6:], A[3:6, 6:] = -reaction.T, -np.cross(arms, reaction).T
    A[6:, :3], A[6:, 3:6] = g_C, g_w
    r = np.concatenate(
        [
            R @ wrench_P[:3] + m * np.array(scene.gravity),
            R @ wrench_P[3:] - np.cross(omega, inertia @ omega),
            -oracle.along(lambda t: gap_rate(t * 0.01)) * 100,
        ]
    )
    y = np.linalg.solve(A, r)
    found = two_point.solve_two_point(scene, q, rates, wrench_P)
    np.testing.assert_allclose(found.normal, y[6:], rtol=2e-6)
    E_dot = oracle.along(lambda t: oracle.spin_axes(q[:3] + t * rates[:3]))
    turning = np.linalg.solve(E, y[3:6] - E_dot @ rates[:3])
    np.testing.assert_allclose(found.acceleration[:3], turning, rtol=1e-6)
    # The mass centre: J q'' and the curvature along q', each by differences of the pose.
    linear = oracle.along(lambda t: placed(scene, q + t * 0.01 * unit(found.acceleration))[0])
    h = 1e-4
    path = [placed(scene, q + t * rates)[0] for t in (-h, 0, h)]
    curved = (path[0] - 2 * path[1] + path[2]) / h**2
    a_C = linear * 100 * np.linalg.norm(found.acceleration) + curved
    # A plain second difference: rounding 1e-17/1e-8, truncation 1e-8 of the change.
    np.testing.assert_allclose(a_C, y[:3], atol=1e-5 * np.max(np.abs(y[:3])))
    assert found.lateral_force == 0.0


def test_held_laterally_the_multiplier_is_the_force_that_holds():
    q, rates = [0.8 * PAPER.gamma0, 0.3, 0.1, 0.0], [-0.16, 0.2, 2.0, 0.0]
    held = two_point.solve_two_point(PAPER, q, rates, np.zeros(6), held=True)
    assert abs(held.lateral_force) > 0.1 and held.acceleration[3] == 0
    # Applied as a wrench at O, it makes the free peg move with beta'' = 0.
    h, _, z = two_point.two_point_pose(PAPER, q[0]).center
    to_O = [-h.v, 0, h.v / np.tan(q[0])]
    force = np.array([0, held.lateral_force, 0])
    R_P = reference.wrench_axes(q[0], q[2]).T
    wrench = np.concatenate([R_P @ force, R_P @ np.cross(to_O, force)])
    free = two_point.solve_two_point(PAPER, q, rates, wrench)
    np.testing.assert_allclose(free.acceleration[:3], held.acceleration[:3], rtol=1e-9)
    np.testing.assert_allclose(free.normal, held.normal, rtol=1e-9)
    assert abs(free.acceleration[3]) < 1e-6
    planar = two_point.solve_two_point(PAPER, q, [-0.16, 0, 0, 0], np.zeros(6), held=True)
    assert abs(planar.lateral_force) < 1e-12


def test_pose_is_smooth_through_gamma0():
    above = geometry.contact_geometry_above(PAPER, 1e-9)
    below = two_point.two_point_pose(PAPER, PAPER.gamma0 - 1e-9)
    h, e, z = below.center
    assert e.v == 0
    for jet, value, first, second in (
        (h, above.h_c, above.dh_c, above.ddh_c),
        (z, above.z_c, above.dz_c, above.ddz_c),
    ):
        assert jet.v == pytest.approx(value, abs=1e-9)
        assert jet.g[0] == pytest.approx(first, rel=1e-6)
        assert jet.h[0, 0] == pytest.approx(second, rel=1e-5)
    # K and the merged B meet from both sides.
    points = geometry.contact_points(above, PAPER.hole_diameter)
    np.testing.assert_allclose(below.points[0], points[0], atol=1e-15)
    np.testing.assert_allclose(below.points[1], points[1] * [1, 0, 1], atol=1e-7)
    assert two_point.insertion_length(PAPER, PAPER.gamma0) == pytest.approx(2 * above.a2, rel=1e-6)


def test_limits_from_both_sides():
    """Closing without slip: K slides one way above gamma0, the other way below, not at gamma0."""
    # Imposed by a couple: force balance alone, as fast motion has its own inertia.
    s0, f = np.sin(PAPER.gamma0), PAPER.friction
    c0, weight = np.cos(PAPER.gamma0), PAPER.peg_mass * 9.80665
    slow = -1e-4
    above = small_tilt.reactions(PAPER, 1e-9, [slow, 0, 0]).K / weight
    assert above == pytest.approx(1 / (s0 * (1 + f**2)), rel=1e-3) == pytest.approx(15.2, abs=0.05)
    below = examples.imposed_two_point(PAPER, PAPER.gamma0 - 1e-9, [slow, 0, 0])[0] / weight
    assert below == pytest.approx(1 / (s0 * (1 - f**2) + 2 * f * c0), rel=1e-3)
    assert below == pytest.approx(2.17, abs=0.01)
    # With slip K slides sideways and the limits meet.
    rates = np.array([slow, 0, 1.0])
    above = small_tilt.reactions(PAPER, 1e-9, rates).K / weight
    below = examples.imposed_two_point(PAPER, PAPER.gamma0 - 1e-9, rates)[0] / weight
    assert above == pytest.approx(below, rel=1e-2)


def test_energy_is_kept_through_the_transition_without_friction():
    scene = Scene(friction=0.0, peg_diameter=0.049)
    couple = -0.4

    def above(t, x):
        # The event is looked for beyond gamma0, where the six equations end.
        x = np.append(max(x[0], scene.gamma0 + 1e-10), x[1:])
        moment = [-couple * np.sin(x[2]), -couple * np.cos(x[2]), 0]
        A, r = reference.six_equations(scene, x[:3], x[3:], [0, 0, 0, *moment], 0.0)
        return np.concatenate([x[3:], np.linalg.solve(A, r)[:3]])

    def below(t, x):
        q, rates = np.append(x[:3], 0.0), np.append(x[3:], 0.0)
        moment = [-couple * np.sin(x[2]), -couple * np.cos(x[2]), 0]
        solution = two_point.solve_two_point(scene, q, rates, [0, 0, 0, *moment], held=True)
        return np.concatenate([x[3:], solution.acceleration[:3]])

    def energy(x, center, slope):
        rates = x[3:]
        v = np.array([slope[0] * rates[0], center[0] * rates[1], slope[1] * rates[0]])
        wP = oracle.rotation(x[:3]).T @ oracle.spin_axes(x[:3]) @ rates
        inertia = [scene.transverse_inertia] * 2 + [scene.axial_inertia]
        kinetic = scene.peg_mass * v @ v / 2 + wP @ (inertia * wP) / 2
        # M . eps does work on gamma alone: eps is square to z and zeta.
        return kinetic + scene.peg_mass * 9.80665 * center[1] - couple * x[0]

    def reaches(t, x):
        return x[0] - scene.gamma0 - 1e-9

    reaches.terminal, options = True, {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}
    start = np.array([0.3, 0.2, 0.0, -0.3, 0.5, 3.0])
    first = solve_ivp(above, (0, 1), start, events=reaches, **options)
    assert first.status == 1
    x = first.y[:, -1].copy()
    x[0] -= 2e-9

    def ends(t, y):
        return y[0] - 0.5 * scene.gamma0

    ends.terminal = True
    second = solve_ivp(below, (0, 1), x, events=ends, **options)
    assert second.status == 1
    g = geometry.contact_geometry(scene, start[0])
    before = energy(start, (g.h_c, g.z_c), (g.dh_c, g.dz_c))
    h, _, z = two_point.two_point_pose(scene, second.y[0, -1]).center
    after = energy(second.y[:, -1], (h.v, z.v), (h.g[0], z.g[0]))
    # 2e-9 rad were stepped over by hand, and rates taken across unchanged.
    assert after == pytest.approx(before, rel=1e-7)


def test_imposed_motion_is_the_free_one_under_the_couple_that_it_needs():
    rates = np.array([-0.16, 0.3, 2.0])
    gamma = 0.9 * PAPER.gamma0
    N_K, N_B, lateral = examples.imposed_two_point(PAPER, gamma, rates)
    columns, q4 = [], [gamma, 0, 0, 0]
    base = two_point.solve_two_point(PAPER, q4, [*rates, 0], np.zeros(6), held=True)
    for k in range(3):
        wrench = np.append(np.zeros(3), np.eye(3)[k])
        one = two_point.solve_two_point(PAPER, q4, [*rates, 0], wrench, held=True)
        columns.append(one.acceleration[:3] - base.acceleration[:3])
    couple = np.linalg.solve(np.array(columns).T, -base.acceleration[:3])
    found = two_point.solve_two_point(
        PAPER, q4, [*rates, 0], np.append(np.zeros(3), couple), held=True
    )
    np.testing.assert_allclose(found.normal, [N_K, N_B], rtol=1e-8)
    assert found.lateral_force == pytest.approx(lateral, rel=1e-8)


@pytest.mark.parametrize(
    "gamma, lateral, message",
    [
        (0.07, 0.0, "gamma = 0.07 rad has no two-point contact"),
        (np.nan, 0.0, "gamma = nan rad has no two-point contact"),
        (-0.01, 0.0, "has no two-point contact"),
        (1e-3, 0.0, "puts K 0.1 m up the peg's side, beyond peg_height = 0.07 m"),
        (0.05, 1.0, "lateral = 1 rad is not within"),
    ],
)
def test_states_without_two_point_contact_are_refused(gamma, lateral, message):
    with pytest.raises(PegOnHoleError, match=message):
        two_point.two_point_pose(PAPER, gamma, lateral)
    with pytest.raises(PegOnHoleError, match="cannot be held"):
        two_point.solve_two_point(PAPER, [0.05, 0, 0, 0.1], np.zeros(4), np.zeros(6), held=True)


def test_energy_is_kept_with_the_lateral_freedom_free():
    scene = Scene(friction=0.0, peg_diameter=0.049, gravity=(0.4, 0.3, -9.5))
    moment = 0.3  # against closing, about e

    def slope(t, x):
        q, rates = x[:4], x[4:]
        to_P = reference.wrench_axes(q[0], q[2]).T
        wrench = np.concatenate([to_P @ [0, 0, -30.0], to_P @ [0, moment, 0]])
        return np.concatenate(
            [rates, two_point.solve_two_point(scene, q, rates, wrench).acceleration]
        )

    def energy(x):
        q, rates = x[:4], x[4:]
        pose = two_point.two_point_pose(scene, q[0], q[3])
        C = np.array([jet.v for jet in pose.center])
        v = np.array([jet.g for jet in pose.center]) @ rates[[0, 3]]
        v = v + rates[1] * np.array([-C[1], C[0], 0])
        wP = oracle.rotation(q[:3]).T @ oracle.spin_axes(q[:3]) @ rates[:3]
        inertia = np.array([scene.transverse_inertia] * 2 + [scene.axial_inertia])
        kinetic = scene.peg_mass * v @ v / 2 + wP @ (inertia * wP) / 2
        C_H = oracle.rotation(np.array([0.0, q[1], 0.0])) @ C
        return kinetic - scene.peg_mass * np.array(scene.gravity) @ C_H + 30 * C[2] + moment * q[0]

    start = np.array([0.75 * scene.gamma0, 0.2, 0.1, 0.1, 0.05, 0.3, 2.0, -0.5])
    run = solve_ivp(slope, (0, 0.01), start, method="DOP853", rtol=1e-10, atol=1e-12)
    assert run.success and np.ptp(run.y[3]) > 0.05
    energies = [energy(x) for x in run.y.T]
    # Against the energy that changes hands, 1e-3 J.
    np.testing.assert_allclose(energies, energies[0], atol=1e-9)
