"""
A friction that is stated a half and one and a half of what it is, beside another checkout.

Motions of `wrong_settings`. When friction comes within 5 % to stay, over the other checkout's time
(a run that never does counts as its duration), and the share of the runs in which it is off by
more than four of its deviations at any time after 50 ms.
"""

from itertools import product
from pathlib import Path

import numpy as np

from benchmarks.grid import cells, misstated, wrong_settings
from benchmarks.grid.cells import truth_of, with_noise
from benchmarks.grid.misstated import with_scene
from benchmarks.grid.wrong_settings import FRICTION, LEARNT, STATED
from benchmarks.harness.errors import SETTLE_NS, changed_parameters
from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.player import player_of
from benchmarks.harness.tables import percent, table
from peg_on_hole_ros.sim.measure import START_NS, measure

FIRST_SEED = 650_000
NEAR, SURE = 0.05, 4.0


def found_at(truth, told, seed, player):
    """Return when friction is near to stay [s], and whether it was surely wrong after 50 ms."""
    right = truth.plan.configuration.scene.friction
    parameters = changed_parameters(told.plan.configuration)
    record = player(parameters, list(map(tuple, measure(truth, seed))), START_NS + SETTLE_NS)
    off, t = np.abs(record.monitor["friction"] - right), (record.t_ns - START_NS) * 1e-9
    far = np.flatnonzero(~(off <= NEAR * right))
    begun = t >= SETTLE_NS * 1e-9
    first = t[0] if not far.size else t[min(far[-1] + 1, len(t) - 1)]
    wrong = off > SURE * record.monitor["friction_stddev"]
    return float(first), bool(wrong[begun].any())


def score_member(case: Member, folder: Path) -> list:
    """Return the time and whether it was surely wrong, of each start and seed."""
    truth = with_noise(truth_of(case.of)[0], "nominal", LEARNT)
    right, rows = truth.plan.configuration.scene.friction, []
    for start, seed in product(STATED, range(FIRST_SEED, FIRST_SEED + case.seeds)):
        # The truth is within two stated deviations.
        told = with_scene(truth, friction=start * right, friction_stddev=max(LEARNT, 0.25 * right))
        rows.append(found_at(truth, told, seed, player_of(case.checkout)))
    return rows


def report(found, options) -> Report:
    """Return the table, beside another checkout where there is one."""
    runs = [
        np.array([row for case, rows in found if bool(case.checkout) == other for row in rows]).T
        for other in (False, True)
    ]
    runs = [each for each in runs if each.size]
    blank = [""] * (2 - len(runs))
    times = [f"{np.median(t):.3f}" for t, _ in runs]
    sure = [percent(wrong.mean(), 1) for _, wrong in runs]
    rows = [("median time until within 5 % [s]", *times, *blank, "")]
    if len(runs) == 2:
        ratio = np.exp(np.mean(np.log(runs[0][0] / runs[1][0])))
        rows.append(("geometric mean of the times' ratio", f"{ratio:.2f}", "1", "1.5"))
    rows.append(("runs off by more than 4 deviations", *sure, *blank, "1 %"))
    return Report(table(("friction a half, one and a half", "this", "other", "limit"), rows))


FAMILY = Family(
    lambda options: [Member(str(motion), motion, options.seeds) for motion in FRICTION],
    score_member, report, seeds=4, sources=(cells, misstated, wrong_settings), against=True,
)  # fmt: skip
