"""The posterior Cramér-Rao bound along a known motion: how well any estimator can do, at best."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimation.measurement import angle_covariance
from peg_on_hole_ros.mechanics.geometry import contact_geometry, velocity_jacobians
from peg_on_hole_ros.mechanics.kernel import (
    WIDTH,
    accelerate_with_derivatives,
    compiled,
    determinant_at,
    scene_of,
    scene_scalars,
    workspace,
)
from peg_on_hole_ros.mechanics.scene import Scene

# State, wrench, friction and peg diameter.
SIZE = WIDTH
# A tangent tells nothing of a function within three standard deviations of its kink or pole.
SPREADS = 3.0
# Slip below so many velocity scales of friction is creep of the regularised law, not sliding.
CREEP_SCALES = 10.0
# The determinant (1 without friction) below which the reactions' tangent is not to be trusted.
SMALL_DETERMINANT = 0.05


class Meaning(IntEnum):
    """
    Whether the bound means something at a sample, else why not.

    SLOW: a contact sticks, or slips so slowly that the direction of its friction is not known.
    SINGULAR: the six equations have no solution nearby. TRANSITION: gamma0 is within the spread.
    Where several hold, the first of them stands.
    """

    SOUND = 0
    SLOW = 1
    SINGULAR = 2
    TRANSITION = 3


class Bound(NamedTuple):
    """
    The bound at each sample, after the orientation that was measured then, if any.

    Attributes
    ----------
    state : ndarray, shape (n, 6, 6)
        Of gamma, psi, phi and their rates [rad^2, rad^2/s, rad^2/s^2].
    reactions : ndarray, shape (n, 3, 3)
        Of N_K, N_B1, N_B2 [N^2].
    parameters : ndarray, shape (n, 2, 2)
        Of friction and peg diameter [-, m, m^2].
    meaning : ndarray of int, shape (n,)
        Members of `Meaning`; where it is not SOUND the numbers say nothing.
    slip_speed : ndarray, shape (n, 3)
        Of the motion at K, B1, B2 [m/s].
    determinant : ndarray, shape (n,)
        Of the six equations with dry friction, over its frictionless value [-].

    """

    state: np.ndarray
    reactions: np.ndarray
    parameters: np.ndarray
    meaning: np.ndarray
    slip_speed: np.ndarray
    determinant: np.ndarray


class Sensors(NamedTuple):
    """
    What is measured, and how well.

    Attributes
    ----------
    wrench_noise : ndarray, shape (6, 6)
        Covariance of the wrench about the mass centre, peg axes [N^2, N^2 m, N^2 m^2].
    orientation_stddev : float
        See `measurement.angle_covariance` [rad].
    measured : ndarray of bool, shape (n,)
        At which samples the orientation is; at the first it has to be, since nothing else tells
        what it is there.

    """

    wrench_noise: np.ndarray
    orientation_stddev: float
    measured: np.ndarray


def posterior_bound(
    scene: Scene,
    t,
    state,
    wrench,
    sensors: Sensors,
    initial_rate_stddev: float = 1.0,
    slip_velocity_scale: float = 1e-5,
    acceleration_stddev=np.inf,
    friction_noise: float = 0.0,
    pieces: int = 1,
) -> Bound:
    """
    Return the bound on the mean square error of any estimator that knows scene and noise.

    Parameters
    ----------
    scene : Scene
        As it truly is; of friction and peg diameter no more is known before the first sample than
        `friction_stddev` and `clearance_stddev` say.
    t : ndarray, shape (n,)
        Times of the wrench's samples [s].
    state : ndarray, shape (n, 6)
        The true motion: gamma, psi, phi [rad] and their rates [rad/s].
    wrench : ndarray, shape (n, 6)
        The true wrench about the mass centre, peg axes [N], [N m].
    sensors : Sensors
    initial_rate_stddev : float
        What is known of the rates before the first sample [rad/s].
    slip_velocity_scale : float
        Of the motion's friction law [m/s].
    acceleration_stddev : float or ndarray, shape (3,) or (n, 3)
        What is known beforehand of each angle's acceleration [rad/s^2], for the reactions only.
    friction_noise : float
        Of the random walk that friction makes as far as is known [1/sqrt(s)].
    pieces : int
        Steps between two samples, their ends on the straight line between the true states.

    Returns
    -------
    Bound

    Raises
    ------
    PegOnHoleError
        Shapes that do not fit, times that do not rise, a motion below gamma0 or not finite, a
        first sample without an orientation.

    Notes
    -----
    The motion is determined by the wrench, and that is known up to its noise, which is held from
    one sample to the next. Its noise at a sample thus drives the motion up to there, and enters
    the reactions there. With x' = f(x, u), the step's exact derivatives F, G at the true motion
    and Q, R the noise of wrench and orientation, the recursion of Tichavsky, Muravchik and Nehorai
    (IEEE Trans. Signal Processing 46, 1998, eq. 21) for state and wrench together becomes

        Z = [[F P F.T + G Q G.T, G Q], [Q G.T, Q]],   J = inv(Z) + H.T inv(R) H,   P = inv(J)_xx

    in covariance form, which stands that the rates alone are driven. Friction and peg diameter are
    two more states, which stay. Nothing is assumed on how
    smoothly the wrench changes: an estimator that knows more of it can do better.

    """
    n = len(t)
    t, state, wrench = (np.ascontiguousarray(a, float) for a in (t, state, wrench))
    _check(scene, t, state, wrench, sensors)
    scales = np.full(3, float(slip_velocity_scale))
    measured = np.asarray(sensors.measured, bool)
    R = np.zeros((n, 3, 3))
    for k in np.flatnonzero(measured):
        R[k] = angle_covariance(state[k, 0], sensors.orientation_stddev)
    P = np.zeros((SIZE, SIZE))
    P[:3, :3] = angle_covariance(state[0, 0], sensors.orientation_stddev)
    P[range(3, 6), range(3, 6)] = initial_rate_stddev**2
    P[range(12, 14), range(12, 14)] = scene.friction_stddev**2, scene.clearance_stddev**2
    scalars = np.array(scene_scalars(scene))
    held = np.broadcast_to(np.square(acceleration_stddev, dtype=float), (n, 3)).copy()
    states, reactions, parameters, determinant = _recursion(
        scalars, scales, t, state, wrench, P,
        np.ascontiguousarray(sensors.wrench_noise, float), R, measured,
        held, float(friction_noise) ** 2, pieces, workspace(),
    )  # fmt: skip
    speed, spread = _slip(scene, state, states)
    slow = speed < np.maximum(SPREADS * spread, CREEP_SCALES * slip_velocity_scale)
    meaning = np.full(n, Meaning.SOUND)
    meaning[state[:, 0] - scene.gamma0 < SPREADS * np.sqrt(states[:, 0, 0])] = Meaning.TRANSITION
    meaning[~(determinant > SMALL_DETERMINANT)] = Meaning.SINGULAR
    meaning[slow.any(axis=1)] = Meaning.SLOW
    return Bound(states, reactions, parameters, meaning, speed, determinant)


def _check(scene, t, state, wrench, sensors):
    n = len(t)
    for name, value, width in (("state", state, 6), ("wrench", wrench, 6)):
        if value.shape != (n, width):
            raise PegOnHoleError(
                f"{name} has the shape {value.shape}, but {n} times ask for {(n, width)}"
            )
        if not np.isfinite(value).all():
            raise PegOnHoleError(f"{name} is not finite: cut the motion where it is not known")
    if len(sensors.measured) != n:
        raise PegOnHoleError(f"measured has {len(sensors.measured)} entries for {n} times")
    if n and not sensors.measured[0]:
        raise PegOnHoleError(
            "measured[0] is False: without an orientation at the first sample nothing bounds the "
            "state there; cut the motion to where the first orientation is"
        )
    if n < 2 or not (np.diff(t) > 0).all():
        raise PegOnHoleError("the times of a motion are two or more, and rise [s]")
    lowest = state[:, 0].min()
    if lowest <= scene.gamma0:
        raise PegOnHoleError(
            f"gamma = {lowest:.6g} rad is not above gamma0 = {scene.gamma0:.6g} rad: there is no "
            "three-point contact; cut the motion before"
        )


@compiled
def _step_derivatives(dy, h):
    """Return d(end)/d(begin) of an implicit Euler step; only the state moves, shape (14, 14)."""
    rows = np.zeros((3, SIZE))
    A = np.eye(3) - h * (dy[:3, 3:6] + h * dy[:3, :3])
    rows[:, :3] = h * dy[:3, :3]
    rows[:, 3:6] = np.eye(3)
    rows[:, 6:] = h * dy[:3, 6:]
    F = np.eye(SIZE)
    F[3:6] = np.linalg.solve(A, rows)
    F[:3] += h * F[3:6]
    return F


@compiled
def _recursion(
    scalars, scales, t, state, wrench, Z, Q, R, measured, acceleration_variance,
    friction_density, pieces, work,
):  # fmt: skip
    p = scene_of(scalars)
    n = len(t)
    states, reactions = np.zeros((n, 6, 6)), np.zeros((n, 3, 3))
    parameters = np.zeros((n, 2, 2))
    determinants = np.zeros(n)
    y, dy = np.zeros(6), np.zeros((6, SIZE))
    coulomb = (1e-9, 1e-9, 1e-9)
    for k in range(n):
        # A new wrench brings its own noise.
        Z[6:12, :] = 0.0
        Z[:, 6:12] = 0.0
        Z[6:12, 6:12] = Q
        if k > 0:
            h = (t[k] - t[k - 1]) / pieces
            for i in range(pieces):
                share = (i + 1.0) / pieces
                x = (1.0 - share) * state[k - 1] + share * state[k]
                u = (1.0 - share) * wrench[k - 1] + share * wrench[k]
                accelerate_with_derivatives(p, scales, x, u, work, y, dy)
                F = _step_derivatives(dy, h)
                Z = F @ Z @ F.T.copy()
            Z[12, 12] += friction_density * (t[k] - t[k - 1])
        if measured[k] and k > 0:
            seen = Z[:3, :].copy()
            Z = Z - seen.T.copy() @ np.linalg.solve(Z[:3, :3] + R[k], seen)
            Z = 0.5 * (Z + Z.T)
        rates = (state[k, 3], state[k, 4], state[k, 5])
        determinants[k] = determinant_at(p, coulomb, state[k, 0], rates, work)
        accelerate_with_derivatives(p, scales, state[k], wrench[k], work, y, dy)
        C = dy @ Z @ dy.T.copy()
        if np.isfinite(acceleration_variance[k]).all():
            S = C[:3, :3] + np.diag(acceleration_variance[k])
            C = C - np.linalg.solve(S, C[:3, :].copy()).T.copy() @ C[:3, :].copy()
        states[k], reactions[k], parameters[k] = Z[:6, :6], C[3:, 3:], Z[12:, 12:]
    return states, reactions, parameters, determinants


def _slip(scene, state, covariance):
    """Return slip speeds and, along and across them, the largest standard deviation of each."""
    n = len(state)
    speed, spread = np.empty((n, 3)), np.empty((n, 3))
    for k in range(n):
        g = contact_geometry(scene, state[k, 0])
        J = np.array(velocity_jacobians(g, scene.peg_diameter, scene.hole_diameter))
        speed[k] = np.linalg.norm(J @ state[k, 3:], axis=1)
        C = J @ covariance[k, 3:, 3:] @ np.transpose(J, (0, 2, 1))
        spread[k] = np.sqrt(np.linalg.eigvalsh(C)[:, -1].clip(0.0))
    return speed, spread
