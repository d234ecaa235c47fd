"""Whether the push that closes a peg on three contacts grows, or is more than usual."""

from math import fabs, sqrt
from typing import NamedTuple

from peg_on_hole_ros.estimator.estimate import Estimate, scene_of
from peg_on_hole_ros.mechanics.kernel import SceneScalars, closed_forms, compiled, pose_of
from peg_on_hole_ros.monitor.contact_probabilities import normal_cdf
from peg_on_hole_ros.monitor.motion_now import Moving
from peg_on_hole_ros.monitor.trend import is_number
from peg_on_hole_ros.monitor.tuned import PUSH_MEANS
from peg_on_hole_ros.typed_record import Floats, Record

# docs/jamming.md, "Stall", has the definition.


class Means(Record):
    """Running means of a quantity: quick and slow ones, and the one while the peg closes."""

    quick: float
    slow: float
    usual: float


class Push(Record):
    """
    What has been seen of the push.

    Attributes
    ----------
    force : Means
        Of the generalised force that closes the peg [N m].
    against : Means
        Of the share of friction that is against the closing [-].
    moved : float
        For how long the peg has closed [s].
    total : float
        Running mean of the sum of the reactions [N]; 0: not seen.

    """

    force: Means
    against: Means
    moved: float
    total: float


class Pushed(NamedTuple):
    """
    The push at a wrench.

    Attributes
    ----------
    taken : bool
        Whether it is a number; the next three are, then.
    force, variance : float
        Generalised force that closes the peg [N m], and its variance.
    held : float
        What friction can hold [N m].
    grows, pushes : float
        Probabilities that the push grows, and that it grows or is more than usual; 0 before the
        peg has moved in contact.

    """

    taken: bool
    force: float
    variance: float
    held: float
    grows: float
    pushes: float


# A peg that touches nothing.
NOT_PUSHED = Pushed(False, 0.0, 0.0, 0.0, 0.0, 0.0)


@compiled
def forget_push(push: Push) -> None:
    """Begin anew with the next push."""
    push.moved = push.total = 0.0
    push.force.quick = push.force.slow = push.force.usual = 0.0
    push.against.quick = push.against.slow = push.against.usual = 0.0


@compiled
def follow_total(push: Push, normal: Floats, dt: float) -> None:
    """Process reactions, shape (3,) [N], a time [s] after the last ones."""
    total = 0.0
    for i in range(3):
        total += fabs(normal[i])
    share = min(dt / PUSH_MEANS.total_over, 1.0) if push.total > 0.0 else 1.0
    push.total += share * (total - push.total)


@compiled
def _closing_force(scene: SceneScalars, estimate: Estimate) -> tuple[float, float, float]:
    """
    Return the generalised force that closes the peg, without contacts, its variance, and a lever.

    The lever is by how much the contacts slip, in their mean, where the tilt changes by one.
    """
    motion, R = estimate.motion, estimate.wrench_noise
    angles = (motion.gamma, motion.psi, motion.phi)
    tilt = max(motion.gamma, scene.gamma0 * (1.0 + PUSH_MEANS.edge))
    geo, wrench = pose_of(scene, angles, estimate.wrench, estimate.work)
    if not motion.gamma > scene.gamma0:
        geo = closed_forms(scene.d, scene.D, scene.H_c, scene.gamma0, tilt)
    dh_c, dz_c = geo.dh_c, geo.dz_c
    force = wrench.M_e - wrench.F_h * dh_c - wrench.F_z * dz_c
    s, a1, S1 = geo.s, geo.a1, geo.S1
    lever = 2.0 / 3.0 * (a1 / s + 2.0 * sqrt(a1 * a1 + S1 * S1))
    return force, R[0, 0] * (dh_c * dh_c + dz_c * dz_c) + R[4, 4], lever


@compiled
def pushed_on(estimate: Estimate, push: Push, moving: Moving, dt: float, horizon: float) -> Pushed:
    """
    Process a wrench of a peg that touches, and return the push.

    A peg that its holder brings to rest feels a push that changes little, one that stalls is
    pushed ever more; both beside what friction can hold. There is no push before the peg has moved
    in contact: what would move it is not known.

    Parameters
    ----------
    estimate : Estimate
    push : Push
        Changed.
    moving : Moving
    dt : float
        Since the last wrench [s].
    horizon : float
        Ahead [s].

    """
    p, total = scene_of(estimate), push.total
    force, variance, lever = _closing_force(p, estimate)
    if not (is_number(force) and is_number(variance)):
        # Nothing is taken from it.
        return NOT_PUSHED
    held = max(0.5 * p.d * p.f * total, 3.0 * sqrt(variance))
    # Friction is against closing and turning in their shares of the slip.
    tilting = lever * fabs(moving.rate)
    against = tilting / (tilting + 0.5 * p.d * fabs(moving.turn) + 1e-9)
    # Of a trend that is noise a peg at rest closes in every other instant.
    closing = moving.closing if moving.known else 0.0
    if push.moved == 0.0:
        push.force.quick = push.force.slow = push.force.usual = force
        push.against.quick = push.against.slow = push.against.usual = against
    _follow_means(push.force, force, dt, closing)
    _follow_means(push.against, against, dt, closing)
    push.moved += dt * closing
    if push.moved < PUSH_MEANS.moved or total == 0.0:
        return Pushed(True, force, variance, held, 0.0, 0.0)
    noise = variance * min(0.5 * dt / PUSH_MEANS.quick, 1.0)
    grows, more = _compared(push, held, noise, horizon)
    return Pushed(True, force, variance, held, grows, max(grows, more))


@compiled
def _follow_means(means: Means, value: float, dt: float, closing: float) -> None:
    means.quick += min(dt / PUSH_MEANS.quick, 1.0) * (value - means.quick)
    means.slow += min(dt / PUSH_MEANS.slow, 1.0) * (value - means.slow)
    means.usual += min(dt / PUSH_MEANS.usual, 1.0) * closing * (value - means.usual)


@compiled
def _compared(push: Push, held: float, noise: float, horizon: float) -> tuple[float, float]:
    """Return the probabilities that the push grows, and that it is more than usual."""
    force, against = push.force, push.against
    scatter = (PUSH_MEANS.more_stddev * held) ** 2
    slope = horizon / (PUSH_MEANS.slow - PUSH_MEANS.quick)
    # A slip or slide that ends, or reverses, turns friction against the closing: that is no press.
    now = max(against.quick, 1e-9)
    turned = max(1.0 - against.slow / now, 0.0) * fabs(force.quick)
    growth = slope * (force.quick - force.slow - turned) - PUSH_MEANS.more * held
    grows = normal_cdf(growth / sqrt(slope * slope * noise + scatter))
    usual = force.usual + max(now / max(against.usual, 1e-9) - 1.0, 0.0) * fabs(force.usual)
    return grows, normal_cdf(
        (force.quick - usual - PUSH_MEANS.more * held) / sqrt(noise + scatter)
    )
