"""Which model of the ladder the filter uses, and what the cheaper ones make of its estimate."""

from math import asin, fabs, inf, nan, sqrt

import numpy as np

from peg_on_hole_ros.estimation.kernel.memory import (
    REACTIONS,
    SCALES,
    SCENE,
    SPREAD,
    WORK,
    U,
    X,
    Y,
    covariance_entry,
    fill_lasting,
    process_of,
    times_covariance,
)
from peg_on_hole_ros.estimation.kernel.prediction import SLOW_SLIP, predict_free
from peg_on_hole_ros.estimation.kernel.slip import (
    friction_scales,
    scales_without_contacts,
    slow_slip,
)
from peg_on_hole_ros.estimation.steps.implicit_euler import CONVERGED
from peg_on_hole_ros.ladder.choice import (
    AUTO,
    choose,
    error_of,
    explained,
    new_choice,
    size_of,
)
from peg_on_hole_ros.ladder.rungs import DYNAMIC, QUASI_STATIC, RUNGS, reduced
from peg_on_hole_ros.mechanics.kernel import WIDTH, compiled, determinant_at, scene_of

# By name; `modes` is not among them: contacts that open are the monitor's, from what is measured.
MODELS = {"auto": AUTO} | {name: RUNGS.index(name) for name in RUNGS[: DYNAMIC + 1]}

# Steps of the differences: of an angle [rad], a rate [rad/s], a force or moment [N, N m], the
# friction coefficient and the diameter over the clearance. Rungs are linear in the wrench.
_ANGLE, _RATE, _WRENCH, _FRICTION, _CLEARANCE = 1e-7, 1e-7, 1.0, 1e-6, 1e-4


class Model:
    """
    The rung in use. State and covariance are the filter's on every rung, so they never jump.

    Parameters
    ----------
    name : str
        Of MODELS.
    tolerance : float
        Error allowed in a reaction, over the largest of the three.
    memory : ndarray
        Of the filter, see `memory`.

    Attributes
    ----------
    rung : int
        In use for the wrench that is held.
    choice : ndarray
        See `ladder.choice`.

    """

    def __init__(self, name: str, tolerance: float, memory: np.ndarray):
        asked = MODELS[name]
        self._always_full = asked == DYNAMIC
        self._undecided = new_choice(tolerance, asked, DYNAMIC)
        self.choice = self._undecided.copy()
        self._memory, self._y = memory, np.zeros(6)
        self._fresh, self.rung = True, DYNAMIC

    def restart(self):
        """Forget all decisions: they are of a motion that has ended."""
        self.choice[:] = self._undecided
        self._fresh, self.rung = True, DYNAMIC

    def held(self):
        """Note that a new wrench is held: the model is looked at once for each."""
        self._fresh = True

    def at_constant_rates(self, in_contact: bool) -> bool:
        """Return whether the model in use predicts nothing but constant rates."""
        if self._always_full:
            return False
        if not in_contact:
            self.rung = DYNAMIC
        elif self._fresh:
            self._fresh = False
            self.rung = choose_at(self._memory, self.choice, self._y)
        return self.rung <= QUASI_STATIC

    def full(self):
        """Use the full equations for the wrench that is held, whatever was chosen."""
        self.rung = DYNAMIC

    @property
    def error(self) -> float | None:
        """Error of the rung in use at the last decision, over the largest reaction, or None."""
        known = error_of(self.choice) if self.rung < DYNAMIC else 0.0
        return known if known >= 0.0 else None

    @property
    def line(self) -> str:
        """The last decision as one line; empty where there never is one."""
        return "" if self._always_full else explained(self.choice)

    def react(self, dy) -> float:
        """Fill in the reactions by the rung in use; returns as `reactions.react`."""
        return react_by(self.rung, self._memory, dy, (self.error or 0.0) * self._size)

    @property
    def _size(self):
        return size_of(self.choice)

    def snapshot(self):
        """Return what `restore` takes back."""
        return self.choice.copy(), self._fresh, self.rung

    def restore(self, snapshot):
        """Go back to a snapshot."""
        self.choice[:], self._fresh, self.rung = snapshot


@compiled
def choose_at(m, choice, y):
    """Return the rung for the estimate."""
    p, x, u = scene_of(m), m[X : X + 6], m[U : U + 6]
    if not x[0] > p.gamma0:
        return DYNAMIC
    return choose(choice, p, m[SCALES : SCALES + 3], x, u, m[WORK:], y)


@compiled
def predict_at_constant_rates(m, slopes, dt, rate_noise):
    """Predict as `prediction.predict_free`, with the friction scales that the reactions need."""
    p, process = scene_of(m), process_of(m)
    friction_scales(p, m, process.slip_velocity_scale, process.slip_widening)
    scales_without_contacts(p, m, process.slip_velocity_scale)
    if slow_slip(m, process.slow_slip):
        return SLOW_SLIP
    predict_free(m, slopes, dt, rate_noise)
    if m[SPREAD] > 0.0:
        m[SPREAD] += process.friction_density * dt
    return CONVERGED


@compiled
def react_by(rung, m, dy, model_stddev):
    """
    Fill Y with a rung's answer at the estimate, and REACTIONS with its covariance.

    Parameters
    ----------
    rung : int
        Up to `align_slip`.
    m : ndarray
        Memory.
    dy : ndarray, shape (6, WIDTH)
        Filled with the answer's derivatives, by differences.
    model_stddev : float
        Of each reaction, for what the rung leaves out [N].

    Returns
    -------
    float
        Determinant of the six equations over its frictionless value; NaN without an answer.

    """
    p, x, u = scene_of(m), m[X : X + 6], m[U : U + 6]
    scales = m[SCALES : SCALES + 3]
    m[Y], m[Y + 1], m[Y + 2], m[Y + 3], m[Y + 4], m[Y + 5] = reduced(rung, p, scales, x, u)
    upright = p.g_x == 0.0 and p.g_y == 0.0
    for column in range(WIDTH):
        for i in range(6):
            dy[i, column] = 0.0
        if column == 1 and upright or 9 <= column < 12 and rung <= QUASI_STATIC:
            continue
        if column == 12 and m[SPREAD] == 0.0 or column == 13 and m[SPREAD + 3] == 0.0:
            continue
        step = _ANGLE if column < 3 else (_RATE if column < 6 else _WRENCH)
        at = X + column if column < 6 else U + column - 6
        if column >= 12:
            step = _FRICTION if column == 12 else -_CLEARANCE * (p.D - p.d)
            at = SCENE + 7 if column == 12 else SCENE
        kept = m[at]
        m[at] += step
        step = m[at] - kept
        if column == 13:
            m[SCENE + 3] = 2.0 * asin(sqrt((p.D - m[SCENE]) / (2.0 * p.D)))
        # A wider hole may leave no three contacts at this tilt.
        if x[0] > m[SCENE + 3]:
            there = reduced(rung, scene_of(m), scales, x, u)
            for i, value in enumerate(there):
                dy[i, column] = (value - m[Y + i]) / step
        m[at], m[SCENE + 3] = kept, p.gamma0
    uncertain = times_covariance(m, dy, 6)
    fill_lasting(m, uncertain)
    total = 0.0
    for i in range(6):
        for j in range(i + 1):
            value = covariance_entry(m, dy, i, j, uncertain)
            if i == j and i >= 3:
                value += model_stddev * model_stddev
            m[REACTIONS + 6 * i + j] = m[REACTIONS + 6 * j + i] = value
            total += value
    determinant = determinant_at(p, scales, x[0], (x[3], x[4], x[5]), m[WORK:])
    return determinant if fabs(total) < inf else nan
