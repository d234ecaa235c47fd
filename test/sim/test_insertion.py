"""A peg in the hole: truth against constructions that share nothing with the simulation."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import insertion_oracle as oracle
from paper.two_point import solve_two_point
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.simulated_bag import write_bag
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.mechanics.whitney import jamming_margin
from peg_on_hole_ros.sim.dynamics import rotation, scene_numbers
from peg_on_hole_ros.sim.hole_places import touching_places
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate
from simulated import plan

pytestmark = pytest.mark.xdist_group("simulation")
SOFT = {"stiffness": 1e4, "rotational_stiffness": 300.0, "force_limit": 1e3, "torque_limit": 50.0}


def inserted(phases, tilt, friction=0.2, psi=0.3, **more):
    """Begin in the hole on two points, at rest."""
    tree = {"holder": SOFT, "start": {"angles": [tilt, psi, 0.0]}, **more}
    tree["phases"] = {k: {"kind": "insert", **phase} for k, phase in phases.items()}
    return integrate(plan_from_tree(Configuration(scene=Scene(friction=friction)), tree))


@cache
def sliding(**more):
    """Two points, 17 to 20 mm deep, while tilt, azimuth and slip change."""
    phases = {
        "down": {
            "duration": 0.2, "angles": [0.008, 0.5, 0.3], "place": [1e-4, 1e-4], "depth": 0.021
        }
    }  # fmt: skip
    return inserted(phases, 0.006, **more)


@cache
def whole():
    """The committed configuration: from three contacts to more than a diameter deep."""
    return integrate(plan("insertion"))


def smooth(a, b, t, duration):
    x = np.clip(t / duration, 0, 1)
    return a + (b - a) * x**3 * (10 - 15 * x + 6 * x * x)


def commanded(begin, t):
    """The program of `sliding`, by rotations and differences."""

    def pose(t):
        gamma, psi, phi = (
            smooth(a, b, t, 0.2) for a, b in ((0.006, 0.008), (0.3, 0.5), (0.0, 0.3))
        )
        end = [smooth(a, b, t, 0.2) for a, b in zip(begin, (1e-4, 1e-4, 0.021))]
        R = oracle.turn(np.array([0, 0, psi])) @ oracle.turn(np.array([0, -gamma, 0]))
        R = R @ oracle.turn(np.array([0, 0, phi]))
        return np.array([end[0], end[1], -end[2]]) + 0.035 * R[:, 2], R

    C, R = pose(t)
    (after, R_after), (before, R_before) = pose(t + 1e-6), pose(t - 1e-6)
    W = (R_after - R_before) @ R.T / 2e-6
    return C, R, (after - before) / 2e-6, np.array([W[2, 1], W[0, 2], W[1, 0]])


@pytest.mark.nightly
def test_agrees_with_rigid_contacts_by_a_time_stepping_scheme():
    """Contacts a hundred times as stiff as steel, against impulses that keep gaps open."""
    truth = sliding(contact_stiffness=1e10)
    scene = truth.plan.configuration.scene
    grip = np.array([0, 0, 0.07 - scene.mass_center_height])
    damping = [1.4 * np.sqrt(k * m) for k, m in ((1e4, 0.5), (300.0, scene.transverse_inertia))]
    holding = (grip, 1e4, damping[0], 300.0, damping[1])
    t, C, R, rim, edge = oracle.insert(
        scene, holding, lambda t: commanded(truth.place[0], t),
        truth.centre[0, 0], rotation(truth.q[0]), np.zeros(3), np.zeros(3), 0.14, 4e-4,
    )  # fmt: skip
    rows = np.round(t * 1000).astype(int)
    chosen = np.isclose(rows, t * 1000) & (t > 0.03)
    rows = rows[chosen]
    assert len(rows) > 50 and set(truth.mode[rows]) == {"two_point"}
    # Its gaps are a step late: 0.4 ms of some 30 mm/s along the hole.
    depth = -(C - scene.mass_center_height * R[:, :, 2])[chosen, 2]
    np.testing.assert_allclose(truth.place[rows, 2], depth, atol=5e-6)
    tilt = np.arccos(np.minimum(R[chosen, 2, 2], 1.0))
    np.testing.assert_allclose(truth.q[rows, 0], tilt, rtol=1e-3)
    np.testing.assert_allclose(truth.normal[rows, 0], rim[chosen], rtol=0.01)
    np.testing.assert_allclose(truth.normal[rows, 1:].sum(axis=1), edge[chosen], rtol=0.01)
    assert truth.normal[rows[-1], 0] > 40


def test_agrees_with_the_equations_of_two_rigid_contacts():
    """The reactions that `paper.two_point` gives under the simulated wrench."""
    truth = sliding(contact_stiffness=1e10)
    scene = truth.plan.configuration.scene
    for k in range(60, 200, 20):
        R = rotation(truth.q[k])
        wrench = np.concatenate([R.T @ truth.force[k], R.T @ truth.moment[k]])
        # B lies beside the plane of tilt, by less than 0.1.
        at_B = truth.contact_point[k, 1]
        beta = np.arctan2(at_B[1], at_B[0]) - truth.q[k, 1]
        after = truth.contact_point[k + 1, 1], truth.contact_point[k - 1, 1]
        change = np.diff([np.arctan2(p[1], p[0]) for p in after])[0] / -2e-3
        found = solve_two_point(
            scene, [*truth.q[k], beta], [*truth.rates[k], change - truth.rates[k, 1]], wrench
        )
        expected = [truth.normal[k, 0], truth.normal[k, 1:].sum()]
        np.testing.assert_allclose(found.normal, expected, rtol=5e-3)


def test_samples_keep_to_newton_and_euler():
    """Accelerations by differences of the poses are what the loads of the samples give."""
    truth = sliding(wrench_rate=5000, joint_rate=500)
    scene, h = truth.plan.configuration.scene, 2e-4
    rows = range(400, 900, 37)
    for k in rows:
        C = truth.centre[:, 0]
        a = (C[k + 5] - 2 * C[k] + C[k - 5]) / (5 * h) ** 2
        loads = truth.force[k] + truth.contact_force[k].sum(axis=0)
        weight = scene.peg_mass * np.asarray(scene.gravity)
        assert np.abs(scene.peg_mass * a - loads - weight).max() < 0.02
        L = []
        for i in (k - 5, k + 5):
            R = rotation(truth.q[i])
            inertia = [scene.transverse_inertia, scene.transverse_inertia, scene.axial_inertia]
            turned = rotation(truth.q[i + 1]) @ rotation(truth.q[i - 1]).T
            w = np.array([turned[2, 1], turned[0, 2], turned[1, 0]]) / (2 * h)
            L.append(R @ (inertia * (R.T @ w)))
        moment = truth.moment[k] + sum(
            np.cross(truth.contact_point[k, i] - C[k], truth.contact_force[k, i]) for i in range(3)
        )
        assert np.abs((L[1] - L[0]) / (10 * h) - moment).max() < 2e-3


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_energy_goes_where_friction_takes_it(friction):
    """Work of holder and weight: motion, what the springs of the contacts hold, and friction."""
    truth = sliding(friction=friction, wrench_rate=5000)
    scene = truth.plan.configuration.scene
    v, w = truth.centre[:, 1], truth.turning[:, 0]
    power = (truth.force * v).sum(axis=1) + (truth.moment * w).sum(axis=1)
    power += scene.peg_mass * (v @ np.asarray(scene.gravity))
    spin = np.array([rotation(q)[:, 2] for q in truth.q])
    along = (w * spin).sum(axis=1)
    turning = scene.transverse_inertia * (w * w).sum(axis=1)
    turning += (scene.axial_inertia - scene.transverse_inertia) * along**2
    kinetic = (scene.peg_mass * (v * v).sum(axis=1) + turning) / 2
    stored = (truth.hole_normal**2).sum(axis=1) / (2 * truth.plan.contact_stiffness)
    # The springs along the surfaces hold f^2/0.82 of that besides.
    stored *= 1 + friction**2 / 0.82
    rubbed = friction * (truth.hole_normal * truth.hole_slip).sum(axis=1)
    h = 1 / 5000
    work = np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * h)])
    lost = np.concatenate([[0], np.cumsum((rubbed[1:] + rubbed[:-1]) / 2 * h)])
    gone = work - (kinetic - kinetic[0]) - stored - lost
    assert np.ptp(work) > 2e-3
    # What is left the dampers of the contacts took: little, and never the other way.
    assert np.abs(gone).max() < 0.01 * np.ptp(work)
    if friction:
        assert lost[-1] > 0.5 * work[-1]


def test_forces_lie_in_the_cones_and_against_the_slip():
    truth = whole()
    in_hole = truth.q[:, 0] < truth.plan.configuration.scene.gamma0
    f = truth.plan.configuration.scene.friction
    for contact in (0, 1):
        force, normal = truth.contact_force[in_hole, contact], truth.normal[in_hole, contact]
        rows = normal > 1.0
        size = np.linalg.norm(force[rows], axis=1)
        assert rows.sum() > 500
        assert (size <= normal[rows] * np.sqrt(1 + f * f) * (1 + 1e-6)).all()
        fast = truth.slip_speed[in_hole, contact][rows] > 1e-3
        np.testing.assert_allclose(size[fast], normal[rows][fast] * np.sqrt(1 + f * f), rtol=2e-3)


def test_goes_through_all_contact_sets_to_more_than_a_diameter():
    truth = whole()
    assert truth.ended_by == "end" and truth.known.all()
    assert truth.place[-1, 2] > truth.plan.configuration.scene.hole_diameter
    found = set(truth.mode)
    assert {"three_point", "two_point", "one_point", "line", "open"} <= found
    (t_ns, what), *_ = truth.events
    k = int(np.searchsorted(truth.t_ns, t_ns))
    gamma0 = truth.plan.configuration.scene.gamma0
    assert truth.q[k, 0] < gamma0 <= truth.q[k - 1, 0] and "transition" in what
    # Contacts merge within milliseconds; the holder feels no jolt.
    assert np.abs(np.diff(truth.force[k - 100 : k + 100], axis=0)).max() < 1.0
    below = np.arange(len(truth.t_ns)) >= k
    np.testing.assert_array_equal(truth.normal[below, 1], truth.normal[below, 2])
    two = truth.mode == "two_point"
    at_rest = np.cos(truth.hole_azimuth[two, 0] - truth.hole_azimuth[two, 3])
    assert (at_rest < 0).mean() > 0.9
    line = truth.mode == "line"
    assert np.cos(truth.hole_azimuth[line, 0] - truth.hole_azimuth[line, 2]).min() > 0


def test_converges_with_the_step(monkeypatch):
    """Half of the step leaves half of the error at most, of angles and of reactions."""
    import peg_on_hole_ros.sim.insertion_phases as run

    original, found = run.Insertion, []
    for step in (1e-3, 5e-4, 2.5e-4, 3.125e-5):
        monkeypatch.setattr(
            run, "Insertion", lambda *given, step=step: original(*given, step=step)
        )
        sliding.cache_clear()
        truth = sliding()
        found.append(np.append(truth.q[150], truth.normal[150] / 1e6))
    sliding.cache_clear()
    errors = [np.abs(q - found[-1]).max() for q in found[:-1]]
    assert errors[0] > 1.7 * errors[1] > 2.9 * errors[2] > 0
    # Of radians, and of meganewtons; the simulation takes a tenth of these steps.
    assert errors[0] < 1e-7


def whitney_margin(truth, k):
    """Whitney's margin by the true wrench, at the lower end, in the plane of tilt [N]."""
    scene = truth.plan.configuration.scene
    load = truth.force[k] + scene.peg_mass * np.asarray(scene.gravity)
    moment = truth.moment[k] + np.cross(truth.centre[k, 0] - truth.position[k], load)
    psi = truth.q[k, 1]
    h, e = np.array([np.cos(psi), np.sin(psi), 0]), np.array([-np.sin(psi), np.cos(psi), 0])
    length = -truth.contact_point[k, 1, 2]
    return -load[2], jamming_margin(
        scene.peg_diameter / 2, length, scene.friction, load @ h, -load[2], -(moment @ e)
    )


