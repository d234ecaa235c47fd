"""Read what is to be simulated: the part `simulation: ros__parameters:` of a parameters file."""

from pathlib import Path

from peg_on_hole_ros.configuration import from_parameters
from peg_on_hole_ros.edges.config_file import load_yaml, read_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.simulation.plan import Plan, plan_from_tree

PART, _BODY = "simulation", "ros__parameters"


def read_plan(path: str | Path) -> Plan:
    """
    Return the plan of a file that holds the estimator's parameters and the simulator's.

    Raises
    ------
    PegOnHoleError
        No such file, no YAML, no such part, unknown name, value out of range.

    """
    path = Path(path)
    parameters = read_parameters(path)
    part = load_yaml(path).get(PART)
    if not isinstance(part, dict) or list(part) != [_BODY] or not isinstance(part[_BODY], dict):
        raise PegOnHoleError(
            f"{path} has no part '{PART}:' with '{_BODY}:' below it, so it says nothing of what "
            "to simulate; config/working_cycle.yaml is an example"
        )
    try:
        return plan_from_tree(from_parameters(parameters), part[_BODY])
    except PegOnHoleError as error:
        raise PegOnHoleError(f"{path}: {error}") from None
