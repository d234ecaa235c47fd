"""Errors against stated deviations: which samples count, and what they come to."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from benchmarks.harness.exact import exactly
from benchmarks.harness.player import Record, play
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.records import ANGLES, CONTACTS, JointSample
from peg_on_hole_ros.sim.measure import START_NS, measure, sensor_wrench

STATES, REACTIONS = slice(0, 6), slice(6, 9)
QUANTITIES = (*ANGLES, *(f"{name}_rate" for name in ANGLES), *(f"N_{name}" for name in CONTACTS))
# The estimate begins with one orientation, no rates, and 20 ms until a contact mode is declared.
SETTLE_NS = 50_000_000
# An orientation further off at the end than so many standard deviations of a measured one.
DIVERGED = 10.0
LEAST_FRICTION = 0.005
# 95 % of a normal distribution lie within so many standard deviations.
INTERVAL = 1.959964
# A contact that is slower [m/s] turns round, and so does what lies near it.
SLOW_SLIP, AROUND_NS = 2e-3, 25_000_000


class Runs(NamedTuple):
    """
    What the estimate did, on each sample of each seed.

    Attributes
    ----------
    error, stddev : ndarray, shape (seeds, n, 9)
        Of QUANTITIES; NaN where there was no output.
    nees : ndarray, shape (seeds, n)
        6 degrees of freedom.
    determined : ndarray of bool, shape (seeds, n)
        Reactions declared determined.
    mode : ndarray of str, shape (seeds, n)
        Declared; empty where there was no output.
    nis : ndarray, shape (seeds,)
        Mean of all corrections after SETTLE_NS, 3 degrees of freedom.
    diverged : ndarray of bool, shape (seeds,)
    restarts : int
        Of the filter by itself.

    """

    error: np.ndarray
    stddev: np.ndarray
    nees: np.ndarray
    determined: np.ndarray
    mode: np.ndarray
    nis: np.ndarray
    diverged: np.ndarray
    restarts: int

    @property
    def contact(self) -> np.ndarray:
        """Return where three-point contact is declared, shape (seeds, n)."""
        return self.mode == "three_point"


class Coverage(NamedTuple):
    """
    What errors come to beside what is stated of them.

    Attributes
    ----------
    rms, stated : ndarray, shape (k,)
        Root mean square of the errors, and of the stated deviations.
    covered : ndarray, shape (k,)
        Share of the samples within their 95 % bounds.

    """

    rms: np.ndarray
    stated: np.ndarray
    covered: np.ndarray


def coverage(error: np.ndarray, stddev: np.ndarray) -> Coverage:
    """Return what errors come to, shape (n, k) both; NaN without a sample."""
    if not len(error):
        return Coverage(*np.full((3, error.shape[1]), np.nan))
    return Coverage(rms(error), rms(stddev), inside(error, stddev).mean(axis=0))


def rms(values: np.ndarray) -> np.ndarray:
    """Return the root mean square over the first axis."""
    return np.sqrt((values**2).mean(axis=0))


def inside(error: np.ndarray, stddev: np.ndarray) -> np.ndarray:
    """Return where an error is within its 95 % bounds."""
    return np.abs(error) <= INTERVAL * stddev


def errors_of(truth, record: Record) -> np.ndarray:
    """Return the errors of QUANTITIES in a record with a row for each of the truth's, (n, 9)."""
    true = np.hstack([truth.q, truth.rates, truth.normal])
    error = np.hstack([record.state, record.normal]) - true
    error[:, 1:3] -= 2 * np.pi * np.round(error[:, 1:3] / (2 * np.pi))
    return error


def stddev_of(record: Record) -> np.ndarray:
    """Return the stated standard deviations of QUANTITIES, shape (n, 9)."""
    spread = np.sqrt(np.diagonal(record.covariance, axis1=1, axis2=2))
    return np.hstack([spread, record.normal_stddev])


def changed_parameters(configuration) -> dict:
    """Return the parameters that differ from the defaults, which any checkout knows."""
    usual = to_parameters(Configuration())
    return {k: v for k, v in to_parameters(configuration).items() if v != usual[k]}


def drawn(configuration, seed):
    """Return a configuration whose friction is off by as much as its stated spread leads to."""
    scene = configuration.scene
    off = np.random.default_rng([seed, 2]).normal() * scene.friction_stddev
    friction = max(scene.friction + off, LEAST_FRICTION)
    return replace(configuration, scene=replace(scene, friction=friction))


