"""The posterior Cramér-Rao bound along a known motion: how well any estimator can do, at best."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.measurements.angles import angle_covariance
from peg_on_hole_ros.mechanics.geometry import contact_geometry, velocity_jacobians
from peg_on_hole_ros.mechanics.kernel import (
    JACOBIAN_WIDTH,
    accelerate_with_derivatives,
    compiled,
    determinant_at,
    scene_of,
    workspace,
)
from peg_on_hole_ros.mechanics.scene import Scene, scene_scalars

# Angles, rates, accelerations; friction and peg diameter; the wrench's noise.
_MOTION_SIZE, _STATE_SIZE, _ALL = 9, 11, 17
# A tangent tells nothing of a function within three standard deviations of its kink or pole.
SPREADS = 3.0
# Slip below so many velocity scales of friction is creep of the regularised law, not sliding.
CREEP_SCALES = 10.0
# The determinant (1 without friction) below which the reactions' tangent is not to be trusted.
SMALL_DETERMINANT = 0.05
# No held peg is steadier [rad/s^2].
STEADIEST = 1e-3


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


class TrueMotion(NamedTuple):
    """
    A motion that is known.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Times of the wrench's samples [s].
    state : ndarray, shape (n, 6)
        gamma, psi, phi [rad] and their rates [rad/s].
    wrench : ndarray, shape (n, 6)
        About the mass centre, peg axes, without noise [N], [N m].

    """

    t: np.ndarray
    state: np.ndarray
    wrench: np.ndarray


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


class Smoothness(NamedTuple):
    """
    How a holder moves the peg: each angle's acceleration is an Ornstein-Uhlenbeck process.

    Attributes
    ----------
    level : ndarray, shape (3,)
        Stationary standard deviation [rad/s^2].
    time : ndarray, shape (3,)
        In which it fades to 1/e [s].

    """

    level: np.ndarray
    time: np.ndarray


def smoothness(t: np.ndarray, accelerations: np.ndarray) -> Smoothness:
    """
    Return level and time of a motion's accelerations.

    The level is their root mean square, the time that in which their autocorrelation falls to
    1/e, between a sample and half the motion.

    Parameters
    ----------
    t : ndarray, shape (n,)
        [s].
    accelerations : ndarray, shape (n, 3)
        Of gamma, psi, phi [rad/s^2].

    """
    n, period = len(t), float(np.median(np.diff(t)))
    level, time = np.empty(3), np.empty(3)
    for i, a in enumerate(np.asarray(accelerations, float).T):
        padded = np.fft.rfft(a, 2 * n)
        correlation = np.fft.irfft(padded * padded.conj())[: n // 2 + 1]
        level[i] = max(np.sqrt(correlation[0] / n), STEADIEST)
        below = np.flatnonzero(correlation <= correlation[0] / np.e)
        time[i] = period * max(below[0] if below.size else n // 2, 1)
    return Smoothness(level, time)


def posterior_bound(
    scene: Scene,
    motion: TrueMotion,
    sensors: Sensors,
    initial_rate_stddev: float = 1.0,
    slip_velocity_scale: float = 1e-5,
    holder: Smoothness | None = None,
    friction_noise: float = 0.0,
) -> Bound:
    """
    Return the bound on the mean square error of any estimator that knows scene, noise and holder.

    Parameters
    ----------
    scene : Scene
        As it truly is; of friction and peg diameter no more is known before the first sample than
        `friction_stddev` and `clearance_stddev` say.
    motion : TrueMotion
    sensors : Sensors
    initial_rate_stddev : float
        What is known of the rates before the first sample [rad/s].
    slip_velocity_scale : float
        Of the motion's friction law [m/s].
    holder : Smoothness, optional
        What is known beforehand of the accelerations; None: the motion's own level and time.
    friction_noise : float
        Of the random walk that friction makes as far as is known [1/sqrt(s)].

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
    The model is that of a held peg. Its state are angles q, rates w, accelerations a, friction
    and peg diameter. Between samples each a_i is an Ornstein-Uhlenbeck process of level A_i and
    time tau_i, integrated exactly; friction walks, the diameter stays. An orientation measures q.
    A wrench measures the six equations, in which the reactions N are unknowns of which nothing is
    known: with (a, N) = y(q, w, u, f, d) solved for the true motion, and u measured with noise v,

        0 = da - y_a,(q, w) d(q, w) - y_a,(f, d) d(f, d) - y_a,u v        (three equations),
        dN = y_N,(q, w) d(q, w) + y_N,(f, d) d(f, d) + y_N,u v.

    With the exact derivatives at the true motion the recursion of Tichavsky, Muravchik and
    Nehorai (IEEE Trans. Signal Processing 46, 1998, eq. 21) is that of a Kalman filter's
    covariance, which is run here with v as a part of the state at its sample, so that reactions
    have its noise as well as what orientations and smoothness tell of it.

    The bound is on the mean over motions that such a holder makes: none that an estimator knows
    beyond level and time is left out. With the motion's own level and time, errors over the bound
    of 1 are thus what a best estimator would have; of one motion, they may lie below by chance.

    """
    motion = TrueMotion(*(np.ascontiguousarray(part, float) for part in motion))
    _check(scene, motion, sensors)
    t, state, _ = motion
    n = len(t)
    scales = np.full(3, float(slip_velocity_scale))
    measured = np.asarray(sensors.measured, bool)
    R = np.zeros((n, 3, 3))
    for k in np.flatnonzero(measured):
        R[k] = angle_covariance(state[k, 0], sensors.orientation_stddev)
    if holder is None:
        holder = smoothness(t, np.gradient(state[:, 3:], t, axis=0))
    P = np.zeros((_STATE_SIZE, _STATE_SIZE))
    P[:3, :3] = angle_covariance(state[0, 0], sensors.orientation_stddev)
    P[range(3, 6), range(3, 6)] = initial_rate_stddev**2
    P[range(6, 9), range(6, 9)] = np.square(holder.level)
    P[range(9, 11), range(9, 11)] = scene.friction_stddev**2, scene.clearance_stddev**2
    steps, which = np.unique(np.round(np.diff(t, prepend=t[0]) * 1e9), return_inverse=True)
    F, Q = (np.array(part) for part in zip(*(_moved(step * 1e-9, holder) for step in steps)))
    noise = np.ascontiguousarray(sensors.wrench_noise, float)
    states, reactions, parameters, determinant = _recursion(
        np.array(scene_scalars(scene)),
        scales,
        motion,
        P,
        _Noise(noise, R, measured),
        _Process(F, Q, which, float(friction_noise) ** 2),
        workspace(),
    )
    speed, spread = _slip(scene, state, states)
    slow = speed < np.maximum(SPREADS * spread, CREEP_SCALES * slip_velocity_scale)
    meaning = np.full(n, Meaning.SOUND)
    meaning[state[:, 0] - scene.gamma0 < SPREADS * np.sqrt(states[:, 0, 0])] = Meaning.TRANSITION
    meaning[~(determinant > SMALL_DETERMINANT)] = Meaning.SINGULAR
    meaning[slow.any(axis=1)] = Meaning.SLOW
    return Bound(states, reactions, parameters, meaning, speed, determinant)


def _moved(dt, holder: Smoothness):
    """Return transition and covariance of angles, rates and accelerations over dt [s], (9, 9)."""
    F, Q = np.eye(_MOTION_SIZE), np.zeros((_MOTION_SIZE, _MOTION_SIZE))
    if dt == 0.0:
        return F, Q
    for i, (level, time) in enumerate(zip(holder.level, holder.time)):
        A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / time]])
        drive = np.diag([0.0, 0.0, 2.0 * level**2 / time])
        # Van Loan (IEEE Trans. Automatic Control 23, 1978).
        both = expm(np.block([[-A, drive], [np.zeros((3, 3)), A.T]]) * dt)
        here = np.ix_(range(i, _MOTION_SIZE, 3), range(i, _MOTION_SIZE, 3))
        F[here] = both[3:, 3:].T
        Q[here] = both[3:, 3:].T @ both[:3, 3:]
    return F, 0.5 * (Q + Q.T)


def _check(scene, motion, sensors):
    t, state, wrench = motion
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


class _Noise(NamedTuple):
    """Covariances of the wrench and of each orientation, and at which samples there is one."""

    wrench: np.ndarray
    orientation: np.ndarray
    measured: np.ndarray


class _Process(NamedTuple):
    """
    Transitions and covariances of the motion, one for each period between samples.

    `which` is the period before each sample, `friction` the density of friction's walk [1/s].

    """

    F: np.ndarray
    Q: np.ndarray
    which: np.ndarray
    friction: float


@compiled
def _recursion(scalars, scales, motion, P, noise, process, work):
    p = scene_of(scalars)
    t, state, wrench = motion
    n = len(t)
    states, reactions = np.zeros((n, 6, 6)), np.zeros((n, 3, 3))
    parameters = np.zeros((n, 2, 2))
    determinants = np.zeros(n)
    y, dy = np.zeros(6), np.zeros((6, JACOBIAN_WIDTH))
    coulomb = (1e-9, 1e-9, 1e-9)
    Z, H, D = np.zeros((_ALL, _ALL)), np.zeros((3, _ALL)), np.zeros((3, _ALL))
    Z[:_STATE_SIZE, :_STATE_SIZE] = P
    for k in range(n):
        # A new wrench brings its own noise.
        Z[_STATE_SIZE:, :] = 0.0
        Z[:, _STATE_SIZE:] = 0.0
        Z[_STATE_SIZE:, _STATE_SIZE:] = noise.wrench
        if k > 0:
            step = process.F[process.which[k]]
            Z[:_MOTION_SIZE, :_STATE_SIZE] = step @ Z[:_MOTION_SIZE, :_STATE_SIZE].copy()
            Z[:_STATE_SIZE, :_MOTION_SIZE] = Z[:_STATE_SIZE, :_MOTION_SIZE].copy() @ step.T.copy()
            Z[:_MOTION_SIZE, :_MOTION_SIZE] += process.Q[process.which[k]]
            Z[9, 9] += process.friction * (t[k] - t[k - 1])
        if noise.measured[k] and k > 0:
            seen = Z[:3, :].copy()
            Z -= seen.T.copy() @ np.linalg.solve(Z[:3, :3] + noise.orientation[k], seen)
        rates = (state[k, 3], state[k, 4], state[k, 5])
        determinants[k] = determinant_at(p, coulomb, state[k, 0], rates, work)
        accelerate_with_derivatives(p, scales, state[k], wrench[k], work, y, dy)
        for i in range(3):
            for j in range(6):
                H[i, j], D[i, j] = -dy[i, j], dy[3 + i, j]
                H[i, _STATE_SIZE + j], D[i, _STATE_SIZE + j] = -dy[i, 6 + j], dy[3 + i, 6 + j]
            for j in range(3):
                H[i, 6 + j] = 1.0 if i == j else 0.0
            for j in range(2):
                H[i, 9 + j], D[i, 9 + j] = -dy[i, 12 + j], dy[3 + i, 12 + j]
        told = H @ Z
        Z -= told.T.copy() @ np.linalg.solve(told @ H.T.copy(), told)
        Z = 0.5 * (Z + Z.T)
        states[k], parameters[k] = Z[:6, :6], Z[9:11, 9:11]
        reactions[k] = D @ Z @ D.T.copy()
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
