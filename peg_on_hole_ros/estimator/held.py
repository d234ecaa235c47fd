"""A held peg's estimate, compiled: start, let go, predict, hold against, correct, weigh."""

from math import isfinite, sqrt

import numpy as np

from peg_on_hole_ros.estimator import insertion_depth, step
from peg_on_hole_ros.estimator.contact import leaning_gravity
from peg_on_hole_ros.estimator.free import hang
from peg_on_hole_ros.estimator.mixture import predict
from peg_on_hole_ros.estimator.noise import follow_noise
from peg_on_hole_ros.estimator.record import Estimate, fill_record
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.estimator.state import (
    BIAS,
    FRICTION,
    MOST_LEVELS,
    MOST_WIDTH,
    OPEN,
    QUANTITIES,
    SCRATCH,
    STATE,
    TILT,
    WIDTHS,
)
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled, scene_of
from peg_on_hole_ros.record_types import GatesRecord, HeldRecord
from peg_on_hole_ros.typed_record import dtype_of

# What becomes of an orientation; LOST: the covariance was no longer one.
USED, GATED, RESET, LOST = range(4)
# Places in `begin` of HELD: friction and its deviation at the next start, orientations that were
# refused in a row.
BEGIN_FRICTION, BEGIN_STDDEV, REFUSED = range(3)


# The tuned constants for compiled code, with how many levels there are.
SETTINGS = np.dtype(
    [("levels", np.int64)]
    + [
        (name, float, (MOST_LEVELS,) if name in ("level", "time", "up") else ())
        for name in Settings._fields
        if name not in ("frictions", "passes")
    ]
    + [("frictions", np.int64), ("passes", np.int64)]
)


# All that an estimate is made of; what it depends on from one step to the next stands at the end.
HELD = np.dtype(
    [
        ("scratch", SCRATCH),
        ("constants", SETTINGS),
        ("scene", float, (len(SceneScalars._fields),)),  # as stated, see `scene_of`
        ("at", np.int64, (len(QUANTITIES),)),  # places of what is open
        ("n", np.int64),  # how many values are estimated
        ("walk", float, (MOST_WIDTH,)),  # variance that each gains in a second
        ("wander", float, (6,)),  # variance that the zero gains in a second in the air
        ("learnt", float, (MOST_WIDTH,)),  # which of them are learnt
        ("bias_map", float, (6, 6)),  # from a bias to what it adds to a wrench on the peg
        ("friction_open", np.int64),  # whether friction has a spread
        ("noise", float, (6, 6)),  # covariance of a wrench on the peg
        ("u", float, (6,)),  # the last wrench on the peg [N], [N m]
        ("record", dtype_of(Estimate)),  # all that it has said
        ("open_mean", float, (sum(WIDTHS),)),  # what is open at the next start
        ("open_stddev", float, (sum(WIDTHS),)),
        ("begin", float, (3,)),
        ("doubt", float, (2,)),  # variance by which the tilt is known less than it is learnt
        ("state", STATE),
    ]
)


def fill_settings(record: np.void, settings: Settings) -> None:
    """Fill in a record of SETTINGS."""
    levels = len(settings.level)
    record["levels"] = levels
    for name, value in settings._asdict().items():
        if isinstance(value, np.ndarray):
            record[name][:levels] = value
        else:
            record[name] = value


# When an orientation is refused, and how a start begins; see `FilterOptions`.
GATES = np.dtype(
    [("gate_threshold", float), ("gate_reset_count", float), ("initial_rate_stddev", float)]
)


@compiled
def doubt_tilt(h: HeldRecord) -> None:
    """
    Widen what is told where a tilt has moved by more than what was learnt of it accounts for.

    A mean that is learnt moves with the variance that learning takes away. One that moves further
    is pushed by what is no tilt, as by gears that bend: it may as well be where it began, however
    much is learnt from there on.
    """
    at, s = h.at[TILT], h.state
    if at < 0 or h.learnt[at] == 0.0:
        return
    C = s.covariance
    for i in range(at, at + 2):
        begun = h.open_stddev[i - OPEN]
        moved, taken = s.mean[i] - h.open_mean[i - OPEN], max(begun * begun - C[i, i], 0.0)
        more = max(h.doubt[i - at], moved * moved - h.constants.sure**2 * taken)
        if not (more > 0.0 and C[i, i] > 0.0):
            continue
        h.doubt[i - at] = more
        # All that depends on the tilt moves with it.
        along = C[i].copy() / C[i, i]
        for a in range(h.n + 3):
            for b in range(h.n + 3):
                C[a, b] += more * along[a] * along[b]


@compiled
def _combine(h):
    step.combine(h.state, h.n)
    doubt_tilt(h)


