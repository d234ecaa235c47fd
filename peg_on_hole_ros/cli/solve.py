"""`peg-on-hole solve`: the six equations at one state."""

import argparse
from collections.abc import Sequence

import numpy as np

from peg_on_hole_ros.cli import solve_unknowns
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.cli.table import finite, table, to_json
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.reference import solve_contact
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.records import ANGLES, CONTACTS

# Beyond, no peg is; squares of what is far beyond overflow. The tilt has a range of its own.
_LARGEST_STATE = (1e6, 1e6, 1e6, 1e4, 1e4, 1e4)
_LARGEST_WRENCH = (1e6,) * 6
_WRENCH_DEFAULT = "0,0,0,0,0,0"


def run(arguments: argparse.Namespace) -> int:
    """Print motion and reactions, or what is declared unknown."""
    configuration, _ = load(arguments.config)
    state = _six("--state", arguments.state, "rad, rad, rad, rad/s, rad/s, rad/s", _LARGEST_STATE)
    if arguments.unknown is not None:
        return _any_side(configuration.scene, state, arguments)
    for name in ("known", "frame"):
        if getattr(arguments, name):
            raise PegOnHoleError(
                f"--{name} needs --unknown: name the quantities to solve for, such as --unknown "
                "N_K,N_B1,N_B2"
            )
    wrench = _six(
        "--wrench", arguments.wrench or _WRENCH_DEFAULT, "N, N, N, N m, N m, N m", _LARGEST_WRENCH
    )
    result = solve(configuration.scene, state, wrench)
    print(to_json(result) if arguments.json else _solution_text(result))
    return 0


def _any_side(scene, state, arguments):
    if arguments.wrench:
        raise PegOnHoleError(
            f"--wrench = {arguments.wrench} beside --unknown: state what is known of the wrench "
            "as --known F_x=...,M_z=... in the axes of --frame"
        )
    frame = arguments.frame or "hole"
    result = solve_unknowns.solve(scene, state, arguments.unknown, arguments.known or [], frame)
    print(to_json(result) if arguments.json else solve_unknowns.text(result))
    return 0


def solve(scene: Scene, state: Sequence[float], wrench: Sequence[float]) -> dict:
    """
    Return the JSON of one solution.

    Parameters
    ----------
    scene : Scene
    state : list of 6 float
        gamma, psi, phi [rad], their rates [rad/s].
    wrench : list of 6 float
        On the peg at its mass centre, hole axes, without gravity [N], [N m].

    """
    try:
        s = solve_contact(scene, state[:3], state[3:], wrench[:3], wrench[3:])
    except np.linalg.LinAlgError:
        raise PegOnHoleError(
            f"the six equations are singular at gamma = {state[0]:g} rad with friction "
            f"{scene.friction:g}: rigid three-point motion has no solution there"
        ) from None
    return {
        "acceleration": dict(zip(ANGLES, map(finite, s.acceleration))),
        "normal": dict(zip(CONTACTS, map(finite, s.normal))),
        "slip_speed": dict(zip(CONTACTS, map(finite, s.slip_speed))),
        "critical_friction": None if s.critical_friction is None else finite(s.critical_friction),
        "outcome": s.outcome.name.lower(),
        "meaning": s.outcome.value,
    }


def _six(name, text, units, most):
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 6 or not np.all(np.isfinite(values)):
        raise PegOnHoleError(f"{name} = {text} is not six finite numbers ({units})")
    for value, limit, unit in zip(values, most, units.split(", ")):
        if abs(value) > limit:
            raise PegOnHoleError(
                f"{name} = {text}: {value:g} {unit} is not within -{limit:g} to {limit:g} {unit}; "
                "all six are in SI units"
            )
    return values


def _solution_text(result):
    angles = table(
        ("", *ANGLES),
        [("acceleration [rad/s^2]", *(f"{result['acceleration'][a]:.6g}" for a in ANGLES))],
    )
    contacts = table(
        ("", *CONTACTS),
        [
            ("normal [N]", *(f"{result['normal'][c]:.6g}" for c in CONTACTS)),
            ("slip_speed [m/s]", *(f"{result['slip_speed'][c]:.6g}" for c in CONTACTS)),
        ],
    )
    critical = result["critical_friction"]
    critical = "none" if critical is None else f"{critical:.6g}"
    outcome = f"{result['outcome']} ({result['meaning']})"
    return f"{angles}\n\n{contacts}\n\ncritical friction: {critical}\noutcome: {outcome}"
