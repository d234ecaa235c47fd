"""Trajectories through the transition, and why they end."""

import numpy as np
import pytest

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics import geometry, reference, two_point
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.mechanics.trajectory import Ending, integrate


def push(force_hez, moment_e):
    """Return a load that is constant in (h, e, z)."""

    def wrench_P(t, q, rates):
        to_P = reference.wrench_axes(q[0], q[2]).T
        return np.concatenate([to_P @ force_hez, to_P @ [0, moment_e, 0]])

    return wrench_P


def test_a_closing_peg_passes_into_two_point_contact():
    scene = Scene(friction=0.05)
    load = push([0, 0, -60.0], 0.3)
    found = integrate(scene, [0.064, 0, 0], [-0.16, 0, 0], 0.05, load)
    assert found.two_point[-1] and not found.two_point[0]
    assert found.ending is Ending.CONTACT_OPEN
    assert found.transition == pytest.approx(0.042, abs=1e-3)
    first = int(np.argmax(found.two_point))
    assert np.all(found.q[0, first:] <= scene.gamma0)
    # Pose and rates run through. So do the reactions: a regularised law lets K stand still for a
    # moment, where Coulomb's law turns its friction round at once.
    assert found.q[0, first] == pytest.approx(found.q[0, first - 1], abs=1e-9)
    assert found.rates[0, first] == pytest.approx(found.rates[0, first - 1], abs=1e-9)
    np.testing.assert_allclose(found.normal[:, first], found.normal[:, first - 1], rtol=1e-4)
    assert found.normal[0, first + 1] < 0.8 * found.normal[0, first - 2]
    assert np.all(found.normal[:, :-1] > 0)
    # Planar motion needs no force to stay planar.
    assert np.max(np.abs(found.lateral_force)) < 1e-6
    # Each sample's reactions are those of its state.
    k = first + 2
    q, rates = np.append(found.q[:, k], 0), np.append(found.rates[:, k], 0)
    one = two_point.solve_two_point(scene, q, rates, load(0, q, rates), 1e-5, held=True)
    np.testing.assert_allclose(found.normal[:, k] @ [0, 1, 1], one.normal[1], rtol=1e-12)


def test_energy_is_kept_through_the_transition():
    scene = Scene(friction=0.0)
    force, moment = np.array([0, 0, -60.0]), 0.25
    found = integrate(scene, [0.064, 0, 0], [-0.16, 0, 0], 0.05, push(force, moment))
    assert found.transition is not None and np.sum(found.two_point) > 5
    weight = scene.peg_mass * 9.80665
    energies = []
    for (gamma, _, _), (rate, _, _), below in zip(found.q.T, found.rates.T, found.two_point):
        if below:
            h, _, z = two_point.two_point_pose(scene, min(gamma, scene.gamma0)).center
            z, dh, dz = z.v, h.g[0], z.g[0]
        else:
            g = geometry.contact_geometry(scene, max(gamma, scene.gamma0 + 1e-12))
            z, dh, dz = g.z_c, g.dh_c, g.dz_c
        inertia = scene.peg_mass * (dh**2 + dz**2) + scene.transverse_inertia
        # The moment along e works on -gamma.
        energies.append(inertia * rate**2 / 2 + (weight - force[2]) * z + moment * gamma)
    # The integrator's tolerance is 1e-8 of each step.
    np.testing.assert_allclose(energies, energies[0], rtol=1e-7)


def test_slip_opens_a_B_contact_just_before_gamma0():
    scene = Scene(friction=0.02)
    found = integrate(scene, [0.064, 0, 0], [-0.16, 0, 2], 0.2, push(np.zeros(3), 0.1))
    assert found.ending is Ending.CONTACT_OPEN and found.transition is None
    assert found.normal[1, -1] == pytest.approx(0, abs=1e-6) and found.normal[2, -1] > 1
    assert 0 < found.q[0, -1] - scene.gamma0 < 3e-4


def test_endings_have_names():
    wedged = integrate(Scene(), [0.08, 0, 0], [-0.16, 0, 2], 1.0, push(np.zeros(3), 0.1))
    assert wedged.ending is Ending.WEDGED
    timed = integrate(Scene(), [0.3, 0, 0], [0.2, 0, 1], 0.01, samples=5)
    assert timed.ending is Ending.TIME and timed.t[-1] == 0.01 and timed.t.size == 6
    opened = integrate(Scene(friction=0.05), [0.05, 0, 0], [0.1, 0, 0], 1.0)
    assert opened.ending is Ending.CONTACT_OPEN and opened.t.size == 1
    lying = integrate(Scene(friction=0.0), [1.0, 0, 0], [3.0, 0, 0], 1.0, push(np.zeros(3), -0.2))
    assert lying.ending in (Ending.LEVEL, Ending.CONTACT_OPEN)


@pytest.mark.parametrize("duration", [0.0, -1.0, np.nan])
def test_a_duration_must_be_positive(duration):
    with pytest.raises(PegOnHoleError, match="is not above 0"):
        integrate(Scene(), [0.3, 0, 0], np.zeros(3), duration)
