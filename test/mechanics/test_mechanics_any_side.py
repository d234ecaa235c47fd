"""One solver for every declared set: what one set gives, another returns."""

import itertools

import numpy as np
import pytest

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics import any_side, reference
from peg_on_hole_ros.mechanics.any_side import (
    ACCELERATIONS,
    REACTIONS,
    Solvability,
    frame_axes,
    solve_any,
)
from peg_on_hole_ros.mechanics.scene import Scene

SCENE = Scene(gravity=(0.5, 0.2, -9.5))
Q, RATES = np.array([0.2, 0.4, -0.7]), np.array([-0.16, 0.3, 2.0])
FORCE, MOMENT = np.array([1.0, -2.0, -8.0]), np.array([0.02, 0.1, 0.03])


def answer(frame):
    """Return all twelve quantities of one motion under a wrench given in hole axes."""
    solution = reference.solve_contact(SCENE, Q, RATES, FORCE, MOMENT)
    turn = frame_axes(frame, Q) @ frame_axes("hole", Q).T
    numbers = np.concatenate([solution.acceleration, solution.normal, turn @ FORCE, turn @ MOMENT])
    return dict(zip(any_side.quantities(frame), numbers, strict=True))


@pytest.mark.parametrize("frame", ["hole", "auxiliary", "moving", "peg"])
def test_motion_from_forces_and_forces_from_motion(frame):
    full = answer(frame)
    wrench = any_side.quantities(frame)[6:]
    for unknown in (
        ACCELERATIONS + REACTIONS,
        wrench,
        ("ddpsi", "ddphi", *REACTIONS, wrench[4]),
        (*REACTIONS, *wrench[3:]),
    ):
        known = {name: value for name, value in full.items() if name not in unknown}
        found = solve_any(SCENE, Q, RATES, unknown, known, frame)
        assert found.solvability is Solvability.UNIQUE and not found.reason
        for name in unknown:
            assert found.values[name] == pytest.approx(full[name], rel=1e-9, abs=1e-9), name


def test_every_set_of_six_is_solved_or_refused_with_a_reason():
    full = answer("auxiliary")
    counts = dict.fromkeys(Solvability, 0)
    for unknown in itertools.combinations(full, 6):
        known = {name: value for name, value in full.items() if name not in unknown}
        found = solve_any(SCENE, Q, RATES, unknown, known)
        counts[found.solvability] += 1
        # The knowns are of one motion: they never contradict each other.
        assert found.residual < 1e-8
        if found.solvability is Solvability.UNIQUE:
            for name in unknown:
                assert found.values[name] == pytest.approx(full[name], rel=1e-6, abs=1e-6)
        else:
            assert found.together and found.reason
            # Moving one of them by hand, the others can follow: there is another solution.
            free = found.together[0]
            others = [name for name in unknown if name != free]
            moved = known | {free: found.values[free] + 1}
            assert solve_any(SCENE, Q, RATES, others, moved).residual < 1e-8
    assert counts[Solvability.CONTRADICTORY] == 0
    assert counts[Solvability.UNIQUE] == 749 and sum(counts.values()) == 924


def test_components_that_do_the_same_are_named():
    # B1 against B2 pushes along e; so does F_e, and M_z, M_h undo what that turns.
    scene, state = Scene(friction=0.0), ([0.2, 0, 0], [-0.16, 0, 0])
    motion = solve_any(scene, *state, ACCELERATIONS + REACTIONS)
    unknown = (*REACTIONS, "F_e", "M_h", "M_z")
    found = solve_any(scene, *state, unknown, {"ddgamma": motion.values["ddgamma"]})
    assert found.solvability is Solvability.UNDETERMINED
    assert found.together == ("N_B1", "N_B2", "F_e", "M_h", "M_z")
    assert "only one combination of N_B1, N_B2, F_e, M_h, M_z enters" in found.reason
    assert found.values["N_K"] == pytest.approx(motion.values["N_K"])


