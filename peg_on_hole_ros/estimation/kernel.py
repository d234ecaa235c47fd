"""Extended Kalman filter on the peg's angles and rates: the compiled prediction and correction."""

from math import floor, pi, sqrt

from peg_on_hole_ros.estimation.carry import carry, carry_all
from peg_on_hole_ros.estimation.direction import slip_without_kink
from peg_on_hole_ros.estimation.held_wrench import add_jump, move_wrench, ramps, wrench_of_piece
from peg_on_hole_ros.estimation.memory import (
    CREEP,
    ENDS,
    GAIN,
    JOSEPH,
    LEARNT,
    METHOD,
    METHOD_USED,
    OFFSETS,
    REFUSED,
    RESIDUAL,
    SAVED,
    SCALES,
    SLIDING,
    SPEEDS,
    SPREAD,
    STAGE,
    STOPPED,
    WORK,
    X1,
    R,
    S,
    X,
    Y,
    Z,
    process_of,
)
from peg_on_hole_ros.estimation.memory import (
    SLOW as SLOW_PLACE,
)
from peg_on_hole_ros.estimation.parameters import correct_parameters
from peg_on_hole_ros.estimation.slip import (
    creep_variance,
    friction_scales,
    slip,
    slow_slip,
    surely_sliding,
)
from peg_on_hole_ros.estimation.step import CONVERGED, FAILED
from peg_on_hole_ros.estimation.steps_choice import (
    IMPLICIT_EULER,
    INACCURATE,
    LONG_STEP,
    SECOND_ORDER,
    contact_speed_gain,
    friction_slack,
    step_error,
    take_step,
)
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
# Of a prediction, beside the outcomes of a step.
SLOW = INACCURATE + 1
LIMITED = SLOW + 1


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
        CONVERGED; or with state and covariance untouched FAILED, SLOW where a slip is not told
        from none, LIMITED where the evaluations that are allowed were spent before.
    evaluations : int
        Of the six equations.
    pieces : int
        Steps of equal length that it took.

    """
    p = scene_of(m)
    process = process_of(m)
    x, u, u_stage = m[X : X + 6], m[ENDS : ENDS + 6], m[ENDS + 6 : ENDS + 12]
    x1, y = m[X1 : X1 + 6], m[Y : Y + 6]
    scales, work, stage = m[SCALES : SCALES + 3], m[WORK:], m[STAGE : STAGE + 192]
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
    smallest = process.slip_velocity_scale
    friction_scales(p, m, smallest, process.slip_widening)
    within = process.slow_slip
    if m[SLOW_PLACE] > 0.0:
        within *= RESUME_SOON if _learns_clearance(m) or _learns_offsets(m) else RESUME
    lately = min(dt / SELECTED_OVER, 1.0)
    if slow_slip(m, within):
        _note_step(m, 1.0, lately)
        return SLOW, 0, 0
    creep = m[CREEP] = creep_variance(p, m, smallest, process.creep_time)
    m[SLIDING] = surely_sliding(m)
    limit = CONTACT_ACCELERATION * max(dt, SHORTEST_INTERVAL)
    pieces = max(1, int(dt / process.max_step + 0.999999))
    evaluations, allowed = 0, m[METHOD + 2] * pieces
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
                    integrator, p, scales, x, u, h, x1, y, slopes, stage, work
                )
                evaluations += count
                if not error <= tolerance:
                    status = INACCURATE
            if status != CONVERGED:
                m[REFUSED + (1 if status == INACCURATE else 0)] += 1.0
                break
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
                move_wrench(m, -0.5)
                slow = slip_without_kink(p, m, dy, dt) < within * within
                move_wrench(m, 0.5)
                evaluations += 1
                _exchange(m, saved)
            if slow:
                for i in range(saved):
                    m[X + i] = m[SAVED + i]
                _note_step(m, 1.0, lately)
                return SLOW, evaluations, pieces
            _note_step(m, 0.0, 1.0 if surely else lately)
            # What a learnt clearance may be off by hides a slip as well, and selects nothing.
            if m[STOPPED] > SELECTED and not _learns_clearance(m):
                m[SLIDING] = 0.0
            add_jump(m, slopes, pieces, dt / pieces, integrator)
            for i in range(3):
                m[Z + 13 * i] += creep * dt
            if m[SPREAD] > 0.0:
                m[SPREAD] += process.friction_density * dt
            return CONVERGED, evaluations, pieces
        for i in range(saved):
            m[X + i] = m[SAVED + i]
        if status == LIMITED:
            return LIMITED, evaluations, pieces
        pieces *= 2
    return FAILED, evaluations, pieces


@inlined
def _keeps_on(begin, begin_variance, end, end_variance):
    """Return whether a slip is so sure at the begin and at the end that it kept its direction."""
    told = begin * begin > SURELY * SURELY * begin_variance
    return told and end > 0.5 * begin and end * end > SURELY * SURELY * end_variance


@inlined
def _learns_clearance(m):
    """Return whether the peg diameter is corrected, and not known."""
    return m[LEARNT + 1] * m[SPREAD + 3] > 0.0


@inlined
def _learns_offsets(m):
    """Return whether a bias of the sensor or a tilt of the hole is corrected."""
    return m[OFFSETS + 2] + m[OFFSETS + 3] > 0.0


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
    """Predict over dt at constant rates: no contact model, and the wrench drives nothing."""
    for i in range(3):
        for j in range(WIDTH):
            slopes[i, j] = 0.0
        slopes[i, 3 + i] = 1.0
        m[X + i] += dt * m[X + 3 + i]
    m[SLIDING] = 0.0
    carry(m, slopes, dt, rate_noise)


@compiled
def innovation(m, q):
    """
    Fill residual and lower Cholesky factor of the innovation covariance; R is in the memory.

    The measured psi and phi may be off by turns. Returns the normalised innovation squared
    (3 degrees of freedom).
    """
    for i in range(3):
        residual = q[i] - m[X + i]
        turns = 0.0 if i == 0 else floor(residual / (2.0 * pi) + 0.5)
        m[RESIDUAL + i] = residual - 2.0 * pi * turns
        for j in range(i + 1):
            total = m[Z + 12 * i + j] + m[R + 3 * i + j]
            for k in range(j):
                total -= m[S + 3 * i + k] * m[S + 3 * j + k]
            m[S + 3 * i + j] = sqrt(total) if i == j else total / m[S + 4 * j]
    w0, w1, w2 = white_innovation(m)
    return w0 * w0 + w1 * w1 + w2 * w2


@inlined
def white_innovation(m):
    """Return the innovation in the memory over the lower root of its covariance."""
    w0 = m[RESIDUAL] / m[S]
    w1 = (m[RESIDUAL + 1] - m[S + 3] * w0) / m[S + 4]
    return w0, w1, (m[RESIDUAL + 2] - m[S + 6] * w0 - m[S + 7] * w1) / m[S + 8]


@compiled
def widen_rates(m, dt, factor):
    """
    Widen as if the rates had been less well known since the last correction, dt [s] ago.

    Adds factor times the rates' covariance, and what it would have carried into the angles: a gain
    for the rates that overshoots, as scaling their rows and columns alone gives, is excluded.
    """
    for i in range(3):
        for j in range(3):
            added = factor * m[Z + 39 + 12 * i + j]
            m[Z + 12 * i + j] += dt * dt * added
            m[Z + 36 + 12 * i + j] += dt * added
            m[Z + 3 + 12 * i + j] += dt * added
    for i in range(3):
        for j in range(3):
            m[Z + 39 + 12 * i + j] *= 1.0 + factor


@compiled
def correct(m):
    """
    Correct with an orientation, in Joseph's form on the joint covariance.

    State, held wrench and joint covariance are changed: an orientation also tells something of
    the noise in the wrench that led to it. Residual, Cholesky factor and R are those that
    `innovation` left in the memory.
    """
    l10, l20, l21 = m[S + 3], m[S + 6], m[S + 7]
    o0, o1, o2 = 1.0 / m[S], 1.0 / m[S + 4], 1.0 / m[S + 8]
    e0, e1, e2 = m[RESIDUAL], m[RESIDUAL + 1], m[RESIDUAL + 2]
    for i in range(12):
        g0 = m[Z + i] * o0
        g1 = (m[Z + 12 + i] - l10 * g0) * o1
        g2 = (m[Z + 24 + i] - l20 * g0 - l21 * g1) * o2 * o2
        g1 = (g1 - l21 * g2) * o1
        g0 = (g0 - l10 * g1 - l20 * g2) * o0
        m[GAIN + i], m[GAIN + 12 + i], m[GAIN + 24 + i] = g0, g1, g2
    # The wrench follows the state in the memory.
    for i in range(12):
        m[X + i] += m[GAIN + i] * e0 + m[GAIN + 12 + i] * e1 + m[GAIN + 24 + i] * e2
    if m[SPREAD] > 0.0 or m[SPREAD + 3] > 0.0:
        correct_parameters(m)
    for i in range(12):
        g0, g1, g2 = m[GAIN + i], m[GAIN + 12 + i], m[GAIN + 24 + i]
        for j in range(12):
            m[JOSEPH + 12 * i + j] = m[Z + 12 * i + j] - (
                g0 * m[Z + j] + g1 * m[Z + 12 + j] + g2 * m[Z + 24 + j]
            )
    for i in range(12):
        g0, g1, g2 = m[GAIN + i], m[GAIN + 12 + i], m[GAIN + 24 + i]
        at = JOSEPH + 12 * i
        k0 = g0 * m[R] + g1 * m[R + 3] + g2 * m[R + 6] - m[at]
        k1 = g0 * m[R + 1] + g1 * m[R + 4] + g2 * m[R + 7] - m[at + 1]
        k2 = g0 * m[R + 2] + g1 * m[R + 5] + g2 * m[R + 8] - m[at + 2]
        for j in range(12):
            m[Z + 12 * i + j] = m[at + j] + (
                k0 * m[GAIN + j] + k1 * m[GAIN + 12 + j] + k2 * m[GAIN + 24 + j]
            )
    for i in range(12):
        for j in range(i):
            m[Z + 12 * j + i] = m[Z + 12 * i + j]
