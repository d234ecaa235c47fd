"""
Steps of a peg in a hole, by TR-BDF2 on the rotation group: second order, and stiff contacts damp.

R. E. Bank and others, Transient simulation of silicon devices and circuits, IEEE Trans. Electron
Devices 32 (1985) 1992-2007: half of a step by the trapezoidal rule, the rest by backward
differences, both with one coefficient.
"""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.compiling import compiled
from peg_on_hole_ros.sim.hole_forces import (
    HoleContacts,
    HoleModel,
    acceleration,
    commanded,
    contact_forces,
    pull,
)

# Largest step [s], and how often one that finds no solution is halved.
STEP = 1e-4
_HALVINGS = 12
_TRAPEZOIDAL_PART = 2 - np.sqrt(2.0)
# Newton's iteration: with one Jacobian, Jacobians, and what is left of a velocity and an angular
# velocity [m/s], [rad/s].
_ITERATIONS, _JACOBIANS = 6, 6
_VELOCITY_RESIDUAL, _TURNING_RESIDUAL = 1e-10, 1e-8


class Body(NamedTuple):
    """
    A peg in the hole at a time.

    Attributes
    ----------
    C, R, V : ndarray, shape (3,), (3, 3), (6,)
        Mass centre [m], axes, velocity [m/s] and angular velocity [rad/s], hole axes.
    acceleration : ndarray, shape (6,)
        [m/s^2], [rad/s^2]
    shift, slips : ndarray, shape (4, 3)
        Strain of the contacts along the surfaces [m], velocity there [m/s].
    azimuth : ndarray, shape (4,)
        Of the contacts' slots [rad].
    J : ndarray, shape (6, 6)
        Of the last step's equations.

    """

    C: np.ndarray
    R: np.ndarray
    V: np.ndarray
    acceleration: np.ndarray
    shift: np.ndarray
    slips: np.ndarray
    azimuth: np.ndarray
    J: np.ndarray


class _Stage(NamedTuple):
    """
    The equations of one stage, of which the velocity is sought.

    `base` is place, rotation vector and velocity without what the stage adds in `ah` [s]; `R` are
    the axes that the rotation vector begins at, `shift` and `azimuth` those of the contacts.

    """

    command: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
    base: np.ndarray
    ah: float
    R: np.ndarray
    shift: np.ndarray
    azimuth: np.ndarray


class _Evaluated(NamedTuple):
    """What comes of a velocity: residual, acceleration, place, rotation vector, axes, contacts."""

    residual: np.ndarray
    acceleration: np.ndarray
    C: np.ndarray
    theta: np.ndarray
    R: np.ndarray
    contacts: HoleContacts


@compiled
def turned(theta: np.ndarray) -> np.ndarray:
    """Return the rotation by a small vector, shape (3, 3)."""
    x, y, z = theta
    a2 = x * x + y * y + z * z
    # Of sin(a)/a and (1 - cos(a))/a^2; steps turn by milliradians.
    a, b = 1 - a2 / 6 * (1 - a2 / 20), 0.5 - a2 / 24 * (1 - a2 / 30)
    R = np.empty((3, 3))
    R[0, 0], R[1, 1], R[2, 2] = (
        1 - b * (y * y + z * z),
        1 - b * (x * x + z * z),
        1 - b * (x * x + y * y),
    )
    R[0, 1], R[1, 0] = b * x * y - a * z, b * x * y + a * z
    R[0, 2], R[2, 0] = b * x * z + a * y, b * x * z - a * y
    R[1, 2], R[2, 1] = b * y * z - a * x, b * y * z + a * x
    return R


@compiled
def _turning(theta, w):
    """Return the rate of a small rotation vector at an angular velocity."""
    x = theta[1] * w[2] - theta[2] * w[1]
    y = theta[2] * w[0] - theta[0] * w[2]
    z = theta[0] * w[1] - theta[1] * w[0]
    out = np.empty(3)
    out[0] = w[0] - x / 2 + (theta[1] * z - theta[2] * y) / 12
    out[1] = w[1] - y / 2 + (theta[2] * x - theta[0] * z) / 12
    out[2] = w[2] - z / 2 + (theta[0] * y - theta[1] * x) / 12
    return out


