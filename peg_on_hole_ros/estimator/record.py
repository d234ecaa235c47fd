"""What an estimate says, as one typed record that monitor and messages read."""

from collections.abc import Sequence
from math import sqrt
from typing import Annotated

import numpy as np

from peg_on_hole_ros.estimator.contact import NEAREST, scene_at
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.direction import (
    direction_moments,
    slip_jacobian,
    slip_moments,
)
from peg_on_hole_ros.estimator.state import ACCELERATION, BIAS, CLEARANCE, FRICTION, RATE
from peg_on_hole_ros.estimator.two_points import two_point_slip, two_point_tilt
from peg_on_hole_ros.mechanics.kernel import (
    SceneScalars,
    closed_forms,
    compiled,
    determinant_at,
    workspace,
)
from peg_on_hole_ros.record_types import StateRecord
from peg_on_hole_ros.typed_record import Floats, Matrix3, Matrix6, Record, Vector3, Vector6


class SceneRecord(Record):
    """A scene as `SceneScalars`, with friction and peg diameter as they are estimated."""

    d: float
    D: float
    H_c: float
    gamma0: float
    m: float
    Ie: float
    Iz: float
    f: float
    g_x: float
    g_y: float
    g_z: float


class Motion(Record):
    """
    Angles and rates.

    Attributes
    ----------
    gamma, psi, phi : float
        [rad].
    gamma_rate, psi_rate, phi_rate : float
        [rad/s].
    covariance : ndarray, shape (6, 6)
        In this order.

    """

    gamma: float
    psi: float
    phi: float
    gamma_rate: float
    psi_rate: float
    phi_rate: float
    covariance: Matrix6


class Reactions(Record):
    """
    Normal reactions at K, B1, B2; in the hole B1 and B2 are halves of B.

    Attributes
    ----------
    normal : ndarray, shape (3,)
        [N].
    covariance : ndarray, shape (3, 3)
        [N^2].
    by_friction, by_diameter : ndarray, shape (3,)
        What an error of friction, or of the peg's diameter, makes of them; it lasts. Of one
        standard deviation [N].

    """

    normal: Vector3
    covariance: Matrix3
    by_friction: Vector3
    by_diameter: Vector3


class Slip(Record):
    """Speed of the peg's material point at a contact [m/s], and its variance [m^2/s^2]."""

    speed: float
    variance: float


class Estimate(Record):
    """
    All that the last wrench has said.

    Attributes
    ----------
    scene : SceneRecord
    friction_variance : float
        [-].
    diameter_variance : float
        Of the peg's diameter [m^2].
    motion : Motion
    accelerations : ndarray, shape (3,)
        [rad/s^2].
    reactions : Reactions
    slips : sequence of Slip
        At K, B1, B2.
    friction_scales : ndarray, shape (3,)
        Velocity scales of friction's mean direction at K, B1, B2 [m/s].
    contacts : ContactSet
        Which the last wrench was weighed with; not determined is `NONE`.
    wrench : ndarray, shape (6,)
        The last wrench on the peg, peg axes, bias taken off [N], [N m].
    wrench_noise : ndarray, shape (6, 6)
        Covariance of a wrench on the peg.
    bias_load : float
        Variance of a carried load by what is not known of the bias [N^2].
    determinant : float
        Of the six equations, over its frictionless value.
    work : ndarray
        Scratch of the kernel.

    """

    scene: SceneRecord
    friction_variance: float
    diameter_variance: float
    motion: Motion
    accelerations: Vector3
    reactions: Reactions
    slips: Annotated[Sequence[Slip], (3,)]
    friction_scales: Vector3
    contacts: ContactSet
    wrench: Vector6
    wrench_noise: Matrix6
    bias_load: float
    determinant: float
    work: Annotated[Floats, workspace().shape]


@compiled
def scene_of(estimate: Estimate) -> SceneScalars:
    """Return the scene of an estimate, with friction and diameter as they are estimated."""
    s = estimate.scene
    return SceneScalars(s.d, s.D, s.H_c, s.gamma0, s.m, s.Ie, s.Iz, s.f, s.g_x, s.g_y, s.g_z)


