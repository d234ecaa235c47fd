"""Variants of the filter over measured motions: error, error over the bound, coverage, cost."""

from collections.abc import Callable
from dataclasses import fields, replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.bound import Bound, Meaning
from peg_on_hole_ros.estimation.measurement import WrenchReduction
from peg_on_hole_ros.estimator.methods import make_filter
from peg_on_hole_ros.options import Configuration, FilterOptions
from peg_on_hole_ros.study.scenes import Recording

DEFAULT = "default"
# The estimate begins with one orientation and no rates [s].
SETTLE = 0.05
# Rows that a variant runs over before it is timed: what it needs beyond others is compiled then.
WARM = 21


class Variant(NamedTuple):
    """
    A filter by what it changes of the configuration.

    Attributes
    ----------
    name : str
    options : dict
        Of FilterOptions.
    scene : dict
        Of Scene.
    every : int
        Only each so many-th wrench is used, and the orientations that come with these.
    contact : bool
        Contact dynamics; else constant rates, and no reactions.
    seeds : int
        It runs over no more than these: slow ones do.
    told : bool
        It knows what the default has to learn, so that it does not compete with it.

    """

    name: str
    options: dict = {}
    scene: dict = {}
    every: int = 1
    contact: bool = True
    seeds: int = 1000
    told: bool = False


VARIANTS = (
    Variant(DEFAULT),
    Variant("friction taken as known", scene={"friction_stddev": 0.0}, told=True),
    Variant("friction considered", {"friction": "considered"}),
    Variant(
        "clearance considered, 2 um",
        {"clearance": "considered"},
        scene={"clearance_stddev": 2e-6},
    ),
    Variant("no widening by slip", {"slip_widening": 0.0}),
    Variant("slow slip followed", {"slow_slip": 0.0}),
    Variant("wrench held as measured", {"wrench_jump": 0.0}),
    Variant("no prior on accelerations", {"acceleration_stddev": 1e6}),
    Variant("wrench at 500 Hz", every=2),
    Variant("wrench, orientation at 100 Hz", every=10),
    Variant("constant rates, no contact model", contact=False),
)
SLOW_SEEDS = 2
# Options that choose another method, where the filter has them: option, value, name, seeds.
_METHODS = (
    ("model", "auto", "model: auto", 1000),
    ("model", "small_angle", "small-angle balance", 1000),
    ("model", "quasi_static", "quasi-static balance", 1000),
    ("model", "align", "1-DOF align", 1000),
    ("model", "align_slip", "2-DOF align and slip", 1000),
    ("integrator", "linearly_implicit", "linearly implicit step", 1000),
    ("integrator", "second_order", "second-order step", 1000),
    ("method", "iterated", "iterated EKF", SLOW_SEEDS),
    ("method", "unscented", "unscented", SLOW_SEEDS),
    ("method", "square_root", "square root", SLOW_SEEDS),
)


class Score(NamedTuple):
    """
    One variant over one motion; median over the seeds, and between what two of three are.

    Attributes
    ----------
    case, name : str
        Of the motion and of the variant.
    state_error, reaction_error : float
        Root mean square of the rotation's error over that of one measured orientation, and of the
        reactions' error over their mean.
    reaction_error_low, reaction_error_high : float
        Between which the latter is for two seeds of three.
    state_ratio, reaction_ratio : float
        Root mean square of the error over the bound, over samples where the bound is sound: angles
        and rates; reactions. NaN where it nowhere is.
    state_low, state_high, reaction_low, reaction_high : float
        Between which the ratio is for two seeds of three.
    coverage : float
        Share of reactions within the stated 95 %.
    lost : float
        Share of runs that end without a finite estimate or 10 sigma off.
    microseconds : float
        Computing time for a millisecond of motion, filter's methods called from Python: median of
        the ratios to the first variant in the same turn, times the median of that one.

    """

    case: str
    name: str
    state_error: float
    reaction_error: float
    reaction_error_low: float
    reaction_error_high: float
    state_ratio: float
    state_low: float
    state_high: float
    reaction_ratio: float
    reaction_low: float
    reaction_high: float
    coverage: float
    lost: float
    microseconds: float


def variants(table) -> list[Variant]:
    """
    Return the variants that this filter knows.

    Parameters
    ----------
    table : callable
        Returns the choices of a parameter by its name, or None.

    """
    known = {field.name for field in fields(FilterOptions)}
    more = [
        Variant(name, {option: value}, seeds=seeds)
        for option, value, name, seeds in _METHODS
        if option in known and value in (table(f"filter.{option}") or ())
    ]
    return [*VARIANTS, *more]


class Track(NamedTuple):
    """What a filter says at every sample that it used: rows, errors and stated deviations."""

    rows: np.ndarray
    values: np.ndarray
    stddev: np.ndarray
    seconds: float


