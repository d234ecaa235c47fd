"""One estimator over one measured motion, whole path: what it says, how far off, at what cost."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.estimator.methods.method import Make
from peg_on_hole_ros.estimator.methods.registry import make_filter
from peg_on_hole_ros.monitor.output_row import ROW
from peg_on_hole_ros.records import Arrivals, WrenchSample
from peg_on_hole_ros.sim.measure import START_NS
from peg_on_hole_ros.sim.truth import Truth
from peg_on_hole_ros.study.smoothed import Smoothed

# The estimate begins with one orientation and no rates [ns].
SETTLE_NS = 50_000_000
# An orientation further off at the end than so many standard deviations of a measured one.
LOST_STDDEVS = 10.0
INSIDE_STDDEVS = 1.959964
# Where less of a quantity is within its 95 % bounds, these are sure and wrong.
LEAST_COVERED = 0.9
# A peg in the hole that goes in faster slides [m/s].
SLIDES = 5e-4


class Track(NamedTuple):
    """
    What an estimator says at each wrench that it was given.

    Attributes
    ----------
    t_ns : ndarray, shape (n,)
        Since the begin of the motion [ns].
    values, stddev : ndarray, shape (n, 9)
        Angles [rad], rates [rad/s], reactions [N]; NaN where it says nothing of a quantity.
    determined : ndarray of bool, shape (n,)
        Reactions are declared determined.
    seconds : float
        Computing time.
    flag_ns : int or None
        When the transition was told first, as `t_ns`; None: never.

    """

    t_ns: np.ndarray
    values: np.ndarray
    stddev: np.ndarray
    determined: np.ndarray
    seconds: float
    flag_ns: int | None = None


class Errors(NamedTuple):
    """
    How far off a track is, once it has settled.

    Attributes
    ----------
    reactions : float
        Root mean square over the mean reaction; NaN of an estimator that tells none.
    tilt_rate : float
        Root mean square of gamma' [rad/s].
    states_inside, reactions_inside : float
        Least share of a quantity within the stated 95 %; of reactions where they are determined.
    determined : float
        Share of samples.
    lost : bool
        Something is not finite, or the orientation ends LOST_STDDEVS deviations off.

    """

    reactions: float
    tilt_rate: float
    states_inside: float
    reactions_inside: float
    determined: float
    lost: bool


def thinned(samples: Iterable, period_ns: int, begin_ns: int = 0) -> list:
    """Return the samples a period apart, from so long after the begin on [ns]."""
    since = [(sample.t_ns - START_NS - begin_ns, sample) for sample in samples]
    return [sample for t_ns, sample in since if t_ns >= 0 and t_ns % period_ns == 0]


def always_in_contact(configuration: Configuration) -> Configuration:
    """Return a configuration by which the peg is taken as on three contacts all the time."""
    return replace(configuration, monitor=replace(configuration.monitor, modes=False))


def run(configuration: Configuration, samples: Sequence, clock: Callable[[], float],
        make: Make = make_filter, live: bool = True) -> Track:  # fmt: skip
    """
    Run the pipeline over samples with an estimator.

    Parameters
    ----------
    configuration : Configuration
    samples : sequence
        Joint and wrench samples.
    clock : callable
        Returns a time [s].
    make : callable
        As `make_filter`; what a `Smoothed` tells counts when all is over.
    live : bool
        Each sample is given by itself, as a node is; else thousands at once, as in a replay,
        which gives the same numbers in a fifth of the time.

    """
    pipeline = Pipeline(configuration, make=make)
    begun = clock()
    if live:
        outputs = list(pipeline.play(samples))
        stamps, rows = [one.t_ns for one in outputs], np.array([one.row for one in outputs], ROW)
    else:
        stamps, rows = _at_once(pipeline, samples)
    smoothed = None
    if isinstance(pipeline.filter, Smoothed):
        smoothed = pipeline.filter.smooth_with_reactions()
    seconds = clock() - begun
    variance = np.diagonal(rows["state_covariance"], axis1=1, axis2=2)
    values = np.hstack([rows["state"], rows["normal"]])
    stddev = np.hstack([np.sqrt(variance), rows["normal_stddev"]])
    t_ns = np.array(stamps, np.int64)
    determined = rows["reactions_determined"] == 1.0
    if smoothed is not None:
        _, at, _ = np.intersect1d(smoothed[0], t_ns, return_indices=True)
        values, stddev = smoothed[1][at], smoothed[2][at]
    flags = t_ns[rows["transition"] != 0]
    return Track(
        t_ns - START_NS, values, stddev, determined, seconds,
        int(flags[0]) - START_NS if len(flags) else None,
    )  # fmt: skip


def _at_once(pipeline: Pipeline, samples: Sequence) -> tuple[np.ndarray, np.ndarray]:
    """Return stamps and rows of what samples give that are sound, pushed together."""
    of_wrench = np.array([isinstance(sample, WrenchSample) for sample in samples])
    wrenches = [one for one in samples if isinstance(one, WrenchSample)]
    joints = [one for one in samples if not isinstance(one, WrenchSample)]
    delay_ns = round(pipeline.configuration.joints.delay * 1e9)
    arrivals = Arrivals(
        of_wrench,
        np.array([one.t_ns for one in samples], np.int64) - np.where(of_wrench, 0, delay_ns),
        np.ones(len(samples), bool),
        np.array([[*one.force, *one.torque] for one in wrenches]),
        np.array([pipeline.orientation(one).row for one in joints]),  # type: ignore[union-attr]
        np.array([one.position for one in joints], float),
    )
    parts, end = [], 0
    while end < len(samples):
        end, rows = pipeline.push(arrivals, end)
        parts.append(rows)
    return (
        np.concatenate([rows.t_ns for rows in parts]),
        np.concatenate([rows.values for rows in parts]),
    )


class Compared(NamedTuple):
    """
    A track beside the truth, where it counts.

    Attributes
    ----------
    error, stddev : ndarray, shape (n, 9), in the hole (n, 8)
        Of angles, rates, reactions.
    determined : ndarray of bool, shape (n,)
    share : float
        Of the samples that could count, those whose reactions are determined.
    load : float
        Mean true reaction [N].
    lost : bool
        The orientation ends LOST_STDDEVS deviations off.

    """

    error: np.ndarray
    stddev: np.ndarray
    determined: np.ndarray
    share: float
    load: float
    lost: bool


def compared(truth: Truth, track: Track) -> Compared | None:
    """
    Return a track beside a truth whose samples hold all its stamps; None: it says nothing.

    Of a peg in the hole what counts is its slide on two points, K and the wall, where that is
    told: where it is not, there are no reactions to be off.
    """
    rows = np.searchsorted(truth.t_ns, track.t_ns)
    true = np.hstack([truth.q, truth.rates, truth.normal])[rows]
    values, stddev, told = track.values, track.stddev, track.t_ns >= SETTLE_NS
    counted = told
    in_hole = not (truth.mode == "three_point").all()
    if in_hole:
        slides = (truth.mode == "two_point") & (np.abs(truth.place_rate[:, 2]) > SLIDES)
        told = told & slides[rows]
        counted = told & track.determined & np.isfinite(stddev[:, 6:]).all(axis=1)
        true, values, stddev = (_on_walls(each) for each in (true, values, stddev))
    if not told.any():
        return None
    error = values - true
    error[:, 1:3] -= 2 * np.pi * np.round(error[:, 1:3] / (2 * np.pi))
    share = counted.sum() / told.sum() if in_hole else track.determined[told].mean()
    return Compared(
        error[counted], stddev[counted], track.determined[counted], float(share),
        float(true[told, 6:].mean()), bool(_off(truth, rows[-1], error[-1]) > LOST_STDDEVS),
    )  # fmt: skip


def errors(truth: Truth, track: Track) -> Errors:
    """Return how far off a track is from a truth; see `compared`."""
    found = compared(truth, track)
    if found is None:
        return Errors(np.inf, np.inf, 0.0, 0.0, 0.0, True)
    nothing = float("nan")
    error = found.error
    if not len(error):
        return Errors(nothing, nothing, nothing, nothing, 0.0, False)
    # A NaN of what is told is no answer; one of what is not is left out.
    reacts = np.isfinite(error[:, 6:]).any()
    finite = bool(np.isfinite(error if reacts else error[:, :6]).all())
    inside = np.abs(error) <= INSIDE_STDDEVS * found.stddev
    known = inside[found.determined, 6:]
    return Errors(
        _rms(error[:, 6:]) / found.load if reacts else nothing,
        _rms(error[:, 3]),
        float(inside[:, :6].mean(axis=0).min()),
        float(known.mean(axis=0).min()) if reacts and len(known) else nothing,
        found.share if reacts else nothing,
        not finite or found.lost,
    )


def _on_walls(values):
    """Return values with one load of the edge in place of B1 and B2, which are halves of it."""
    return np.column_stack([values[:, :7], values[:, 7:].sum(axis=1)])


def _off(truth, row, error):
    """Return the rotation that an orientation is off by, in deviations of a measured one."""
    g, a, b = error[:3]
    square = g**2 + a**2 + b**2 + 2 * np.cos(truth.q[row, 0]) * a * b
    return np.sqrt(max(square, 0.0)) / truth.plan.configuration.joints.position_stddev


def _rms(values):
    """Return the root mean square; infinite where one is not a number."""
    total = float(np.sqrt(np.mean(values**2)))
    return total if np.isfinite(total) else float("inf")