@compiled
def fill(h: HeldRecord) -> None:
    """Fill in the record."""
    fill_record(
        h.record, h.state, h.at, h.n, scene_of(h.scene), h.u, h.bias_map,
        h.constants.direction_share, h.scratch.left,
    )  # fmt: skip


@compiled
def start(h: HeldRecord, gates: GatesRecord, q: np.ndarray, R: np.ndarray) -> None:
    """Start from an orientation q [rad] with the stated covariance R, at unknown rates."""
    step.start(
        h.state, h.scratch, h.constants, h.at, h.n, q, h.state.noise[0] * R,
        gates.initial_rate_stddev, h.begin[BEGIN_FRICTION], h.begin[BEGIN_STDDEV], h.open_mean,
        h.open_stddev,
    )  # fmt: skip
    h.begin[REFUSED] = h.doubt[0] = h.doubt[1] = 0.0
    fill(h)


@compiled
def let_go(h: HeldRecord) -> None:
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


@compiled
def move_on(h: HeldRecord, dt: float) -> None:
    """Predict by dt [s]."""
    predict(h.state, h.scratch, h.constants, h.walk, h.n, dt)
    step.pass_time(h.state, dt)
    _combine(h)


@compiled
def hold_against(
    h: HeldRecord, gates: GatesRecord, q: np.ndarray, R: np.ndarray
) -> tuple[int, float]:
    """
    Hold the estimate against an orientation, without any correction; a jump widens it.

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
        further = step.departs_further(h.state, h.scratch, R)
        # One alone is an outlier; a second in a row tells of a jump.
        if not (
            h.begin[REFUSED] > 0.0
            and further
            and step.jump_to(h.state, h.scratch, h.constants, h.at, q, R, gates.gate_threshold)
        ):
            h.begin[REFUSED] += 1.0
            return (GATED if h.begin[REFUSED] <= gates.gate_reset_count else RESET), nis
    h.begin[REFUSED] = 0.0
    return USED, nis


@compiled
def orient(h: HeldRecord, q: np.ndarray, R: np.ndarray) -> None:
    """Correct by an orientation that is used."""
    step.orient(h.state, h.scratch, h.constants, h.at, h.n, h.learnt, q, R)
    _combine(h)


@compiled
def sink(h: HeldRecord, depth: float, variance: float, since: float) -> None:
    """Correct by a measured depth [m], [m^2], so long after the one before [s]."""
    p = scene_of(h.scene)
    if insertion_depth.sink(
        h.state, h.scratch, h.constants, p, h.at, h.n, h.learnt, depth, variance, since
    ):
        _combine(h)


@compiled
def correct(h: HeldRecord, gates: GatesRecord, q: np.ndarray, R: np.ndarray) -> tuple[int, float]:
    """Correct with an orientation, or start from it; return what `hold_against` does."""
    result, nis = hold_against(h, gates, q, R)
    if result == USED:
        orient(h, q, R)
    elif result != GATED:
        if result == RESET:
            let_go(h)
        start(h, gates, q, R)
    return result, nis


@compiled
def weigh(h: HeldRecord, u: np.ndarray, contacts: int) -> None:
    """Take a wrench on the peg, and fill in the record; contacts as for `step.weigh`."""
    h.u[:] = u
    if not isfinite(h.state.mean[0]):
        return
    # A motion that the wrench drives leaves nothing to tell a bias from.
    if contacts == 0 and h.at[BIAS] >= 0 and isfinite(h.constants.time[0]):
        _let_zero_wander(h)
        walk = h.walk[h.at[BIAS] : h.at[BIAS] + 6] + h.wander
        hang(
            h.state, h.scratch, h.constants, scene_of(h.scene), h.at, h.n, h.learnt, h.u, h.noise,
            h.bias_map, walk,
        )  # fmt: skip
    else:
        h.state.air[:, :] = 0.0
    step.weigh(
        h.state, h.scratch, h.constants, scene_of(h.scene), h.at, h.n, h.learnt, h.u, h.noise,
        h.bias_map, contacts,
    )  # fmt: skip
    doubt_tilt(h)
    fill(h)


@compiled
def _let_zero_wander(h: HeldRecord) -> None:
    """Let the zero be what it may have become since the last wrench, while nothing touches."""
    s, first = h.state, h.at[BIAS]
    for j in range(s.components):
        if s.alive[j // h.constants.levels] > 0.0:
            for i in range(6):
                s.P[j, first + i, first + i] += h.wander[i] * s.step[0]


@compiled
def gravity(h: HeldRecord) -> tuple[float, float, float]:
    """Return gravity in the axes of the hole as it is now taken to lie [m/s^2]."""
    return leaning_gravity(scene_of(h.scene), h.state.mean, h.at)