@pytest.mark.parametrize(
    "set_",
    [
        ("ddphi", "M_h", "M_z"),
        ("ddgamma", "F_h", "F_z", "M_e"),
        ("ddpsi", "F_e", "M_h", "M_z"),
        ("ddpsi", "ddphi", "F_e", "M_h"),
        ("ddpsi", "ddphi", "F_e", "M_z"),
    ],
)
def test_accelerations_cannot_be_told_from_their_own_inertia(set_):
    full = answer("auxiliary")
    known = {name: value for name, value in full.items() if name not in set_}
    found = solve_any(SCENE, Q, RATES, set_, known)
    assert found.solvability is Solvability.UNDETERMINED and set(found.together) == set(set_)
    # One less, any one, and the rest follows.
    for name in set_:
        rest = [x for x in set_ if x != name]
        less = solve_any(SCENE, Q, RATES, rest, known | {name: full[name]})
        assert less.solvability is Solvability.UNIQUE


def test_contradictory_knowns_name_the_equation():
    # No moment and no force along e: psi'' cannot be had from a known, unfit one.
    found = solve_any(
        Scene(friction=0.0),
        [0.2, 0, 0],
        [0, 0, 0],
        ("ddgamma", "N_K", "N_B1", "N_B2"),
        {"ddpsi": 3.0},
    )
    assert found.solvability is Solvability.CONTRADICTORY
    assert "Lagrange's equation of psi" in found.reason


def test_mixed_problems_of_the_paper():
    # gamma prescribed (uniform), psi and phi free, a couple about eps and all reactions wanted.
    unknown = ("ddpsi", "ddphi", *REACTIONS, "M_eps")
    found = solve_any(SCENE, Q, RATES, unknown, {"ddgamma": 0.0}, "moving")
    assert found.solvability is Solvability.UNIQUE
    moment = frame_axes("hole", Q) @ frame_axes("moving", Q).T @ [found.values["M_eps"], 0, 0]
    back = reference.solve_contact(SCENE, Q, RATES, np.zeros(3), moment)
    assert back.acceleration[0] == pytest.approx(0, abs=1e-9)
    assert back.normal[0] == pytest.approx(found.values["N_K"], rel=1e-9)
    # A holder that gives a moment only.
    found = solve_any(SCENE, Q, RATES, (*REACTIONS, "M_h", "M_e", "M_z"))
    assert found.solvability is Solvability.UNIQUE


def test_arrays_over_time_from_the_same_call():
    gamma = np.linspace(0.08, 0.4, 5)
    q = np.array([gamma, 0 * gamma + 0.1, gamma])
    many = solve_any(SCENE, q, RATES, ACCELERATIONS + REACTIONS, {"F_z": -gamma, "M_e": 0.1})
    for k in range(5):
        one = solve_any(
            SCENE, q[:, k], RATES, ACCELERATIONS + REACTIONS, {"F_z": -gamma[k], "M_e": 0.1}
        )
        for name, value in one.values.items():
            assert many.values[name][k] == pytest.approx(value, rel=1e-9, abs=1e-9)


def test_a_pulling_reaction_is_named():
    found = solve_any(Scene(), [0.3, 0, 0], [-0.16, 0, 0], ACCELERATIONS + REACTIONS)
    assert found.pulling == ("N_K",)


@pytest.mark.parametrize(
    "unknown, known, message",
    [
        (("N_C",), {}, "'N_C' is none of the quantities ddgamma, ddpsi"),
        (("N_K",), {"N_K": 1.0}, "N_K named twice"),
        ((), {}, "0 unknowns: six equations determine one to six"),
        (ACCELERATIONS + REACTIONS + ("F_h",), {}, "7 unknowns"),
        (("N_K",), {"F_z": np.nan}, "F_z = nan is not finite"),
    ],
)
def test_a_wrong_declaration_is_refused(unknown, known, message):
    with pytest.raises(PegOnHoleError, match=message):
        solve_any(SCENE, Q, RATES, unknown, known)
