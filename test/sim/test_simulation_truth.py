"""Truths obey Newton and Euler, converge, stay unilateral, and end for the reason they state."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics import reference
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim import contact_run
from peg_on_hole_ros.sim.dynamics import rotation, scene_numbers
from peg_on_hole_ros.sim.holder import holder_numbers, state_rate
from peg_on_hole_ros.sim.measure import sensor_wrench
from peg_on_hole_ros.sim.plan import holder_program
from peg_on_hole_ros.sim.truth import integrate
from rigid_body_oracle import contacts as oracle_contacts
from simulated import SAMPLES, contact_plan, plan, truth
from tiers import at_push

pytestmark = pytest.mark.xdist_group("simulation")


def momentum_residuals(result, rows):
    """
    Force and moment that the trajectory lacks, from poses alone by sixth-order differences.

    Angular velocity is read off the rotation matrices, so no rate formula of the package is used.
    """
    scene = result.plan.configuration.scene
    h = (result.t_ns[1] - result.t_ns[0]) * 1e-9
    first = np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * h)
    second = np.array([2, -27, 270, -490, 270, -27, 2]) / (180 * h * h)
    inertia = np.diag([scene.transverse_inertia] * 2 + [scene.axial_inertia])
    R = np.array([rotation(q) for q in result.q])
    C = result.position + scene.mass_center_height * R[:, :, 2]
    forces, moments = [], []
    for i in rows:
        span = slice(i - 3, i + 4)
        L = []
        for k in range(i - 3, i + 4):
            W = np.tensordot(first, R[k - 3 : k + 4], 1) @ R[k].T
            L.append(R[k] @ inertia @ R[k].T @ [W[2, 1], W[0, 2], W[1, 0]])
        weight = scene.peg_mass * np.array(scene.gravity)
        acting = result.contact_force[i].sum(axis=0) + result.force[i] + weight
        forces.append(scene.peg_mass * second @ C[span] - acting)
        arms = result.contact_point[i] - C[i]
        acting = np.cross(arms, result.contact_force[i]).sum(axis=0) + result.moment[i]
        moments.append(first @ np.array(L) - acting)
    return np.abs(forces).max(), np.abs(moments).max()


def test_motion_on_three_contacts_balances_forces_and_moments():
    turning = contact_plan([0.2, 0.5, 0.3], [-0.16, 0.4, 1.5], [-2e-4, 1e-4, -1e-3])
    result = integrate(replace(turning, wrench_rate=10000))
    assert result.ended_by == "end"
    rows = range(10, len(result.t_ns) - 10, 7)
    force, moment = momentum_residuals(result, rows)
    # Second differences over 0.1 ms of positions good to 1e-15 m: 1e-6 N; loads are some 10 N.
    assert force < 1e-4
    assert moment < 1e-6
    assert result.normal.min() > 1


def test_samples_are_stamped_from_the_end_of_the_lead_in_whatever_their_rate():
    # 20 ms are 2.5 samples of 125 Hz: the first after them comes 4 ms later.
    turning = contact_plan([0.3, 0.5, 0.3], [-0.16, 0.4, 1.5], [-2e-4, 1e-4, -1e-3])
    finely = integrate(replace(turning, wrench_rate=1000))
    coarsely = integrate(replace(turning, wrench_rate=125, joint_rate=125))
    assert coarsely.t_ns[:2].tolist() == [4_000_000, 12_000_000]
    same = np.searchsorted(finely.t_ns, coarsely.t_ns)
    np.testing.assert_array_equal(finely.t_ns[same], coarsely.t_ns)
    # Both are read off the integrator's polynomials, to its tolerance.
    np.testing.assert_allclose(finely.q[same], coarsely.q, rtol=0, atol=1e-7)


@pytest.mark.parametrize("mode", ["open", "two_point"])
def test_guided_motion_balances_forces_and_moments(mode):
    result = truth("working_cycle")
    rows = np.flatnonzero(result.mode == mode)
    # Not across the borders of phases, where the jerk jumps.
    inner = [i for i in rows[6:-6:23] if len(set(result.phase[i - 6 : i + 7])) == 1]
    inner = [i for i in inner if len(set(result.mode[i - 6 : i + 7])) == 1]
    fade = [t for t, _ in result.events]
    inner = [i for i in inner if all(not -1e7 < result.t_ns[i] - t < 8e7 for t in fade)]
    assert len(inner) > 20
    force, moment = momentum_residuals(result, inner)
    # The same with 1 ms: truncation of a motion that changes within some 0.1 s.
    assert force < 1e-6
    assert moment < 1e-6


def test_a_motion_in_the_hole_ends_before_the_whole_peg_is_in_it():
    """A program that closes to upright parts K and the far wall by more than the peg is long."""
    given = plan("working_cycle")
    last = given.phases[-1]
    upright = replace(last, name="upright", angles=(0.0, 0.8, 5.0), duration=0.5, load=None)
    result = integrate(replace(given, phases=(*given.phases[:-1], upright)))
    assert result.ended_by == "the whole peg would be in the hole"
    two_point = result.mode == "two_point"
    assert result.q[two_point, 0].min() > 0.0
    scene = given.configuration.scene
    depth = -result.contact_point[two_point, :, 2].min()
    assert 0.95 * scene.peg_height < depth <= scene.peg_height
    assert "whole peg" in result.events[-1][1]


def test_contacts_touch_and_do_not_move_along_their_normals():
    result = truth("working_cycle")
    scene = result.plan.configuration.scene
    for i in np.flatnonzero(result.mode == "three_point")[::400]:
        R = rotation(result.q[i])
        C = result.position[i] + scene.mass_center_height * R[:, 2]
        gaps, points = oracle_contacts(scene, C, R)
        # The oracle looks for the nearest points by iteration.
        assert np.abs(np.real(gaps)).max() < 1e-12
        assert np.array(points).real == pytest.approx(result.contact_point[i], abs=1e-9)


@pytest.mark.parametrize("mode", ["three_point", "two_point"])
def test_friction_opposes_slip_with_f_n(mode):
    result = truth("working_cycle")
    scene, h = result.plan.configuration.scene, 1e-3
    sliding = (result.mode == mode) & (result.slip_speed.max(axis=1) > 0.04)
    rows = [
        i
        for i in np.flatnonzero(sliding)[20:-20:150]
        if (result.closed[i - 2 : i + 3] == result.closed[i]).all()
    ]
    assert len(rows) > 3
    weights = np.array([1, -8, 0, 8, -1]) / (12 * h)
    for i in rows:
        R = np.array([rotation(q) for q in result.q[i - 2 : i + 3]])
        for k in np.flatnonzero(result.closed[i]):
            # The same material point of the peg before and after, by differences of the pose.
            place = R[2].T @ (result.contact_point[i, k] - result.position[i])
            v = weights @ (result.position[i - 2 : i + 3] + R @ place)
            slip = np.linalg.norm(v)
            assert slip == pytest.approx(result.slip_speed[i, k], rel=1e-6)
            force, N = result.contact_force[i, k], result.normal[i, k]
            # At 4000 times the regularising speed friction lacks 3e-8 of f N.
            assert force @ v / slip == pytest.approx(-scene.friction * N, rel=1e-5)
            assert np.linalg.norm(force) == pytest.approx(
                N * np.hypot(1, scene.friction), rel=1e-5
            )


def test_another_integrator_finds_the_same_motion():
    start, rates, offset = [0.2, 0.5, 0.3], [-0.16, 0.4, 1.5], [-2e-4, 1e-4, -1e-3]
    result = integrate(contact_plan(start, rates, offset))
    p, settings = result.plan, result.plan.holder
    scene = p.configuration.scene
    stiffness = settings.stiffness, settings.rotational_stiffness, settings.damping_ratio
    numbers = holder_numbers(scene, (0.0, 0.0, 0.07), *stiffness)
    arguments = scene_numbers(scene), numbers, *holder_program(p), p.slip_velocity_scale
    other = solve_ivp(
        state_rate, (0, 0.05), [*start, *rates], "LSODA", args=arguments, rtol=1e-10, atol=1e-12
    )
    assert other.y[:3, -1] == pytest.approx(result.q[-1], abs=1e-9)
    assert other.y[3:, -1] == pytest.approx(result.rates[-1], abs=1e-7)


@pytest.mark.parametrize("name", at_push(["closing_with_slip"], SAMPLES))
def test_tolerance_and_step_do_not_show(name, monkeypatch):
    base = truth(name)
    monkeypatch.setattr(contact_run, "MAX_STEP", contact_run.MAX_STEP / 2)
    finer = integrate(replace(plan(name), rtol=base.plan.rtol / 2))
    assert len(finer.t_ns) == len(base.t_ns)
    rows = base.mode == "three_point"
    # Far below the noise of 1e-4 rad and 0.2 N that is put on top.
    assert np.abs(finer.q - base.q)[rows].max() < 1e-9
    assert np.abs(finer.rates - base.rates)[rows].max() < 1e-6
    assert np.abs(finer.normal - base.normal)[rows].max() < 1e-3
    assert np.abs(finer.force - base.force)[rows].max() < 1e-5


@pytest.mark.parametrize("name", SAMPLES)
def test_samples_are_finite_and_no_contact_pulls(name):
    result = truth(name)
    for field in ("q", "rates", "normal", "slip_speed", "force", "moment", "contact_force"):
        assert np.isfinite(getattr(result, field)).all(), field
    assert np.array_equal(np.unique(np.diff(result.t_ns)), [1_000_000])
    # Rounding where the contact begins.
    assert result.normal.min() > -1e-9
    assert result.normal[~result.closed].max(initial=0) == 0
    assert np.array_equal(result.known, result.mode != "unknown") or name == "working_cycle"


def test_sensor_reads_no_jump_but_where_contact_changes():
    result = truth("working_cycle")
    jump = np.abs(np.diff(sensor_wrench(result)[:, :3], axis=0)).max(axis=1)
    transition = next(t for t, what in result.events if "transition" in what)
    near = np.abs(result.t_ns[1:] - transition) < 2e6
    # B1 and B2 become one, and what the difference between them held along e is the holder's.
    assert jump[near].max() < 0.5
    # The lift-off unloads at 0.29 N a sample.
    assert jump[~near].max() < 0.4


def test_closing_without_slip_wedges_where_the_numpy_model_is_singular():
    result = truth("closing_without_slip")
    assert result.ended_by == "jammed"
    (t_wedged, wedged), (_, limit) = result.events
    assert "wedged at gamma = 0.0651" in wedged
    assert "stayed until the holder's limit" in limit
    sliding = result.t_ns < t_wedged
    scene = result.plan.configuration.scene
    gamma = result.q[sliding][-1, 0]
    low, high = (
        np.polyval(reference.friction_cubic(scene, [g, 0, 0], [-0.14, 0, 0], 1e-5)[::-1], 0.2)
        for g in (gamma - 2e-4, gamma)
    )
    assert low < 0 < high
    assert result.known[sliding].all() and not result.known[~sliding].any()
    assert np.abs(result.rates[~sliding]).max() == 0
    assert np.ptp(result.q[~sliding], axis=0).max() == 0
    assert result.normal[sliding].min() > 10
    # The holder goes on pushing the peg that does not move.
    torque = np.linalg.norm(result.moment, axis=1)
    assert torque[-1] > 5 * torque[sliding][-1]
    assert torque[-1] <= result.plan.holder.torque_limit


def test_closing_with_slip_reaches_the_transition():
    result = truth("closing_with_slip")
    assert result.ended_by == "transition"
    assert set(result.mode) == {"three_point"}
    # Less than one sample's motion is left.
    assert 0 < result.q[-1, 0] - result.plan.configuration.scene.gamma0 < 1.6e-4
    assert result.normal.min() > 20


def test_working_cycle_does_all_that_it_names():
    result = truth("working_cycle")
    assert result.ended_by == "end"
    assert 10 <= result.t_ns[-1] * 1e-9 <= 15
    order = [mode for i, mode in enumerate(result.mode) if i == 0 or mode != result.mode[i - 1]]
    assert order == ["open", "three_point", "open", "three_point", "two_point"]
    touching = (result.mode == "three_point") & (result.slip_speed.min(axis=1) > 2e-3)
    for j in range(3):
        rate = result.rates[touching, j]
        assert rate.min() < -0.05 and rate.max() > 0.05
    still = result.phase == "hold_still"
    assert result.slip_speed[still].max() < 5e-5
    assert result.q[-1, 0] == pytest.approx(0.02, abs=1e-9)


def test_a_contact_that_opens_ends_the_simulation():
    phases = {
        "pull": {
            "kind": "contact",
            "duration": 0.1,
            "rates": [-0.16, 0, 0],
            "offset": [1e-3, 0, -5e-4],
        }
    }
    result = integrate(contact_plan([0.22, 0, 0], [-0.16, 0, 0], [-5e-4, 0, -5e-4], phases=phases))
    assert result.ended_by == "contact K opened"
    assert "contact K opened at gamma" in result.events[-1][1]
    assert 5e6 < result.t_ns[-1] < 8e7
    assert result.normal.min() >= 0
    # Less than one more sample unloads.
    assert result.normal[-1, 0] < 0.5


def test_a_contact_open_from_the_begin_is_refused():
    open_K = contact_plan([0.28, 0, 0], [-0.16, 0, 0], [5e-4, 0, -2e-4])
    with pytest.raises(PegOnHoleError, match="nothing is left to record: contact K opened at"):
        integrate(open_K)


def test_an_overload_ends_the_simulation():
    rates = [-0.16, 0, 2.0]
    phases = {
        "push": {"kind": "contact", "duration": 0.2, "rates": rates, "offset": [0, 0, -3e-3]}
    }
    limit = {"force_limit": 30.0}
    heavy = contact_plan([0.2, 0, 0], rates, [0, 0, -1e-3], phases=phases, holder=limit)
    result = integrate(heavy)
    assert result.ended_by == "force limit"
    load = np.linalg.norm(result.force, axis=1)
    assert 29.5 < load[-1] <= 30.0


def test_a_touch_down_off_the_touching_pose_is_refused():
    phases = {
        "approach": {"kind": "free", "duration": 0.1, "offset": [0, 0, 0.001]},
        "land": {"kind": "contact", "duration": 0.1},
    }
    off = contact_plan([0.3, 0, 0], [0, 0, 0], [0, 0, 0.01], phases=phases)
    with pytest.raises(PegOnHoleError, match="phases.land begins in contact, but the peg is"):
        integrate(off)


def test_leaving_without_lift_off_is_refused():
    phases = {
        "press": {"kind": "contact", "duration": 0.05, "rates": [0, 0, 1.0]},
        "leave": {"kind": "free", "duration": 0.1, "offset": [0, 0, 0.01]},
    }
    stays = contact_plan([0.3, 0, 0], [0, 0, 1.0], [0, 0, -5e-4], phases=phases)
    with pytest.raises(PegOnHoleError, match="phases.leave is free, but the contacts still carry"):
        integrate(stays)


def test_guidance_into_the_rim_is_refused():
    phases = {"dive": {"kind": "free", "duration": 0.1, "offset": [0, 0, -0.01]}}
    cuts = contact_plan([0.3, 0, 0], [0, 0, 0], [0, 0, 0.001], phases=phases)
    with pytest.raises(PegOnHoleError, match="phases.dive: the guided peg would cut .* mm into"):
        integrate(cuts)


def test_friction_jumps_where_a_phase_says_so():
    rates = [-0.16, 0, 2.0]
    phases = {
        "before": {"kind": "contact", "duration": 0.05, "rates": rates},
        "after": {"kind": "contact", "duration": 0.05, "rates": rates, "friction": 0.35},
    }
    result = integrate(contact_plan([0.2, 0, 0], rates, [0, 0, -1e-3], phases=phases))
    assert result.ended_by == "end" and len(result.t_ns) == 81
    # |F| = N sqrt(1 + f^2) at a contact that slides: normal and friction stand at right angles.
    share = np.linalg.norm(result.contact_force, axis=2) / result.normal
    for name, friction in (("before", 0.2), ("after", 0.35)):
        chosen = result.phase == name
        # The last sample before the jump is that of the jump itself.
        chosen[np.flatnonzero(chosen)[[0, -1]]] = False
        np.testing.assert_allclose(share[chosen], np.hypot(1, friction), rtol=1e-4)
    # Rates go on without a step: friction's moment of 0.1 N m on Iz makes some 200 rad/s^2.
    assert np.abs(np.diff(result.rates, axis=0)).max() < 0.2


def test_friction_of_a_phase_that_lets_go_is_refused():
    phases = {"leave": {"kind": "lift_off", "duration": 0.1, "friction": 0.3}}
    with pytest.raises(PegOnHoleError, match="phases.leave.friction is for contact, two_point"):
        contact_plan([0.2, 0, 0], [0, 0, 1.0], [0, 0, -1e-3], phases=phases)


def test_without_friction_the_peg_slides_and_contacts_push_along_their_normals():
    smooth = replace(Configuration(), scene=Scene(friction=0.0))
    turning = contact_plan(
        [0.2, 0.5, 0.3], [-0.16, 0.4, 1.5], [-2e-4, 1e-4, -1e-3], configuration=smooth
    )
    result = integrate(replace(turning, wrench_rate=10000))
    assert result.ended_by == "end"
    assert set(result.mode) == {"three_point"}
    # As with friction, see above.
    force, moment = momentum_residuals(result, range(10, len(result.t_ns) - 10, 7))
    assert force < 1e-4
    assert moment < 1e-6
    assert result.normal.min() > 1
    size = np.linalg.norm(result.contact_force, axis=2)
    np.testing.assert_allclose(size, result.normal, rtol=1e-12)


def test_friction_that_a_phase_takes_away_does_not_wedge():
    rates = [-0.16, 0, 2.0]
    phases = {
        "before": {"kind": "contact", "duration": 0.05, "rates": rates},
        "after": {"kind": "contact", "duration": 0.05, "rates": rates, "friction": 0.0},
    }
    result = integrate(contact_plan([0.2, 0, 0], rates, [0, 0, -1e-3], phases=phases))
    assert result.ended_by == "end" and len(result.t_ns) == 81
