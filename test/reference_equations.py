"""The measurements of the estimator in plain numpy: residuals, slopes by complex steps, noise."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from peg_on_hole_ros.estimator import state
from peg_on_hole_ros.estimator.friction_direction import (
    friction_direction_statistics,
    slip_statistics,
)
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.estimator.state import ACCELERATION, FRICTION, RATE
from peg_on_hole_ros.estimator.tuned import SCENE_AT_MEAN_BOUNDS
from peg_on_hole_ros.mechanics.geometry import (
    ClosedForms,
    contact_geometry,
    normals,
    velocity_jacobians,
)
from peg_on_hole_ros.mechanics.kernel import SceneScalars
from peg_on_hole_ros.mechanics.reference import (
    peg_axes,
    precession_axes,
    six_equations,
    wrench_axes,
)
from peg_on_hole_ros.mechanics.scene import Scene


class Cell(NamedTuple):
    """
    What is fixed while a scene is estimated.

    Attributes
    ----------
    scene : Scene
    settings : Settings
    open_quantities : tuple of str
        Of `state.OPENABLE_QUANTITIES`.
    wrench_noise, bias_map : ndarray, shape (6, 6)
        See `FilterRecord`.
    walk : ndarray, shape (n,)
        See `FilterRecord`.
    learnt : ndarray, shape (n + 3,)
        See `FilterRecord.estimated`.

    """

    scene: Scene
    settings: Settings
    open_quantities: tuple[str, ...]
    wrench_noise: np.ndarray
    bias_map: np.ndarray
    walk: np.ndarray
    learnt: np.ndarray

    @property
    def n(self) -> int:
        """How many values stand before the reactions."""
        return len(self.walk)

    def value(self, x: np.ndarray, quantity: str) -> np.ndarray:
        """Return an open quantity out of the mean, zero where it is known."""
        first = getattr(state.places_of(self.open_quantities), quantity)
        width = state.OPENABLE_QUANTITIES[quantity]
        return x[first : first + width] if first >= 0 else np.zeros(width)

    def is_open(self, quantity: str) -> bool:
        """Whether a quantity has a place in the mean."""
        return quantity in self.open_quantities


class OpenScene(NamedTuple):
    """A `Scene` whose numbers may be complex, with a friction for each contact, shape (3, 1)."""

    peg_diameter: complex
    hole_diameter: float
    mass_center_height: float
    gamma0: complex
    peg_mass: float
    transverse_inertia: float
    axial_inertia: float
    friction: np.ndarray
    gravity: np.ndarray


class Linear(NamedTuple):
    """A measurement at one point: residual = E (truth - point) + noise of covariance R."""

    residual: np.ndarray
    E: np.ndarray
    R: np.ndarray


def slopes(function: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> np.ndarray:
    """Return how a function moves with each entry of x, by complex steps, shape (k, len(x))."""
    tiny = 1e-30
    moved = [function(x + 1j * tiny * unit).imag / tiny for unit in np.eye(len(x))]
    return np.stack(moved, axis=1)


def _within(value, low, high):
    """Bound a value by its real part; its slopes are those inside."""
    return value + (np.clip(np.real(value), low, high) - np.real(value))


def open_scene(cell: Cell, x: np.ndarray, load: float) -> OpenScene:
    """Return the scene at a mean: diameter, frictions and gravity as they are taken to be."""
    scene = cell.scene
    clearance = scene.hole_diameter - scene.peg_diameter
    most_log = SCENE_AT_MEAN_BOUNDS.most_log_clearance
    clearance *= np.exp(_within(cell.value(x, "clearance")[0], -most_log, most_log))
    taken = cell.value(x, "compliance")[0] * load
    clearance = _within(clearance - taken, SCENE_AT_MEAN_BOUNDS.least_clearance, np.inf)
    gamma0 = 2 * np.arcsin(np.sqrt(clearance / (2 * scene.hole_diameter)))
    frictions = x[FRICTION] + np.array([[1.0], [0.0], [0.0]]) * cell.value(x, "friction_k")
    return OpenScene(
        scene.hole_diameter - clearance,
        scene.hole_diameter,
        scene.mass_center_height,
        gamma0,
        scene.peg_mass,
        scene.transverse_inertia,
        scene.axial_inertia,
        frictions,
        _gravity(cell, x),
    )


def _gravity(cell, x):
    """Return gravity in a hole that is turned by its tilt."""
    g = np.array(cell.scene.gravity)
    return g - np.cross(np.append(cell.value(x, "tilt"), 0.0), g)


def _tilts(scene):
    """Return the least and the greatest tilt at which the equations are taken."""
    bounds = SCENE_AT_MEAN_BOUNDS
    return np.real(scene.gamma0) + bounds.nearest_tilt, bounds.steepest_tilt


def _balance(cell, x, u, load, scales):
    """Return left less right side of the six equations, shape (6,)."""
    scene, n = open_scene(cell, x, load), cell.n
    gamma = _within(x[0], *_tilts(scene))
    q = np.array([gamma, x[1], x[2]])
    wrench = u - cell.bias_map @ cell.value(x, "bias")
    A, r = six_equations(scene, q, x[RATE : RATE + 3], wrench, scales)
    acceleration = cell.settings.inertia * x[ACCELERATION : ACCELERATION + 3]
    return A @ np.concatenate([acceleration, x[n:]]) - r


def contact(
    cell: Cell,
    x: np.ndarray,
    P: np.ndarray,
    u: np.ndarray,
    load: float,
    friction_force2: np.ndarray,
) -> tuple[Linear, np.ndarray, float, np.ndarray]:
    """
    Return the six equations at a mean, and the noise of friction whose direction is unknown.

    Slopes are taken at the wrench with which the equations hold, whose noise is not the sensor's.
    The last but one is how far the slip may point elsewhere, see `friction_direction_statistics`.

    Parameters
    ----------
    cell : Cell
    x : ndarray, shape (n + 3,)
    P : ndarray, shape (n + 3, n + 3)
    u : ndarray, shape (6,)
        Wrench on the peg about its mass centre, peg axes [N], [N m].
    load : float
        [N].
    friction_force2 : ndarray, shape (3,)
        [N^2].

    """
    scene = open_scene(cell, x, load)
    geometry = contact_geometry(scene, np.clip(x[0], *_tilts(scene)))
    scales, left = np.zeros(3), np.zeros(3)
    forms = ClosedForms(*geometry[1:])
    turned = friction_direction_statistics.py_func(
        _scalars(scene), forms, x, P, cell.settings.direction_share, scales, left
    )
    residual = -_balance(cell, x, u, load, scales)
    W = slopes(lambda u: _balance(cell, x, u, load, scales), u)
    expected = u + np.linalg.solve(W, residual)
    E = slopes(lambda x: _balance(cell, x, expected, load, scales), x)
    unknown, by_friction = np.zeros((6, 6)), np.zeros((6, 3))
    jacobians = velocity_jacobians(geometry, scene.peg_diameter, scene.hole_diameter)
    for i, (J, normal, amount) in enumerate(
        zip(jacobians, normals(geometry), 0.5 * left * friction_force2)
    ):
        reach, v = np.vstack([J.T, np.eye(3)]), J @ x[RATE : RATE + 3]
        unknown += amount * reach @ (np.eye(3) - np.outer(normal, normal)) @ reach.T
        by_friction[:, i] = reach @ v / np.sqrt(v @ v + scales[i] ** 2)
    return Linear(residual, E, W @ cell.wrench_noise @ W.T), unknown, turned, by_friction


def two_points(
    cell: Cell,
    x: np.ndarray,
    P: np.ndarray,
    u: np.ndarray,
    load: float,
    friction_force2: np.ndarray,
    level: float,
) -> tuple[Linear, np.ndarray, float, np.ndarray]:
    """
    Return the balance of a peg on K and B in the hole; else as `contact`, for a level.

    Written with vectors in (h, e, z) about the mass centre; the slip's way and what accelerations
    take are those at the mean.
    """
    o = cell.settings

    def geometry(x):
        scene = open_scene(cell, x, -load)
        d, D = scene.peg_diameter, scene.hole_diameter
        least = (D - d) / (2 * scene.mass_center_height)
        gamma = _within(x[0], np.real(least), np.real(scene.gamma0))
        s, c = np.sin(gamma), np.cos(gamma)
        length = (D - d * c) / s
        way = (d - D * c) / s**2
        zeta, eta = np.array([-s, 0, c]), np.array([c, 0, s])
        # From the centre of the lower end: B on the edge, K up the side.
        centre = scene.mass_center_height * zeta
        arms = -d / 2 * eta + length * zeta - centre, d / 2 * eta - centre
        along = np.array([0, D / 2, 0]), np.array([0, d / 2, 0])
        slips = (
            np.column_stack([-way * zeta, -along[0], -along[1]]),
            np.column_stack([[0, 0, D - c * way], *along]),
        )
        return scene, gamma, arms, (eta, np.array([-1.0, 0, 0])), slips

    scene, gamma, arms, faces, slips = geometry(x)
    zeta = np.array([-np.sin(gamma), 0, np.cos(gamma)])
    moments = [slip_statistics.py_func(J, x, P, o.direction_share) for J in slips]
    m, Ie, Iz = scene.peg_mass, scene.transverse_inertia, scene.axial_inertia
    up, across = np.array([0, 0, 1.0]), np.array([0, -1.0, 0])
    tensor = Ie * np.eye(3) + (Iz - Ie) * np.outer(zeta, zeta)
    h_c = scene.hole_diameter / 2 - arms[1][0]
    inertia = np.zeros((6, 3))
    inertia[0, 0], inertia[1, 1] = m * arms[1][2], m * h_c
    inertia[3:] = tensor @ np.column_stack([across, up, zeta])

    def balance(x, u=u):
        scene, gamma, arms, faces, _ = geometry(x)
        to_hez = wrench_axes(gamma, x[2])
        wrench = u - cell.bias_map @ cell.value(x, "bias")
        weight = scene.peg_mass * precession_axes(x[1]).T @ scene.gravity
        left = o.inertia * inertia @ x[ACCELERATION : ACCELERATION + 3]
        left = left - np.concatenate([to_hez @ wrench[:3] + weight, to_hez @ wrench[3:]])
        loads = x[cell.n], x[cell.n + 1] + x[cell.n + 2]
        frictions = scene.friction[0, 0], scene.friction[1, 0]
        for N, f, r, normal, J, (_, _, scale2) in zip(
            loads, frictions, arms, faces, slips, moments
        ):
            v = J @ x[RATE : RATE + 3]
            force = N * (normal - f * v / np.sqrt(v @ v + scale2))
            left = left - np.concatenate([force, np.cross(r, force)])
        return left

    W = slopes(lambda u: balance(x, u), u)
    R = W @ cell.wrench_noise @ W.T
    # Along the hole it speeds up as it turns.
    R[2, 2] += (2 * cell.scene.peg_mass * cell.scene.mass_center_height * level) ** 2
    crossing = (arms[0] + arms[1]) / 2
    lateral = np.append([0, 1.0, 0], np.cross(crossing, [0, 1.0, 0]))
    R += load**2 * np.outer(lateral, lateral)
    unknown, by_friction = np.zeros((6, 6)), np.zeros((6, 3))
    squares = friction_force2[0], 2 * (friction_force2[1] + friction_force2[2])
    for k, (square, r, normal, (_, left, scale2)) in enumerate(zip(squares, arms, faces, moments)):
        reach, v = np.vstack([np.eye(3), -np.cross(np.eye(3), r).T]), slips[k] @ x[RATE : RATE + 3]
        unknown += 0.5 * left * square * reach @ (np.eye(3) - np.outer(normal, normal)) @ reach.T
        # N_B is two halves.
        by_friction[:, [0] if k == 0 else [1, 2]] = (reach @ v / np.sqrt(v @ v + scale2))[:, None]
    turned = (moments[0][0] + moments[1][0]) / 2
    expected = u - np.linalg.solve(W, balance(x))
    linear = Linear(-balance(x), slopes(lambda x: balance(x, expected), x.astype(complex)), R)
    return linear, unknown, turned, by_friction


def _scalars(scene: OpenScene) -> SceneScalars:
    return SceneScalars(*scene[:7], scene.friction[1, 0], *scene.gravity)


def _walked(cell, dt):
    """Return the variance of the force of a holder whose speed walks, over a sample [N^2]."""
    return (cell.scene.peg_mass * cell.settings.free_walk) ** 2 / max(dt, 1e-4)


def hanging(cell: Cell, x: np.ndarray, at: np.ndarray, u: np.ndarray, dt: float) -> Linear:
    """
    Return the mean balance of a peg that nothing touches; how its holder moves it is noise.

    Parameters
    ----------
    cell : Cell
    x : ndarray, shape (n + 3,)
    at : ndarray, shape (k, n + 3)
        Means at its wrenches. A weight tells nothing of angles that orientations tell far better.
    u : ndarray, shape (k, 6)
    dt : float
        Between two wrenches [s].

    """
    o, scene, to_peg = cell.settings, cell.scene, [peg_axes(x[:3]).T for x in at]

    def balance(x):
        weight = np.mean(to_peg, axis=0) * scene.peg_mass @ _gravity(cell, x)
        bias = cell.bias_map @ cell.value(x, "bias")
        return u.mean(axis=0) + np.append(weight, np.zeros(3)) - bias

    turned = max(o.mode_time[o.modes - 1] / max(dt, 1e-4), 1.0)
    turned *= (scene.transverse_inertia * o.mode_stddev[o.modes // 2]) ** 2
    R = cell.wrench_noise + np.diag([_walked(cell, dt)] * 3 + [turned] * 3)
    return Linear(-balance(x), slopes(balance, x), R / len(u))


def orientation(cell: Cell, x: np.ndarray, q: np.ndarray, R: np.ndarray) -> Linear:
    """
    Return an orientation at a mean.

    A hole that is tilted is measured as a peg that is turned; one that is stamped too late by a
    delay is where the peg was.

    Parameters
    ----------
    cell : Cell
    x : ndarray, shape (n + 3,)
    q : ndarray, shape (3,)
        gamma, psi, phi [rad], psi and phi to whole turns.
    R : ndarray, shape (3, 3)
        Covariance [rad^2].

    """
    delay, tilt = cell.value(x, "delay"), cell.value(x, "tilt")
    back = Rotation.from_rotvec([*-tilt, 0.0]).as_matrix()
    residual = _angles(back @ peg_axes(q)).real - x[:3] + x[RATE : RATE + 3] * delay
    residual[1:] -= 2 * np.pi * np.round(residual[1:] / (2 * np.pi))

    def expected(value):
        a, b = cell.value(value, "tilt") - tilt
        turned = np.array([[1, 0, b], [0, 1, -a], [-b, a, 1]]) @ peg_axes(x[:3])
        moved = value[:3] - value[RATE : RATE + 3] * cell.value(value, "delay")
        return moved + _angles(turned)

    return Linear(residual, slopes(expected, x.astype(complex)), R)


def _angles(axes):
    """Return gamma, psi, phi of peg axes, which may carry a complex step."""
    lean = np.sqrt(axes[2, 0] ** 2 + axes[2, 1] ** 2)
    sides = (axes[2, 2], lean), (-axes[0, 2], -axes[1, 2]), (axes[2, 0], -axes[2, 1])
    # arctan2 takes no complex values.
    return np.array(
        [
            np.arctan2(y.real, x.real)
            + 1j * (x.real * y.imag - y.real * x.imag) / abs(x**2 + y**2)
            for x, y in sides
        ]
    )
