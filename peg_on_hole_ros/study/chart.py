"""What is charted: how far off estimators are, and what they cost, for each kind of scene."""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.estimator.methods.registry import METHODS
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.sim.truth import Truth
from peg_on_hole_ros.study.bare_balance import bare_balance
from peg_on_hole_ros.study.cost_floor import cost_along, noted, taken_anew
from peg_on_hole_ros.study.estimators import DEFAULT, ESTIMATORS, Estimator
from peg_on_hole_ros.study.runs import (
    LEAST_COVERED,
    Errors,
    Track,
    always_in_contact,
    errors,
    run,
    thinned,
)
from peg_on_hole_ros.study.scenes import (
    SCENE_KINDS,
    Case,
    Least,
    bound_along,
    least_errors,
    measured,
)

# Samples that an estimator runs over before it is timed: what it needs beyond others is compiled.
WARM = 150
# Of the samples; an estimator that determines less tells nothing.
LEAST_DETERMINED = 0.5
# A slower wrench is one of those that come with an orientation [ns].
JOINT_PERIOD_NS = 2_000_000
# Whose steps are shown along a working cycle, in pieces of so long [s].
CYCLE_METHODS, CYCLE_PIECE = ("mixture", "one_level"), 0.05
# How often the steps of a motion are taken, to tell how far their times spread.
STEP_TURNS = 7


# No estimator: the bound on the errors of all.
BOUND = "bound, 1 kHz"
# Kinds of scene that stand for themselves alone.
OWN_ROWS = ("begins fast", "in the hole")


class ChartScore(NamedTuple):
    """
    One estimator over one motion.

    Attributes
    ----------
    kind, case, name : str
    reactions : float
        Root mean square of the error over the mean reaction, median over seeds; the seeds of a
        slower wrench begin at other samples.
    reactions_low, reactions_high : float
        Least and largest of the seeds.
    tilt_rate : float
        Root mean square of gamma' [rad/s], median over seeds.
    reactions_inside : float
        Least share of a reaction within the stated 95 %, where it is determined.
    determined : float
        Share of samples.
    lost : float
        Share of runs.
    step, step_low, step_high : float
        Computing time of the compiled step for a wrench, with the orientation of its time [us]:
        median and quartiles of STEP_TURNS. Of the bare balance that of the balance in numpy;
        NaN: it has no step.
    whole : float
        Computing time for a millisecond of motion, from messages to outputs [us]: median of the
        ratios to the default in the same turn, times the median of that one. What judging modes
        and alarms costs a wrench is the default's for all. NaN: it takes no messages.

    """

    kind: str
    case: str
    name: str
    reactions: float
    reactions_low: float
    reactions_high: float
    tilt_rate: float
    reactions_inside: float
    determined: float
    lost: float
    step: float
    step_low: float
    step_high: float
    whole: float


def scores(
    chosen: Sequence[Estimator],
    case: Case,
    truth: Truth,
    seeds: Sequence[int],
    clock: Callable[[], float],
) -> list[ChartScore]:
    """
    Return the ChartScore of each estimator over one motion.

    They are told that the peg is on three contacts, so that none is scored for when it believes
    it; in the hole they judge, and those that cannot are NaN. They take turns, so that what slows
    the machine for a while slows all of them.

    Parameters
    ----------
    chosen : sequence of Estimator
        The first is what the others' times are compared with.
    case : Case
    truth : Truth
        With wrenches at 1 kHz.
    seeds : sequence of int
        Of the sensors' noise.
    clock : callable
        Returns a time [s].

    """
    judged = truth.plan.configuration
    configuration = always_in_contact(judged) if case.told else judged
    found: list[list[Errors]] = [[] for _ in chosen]
    spent: list[list[float]] = [[] for _ in chosen]
    bare: list[list[float]] = [[] for _ in chosen]
    steps: list[list[float]] = [[] for _ in chosen]
    duration_ms = (truth.t_ns[-1] - truth.t_ns[0]) * 1e-6
    run(judged, measured(case, truth, 0)[:WARM], clock)
    for turn, seed in enumerate(seeds):
        samples = measured(case, truth, seed)
        whole = run(judged, samples, clock)
        # Of a wrench [s].
        judging = whole.seconds / len(whole.t_ns)
        if turn == 0:
            steps = step_times(chosen, configuration, samples, clock)
        for estimator, own, seconds, balance in zip(chosen, found, spent, bare):
            if not (case.told or estimator.judges):
                seconds.append(float("nan"))
                continue
            period = 10**9 // estimator.rate
            given = thinned(samples, period, _begin(turn / len(seeds), period))
            if turn == 0:
                _track(estimator, configuration, given[:WARM], clock)
            track = _track(estimator, configuration, given, clock)
            own.append(errors(truth, track))
            if estimator.method is None:
                balance.append(1e6 * track.seconds / len(track.t_ns))
                seconds.append(float("nan"))
                continue
            if estimator is chosen[0]:
                judging -= track.seconds / len(track.t_ns)
            # Noise of the clock may leave less than nothing of it.
            total = track.seconds + (max(judging, 0.0) * len(track.t_ns) if case.told else 0.0)
            seconds.append(1e6 * total / duration_ms)
    usual = float(np.median(spent[0]))
    return [
        ChartScore(  # type: ignore[call-arg]
            _kind_of(case), case.name, str(estimator),
            *_about([e.reactions for e in own]),
            *(_median([getattr(e, name) for e in own]) for name in
              ("tilt_rate", "reactions_inside", "determined")),
            sum(e.lost for e in own) / max(len(own), 1),
            *_quartiles(step or balance),
            usual * float(np.median(np.divide(seconds, spent[0]))),
        )
        for estimator, own, seconds, step, balance in zip(chosen, found, spent, steps, bare)
    ]  # fmt: skip