def pushed_aside(**more):
    phases = {
        "aside": {"duration": 0.1, "place": [-0.0028660, -0.0008866]},
        "push": {"duration": 0.4, "depth": 0.024},
        **more,
    }
    return inserted(phases, 0.006)


def test_a_jammed_peg_moves_where_whitney_says():
    """A side load holds the peg against a push that grows: it goes where the margin is zero."""
    truth = pushed_aside()
    speed = truth.place_rate[:, 2]
    k = int(np.argmax((speed > 5e-4) & (truth.t_ns > 120_000_000)))
    assert truth.mode[k - 5] == "two_point"
    push, margin = whitney_margin(truth, k - 2)
    assert push > 15
    assert abs(margin) < 0.05 * push
    before = truth.t_ns.searchsorted(150_000_000)
    push, margin = whitney_margin(truth, before)
    assert margin < -0.1 * abs(push) and abs(speed[before]) < 1e-5


def test_a_peg_at_rest_does_not_creep():
    truth = pushed_aside(push={"duration": 0.1, "depth": 0.0172}, still={"duration": 0.4})
    depth = truth.place[truth.t_ns >= 300_000_000, 2]
    assert truth.normal[-1, 0] > 20 and truth.closed[-1].all()
    assert np.ptp(depth) < 1e-9


