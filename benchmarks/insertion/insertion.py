"""
The monitor over drawn insertions: pegs that are stuck, alarms that are false, modes, estimates.

Friction is stated FACTORS times the true one, scene by scene in turn; the rest is stated as it is.
Thresholds are chosen on the set `tuning`. An alarm is right where the peg is slower than RESTS
under a push of more than PUSHED within NEAR of its begin.
"""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.tables import percent, table
from benchmarks.harness.truths import play, truth_of
from benchmarks.insertion import estimates, families, labels, scenes
from benchmarks.insertion.estimates import SLIDES, estimates_of, said
from benchmarks.insertion.labels import friction_of, labels_of
from benchmarks.insertion.scenes import SEEDS, cases, plan_of

FACTORS = (0.5, 0.75, 1.0, 1.25, 1.5)
LEVELS = {"WARN": 1, "ERROR": 2}
# A stop that lasts is to be told within [s], [s].
LASTS, WITHIN = 0.1, 0.1
# A peg that is pushed, `monitor.contact_force_threshold` [N], and rests along the hole [m/s].
PUSHED, RESTS = 1.0, 5e-4
# Before and after the begin of an alarm [s].
NEAR = (0.1, 0.2)
# Modes are scored farther than this from a change of the true one [s].
CHANGES = 0.02


def score_member(insertion: Member, folder: Path) -> dict:
    """
    Return what became of one scene.

    Returns
    -------
    dict
        `causes`, `freed`, `depth`: what truly happened, depth over the hole's diameter. `stops`:
        for each stop that lasts, whether each level was there within WITHIN. `alarms`: for each
        begin of a level after the transition, whether it was right. `modes`: samples by true and
        declared mode. `alone`: samples told `two_point` by true mode, and how many of them are
        likelier to be one point alone. `flag`: after the transition [s]; None: there was none,
        infinite: it did not come. `estimates`: of `Estimates.summary`.

    """
    case, factor = insertion.of
    truth, why = truth_of(plan_of(case), folder / "truths")
    if truth is None:
        raise RuntimeError(f"{case}: {why}")
    told = truth.plan.configuration
    friction = factor * told.scene.friction
    told = replace(told, scene=replace(told.scene, friction=friction))
    record = play(truth, told, [[*case.seed, 1]])
    labels = labels_of(truth)
    t, level = labels.t, record.alarms["jamming"]
    rests = (np.abs(truth.place_rate[:, 2]) < RESTS) & (labels.push > PUSHED)
    rests &= truth.closed.any(axis=1)
    far = record.mode != ""
    for k in np.flatnonzero(labels.mode[1:] != labels.mode[:-1]):
        far &= np.abs(t - t[k]) > CHANGES
    slides = far & (labels.mode == "two_point") & (np.abs(truth.place_rate[:, 2]) > SLIDES)
    normal = np.column_stack([truth.normal[:, 0], truth.normal[:, 1:].sum(axis=1)])
    found = estimates_of(record, t, slides, normal, friction_of(truth))
    flag = None
    if labels.transition is not None:
        flag = float(t[record.flag].min(initial=np.inf)) - labels.transition
    return {
        "causes": [event.cause for event in labels.events],
        "freed": any(event.freed for event in labels.events),
        "depth": float(truth.place[-1, 2] / told.scene.hole_diameter),
        "stops": _stops(labels, level),
        "alarms": {name: _alarms(labels, level >= least, rests) for name, least in LEVELS.items()},
        "modes": _modes(labels, record, far),
        "alone": _alone(labels, record, far),
        "flag": flag,
        "estimates": found.summary(),
    }


def _stops(labels, level) -> list[dict[str, bool]]:
    found = []
    for event in labels.events:
        if event.end - event.begin >= LASTS:
            soon = (labels.t >= event.begin) & (labels.t <= event.begin + WITHIN)
            found.append({name: bool(level[soon].max() >= at) for name, at in LEVELS.items()})
    return found


def _alarms(labels, raised, rests) -> list[bool]:
    found, t = [], labels.t
    for k in np.flatnonzero(raised[1:] & ~raised[:-1]) + 1:
        if labels.transition is not None and t[k] >= labels.transition:
            near = (t >= t[k] - NEAR[0]) & (t <= t[k] + NEAR[1])
            found.append(bool(rests[near].any()))
    return found


