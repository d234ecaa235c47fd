"""Numbers that are none are refused wherever states and wrenches enter; no NaN leaves."""

import numpy as np
import pytest

from paper import examples, small_tilt, two_point, velocities, wedging
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics import any_side, checks
from peg_on_hole_ros.mechanics.scene import Scene

SCENE, NAN = Scene(), float("nan")
STATE, RATES = [0.2, 0.0, 0.0], [-0.16, 0.0, 1.0]

ENTRIES = {
    "solve_any": lambda q, rates: any_side.solve_any(SCENE, q, rates, any_side.REACTIONS),
    "contact_velocities": lambda q, rates: velocities.contact_velocities(SCENE, q, rates),
    "friction_cosines": lambda q, rates: velocities.friction_cosines(SCENE, q, rates),
    "generalized_forces": lambda q, rates: velocities.generalized_forces(
        SCENE, q, rates, np.ones(3)
    ),
    "wedging": lambda q, rates: wedging.wedging(SCENE, q, rates),
}


@pytest.mark.parametrize("name", ENTRIES)
def test_a_state_must_be_three_finite_numbers(name):
    entry = ENTRIES[name]
    entry(STATE, RATES)
    with pytest.raises(PegOnHoleError, match=r"state = \[0.2 nan 0. \] rad is not finite"):
        entry([0.2, NAN, 0.0], RATES)
    with pytest.raises(PegOnHoleError, match=r"rates = \[-0.16  0.     inf\] rad/s is not finite"):
        entry(STATE, [-0.16, 0.0, np.inf])
    with pytest.raises(PegOnHoleError, match=r"rates has shape \(2,\), not \(3, ...\)"):
        entry(STATE, [-0.16, 0.0])
    # Degrees for radians.
    with pytest.raises(PegOnHoleError, match="gamma = 11.5 rad .* degrees must be converted"):
        entry([11.5, 0.0, 0.0], RATES)


def test_other_entries():
    with pytest.raises(PegOnHoleError, match="rates = .* rad/s is not finite"):
        examples.imposed(SCENE, 0.2, [NAN, 0, 0])
    with pytest.raises(PegOnHoleError, match="gamma = nan rad is not finite"):
        examples.imposed(SCENE, NAN, RATES)
    with pytest.raises(PegOnHoleError, match="rates = .* rad/s is not finite"):
        examples.imposed_two_point(SCENE, 0.05, [NAN, 0, 0])
    with pytest.raises(PegOnHoleError, match="rates = .* rad/s is not finite"):
        small_tilt.reactions(SCENE, 1e-4, [NAN, 0, 0])
    with pytest.raises(PegOnHoleError, match="not along -z"):
        small_tilt.reactions(Scene(gravity=(1.0, 0.0, -9.0)), 1e-4, RATES)
    with pytest.raises(PegOnHoleError, match="gamma - gamma0 = 0 rad is not above 0"):
        small_tilt.stage(SCENE, 0.0)
    with pytest.raises(PegOnHoleError, match="wrench = .* N, N m is not finite"):
        two_point.solve_two_point(SCENE, [0.05, 0, 0, 0], [0, 0, 0, 0], [0, 0, NAN, 0, 0, 0])
    with pytest.raises(PegOnHoleError, match="force = 'hard' is not numbers in N"):
        checks.require_finite("force", "N", "hard")


def test_stages_of_alignment():
    found = [small_tilt.stage(SCENE, e).name for e in (1e-3, 0.05, 0.29, 0.5)]
    assert found == ["SMALL", "MEDIUM", "MEDIUM", "LARGE"]
    assert small_tilt.stage(Scene(peg_diameter=0.05 - 1e-7), 0.1).name == "LARGER"