@pytest.mark.parametrize(
    "way",
    [
        {"turn": {"duration": 0.2, "rates": [0.0, 0.0, 2.0]}},
        {"let_go": {"duration": 0.2, "place": [0.0, 0.0]}},
    ],
)
def test_a_jammed_peg_is_freed(way):
    stuck = {"push": {"duration": 0.1, "depth": 0.018}, "still": {"duration": 0.1}}
    truth = pushed_aside(**stuck, **way)
    held = truth.place[truth.phase == "still", 2]
    assert np.ptp(held) < 1e-8
    assert truth.place[-1, 2] > held[-1] + 1e-4


@pytest.mark.parametrize("friction, kept", [(0.3, True), (0.1, False)])
def test_a_peg_wedges_where_both_cones_hold_the_other_contact(friction, kept):
    """Squeezed by a tilt and let go: l/d is 0.2, between the two coefficients."""
    gamma = 0.0125
    phases = {
        "squeeze": {"duration": 0.1, "angles": [gamma + 0.004, 0.3, 0.0]},
        "let_go": {"duration": 0.1, "angles": [gamma, 0.3, 0.0]},
        "rest": {"duration": 0.1},
    }
    truth = inserted(phases, gamma, friction)
    squeezed = truth.normal[truth.phase == "squeeze", 0].max()
    assert squeezed > 40
    left = truth.normal[-1, 0]
    assert left > 0.5 * squeezed if kept else left < 0.1 * squeezed


