"""Random scenes for the ladder of models: a peg, a hole, a held motion, and its solution."""

from typing import NamedTuple

import numpy as np
from peg_on_hole_ros.ladder import reference
from peg_on_hole_ros.study.steps import ROS3P, SCRATCH, advance
from scipy.interpolate import CubicSpline

from peg_on_hole_ros.mechanics.kernel import (
    SceneScalars,
    accelerate,
    compiled,
    scene_scalars,
    workspace,
)
from peg_on_hole_ros.mechanics.reference import six_equations
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.study.problems import balancing_wrench

INTERVAL = 1e-3
SAMPLES = 250
SCALE = 2e-5
TOLERANCES = (0.01, 0.02, 0.05, 0.1, 0.2)
# The truth's steps per sample; two in a row have to agree in the reactions, over the largest. A
# motion sticks and slips too finely to be followed where they do not: it ends there.
STEPS = (16, 32, 128, 256)
CONVERGED_TO = 1e-4
# Nearer to singular, rigid motion ends within a sample or two.
LEAST_DETERMINANT = 0.01
# Scenes in which less than this much time passes before rigid motion ends are drawn anew.
LEAST_SAMPLES = 20


class Drawn(NamedTuple):
    """
    One scene with its truth, a row a sample.

    Attributes
    ----------
    scene : Scene
    p : SceneScalars
    tolerance : float
        Of each reaction, over the largest [-].
    interval : float
        Between samples [s]; 0 for a scene that is one instant.
    states : ndarray, shape (n + 1, 6)
        gamma, psi, phi [rad] and rates [rad/s]; the first is the start.
    wrenches : ndarray, shape (n + 1, 6)
        About the mass centre, peg axes [N], [N m].
    normal : ndarray, shape (n + 1, 3)
        N_K, N_B1, N_B2 [N].
    kind : str
        What was drawn, for tables.
    redrawn : int
        Draws that had no motion, before this one.

    """

    scene: Scene
    p: SceneScalars
    tolerance: float
    interval: float
    states: np.ndarray
    wrenches: np.ndarray
    normal: np.ndarray
    kind: str
    redrawn: int


