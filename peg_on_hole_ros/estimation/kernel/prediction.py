"""The prediction of angles and rates under contact or free, with its covariance, compiled."""

from peg_on_hole_ros.estimation.kernel.carry import add_walk, carry, carry_all
from peg_on_hole_ros.estimation.kernel.direction import slip_without_kink
from peg_on_hole_ros.estimation.kernel.held_wrench import (
    add_jump,
    ramps,
    wrench_of_piece,
)
from peg_on_hole_ros.estimation.kernel.lean import doubted
from peg_on_hole_ros.estimation.kernel.memory import (
    AT_MEAN,
    ENDS,
    KEPT_FOR,
    MEAN_RATES,
    METHOD,
    METHOD_USED,
    OFFSETS,
    REFUSED,
    SAVED,
    SCALES,
    SLIDING,
    SLOW,
    SPEEDS,
    SPREAD,
    STAGE,
    STOPPED,
    WORK,
    X1,
    X,
    Y,
    process_of,
)
from peg_on_hole_ros.estimation.kernel.parameters import learns_clearance, learns_geometry_or_bias
from peg_on_hole_ros.estimation.kernel.runaway import runs_away
from peg_on_hole_ros.estimation.kernel.slip import (
    friction_scales,
    slip,
    slow_slip,
    surely_sliding,
)
from peg_on_hole_ros.estimation.kernel.tangent import mean_rates_known, tangent_at
from peg_on_hole_ros.estimation.steps.choice import (
    IMPLICIT_EULER,
    INACCURATE,
    LONG_STEP,
    SECOND_ORDER,
    contact_speed_gain,
    friction_slack,
    step_error,
    take_step,
)
from peg_on_hole_ros.estimation.steps.implicit_euler import CONVERGED, FAILED
from peg_on_hole_ros.mechanics.kernel import WIDTH, compiled, inlined, scene_of

# A held peg's contacts do not gain speed faster than this [m/s^2]; the noise of a wrench gives
# some 0.5 over a millisecond, and less over longer intervals. Where friction leaves rigid motion
# more than one solution (Painleve), or none, Newton's method otherwise finds the far one.
CONTACT_ACCELERATION = 20.0
SHORTEST_INTERVAL = 1e-3
# A slip of so many standard deviations at the begin and at the end of a step, and at the end half
# of what it was, surely has its direction throughout.
SURELY = 10.0
# Once not told from none, a slip is so many times farther from it before it counts again: what a
# few steps in a wrong direction do is forgotten in tens of milliseconds, and where noise hides the
# slip at all, what it does to a step is more than a held peg does to its rates.
RESUME = 12.0
# Where a clearance, a bias or a tilt of the hole is learnt: nothing but steps tells of them.
RESUME_SOON = 3.0
# Share of steps that are not believed, over so long [s], above which those that are do not tell
# of friction: their noise has been selected to push the peg on, so that friction seems higher.
SELECTED = 0.04
SELECTED_OVER = 0.05
# What a learnt clearance may be off by hides a slip as well, and selects nothing; up to here.
HIDDEN = 0.3
# Of a prediction, beside the outcomes of a step.
SLOW_SLIP = INACCURATE + 1
LIMITED = SLOW_SLIP + 1
RUNS_AWAY = LIMITED + 1
DOUBTED = RUNS_AWAY + 1


# The joint covariance Z is that of the state (6) and of the noise of the wrench that is held (6):
# the same noise drives the motion and enters the reactions. Functions take the memory m of
# `memory`; its covariances are symmetric to the last bit.


