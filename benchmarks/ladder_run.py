"""One random scene through every rung of the ladder and through `auto`: errors, choices, costs."""

from time import perf_counter

import numpy as np
from peg_on_hole_ros.estimation.filters.contact import ContactFilter
from peg_on_hole_ros.estimation.filters.model import choose_at, predict_at_constant_rates, react_by
from peg_on_hole_ros.estimation.kernel import correction
from peg_on_hole_ros.estimation.kernel.cycle import (
    bridge_unless_stepped,
    correct_and_follow,
    predict_or_bridge,
)
from peg_on_hole_ros.estimation.kernel.held_wrench import hold_wrench
from peg_on_hole_ros.estimation.kernel.memory import R
from peg_on_hole_ros.estimation.kernel.reactions import react
from peg_on_hole_ros.estimation.steps.implicit_euler import CONVERGED
from peg_on_hole_ros.ladder.choice import answer_by_choice, new_choice, tally
from peg_on_hole_ros.ladder.rungs import DYNAMIC, QUASI_STATIC, RUNGS, answer

from ladder_scenes import SCALE, Drawn, draw
from peg_on_hole_ros.mechanics.kernel import WIDTH, compiled, workspace
from peg_on_hole_ros.options import FilterOptions, WrenchInput

AUTO = -1
# An instant is asked for so often in a row, for its cost.
INSTANT = 50
REPEATS = 5
# What has no finite answer, or none.
LOST = 1e9


@compiled
def through(rung, choice, p, scales, states, wrenches, work, y, normal, used):
    """Fill in the reactions at every sample, by a rung or (AUTO) by choice, and what was used."""
    for k in range(len(states)):
        if rung == AUTO:
            used[k] = answer_by_choice(choice, p, scales, states[k], wrenches[k], work, y)
        else:
            answer(rung, p, scales, states[k], wrenches[k], work, y)
        normal[k, 0], normal[k, 1], normal[k, 2] = y[3], y[4], y[5]


@compiled
def filtered(rung, choice, m, dy, slopes, y, wrenches, angles, covariance, dt, free, held):
    """Run the filter's steps by a rung or by choice, as `ContactFilter` composes them."""
    for k in range(1, len(wrenches)):
        hold_wrench(m, wrenches[k])
        used = choose_at(m, choice, y) if rung == AUTO else min(rung, DYNAMIC)
        if used <= QUASI_STATIC:
            status = predict_at_constant_rates(m, slopes, dt, free * free)
            bridge_unless_stepped(m, slopes, status, dt, free)
        else:
            status, _ = predict_or_bridge(m, dy, slopes, dt, held, free)
        if status != CONVERGED:
            used = DYNAMIC
        for i in range(9):
            m[R + i] = covariance[i]
        correct_and_follow(m, correction.innovation(m, angles[k]), dt)
        if used < DYNAMIC:
            react_by(used, m, dy, 0.0)
        else:
            react(m, dy, held)


def score(task) -> dict:
    """Return the figures of a scene, given its seed and index."""
    scene = draw(*task)
    size = np.abs(scene.normal).max(axis=1)
    errors, _, _ = _errors(scene, size)
    found, used, choice = _errors(scene, size, True)
    decisions, changes = tally(choice)
    model, step = _model_costs(scene), _step_costs(scene)
    return {
        "seed": task[0], "index": task[1], "kind": str(scene.kind), "tolerance": scene.tolerance,
        "samples": len(size), "redrawn": scene.redrawn, "errors": errors, "auto": found,
        "used": [int((used == rung).sum()) for rung in range(len(RUNGS))],
        "decisions": decisions, "changes": changes, "model_us": model, "step_us": step,
    }  # fmt: skip


def _errors(scene: Drawn, size, auto=False):
    """Return the largest error over the samples, of every rung or of `auto`."""
    worst, used, choice = [], np.zeros(len(size)), new_choice(scene.tolerance)
    for rung in [AUTO] if auto else range(len(RUNGS)):
        normal = np.empty((len(size), 3))
        through(
            rung, choice, scene.p, np.full(3, SCALE), scene.states, scene.wrenches, workspace(),
            np.zeros(6), normal, used,
        )  # fmt: skip
        with np.errstate(invalid="ignore", over="ignore"):
            error = float((np.abs(normal - scene.normal).max(axis=1) / size).max())
        worst.append(min(error, LOST) if np.isfinite(error) else LOST)
    return (worst[0] if auto else worst), used, choice


def _model_costs(scene: Drawn):
    """Return microseconds a sample of each rung and of `auto`, the models alone."""
    states, wrenches = scene.states, scene.wrenches
    if not scene.interval:
        states, wrenches = (np.tile(rows[:1], (INSTANT, 1)) for rows in (states, wrenches))
    n, scales, work = len(states), np.full(3, SCALE), workspace()
    y, normal, used = np.zeros(6), np.empty((len(states), 3)), np.zeros(len(states))
    least = np.full(len(RUNGS) + 1, np.inf)
    for _ in range(REPEATS):
        for at, rung in enumerate([*range(len(RUNGS)), AUTO]):
            choice = new_choice(scene.tolerance)
            begun = perf_counter()
            through(rung, choice, scene.p, scales, states, wrenches, work, y, normal, used)
            least[at] = min(least[at], perf_counter() - begun)
    return (1e6 * least / n).tolist()


def _step_costs(scene: Drawn):
    """Return the same of a filter's step, from the true state under exact sensors, or None."""
    if not scene.interval:
        return None
    options, sensor = FilterOptions(), WrenchInput()
    noise = np.diag([sensor.force_stddev**2] * 3 + [sensor.torque_stddev**2] * 3)
    covariance = 1e-8 * np.eye(3)
    angles = np.ascontiguousarray(scene.states[:, :3])
    kalman = ContactFilter(scene.scene, options, noise)
    kalman.start(angles[0], covariance)
    # The rates are known to what a few orientations tell.
    kalman.x[3:] = scene.states[0, 3:]
    kalman.Z[range(3, 6), range(3, 6)] = 0.02**2
    begin, least = kalman.memory.copy(), np.full(DYNAMIC + 2, np.inf)
    dy, slopes, y = np.zeros((6, WIDTH)), np.zeros((6, WIDTH)), np.zeros(6)
    for _ in range(REPEATS):
        for at, rung in enumerate([*range(DYNAMIC + 1), AUTO]):
            kalman.memory[:] = begin
            choice = new_choice(scene.tolerance, top=DYNAMIC)
            begun = perf_counter()
            filtered(
                rung, choice, kalman.memory, dy, slopes, y, scene.wrenches, angles,
                covariance.ravel(), scene.interval, options.free_rate_noise,
                options.acceleration_stddev,
            )  # fmt: skip
            least[at] = min(least[at], perf_counter() - begun)
    return (1e6 * least / (len(angles) - 1)).tolist()
