"""Whether a peg in the hole is stuck: pushed, by Whitney's diagram, and at rest along the hole."""

from math import cos, exp, fabs, log, pi, sin, sqrt

import numpy as np

from peg_on_hole_ros.estimator.record import Estimate
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled, pose_of
from peg_on_hole_ros.mechanics.whitney import jamming_margin
from peg_on_hole_ros.monitor import trend
from peg_on_hole_ros.monitor.contacts import MOST, below
from peg_on_hole_ros.monitor.down_the_hole import along_share, rests

# docs/jamming.md, "In the hole", derives it.

# The load beyond the diagram counts by its mean over this time [s].
_BEYOND_OVER = 0.01
_ROOT_TWO_PI = sqrt(2.0 * pi)
# Where the motion along the hole stands in that of the peg.
DOWN = trend.SIZE

# Memory: by how many deviations the load is surely beyond the diagram.
BEYOND, SIZE = 0, 1


@compiled
def forget_stuck(m: np.ndarray, at: int) -> None:
    """Begin anew with the next wrench."""
    m[at + BEYOND] = 0.0


@compiled
def stuck_in_hole(
    p: SceneScalars,
    estimate: Estimate,
    motion: np.ndarray,
    m: np.ndarray,
    at: int,
    threshold: float,
    dt: float,
) -> tuple[float, float, float, float]:
    """
    Take a wrench, of a peg that touches below gamma0.

    Parameters
    ----------
    p : SceneScalars
    estimate : Estimate
    motion : ndarray
        Memory of `trend`, then that of `down_the_hole`.
    m : ndarray
        Memory, of which SIZE places from `at` on.
    at : int
    threshold : float
        Push that is one [N].
    dt : float
        Since the last wrench [s].

    Returns
    -------
    stuck, wedged : float
        Probabilities that it is stuck, and that it is wedged.
    insertion, margin : float
        l/d, and Whitney's margin [N].

    """
    around = 0.5 * p.d * (estimate.motion.psi_rate + estimate.motion.phi_rate)
    f_z = p.f * along_share(motion, DOWN, p, around)
    insertion, margin, beyond, surely, width, locks, held, pressed = _by_diagram(
        p, estimate, f_z, threshold
    )
    kept = below(beyond)
    rest = rests(motion, DOWN)
    m[at + BEYOND] += min(dt / _BEYOND_OVER, 1.0) * (surely - m[at + BEYOND])
    # A peg that slides is at the diagram's edge; one that rests is anywhere beyond it, up to
    # twice the push, or inside where it can wedge.
    for_rest = 0.5 * max(m[at + BEYOND], 0.0) ** 2 - (1.0 - locks) * log(width)
    # Inside says nothing, for friction may be stated too low.
    for_rest = exp(min(max(for_rest, 0.0), MOST))
    rest *= for_rest / (1.0 + rest * (for_rest - 1.0))
    stuck = held * pressed * rest
    return stuck, stuck * locks * (1.0 - kept), insertion, margin


@compiled
def _by_diagram(p, estimate, f_z, threshold):
    """
    Return l/d, Whitney's margin, by how many deviations it is used up, and more of the load.

    That is by how many it is used up with a friction that is one deviation less, how many of them
    twice the push is wide, and the probabilities that the peg can wedge, that rim and wall are
    pressed on, and that it is pushed into the hole. Of the friction, f_z is along the hole. The
    plane is that of the tilt, the tilt small. An estimate a little below zero leans to the other
    side.
    """
    motion, R = estimate.motion, estimate.wrench_noise
    angles = (motion.gamma, motion.psi, motion.phi)
    s, c = sin(motion.gamma), cos(motion.gamma)
    side = 1.0 if s >= 0.0 else -1.0
    _, wrench = pose_of(p, angles, estimate.wrench, estimate.work)
    length = ((p.D - p.d) + 2.0 * p.d * sin(0.5 * motion.gamma) ** 2) / max(side * s, 1e-6)
    F_x, F_z = side * wrench[0], -wrench[2]
    M = -side * (wrench[4] + p.H_c * (c * wrench[0] + s * wrench[2]))
    f_z = max(f_z, 1e-3)
    margin = jamming_margin(0.5 * p.d, length, f_z, F_x, F_z, M)
    more = f_z + sqrt(max(estimate.friction_variance, 1e-6))
    by_friction = jamming_margin(0.5 * p.d, length, more, F_x, F_z, M) - margin
    noise = sqrt(R[0, 0] + R[4, 4] / (p.d * p.d / 4.0))
    lever = 1.0 + 2.0 * p.f * p.d / length
    uncertain = noise * lever + 0.05 * fabs(F_z)
    uncertain = sqrt(uncertain * uncertain + by_friction * by_friction)
    beyond, surely = -margin / uncertain, (by_friction - margin) / uncertain
    # Moments about the edge leave K alone, if the peg slides in; B carries it and the side load.
    arm = length + p.f * p.d
    about_edge = M + 0.5 * p.d * (c * F_z + side * s * F_x)
    about_edge_noise = R[4, 4] + p.H_c * p.H_c * R[0, 0]
    N_K, variance = about_edge / arm, about_edge_noise / (arm * arm)
    # K is as steep as the peg leans: without friction it lifts the peg by so much, as where the
    # holder alone keeps the tilt. What is left of the push is for friction.
    steep = max(side * s, 0.0) / length
    left, left_noise = F_z - steep * max(about_edge, 0.0), steep * steep * about_edge_noise
    pressed = below((left - threshold) / sqrt(noise * noise + left_noise))
    variance += max(estimate.friction_variance, 0.0) * (N_K * p.d / arm) ** 2
    loaded = below(N_K / sqrt(variance)) * below((F_x + N_K) / sqrt(variance + R[0, 0]))
    # Where either friction cone holds the other contact, any load may be locked in.
    locks = below((p.f - length / p.d) / sqrt(max(estimate.friction_variance, 1e-6)))
    held = max(loaded, locks)
    width = max(2.0 * F_z / (uncertain * _ROOT_TWO_PI), 1.0)
    # K lies on the peg's side.
    deepest = 2.0 * p.H_c * side * motion.gamma - (p.D - p.d)
    held *= below(deepest / (2.0 * p.H_c * sqrt(max(motion.covariance[0, 0], 1e-18))))
    return length / p.d, margin, beyond, surely, width, locks, held, pressed
