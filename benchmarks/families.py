"""The families that there are, by name: each states its members, their scores and its tables."""

import importlib
from types import ModuleType

# What a family needs (another engine, DDS) is loaded with it.
FAMILIES = {
    "grid": "benchmarks.grid.grid",
    "wrong_settings": "benchmarks.grid.wrong_settings",
    "own_cells": "benchmarks.own_cells.own_cells",
    "searches": "benchmarks.own_cells.searches",
    "landings": "benchmarks.own_cells.landings",
    "friction_drift": "benchmarks.grid.friction_drift",
    "friction_steps": "benchmarks.grid.friction_steps",
    "offsets_learnt": "benchmarks.grid.offsets_learnt",
    "other_pegs": "benchmarks.grid.other_pegs",
    "friction_found": "benchmarks.grid.friction_found",
    "accuracies": "benchmarks.grid.accuracies",
    "consistency": "benchmarks.grid.consistency",
    "scenes": "benchmarks.scenes.scenes",
    "faults": "benchmarks.faults.faults",
    "engine": "benchmarks.engines.engine",
    "insertion": "benchmarks.insertion.insertion",
    "insertion_engine": "benchmarks.insertion.engine",
    "insertion_estimates": "benchmarks.insertion.estimates",
    "gate": "benchmarks.engines.gate",
    "robot_cells": "benchmarks.robot_cells.drawn",
    "loop": "benchmarks.loop.loop",
    "wedge_stiffness": "benchmarks.engines.wedge_stiffness",
    "ablation": "benchmarks.ablation",
    "rivals": "benchmarks.rivals",
    "calibration": "benchmarks.calibration",
    "tuned_numbers": "benchmarks.tuned_numbers.tuned_numbers",
    "plans": "benchmarks.plans",
    "ways_on": "benchmarks.ways_on",
    "choices": "benchmarks.choices",
}


def module_of(name: str) -> ModuleType:
    """Return the module of a family."""
    return importlib.import_module(FAMILIES[name])


def family_of(name: str):
    """Return the family of a name."""
    return module_of(name).FAMILY