def run(variant: Variant, configuration: Configuration, recording: Recording,
        clock: Callable[[], float]) -> Track:  # fmt: skip
    """Run a variant over a recording; values are states and reactions, shape (n, 9)."""
    scene = replace(configuration.scene, **variant.scene)
    options = replace(configuration.filter, **variant.options)
    kalman = make_filter(scene, options, WrenchReduction(configuration.wrench, scene).covariance)
    kalman.start(recording.angles[0], recording.covariances[0])
    dt, contact = recording.dt * variant.every, variant.contact
    rows = np.arange(variant.every, len(recording.wrench), variant.every)
    values, stddev = np.full((len(rows), 9), np.nan), np.full((len(rows), 9), np.nan)
    measured = np.isfinite(recording.angles).all(axis=1)
    begun = clock()
    for n, k in enumerate(rows.tolist()):
        kalman.hold(recording.wrench[k])
        kalman.predict(dt, contact)
        if measured[k]:
            kalman.correct(recording.angles[k], recording.covariances[k])
        values[n, :6] = kalman.x
        stddev[n, :6] = kalman.P.diagonal()
        if contact:
            found = kalman.reactions()
            if found is not None:
                values[n, 6:], stddev[n, 6:] = found.normal, found.normal_stddev
    seconds = clock() - begun
    stddev[:, :6] = np.sqrt(stddev[:, :6])
    return Track(rows, values, stddev, seconds)


def scores(chosen, case: str, motion, clock) -> list[Score]:
    """
    Return the Score of each variant over one motion.

    The variants take turns, so that what slows the machine for a while slows all of them.

    Parameters
    ----------
    chosen : list of Variant
    case : str
        Name of the motion.
    motion : tuple
        (truth, bound, recordings), one recording a seed.
    clock : callable
        Returns a time [s].

    """
    truth, bound, recordings = motion
    configuration = truth.plan.configuration
    begin = recordings[0]._replace(
        **{
            name: getattr(recordings[0], name)[:WARM]
            for name in ("wrench", "angles", "covariances")
        }
    )
    for variant in chosen:
        run(variant, configuration, begin, clock)
    kept: list[list] = [[] for _ in chosen]
    for seed, recording in enumerate(recordings):
        for variant, own in zip(chosen, kept):
            if seed < variant.seeds:
                track = run(variant, configuration, recording, clock)
                own.append(_errors(variant, truth, bound, recording, track))
    first = [run.microseconds for run in kept[0]]
    usual = float(np.median(first))
    return [
        _score(case, variant.name, own, usual * _paired([r.microseconds for r in own], first))
        for variant, own in zip(chosen, kept)
    ]


def _paired(values, others):
    """Return the median of ratios of what was measured in the same turn."""
    return float(np.median([value / other for value, other in zip(values, others)]))


class _Errors(NamedTuple):
    state: float
    reaction: float
    state_ratio: float
    reaction_ratio: float
    inside: np.ndarray
    lost: bool
    microseconds: float


def _errors(variant, truth, bound, recording, track) -> _Errors:
    """Return what one run is off by, and its cost."""
    exact = np.hstack([truth.q, truth.rates, truth.normal])
    sigma = _sigma(bound)
    error = track.values - exact[track.rows]
    error[:, 1:3] -= 2 * np.pi * np.round(error[:, 1:3] / (2 * np.pi))
    last = np.abs(error[-1, :6]) < 10 * np.maximum(sigma[track.rows[-1], :6], 1e-4)
    settled = truth.t_ns[track.rows] * 1e-9 >= SETTLE
    sound = settled & (bound.meaning[track.rows] == Meaning.SOUND)
    turned = error[settled, :3]
    cosine = np.cos(truth.q[track.rows][settled, 0])
    rotation = (turned**2).sum(axis=1) + 2 * cosine * turned[:, 1] * turned[:, 2]
    ratio = error[sound] / sigma[track.rows][sound]
    inside = np.abs(error[settled, 6:]) < 1.96 * track.stddev[settled, 6:]
    noise = truth.plan.configuration.joints.position_stddev * np.sqrt(3.0)
    contact = variant.contact
    return _Errors(
        float(np.sqrt(rotation.mean())) / noise,
        _rms(error[settled, 6:]) / float(truth.normal.mean()) if contact else float("nan"),
        _rms(ratio[:, :6]),
        _rms(ratio[:, 6:]) if contact else float("nan"),
        inside if contact else np.empty((0, 3)),
        not last.all(),
        1e3 * track.seconds / len(track.rows) / (variant.every * recording.dt),
    )


def _score(case, name, runs, microseconds) -> Score:
    inside = np.concatenate([r.inside for r in runs])
    reaction = _over_seeds([r.reaction for r in runs])
    return Score(
        case,
        name,
        _over_seeds([r.state for r in runs])[0],
        *reaction,
        *_over_seeds([r.state_ratio for r in runs]),
        *_over_seeds([r.reaction_ratio for r in runs]),
        float(inside.mean()) if len(inside) else float("nan"),
        sum(r.lost for r in runs) / len(runs),
        microseconds,
    )


def _sigma(bound: Bound):
    parts = [np.diagonal(part, axis1=1, axis2=2) for part in (bound.state, bound.reactions)]
    return np.sqrt(np.hstack(parts))


def _rms(values):
    """Return the root mean square; NaN of none, infinite where one is not a number."""
    if not values.size:
        return float("nan")
    total = float(np.sqrt(np.mean(values**2)))
    return total if np.isfinite(total) else float("inf")


def _over_seeds(values):
    return tuple(float(v) for v in np.quantile(values, (0.5, 1 / 6, 5 / 6)))
