"""
Follow in simulation what is said beside an alarm, in the drawn cells of `plans.py`, and time it.

    python -m benchmarks.ways_on [--cells 100] [--seed 1]

The peg closes without turning, and is asked for a way on 0.2 s before that fails. What is said is
then done, with the friction and clearance that hold.
"""

import argparse
from collections import Counter
from dataclasses import replace
from time import perf_counter

import numpy as np

from benchmarks.plans import Came, _Chatter, cell_of, foreseen, simulated
from peg_on_hole_ros.mechanics.planning.motion import motion_of
from peg_on_hole_ros.mechanics.planning.way_on import way_on

# Before the failure that is foreseen [s].
AHEAD = 0.2


def asked(number: int, seed: int):
    """Return a cell, where it is asked, and at which rates; None where plain closing does."""
    drawn = cell_of(number, seed)
    scene, cell = drawn.true, drawn.cell
    rate = cell.max_closing_rate
    plain = motion_of(
        cell.start_tilt, (0, 0, 0), [((-rate, 0, 0), scene.gamma0)], scene.gamma0,
        cell.max_acceleration,
    )  # fmt: skip
    said, tilt = foreseen(drawn, plain)
    if said == "through":
        return None
    # Before that the peg is not closing yet.
    return drawn, min(tilt + AHEAD * rate, cell.start_tilt - 0.02), rate


def came_of(drawn, found, tilt, rate) -> Came:
    """Return what comes of closing to a tilt, and then doing what is said."""
    cell, end = drawn.cell, drawn.true.gamma0
    legs = [((-rate, 0, 0), tilt), (found.motion.stages[-1].rates, end)]
    motion = motion_of(cell.start_tilt, (0, 0, 0), legs, end, cell.max_acceleration)
    # The simulated peg is pushed with the share from the begin.
    pushed = replace(cell, press=tuple(found.share * x for x in cell.press))
    try:
        return simulated(drawn._replace(cell=pushed), motion)
    except _Chatter:
        return Came("chatters", np.nan, np.full(3, np.inf))


def main(arguments=None):
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--cells", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    times, counts = {1: [], 3: []}, Counter()
    for number in range(options.cells):
        given = asked(number, options.seed)
        if given is None:
            counts["plain closing does"] += 1
            continue
        drawn, tilt, rate = given
        state = drawn.max_normal, tilt, (-rate, 0.0, 0.0)
        for clearances in (1, 3):
            stddev = drawn.scene.clearance_stddev if clearances == 3 else 0.0
            scene = replace(drawn.scene, clearance_stddev=stddev)
            begin = perf_counter()
            found = way_on(scene, drawn.cell, *state)
            times[clearances].append(perf_counter() - begin)
        kind = "another turn" if found.share == 1 else "less push"
        kind = "as it is" if found.goes_on else kind
        if not found.possible:
            counts["none: lift"] += 1
            continue
        counts[kind] += 1
        came = came_of(drawn, found, tilt, rate)
        kept = came.outcome == "through"
        counts[f"{kind}: limits kept"] += kept
        counts[f"{kind}: load as said"] += kept and came.peak[found.contact] < found.load
    for name, count in sorted(counts.items()):
        print(f"{name:28} {count}")
    for clearances, taken in times.items():
        known = "known" if clearances == 1 else "uncertain"
        ms = 1e3 * np.quantile(taken, (0.5, 0.95, 1))
        print(f"clearance {known}: {ms[0]:.0f} ms, 95 % {ms[1]:.0f} ms, longest {ms[2]:.0f} ms")


if __name__ == "__main__":
    main()