@compiled
def predict_contact(m, dy, slopes, dt):
    """
    Predict over dt under three-point contact; halve the step until one is found that is good.

    Parameters
    ----------
    m : ndarray
        Memory: state and joint covariance are changed; on return the velocity scales of friction
        are at SCALES, and how many attempts were refused at REFUSED.
    dy : ndarray, shape (6, WIDTH)
        Scratch.
    slopes : ndarray, shape (6, WIDTH)
        Scratch.
    dt : float
        [s].

    Returns
    -------
    status : int
        CONVERGED; or with state and covariance untouched FAILED, SLOW_SLIP where a slip is not
        told from none, DOUBTED where innovations of steps lean, RUNS_AWAY where no prediction is
        to be relied on, LIMITED where the evaluations that are allowed were spent before.
    evaluations : int
        Of the six equations.
    pieces : int
        Steps of equal length that it took.

    """
    p = scene_of(m)
    process = process_of(m)
    x, u, u_stage = m[X : X + 6], m[ENDS : ENDS + 6], m[ENDS + 6 : ENDS + 12]
    u_begin = m[ENDS + 12 : ENDS + 18]
    x1, y, mean_rates = m[X1 : X1 + 6], m[Y : Y + 6], m[MEAN_RATES : MEAN_RATES + 3]
    scales, work, stage = m[SCALES : SCALES + 3], m[WORK:], m[STAGE : STAGE + 96]
    integrator, tolerance = int(m[METHOD]), m[METHOD + 1]
    if integrator == IMPLICIT_EULER and ramps(m):
        # Stiff friction follows the wrench at the end of a step, all else its mean.
        integrator = SECOND_ORDER
    m[METHOD_USED] = integrator
    m[REFUSED] = m[REFUSED + 1] = 0.0
    # The covariance of offsets that are known stays zero.
    saved = 184 + 12 * int(m[OFFSETS + 1])
    for i in range(saved):
        m[SAVED + i] = m[X + i]
    friction_scales(p, m, process.slip_velocity_scale, process.slip_widening)
    within = process.slow_slip
    constants = learns_geometry_or_bias(m)
    if m[SLOW] > 0.0:
        within *= RESUME_SOON if constants else RESUME
    lately = min(dt / SELECTED_OVER, 1.0)
    if doubted(m):
        _note_step(m, 1.0, lately)
        return DOUBTED, 0, 0
    if slow_slip(m, within) or (m[SLOW] > 0.0 and m[KEPT_FOR] > 0.5 * dt):
        _note_step(m, 1.0, lately)
        return SLOW_SLIP, 0, 0
    if runs_away(p, m):
        return RUNS_AWAY, 1, 0
    m[SLIDING] = surely_sliding(m)
    # Steps that noise has selected make a clearance seem smaller; their own tangents, larger. With
    # these at the mean there as well, N_K on a peg of 10 mm was covered in 71 for 91 %.
    at_mean = integrator == IMPLICIT_EULER and constants and m[STOPPED] <= SELECTED
    at_mean = at_mean and mean_rates_known(m)
    m[AT_MEAN] = 1.0 if at_mean else 0.0
    limit = CONTACT_ACCELERATION * max(dt, SHORTEST_INTERVAL)
    pieces = max(1, int(dt / process.max_step + 0.999999))
    evaluations, allowed = 1, m[METHOD + 2] * pieces
    for _ in range(8):
        h = dt / pieces
        status = CONVERGED
        for piece in range(pieces):
            if evaluations >= allowed:
                status = LIMITED
                break
            wrench_of_piece(m, piece, pieces)
            status, count = take_step(
                integrator, p, scales, x, u_stage, u, h, x1, y, dy, slopes, stage, work
            )
            evaluations += count
            if status == CONVERGED:
                gain = contact_speed_gain(p, m[SAVED : SAVED + 6], x1)
                if gain > limit + friction_slack(p, m[SPREAD], slopes):
                    status = FAILED
            if status == CONVERGED and h > LONG_STEP:
                error, count = step_error(
                    integrator, p, scales, x, u_begin, u, h, x1, y, slopes, stage, work
                )
                evaluations += count
                if not error <= tolerance:
                    status = INACCURATE
            if status != CONVERGED:
                m[REFUSED + (1 if status == INACCURATE else 0)] += 1.0
                break
            if at_mean:
                tangent_at(p, mean_rates, scales, x1, u, h, dy, slopes, stage, work)
                evaluations += 1
            if integrator == SECOND_ORDER:
                carry_all(m, slopes, h, process.rate_density)
            else:
                carry(m, slopes, h, process.rate_density)
            for i in range(6):
                m[X + i] = m[X1 + i]
        if status == CONVERGED:
            # The slip that it had against the spread that it got: one that the step has stopped
            # tells of friction.
            v0, v1, v2 = m[SPEEDS], m[SPEEDS + 2], m[SPEEDS + 4]
            s0, s1, s2 = m[SPEEDS + 1], m[SPEEDS + 3], m[SPEEDS + 5]
            slip(p, m, m[X])
            surely = (
                _keeps_on(v0, s0, m[SPEEDS], m[SPEEDS + 1])
                or _keeps_on(v1, s1, m[SPEEDS + 2], m[SPEEDS + 3])
                or _keeps_on(v2, s2, m[SPEEDS + 4], m[SPEEDS + 5])
            )
            m[SPEEDS], m[SPEEDS + 2], m[SPEEDS + 4] = v0, v1, v2
            slow = slow_slip(m, process.slow_slip)
            if within > 0.0 and not surely and not slow:
                _exchange(m, saved)
                distance, count = slip_without_kink(p, m, dt)
                _exchange(m, saved)
                slow = distance < within * within
                evaluations += count
            if slow:
                for i in range(saved):
                    m[X + i] = m[SAVED + i]
                _note_step(m, 1.0, lately)
                return SLOW_SLIP, evaluations, pieces
            _note_step(m, 0.0, 1.0 if surely else lately)
            if m[STOPPED] > (HIDDEN if learns_clearance(m) else SELECTED):
                m[SLIDING] = 0.0
            add_jump(m, slopes, pieces, dt / pieces, integrator)
            if m[SPREAD] > 0.0:
                m[SPREAD] += process.friction_density * dt
            return CONVERGED, evaluations, pieces
        for i in range(saved):
            m[X + i] = m[SAVED + i]
        if status == LIMITED:
            if dt > LONG_STEP:
                # So it goes on while the wrench comes no faster.
                _note_step(m, 1.0, lately)
            return LIMITED, evaluations, pieces
        pieces *= 2
    return FAILED, evaluations, pieces


@inlined
def _keeps_on(begin, begin_variance, end, end_variance):
    """Return whether a slip is so sure at the begin and at the end that it kept its direction."""
    told = begin * begin > SURELY * SURELY * begin_variance
    return told and end > 0.5 * begin and end * end > SURELY * SURELY * end_variance


@inlined
def _note_step(m, unbelieved, share):
    """Let the share of unbelieved steps follow this one, 1.0 if it is not believed."""
    m[STOPPED] += share * (unbelieved - m[STOPPED])


@inlined
def _exchange(m, count):
    """Exchange the state with the one that was saved."""
    for i in range(count):
        kept = m[X + i]
        m[X + i] = m[SAVED + i]
        m[SAVED + i] = kept


@compiled
def predict_free(m, slopes, dt, rate_noise):
    """Predict over dt at constant rates with their random walk; the wrench drives nothing."""
    for i in range(3):
        for j in range(WIDTH):
            slopes[i, j] = 0.0
        slopes[i, 3 + i] = 1.0
        m[X + i] += dt * m[X + 3 + i]
    m[SLIDING] = 0.0
    carry(m, slopes, dt, 0.0)
    for i in range(3):
        add_walk(m, i, rate_noise, dt)
