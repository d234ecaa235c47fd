"""Score one cell of the grid: runs of the pipeline over noise seeds against the bound."""

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from benchmarks.grid.cells import with_noise
from benchmarks.grid.consistency import near_reversal
from benchmarks.grid.player import play
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.measurements.measurement import WrenchReduction
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.records import ANGLES, CONTACTS, JointSample
from peg_on_hole_ros.sim.measure import START_NS, measure, sensor_wrench
from peg_on_hole_ros.study.bound import Meaning, Sensors, posterior_bound
from peg_on_hole_ros.study.scenes import holder_of

STATES, REACTIONS = slice(0, 6), slice(6, 9)
QUANTITIES = (*ANGLES, *(f"{name}_rate" for name in ANGLES), *(f"N_{name}" for name in CONTACTS))
# The estimate begins with one orientation, no rates, and 20 ms until a contact mode is declared.
SETTLE_NS = 50_000_000
NEAR_GAMMA0 = 1.15
NEAR_SINGULAR = 0.1
# An orientation further off at the end than so many standard deviations of a measured one.
DIVERGED = 10.0
LEAST_FRICTION = 0.005
START_ERROR = (0.1, 1.0)  # gamma, psi [rad]
INTERVAL = 1.959964


class Runs(NamedTuple):
    """
    What the estimate did, on each sample of each seed.

    Attributes
    ----------
    error, stddev : ndarray, shape (seeds, n, 9)
        Of QUANTITIES; NaN where there was no output.
    nees : ndarray, shape (seeds, n)
        6 degrees of freedom.
    determined, contact : ndarray of bool, shape (seeds, n)
        Reactions declared determined; three-point contact declared.
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
    contact: np.ndarray
    nis: np.ndarray
    diverged: np.ndarray
    restarts: int


def peg_wrench(truth):
    """Return the true wrench about the mass centre, peg axes, shape (n, 6) [N], [N m]."""
    R_HP = np.array([peg_axes(q) for q in truth.q])
    return np.hstack(
        [np.einsum("nji,nj->ni", R_HP, truth.force), np.einsum("nji,nj->ni", R_HP, truth.moment)]
    )


def bound_of(truth):
    """Return the bound along a truth."""
    state = np.hstack([truth.q, truth.rates])
    return bound_along(truth.plan, truth.t_ns, state, peg_wrench(truth))


def bound_along(plan, t_ns, state, wrench):
    """Return the bound along a motion with the scene and sensors of a plan."""
    settings = plan.configuration
    scene, t = settings.scene, t_ns * 1e-9
    every = plan.wrench_rate // plan.joint_rate
    sensors = Sensors(
        WrenchReduction(settings.wrench, scene).covariance,
        settings.joints.position_stddev,
        np.arange(len(t)) % every == 0,
    )
    return posterior_bound(
        scene, t, state, wrench, sensors,
        settings.filter.initial_rate_stddev, plan.slip_velocity_scale,
        holder_of(t, np.asarray(state)[:, 3:]),
        settings.filter.friction_noise if scene.friction_stddev else 0.0,
    )  # fmt: skip


def run_seeds(truth, seeds, exact=None, start_error=None, player=play) -> Runs:
    """
    Run the pipeline over measurements of a truth.

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
    n, m = len(truth.t_ns), len(seeds)
    error, stddev = np.full((m, n, 9), np.nan), np.full((m, n, 9), np.nan)
    nees, exact_values = np.full((m, n), np.nan), np.hstack([truth.q, truth.rates, truth.normal])
    determined, contact = np.zeros((m, n), bool), np.zeros((m, n), bool)
    means, restarts = [], 0
    for s, seed in enumerate(seeds):
        parameters = changed_parameters(drawn(truth.plan.configuration, seed))
        samples = _first_wrong(measure(truth, seed, exact=exact), seed, start_error)
        found = player(parameters, list(map(tuple, samples)), START_NS + SETTLE_NS)
        k = np.searchsorted(truth.t_ns, found["t_ns"] - START_NS)
        error[s, k] = np.hstack([found["state"], found["normal"]]) - exact_values[k]
        error[s, :, 1:3] -= 2 * np.pi * np.round(error[s, :, 1:3] / (2 * np.pi))
        covariance = found["covariance"]
        spread = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
        stddev[s, k] = np.hstack([spread, found["stddev"]])
        determined[s, k], contact[s, k] = found["determined"], found["contact"]
        told = np.isfinite(error[s, k, :6]).all(axis=1) & np.isfinite(covariance).all(axis=(1, 2))
        off = error[s, k[told], :6]
        weighed = np.linalg.solve(covariance[told], off[..., None])[..., 0]
        nees[s, k[told]] = (off * weighed).sum(axis=1)
        means.append(found["nis"])
        restarts += found["restarts"]
    ends = diverged(truth, error)
    return Runs(error, stddev, nees, determined, contact, np.array(means), ends, restarts)


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