@compiled
def fill_record(
    estimate: Estimate,
    s: StateRecord,
    at: np.ndarray,
    n: int,
    p: SceneScalars,
    u: np.ndarray,
    bias_map: np.ndarray,
    share: float,
    left: np.ndarray,
) -> None:
    """
    Fill in the record by the mean of the mixture.

    Parameters
    ----------
    estimate : Estimate
        Filled, but for `wrench_noise`.
    s : record of STATE
    at : ndarray, shape (6,)
    n : int
    p : SceneScalars
        The scene as stated.
    u : ndarray, shape (6,)
        The last wrench.
    bias_map : ndarray, shape (6, 6)
    share : float
        `direction_share`.
    left : ndarray, shape (3,)
        Scratch.

    """
    x, C = s.mean, s.covariance
    q = scene_at(p, x, at, s.load[0])
    q = SceneScalars(q.d, q.D, q.H_c, q.gamma0, q.m, q.Ie, q.Iz, x[FRICTION], q.g_x, q.g_y, q.g_z)
    _fill_scene(estimate.scene, q)
    _fill_motion(estimate.motion, x, C)
    for i in range(6):
        estimate.wrench[i] = u[i]
    for i in range(3):
        estimate.accelerations[i] = x[ACCELERATION + i]
    estimate.bias_load = 0.0
    if at[BIAS] >= 0:
        _take_bias_off(estimate, x, C, at[BIAS], bias_map, 2.0 / p.d)
    # The diameter is what the clearance leaves of the hole's.
    by_log = -(q.D - q.d) if at[CLEARANCE] >= 0 else 0.0
    k = max(at[CLEARANCE], 0)
    estimate.friction_variance = C[FRICTION, FRICTION]
    estimate.diameter_variance = by_log * by_log * C[k, k]
    reactions = estimate.reactions
    for i in range(3):
        reactions.normal[i] = x[n + i]
        for j in range(3):
            reactions.covariance[i, j] = C[n + i, n + j]
    _fill_lasting(reactions.by_friction, C, FRICTION, n, 1.0, estimate.friction_variance)
    _fill_lasting(reactions.by_diameter, C, k, n, by_log, estimate.diameter_variance)
    tilt = min(max(x[0], q.gamma0 + NEAREST), 1.5)
    geo = closed_forms(q.d, q.D, q.H_c, q.gamma0, tilt)
    scales = estimate.friction_scales
    direction_moments(q, geo, x, C, share, scales, left)
    contacts = int(s.contacts[0])
    in_hole = contacts == ContactSet.TWO
    if in_hole:
        estimate.contacts = ContactSet.TWO
    else:
        estimate.contacts = ContactSet.THREE if contacts == ContactSet.THREE else ContactSet.NONE
    for i in range(3):
        if in_hole:
            rows = two_point_slip(q, two_point_tilt(q, x[0]), min(i, 1))
            scales[i] = sqrt(slip_moments(rows, x, C, share)[2])
        else:
            rows = slip_jacobian(q, geo, i)
        _fill_slip(estimate.slips[i], rows, x, C)
    rates = (x[RATE], x[RATE + 1], x[RATE + 2])
    if not in_hole:
        estimate.determinant = determinant_at(q, scales, tilt, rates, estimate.work)


@compiled
def _fill_scene(scene, q):
    scene.d, scene.D, scene.H_c, scene.gamma0 = q.d, q.D, q.H_c, q.gamma0
    scene.m, scene.Ie, scene.Iz, scene.f = q.m, q.Ie, q.Iz, q.f
    scene.g_x, scene.g_y, scene.g_z = q.g_x, q.g_y, q.g_z


@compiled
def _fill_motion(motion, x, C):
    motion.gamma, motion.psi, motion.phi = x[0], x[1], x[2]
    motion.gamma_rate, motion.psi_rate, motion.phi_rate = x[RATE], x[RATE + 1], x[RATE + 2]
    for i in range(6):
        for j in range(6):
            motion.covariance[i, j] = C[i, j]


@compiled
def _fill_lasting(out, C, of, n, scale, variance):
    """Fill in what a standard deviation of one quantity makes of the reactions."""
    over = 1.0 / sqrt(variance) if variance > 0.0 else 0.0
    for i in range(3):
        out[i] = scale * C[of, n + i] * over


@compiled
def _take_bias_off(estimate, x, C, first, bias_map, over_radius):
    for i in range(6):
        weight = 1.0 if i < 3 else over_radius * over_radius
        for j in range(6):
            estimate.wrench[i] -= bias_map[i, j] * x[first + j]
            for k in range(6):
                estimate.bias_load += (
                    weight * bias_map[i, j] * C[first + j, first + k] * bias_map[i, k]
                )


@compiled
def _fill_slip(slip, rows, x, C):
    """Fill in speed and variance of the peg's material point at one contact, by its Jacobian."""
    speed2, d0, d1, d2 = 0.0, 0.0, 0.0, 0.0
    for a, b, c in rows:
        v = a * x[RATE] + b * x[RATE + 1] + c * x[RATE + 2]
        speed2 += v * v
        d0 += v * a
        d1 += v * b
        d2 += v * c
    speed = sqrt(speed2)
    over = 1.0 / (speed + 1e-300)
    d0, d1, d2 = d0 * over, d1 * over, d2 * over
    k = RATE
    variance = d0 * d0 * C[k, k] + d1 * d1 * C[k + 1, k + 1] + d2 * d2 * C[k + 2, k + 2]
    variance += 2.0 * (d0 * d1 * C[k, k + 1] + d0 * d2 * C[k, k + 2] + d1 * d2 * C[k + 1, k + 2])
    slip.speed, slip.variance = speed, max(variance, 0.0)
