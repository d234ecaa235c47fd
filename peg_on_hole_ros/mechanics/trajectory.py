"""A trajectory through three-point contact, the transition at gamma0, and two-point contact."""

from collections.abc import Callable
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.checks import require_finite
from peg_on_hole_ros.mechanics.reference import six_equations
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.mechanics.two_point import insertion_length, solve_two_point

# So close to gamma0 the pose changes its description: rates and pose are continuous there, and the
# step across moves a point by 1e-11 m at most.
_EDGE = 1e-10


class Ending(Enum):
    """Why a trajectory ended; the values are advice."""

    TIME = "the time was over"
    CONTACT_OPEN = "a reaction became negative: that contact opens, see `solve_unilateral`"
    WEDGED = "the reactions' matrix became singular: rigid motion ends here"
    LEVEL = "the peg lies down: no three-point contact at a right angle"
    FREE = "K reached the peg's upper end: the peg is free in the hole"
    FAILED = "the integrator could not go on: state the friction law with a larger velocity scale"


class Trajectory(NamedTuple):
    """
    A motion over time.

    Attributes
    ----------
    t : ndarray, shape (n,)
        [s].
    q, rates : ndarray, shape (3, n)
        gamma, psi, phi [rad] and their rates [rad/s].
    normal : ndarray, shape (3, n)
        N_K, N_B1, N_B2 [N]; in two-point contact N_B stands half in each.
    lateral_force : ndarray, shape (n,)
        Force along e at O that keeps the two-point pose symmetric [N]; zero in three-point
        contact, where N_B1 - N_B2 is that force.
    two_point : ndarray of bool, shape (n,)
    transition : float or None
        Time at which gamma passed gamma0 last [s].
    ending : Ending

    """

    t: np.ndarray
    q: np.ndarray
    rates: np.ndarray
    normal: np.ndarray
    lateral_force: np.ndarray
    two_point: np.ndarray
    transition: float | None
    ending: Ending


def integrate(
    scene: Scene,
    q: ArrayLike,
    rates: ArrayLike,
    duration: float,
    wrench_P: Callable | None = None,
    slip_velocity_scale: float = 1e-5,
    samples: int = 200,
) -> Trajectory:
    """
    Integrate the peg's motion, in three-point contact and, held symmetric, in two-point contact.

    Parameters
    ----------
    scene : Scene
    q, rates : array_like, shape (3,)
        Start: gamma, psi, phi [rad] and their rates [rad/s]; gamma on either side of gamma0.
    duration : float
        [s].
    wrench_P : callable, optional
        wrench_P(t, q, rates) -> array, shape (6,): force and moment about the mass centre, peg
        axes [N], [N m]; none by default.
    slip_velocity_scale : float
        Of the regularised friction law [m/s]: the law is stiff, and Radau's method takes it.
    samples : int
        Number of times, in even steps, beside the ends.

    Returns
    -------
    Trajectory

    Raises
    ------
    PegOnHoleError
        Where the duration is not positive, or the start has neither contact.

    """
    if not np.isfinite(duration) or duration <= 0:
        raise PegOnHoleError(f"duration = {duration:g} s is not above 0")
    wrench_P = wrench_P or (lambda t, q, rates: np.zeros(6))
    q = require_finite("state", "rad", q, 3)
    x, t = np.concatenate([q, require_finite("rates", "rad/s", rates, 3)]), 0.0
    below = bool(x[0] <= scene.gamma0)
    pieces, transition = [], None
    for _ in range(_MOST_PIECES):
        solve = _two_point if below else _three_point

        def slope(t, x, solve=solve):
            return np.concatenate([x[3:], solve(scene, t, x, wrench_P, slip_velocity_scale)[0]])

        if np.min(solve(scene, t, x, wrench_P, slip_velocity_scale)[1]) < 0:
            pieces.append((np.array([t]), x[:, None], below))
            ending = Ending.CONTACT_OPEN
            break
        events = _events(scene, below, solve, wrench_P, slip_velocity_scale)
        run = solve_ivp(
            slope, (t, duration), x, "Radau", events=[e for e, _ in events], dense_output=True,
            jac=_jacobian(slope), rtol=1e-8, atol=1e-10,
        )  # fmt: skip
        grid = np.linspace(0, duration, samples + 1)
        times = np.unique([t, *grid[(grid > t) & (grid < run.t[-1])], run.t[-1]])
        pieces.append((times, run.sol(times), below))
        t, x = run.t[-1], run.y[:, -1].copy()
        if run.status != 1:
            ending = Ending.TIME if run.status == 0 else Ending.FAILED
            if ending is Ending.FAILED and _grown(
                scene, solve, t, x, wrench_P, slip_velocity_scale
            ):
                ending = Ending.WEDGED
            break
        ending = next(name for (_, name), hit in zip(events, run.t_events) if hit.size)
        if ending is not None:
            break
        transition, below = float(t), not below
        x[0] = scene.gamma0 + (-_EDGE if below else _EDGE)
    else:
        ending = Ending.FAILED
    return _gather(scene, pieces, wrench_P, slip_velocity_scale, transition, ending)


