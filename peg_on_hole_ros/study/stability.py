"""Where estimators work, have wrong bounds or diverge: the result of one at a place of the map."""

from collections.abc import Iterable
from dataclasses import replace
from enum import Enum
from functools import partial
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.estimator.methods.method import Make
from peg_on_hole_ros.sim.measure import measure, sensor_wrench
from peg_on_hole_ros.sim.truth import Truth
from peg_on_hole_ros.study.bare_balance import bare_balance
from peg_on_hole_ros.study.chart import LEAST_DETERMINED
from peg_on_hole_ros.study.estimators import BARE, DDE_DRIVEN, by_method
from peg_on_hole_ros.study.map_places import MapPlace, truth_at
from peg_on_hole_ros.study.runs import (
    INSIDE_STDDEVS,
    LEAST_COVERED,
    Track,
    always_in_contact,
    compared,
    run,
)

DEFAULT = "mixture"
# None: the bare balance, which is no estimator of the pipeline.
COMPARED_METHODS: dict[str, Make | None] = {
    DEFAULT: partial(by_method, DEFAULT),
    "one_level": partial(by_method, "one_level"),
    "balance": partial(by_method, "balance"),
    "dde_driven": DDE_DRIVEN.make,
    "unscented": partial(by_method, "unscented"),
    "particles_1000": partial(by_method, "particles_1000"),
    BARE: None,
}
QUANTITIES = ("gamma", "psi", "phi", "gamma'", "psi'", "phi'", "N_K", "N_B1", "N_B2")
_STATES = 6


class Verdict(Enum):
    """The result of an estimator at a place."""

    HOLDS = "works"
    UNDETERMINED = "reactions not determined"
    ERRS = "bounds too narrow"
    DIVERGED = "diverged"
    NONE = "no motion on three contacts"


class Result(NamedTuple):
    """
    One method at one place, over all seeds of the noise together.

    Attributes
    ----------
    method : str
    seeds : int
    verdict : Verdict
    worst : str
        Of QUANTITIES that which lies least within its bounds.
    inside : float
        Share of it within the stated 95 %; of reactions where they are determined.
    determined : float
        Share of samples.
    reactions : float
        Root mean square of the error over the mean reaction; NaN where none are estimated.
    lost : int
        Seeds.

    """

    method: str
    seeds: int
    verdict: Verdict
    worst: str = ""
    inside: float = float("nan")
    determined: float = float("nan")
    reactions: float = float("nan")
    lost: int = 0


class Settled(NamedTuple):
    """
    A track beside the truth, once it has settled.

    Attributes
    ----------
    error : ndarray, shape (n, 9)
        As `runs.Track.values`.
    inside : ndarray of bool, shape (n, 9)
        Within the stated 95 %.
    determined : ndarray of bool, shape (n,)
    reacts : bool
        It estimates reactions.
    lost : bool
        Something is not finite, or the orientation ends too far off.

    """

    error: np.ndarray
    inside: np.ndarray
    determined: np.ndarray
    reacts: bool
    lost: bool


def settled(truth: Truth, track: Track) -> Settled:
    """Return a track on three contacts beside a truth whose samples hold all its stamps."""
    found = compared(truth, track) if len(track.t_ns) else None
    if found is None:
        nothing = np.empty((0, 9))
        return Settled(nothing, nothing.astype(bool), np.empty(0, bool), False, False)
    # A NaN among published quantities means lost; quantities that it does not have are left out.
    reacts = bool(np.isfinite(found.error[:, _STATES:]).any())
    finite = bool(np.isfinite(found.error[:, : None if reacts else _STATES]).all())
    inside = np.abs(found.error) <= INSIDE_STDDEVS * found.stddev
    return Settled(found.error, inside, found.determined, reacts, found.lost or not finite)


class Examiner:
    """
    Examines methods at places; keeps the last place's motion.

    Parameters
    ----------
    configuration : Configuration
        What places differ from.

    """

    def __init__(self, configuration: Configuration) -> None:
        self.configuration = configuration
        self._place: MapPlace | None = None
        self._truth: Truth | None = None
        self._exact = np.empty((0, 6))

    def __call__(self, place: MapPlace, method: str, seeds: Iterable[int]) -> Result:
        """Return the result of a method of COMPARED_METHODS."""
        if place != self._place:
            self._place, self._truth = place, truth_at(place, self.configuration)
            if self._truth is not None:
                self._exact = sensor_wrench(self._truth)
        seeds = list(seeds)
        if self._truth is None:
            return Result(method, len(seeds), Verdict.NONE)
        return _examined(self._truth, self._exact, method, seeds)


def _examined(truth, exact, method, seeds):
    configuration, make = _stated(truth), COMPARED_METHODS[method]
    found = []
    for seed in seeds:
        samples = list(measure(truth, seed, exact=exact))
        with np.errstate(invalid="ignore", over="ignore"):
            if make is None:
                track = bare_balance(configuration, samples, _no_clock)
            else:
                track = run(configuration, samples, _no_clock, make)
            found.append(settled(truth, track))
    return judged(method, found, float(truth.normal.mean()))


def _stated(truth: Truth) -> Configuration:
    """Return what is stated to an estimator: no delay."""
    configuration = truth.plan.configuration
    joints = replace(configuration.joints, delay=0.0)
    return always_in_contact(replace(configuration, joints=joints))


def judged(method: str, found: list, mean_reaction: float) -> Result:
    """
    Return what runs with one seed each, as of `settled`, come to together.

    Parameters
    ----------
    method : str
    found : list of Settled
    mean_reaction : float
        [N].

    """
    error, inside, determined = (
        np.concatenate([getattr(one, part) for one in found])
        for part in ("error", "inside", "determined")
    )
    reacts = any(one.reacts for one in found)
    lost = sum(one.lost for one in found)
    if not len(error):
        return Result(method, len(found), Verdict.UNDETERMINED, determined=0.0)
    shares = inside[:, :_STATES].mean(axis=0).tolist()
    if reacts and determined.any():
        shares += inside[determined, _STATES:].mean(axis=0).tolist()
    worst = int(np.argmin(shares))
    share = float(determined.mean()) if reacts else 0.0
    verdict = Verdict.HOLDS
    if lost:
        verdict = Verdict.DIVERGED
    elif shares[worst] < LEAST_COVERED:
        verdict = Verdict.ERRS
    elif share < LEAST_DETERMINED:
        verdict = Verdict.UNDETERMINED
    with np.errstate(invalid="ignore", over="ignore"):
        off = float(np.sqrt(np.mean(error[:, _STATES:] ** 2))) / mean_reaction
    return Result(method, len(found), verdict, QUANTITIES[worst], shares[worst], share, off, lost)


def _no_clock():
    return 0.0
