"""
Score the monitor over drawn insertions: pegs that are stuck, alarms that are false, modes.

    python -m benchmarks.insertion.monitor [--scenes 100] [--set scoring] [--each]

Friction is stated FACTORS times the true one, scene by scene in turn; the rest is stated as it is.
Thresholds are chosen on the set `tuning`. An alarm is right where the peg is slower than RESTS
under a push of more than PUSHED within NEAR of its begin.
"""

import argparse
from collections import Counter
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from benchmarks.insertion.estimates import SLIDES, Estimates, estimates_of, said
from benchmarks.insertion.labels import friction_of, labels_of
from benchmarks.insertion.scenes import SEEDS, Case, cases, plan_of
from benchmarks.scenes.play import play, truth_of

FACTORS = (0.5, 0.75, 1.0, 1.25, 1.5)
LEVELS = {"WARN": 1, "ERROR": 2}
# A stop that lasts is to be told within [s], [s].
LASTS, WITHIN = 0.1, 0.1
# `monitor.contact_force_threshold` [N] and `monitor.rest_speed` [m/s].
PUSHED, RESTS = 1.0, 5e-4
# Before and after the begin of an alarm [s].
NEAR = (0.1, 0.2)
# Modes are scored farther than this from a change of the true one [s].
CHANGES = 0.02


class Score(NamedTuple):
    """
    What became of one scene.

    Attributes
    ----------
    case : Case
    told : list of dict of str to bool
        For each stop that lasts: whether each level was there within WITHIN.
    alarms : dict of str to list of bool
        For each begin of a level after the transition: whether it was right.
    modes : Counter
        Samples by true and declared mode.
    alone : Counter
        Samples told `two_point` by true mode, and by whether one point is likelier to be alone.
    flag : float
        After the transition [s]; NaN: there was none; infinite: it did not come.
    estimates : Estimates

    """

    case: Case
    told: list[dict[str, bool]]
    alarms: dict[str, list[bool]]
    modes: Counter
    alone: Counter
    flag: float
    estimates: Estimates


def score_of(case: Case, factor: float) -> Score:
    """Return the score of a scene with friction stated so many times the true one."""
    truth, why = truth_of(plan_of(case))
    if truth is None:
        raise RuntimeError(f"{case}: {why}")
    told = truth.plan.configuration
    told = replace(told, scene=replace(told.scene, friction=factor * told.scene.friction))
    record = play(truth, told, [[*case.seed, 1]])
    labels = labels_of(truth)
    t, level = labels.t, record.alarms["jamming"]
    stops = []
    for event in labels.events:
        if event.end - event.begin >= LASTS:
            soon = level[(t >= event.begin) & (t <= event.begin + WITHIN)].max()
            stops.append({name: bool(soon >= least) for name, least in LEVELS.items()})
    rests = (np.abs(truth.place_rate[:, 2]) < RESTS) & (labels.push > PUSHED)
    rests &= truth.closed.any(axis=1)
    alarms: dict[str, list[bool]] = {name: [] for name in LEVELS}
    for name, least in LEVELS.items():
        for k in np.flatnonzero((level[1:] >= least) & (level[:-1] < least)) + 1:
            if labels.transition is not None and t[k] >= labels.transition:
                near = (t >= t[k] - NEAR[0]) & (t <= t[k] + NEAR[1])
                alarms[name].append(bool(rests[near].any()))
    far = record.mode != ""
    for k in np.flatnonzero(labels.mode[1:] != labels.mode[:-1]):
        far &= np.abs(t - t[k]) > CHANGES
    pairs = zip(labels.mode[far].tolist(), record.mode[far].tolist(), strict=True)
    below = record.monitor["mode_probability_two_point"]
    alone = record.monitor["mode_probability_K_alone"] + record.monitor["mode_probability_B_alone"]
    told_two = far & (record.mode == "two_point") & np.isfinite(alone)
    which = zip(
        labels.mode[told_two].tolist(), (2 * alone > below)[told_two].tolist(), strict=True
    )
    slides = far & (labels.mode == "two_point") & (np.abs(truth.place_rate[:, 2]) > SLIDES)
    normal = np.column_stack([truth.normal[:, 0], truth.normal[:, 1:].sum(axis=1)])
    found = estimates_of(record, t, slides, normal, friction_of(truth))
    flag = np.nan
    if labels.transition is not None:
        flag = float(t[record.flag].min(initial=np.inf)) - labels.transition
    return Score(case, stops, alarms, Counter(pairs), Counter(which), flag, found)


def main(arguments=None):
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--set", choices=tuple(SEEDS), default="scoring")
    parser.add_argument("--each", action="store_true", help="a line for each scene")
    options = parser.parse_args(arguments)
    found = []
    for i, case in enumerate(cases(options.scenes, options.set)):
        found.append(score_of(case, FACTORS[i % len(FACTORS)]))
        if options.each:
            print(found[-1][:3], flush=True)
    stops = [stop for row in found for stop in row.told]
    normal = [row for row in found if row.case.family == "normal"]
    print(f"{len(found)} scenes, {len(stops)} stops that last")
    for name in LEVELS:
        soon = sum(stop[name] for stop in stops)
        right = [good for row in found for good in row.alarms[name]]
        false = sum(not all(row.alarms[name]) for row in normal)
        print(
            f"{name:5} within {WITHIN:g} s: {soon} of {len(stops)}; right: {sum(right)} of "
            f"{len(right)}; normal insertions with a false one: {false} of {len(normal)}"
        )
    modes = sum((row.modes for row in found), Counter())
    for true in sorted({pair[0] for pair in modes}):
        row = {told: n for (mode, told), n in modes.items() if mode == true}
        shares = ", ".join(f"{k} {v / sum(row.values()):.1%}" for k, v in sorted(row.items()))
        print(f"{true:11} {sum(row.values()):7} samples: {shares}")
    right = sum(n for (true, told), n in modes.items() if true == told)
    print(f"mode right: {right / modes.total():.1%} of {modes.total()} samples")
    alone = sum((row.alone for row in found), Counter())
    for true in sorted({pair[0] for pair in alone}):
        total = alone[true, True] + alone[true, False]
        print(f"{true:11} {total:7} told two_point: one alone {alone[true, True] / total:.1%}")
    flags = np.array([row.flag for row in found])
    off = np.abs(flags[np.isfinite(flags)])
    print(
        f"flag: median {1e3 * np.median(off):.1f} ms off, 95 % {1e3 * np.quantile(off, 0.95):.1f} "
        f"ms, missed {np.isinf(flags).sum()} of {np.isfinite(flags).sum() + np.isinf(flags).sum()}"
    )
    print(said([row.estimates for row in found]))


if __name__ == "__main__":
    main()
