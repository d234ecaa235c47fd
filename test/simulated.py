"""Truths that several tests look at, each integrated once a run."""

import os
import pickle
from dataclasses import replace
from functools import cache
from pathlib import Path

from peg_on_hole_ros.cli.simulation_file import read_plan
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate

ROOT = Path(__file__).parents[1]
SAMPLES = ("closing_without_slip", "closing_with_slip", "working_cycle")


@cache
def plan(name):
    return read_plan(ROOT / "config" / f"{name}.yaml")


@cache
def truth(name, **changes):
    if changes:
        return integrate(replace(plan(name), **changes))
    # The workers of a run share it: the working cycle takes as long as a hundred other tests.
    shared = Path(os.environ["PEG_ON_HOLE_TEST_RUN"]) / f"{name}.pickle"
    if not shared.exists():
        own = shared.with_suffix(f".{os.getpid()}")
        own.write_bytes(pickle.dumps(integrate(plan(name))))
        own.replace(shared)
    return pickle.loads(shared.read_bytes())


def contact_plan(start, rates, offset, duration=0.05, configuration=None, phases=None, **more):
    """A plan that begins on three contacts; `phases` replaces the single one."""
    tree = {
        "lead_in": 0.02,
        "start": {"angles": start, "rates": rates, "offset": offset},
        "phases": phases or {"move": {"kind": "contact", "duration": duration, "rates": rates}},
        **more,
    }
    return plan_from_tree(configuration or Configuration(), tree)