def _log(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw(seed: int, index: int) -> Drawn:
    """Return a scene; the same seed and index give the same one."""
    rng = np.random.default_rng([seed, index])
    for redrawn in range(100):
        found = _draw(rng, redrawn)
        if found is not None:
            return found
    raise RuntimeError(f"scene {index} of seed {seed}: 100 draws without a motion")


def _scene(rng):
    D = _log(rng, 0.005, 0.1)
    d = D * (1 - _log(rng, 2e-4, 1e-2))
    H = D * _log(rng, 0.5, 4)
    steel = 7800 * np.pi / 4 * d**2 * H
    tilted = rng.random() < 0.2
    direction = rng.normal(size=3) if tilted else np.array([0.0, 0.0, -1.0])
    gravity = 9.80665 * direction / np.linalg.norm(direction)
    return Scene(
        hole_diameter=D, peg_diameter=d, peg_height=H, peg_mass=steel * _log(rng, 0.3, 10),
        friction=float(rng.uniform(0.02, 0.5)), gravity=tuple(map(float, gravity)),
    )  # fmt: skip


def _draw(rng, redrawn):
    scene = _scene(rng)
    gamma = scene.gamma0 * (1 + _log(rng, 0.02, 6.0))
    kind = rng.choice(
        ["align", "slip", "slide", "all", "turning", "opening contact"],
        p=[0.22, 0.22, 0.1, 0.3, 0.08, 0.08],
    )
    if gamma > 0.5:
        return None
    closing = _log(rng, 0.003, 1.5) * (-1 if rng.random() < 0.8 else 1)
    rates = np.array([closing, 0.0, 0.0])
    for i, names in ((1, ("slide", "all", "turning")), (2, ("slip", "all", "turning"))):
        rates[i] = _log(rng, 0.003, 3.0) * rng.choice([-1, 1])
        if kind not in (*names, "opening contact"):
            # A motion without slip or slide has, at most, a trace of it.
            rates[i] *= rng.choice([0.0, 0.001])
    angles = np.array([gamma, *rng.uniform(-np.pi, np.pi, 2)])
    load = _log(rng, 0.5, 200)
    normal = load * np.array([_log(rng, 0.1, 1) for _ in range(3)])
    tolerance = float(rng.choice(TOLERANCES))
    if kind == "opening contact":
        normal[rng.integers(3)] *= -rng.uniform(0.1, 1)
        return _instant(scene, angles, rates, normal, tolerance, kind, redrawn)
    return _motion(rng, scene, angles, rates, normal, tolerance, kind, redrawn)


def _instant(scene, angles, rates, normal, tolerance, kind, redrawn):
    state = np.concatenate([angles, rates])
    wrench = balancing_wrench(scene, state, normal, scale=SCALE)
    exact = reference.answer("modes", scene, angles, rates, wrench, SCALE)[3:]
    if not np.isfinite(exact).all() or not exact.max() > 0:
        return None
    rows = [np.array([value, value]) for value in (state, wrench, exact)]
    return Drawn(scene, scene_scalars(scene), tolerance, 0.0, *rows, kind, redrawn)


def _motion(rng, scene, angles, rates, normal, tolerance, kind, redrawn):
    """Return what the full equations make of the wrench that a held motion asks for."""
    t = INTERVAL * np.arange(SAMPLES + 1)
    swing, size = 2 * np.pi * _log(rng, 1, 25), _log(rng, 0.01, 100)
    # Rates turn round only where that is the kind.
    swings = np.minimum(size / swing, (1.5 if kind == "turning" else 0.8) * np.abs(rates))
    start = rng.uniform(0, 2 * np.pi, 3)
    phase = swing * t[:, None] + start
    nominal = rates + swings * np.sin(phase)
    change = swings * swing * np.cos(phase)
    q = angles + rates * t[:, None] + swings / swing * (np.cos(start) - np.cos(phase))
    slow = 2 * np.pi * rng.uniform(1, 10, 3)
    loads = normal * (1 + 0.3 * np.sin(slow * t[:, None] + rng.uniform(0, 2 * np.pi, 3)))
    above = (q[:, 0] > 1.002 * scene.gamma0) & (q[:, 0] < 0.6)
    count = len(t) if above.all() else int(np.argmin(above))
    if count <= LEAST_SAMPLES:
        return None
    q, nominal, loads, change = q[:count], nominal[:count], loads[:count], change[:count]
    wrenches = _wrenches(scene, q.T, nominal.T, np.vstack([change.T, loads.T]))
    state = np.concatenate([q[0], nominal[0]])
    states = _integrate(scene, state, CubicSpline(t[:count], wrenches), t[:count])
    if len(states) <= LEAST_SAMPLES:
        return None
    n = len(states)
    normal = _reactions(scene_scalars(scene), np.full(3, SCALE), states, wrenches, workspace())
    # Rigid motion on three contacts may end on the way.
    good = (normal[:, 0] > LEAST_DETERMINANT) & (normal[:, 1:].min(axis=1) > 0)
    n = n if good.all() else int(np.argmin(good))
    if n <= LEAST_SAMPLES:
        return None
    return Drawn(
        scene, scene_scalars(scene), tolerance, INTERVAL, states[:n], wrenches[:n],
        normal[:n, 1:], kind, redrawn,
    )  # fmt: skip


def _wrenches(scene, q, rates, y):
    """Return the wrenches under which states have accelerations and reactions y, shape (n, 6)."""
    A, r0 = six_equations(scene, q, rates, np.zeros(6), SCALE)
    columns = [six_equations(scene, q, rates, unit, SCALE)[1] - r0 for unit in np.eye(6)]
    right = np.einsum("ijn,jn->ni", A, y) - r0.T
    return np.linalg.solve(np.transpose(columns, (2, 1, 0)), right[:, :, None])[:, :, 0]


def _integrate(scene, state, wrench, times):
    """
    Return the states at times, as far as the method has converged, shape (n, 6).

    Rosenbrock's method of order three, at steps that are halved until reactions agree.
    """
    p, scales = scene_scalars(scene), np.full(3, SCALE)
    coefficients = np.ascontiguousarray(np.transpose(wrench.c[::-1], (1, 0, 2)))
    before, kept = None, 0
    for count in STEPS:
        states = np.empty((len(times), 6))
        states[0] = state
        n = _follow(p, scales, coefficients, count, states, np.zeros(SCRATCH))
        rows = _reactions(p, scales, states[:n], wrench(times[:n]), workspace())[:, 1:]
        if before is not None:
            n = min(n, len(before))
            off = np.abs(rows[:n] - before[:n]).max(axis=1, initial=0.0)
            agree = off <= CONVERGED_TO * np.abs(rows[:n]).max(axis=1)
            kept = n if agree.all() else int(np.argmin(agree))
            if kept == len(times):
                break
        before = rows
    return states[:kept]


@compiled
def _follow(p, scales, coefficients, count, states, m):
    """Fill in the states after the first; return how many are finite."""
    x, x1 = states[0].copy(), states[0].copy()
    for k in range(1, len(states)):
        t = INTERVAL * (k - 1)
        status, _ = advance(
            ROS3P, p, scales, coefficients, INTERVAL, t, INTERVAL / count, count, x, x1, m
        )
        if status != 0 or not x[0] > p.gamma0:
            return k
        states[k] = x
    return len(states)


@compiled
def _reactions(p, scales, states, wrenches, work):
    """Return determinant and reactions of the full equations, shape (n, 4)."""
    rows, y = np.empty((len(states), 4)), np.empty(6)
    for k in range(len(states)):
        rows[k, 0] = accelerate(p, scales, states[k], wrenches[k], work, y)
        rows[k, 1:] = y[3:]
    return rows
