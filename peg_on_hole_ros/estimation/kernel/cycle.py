"""
What a filter does from one wrench to the next.

`ContactFilter` is made of parts of it, and does more between them; `predict_or_bridge` and
`correct_and_follow` put them together for compiled loops, see `study.step_loop`.
"""

from peg_on_hole_ros.estimation.kernel.acceleration import follow_acceleration
from peg_on_hole_ros.estimation.kernel.balance import learn_from_balance
from peg_on_hole_ros.estimation.kernel.bridging import (
    adapt_rate_noise,
    bridge,
    bridge_without_step,
)
from peg_on_hole_ros.estimation.kernel.constant_rates import correct_beside, take_beside
from peg_on_hole_ros.estimation.kernel.correction import correct
from peg_on_hole_ros.estimation.kernel.friction_lag import follow_friction
from peg_on_hole_ros.estimation.kernel.lean import follow_steps
from peg_on_hole_ros.estimation.kernel.memory import (
    BRIDGED,
    INTERVAL,
    KEPT_FOR,
    OFFSETS,
    ON_CONTACTS,
    SINCE_CORRECTION,
    SLOW,
    WITHOUT_STEP,
)
from peg_on_hole_ros.estimation.kernel.parameters import learns_geometry_or_bias
from peg_on_hole_ros.estimation.kernel.prediction import (
    DOUBTED,
    RUNS_AWAY,
    SLOW_SLIP,
    predict_contact,
)
from peg_on_hole_ros.estimation.kernel.tangent import follow_rates
from peg_on_hole_ros.estimation.steps.implicit_euler import CONVERGED
from peg_on_hole_ros.mechanics.kernel import compiled, inlined

# Constant rates that were taken for the estimate are kept so long at least [s]: they know the slip
# at once, and the noise that had hidden it from the steps would do so again.
KEPT = 0.02


@compiled
def bridge_unless_stepped(m, slopes, status, dt, free_rate_noise):
    """
    Take note of what became of a prediction, and bridge the interval where there is none.

    Parameters
    ----------
    m, slopes, dt
        As for `prediction.predict_contact`.
    status : int
        That it returned.
    free_rate_noise : float
        Least random walk of the rates where the contact equations give no step [rad/s^1.5].

    """
    m[ON_CONTACTS] = 1.0
    # A slip that is not told from none is harder to tell the next time.
    m[SLOW] = 1.0 if _not_believed(status) else 0.0
    m[KEPT_FOR] = m[KEPT_FOR] - dt if m[SLOW] > 0.0 else 0.0
    m[BRIDGED] = 0.0
    if status != CONVERGED and m[SLOW] == 0.0 and status != RUNS_AWAY:
        bridge_without_step(m, slopes, dt, free_rate_noise)
        return
    m[WITHOUT_STEP] = 0.0
    if status != CONVERGED:
        bridge(m, slopes, dt)


@compiled
def resume_constant_rates(m, status, dt):
    """
    Take constant rates as they would be had no step been taken, where a step is not believed.

    Parameters
    ----------
    m : ndarray
        Memory after `prediction.predict_contact`, before `bridge_unless_stepped`.
    status : int
        That it returned.
    dt : float
        [s].

    Returns
    -------
    bool
        Whether angles and rates, at the begin of the interval, were changed.

    """
    if not _not_believed(status) or m[SLOW] > 0.0:
        return False
    # What has been learnt of geometry or bias came with these angles and rates; and what an
    # uncertain bias or tilt shares with them is not known of those beside.
    if learns_geometry_or_bias(m) or m[OFFSETS + 1] > m[OFFSETS]:
        return False
    taken = take_beside(m, dt)
    m[KEPT_FOR] = KEPT if taken else 0.0
    return taken


@inlined
def _not_believed(status):
    """Return whether there is a step that is not relied on."""
    if status == DOUBTED:
        return True
    return status == SLOW_SLIP


@compiled
def predict_or_bridge(m, dy, slopes, dt, acceleration_stddev, free_rate_noise):
    """
    Learn from balance, predict under contact; without a step to rely on, bridge the interval.

    Parameters
    ----------
    m, dy, slopes, dt
        As for `prediction.predict_contact`.
    acceleration_stddev : float
        See `balance.learn_from_balance` [rad/s^2].
    free_rate_noise : float
        Least random walk of the rates where the contact equations give no step [rad/s^1.5].

    Returns
    -------
    status, evaluations : int
        As of `prediction.predict_contact`.

    """
    learn_from_balance(m, dy, dt, acceleration_stddev)
    m[SINCE_CORRECTION] += dt
    status, evaluations, _ = predict_contact(m, dy, slopes, dt)
    resume_constant_rates(m, status, dt)
    bridge_unless_stepped(m, slopes, status, dt, free_rate_noise)
    return status, evaluations


@compiled
def follow_innovation(m, nis, dt):
    """Follow what the innovation in the memory, nis its square, tells of predictions; dt [s]."""
    if m[BRIDGED] > 0.0:
        adapt_rate_noise(m, nis)
    follow_steps(m, dt)


@compiled
def correct_and_follow(m, nis, dt):
    """Correct by the innovation in the memory, nis its square, dt [s] after the last one."""
    follow_innovation(m, nis, dt)
    m[INTERVAL] = dt
    correct_beside(m, dt)
    correct(m)
    follow_motion(m, dt)


@compiled
def follow_motion(m, dt):
    """Follow a correction, dt [s] after the last one: how the peg moves, and how friction does."""
    if learns_geometry_or_bias(m):
        follow_rates(m, dt)
    follow_acceleration(m, dt)
    follow_friction(m)
