"""Extended Kalman filter on the peg's angles and rates: the compiled prediction and correction."""

from math import fabs, sqrt
from typing import NamedTuple

from peg_on_hole_ros.estimation.reactions import creep_variance, friction_scales
from peg_on_hole_ros.estimation.step import CONVERGED, FAILED, implicit_euler
from peg_on_hole_ros.mechanics.kernel import compiled

# A held peg's contacts do not gain speed faster than this [m/s^2]; the noise of a wrench gives
# some 0.5 over a millisecond, and less over longer intervals. Where friction leaves rigid motion
# more than one solution (Painleve), or none, Newton's method otherwise finds the far one.
CONTACT_ACCELERATION = 20.0
SHORTEST_INTERVAL = 1e-3


class Process(NamedTuple):
    """
    How far the contact dynamics are trusted.

    Attributes
    ----------
    max_step : float
        Longest integration step [s].
    rate_density : float
        Spectral density of the random walk added to each rate [rad^2/s^3].
    slip_velocity_scale, slip_widening, creep_time : float
        See `friction_scales` and `creep_variance` [m/s], [-], [s].

    """

    max_step: float
    rate_density: float
    slip_velocity_scale: float
    slip_widening: float
    creep_time: float


# The joint covariance Z is that of the state (6) and of the noise of the wrench that is held (6):
# the same noise drives the motion and enters the reactions.


@compiled
def hold_wrench(Z, noise):
    """Start on a new wrench: its noise is independent of the state's error so far."""
    for i in range(6):
        for j in range(6):
            Z[i, 6 + j] = 0.0
            Z[6 + i, j] = 0.0
            Z[6 + i, 6 + j] = noise[i, j]


@compiled
def _carry(Z, slopes, h, rate_noise, M):
    """Carry the joint covariance through one step, given d(rates)/d(state, wrench)."""
    for i in range(3):
        for j in range(12):
            total = 0.0
            for k in range(12):
                total += slopes[i, k] * Z[k, j]
            M[3 + i, j] = total
    for i in range(3):
        for j in range(12):
            M[i, j] = Z[i, j] + h * M[3 + i, j]
    for i in range(6):
        for j in range(3):
            total = 0.0
            for k in range(12):
                total += M[i, k] * slopes[j, k]
            Z[i, 3 + j] = total
    for i in range(6):
        for j in range(3):
            Z[i, j] = M[i, j] + h * Z[i, 3 + j]
        for j in range(6):
            Z[i, 6 + j] = M[i, 6 + j]
            Z[6 + j, i] = M[i, 6 + j]
    for i in range(3):
        Z[3 + i, 3 + i] += rate_noise * h
        # The implicit step moves the angle with the rate at its end, noise included.
        Z[i, 3 + i] += rate_noise * h * h
        Z[3 + i, i] += rate_noise * h * h
        Z[i, i] += rate_noise * h * h * h
    for i in range(6):
        for j in range(i):
            mean = 0.5 * (Z[i, j] + Z[j, i])
            Z[i, j] = mean
            Z[j, i] = mean


@compiled
def contact_speed_gain(p, x, x1):
    """Return how much speed a contact gains between two states, along or around the rim [m/s]."""
    along = p.D * fabs(x1[3] - x[3])
    around = 0.5 * fabs(p.D * (x1[4] - x[4]) + p.d * (x1[5] - x[5]))
    return max(along, around)


@compiled
def predict_contact(p, process, x, u, Z, dt, buffers):
    """
    Predict over dt under three-point contact; halve the step until Newton's method converges.

    Parameters
    ----------
    p : SceneScalars
    process : Process
    x : ndarray, shape (6,)
        State, changed in place [rad], [rad/s].
    u : ndarray, shape (6,)
        Wrench held, peg axes about the mass centre [N], [N m].
    Z : ndarray, shape (12, 12)
        Joint covariance of state and wrench noise, changed in place.
    dt : float
        [s].
    buffers : Buffers
        Scratch; on return y and dy hold accelerations and reactions at the end, and scales the
        velocity scales of friction that they were taken with.

    Returns
    -------
    status : int
        CONVERGED, or FAILED with state and covariance untouched.
    evaluations : int
        Of the six equations.

    """
    saved_x, saved_Z = buffers.saved_x, buffers.saved_Z
    saved_x[:] = x
    saved_Z[:] = Z
    scales, speeds, smallest = buffers.scales, buffers.speeds, process.slip_velocity_scale
    friction_scales(p, x, Z, smallest, process.slip_widening, speeds, scales)
    creep = creep_variance(p, speeds, smallest, process.creep_time)
    limit = CONTACT_ACCELERATION * max(dt, SHORTEST_INTERVAL)
    pieces = max(1, int(dt / process.max_step + 0.999999))
    evaluations = 0
    for _ in range(8):
        h = dt / pieces
        status = CONVERGED
        for _ in range(pieces):
            status, count = implicit_euler(
                p, scales, x, u, h, buffers.x1, buffers.y, buffers.dy, buffers.iteration,
                buffers.slopes, buffers.work,
            )  # fmt: skip
            evaluations += count
            if status == CONVERGED and contact_speed_gain(p, saved_x, buffers.x1) > limit:
                status = FAILED
            if status != CONVERGED:
                break
            _carry(Z, buffers.slopes, h, process.rate_density, buffers.M)
            x[:] = buffers.x1
        if status == CONVERGED:
            for i in range(3):
                Z[i, i] += creep * dt
            return CONVERGED, evaluations
        x[:] = saved_x
        Z[:] = saved_Z
        pieces *= 2
    return FAILED, evaluations