@compiled
def _evaluate(model, stage, V):
    p, base, ah = model.p, stage.base, stage.ah
    C = base[:3] + ah * V[:3]
    theta = base[3:6] + ah * V[3:]
    for _ in range(2):
        theta = base[3:6] + ah * _turning(theta, V[3:])
    R = turned(theta) @ stage.R
    F, M = pull(p, model.holder, stage.command, C, R, V)
    contacts = contact_forces(model, C, R, V, stage.shift, ah, stage.azimuth)
    acc = acceleration(p, F, M, C, R, V, contacts.points, contacts.forces)
    return _Evaluated(V - base[6:] - ah * acc, acc, C, theta, R, contacts)


@compiled
def _small(r):
    return np.abs(r[:3]).max() < _VELOCITY_RESIDUAL and np.abs(r[3:]).max() < _TURNING_RESIDUAL


@compiled
def _solve(model, stage, V, J):
    """Return whether a stage was solved, its velocity and the Jacobian used."""
    r = _evaluate(model, stage, V).residual
    for tried in range(_JACOBIANS + 1):
        size = np.abs(r).max()
        for _ in range(_ITERATIONS):
            if _small(r):
                return True, V, J
            trial = V - np.linalg.solve(J, r)
            new = _evaluate(model, stage, trial).residual
            if not np.abs(new).max() < 0.7 * size:
                break
            V, r, size = trial, new, np.abs(new).max()
        if _small(r):
            return True, V, J
        if tried == _JACOBIANS:
            break
        J = np.empty((6, 6))
        for j in range(6):
            step = 1e-7 if j < 3 else 1e-6
            there = V.copy()
            there[j] += step
            J[:, j] = (_evaluate(model, stage, there).residual - r) / step
        # The first step with a new Jacobian is taken as far as it helps.
        along = np.linalg.solve(J, r)
        length = 1.0
        for _ in range(8):
            trial = V - length * along
            new = _evaluate(model, stage, trial).residual
            if np.abs(new).max() < size:
                break
            length /= 2
        V, r = trial, new
    return False, V, J


@compiled
def _step(model, knots, coefficients, t, h, body):
    """Return whether a step succeeded, and the body behind it."""
    C, R, V, acc, shift, slips, azimuth, J = body
    ah = _TRAPEZOIDAL_PART / 2 * h
    base = np.empty(12)
    base[:3], base[3:6], base[6:] = C + ah * V[:3], ah * V[3:], V + ah * acc
    command = commanded(model.p, knots, coefficients, t + _TRAPEZOIDAL_PART * h)
    stage = _Stage(command, base, ah, R, shift + ah * slips, azimuth)
    good, V1, J = _solve(model, stage, V, J)
    if not good:
        return False, body
    half = _evaluate(model, stage, V1)
    one = 1 / (_TRAPEZOIDAL_PART * (2 - _TRAPEZOIDAL_PART))
    two = one - 1
    base[:3], base[3:6], base[6:] = one * half.C - two * C, one * half.theta, one * V1 - two * V
    command = commanded(model.p, knots, coefficients, t + h)
    strained = one * half.contacts.strained - two * shift
    stage = _Stage(command, base, ah, R, strained, half.contacts.azimuth)
    good, V2, J = _solve(model, stage, V1 + (1 - _TRAPEZOIDAL_PART) * h * half.acceleration, J)
    if not good:
        return False, body
    end = _evaluate(model, stage, V2)
    contacts = end.contacts
    return True, Body(
        end.C, end.R, V2, end.acceleration, contacts.strained, contacts.slips, contacts.azimuth, J
    )


@compiled
def advance(
    model: HoleModel,
    knots: np.ndarray,
    coefficients: np.ndarray,
    t: float,
    end: float,
    largest: float,
    body: Body,
) -> tuple[bool, Body]:
    """
    Return whether a later time was reached, and the body then, or where it stayed.

    Parameters
    ----------
    model : HoleModel
    knots, coefficients : ndarray
        Of the commanded place, for `hole_forces.commanded`.
    t, end, largest : float
        From when until when, and the largest step [s].
    body : Body
        At t; its Jacobian is that of an earlier step, to begin with.

    """
    number = max(1, int(np.ceil((end - t) / largest - 1e-6)))
    h, left = (end - t) / number, 0
    whole, done, level = h, 0.0, 0
    while done < end - t - 1e-12:
        good, body = _step(model, knots, coefficients, t + done, h, body)
        if good:
            done += h
            left -= 1
            if level and left <= 0:
                # Back to the whole step where its grid is met.
                level, h = 0, whole
        else:
            if level == _HALVINGS:
                return False, body
            left = 2 * max(left, 1) if level else 2
            level += 1
            h /= 2
    return True, body
