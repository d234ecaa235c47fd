"""Forward kinematics of a robot by screws: pose and Jacobian of its tip, for many joint states."""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled


class ScrewChain(NamedTuple):
    """
    Joints between a robot's base and its tip, as screws where all joints are at zero.

    Pose of the tip = product of the exponentials of the screws, from the base on, times its pose
    at zero (K. M. Lynch and F. C. Park, Modern Robotics, 2017, section 4.1).

    Attributes
    ----------
    turn : ndarray, shape (m, 3)
        Unit axis of each joint that turns, base axes; zero of one that slides.
    slide : ndarray, shape (m, 3)
        Velocity, per unit rate, of the point that lies in the base's origin, base axes [m].
    source : ndarray of int, shape (m,)
        Which of the n positions that are read moves the joint.
    multiplier, offset : ndarray, shape (m,)
        Position of the joint = multiplier * position that is read + offset.
    rotation : ndarray, shape (3, 3)
        Tip axes in base axes at zero.
    position : ndarray, shape (3,)
        Of the tip's origin at zero [m].

    """

    turn: np.ndarray
    slide: np.ndarray
    source: np.ndarray
    multiplier: np.ndarray
    offset: np.ndarray
    rotation: np.ndarray
    position: np.ndarray


class TipPoses(NamedTuple):
    """
    Where a robot's joints turn and carry its tip, for s joint states of n joints.

    Attributes
    ----------
    rotation : ndarray, shape (s, 3, 3)
        R_RT, axes of the tip frame in those of the robot's base.
    jacobian : ndarray, shape (s, 3, n)
        Angular velocity of the tip, base axes, per unit rate of each joint that was asked for.
    position : ndarray, shape (s, 3)
        Of the tip frame's origin, base axes; NaN: not known [m].
    velocities : ndarray, shape (s, 3, n)
        Its velocity per unit rate of each joint.

    """

    rotation: np.ndarray
    jacobian: np.ndarray
    position: np.ndarray
    velocities: np.ndarray


def empty_poses(states: int, joints: int) -> TipPoses:
    """Return poses to be filled in, of so many joint states of so many joints."""
    return TipPoses(
        np.empty((states, 3, 3)),
        np.zeros((states, 3, joints)),
        np.full((states, 3), np.nan),
        np.zeros((states, 3, joints)),
    )


def tip_poses(chain: ScrewChain, positions: np.ndarray) -> TipPoses:
    """
    Return the poses of the tip.

    Parameters
    ----------
    chain : ScrewChain
    positions : ndarray, shape (s, n)
        Of the joints that are read [rad or m].

    """
    poses = empty_poses(*positions.shape)
    _fill_poses(chain, positions, poses, np.empty((len(chain.source), 6)))
    return poses


@compiled
def _fill_poses(chain, positions, poses, screws):
    E, R, turned = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    p, moved = np.empty(3), np.empty(3)
    for s in range(len(positions)):
        R[:] = 0.0
        for i in range(3):
            R[i, i], p[i] = 1.0, 0.0
        for j in range(len(chain.source)):
            _carry_screw(R, p, chain.turn[j], chain.slide[j], screws[j])
            x = chain.multiplier[j] * positions[s, chain.source[j]] + chain.offset[j]
            _exponential(chain.turn[j], chain.slide[j], x, E, moved)
            _times_vector(R, moved, turned[0])
            for i in range(3):
                p[i] += turned[0, i]
            _times_matrix(R, E, turned)
            R[:] = turned
        _times_matrix(R, chain.rotation, poses.rotation[s])
        _times_vector(R, chain.position, moved)
        x, y, z = moved[0] + p[0], moved[1] + p[1], moved[2] + p[2]
        poses.position[s, 0], poses.position[s, 1], poses.position[s, 2] = x, y, z
        for j in range(len(chain.source)):
            a, b, c = screws[j, 0], screws[j, 1], screws[j, 2]
            velocity = (
                screws[j, 3] + b * z - c * y,
                screws[j, 4] + c * x - a * z,
                screws[j, 5] + a * y - b * x,
            )
            for i in range(3):
                rate = chain.multiplier[j]
                poses.jacobian[s, i, chain.source[j]] += rate * screws[j, i]
                poses.velocities[s, i, chain.source[j]] += rate * velocity[i]


@compiled
def _carry_screw(R, p, turn, slide, screw):
    """Fill in a screw, axis first, as the joints before it have carried it."""
    _times_vector(R, turn, screw[:3])
    _times_vector(R, slide, screw[3:])
    a, b, c = screw[0], screw[1], screw[2]
    screw[3] += p[1] * c - p[2] * b
    screw[4] += p[2] * a - p[0] * c
    screw[5] += p[0] * b - p[1] * a


@compiled
def _exponential(turn, slide, x, E, moved):
    """Fill in rotation and displacement of a screw by x [rad or m]."""
    a, b, c = turn[0], turn[1], turn[2]
    if a == 0.0 and b == 0.0 and c == 0.0:
        for i in range(3):
            moved[i] = slide[i] * x
            for j in range(3):
                E[i, j] = 1.0 if i == j else 0.0
        return
    s, v = sin(x), 2.0 * sin(0.5 * x) ** 2
    co = cos(x)
    E[0, 0], E[0, 1], E[0, 2] = co + v * a * a, v * a * b - s * c, v * a * c + s * b
    E[1, 0], E[1, 1], E[1, 2] = v * a * b + s * c, co + v * b * b, v * b * c - s * a
    E[2, 0], E[2, 1], E[2, 2] = v * a * c - s * b, v * b * c + s * a, co + v * c * c
    # A point of the axis, and what goes along it.
    q = (
        b * slide[2] - c * slide[1],
        c * slide[0] - a * slide[2],
        a * slide[1] - b * slide[0],
    )
    along = (a * slide[0] + b * slide[1] + c * slide[2]) * x
    for i in range(3):
        moved[i] = q[i] + turn[i] * along
        for j in range(3):
            moved[i] -= E[i, j] * q[j]


@compiled
def _times_vector(A, v, out):
    for i in range(3):
        out[i] = A[i, 0] * v[0] + A[i, 1] * v[1] + A[i, 2] * v[2]


@compiled
def _times_matrix(A, B, out):
    for i in range(3):
        for j in range(3):
            out[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]
