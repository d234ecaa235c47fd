"""Variants of the filter over measured motions: error over the bound, coverage, cost."""

from collections.abc import Callable
from dataclasses import fields, replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.bound import Bound, Meaning
from peg_on_hole_ros.estimation.filter import ContactFilter
from peg_on_hole_ros.estimation.measurement import WrenchReduction
from peg_on_hole_ros.options import Configuration, FilterOptions
from peg_on_hole_ros.study.scenes import Recording

DEFAULT = "default"
# The estimate begins with one orientation and no rates [s].
SETTLE = 0.05


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
        Only each so many-th wrench is used.
    contact : bool
        Contact dynamics; else constant rates, and no reactions.

    """

    name: str
    options: dict = {}
    scene: dict = {}
    every: int = 1
    contact: bool = True


VARIANTS = (
    Variant(DEFAULT),
    Variant("friction taken as known", scene={"friction_stddev": 0.0}),
    Variant("friction considered", {"friction": "considered"}),
    Variant(
        "clearance considered, 2 um",
        {"clearance": "considered"},
        scene={"clearance_stddev": 2e-6},
    ),
    Variant("no widening by slip", {"slip_widening": 0.0}),
    Variant("slow slip followed", {"slow_slip": 0.0}),
    Variant("no prior on accelerations", {"acceleration_stddev": 1e6}),
    Variant("wrench at 500 Hz", every=2),
    Variant("wrench at 100 Hz", every=10),
    Variant("constant rates, no contact model", contact=False),
)
# Options that choose another method, where the filter has them: option, value, name.
_METHODS = (
    ("integrator", "linearly_implicit", "linearly implicit step"),
    ("integrator", "second_order", "second-order step"),
    ("method", "iterated", "iterated EKF"),
    ("method", "unscented", "unscented"),
    ("method", "square_root", "square root"),
)


class Score(NamedTuple):
    """
    One variant over all motions and seeds.

    Attributes
    ----------
    name : str
    state_ratio, reaction_ratio : float
        Root mean square of the error over the bound, over samples where the bound is sound:
        median over the seeds.
    state_low, state_high, reaction_low, reaction_high : float
        Between which the ratio is for two seeds of three.
    coverage : float
        Share of reactions within the stated 95 %.
    lost : float
        Share of runs that end without a finite estimate or 10 sigma off.
    microseconds : float
        A step, filter's methods called from Python.

    """

    name: str
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
        Variant(name, {option: value})
        for option, value, name in _METHODS
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
    kalman = ContactFilter(scene, options, WrenchReduction(configuration.wrench, scene).covariance)
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


def score(variant, configuration, motions, clock) -> Score:
    """
    Return the Score of a variant.

    Parameters
    ----------
    motions : list of tuple
        (truth, bound, recordings) of each motion, one recording a seed.
    clock : callable
        Returns a time [s].

    """
    seeds = len(motions[0][2])
    squares = [[[], []] for _ in range(seeds)]
    inside, lost, seconds, steps = [], 0, [], 0
    for truth, bound, recordings in motions:
        exact = np.hstack([truth.q, truth.rates, truth.normal])
        sigma = _sigma(bound)
        sound = (bound.meaning == Meaning.SOUND) & (truth.t_ns * 1e-9 >= SETTLE)
        for s, recording in enumerate(recordings):
            track = run(variant, configuration, recording, clock)
            seconds.append(track.seconds / len(track.rows))
            error = track.values - exact[track.rows]
            error[:, 1:3] -= 2 * np.pi * np.round(error[:, 1:3] / (2 * np.pi))
            last = np.abs(error[-1, :6]) < 10 * np.maximum(sigma[track.rows[-1], :6], 1e-4)
            lost += not last.all()
            chosen = sound[track.rows]
            ratio = (error / sigma[track.rows])[chosen]
            squares[s][0].append(ratio[:, :6].ravel() ** 2)
            if variant.contact:
                squares[s][1].append(ratio[:, 6:].ravel() ** 2)
                inside.append(np.abs(error[chosen, 6:]) < 1.96 * track.stddev[chosen, 6:])
            steps += len(track.rows)
    states, reactions = (np.array([_rms(of_seed[part]) for of_seed in squares]) for part in (0, 1))
    coverage = float(np.concatenate(inside).mean()) if inside else float("nan")
    runs = seeds * len(motions)
    return Score(
        variant.name, *_over_seeds(states), *_over_seeds(reactions),
        coverage, lost / runs, 1e6 * float(np.min(seconds)),
    )  # fmt: skip


def _sigma(bound: Bound):
    parts = [np.diagonal(part, axis1=1, axis2=2) for part in (bound.state, bound.reactions)]
    return np.sqrt(np.hstack(parts))


def _rms(parts):
    if not parts:
        return float("nan")
    values = np.concatenate(parts)
    values = values[np.isfinite(values)]
    return float(np.sqrt(values.mean())) if len(values) else float("nan")


def _over_seeds(values):
    return tuple(float(v) for v in np.quantile(values, (0.5, 1 / 6, 5 / 6)))
