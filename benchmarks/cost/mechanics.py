"""
Time the mechanics: one solution in the kernel, and its ratio to the numpy model.

    python -m benchmarks.cost.mechanics [COUNT]

Prints a table; the best of five runs each, on one core.
"""

import sys
from time import perf_counter

import numpy as np
from numba import njit

from benchmarks.cost.turns import in_turns
from peg_on_hole_ros.mechanics import kernel, reference
from peg_on_hole_ros.mechanics.scene import Scene, scene_scalars

SCENE = Scene()
AIM_ONE = 1.5e-6
TURNS = 5


@njit
def repeat(p, scales, states, work, y):
    """Solve all states one after the other; what a filter's inner loop pays."""
    total = 0.0
    for k in range(states.shape[0]):
        row = states[k]
        total += kernel.accelerate(p, scales, row[:6], row[6:], work, y)
    return total


def main(count=1_000_000):
    """Measure and print."""
    rng = np.random.default_rng(0)
    q = np.array([rng.uniform(0.08, 1.2, count), *rng.uniform(-3, 3, (2, count))])
    rates = rng.uniform(-2, 2, (3, count))
    wrench = rng.uniform(-5, 5, (6, count))
    states = np.vstack([q, rates, wrench]).T.copy()
    p, work, y = scene_scalars(SCENE), kernel.workspace(), np.zeros(6)
    scales = np.full(3, 5e-5)
    repeat(p, scales, states[:2], work, y)

    def numpy_one():
        for k in range(min(count, 200)):
            A, r = reference.six_equations(SCENE, q[:, k], rates[:, k], wrench[:, k], 5e-5)
            np.linalg.solve(A, r)

    part = min(count, 50_000)

    def numpy_array():
        A, r = reference.six_equations(SCENE, q[:, :part], rates[:, :part], wrench[:, :part], 5e-5)
        np.linalg.solve(np.moveaxis(A, -1, 0), r.T[..., None])

    ways = {"kernel": lambda: repeat(p, scales, states, work, y)}
    ways |= {"one": numpy_one, "array": numpy_array}
    turns = in_turns(ways, TURNS, perf_counter)
    one, array = turns.least("kernel") / count, turns.least("array") / part
    single = turns.least("one") / min(count, 200)
    print(f"one solution, kernel              {one * 1e6:8.3f} us   aim {AIM_ONE * 1e6:g} us")
    print(f"one solution, numpy model         {single * 1e6:8.1f} us   ratio {single / one:.0f}")
    print(f"one of an array, numpy model      {array * 1e6:8.2f} us   ratio {array / one:.1f}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
