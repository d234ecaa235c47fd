"""
How near a particle filter comes to the bound: whether an estimator can reach it.

    python benchmarks/bound_reached.py [--motion slip] [--clearance 2e-5] [--friction 0.2]
        [--speed 0.01] [--noise low] [--friction-stddev 0] [--runs 12] [--particles 16000]
        [--seconds 0.15]

The bound is one of tangents. A bootstrap particle filter (Gordon, Salmond and Smith 1993) makes
none: each particle is moved by the contact's own step under the measured wrench less a draw of
its noise, and weighed by the orientation. It knows the clearance, and friction or what is stated
of it, as the filter in the grid: the start is off by that, and it walks. Rates it knows to 0.02
rad/s at the start, where the bound has 1 rad/s, which is of the first milliseconds. It costs
thousands of times as much, and is no filter to use. Some minutes.
"""

import argparse
from typing import NamedTuple

import numpy as np

from grid_cells import (
    CLEARANCES,
    FRICTIONS,
    MOTIONS,
    NOISE,
    SPEEDS,
    Motion,
    truth_of,
    with_noise,
)
from grid_score import LEAST_FRICTION, QUANTITIES, bound_of, peg_wrench
from peg_on_hole_ros.estimation.bound import Meaning
from peg_on_hole_ros.estimation.measurement import WrenchReduction, angle_covariance
from peg_on_hole_ros.estimation.steps.implicit_euler import CONVERGED, implicit_euler
from peg_on_hole_ros.mechanics.kernel import (
    WIDTH,
    accelerate,
    compiled,
    scene_of,
    scene_scalars,
    with_friction,
    workspace,
)

# Of the rates at the begin [rad/s]: particles that know nothing of them are mostly lost.
BEGIN_RATE = 0.02


class Track(NamedTuple):
    """
    What the particles say at each sample of the state, the reactions and friction.

    Attributes
    ----------
    error, stddev : ndarray, shape (n, 10)
        Of their mean, and of themselves.

    """

    error: np.ndarray
    stddev: np.ndarray


@compiled
def _advance(scalars, scales, x, f, u, h, pieces, found, answer, work):
    """
    Move each particle x (n, 6) of friction f (n,) by its wrench u (n, 6) over h [s].

    Filled are `found`, whether it had a step, and `answer`, its accelerations and reactions then.
    """
    scene = scene_of(scalars)
    begin, end, y = np.zeros(6), np.zeros(6), np.zeros(6)
    dy, slopes = np.zeros((6, WIDTH)), np.zeros((6, WIDTH))
    for n in range(len(x)):
        p = with_friction(scene, f[n])
        begin[:] = x[n]
        found[n] = 1.0
        for _ in range(pieces):
            status, _ = implicit_euler(
                p, scales, begin, u[n], h / pieces, end, y, dy, slopes, work
            )
            if status != CONVERGED:
                found[n] = 0.0
                break
            begin[:] = end
        x[n] = begin
        accelerate(p, scales, x[n], u[n], work, answer[n])


