"""Stuck in the hole: the peg is pushed, by Whitney's diagram, and rests along the hole."""

from math import cos, exp, fabs, log, pi, sin, sqrt
from typing import NamedTuple

from peg_on_hole_ros.estimator.estimate import Estimate, scene_of
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled, pose_of
from peg_on_hole_ros.mechanics.whitney import jamming_margin
from peg_on_hole_ros.monitor.contact_probabilities import normal_cdf
from peg_on_hole_ros.monitor.dangers.situation import Situation, in_hole, is_inside
from peg_on_hole_ros.monitor.rest_in_hole import along_share, rests
from peg_on_hole_ros.monitor.tuned import EVIDENCE_WEIGHTS, STUCK_IN_HOLE
from peg_on_hole_ros.typed_record import Record

ADVICE = (
    "in the hole the load leaves the range in which the peg slides (Whitney's diagram): push "
    "along the hole, reduce side force and moment",
    "the peg is stuck in the hole: stop pushing, reduce side force and moment, pull back",
)

# docs/jamming.md, "In the hole", derives it.

_ROOT_TWO_PI = sqrt(2.0 * pi)


class Stuck(Record):
    """
    Whether a peg in the hole is stuck; all numbers of the last wrench are 0 elsewhere.

    Attributes
    ----------
    probability : float
        That it is wedged, or that it rests, whichever is likelier.
    wedged, rests : float
        Probabilities that it is wedged, and that it is stuck where it is not wedged.
    insertion, margin : float
        l/d, and Whitney's margin [N].
    beyond : float
        Running mean of `OnDiagram.beyond_low_friction`.

    """

    probability: float
    wedged: float
    rests: float
    insertion: float
    margin: float
    beyond: float


class OnDiagram(NamedTuple):
    """
    A load on Whitney's diagram.

    Attributes
    ----------
    insertion, margin : float
        l/d, and Whitney's margin [N].
    beyond, beyond_low_friction : float
        By how many standard deviations the margin is used up, and by how many of them with a
        friction that is one standard deviation lower.
    width : float
        How many of them twice the push is wide.
    locks, held, pressed : float
        Probabilities that the peg can wedge, that rim and wall are pressed on, and that it is
        pushed into the hole.

    """

    insertion: float
    margin: float
    beyond: float
    beyond_low_friction: float
    width: float
    locks: float
    held: float
    pressed: float


@compiled
def forget(found: Stuck) -> None:
    """Begin anew with the next wrench."""
    _clear(found)
    found.beyond = 0.0


@compiled
def _clear(found: Stuck) -> None:
    found.probability = found.wedged = found.rests = found.insertion = found.margin = 0.0


@compiled
def assess(found: Stuck, situation: Situation) -> None:
    """Process a wrench, see the package."""
    if not is_inside(situation.shown):
        _clear(found)
        return
    stuck, wedged = _stuck_in_hole(found, situation)
    touching = in_hole(situation.shown)
    found.wedged = touching * wedged
    # Of a peg that is not wedged, so that the risk is that it is stuck.
    found.rests = (touching * stuck - found.wedged) / max(1.0 - found.wedged, 1e-9)
    found.probability = max(found.wedged, found.rests)


@compiled
def _stuck_in_hole(found: Stuck, situation: Situation) -> tuple[float, float]:
    """Return the probabilities that a peg below gamma0 is stuck, and that it is wedged."""
    estimate, depth = situation.estimate, situation.depth
    p, motion, threshold = (
        scene_of(estimate),
        estimate.motion,
        situation.settings.contact_force_threshold,
    )
    around = 0.5 * p.d * (motion.psi_rate + motion.phi_rate)
    f_z = p.f * along_share(depth, p.d, p.D, around)
    load = _by_diagram(p, estimate, f_z, threshold)
    found.insertion, found.margin = load.insertion, load.margin
    kept = normal_cdf(load.beyond)
    rest = rests(depth)
    share = min(situation.passed.dt / STUCK_IN_HOLE.beyond_over, 1.0)
    found.beyond += share * (load.beyond_low_friction - found.beyond)
    # A peg that slides is at the diagram's edge; one that rests is anywhere beyond it, up to
    # twice the push, or inside where it can wedge.
    for_rest = 0.5 * max(found.beyond, 0.0) ** 2 - (1.0 - load.locks) * log(load.width)
    # A load inside proves nothing, for friction may be stated too low.
    for_rest = exp(min(max(for_rest, 0.0), EVIDENCE_WEIGHTS.most))
    rest *= for_rest / (1.0 + rest * (for_rest - 1.0))
    stuck = load.held * load.pressed * rest
    return stuck, stuck * load.locks * (1.0 - kept)