# A peg that rocks about gamma0 passes it many times; more is a loop without an end.
_MOST_PIECES = 50


def _jacobian(slope):
    """Return the slope's derivatives by fixed steps; scipy's own grow where nothing depends."""
    steps = np.array([1e-9, 1e-7, 1e-7, 1e-8, 1e-8, 1e-8])

    def jacobian(t, x):
        columns = [
            slope(t, x + h * unit) - slope(t, x - h * unit) for h, unit in zip(steps, np.eye(6))
        ]
        return np.array(columns).T / (2 * steps)

    return jacobian


def _three_point(scene, t, x, wrench_P, scale):
    """Return accelerations, three reactions and the lateral force; beyond gamma0 those at it."""
    q, rates = x[:3].copy(), x[3:]
    q[0] = max(q[0], scene.gamma0 + _EDGE / 2)
    y = np.linalg.solve(*six_equations(scene, q, rates, wrench_P(t, q, rates), scale))
    return y[:3], y[3:], 0.0


def _two_point(scene, t, x, wrench_P, scale):
    q, rates = np.append(x[:3], 0.0), np.append(x[3:], 0.0)
    q[0] = min(q[0], scene.gamma0 - _EDGE / 2)
    found = solve_two_point(scene, q, rates, wrench_P(t, x[:3], x[3:]), scale, held=True)
    N_K, N_B = found.normal
    return found.acceleration[:3], np.array([N_K, N_B / 2, N_B / 2]), found.lateral_force


def _events(scene, below, solve, wrench_P, scale):
    """Return event functions and the ending that each stands for; None: the contact changes."""

    def edge(t, x):
        return x[0] - scene.gamma0

    def pressing(t, x):
        return np.min(solve(scene, t, x, wrench_P, scale)[1])

    def lying(t, x):
        return np.pi / 2 - 1e-3 - x[0]

    def leaving(t, x):
        return scene.peg_height - insertion_length(scene, x[0])

    def regular(t, x):
        q, rates = x[:3].copy(), x[3:]
        q[0] = max(q[0], scene.gamma0 + _EDGE / 2)
        A, _ = six_equations(scene, q, rates, np.zeros(6), scale)
        inner = A[3:, 3:] - A[3:, :3] @ np.linalg.solve(A[:3, :3], A[:3, 3:])
        return np.linalg.det(inner / np.linalg.norm(inner, axis=0))

    edge.direction = 1 if below else -1  # type: ignore[attr-defined]
    pressing.direction = leaving.direction = lying.direction = -1  # type: ignore[attr-defined]
    chosen = [(edge, None), (pressing, Ending.CONTACT_OPEN)]
    chosen += (
        [(leaving, Ending.FREE)] if below else [(lying, Ending.LEVEL), (regular, Ending.WEDGED)]
    )
    for event, _ in chosen:
        event.terminal = True  # type: ignore[attr-defined]
    return chosen


def _grown(scene, solve, t, x, wrench_P, scale):
    """Return whether the reactions grew out of all proportion: the singular set is reached."""
    load = np.linalg.norm(wrench_P(t, x[:3], x[3:])[:3])
    load += scene.peg_mass * np.linalg.norm(scene.gravity)
    return np.max(np.abs(solve(scene, t, x, wrench_P, scale)[1])) > 1e3 * load


def _gather(scene, pieces, wrench_P, scale, transition, ending):
    normal, lateral = [], []
    for times, states, below in pieces:
        solve = _two_point if below else _three_point
        for t, x in zip(times, states.T):
            _, N, force = solve(scene, t, x, wrench_P, scale)
            normal.append(N)
            lateral.append(force)
    states = np.concatenate([piece[1] for piece in pieces], axis=1)
    sides = np.concatenate([np.full(len(times), below) for times, _, below in pieces])
    return Trajectory(
        np.concatenate([piece[0] for piece in pieces]),
        states[:3],
        states[3:],
        np.array(normal).T,
        np.array(lateral),
        sides,
        transition,
        ending,
    )
