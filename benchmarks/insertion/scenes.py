"""
Drawn insertions down the hole: normal ones, pegs that jam, that wedge, and that are freed.

    python -m benchmarks.insertion.scenes [--scenes 300] [--set scoring] [--jobs 1]

prints what happened in each family. A program that scores a monitor takes `cases`, `plan_of` and
`insertion_labels.labels_of`. Scenes of the set `tuning` are others than those of `scoring`; a case
gives the same plan every time. Whether a peg is stuck, and why, is read off the truth, never off
the family.
"""

import argparse
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

from benchmarks.insertion.families import FAMILY, LEAD_IN
from benchmarks.insertion.labels import labels_of
from benchmarks.scenes.setting import Draw
from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.sim.plan import Plan, plan_from_tree
from peg_on_hole_ros.sim.truth import integrate

FAMILIES = tuple(FAMILY)
SEEDS = {"scoring": 8_200, "tuning": 4_700}
# Of 300.
SHARES = {"normal": 100, "jammed": 70, "wedged": 50, "freed": 80}


class Case(NamedTuple):
    """One scene: its family, its number in it, and whether it is for tuning or for scoring."""

    family: str
    number: int
    set: str = "scoring"

    def __str__(self):
        """Return a name for files and tables."""
        return f"{self.family}_{self.number:03d}_{self.set}"

    @property
    def seed(self) -> list[int]:
        """Return what the draw, and with one more number the noise, is seeded with."""
        return [SEEDS[self.set], FAMILIES.index(self.family), self.number]


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


def summary_of(case: Case) -> dict:
    """Return what happened in a case, for the table."""
    begin = time.perf_counter()
    truth = integrate(plan_of(case))
    spent = time.perf_counter() - begin
    labels = labels_of(truth)
    return {
        "case": str(case),
        "family": case.family,
        "causes": tuple(event.cause for event in labels.events),
        "freed": any(event.freed for event in labels.events),
        "ended_by": truth.ended_by,
        "depth": float(truth.place[-1, 2] / truth.plan.configuration.scene.hole_diameter),
        "spent": spent,
        "seconds": float(truth.t_ns[-1] * 1e-9),
        "modes": dict(Counter(labels.mode.tolist())),
        "max_normal": float(truth.normal.max()),
    }


def main(arguments=None):
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--scenes", type=int, default=300)
    parser.add_argument("--set", choices=tuple(SEEDS), default="scoring")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--each", action="store_true", help="a line for each scene")
    options = parser.parse_args(arguments)
    chosen = cases(options.scenes, options.set)
    # The first compiles; the others load what it compiled.
    found = [summary_of(chosen[0])]
    with ProcessPoolExecutor(options.jobs) as pool:
        for row in pool.map(summary_of, chosen[1:]):
            found.append(row)
            if options.each:
                print(row, flush=True)
    print("family    scenes  jammed  wedged   freed   depth/D      modes, share of samples; time")
    for family in FAMILIES:
        rows = [row for row in found if row["family"] == family]
        with_cause = [
            sum(cause in row["causes"] for row in rows) for cause in ("jammed", "wedged")
        ]
        depths = sorted(row["depth"] for row in rows)
        modes = sum((Counter(row["modes"]) for row in rows), Counter())
        total = modes.total()
        shown = ", ".join(f"{k} {v / total:.0%}" for k, v in modes.most_common())
        spent = sorted(row["spent"] for row in rows)
        print(
            f"{family:9} {len(rows):6} {with_cause[0]:7} {with_cause[1]:7} "
            f"{sum(row['freed'] for row in rows):7}  "
            f"{depths[0]:.2f} to {depths[-1]:.2f}  {shown}; "
            f"{spent[len(spent) // 2]:.2f} s, at most {spent[-1]:.2f} s"
        )


if __name__ == "__main__":
    main()
