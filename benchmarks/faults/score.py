"""What a fault did to what is said, against the truth and the recording as it was."""

from typing import NamedTuple

import numpy as np

from benchmarks.faults.play import Said
from benchmarks.faults.scenes import Scene
from peg_on_hole_ros.bags.truth import BOUND_STDDEVS, THREE_POINT, TWO_POINT

# A flag may come so much before the transition, and has to be there so long after it [s].
EARLY, LATE = 0.02, 0.05
# What has recovered says for so long [s], in this share of the samples, what the clean one does.
SETTLED, AGREES = 0.1, 0.95
# Fewer samples tell no share.
FEW = 50
ERROR = 2


class Score(NamedTuple):
    """
    Figures of a faulted recording.

    Attributes
    ----------
    angles, reactions : float
        Least share, over the three, of errors within 95 % bounds while the fault lasts, from when
        it has to be told; NaN where too little was said that counts. Angles count but in mode
        `unknown`, reactions where they are declared determined. Both count only where the
        diagnostics of the filter have no doubt.
    angles_after, reactions_after : float
        After the fault, likewise.
    clean : dict of str to float
        The four shares of the same samples of the recording as it was.
    gamma, gamma_after : float
        Largest error of gamma that counts [rad].
    recovered : float
        After the end of the fault [s]; infinite: never; NaN: it has no end.
    flag : int
        Samples with a wrong transition flag and no word of doubt: neither mode `unknown` nor
        a status ERROR.
    jam : int
        Samples in which a peg that jams is not told as such, likewise.
    false_jam : int
        Samples with a jamming ERROR where nothing jams, likewise.
    told : dict of str to float
        Lines that the clean recording has not, and when they came after the begin of the fault.
    level : int
        Worst of the diagnostics after its begin.
    counts : dict of str to int
        By how much they are higher than in the clean recording.
    lost : int
        Messages without a fate, or with two.
    answers : list of str
        Of calls.

    """

    angles: float
    reactions: float
    angles_after: float
    reactions_after: float
    clean: dict
    gamma: float
    gamma_after: float
    recovered: float
    flag: int
    jam: int
    false_jam: int
    told: dict
    level: int
    counts: dict
    lost: int
    answers: list


def score(scene: Scene, clean: Said, said: Said, begin: float, end: float, within: float) -> Score:
    """
    Return the figures of what is said of a recording with a fault.

    Parameters
    ----------
    scene : Scene
    clean, said : Said
        Of the recording as it was, and with the fault.
    begin, end : float
        Where the fault is [s].
    within : float
        How long after its begin it has to be told [s].

    """
    error, _, seconds = errors_of(scene, said)
    during, after = _judged(scene, said, begin + within, end)
    off = np.abs(error[:, 0])
    return Score(
        **_shares(scene, said, begin + within, end),
        clean=_shares(scene, clean, begin + within, end),
        gamma=float(off[during[:, 0]].max(initial=0.0)),
        gamma_after=float(off[after[:, 0]].max(initial=0.0)),
        recovered=_recovered(clean, said, error, seconds, end),
        flag=int(wrong_flags(scene, said).sum()),
        jam=int(untold_jams(scene, said).sum()),
        false_jam=int(false_jams(scene, said).sum()),
        told={
            line: max(t - begin, 0.0) for line, t in said.told.items() if line not in clean.told
        },
        level=max((level for t, level in said.worst if t >= begin), default=0),
        counts={
            name: count - clean.counts.get(name, 0)
            for name, count in said.counts.items()
            if count > clean.counts.get(name, 0)
        },
        lost=_lost(said),
        answers=said.answers,
    )


def errors_of(scene: Scene, said) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Return errors of angles and reactions, the true mode, and when that was [s].

    `said` has its fields of Said.

    """
    at = np.clip(np.searchsorted(scene.t_ns, said.true_ns), 0, len(scene.t_ns) - 1)
    error = said.values - scene.values[at]
    error[:, :3] -= 2.0 * np.pi * np.round(error[:, :3] / (2.0 * np.pi))
    return error, scene.mode[at], (said.true_ns - scene.recording[0].true_ns) * 1e-9


def _judged(scene, said, begin, end):
    """Return which values are said to be known without a doubt, from begin to end and after."""
    error, mode, seconds = errors_of(scene, said)
    known = (said.mode != "unknown") & (said.doubt == 0)
    three = known & said.determined & (said.mode == THREE_POINT) & (mode == THREE_POINT)
    counted = np.column_stack([known] * 3 + [three] * 3) & ~np.isnan(error)
    during = counted & ((seconds >= begin) & (seconds < end))[:, None]
    return during, counted & (seconds >= end + SETTLED)[:, None]


def _shares(scene, said, begin, end):
    """Return the least shares within bounds of angles and reactions, in both."""
    error = errors_of(scene, said)[0]
    inside, found = np.abs(error) <= BOUND_STDDEVS * said.stddev, {}
    for which, suffix in zip(_judged(scene, said, begin, end), ("", "_after")):
        numbers, good = which.sum(axis=0), (which & inside).sum(axis=0)
        for name, three in (("angles", slice(3)), ("reactions", slice(3, 6))):
            shares = [n / of for n, of in zip(good[three], numbers[three]) if of >= FEW]
            found[name + suffix] = float(min(shares, default=np.nan))
    return found


def _recovered(clean, said, error, seconds, end):
    if not (seconds >= end).any():
        return np.nan
    before = dict(zip(clean.true_ns.tolist(), clean.mode.tolist()))
    same = np.array([before.get(t) == m for t, m in zip(said.true_ns.tolist(), said.mode)])
    fits = same & (np.abs(error[:, 0]) < 4.0 * said.stddev[:, 0])
    for k in np.flatnonzero(seconds >= end):
        there = fits[k:][seconds[k:] < seconds[k] + SETTLED]
        if fits[k] and there.mean() >= AGREES:
            return float(seconds[k] - end)
    return np.inf


def _silent(said):
    return (said.mode != "unknown") & (said.level < ERROR)


def wrong_flags(scene: Scene, said) -> np.ndarray:
    """Return where a flag is wrong and nothing doubts it; `said` has its fields of Said."""
    if scene.crossed_ns is None:
        return _silent(said) & said.flag
    at = np.clip(np.searchsorted(scene.t_ns, said.true_ns), 0, len(scene.t_ns) - 1)
    ahead = (scene.crossed_ns - said.true_ns) * 1e-9
    missed = ~said.flag & (ahead < -LATE) & (scene.mode[at] == TWO_POINT)
    return _silent(said) & ((said.flag & (ahead > EARLY)) | missed)


def untold_jams(scene: Scene, said) -> np.ndarray:
    """Return where the peg jams, nothing says so and nothing doubts what is said."""
    if scene.jams_ns is None:
        return np.zeros(len(said.flag), bool)
    return _silent(said) & (said.jamming < ERROR) & (said.true_ns >= scene.jams_ns)


def false_jams(scene: Scene, said) -> np.ndarray:
    """Return where an ERROR of jamming stands though nothing jams, and nothing doubts it."""
    if scene.jams_ns is not None:
        return np.zeros(len(said.flag), bool)
    return _silent(said) & (said.jamming == ERROR)


def _lost(said):
    fates = dict.fromkeys(said.sent, 0)
    for name, count in said.counts.items():
        if "_dropped_" in name or name in ("wrench_used", "joints_used", "joints_gated"):
            fates[name.partition("_")[0]] += count
    return sum(abs(said.sent[source] - fates[source]) for source in fates)
