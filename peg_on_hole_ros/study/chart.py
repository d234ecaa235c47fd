"""What is charted: the default and common methods, at three rates, over many motions."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration, FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.methods import dde_driven
from peg_on_hole_ros.estimator.methods.method import Method, of_settings
from peg_on_hole_ros.estimator.methods.registry import METHODS, make_filter
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.sim.truth import Truth
from peg_on_hole_ros.study.bare_balance import bare_balance
from peg_on_hole_ros.study.cost_floor import noted, taken_anew
from peg_on_hole_ros.study.runs import Errors, Track, always_in_contact, errors, run, thinned
from peg_on_hole_ros.study.scenes import bound_along, least_errors
from peg_on_hole_ros.study.smoothed import make_smoothed

# Samples that an estimator runs over before it is timed: what it needs beyond others is compiled.
WARM = 150
# Below this, 95 % bounds are sure and wrong.
OVERCONFIDENT_COVERAGE = 0.9
# Of the samples; an estimator that determines less tells nothing.
LEAST_DETERMINED = 0.5
# Thousands of times what one wrench tells of an acceleration [rad/s^2].
DDE_LEVEL = 1e5


# How often the steps of a motion are taken, to tell how far their times spread.
STEP_TURNS = 7


class Estimator(NamedTuple):
    """
    A row of the chart's table.

    Attributes
    ----------
    name : str
        Of `filter.method`, where it is one.
    rate : int
        Wrenches that it is given [Hz], and as many orientations, at most 500.
    method : Method or None
        None: the bare balance, which is no estimator of the pipeline.
    shown : bool
        It is a point of the picture.

    """

    name: str
    rate: int
    method: Method | None
    shown: bool = True

    def __str__(self) -> str:
        """Return what it is called in tables."""
        return f"{self.name}, {'1 kHz' if self.rate == 1000 else f'{self.rate} Hz'}"


def by_method(
    method: str,
    scene: Scene,
    options: FilterOptions,
    wrench_noise: np.ndarray,
    offsets: OffsetUncertainty | None = None,
) -> ContactFilter:
    """Return the estimator of a method, whatever the options name."""
    return make_filter(scene, replace(options, method=method), wrench_noise, offsets)


# The estimator in which the wrench alone drives the motion. With the level of the method, 1e6,
# rates are lost before the first wrench is used.
DDE_DRIVEN = of_settings(dde_driven.SETTINGS | {"mode_stddev": (DDE_LEVEL,)})
WRENCH_RATES = (1000, 500, 100)
DEFAULT = Estimator("mixture", WRENCH_RATES[0], METHODS["mixture"])
BARE = "bare balance"
_OTHERS: dict[str, Method | None] = {
    **{name: method for name, method in METHODS.items() if name != DEFAULT.name},
    "dde_driven": DDE_DRIVEN,
    "smoother": Method(make_smoothed),
    BARE: None,
}
# The smoother has no step to be a point, and the others are no more than one point among them.
_NOT_SHOWN = ("quasi_static", "particles_100", "smoother")
# Of the others the fastest alone is drawn.
ESTIMATORS = (
    *(DEFAULT._replace(rate=rate) for rate in WRENCH_RATES),
    *(
        Estimator(name, rate, method, rate == WRENCH_RATES[0] and name not in _NOT_SHOWN)
        for name, method in _OTHERS.items()
        for rate in WRENCH_RATES
    ),
)


# No estimator: the bound on the errors of all.
BOUND = "bound, 1 kHz"


class ChartScore(NamedTuple):
    """
    One estimator over one motion, median over the seeds.

    Attributes
    ----------
    case, name : str
        Of the motion and of the estimator.
    reactions : float
        Root mean square of the error over the mean reaction; NaN where none are told.
    tilt_rate : float
        Of gamma' [rad/s].
    reactions_inside : float
        Least share of a determined reaction within the stated 95 %.
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

    case: str
    name: str
    reactions: float
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
    case: str,
    truth: Truth,
    seeds: Iterable[int],
    clock: Callable[[], float],
) -> list[ChartScore]:
    """
    Return the ChartScore of each estimator over one motion.

    They are told that the peg is on three contacts, so that none is scored for when it believes
    it. They take turns, so that what slows the machine for a while slows all of them.

    Parameters
    ----------
    chosen : sequence of Estimator
        The first is what the others' times are compared with.
    case : str
    truth : Truth
        With wrenches at 1 kHz.
    seeds : iterable of int
        Of the sensors' noise.
    clock : callable
        Returns a time [s].

    """
    judged = truth.plan.configuration
    configuration = always_in_contact(judged)
    found: list[list[Errors]] = [[] for _ in chosen]
    spent: list[list[float]] = [[] for _ in chosen]
    bare: list[list[float]] = [[] for _ in chosen]
    steps: list[list[float]] = [[] for _ in chosen]
    duration_ms = (truth.t_ns[-1] - truth.t_ns[0]) * 1e-6
    run(judged, list(measure(truth, 0))[:WARM], clock)
    for turn, seed in enumerate(seeds):
        samples = list(measure(truth, seed))
        whole = run(judged, samples, clock)
        # Of a wrench [s].
        judging = whole.seconds / len(whole.t_ns)
        if turn == 0:
            steps = step_times(chosen, configuration, samples, clock)
        for estimator, own, seconds, balance in zip(chosen, found, spent, bare):
            given = thinned(samples, 10**9 // estimator.rate)
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
            total = track.seconds + max(judging, 0.0) * len(track.t_ns)
            seconds.append(1e6 * total / duration_ms)
    usual = float(np.median(spent[0]))
    return [
        ChartScore(  # type: ignore[call-arg]
            case, str(estimator),
            *(_median([getattr(e, name) for e in own]) for name in
              ("reactions", "tilt_rate", "reactions_inside", "determined")),
            sum(e.lost for e in own) / len(own),
            *_spread(step or balance),
            usual * float(np.median(np.divide(seconds, spent[0]))),
        )
        for estimator, own, seconds, step, balance in zip(chosen, found, spent, steps, bare)
    ]  # fmt: skip


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


def _spread(values: Sequence[float]) -> tuple[float, float, float]:
    """Return median and quartiles; NaN of none."""
    if not values:
        return (float("nan"),) * 3
    low, middle, high = np.percentile(values, (25, 50, 75)).tolist()
    return middle, low, high


def bound_score(case: str, truth: Truth) -> ChartScore:
    """Return the least errors of any estimator at 1 kHz over a motion; NaN: no bound is sound."""
    least = least_errors(truth, bound_along(truth))
    nothing = float("nan")
    return ChartScore(case, BOUND, *least, *(nothing,) * 2, 0.0, *(nothing,) * 4)


def _median(values):
    """Return the median of what is a number; NaN of none."""
    known = [value for value in values if not np.isnan(value)]
    return float(np.median(known)) if known else float("nan")


class Overall(NamedTuple):
    """
    One estimator over all motions.

    Attributes
    ----------
    name : str
    reactions, tilt_rate : float
        Geometric mean over the motions.
    reactions_inside, determined, step, step_low, step_high, whole : float
        Median of the motions.
    lost : float
        Share of all runs.

    """

    name: str
    reactions: float
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


def overall(found: list[ChartScore]) -> list[Overall]:
    """Return each estimator over all motions."""
    rows = []
    for name in dict.fromkeys(score.name for score in found):
        own = [score for score in found if score.name == name]
        rows.append(
            Overall(  # type: ignore[call-arg]
                name,
                *(geometric_mean([getattr(s, part) for s in own])
                  for part in ("reactions", "tilt_rate")),
                *(_median([getattr(s, part) for s in own])
                  for part in ("reactions_inside", "determined")),
                float(np.mean([s.lost for s in own])),
                *(_median([getattr(s, part) for s in own])
                  for part in ("step", "step_low", "step_high", "whole")),
            )
        )  # fmt: skip
    return rows


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
