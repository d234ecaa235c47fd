"""Score one cell of the grid: runs of the pipeline over noise seeds against the bound."""

from functools import partial

import numpy as np

from benchmarks.grid.cells import with_noise
from benchmarks.harness.errors import (
    REACTIONS,
    SETTLE_NS,
    Runs,
    error_over_seeds,
    inside,
    near_reversal,
    run_seeds,
)
from benchmarks.harness.player import play
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.study.bound import Meaning, Sensors, TrueMotion, posterior_bound
from peg_on_hole_ros.study.scenes import holder_of

NEAR_GAMMA0 = 1.15
NEAR_SINGULAR = 0.1
START_ERROR = (0.1, 1.0)  # gamma, psi [rad]


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
        scene, TrueMotion(t, state, wrench), sensors,
        settings.filter.initial_rate_stddev, plan.slip_velocity_scale,
        holder_of(t, np.asarray(state)[:, 3:]),
        settings.filter.friction_noise if scene.friction_stddev else 0.0,
    )  # fmt: skip


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
    within = inside(error, stddev)
    missed = ~within[..., REACTIONS].all(axis=2)
    flagged = ~runs.determined[:, chosen]
    rms = np.sqrt(np.nanmean(error**2, axis=(0, 1)))
    known, good = within[..., REACTIONS][~flagged], chosen & sound
    ratio2 = (runs.error[:, good] / sigma[good]) ** 2
    return {
        "samples": int(chosen.sum()),
        "sound": float(sound[chosen].mean()),
        "determined": float((~flagged).mean()),
        "contact": float(runs.contact[:, chosen].mean()),
        "missed": int(missed.sum()),
        "missed_flagged": int((missed & flagged).sum()),
        "nees_median": float(np.median(np.nanmean(runs.nees[:, chosen], axis=0))),
        "coverage": within.mean(axis=(0, 1)).tolist(),
        "coverage_error": error_over_seeds(partial(np.mean, axis=0), within.astype(float)),
        "coverage_determined": known.mean(axis=0).tolist() if len(known) else None,
        "rms": rms.tolist(),
        "bound": np.median(sigma[chosen], axis=0).tolist(),
        "sharp": (np.nanmedian(stddev, axis=(0, 1)) / rms).tolist(),
        "ratio": np.sqrt(np.nanmean(ratio2, axis=(0, 1))).tolist() if good.any() else None,
    }