def _modes(labels, record, far) -> dict[str, dict[str, int]]:
    return {
        true: dict(Counter(record.mode[far & (labels.mode == true)].tolist()))
        for true in np.unique(labels.mode[far]).tolist()
    }


def _alone(labels, record, far) -> dict[str, list[int]]:
    below = record.monitor["mode_probability_two_point"]
    alone = record.monitor["mode_probability_K_alone"] + record.monitor["mode_probability_B_alone"]
    told = far & (record.mode == "two_point") & np.isfinite(alone)
    of = {true: told & (labels.mode == true) for true in np.unique(labels.mode[told]).tolist()}
    return {true: [int(n.sum()), int((2 * alone > below)[n].sum())] for true, n in of.items()}


def members(options) -> list[Member]:
    """Return the scenes asked for, with how many times the true friction is stated in each."""
    chosen = cases(options.scenes, options.set)
    pairs = [(case, FACTORS[i % len(FACTORS)]) for i, case in enumerate(chosen)]
    return [Member(f"{case}_{factor:g}", (case, factor)) for case, factor in pairs]


def report(found, options) -> Report:
    """Return what happened in each family, and what was said of it."""
    trees = [tree for _, tree in found]
    parts = [_happened(found), _alarm_table(found), _mode_table(trees), _alone_table(trees)]
    lines = [_flags(trees), said([tree["estimates"] for tree in trees])]
    return Report("\n\n".join([*parts, "\n".join(lines)]))


def _happened(found):
    of: dict[str, list[dict]] = {}
    for insertion, tree in found:
        of.setdefault(insertion.of[0].family, []).append(tree)
    rows = []
    for family, trees in of.items():
        causes = (sum(cause in t["causes"] for t in trees) for cause in ("jammed", "wedged"))
        depths = [tree["depth"] for tree in trees]
        deep = f"{min(depths):.2f} to {max(depths):.2f}"
        rows.append((family, len(trees), *causes, sum(t["freed"] for t in trees), deep))
    return table(("family", "scenes", "jammed", "wedged", "freed", "depth/D"), rows)


def _alarm_table(found):
    stops = [stop for _, tree in found for stop in tree["stops"]]
    normal = [tree for insertion, tree in found if insertion.of[0].family == "normal"]
    rows = []
    for name in LEVELS:
        right = [good for _, tree in found for good in tree["alarms"][name]]
        false = sum(not all(tree["alarms"][name]) for tree in normal)
        soon = sum(stop[name] for stop in stops)
        rows.append(
            (
                name, f"{soon} of {len(stops)}", f"{sum(right)} of {len(right)}",
                f"{false} of {len(normal)}",
            )
        )  # fmt: skip
    head = "stops that last", f"told within {WITHIN:g} s", "alarms that are right"
    return table((*head, "normal insertions with a false one"), rows)


def _mode_table(trees):
    of: dict[str, Counter] = {}
    for tree in trees:
        for true, row in tree["modes"].items():
            of.setdefault(true, Counter()).update(row)
    declared = sorted({mode for row in of.values() for mode in row})
    rows = [
        (true, row.total(), *(percent(row[mode] / row.total(), 1) for mode in declared))
        for true, row in sorted(of.items())
    ]
    total = sum(row.total() for row in of.values())
    right = sum(row[true] for true, row in of.items())
    text = table(("true mode", "samples", *declared), rows)
    return f"{text}\n\nMode right: {percent(right / total, 1)} of {total} samples."


def _alone_table(trees):
    of: dict[str, np.ndarray] = {}
    for tree in trees:
        for true, counts in tree["alone"].items():
            of[true] = of.get(true, 0) + np.array(counts)
    rows = [(true, n, percent(alone / n, 1)) for true, (n, alone) in sorted(of.items())]
    return table(("told `two_point`, truly", "samples", "one alone"), rows)


def _flags(trees):
    flags = np.array([tree["flag"] for tree in trees if tree["flag"] is not None])
    off = np.abs(flags[np.isfinite(flags)])
    return (
        f"flag: median {1e3 * np.median(off):.1f} ms off, 95 % {1e3 * np.quantile(off, 0.95):.1f} "
        f"ms, missed {np.isinf(flags).sum()} of {len(flags)}"
    )


def add_options(parser) -> None:
    """Add which scenes."""
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--set", choices=tuple(SEEDS), default="scoring")


FAMILY = Family(
    members, score_member, report, add_options,
    sources=(estimates, families, labels, scenes),
)  # fmt: skip