@compiled
def _by_diagram(
    scene: SceneScalars, estimate: Estimate, f_z: float, threshold: float
) -> OnDiagram:
    """
    Return where the load is on the diagram.

    Of the friction, f_z is along the hole. The plane is that of the tilt, the tilt small. An
    estimate a little below zero leans to the other side.
    """
    motion, R = estimate.motion, estimate.wrench_noise
    friction_variance = estimate.friction_variance
    angles = (motion.gamma, motion.psi, motion.phi)
    s, c = sin(motion.gamma), cos(motion.gamma)
    side = 1.0 if s >= 0.0 else -1.0
    _, wrench = pose_of(scene, angles, estimate.wrench, estimate.work)
    length = ((scene.D - scene.d) + 2.0 * scene.d * sin(0.5 * motion.gamma) ** 2) / max(
        side * s, 1e-6
    )
    F_x, F_z = side * wrench.F_h, -wrench.F_z
    M = -side * (wrench.M_e + scene.H_c * (c * wrench.F_h + s * wrench.F_z))
    f_z = max(f_z, 1e-3)
    margin = jamming_margin(0.5 * scene.d, length, f_z, F_x, F_z, M)
    more = f_z + sqrt(max(friction_variance, 1e-6))
    by_friction = jamming_margin(0.5 * scene.d, length, more, F_x, F_z, M) - margin
    noise = sqrt(R[0, 0] + R[4, 4] / (scene.d * scene.d / 4.0))
    lever = 1.0 + 2.0 * scene.f * scene.d / length
    uncertain = noise * lever + 0.05 * fabs(F_z)
    uncertain = sqrt(uncertain * uncertain + by_friction * by_friction)
    beyond, low_friction = -margin / uncertain, (by_friction - margin) / uncertain
    # Moments about the edge leave K alone, if the peg slides in; B carries it and the side load.
    arm = length + scene.f * scene.d
    about_edge = M + 0.5 * scene.d * (c * F_z + side * s * F_x)
    about_edge_noise = R[4, 4] + scene.H_c * scene.H_c * R[0, 0]
    N_K, variance = about_edge / arm, about_edge_noise / (arm * arm)
    # K is as steep as the peg leans: without friction it lifts the peg by so much, as where the
    # holder alone keeps the tilt. What is left of the push is for friction.
    steep = max(side * s, 0.0) / length
    left, left_noise = F_z - steep * max(about_edge, 0.0), steep * steep * about_edge_noise
    pressed = normal_cdf((left - threshold) / sqrt(noise * noise + left_noise))
    variance += max(friction_variance, 0.0) * (N_K * scene.d / arm) ** 2
    loaded = normal_cdf(N_K / sqrt(variance)) * normal_cdf((F_x + N_K) / sqrt(variance + R[0, 0]))
    # Where either friction cone holds the other contact, any load may be locked in.
    locks = normal_cdf((scene.f - length / scene.d) / sqrt(max(friction_variance, 1e-6)))
    held = max(loaded, locks)
    width = max(2.0 * F_z / (uncertain * _ROOT_TWO_PI), 1.0)
    # K lies on the peg's side.
    deepest = 2.0 * scene.H_c * side * motion.gamma - (scene.D - scene.d)
    held *= normal_cdf(deepest / (2.0 * scene.H_c * sqrt(max(motion.covariance[0, 0], 1e-18))))
    return OnDiagram(length / scene.d, margin, beyond, low_friction, width, locks, held, pressed)
