"""Read what is to be simulated: the part `simulation: ros__parameters:` of a parameters file."""

from pathlib import Path

from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.parameters_file import load_yaml, read_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.sim.plan import Plan, plan_from_tree

SIMULATION_PART, _BODY = "simulation", "ros__parameters"


def read_plan(path: str | Path) -> Plan:
    """
    Return the plan of a file that holds the estimator's parameters and the simulator's.

    Raises
    ------
    PegOnHoleError
        No such file, no YAML, no such part, unknown name, value out of range, a list by which
        ROS 2 refuses the whole file, the estimator's part too.

    """
    path = Path(path)
    parameters = read_parameters(path)
    part = load_yaml(path).get(SIMULATION_PART)
    if not isinstance(part, dict) or list(part) != [_BODY] or not isinstance(part[_BODY], dict):
        raise PegOnHoleError(
            f"{path} has no part '{SIMULATION_PART}:' with '{_BODY}:' below it, so there "
            "is no motion to simulate; config/working_cycle.yaml is an example"
        )
    try:
        _check_lists(part[_BODY], f"{SIMULATION_PART}.")
        return plan_from_tree(from_parameters(parameters), part[_BODY])
    except PegOnHoleError as error:
        raise PegOnHoleError(f"{path}: {error}") from None


def _check_lists(tree, prefix):
    for key, value in tree.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            _check_lists(value, f"{name}.")
        elif isinstance(value, list) and len({type(item) for item in value}) > 1:
            raise PegOnHoleError(
                f"{name} = {value} has values of several types, for which ROS 2 does not read the "
                "file; a double needs its point (0.0, not 0)"
            )
