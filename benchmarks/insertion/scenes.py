"""
Drawn insertions down the hole: normal ones, pegs that jam, that wedge, and that are freed.

Scenes of the set `tuning` are others than those of `scoring`; a case gives the same plan every
time. Whether a peg is stuck, and why, is read off the truth, never off the family.
"""

from benchmarks.harness.draw import Draw, DrawnCase
from benchmarks.insertion.families import FAMILY, LEAD_IN
from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.sim.plan import Plan, plan_from_tree

FAMILIES = tuple(FAMILY)
SEEDS = {"scoring": 8_200, "tuning": 4_700}
# Of 300.
SHARES = {"normal": 100, "jammed": 70, "wedged": 50, "freed": 80}


class Case(DrawnCase):
    """One insertion."""

    __slots__ = ()
    SEEDS, FAMILIES = SEEDS, FAMILIES


def cases(count: int = 300, of: str = "scoring") -> list[Case]:
    """Return about so many cases, families in their shares."""
    share = count / sum(SHARES.values())
    return [
        Case(family, number, of)
        for family, all_of_it in SHARES.items()
        for number in range(max(1, round(all_of_it * share)))
    ]


def plan_of(case: Case) -> Plan:
    """Return what is simulated; the same case gives the same plan."""
    setting, start, phases = FAMILY[case.family](Draw(case.seed))
    configuration = Configuration(
        scene=setting.scene,
        wrench=WrenchInput(
            sensor_xyz=(0.0, 0.0, setting.sensor_height),
            force_stddev=0.2 * setting.noise,
            torque_stddev=0.005 * setting.noise,
        ),
        joints=JointInput(position_stddev=1e-4 * setting.noise),
    )
    tree = {
        "lead_in": LEAD_IN,
        "holder": {
            "stiffness": setting.stiffness,
            "rotational_stiffness": setting.rotational_stiffness,
            "force_limit": 1500.0,
            "torque_limit": 60.0,
        },
        "start": start,
        "phases": phases,
    }
    return plan_from_tree(configuration, tree)
