"""`peg-on-hole solve --unknown`: any of the twelve quantities from the others."""

from collections.abc import Sequence

from peg_on_hole_ros.cli.table import finite, table
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.any_side import ACCELERATIONS, REACTIONS, quantities, solve_any
from peg_on_hole_ros.mechanics.scene import Scene

# Beyond, squares overflow.
_LARGEST_VALUE = 1e9


def solve(
    scene: Scene, state: Sequence[float], unknown: str, known: list[str], frame: str
) -> dict:
    """
    Return the JSON of the unknowns.

    Parameters
    ----------
    scene : Scene
    state : list of 6 float
        gamma, psi, phi [rad], their rates [rad/s].
    unknown : str
        One to six names with commas between.
    known : list of str
        Texts `NAME=VALUE`, several with commas between; what is not named is zero.
    frame : str
        Of the applied wrench's components.

    Raises
    ------
    PegOnHoleError

    """
    names = [name.strip() for name in unknown.split(",") if name.strip()]
    given = _given(known)
    found = solve_any(scene, state[:3], state[3:], names, given, frame)
    return {
        "frame": frame,
        "known": {
            name: given.get(name, 0.0) for name in quantities(frame) if name not in found.values
        },
        "values": {name: finite(value) for name, value in found.values.items()},
        "units": {name: _unit(name) for name in found.values},
        "solvability": found.solvability.name.lower(),
        "meaning": found.solvability.value,
        "reason": found.reason,
        "together": list(found.together),
        "pulling": list(found.pulling),
        "residual": finite(found.residual),
    }


def text(result: dict) -> str:
    """Return the same in words."""
    rows = [
        (name, "-" if value is None else f"{value:.6g}", result["units"][name])
        for name, value in result["values"].items()
    ]
    lines = [table(("unknown", "value", "unit"), rows), ""]
    given = [f"{name} = {value:g}" for name, value in result["known"].items() if value]
    lines.append(f"known: {', '.join(given) or 'all zero'}" + (", others zero" if given else ""))
    reason = f": {result['reason']}" if result["reason"] else ""
    lines.append(f"solvability: {result['solvability']} ({result['meaning']}){reason}")
    if result["pulling"]:
        lines.append(
            f"{', '.join(result['pulling'])} would have to pull: that contact is open, and this "
            "is no motion on three points"
        )
    return "\n".join(lines)


def _given(texts):
    given = {}
    for part in (part for text in texts for part in text.split(",") if part.strip()):
        name, _, value = (word.strip() for word in part.partition("="))
        try:
            number = float(value)
        except ValueError:
            raise PegOnHoleError(
                f"--known {part.strip()} is not NAME=VALUE with a number, such as N_K=20"
            ) from None
        if not abs(number) <= _LARGEST_VALUE:
            raise PegOnHoleError(
                f"--known {part.strip()}: {number:g} {_unit(name)} is not within "
                f"-{_LARGEST_VALUE:g} to {_LARGEST_VALUE:g} {_unit(name)}; "
                "quantities are in SI units"
            )
        if name in given:
            raise PegOnHoleError(f"--known {name} is given twice: leave one of them out")
        given[name] = number
    return given


def _unit(name):
    if name in ACCELERATIONS:
        return "rad/s^2"
    return "N" if name in REACTIONS or name.startswith("F_") else "N m"