def test_places_are_those_of_dense_samples():
    """Poses that cut some micrometres into rim or wall, against circles of 720 points."""
    scene = Scene()
    p, rng, seen = scene_numbers(scene), np.random.default_rng(8), [0, 0]
    for _ in range(300):
        tilt = rng.uniform(0, 0.9) * scene.gamma0
        R = rotation(np.array([tilt, rng.uniform(-3, 3), rng.uniform(-3, 3)]))
        end = np.array([*rng.uniform(-6e-5, 6e-5, 2), -rng.uniform(0.004, 0.05)])
        C = end + scene.mass_center_height * R[:, 2]
        expected = oracle.touching(scene, C, R)
        before = np.array([0.0, np.pi, 0.0, np.pi])
        points, normals, gaps, _, _ = touching_places(p, scene.peg_height, C, R, before)
        near = np.flatnonzero(gaps < oracle.NEAR)
        assert len(near) == len(expected)
        for point, normal, gap in expected:
            rim = bool(abs(point[2]) < 1e-15)
            seen[rim] += 1
            k = min(
                (i for i in near if (i < 2) == rim),
                key=lambda i: np.linalg.norm(points[i] - point),
            )
            assert gaps[k] == pytest.approx(gap, abs=1e-11)
            np.testing.assert_allclose(points[k], point, atol=2e-6)
            np.testing.assert_allclose(normals[k], normal, atol=1e-4)
    assert min(seen) > 50


