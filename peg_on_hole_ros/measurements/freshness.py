"""Which orientations are news, where drivers repeat values under fresh stamps."""

from math import sqrt

from peg_on_hole_ros.estimator.state import RATE
from peg_on_hole_ros.measurements.angles import turn_between, turn_size
from peg_on_hole_ros.measurements.repeats import Repeats, describe, held, notice
from peg_on_hole_ros.measurements.tuned import REPEATED_VALUES
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats, Record, Vector3


class Oriented(Record):
    """
    An orientation as it was measured.

    Attributes
    ----------
    q : shape (3,)
        gamma, psi, phi [rad].
    variance
        Of gamma [rad^2]; 0: none was measured.

    """

    q: Vector3
    variance: float


class Freshness(Record):
    """
    How often the values of joint states come, and whether the peg has turned away from them.

    Attributes
    ----------
    joints : Repeats
    angles : shape (3,)
        The latest gamma, psi, phi [rad], as they came.
    left : bool
        Whether the peg has turned away from the orientation that is repeated.
    still, stuck : bool, float
        Whether that has lasted long enough to be reported, and for how long it has, at most [s].
    oriented : Oriented
        The latest orientation.

    """

    joints: Repeats
    angles: Vector3
    left: bool
    still: bool
    stuck: float
    oriented: Oriented


@compiled
def is_news(
    fresh: Freshness,
    t_ns: int,
    q: Floats,
    stddev2: float,
    x: Floats,
    variance: float,
) -> bool:
    """
    Process an orientation; return whether it is news.

    Encoders at rest, and coarse ones, repeat what is true. So a repeated value is none where each
    comes several times as a rule, or where the peg has turned away from it; of a peg that moves it
    is left out until it would be reported, when that shows.

    Parameters
    ----------
    fresh : Freshness
        Changed.
    t_ns : int
        Stamp [ns].
    q : ndarray, shape (3,)
        gamma, psi, phi as measured [rad].
    stddev2 : float
        Variance of gamma [rad^2].
    x : ndarray
        gamma, psi, phi as predicted, and their rates [rad], [rad/s].
    variance : float
        Of the prediction's tilt [rad^2].

    """
    t = t_ns * 1e-9
    for i in range(3):
        fresh.oriented.q[i] = q[i]
    fresh.oriented.variance = stddev2
    if notice(fresh.joints, t, q, fresh.angles) == 1:
        fresh.left = fresh.still = False
        return True
    if held(fresh.joints) > 1:
        return False
    noise = REPEATED_VALUES.turned * sqrt(stddev2 + max(variance, 0.0))
    seconds = t - fresh.joints.since
    # The prediction's spread grows without news: what has left a value does not come back.
    if turn_between(q, x) > noise:
        fresh.left = True
    if fresh.left:
        fresh.still = seconds > REPEATED_VALUES.reported
        fresh.stuck = max(fresh.stuck, seconds)
    # If it were used at once, it would stop the prediction that has to show the difference.
    moves = REPEATED_VALUES.reported * turn_size(q[0], x[RATE], x[RATE + 1], x[RATE + 2]) > noise
    return not fresh.left and (seconds > REPEATED_VALUES.reported or not moves)


def causes(fresh: Freshness) -> list[str]:
    """Return what is reported to a user: a line, or none."""
    if repeats := describe(fresh.joints):
        return [f"joints: {repeats}"]
    if fresh.stuck <= REPEATED_VALUES.reported:
        return []
    return [
        f"joints: joint states that do not change for {fresh.stuck:.2f} s while the peg "
        "turns: the encoders or their driver stand still; they are not used"
    ]
