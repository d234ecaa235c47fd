"""A peg that has lost a contact: six degrees of freedom on the contacts that are left."""

from dataclasses import replace

import numpy as np
import pytest
from test_simulation_truth import momentum_residuals

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.sim.contact_run import contact_samples
from peg_on_hole_ros.sim.dynamics import contacts
from peg_on_hole_ros.sim.parted import (
    CONTACT_STIFFNESS,
    parted_motion,
    parted_state,
    pushes,
    run_parted,
)
from peg_on_hole_ros.sim.run import Run
from peg_on_hole_ros.sim.truth import integrate
from simulated import contact_plan

pytestmark = pytest.mark.xdist_group("simulation")
CLOSING = [-0.16, 0, 0]


def tipped(back=False, **changes):
    """Closing without slip; a sideways pull opens K, and in the end may press it on again."""
    phases = {
        "pull": {"kind": "parted", "duration": 0.08, "rates": CLOSING, "offset": [1e-3, 0, -5e-4]}
    }
    if back:
        phases["press"] = {
            "kind": "parted", "duration": 0.08, "rates": CLOSING, "offset": [-4e-3, 0, -5e-4]
        }  # fmt: skip
    plan = contact_plan([0.22, 0, 0], CLOSING, [-5e-4, 0, -5e-4], phases=phases)
    return integrate(replace(plan, **changes))


@pytest.fixture(scope="module")
def opened():
    return tipped(wrench_rate=10000)


def test_goes_on_where_a_contact_opened(opened):
    assert opened.ended_by == "contact K opened"
    assert "the program is over" in opened.events[-1][1]
    k = int(np.argmin(opened.closed[:, 0]))
    assert 0.001 < opened.t_ns[k] * 1e-9 < 0.06
    assert opened.t_ns[-1] == pytest.approx(60_000_000, abs=1)
    assert (opened.normal[k:, 0] == 0).all() and (opened.normal[:, 1:] > 1).all()
    assert set(opened.mode[k:]) == {"unknown"} and opened.known.all()
    # Nothing jumps: less than a newton a tenth of a millisecond, as before.
    assert np.abs(np.diff(opened.normal, axis=0)).max() < 0.5
    assert np.abs(np.diff(opened.force, axis=0)).max() < 0.5


def test_forces_and_moments_balance(opened):
    k = int(np.argmin(opened.closed[:, 0]))
    rows = range(k + 100, len(opened.t_ns) - 10, 23)
    assert len(rows) > 5
    force, moment = momentum_residuals(opened, rows)
    # The contacts still ring at some 3 kHz, which differences over 0.1 ms see coarsely.
    assert force < 0.05
    assert moment < 1e-3


def test_a_contact_touches_again_when_it_is_pressed():
    result = tipped(back=True)
    k = int(np.argmin(result.closed[:, 0]))
    again = k + int(np.argmax(result.closed[k:, 0]))
    assert result.t_ns[again] > result.t_ns[k] + 10_000_000
    assert result.mode[-1] == "three_point" and result.normal[-1].min() > 1


def test_agrees_with_rigid_contacts_while_all_are_closed():
    """A hundred newtons press steel in by a micrometre; what that does to the motion is small."""
    rates = [-0.16, 0.2, 1.5]
    plan = contact_plan([0.2, 0, 0], rates, [-2e-4, 0, -1e-3])
    rigid = integrate(plan)
    model = Run(plan, None).model
    start = np.concatenate([rigid.q[0], rigid.rates[0]])
    t = plan.lead_in + rigid.t_ns * 1e-9
    y = parted_state(model, start, rigid.normal[0])
    soft = run_parted(model, t[0], y, t, t[-1], (1e3, 1e3), 1e-8)
    assert soft.ended_by == "end" and len(soft.t) == len(t)
    np.testing.assert_allclose(soft.states[:, :3], rigid.q, atol=2e-5)
    normal = np.array(
        [pushes(model.p, _levels(s), model.scale, CONTACT_STIFFNESS)[2] for s in soft.states]
    )
    np.testing.assert_allclose(normal[-10:], rigid.normal[-10:], rtol=0.03)


def test_contacts_that_give_begin_with_the_loads_of_rigid_ones():
    rates = [-0.16, 0.2, 1.5]
    plan = contact_plan([0.2, 0.4, 0.1], rates, [-2e-4, 0, -1e-3])
    model = Run(plan, None).model
    state = np.array([0.2, 0.4, 0.1, *rates])
    _, normal, force, moment = contact_samples(model, np.zeros(1), state[None])
    y = parted_state(model, state, normal[0])
    points, forces, pushed, slip = pushes(model.p, _levels(y), model.scale, CONTACT_STIFFNESS)
    np.testing.assert_allclose(pushed, normal[0], rtol=1e-3)
    _, velocity, _, _ = contacts(model.p, state[:3], state[3:], model.scale)
    np.testing.assert_allclose(slip, np.linalg.norm(velocity, axis=1), rtol=1e-3)
    # The peg has moved by a few micrometres, on a spring of 2e4 N/m.
    motion = parted_motion(0.0, y, *model, CONTACT_STIFFNESS)
    np.testing.assert_allclose(motion[6:9], force[0], atol=0.5)
    np.testing.assert_allclose(motion[9:], moment[0], atol=0.02)


def _levels(y):
    x = np.zeros((3, 6))
    x[0], x[1] = y[:6], y[6:]
    return x


def test_what_cannot_follow_is_refused():
    phases = {
        "tip": {"kind": "parted", "duration": 0.05},
        "go": {"kind": "contact", "duration": 0.05},
    }
    with pytest.raises(PegOnHoleError, match="phases.go: contact does not follow parted"):
        contact_plan([0.2, 0, 0], CLOSING, [0, 0, -1e-3], phases=phases)