def _first_wrong(samples, seed, start_error):
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


def classes(truth, bound) -> dict[str, np.ndarray]:
    """
    Return the samples of each class by what is true of them, not by what the estimate says.

    `window`: a contact under 2 mm/s, 25 ms around, or gamma < 1.15 gamma0; `outside`: the rest;
    `singular`: those of both where the determinant of the six equations is small.

    """
    scene = truth.plan.configuration.scene
    settled = truth.t_ns >= SETTLE_NS
    window = near_reversal(truth) | (truth.q[:, 0] < NEAR_GAMMA0 * scene.gamma0)
    singular = ~(bound.determinant > NEAR_SINGULAR)
    return {
        "outside": settled & ~window,
        "window": settled & window,
        "singular": settled & singular,
    }


def score_cell(truth, noise, seeds, start_seeds, exact=None, friction_stddev=None, player=play):
    """Return the figures of one motion at one noise level, as a plain tree of numbers."""
    measured = with_noise(truth, noise, friction_stddev)
    bound = bound_of(measured)
    runs = run_seeds(measured, seeds, exact, player=player)
    wrong = run_seeds(measured, start_seeds, exact, START_ERROR, player)
    parts = (np.diagonal(part, axis1=1, axis2=2) for part in (bound.state, bound.reactions))
    sigma, sound = np.sqrt(np.hstack(list(parts))), bound.meaning == Meaning.SOUND
    result = {
        "seeds": len(seeds),
        "nis": _mean(runs.nis),
        "diverged": int(runs.diverged.sum()),
        "restarts": runs.restarts,
        "start_seeds": len(start_seeds),
        "start_diverged": int(wrong.diverged.sum()),
        "start_restarts": wrong.restarts,
        "classes": {},
    }
    for name, chosen in classes(truth, bound).items():
        if chosen.any():
            result["classes"][name] = figures(runs, chosen, sound, sigma)
    return result


def _mean(values):
    return float(np.nanmean(values)) if np.isfinite(values).any() else None


def _error(statistic, values):
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


def figures(runs: Runs, chosen, sound, sigma) -> dict:
    """
    Return the figures of the samples of one class, of QUANTITIES where they are lists.

    Parameters
    ----------
    runs : Runs
    chosen : ndarray of bool, shape (n,)
    sound : ndarray of bool, shape (n,)
        Where the bound means something.
    sigma : ndarray, shape (n, 9)
        The bound, as a standard deviation.

    Returns
    -------
    dict
        `rms` of the errors; `bound`, the median of sigma; `ratio`, the root mean square of errors
        over sigma where it is sound, if it is anywhere; `sharp`, the median stated deviation over
        rms; `coverage` of 95 % bounds and its standard error; `coverage_determined`, of the
        reactions that are declared determined; `determined`, `contact`, `sound`: shares; `missed`
        samples of which a reaction is outside, and how many of those are flagged; `nees_median`.

    """
    error, stddev = runs.error[:, chosen], runs.stddev[:, chosen]
    inside = np.abs(error) <= INTERVAL * stddev
    missed = ~inside[..., REACTIONS].all(axis=2)
    flagged = ~runs.determined[:, chosen]
    rms = np.sqrt(np.nanmean(error**2, axis=(0, 1)))
    known, good = inside[..., REACTIONS][~flagged], chosen & sound
    ratio2 = (runs.error[:, good] / sigma[good]) ** 2
    return {
        "samples": int(chosen.sum()),
        "sound": float(sound[chosen].mean()),
        "determined": float((~flagged).mean()),
        "contact": float(runs.contact[:, chosen].mean()),
        "missed": int(missed.sum()),
        "missed_flagged": int((missed & flagged).sum()),
        "nees_median": float(np.median(np.nanmean(runs.nees[:, chosen], axis=0))),
        "coverage": inside.mean(axis=(0, 1)).tolist(),
        "coverage_error": _error(partial(np.mean, axis=0), inside.astype(float)),
        "coverage_determined": known.mean(axis=0).tolist() if len(known) else None,
        "rms": rms.tolist(),
        "bound": np.median(sigma[chosen], axis=0).tolist(),
        "sharp": (np.nanmedian(stddev, axis=(0, 1)) / rms).tolist(),
        "ratio": np.sqrt(np.nanmean(ratio2, axis=(0, 1))).tolist() if good.any() else None,
    }