def test_bag_tells_place_and_contacts(tmp_path):
    truth = sliding()
    write_bag(tmp_path / "in.mcap", truth)
    bag = Bag(tmp_path / "in.mcap")
    rows = {"/truth/place": [], "/truth/hole_contacts": [], "/truth/contact_mode": []}
    for topic, _, message in bag.messages(list(rows)):
        rows[topic].append(message)
    place, contacts = rows["/truth/place"], rows["/truth/hole_contacts"]
    assert list(place[0].name) == ["x", "y", "depth"]
    assert list(contacts[0].name) == ["rim_1", "rim_2", "edge_1", "edge_2"]
    np.testing.assert_allclose([m.position for m in place], truth.place)
    np.testing.assert_allclose([m.velocity for m in place], truth.place_rate)
    np.testing.assert_allclose([m.effort for m in contacts], truth.hole_normal)
    np.testing.assert_allclose([m.position for m in contacts], truth.hole_azimuth)
    assert "two_point" in [m.data for m in rows["/truth/contact_mode"]]
    assert "TR-BDF2" in bag.metadata["peg_on_hole_simulation"]["integrator"]
    # The speed is the change of the place.
    np.testing.assert_allclose(
        np.gradient(truth.place[50:, 2], 1e-3)[1:-1], truth.place_rate[51:-1, 2], atol=2e-4
    )


def test_the_holder_s_limit_ends_an_insertion():
    truth = inserted({"push": {"duration": 0.3, "place": [0.3e-1, 0.0]}}, 0.006)
    limited = replace(truth.plan.holder, force_limit=30.0)
    short = integrate(replace(truth.plan, holder=limited))
    assert short.ended_by == "force limit" and len(short.t_ns) < len(truth.t_ns)
    assert np.linalg.norm(short.force, axis=1).max() < 30


@pytest.mark.parametrize(
    "phase, message",
    [
        ({"kind": "contact", "depth": 0.01}, "a.depth is for insert; in contact the peg's place"),
        ({"offset": [0.0, 0.0, 0.0]}, "a.offset is not for insert: in the hole state place and"),
        ({"depth": 0.07}, "a.depth = 0.07 m is not below scene.peg_height = 0.07 m: the whole"),
        ({"depth_rate": 2.0}, "a.depth_rate = 2.0 m/s is not a number within -1 to 1 m/s"),
        ({"place": [0.0]}, "a.place = .0.0. is not 2 numbers"),
    ],
)
def test_mistakes_are_told(phase, message):
    with pytest.raises(PegOnHoleError, match=message):
        inserted({"a": {"duration": 0.1, **phase}}, 0.1)


def test_nothing_but_insert_follows_insert():
    phases = {"a": {"duration": 0.1}, "b": {"kind": "free", "duration": 0.1}}
    with pytest.raises(PegOnHoleError, match="b: free does not follow insert"):
        inserted(phases, 0.1)
