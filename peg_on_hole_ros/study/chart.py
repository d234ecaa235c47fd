"""What is charted: the default and common methods, at three rates, over many motions."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.methods import dde_driven
from peg_on_hole_ros.estimator.methods.method import Make
from peg_on_hole_ros.estimator.methods.registry import make_filter
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.sim.truth import Truth
from peg_on_hole_ros.study.balance import make_balance, make_small_angle
from peg_on_hole_ros.study.cost_floor import arithmetic
from peg_on_hole_ros.study.fewer_freedoms import make_one, make_two
from peg_on_hole_ros.study.particles import make_particles
from peg_on_hole_ros.study.runs import Errors, always_in_contact, errors, run, thinned
from peg_on_hole_ros.study.scenes import bound_along, least_errors
from peg_on_hole_ros.study.smoothed import make_smoothed
from peg_on_hole_ros.study.unscented import make_unscented

# Samples that an estimator runs over before it is timed: what it needs beyond others is compiled.
WARM = 150
# Below this, 95 % bounds are sure and wrong.
OVERCONFIDENT_COVERAGE = 0.9
# Of the samples; an estimator that determines less tells nothing.
LEAST_DETERMINED = 0.5
# Thousands of times what one wrench tells of an acceleration [rad/s^2].
DDE_LEVEL = 1e5


class Estimator(NamedTuple):
    """
    A row of the chart's table.

    Attributes
    ----------
    name : str
    rate : int
        Wrenches that it is given [Hz], and as many orientations, at most 500.
    make : callable
        As `make_filter`.
    shown : bool
        It is a point of the picture.

    """

    name: str
    rate: int
    make: Make
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


def make_dde_driven(
    scene: Scene,
    options: FilterOptions,
    wrench_noise: np.ndarray,
    offsets: OffsetUncertainty | None = None,
) -> ContactFilter:
    """
    Return the estimator in which the wrench alone drives the motion.

    With the level of the method `dde_driven`, 1e6, rates are lost before the first wrench is used.
    """
    settings = default_settings(**dde_driven.SETTINGS | {"mode_stddev": (DDE_LEVEL,)})
    return ContactFilter(scene, options, wrench_noise, offsets, settings)


WRENCH_RATES = (1000, 500, 100)
DEFAULT = Estimator("default", WRENCH_RATES[0], partial(by_method, "mixture"))
# Those of which the fastest alone is drawn.
_OTHER_METHODS: dict[str, Make] = {
    "no mixture": partial(by_method, "one_level"),
    "quasi-static balance": make_balance,
    "small angle": make_small_angle,
    "1 DOF": make_one,
    "2 DOF": make_two,
    "DDE-driven": make_dde_driven,
    "unscented": make_unscented,
    "particles": make_particles,
    "smoother": make_smoothed,
}
ESTIMATORS = (
    *(DEFAULT._replace(rate=rate) for rate in WRENCH_RATES),
    *(
        Estimator(name, rate, make, rate == WRENCH_RATES[0])
        for name, make in _OTHER_METHODS.items()
        for rate in WRENCH_RATES
    ),
    *(
        Estimator("no inertia", rate, partial(by_method, "quasi_static"), False)
        for rate in WRENCH_RATES
    ),
)


# No estimators: what the default's arithmetic alone costs, and the bound on the errors of all.
LIMIT, BOUND = "C limit, 1 kHz", "bound, 1 kHz"


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
    microseconds : float
        Computing time for a millisecond of motion, from messages to outputs: median of the ratios
        to the default in the same turn, times the median of that one. What judging modes and
        alarms costs a wrench is the default's for all.

    """

    case: str
    name: str
    reactions: float
    tilt_rate: float
    reactions_inside: float
    determined: float
    lost: float
    microseconds: float


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
    duration_ms = (truth.t_ns[-1] - truth.t_ns[0]) * 1e-6
    run(judged, list(measure(truth, 0))[:WARM], clock)
    for turn, seed in enumerate(seeds):
        samples = list(measure(truth, seed))
        whole = run(judged, samples, clock)
        # Of a wrench [s].
        judging = whole.seconds / len(whole.t_ns)
        for estimator, own, seconds in zip(chosen, found, spent):
            given = thinned(samples, 10**9 // estimator.rate)
            if turn == 0:
                run(configuration, given[:WARM], clock, estimator.make)
            track = run(configuration, given, clock, estimator.make)
            own.append(errors(truth, track))
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
            usual * float(np.median(np.divide(seconds, spent[0]))),
        )
        for estimator, own, seconds in zip(chosen, found, spent)
    ]  # fmt: skip


def limit_score(
    case: str, truth: Truth, seeds: Iterable[int], clock: Callable[[], float]
) -> ChartScore:
    """Return what the default's arithmetic alone costs; parameters as for `scores`."""
    configuration = always_in_contact(truth.plan.configuration)
    duration_ms = (truth.t_ns[-1] - truth.t_ns[0]) * 1e-6
    seconds = [arithmetic(configuration, list(measure(truth, seed)), clock) for seed in seeds]
    nothing = float("nan")
    return ChartScore(case, LIMIT, *(nothing,) * 4, 0.0, 1e6 * _median(seconds) / duration_ms)


def bound_score(case: str, truth: Truth) -> ChartScore:
    """Return the least errors of any estimator at 1 kHz over a motion; NaN: no bound is sound."""
    least = least_errors(truth, bound_along(truth))
    nothing = float("nan")
    return ChartScore(case, BOUND, *least, *(nothing,) * 2, 0.0, nothing)


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
    reactions_inside, determined, microseconds : float
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
    microseconds: float


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
                _median([s.microseconds for s in own]),
            )
        )  # fmt: skip
    return rows


class Limits(NamedTuple):
    """
    What no estimator goes below.

    Attributes
    ----------
    reactions, tilt_rate : float
        Errors as of `Overall`, by the bound at 1 kHz.
    microseconds : float
        For a millisecond of motion at 1 kHz: the default's arithmetic alone, compiled.

    """

    reactions: float
    tilt_rate: float
    microseconds: float


def limits(found: list[Overall]) -> tuple[list[Overall], Limits]:
    """Return the estimators among what was found, and the limits."""
    named = {row.name: row for row in found}
    bound, arithmetic_alone = named.pop(BOUND), named.pop(LIMIT)
    own = Limits(bound.reactions, bound.tilt_rate, arithmetic_alone.microseconds)
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