@compiled
def predict_free(x, Z, dt, rate_noise, buffers):
    """Predict over dt at constant rates: no contact model, and the wrench drives nothing."""
    slopes = buffers.slopes
    for i in range(3):
        for j in range(12):
            slopes[i, j] = 0.0
        slopes[i, 3 + i] = 1.0
    for i in range(3):
        x[i] += dt * x[3 + i]
    _carry(Z, slopes, dt, rate_noise, buffers.M)


@compiled
def innovation(x, Z, q, R, residual, S):
    """
    Fill residual and lower Cholesky factor S of the innovation covariance.

    Returns the normalised innovation squared (3 degrees of freedom).
    """
    for i in range(3):
        residual[i] = q[i] - x[i]
    for i in range(3):
        for j in range(i + 1):
            total = Z[i, j] + R[i, j]
            for k in range(j):
                total -= S[i, k] * S[j, k]
            if i == j:
                S[i, i] = sqrt(total)
            else:
                S[i, j] = total / S[j, j]
    w0 = residual[0] / S[0, 0]
    w1 = (residual[1] - S[1, 0] * w0) / S[1, 1]
    w2 = (residual[2] - S[2, 0] * w0 - S[2, 1] * w1) / S[2, 2]
    return w0 * w0 + w1 * w1 + w2 * w2


@compiled
def widen_rates(Z, dt, factor):
    """
    Widen as if the rates had been less well known since the last correction, dt [s] ago.

    Adds factor times the rates' covariance, and what it would have carried into the angles: a gain
    for the rates that overshoots, as scaling their rows and columns alone gives, is excluded.
    """
    for i in range(3):
        for j in range(3):
            added = factor * Z[3 + i, 3 + j]
            Z[i, j] += dt * dt * added
            Z[3 + i, j] += dt * added
            Z[i, 3 + j] += dt * added
    for i in range(3):
        for j in range(3):
            Z[3 + i, 3 + j] *= 1.0 + factor


@compiled
def correct(x, u, Z, R, residual, S, buffers):
    """
    Correct with an orientation, in Joseph's form on the joint covariance.

    Parameters
    ----------
    x, u, Z
        State, held wrench and their joint covariance, changed in place: an orientation also tells
        something of the noise in the wrench that led to it.
    R : ndarray, shape (3, 3)
        Covariance of the measured angles [rad^2].
    residual, S
        From `innovation`.
    buffers : Buffers

    """
    gain, M = buffers.gain, buffers.joseph
    for i in range(12):
        g0 = Z[i, 0] / S[0, 0]
        g1 = (Z[i, 1] - S[1, 0] * g0) / S[1, 1]
        g2 = (Z[i, 2] - S[2, 0] * g0 - S[2, 1] * g1) / S[2, 2]
        g2 = g2 / S[2, 2]
        g1 = (g1 - S[2, 1] * g2) / S[1, 1]
        g0 = (g0 - S[1, 0] * g1 - S[2, 0] * g2) / S[0, 0]
        gain[i, 0], gain[i, 1], gain[i, 2] = g0, g1, g2
    for i in range(6):
        x[i] += gain[i, 0] * residual[0] + gain[i, 1] * residual[1] + gain[i, 2] * residual[2]
    for i in range(6):
        k = 6 + i
        u[i] += gain[k, 0] * residual[0] + gain[k, 1] * residual[1] + gain[k, 2] * residual[2]
    for i in range(12):
        for j in range(12):
            M[i, j] = Z[i, j] - (
                gain[i, 0] * Z[0, j] + gain[i, 1] * Z[1, j] + gain[i, 2] * Z[2, j]
            )
    for i in range(12):
        k0 = gain[i, 0] * R[0, 0] + gain[i, 1] * R[1, 0] + gain[i, 2] * R[2, 0]
        k1 = gain[i, 0] * R[0, 1] + gain[i, 1] * R[1, 1] + gain[i, 2] * R[2, 1]
        k2 = gain[i, 0] * R[0, 2] + gain[i, 1] * R[1, 2] + gain[i, 2] * R[2, 2]
        for j in range(i + 1):
            total = M[i, j] + k0 * gain[j, 0] + k1 * gain[j, 1] + k2 * gain[j, 2]
            total -= M[i, 0] * gain[j, 0] + M[i, 1] * gain[j, 1] + M[i, 2] * gain[j, 2]
            Z[i, j] = total
            Z[j, i] = total
