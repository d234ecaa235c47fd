"""A held peg's estimate, compiled: start, let go, predict, hold against, correct, weigh."""

from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimator import step
from peg_on_hole_ros.estimator.mixture import predict
from peg_on_hole_ros.estimator.noise import follow_noise
from peg_on_hole_ros.estimator.record import fill_record
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.estimator.state import FRICTION, OPEN, TILT, Scratch, State
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled, spliced

# What becomes of an orientation; LOST: the covariance was no longer one.
USED, GATED, RESET, LOST = range(4)
# Places in `Held.begin`: friction and its deviation at the next start, orientations that were
# refused in a row.
BEGIN_FRICTION, BEGIN_STDDEV, REFUSED = range(3)


class Held(NamedTuple):
    """
    All that an estimate is made of; what changes stands in `state` and in the five arrays behind.

    Attributes
    ----------
    state : State
    u : ndarray, shape (6,)
        The last wrench on the peg [N], [N m].
    record : ndarray
        All that it has said, see `record`.
    open_mean, open_stddev : ndarray
        What is open at the next start.
    begin : ndarray, shape (3,)
    scratch : Scratch
    constants : Settings
    scene : SceneScalars
        As stated.
    at : ndarray of int, shape (6,)
        Places of what is open.
    n : int
        How many values are estimated.
    walk : ndarray, shape (n,)
        Variance that each gains in a second.
    learnt : ndarray, shape (n + 3,)
        Which of them are learnt.
    noise, bias_map : ndarray, shape (6, 6)
        Covariance of a wrench on the peg; from a bias to what it adds to that.
    friction_open : bool
        Whether friction has a spread.

    """

    state: State
    u: np.ndarray
    record: np.ndarray
    open_mean: np.ndarray
    open_stddev: np.ndarray
    begin: np.ndarray
    scratch: Scratch
    constants: Settings
    scene: SceneScalars
    at: np.ndarray
    n: int
    walk: np.ndarray
    learnt: np.ndarray
    noise: np.ndarray
    bias_map: np.ndarray
    friction_open: bool


class Gates(NamedTuple):
    """When an orientation is refused, and how a start begins; see `FilterOptions`."""

    gate_threshold: float
    gate_reset_count: float
    initial_rate_stddev: float


@spliced
def fill(h):
    """Fill in the record."""
    fill_record(
        h.record, h.state, h.at, h.n, h.scene, h.u, h.bias_map, h.constants.direction_share,
        h.scratch.left,
    )  # fmt: skip


@compiled
def start(h, gates, q, R):
    """Start from an orientation q [rad] with the stated covariance R, at unknown rates."""
    step.start(
        h.state, h.scratch, h.constants, h.at, h.n, q, h.state.noise[0] * R,
        gates.initial_rate_stddev, h.begin[BEGIN_FRICTION], h.begin[BEGIN_STDDEV], h.open_mean,
        h.open_stddev,
    )  # fmt: skip
    h.begin[REFUSED] = 0.0
    fill(h)


@compiled
def let_go(h):
    """Let go of the motion; what was learnt stays for the next start."""
    s = h.state
    if s.since[0] > 0.0:
        # A friction that is known stays as stated, without what rounding makes of it.
        if h.friction_open:
            h.begin[BEGIN_FRICTION] = s.mean[FRICTION]
            h.begin[BEGIN_STDDEV] = sqrt(max(s.covariance[FRICTION, FRICTION], 0.0))
        for i in range(OPEN, h.n):
            h.open_mean[i - OPEN] = s.mean[i]
            h.open_stddev[i - OPEN] = sqrt(max(s.covariance[i, i], 0.0))
    h.begin[REFUSED] = 0.0
    h.u[:] = 0.0


@spliced
def move_on(h, dt):
    """Predict by dt [s]."""
    predict(h.state, h.scratch, h.constants, h.walk, h.n, dt)
    step.pass_time(h.state, dt)
    step.combine(h.state, h.n)


@spliced
def hold_against(h, gates, q, R):
    """
    Hold the estimate against an orientation, without any correction.

    Returns
    -------
    result : int
        USED, GATED, RESET or LOST: what has to become of it.
    nis : float
        Normalised innovation squared, 3 degrees of freedom.

    """
    nis = step.expect(h.state, h.scratch, h.at, q, R)
    follow_noise(h.state, h.constants, q, R)
    if not isfinite(nis):
        return LOST, nis
    if nis > gates.gate_threshold:
        h.begin[REFUSED] += 1.0
        return (GATED if h.begin[REFUSED] <= gates.gate_reset_count else RESET), nis
    h.begin[REFUSED] = 0.0
    return USED, nis


@spliced
def orient(h, q, R):
    """Correct by an orientation that is used."""
    step.orient(h.state, h.scratch, h.constants, h.at, h.n, h.learnt, q, R)
    step.combine(h.state, h.n)


@spliced
def correct(h, gates, q, R):
    """Correct with an orientation, or start from it; return what `hold_against` does."""
    result, nis = hold_against(h, gates, q, R)
    if result == USED:
        orient(h, q, R)
    elif result != GATED:
        if result == RESET:
            let_go(h)
        start(h, gates, q, R)
    return result, nis


@spliced
def weigh(h, u, contacts):
    """Take a wrench on the peg, and fill in the record; contacts as for `step.weigh`."""
    h.u[:] = u
    if not isfinite(h.state.mean[0]):
        return
    step.weigh(
        h.state, h.scratch, h.constants, h.scene, h.at, h.n, h.learnt, h.u, h.noise, h.bias_map,
        contacts,
    )  # fmt: skip
    fill(h)


@spliced
def gravity(h):
    """Return gravity in the axes of the hole as it is now taken to lie [m/s^2]."""
    g_x, g_y, g_z = h.scene.g_x, h.scene.g_y, h.scene.g_z
    at = h.at[TILT]
    if at < 0:
        return g_x, g_y, g_z
    t_x, t_y = h.state.mean[at], h.state.mean[at + 1]
    return g_x - t_y * g_z, g_y + t_x * g_z, g_z + t_y * g_x - t_x * g_y
