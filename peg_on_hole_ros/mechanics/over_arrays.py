"""The compiled six equations over arrays of states."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.geometry import contact_geometry
from peg_on_hole_ros.mechanics.kernel import accelerate, compiled, scene_scalars, workspace
from peg_on_hole_ros.mechanics.scene import Scene


class Solutions(NamedTuple):
    """
    Solutions of the six equations, time last.

    Attributes
    ----------
    acceleration : ndarray, shape (3, n)
        gamma'', psi'', phi'' [rad/s^2].
    normal : ndarray, shape (3, n)
        N_K, N_B1, N_B2 [N]; a negative one belongs to a contact that has opened.
    determinant : ndarray, shape (n,)
        Over its frictionless value; 0 or less is wedged.

    """

    acceleration: np.ndarray
    normal: np.ndarray
    determinant: np.ndarray


def solve_many(
    scene: Scene,
    q: ArrayLike,
    rates: ArrayLike,
    wrench_P: ArrayLike,
    slip_velocity_scale: float = 0.0,
) -> Solutions:
    """
    Return motion and reactions of many states.

    Parameters
    ----------
    scene : Scene
    q, rates : array_like, shape (3, n)
        gamma, psi, phi [rad] and their rates [rad/s].
    wrench_P : array_like, shape (6, n) or (6,)
        Applied force and moment about the mass centre, peg axes [N], [N m].
    slip_velocity_scale : float
        Of the regularised friction law [m/s]; 0 is Coulomb's.

    Returns
    -------
    Solutions

    Raises
    ------
    PegOnHoleError
        Where a state or wrench is not finite, or a tilt has no three-point contact, or a peg at
        rest has no direction of slip under Coulomb's law.

    """
    q, rates, wrench_P = (np.asarray(x, float) for x in (q, rates, wrench_P))
    if q.ndim != 2 or q.shape[0] != 3 or rates.shape[0] != 3 or wrench_P.shape[0] != 6:
        raise PegOnHoleError(
            f"shapes {q.shape}, {rates.shape}, {wrench_P.shape} are not (3, n), (3, n), (6, n): "
            "components come first, states last"
        )
    n = q.shape[1]
    states = np.empty((n, 12))
    states[:, :3] = q.T
    states[:, 3:6] = np.broadcast_to(rates.T, (n, 3))
    states[:, 6:] = np.broadcast_to(wrench_P.T, (n, 6))
    bad = ~np.all(np.isfinite(states), axis=1)
    if np.any(bad):
        raise PegOnHoleError(f"state {int(np.argmax(bad))} of {n} is not finite: {states[bad][0]}")
    contact_geometry(scene, q[0])
    scales = np.full(3, float(slip_velocity_scale))
    answers = np.empty((n, 7))
    _fill(scene_scalars(scene), scales, states, workspace(), answers)
    bad = ~np.all(np.isfinite(answers), axis=1)
    if np.any(bad):
        raise PegOnHoleError(
            f"state {int(np.argmax(bad))} of {n} has no solution: {states[bad][0]}; a contact at "
            "rest needs slip_velocity_scale above 0 m/s"
        )
    return Solutions(answers[:, :3].T, answers[:, 3:6].T, answers[:, 6])


@compiled
def _fill(p, scales, states, work, answers):
    for k in range(states.shape[0]):
        row = states[k]
        answers[k, 6] = accelerate(p, scales, row[:6], row[6:], work, answers[k, :6])