def _kind_of(case):
    return next((kind for kind, cases in SCENE_KINDS.items() if case in cases), "")


def _begin(share, period_ns):
    """Return where sampling begins [ns]: a share of a period, at an orientation."""
    return int(share * period_ns) // JOINT_PERIOD_NS * JOINT_PERIOD_NS


def _about(values):
    known = [value for value in values if not np.isnan(value)]
    if not known:
        return (float("nan"),) * 3
    return _median(known), min(known), max(known)


def _track(
    estimator: Estimator,
    configuration: Configuration,
    samples: Sequence,
    clock: Callable[[], float],
) -> Track:
    if estimator.method is None:
        return bare_balance(configuration, samples, clock)
    return run(configuration, samples, clock, estimator.method.make)


def step_times(
    chosen: Sequence[Estimator],
    configuration: Configuration,
    samples: Sequence,
    clock: Callable[[], float],
) -> list[list[float]]:
    """
    Return the time of the compiled step for a wrench [us], in STEP_TURNS; empty: it has none.

    All of one rate take the same steps, in turns.

    Parameters
    ----------
    chosen : sequence of Estimator
    configuration : Configuration
    samples : sequence
        Joint and wrench samples.
    clock : callable
        Returns a time [s].

    """
    calls = {
        rate: noted(configuration, thinned(samples, 10**9 // rate), clock)
        for rate in {one.rate for one in chosen}
    }
    found: list[list[float]] = [[] for _ in chosen]
    for turn in range(1 + STEP_TURNS):
        for one, own in zip(chosen, found):
            if one.method is None or one.method.settings is None:
                continue
            settings = default_settings(**one.method.settings)
            _, seconds = taken_anew(calls[one.rate], settings, clock)
            # The first brings its memory to hand.
            if turn > 0:
                own.append(1e6 * seconds)
    return found


def _quartiles(values: Sequence[float]) -> tuple[float, float, float]:
    """Return median and quartiles; NaN of none."""
    if not values:
        return (float("nan"),) * 3
    low, middle, high = np.percentile(values, (25, 50, 75)).tolist()
    return middle, low, high


def bound_score(case: Case, truth: Truth) -> ChartScore:
    """Return the least errors of any estimator at 1 kHz over a motion; NaN: no bound is sound."""
    nothing = float("nan")
    # It is one of three contacts, of which one is told.
    least = least_errors(truth, bound_along(truth)) if case.told else Least(nothing, nothing)
    return ChartScore(
        _kind_of(case), case.name, BOUND, least.reactions, nothing, nothing, least.tilt_rate,
        nothing, nothing, 0.0, *(nothing,) * 4,
    )  # fmt: skip


def _median(values):
    """Return the median of what is a number; NaN of none."""
    known = [value for value in values if not np.isnan(value)]
    return float(np.median(known)) if known else float("nan")


class Overall(NamedTuple):
    """
    One estimator over several motions.

    Attributes
    ----------
    name : str
    reactions, reactions_low, reactions_high, tilt_rate : float
        Geometric mean over the motions.
    reactions_inside, determined : float
        Mean over the motions.
    lost : float
        Share of all runs.
    step, step_low, step_high, whole : float
        Median of the motions.

    """

    name: str
    reactions: float
    reactions_low: float
    reactions_high: float
    tilt_rate: float
    reactions_inside: float
    determined: float
    lost: float
    step: float
    step_low: float
    step_high: float
    whole: float

    def per_ms(self) -> float:
        """Return the time of its steps for a millisecond of motion [us]."""
        rates = {str(one): one.rate for one in ESTIMATORS}
        return self.step * rates.get(self.name, 1000) / 1000


def over_motions(found: Sequence[ChartScore]) -> list[Overall]:
    """Return each estimator over all motions of some scores."""
    rows = []
    for name in dict.fromkeys(score.name for score in found):
        own = [score for score in found if score.name == name]
        errors = ("reactions", "reactions_low", "reactions_high", "tilt_rate")
        rows.append(
            Overall(  # type: ignore[call-arg]
                name,
                *(geometric_mean([getattr(s, part) for s in own]) for part in errors),
                *(_mean([getattr(s, part) for s in own])
                  for part in ("reactions_inside", "determined")),
                float(np.mean([s.lost for s in own])),
                *(_median([getattr(s, part) for s in own])
                  for part in ("step", "step_low", "step_high", "whole")),
            )
        )  # fmt: skip
    return rows


def of_kinds(found: Sequence[ChartScore]) -> dict[str, list[Overall]]:
    """Return each estimator over the motions of each kind of scene."""
    return {
        kind: over_motions([score for score in found if score.kind == kind])
        for kind in dict.fromkeys(score.kind for score in found)
    }


def overall(found: Sequence[ChartScore]) -> list[Overall]:
    """
    Return each estimator over all kinds in which all are compared, each kind for the same.

    Left out are those of OWN_ROWS: a start that no method has a prior for, and the hole, where
    some cannot judge.
    """
    compared = [
        score
        for kind, rows in of_kinds(found).items()
        if kind not in OWN_ROWS
        for score in (_as_score(kind, row) for row in rows)
    ]
    return over_motions(compared or found)


def _as_score(kind, row):
    return ChartScore(kind, "", *row)


def _mean(values):
    """Return the mean of what is a number; NaN of none."""
    known = [value for value in values if not np.isnan(value)]
    return float(np.mean(known)) if known else float("nan")


class Limits(NamedTuple):
    """
    What no estimator goes below, and what is around it.

    Attributes
    ----------
    reactions, tilt_rate : float
        Errors as of `Overall`, by the bound at 1 kHz.
    whole : float
        Of the default at 1 kHz, from messages to outputs [us for a millisecond]: what is less
        than that saves little.

    """

    reactions: float
    tilt_rate: float
    whole: float


def limits(found: list[Overall]) -> tuple[list[Overall], Limits]:
    """Return the estimators among what was found, and the limits."""
    named = {row.name: row for row in found}
    bound = named.pop(BOUND)
    own = Limits(bound.reactions, bound.tilt_rate, named[str(DEFAULT)].whole)
    return list(named.values()), own


def keeps(row: Overall) -> bool:
    """Return whether an estimator's word on its reactions counts."""
    sure = row.determined >= LEAST_DETERMINED and row.reactions_inside >= LEAST_COVERED
    return bool(sure) and not row.lost


def geometric_mean(values: Iterable[float]) -> float:
    """Return the geometric mean of what is a number; NaN of none."""
    known = [value for value in values if not np.isnan(value)]
    return float(np.exp(np.mean(np.log(known)))) if known else float("nan")


def front(cost: Sequence[float] | np.ndarray, error: Sequence[float] | np.ndarray) -> list[int]:
    """Return the places on the Pareto front by rising cost: none is both dearer and worse."""
    kept, least = [], np.inf
    for k in np.lexsort((error, cost)):  # type: ignore[arg-type]
        if error[k] < least:
            kept.append(int(k))
            least = error[k]
    return kept


class CyclePiece(NamedTuple):
    """
    What a step costs in a piece of a working cycle.

    Attributes
    ----------
    method : str
    t : float
        Where it begins [s].
    phase, mode : str
        Of the cycle there, and the true contact mode.
    step : float
        As of `ChartScore`.

    """

    method: str
    t: float
    phase: str
    mode: str
    step: float


def cycle_costs(truth: Truth, clock: Callable[[], float]) -> list[CyclePiece]:
    """Return what the steps of CYCLE_METHODS cost along a cycle, in pieces."""
    calls = noted(truth.plan.configuration, list(measure(truth, 1)), clock)
    rows = []
    for method in CYCLE_METHODS:
        settings = default_settings(**(METHODS[method].settings or {}))
        for piece in cost_along(calls, settings, clock, CYCLE_PIECE, STEP_TURNS):
            k = min(int(np.searchsorted(truth.t_ns, 1e9 * piece.t)), len(truth.t_ns) - 1)
            rows.append(
                CyclePiece(method, piece.t, str(truth.phase[k]), str(truth.mode[k]), piece.step)
            )
    return rows