def particles(truth, seed: int, count: int, rows: int, pieces: int = 4) -> Track:
    """
    Run a particle filter over the first samples of a truth.

    Parameters
    ----------
    truth : Truth
    seed : int
        Of all noise.
    count : int
        Particles.
    rows : int
        Samples of the wrench.
    pieces : int
        Steps from one sample to the next.

    Returns
    -------
    Track

    """
    settings, random = truth.plan.configuration, np.random.default_rng(seed)
    scene, position = settings.scene, settings.joints.position_stddev
    scalars = np.array(scene_scalars(scene))
    scales = np.full(3, float(truth.plan.slip_velocity_scale))
    root = np.linalg.cholesky(WrenchReduction(settings.wrench, scene).covariance)
    every = truth.plan.wrench_rate // truth.plan.joint_rate
    exact, wrench = np.hstack([truth.q, truth.rates]), peg_wrench(truth)
    truths = np.hstack([exact, truth.normal, np.full((len(exact), 1), scene.friction)])
    error, stddev = np.full((rows, 10), np.nan), np.full((rows, 10), np.nan)
    R = angle_covariance(truth.q[0, 0], position)
    x = np.empty((count, 6))
    x[:, :3] = random.multivariate_normal(random.multivariate_normal(truth.q[0], R), R, count)
    centre = truth.rates[0] + BEGIN_RATE * random.normal(size=3)
    x[:, 3:] = centre + BEGIN_RATE * random.normal(size=(count, 3))
    spread, wander = scene.friction_stddev, settings.filter.friction_noise
    f = scene.friction + spread * (random.normal() + random.normal(size=count))
    wander *= spread > 0.0
    logarithm, found, work = np.zeros(count), np.zeros(count), workspace()
    answer, held = np.zeros((count, 6)), settings.filter.acceleration_stddev
    for k in range(1, rows):
        measured = wrench[k] + root @ random.normal(size=6)
        u = measured + random.normal(size=(count, 6)) @ root.T
        h = (truth.t_ns[k] - truth.t_ns[k - 1]) * 1e-9
        f = np.maximum(f + wander * np.sqrt(h) * random.normal(size=count), LEAST_FRICTION)
        _advance(scalars, scales, x, f, u, h, pieces, found, answer, work)
        logarithm = np.where(found > 0.0, logarithm, -np.inf)
        seen = k % every == 0
        if seen:
            R = angle_covariance(truth.q[k, 0], position)
            off = x[:, :3] - random.multivariate_normal(truth.q[k], R)
            logarithm = logarithm - 0.5 * np.einsum("ni,ij,nj->n", off, np.linalg.inv(R), off)
        weight = _normal(logarithm)
        # As the bound has it, and the filter: beside how fast a held peg can accelerate.
        beside = _normal(logarithm - 0.5 * (answer[:, :3] ** 2).sum(axis=1) / held**2)
        for part, values, by in (
            (slice(0, 6), x, weight),
            (slice(6, 9), answer[:, 3:], beside),
            (slice(9, 10), f[:, None], weight),
        ):
            mean = by @ values
            error[k, part] = mean - truths[k, part]
            stddev[k, part] = np.sqrt(by @ (values - mean) ** 2)
        if seen:
            # Systematic resampling.
            places = (np.arange(count) + random.random()) / count
            kept = np.searchsorted(np.cumsum(weight), places).clip(0, count - 1)
            x, f = x[kept], f[kept]
            logarithm[:] = 0.0
    return Track(error, stddev)


def _normal(logarithm):
    weight = np.exp(logarithm - logarithm.max())
    return weight / weight.sum()


def main():
    """Print errors and spreads over the bound, by quarters of the time."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--motion", choices=MOTIONS, default="slip")
    parser.add_argument("--clearance", type=float, default=2e-5, help=f"[m], as {CLEARANCES}")
    parser.add_argument("--friction", type=float, default=0.2, help=f"as {FRICTIONS}")
    parser.add_argument("--speed", type=float, default=0.01, help=f"[rad/s], as {SPEEDS}")
    parser.add_argument("--noise", choices=list(NOISE), default="low")
    parser.add_argument("--friction-stddev", type=float, default=0.0, help="0: known")
    parser.add_argument("--runs", type=int, default=12)
    parser.add_argument("--particles", type=int, default=16000)
    parser.add_argument("--seconds", type=float, default=0.15)
    asked = parser.parse_args()
    motion = Motion(asked.clearance, asked.friction, asked.speed, asked.motion)
    truth = with_noise(truth_of(motion)[0], asked.noise, asked.friction_stddev)
    rows = min(len(truth.t_ns), int(np.searchsorted(truth.t_ns, asked.seconds * 1e9)))
    bound = bound_of(truth)
    parts = bound.state, bound.reactions, bound.parameters[:, :1, :1]
    squares = [np.diagonal(part[:rows], axis1=1, axis2=2) for part in parts]
    # A friction that is known has no bound; it is told as it is.
    sigma = np.sqrt(np.hstack(squares))
    sigma[sigma == 0.0] = 1.0
    tracks = []
    for seed in range(asked.runs):
        tracks.append(particles(truth, seed, asked.particles, rows))
        print(f"run {seed + 1} of {asked.runs}", flush=True)
    error = np.array([track.error for track in tracks]) / sigma
    stddev = np.array([track.stddev for track in tracks]) / sigma
    print(f"{motion} {asked.noise}, over the bound: {', '.join(QUANTITIES)}, friction")
    sound = bound.meaning[:rows] == Meaning.SOUND
    for part in np.array_split(np.arange(1, rows), 4):
        told = part[sound[part]]
        if not told.size:
            print(f"{truth.t_ns[part[0]] * 1e-9:.3f} s: the bound means nothing")
            continue
        print(
            f"{truth.t_ns[part[0]] * 1e-9:.3f} s: error",
            np.sqrt((error[:, told] ** 2).mean(axis=(0, 1))).round(2),
            "spread", np.sqrt((stddev[:, told] ** 2).mean(axis=(0, 1))).round(2),
            f"in the {told.size / part.size:.0%} of the samples whose bound is sound",
        )  # fmt: skip


if __name__ == "__main__":
    main()
