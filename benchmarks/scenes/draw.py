"""Insertion scenes with drawn parameters: what is commanded, what the estimator is told."""

from dataclasses import replace

from benchmarks.harness.draw import Draw, DrawnCase
from benchmarks.scenes.families import FAMILY, LEAD_IN
from peg_on_hole_ros.config.options import Configuration, JointInput, MonitorOptions, WrenchInput
from peg_on_hole_ros.sim.plan import Plan, plan_from_tree

FAMILIES = tuple(FAMILY)
# First of the two numbers that a draw is seeded with: no scene is of both sets.
SEEDS = {"scoring": 7_100, "tuning": 3_900}
FRICTION_OFF = 0.30
CLEARANCE_OFF = 0.20


class Case(DrawnCase):
    """One scene."""

    __slots__ = ()
    SEEDS, FAMILIES = SEEDS, FAMILIES


def plan_of(case: Case) -> Plan:
    """Return what is simulated; the same case gives the same plan."""
    setting, start, phases = FAMILY[case.family](Draw(case.seed))
    s = setting
    configuration = Configuration(
        scene=s.scene,
        wrench=WrenchInput(force_stddev=0.2 * s.noise, torque_stddev=0.005 * s.noise),
        joints=JointInput(position_stddev=1e-4 * s.noise),
        monitor=MonitorOptions(max_normal=(s.max_normal,) * 3),
    )
    tree = {
        "lead_in": LEAD_IN,
        "settle": 0.04,
        "holder": {
            "stiffness": s.stiffness,
            "rotational_stiffness": s.rotational_stiffness,
            "force_limit": 1500.0,
            "torque_limit": 40.0,
        },
        "start": start,
        "phases": phases,
    }
    return plan_from_tree(configuration, tree)


def estimator_of(case: Case, plan: Plan, mismatch: bool) -> Configuration:
    """
    Return what the estimator is told.

    With a mismatch friction is 30 % off, and clearance 20 % with `clearance_stddev` as large:
    up or down, each drawn. `friction_stddev` is the default in both.

    """
    if not mismatch:
        return plan.configuration
    return told_wrongly(plan.configuration, Draw([*case.seed, 2]))


def told_wrongly(configuration: Configuration, draw: Draw) -> Configuration:
    """Return a configuration with friction and clearance off, and a spread of the clearance."""
    scene = configuration.scene
    friction = scene.friction * (1 + draw.sign() * FRICTION_OFF)
    clearance = scene.hole_diameter - scene.peg_diameter
    told = clearance * (1 + draw.sign() * CLEARANCE_OFF)
    scene = replace(
        scene,
        friction=friction,
        peg_diameter=scene.hole_diameter - told,
        clearance_stddev=CLEARANCE_OFF * told,
    )
    return replace(configuration, scene=scene)


def noise_seeds(case: Case, tries: int = 1) -> list[list[int]]:
    """Return the seeds of the sensors' noise in each try; that of the last is always the same."""
    return [[*case.seed, 2 + before] for before in range(1, tries)] + [[*case.seed, 1]]
