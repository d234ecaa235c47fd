"""`peg-on-hole solve --unknown`: forces for a motion, motion for forces, and mixes."""

import json

import pytest

import rigid_body_oracle as oracle
from cli_helpers import config, fails
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.mechanics.scene import Scene

STATE = "0.1,0.3,-0.2,-0.16,0.4,2"
UNKNOWN = "N_K,N_B1,N_B2,M_x,M_y,M_z"


def solved(capsys, *arguments):
    assert main(["solve", "--state", STATE, "--json", *arguments]) == 0
    return json.loads(capsys.readouterr().out)


def test_the_couple_that_a_motion_needs_gives_that_motion(capsys):
    accelerations = {"ddgamma": 0.5, "ddpsi": -0.3, "ddphi": 1.0}
    known = ",".join(f"{name}={value}" for name, value in accelerations.items())
    found = solved(capsys, "--unknown", UNKNOWN, "--known", known, "--known", "F_z=-10")
    assert found["solvability"] == "unique" and found["reason"] == "" and not found["pulling"]
    assert list(found["values"]) == UNKNOWN.split(",")
    assert found["units"] == dict(zip(UNKNOWN.split(","), ["N"] * 3 + ["N m"] * 3))
    assert found["known"]["F_x"] == 0 and found["known"]["F_z"] == -10
    # By a body that is built from distances alone.
    moment = [found["values"][name] for name in ("M_x", "M_y", "M_z")]
    body = oracle.Body(Scene(), [0.1, 0.3, -0.2], [-0.16, 0.4, 2], [0, 0, -10], moment)
    y = oracle.newton_euler(body)
    assert y[:3] == pytest.approx(list(accelerations.values()), abs=1e-6)
    assert y[3:] == pytest.approx([found["values"][n] for n in UNKNOWN.split(",")[:3]], rel=1e-7)


def test_motion_from_forces_is_what_solve_says_without_unknowns(capsys):
    found = solved(
        capsys, "--unknown", "ddgamma,ddpsi,ddphi,N_K,N_B1,N_B2", "--known", "F_x=1,M_y=-0.3"
    )
    plain = solved(capsys, "--wrench", "1,0,0,0,-0.3,0")
    expected = [*plain["acceleration"].values(), *plain["normal"].values()]
    assert list(found["values"].values()) == pytest.approx(expected, rel=1e-9)


def test_axes_of_the_wrench_are_those_of_the_frame(capsys):
    # One couple in two frames: its size is the same, its parts are not.
    sizes, parts = [], []
    for frame, names in (("hole", "M_x,M_y,M_z"), ("moving", "M_eps,M_eta,M_zeta")):
        found = solved(capsys, "--frame", frame, "--unknown", f"N_K,N_B1,N_B2,{names}")
        parts.append([found["values"][name] for name in names.split(",")])
        sizes.append(sum(x * x for x in parts[-1]) ** 0.5)
    assert sizes[0] == pytest.approx(sizes[1], rel=1e-9)
    assert parts[0] != pytest.approx(parts[1], rel=0.1)


def test_what_cannot_be_told_is_an_answer(capsys):
    # phi'' is a moment in the plane of h and z: the two components do what it does.
    names = "N_K,N_B1,N_B2,ddphi,M_h,M_z"
    found = solved(capsys, "--frame", "auxiliary", "--unknown", names)
    assert found["solvability"] != "unique" and found["reason"]
    assert set(found["together"]) == {"ddphi", "M_h", "M_z"}
    assert main(["solve", "--state", STATE, "--unknown", "N_K"]) == 0
    text = capsys.readouterr().out
    assert "solvability: contradictory (no value of these unknowns fits the knowns" in text
    assert "known: all zero" in text


def test_a_contact_that_would_pull_is_named_in_words(capsys):
    assert main(["solve", "--state", "0.3,0,0,-0.16,0,0", "--unknown", UNKNOWN]) == 0
    assert "N_K would have to pull: that contact is open" in capsys.readouterr().out


def test_the_scene_is_that_of_the_configuration(tmp_path, capsys):
    heavy = config(tmp_path, "scene: {peg_mass: 5.0}")
    light = solved(capsys, "--unknown", UNKNOWN)["values"]
    found = solved(capsys, "--config", str(heavy), "--unknown", UNKNOWN)["values"]
    assert found == pytest.approx({name: 10 * x for name, x in light.items()}, rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["--known", "N_K=1"],
            "--known needs --unknown: name the quantities to solve for, such as --unknown "
            "N_K,N_B1,N_B2",
        ),
        (
            ["--frame", "peg"],
            "--frame needs --unknown: name the quantities to solve for, such as --unknown "
            "N_K,N_B1,N_B2",
        ),
        (
            ["--unknown", "N_K", "--wrench", "1,0,0,0,0,0"],
            "--wrench = 1,0,0,0,0,0 beside --unknown: state what is known of the wrench as "
            "--known F_x=...,M_z=... in the axes of --frame",
        ),
        (
            ["--unknown", "N_K", "--known", "N_B1"],
            "--known N_B1 is not NAME=VALUE with a number, such as N_K=20",
        ),
        (
            ["--unknown", "N_K", "--known", "F_x=1e12"],
            "--known F_x=1e12: 1e+12 N is not within -1e+09 to 1e+09 N; quantities are in SI "
            "units",
        ),
        (
            ["--unknown", "N_K", "--known", "M_z=nan"],
            "--known M_z=nan: nan N m is not within -1e+09 to 1e+09 N m; quantities are in SI "
            "units",
        ),
        (
            ["--unknown", "N_K", "--known", "F_x=1,F_x=2"],
            "--known F_x is given twice: leave one of them out",
        ),
        (
            ["--unknown", "N_A"],
            "'N_A' is none of the quantities ddgamma, ddpsi, ddphi, N_K, N_B1, N_B2, F_x, F_y, "
            "F_z, M_x, M_y, M_z",
        ),
        (
            ["--unknown", ""],
            "0 unknowns: six equations determine one to six; declare others known",
        ),
    ],
)
def test_a_declaration_that_is_none_is_refused(arguments, message, capsys):
    fails(capsys, 2, message, "solve", "--state", STATE, *arguments)
