"""Closed-form geometry against distances of analytic cylinders, numeric kinematics and mpmath."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rigid_body_oracle as oracle
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics import geometry
from peg_on_hole_ros.mechanics.scene import Scene
from tiers import at_push

scenes = st.builds(
    lambda D, gap, H, height: Scene(
        hole_diameter=D,
        peg_diameter=D * (1 - gap),
        peg_height=H,
        mass_center_height=height * H,
    ),
    st.floats(0.001, 0.5),
    st.floats(1e-4, 0.1),
    st.floats(0.01, 0.3),
    st.floats(0.2, 0.8),
)
# Of the way from gamma0 to a level peg.
shares = st.floats(0.001, 0.95)


def tilt(scene, share):
    return scene.gamma0 + share * (np.pi / 2 - scene.gamma0)


@given(scenes, shares)
@settings(max_examples=100, deadline=None)
def test_contact_velocities_have_no_normal_part(scene, share):
    g = geometry.contact_geometry(scene, tilt(scene, share))
    J = geometry.velocity_jacobians(g, scene.peg_diameter, scene.hole_diameter)
    n = geometry.normals(g)
    speeds = np.einsum("ic,icj->ij", n, J)
    assert np.max(np.abs(speeds)) <= 1e-12
    assert np.max(np.abs(speeds)) <= 1e-14 * np.max(np.abs(J)) * 10
    np.testing.assert_allclose(np.linalg.norm(n, axis=1), 1, rtol=1e-14)


@given(scenes, shares)
@settings(max_examples=60, deadline=None)
def test_peg_touches_the_rim_in_three_points_and_is_nowhere_inside(scene, share):
    gamma = tilt(scene, share)
    g = geometry.contact_geometry(scene, gamma)
    D, radius, tol = scene.hole_diameter, scene.peg_diameter / 2, 1e-12
    R = oracle.rotation(np.array([gamma, 0.0, 0.0]))
    C = np.array([g.h_c, 0.0, g.z_c])
    end = C - scene.mass_center_height * R[:, 2]
    points = geometry.contact_points(g, D)

    def inside_peg(p):
        """Return how deep points lie within the (upwards endless) solid peg [m]."""
        local = (p - end) @ R
        return np.minimum(radius - np.hypot(local[..., 0], local[..., 1]), local[..., 2])

    # The three points lie on the rim and on the peg's surface.
    np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), D / 2, rtol=1e-13)
    assert np.all(points[:, 2] == 0)
    assert np.max(np.abs(inside_peg(points))) < tol
    local = (points - end) @ R
    assert local[0, 2] > 0 and np.all(np.abs(local[1:, 2]) < tol)
    # The rim lies nowhere inside the peg.
    theta = np.concatenate(
        [np.linspace(0, 2 * np.pi, 4001), np.arctan2(g.b, g.S1) + np.linspace(-1e-3, 1e-3, 801)]
    )
    rim = np.stack([D / 2 * np.cos(theta), D / 2 * np.sin(theta), 0 * theta], axis=-1)
    assert np.max(inside_peg(rim)) < tol
    # What of the peg's lower edge lies below the rim stays within the hole.
    chi = np.linspace(0, 2 * np.pi, 4001)
    edge = end + radius * (np.outer(np.cos(chi), R[:, 0]) + np.outer(np.sin(chi), R[:, 1]))
    below = edge[edge[:, 2] < -tol]
    assert np.max(np.hypot(below[:, 0], below[:, 1]), initial=0) < D / 2 + tol
    # And the peg's side, cut at depths below the rim.
    for share_up in (0.02, 0.1, 0.5):
        ring = edge + share_up * (scene.peg_height * R[:, 2])
        below = ring[ring[:, 2] < -tol]
        assert np.max(np.hypot(below[:, 0], below[:, 1]), initial=0) < D / 2 + tol


def test_pose_contacts_normals_and_velocities_equal_the_numeric_body():
    scene = Scene(mass_center_height=0.031)
    rng = np.random.default_rng(1)
    for _ in range(8):
        q = np.array([rng.uniform(0.07, 1.3), *rng.uniform(-3, 3, 2)])
        body = oracle.Body(scene, q, rng.uniform(-2, 2, 3), np.zeros(3), np.zeros(3))
        g = geometry.contact_geometry(scene, q[0])
        Rz = oracle.rotation(np.array([0, q[1], 0]))
        np.testing.assert_allclose(Rz @ [g.h_c, 0, g.z_c], body.C, atol=1e-14)
        np.testing.assert_allclose(Rz @ [g.dh_c, 0, g.dz_c], body.dC[:, 0], atol=1e-12)
        points = geometry.contact_points(g, scene.hole_diameter) @ Rz.T
        np.testing.assert_allclose(points, body.points, atol=1e-13)
        np.testing.assert_allclose(geometry.normals(g) @ Rz.T, body.normals, atol=1e-12)
        J = geometry.velocity_jacobians(g, scene.peg_diameter, scene.hole_diameter)
        np.testing.assert_allclose((J @ body.rates) @ Rz.T, body.velocity, atol=1e-12)


@given(scenes, shares)
@settings(max_examples=60, deadline=None)
def test_derivatives_equal_complex_steps(scene, share):
    gamma, h = tilt(scene, share), 1e-30
    g = geometry.contact_geometry(scene, gamma)
    step = geometry.contact_geometry(scene, gamma + 1j * h)
    for name, derivative in (
        ("b", g.db),
        ("h_c", g.dh_c),
        ("z_c", g.dz_c),
        ("dh_c", g.ddh_c),
        ("dz_c", g.ddz_c),
        ("a1", g.a2 / g.s),
        ("a2", g.a1 / g.s),
        ("S1", -2 * g.S2 / g.s),
    ):
        # Relative to the sizes that are differenced; the formulas share no step.
        size = abs(derivative) + scene.hole_diameter + scene.peg_height
        assert getattr(step, name).imag / h == pytest.approx(derivative, abs=1e-11 * size), name


LENGTHS = geometry.ContactGeometry._fields[3:]


def exact(D, gap, H_c, gamma):
    """Return the geometry by its definitions, in the digits mpmath works with."""
    d = D - gap

    def forms(x):
        s, c = mpmath.sin(x), mpmath.cos(x)
        a1, a2 = (d - D * c) / (2 * s), (D - d * c) / (2 * s)
        S1, S2 = (a2 - a1 * c) / s, (a2 * c - a1) / s
        b = mpmath.sqrt(D**2 / 4 - S1**2)
        return (a1, a2, S1, S2, b, -(H_c - a2) * s, (H_c - a2) * c + a1)

    # Differences lose 2 x 30 of 150 digits.
    step = mpmath.mpf(10) ** -30 * (gamma - mpmath.acos(d / D))
    before, at, after = (forms(gamma + k * step) for k in (-1, 0, 1))
    first = [(z - x) / (2 * step) for x, z in zip(before, after, strict=True)]
    second = [(z - 2 * y + x) / step**2 for x, y, z in zip(before, at, after, strict=True)]
    a1, a2, S1, S2, b, h_c, z_c = at
    return (a1, a2, S1, S2, b, first[4], h_c, z_c, *first[5:], *second[5:])


# Clearances of 1 um to 5 mm on diameters of 1 mm to 500 mm, as far as the peg keeps a diameter.
EDGE = [
    (D, gap)
    for D in (0.001, 0.008, 0.050, 0.500)
    for gap in (1e-6, 1e-5, 1e-4, 1e-3, 5e-3)
    if gap < D / 5
]
# And between them: zeros of S2 and of the derivatives lie where no round number is.
_RANDOM = np.random.default_rng(5)
EDGE += [
    (D, gap)
    for D, gap in zip(
        10 ** _RANDOM.uniform(-3, np.log10(0.5), 30),
        10 ** _RANDOM.uniform(-6, -2.3, 30),
        strict=True,
    )
    if gap < D / 5
]
EXCESS = (1e-10, 3e-9, 1e-7, 1e-5, 1e-3, 0.02, 0.3, 0.8, *10 ** _RANDOM.uniform(-10, -0.1, 8))


@pytest.mark.parametrize("argument", ["gamma", "excess"])
@pytest.mark.parametrize("D, gap", at_push(EDGE[::5], EDGE))
def test_geometry_keeps_its_digits_at_the_edge(D, gap, argument):
    scene = Scene(hole_diameter=D, peg_diameter=D - gap, peg_height=1.4 * D)
    for excess in EXCESS:
        with mpmath.workdps(150):
            d, D_, H_c = (
                mpmath.mpf(x)
                for x in (scene.peg_diameter, scene.hole_diameter, scene.mass_center_height)
            )
            if argument == "gamma":
                x = float(scene.gamma0 + excess)
                g = geometry.contact_geometry(scene, x)
            else:
                x = excess
                g = geometry.contact_geometry_above(scene, x)

            def evaluate(D, gap, H_c, x):
                gamma = x if argument == "gamma" else x + mpmath.acos(1 - gap / D)
                return exact(D, gap, H_c, gamma)

            # The condition number: relative change of the result over that of D, of the
            # clearance D - d, of the mass centre's height and of the argument, added up.
            inputs = [D_, D_ - d, H_c, mpmath.mpf(x)]
            truth = evaluate(*inputs)
            condition = [mpmath.mpf(0)] * len(truth)
            nudge = mpmath.mpf(10) ** -25
            for k in range(4):
                moved = list(inputs)
                moved[k] *= 1 + nudge
                for i, value in enumerate(evaluate(*moved)):
                    condition[i] += abs((value - truth[i]) / (truth[i] * nudge))
            for name, value, bound in zip(LENGTHS, truth, condition, strict=True):
                error = abs(mpmath.mpf(float(getattr(g, name))) - value)
                ulps = error / mpmath.mpf(float(np.spacing(abs(float(value)))))
                assert ulps <= 4 * max(1, bound), (excess, name, float(ulps), float(bound))


def test_plain_forms_lose_at_the_edge_what_the_factored_ones_keep():
    scene, excess = Scene(), 1e-10
    with mpmath.workdps(150):
        d, D = mpmath.mpf(scene.peg_diameter), mpmath.mpf(scene.hole_diameter)
        gamma = mpmath.acos(d / D) + mpmath.mpf(excess)
        a1, *_ = exact(D, D - d, mpmath.mpf(scene.mass_center_height), gamma)
        kept = abs(geometry.contact_geometry_above(scene, excess).a1 / a1 - 1)
        x = float(gamma)
        plain = abs((0.0499 - 0.05 * np.cos(x)) / (2 * np.sin(x)) / a1 - 1)
    assert kept < 1e-15 < 1e-6 < plain


def test_gamma0_keeps_its_digits():
    for D, gap in EDGE:
        scene = Scene(hole_diameter=D, peg_diameter=D - gap)
        with mpmath.workdps(60):
            truth = mpmath.acos(mpmath.mpf(scene.peg_diameter) / mpmath.mpf(D))
            assert abs(scene.gamma0 / truth - 1) < 4e-16
    assert Scene().gamma0 == pytest.approx(0.063256, abs=5e-7)


def test_an_array_of_tilts_gives_what_each_tilt_gives():
    scene = Scene()
    gammas = np.linspace(0.0634, 1.4, 7).reshape(7, 1)
    many = geometry.contact_geometry(scene, gammas)
    J = geometry.velocity_jacobians(many, 0.0499, 0.05)
    n, points = geometry.normals(many), geometry.contact_points(many, 0.05)
    assert J.shape == (3, 3, 3, 7, 1) and n.shape == points.shape == (3, 3, 7, 1)
    for k, gamma in enumerate(gammas[:, 0]):
        one = geometry.contact_geometry(scene, gamma)
        np.testing.assert_allclose([x[k, 0] for x in many[1:]], one[1:], rtol=1e-15)
        np.testing.assert_array_equal(J[..., k, 0], geometry.velocity_jacobians(one, 0.0499, 0.05))
        np.testing.assert_array_equal(n[..., k, 0], geometry.normals(one))
        np.testing.assert_array_equal(points[..., k, 0], geometry.contact_points(one, 0.05))


@pytest.mark.parametrize("gamma", [0.06, 0.0, -0.1, 1.6, 22.0, np.nan, np.inf])
def test_a_tilt_without_three_contacts_says_so(gamma):
    message = r"gamma = \S+ rad has no three-point contact: it must lie within 0.0632\d+ rad"
    with pytest.raises(PegOnHoleError, match=message):
        geometry.contact_geometry(Scene(), gamma)
    with pytest.raises(PegOnHoleError, match=message):
        geometry.contact_geometry(Scene(), np.array([0.1, gamma]))


@pytest.mark.parametrize("excess", [0.0, -1e-3, 1.6, np.nan, np.inf])
def test_an_excess_without_three_contacts_says_so(excess):
    with pytest.raises(PegOnHoleError, match=r"gamma - gamma0 = \S+ rad has no three-point"):
        geometry.contact_geometry_above(Scene(), excess)
