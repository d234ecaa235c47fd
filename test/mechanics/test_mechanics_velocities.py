"""Velocities, cosines and generalised forces against the numeric body, in all frames."""

import numpy as np
import pytest

import rigid_body_oracle as oracle
from paper import velocities
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics import geometry
from peg_on_hole_ros.mechanics.any_side import AXES
from peg_on_hole_ros.mechanics.scene import Scene

SCENE = Scene(mass_center_height=0.03, gravity=(1.0, 2.0, -9.0))
Q = np.array([0.3, 0.8, -1.9])
RATES = np.array([-0.16, 0.7, 2.0])


def axes(frame):
    """Return the axes of a frame as columns in hole axes, by turns."""
    s, c = np.sin(Q[0]), np.cos(Q[0])
    Rz = oracle.rotation([0, Q[1], 0])
    moving = np.array([[0, c, -s], [-1, 0, 0], [0, s, c]])
    return {"hole": np.eye(3), "auxiliary": Rz, "moving": Rz @ moving, "peg": oracle.rotation(Q)}[
        frame
    ]


@pytest.mark.parametrize("frame", AXES)
def test_vectors_in_a_frame_are_those_of_the_body(frame):
    body = oracle.Body(SCENE, Q, RATES, np.zeros(3), np.zeros(3))
    E = axes(frame)
    found = velocities.contact_velocities(SCENE, Q, RATES, frame)
    np.testing.assert_allclose(found, body.velocity @ E, atol=1e-12)
    parts = [velocities.contact_velocities(SCENE, Q, RATES, frame, m) for m in velocities.MOTIONS]
    np.testing.assert_allclose(sum(parts), found, atol=1e-15)
    one = oracle.Body(SCENE, Q, RATES * [0, 1, 0], np.zeros(3), np.zeros(3))
    np.testing.assert_allclose(parts[1], one.velocity @ E, atol=1e-12)
    np.testing.assert_allclose(
        velocities.normal_cosines(SCENE, Q, frame), body.normals @ E, atol=1e-12
    )
    np.testing.assert_allclose(
        SCENE.friction * velocities.friction_cosines(SCENE, Q, RATES, frame),
        body.friction @ E,
        atol=1e-11,
    )


def test_generalized_forces_are_the_virtual_work_of_the_forces():
    force, moment, normal = (
        np.array([1.0, -2, 3]),
        np.array([0.1, 0.2, -0.3]),
        np.array([5.0, 6, 7]),
    )
    body = oracle.Body(SCENE, Q, RATES, np.zeros(3), np.zeros(3))
    wrench_P = np.concatenate([body.R.T @ force, body.R.T @ moment])
    Q_i = velocities.generalized_forces(SCENE, Q, RATES, normal, wrench_P)
    np.testing.assert_allclose(Q_i.applied, body.dC.T @ force + body.E.T @ moment, atol=1e-12)
    np.testing.assert_allclose(Q_i.gravity, body.dC.T @ body.force, atol=1e-12)
    for i, point in enumerate(body.points):
        virtual = body.dC + np.cross(body.E.T, point - body.C).T
        np.testing.assert_allclose(
            Q_i.friction[i], normal[i] * virtual.T @ body.friction[i], atol=1e-11
        )


def test_instant_center_does_not_move():
    g = geometry.contact_geometry(SCENE, Q[0])
    L, KL, BL = velocities.instant_center(g)
    body = oracle.Body(SCENE, [Q[0], 0, 0], [1.0, 0, 0], np.zeros(3), np.zeros(3))
    v = body.dC[:, 0] + np.cross(body.omega, L - body.C)
    np.testing.assert_allclose(v, 0, atol=1e-12)
    K, B1, _ = body.points
    assert np.linalg.norm(L - K) == pytest.approx(KL, rel=1e-12)
    assert np.linalg.norm((L - B1)[[0, 2]]) == pytest.approx(BL, rel=1e-12)
    assert np.linalg.norm(body.velocity[0]) == pytest.approx(KL, rel=1e-10)


def test_arrays_over_time_give_what_each_time_gives():
    gamma = np.linspace(0.1, 0.5, 6)
    q = np.array([gamma, gamma * 2, gamma - 3])
    rates = np.array([-0.16 + 0 * gamma, gamma, np.cos(gamma)])
    normal = np.array([gamma, gamma + 1, gamma + 2])
    wrench = np.outer(np.arange(6.0), gamma)
    for frame in AXES:
        many = velocities.contact_velocities(SCENE, q, rates, frame)
        cosines = velocities.normal_cosines(SCENE, q, frame)
        assert many.shape == cosines.shape == (3, 3, 6)
        for k in range(6):
            one = velocities.contact_velocities(SCENE, q[:, k], rates[:, k], frame)
            np.testing.assert_allclose(many[..., k], one, rtol=1e-13, atol=1e-16)
            one = velocities.normal_cosines(SCENE, q[:, k], frame)
            np.testing.assert_allclose(cosines[..., k], one, rtol=1e-13, atol=1e-16)
    many = velocities.generalized_forces(SCENE, q, rates, normal, wrench)
    for k in range(6):
        one = velocities.generalized_forces(
            SCENE, q[:, k], rates[:, k], normal[:, k], wrench[:, k]
        )
        for a, b in zip(many, one, strict=True):
            np.testing.assert_allclose(a[..., k], b, rtol=1e-12, atol=1e-15)


def test_unknown_names_are_refused_with_the_known_ones():
    with pytest.raises(PegOnHoleError, match="frame = 'world' is none of hole, auxiliary, moving"):
        velocities.contact_velocities(SCENE, Q, RATES, "world")
    with pytest.raises(PegOnHoleError, match="motion = 'gamma' is none of align, slide, slip"):
        velocities.contact_velocities(SCENE, Q, RATES, "hole", "gamma")


def test_a_contact_at_rest_has_no_direction_of_friction():
    assert np.all(velocities.friction_cosines(SCENE, Q, np.zeros(3)) == 0)
    assert velocities.overall_reaction(SCENE, 10.0) == pytest.approx(10 * 1.04**0.5)