def run_seeds(truth, seeds, exact=None, start_error=None, player=play) -> Runs:
    """
    Run the pipeline over measurements of a truth, friction drawn from what is stated of it.

    Parameters
    ----------
    truth : Truth
    seeds : sequence of int
    exact : ndarray, optional
        From `sensor_wrench`, where it is known already.
    start_error : sequence of 2 float, optional
        See `_first_wrong`.
    player : callable
        `play`, here or elsewhere.

    """
    exact = sensor_wrench(truth) if exact is None else exact

    def played(seed):
        told = exactly(truth.plan.configuration)
        parameters = changed_parameters(drawn(told, seed))
        samples = _first_wrong(measure(truth, seed, exact=exact), seed, start_error)
        return player(parameters, list(map(tuple, samples)), START_NS + SETTLE_NS)

    return runs_of(truth, map(played, seeds))


def runs_of(truth, records: Iterable[Record]) -> Runs:
    """Return what was said of a truth in several records, each measured from START_NS on."""
    rows = [record.rows_at(truth.t_ns, START_NS) for record in records]
    error = np.array([errors_of(truth, record) for record in rows])
    return Runs(
        error,
        np.array([stddev_of(record) for record in rows]),
        np.array([_nees(off, record.covariance) for off, record in zip(error, rows)]),
        np.array([record.determined for record in rows]),
        np.array([record.mode for record in rows]),
        np.array([record.nis for record in rows]),
        diverged(truth, error),
        sum(record.restarts for record in rows),
    )


def _nees(error, covariance):
    told = np.isfinite(error[:, :6]).all(axis=1) & np.isfinite(covariance).all(axis=(1, 2))
    nees, off = np.full(len(error), np.nan), error[told, :6]
    weighed = np.linalg.solve(covariance[told], off[..., None])[..., 0]
    nees[told] = (off * weighed).sum(axis=1)
    return nees


def _first_wrong(samples, seed, start_error) -> Iterator:
    """Pass samples on; of the first orientation gamma and psi are off by up to `start_error`."""
    first = start_error is not None
    for sample in samples:
        if first and isinstance(sample, JointSample):
            first = False
            off = np.random.default_rng([seed, 1]).uniform(-1.0, 1.0, 2) * start_error
            gamma, psi, phi = sample.position
            sample = sample._replace(position=(abs(gamma + off[0]), psi + off[1], phi))
        yield sample


def diverged(truth, error):
    """Return for each run whether an output is missing or not finite, or the end is far off."""
    settled = truth.t_ns >= min(SETTLE_NS, truth.t_ns[-1])
    bad = ~np.isfinite(error[:, settled]).all(axis=(1, 2))
    last = error[:, -20:, :3]
    c = np.cos(truth.q[-20:, 0])
    # Size of the rotation between true and estimated orientation.
    g, a, b = last[..., 0], last[..., 1], last[..., 2]
    size = np.sqrt(np.maximum(g**2 + a**2 + b**2 + 2 * c * a * b, 0.0))
    limit = DIVERGED * truth.plan.configuration.joints.position_stddev
    return bad | (np.median(size, axis=1) > limit)


def near_reversal(truth) -> np.ndarray:
    """Return for each sample whether a contact is slower than SLOW_SLIP within AROUND_NS."""
    slow = (truth.slip_speed < SLOW_SLIP).any(axis=1) & (truth.mode == "three_point")
    marks = truth.t_ns[slow]
    if not marks.size:
        return np.zeros(len(truth.t_ns), bool)
    after = np.searchsorted(marks, truth.t_ns - AROUND_NS)
    return (after < marks.size) & (
        marks[np.minimum(after, marks.size - 1)] <= truth.t_ns + AROUND_NS
    )


def error_over_seeds(statistic: Callable, values: np.ndarray):
    """
    Return the standard error of a statistic of the mean over seeds (the jackknife, Tukey 1958).

    Parameters
    ----------
    statistic : callable
        Of an array without the first axis.
    values : ndarray, shape (seeds, ...)

    """
    seeds = len(values)
    if seeds < 2 or not np.isfinite(values).any():
        return None
    known = np.isfinite(values)
    total, count = np.where(known, values, 0.0).sum(axis=0), known.sum(axis=0)
    left = []
    for k in range(seeds):
        without = total - np.where(known[k], values[k], 0.0)
        left.append(statistic(without / np.maximum(count - known[k], 1)))
    left = np.array(left)
    variance = (seeds - 1) / seeds * ((left - left.mean(axis=0)) ** 2).sum(axis=0)
    return np.sqrt(variance).tolist()
