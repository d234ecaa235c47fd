"""Where the numbers of one filter lie: one flat array that all of its compiled code works in."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.kernel.process import Process
from peg_on_hole_ros.mechanics.kernel import SceneScalars, inlined, workspace

# One array, because an array handed to compiled code costs as much as 50 multiplications and a
# named tuple of them ten times that, and because loops over fixed places in one array become
# vector instructions: the compiler sees that they do not overlap. In brackets: what sets a place
# that lives from one call to the next, by its function or as a method of the filter.
_SIZES = {
    "SCENE": len(SceneScalars._fields),
    "PROCESS": len(Process._fields),
    "X": 6,  # state
    "U": 6,  # wrench that is held
    "Z": 144,  # joint covariance of state and wrench, (12, 12) by rows
    "CROSS": 24,  # covariance of friction and of the peg diameter with state and wrench, (2, 12)
    "SPREAD": 4,  # covariance of friction and peg diameter, (2, 2)
    "OFFSET_CROSS": 96,  # covariance of bias and hole tilt with state and wrench, (8, 12)
    "OFFSET_SPREAD": 80,  # of them with friction, peg diameter and one another, (8, 10)
    "GIVEN": 6,  # wrench that was held last, before any bias was taken off
    "OFFSET": 8,  # bias at the sensor (6) and tilt of the hole (2), see offsets
    # Of the time in the air so far: readings in three blocks of 15; how much of each bias they
    # have told and that times what they have told of it (hang, touched).
    "AIR": 45,
    "AIR_TOLD": 12,
    "LEARNT": 2,  # 1: friction, peg diameter are corrected; 0: only their spread counts
    "OFFSETS": 4,  # first and beyond last that is not known; 1: bias, tilt are corrected
    "INTERVAL": 1,  # from the last correction to this one [s] (correct)
    # 1: what that told of friction or peg diameter was not taken in full (learning_shares)
    "HELD_BACK": 1,
    "SLIDING": 1,  # 1: every contact surely slides (predict_contact, predict_free)
    "SLID": 1,  # 1: they did in a step since the last correction (predict; correct ends it)
    "ON_CONTACTS": 1,  # 1: the last prediction was on three contacts (predict)
    "SLOW": 1,  # 1: a slip is not told from none (predict)
    "BRIDGED": 1,  # 1: the last prediction was at constant rates (bridge; predict ends it)
    # For how long the contact equations have given no step [s] (bridge_without_step).
    "WITHOUT_STEP": 1,
    # Share of the steps of late that were not believed, see `prediction.SELECTED`
    # (predict_contact; predict ends it in the air).
    "STOPPED": 1,
    # By how much the wrench goes in its interval (hold_wrench); shares gone before, at the end
    # (predict).
    "RAMP": 8,
    "CHANGE": 6,  # of the wrench, from the one before to the one that is held (hold_wrench)
    "JUMP": 6,  # by how much it may have differed from the ramp, a standard deviation
    "ACCELERATION": 3,  # as the rates went of late (follow_acceleration, with the next four)
    "RATES_BEFORE": 3,  # at the last correction
    "ACCELERATION_BEFORE": 3,  # as it went of before
    "CHANGES": 3,  # mean square of its changes
    "CHANGES_SEEN": 1,  # share of them that was seen
    "SINCE_CORRECTION": 1,  # time predicted since the last one [s] (predict)
    "MEAN_RATES": 3,  # of late, each with its weight [s/(rad/s)^2] (follow_rates)
    "RATES_WEIGHT": 3,
    "AT_MEAN": 1,  # 1: the last prediction's tangents are at the mean rates (predict_contact)
    "RATES_KNOWN": 1,  # 1: the rates at the last correction are known (follow_acceleration)
    # Random walk of the rates where they are bridged [rad/s^1.5] (adapt_rate_noise,
    # bridge_without_step).
    "RATE_NOISE": 1,
    "LEAN": 3,  # mean of the white innovations of late, bridged (adapt_rate_noise)
    "STEPS_LEAN": 3,  # and of steps (follow_steps)
    # Constant rates beside the estimate: state, covariance (6, 6), for how long they have been
    # predicted since the last correction [s], and what is above of the same name
    # (correct_beside).
    "BESIDE_X": 6,
    "BESIDE_P": 36,
    "BESIDE_SINCE": 1,
    "BESIDE_RATE_NOISE": 1,
    "BESIDE_LEAN": 3,
    "BESIDE_ACCELERATION": 3,
    "BESIDE_RATES_BEFORE": 3,
    "BESIDE_ACCELERATION_BEFORE": 3,
    "BESIDE_CHANGES": 3,
    "BESIDE_CHANGES_SEEN": 1,
    # For how much longer rates are kept that were taken from there [s]
    # (resume_constant_rates).
    "KEPT_FOR": 1,
    "DOUBT": 1,  # 1: they lean too far (follow_steps)
    "STATED": 2,  # friction as it was stated, and its variance
    # Friction and its variance after the last correction, and how far it lags behind what
    # corrections tell (follow_friction, take_friction).
    "FRICTION_LAG": 3,
    # By which balance told of friction in the last interval that told (learn_from_balance).
    "TOLD_GAIN": 3,
    # Of what was not known of it; 0: nothing was told (predict ends it in the air).
    "TOLD_SHARE": 1,
    # 1: forces were weighed, and by how much they were off, white (learn_from_balance; predict
    # ends it).
    "UNBALANCE": 4,
    "METHOD": 3,  # the integrator's number and tolerance; evaluations for each max_step
    "NOISE": 36,  # covariance of a new wrench, (6, 6)
    "WEIGHT": 36,  # its inverse
    "JUMPED": 6,  # what JUMP made of the state in a prediction
    "ENDS": 18,  # wrench of a step: at its end, its first stage, its begin (wrench_of_piece)
    "METHOD_USED": 1,  # the integrator's number in the last prediction
    "SCALES": 3,  # velocity scales of friction
    "SPEEDS": 6,  # slip speed and its variance at K, B1, B2
    "ACROSS": 3,  # variance of these slips across themselves, friction left out [m^2/s^2]
    "X1": 6,  # state at the end of a step
    "Y": 6,  # accelerations and reactions
    "SAVED": 280,  # X, U, Z, CROSS, SPREAD and OFFSET_CROSS before a prediction
    "BEGIN": 90,  # accelerations and reactions there, (6,), and their derivatives, (6, 14)
    "ROWS": 72,  # (6, 12)
    "GAIN": 36,  # of a correction, transposed, (3, 12)
    "JOSEPH": 144,
    "RESIDUAL": 3,
    "S": 9,  # lower Cholesky factor of the innovation's covariance, (3, 3)
    "R": 9,  # covariance of the measured angles, (3, 3)
    "REACTIONS": 36,  # covariance of Y, (6, 6)
    "LASTING": 12,  # what friction and peg diameter make of Y, a standard deviation, (2, 6)
    # What is found for Y; what it is found from in a slow slip, and what a lower friction makes of
    # it, (3, 6).
    "ANSWERS": 18,
    "SURPRISE": 1,  # how far it was from what a held peg can accelerate, squared
    # What unknown friction makes of Y, see `slow_friction`, (12, 6), and for each newton of the
    # reaction that it is with.
    "FRICTION": 72,
    "PER_NEWTON": 72,
    "WITH": 12,  # covariance of what was computed with friction and peg diameter, (6, 2)
    "STAGE": 96,  # of a step of two stages or of second derivatives, see steps.choice
    "REFUSED": 2,  # attempts at a prediction refused: no step found, error above its tolerance
    "LOAD": 48,  # from the offsets to the wrench on the peg, (6, 8)
    "UNLOAD": 36,  # back from that to a bias, (6, 6)
    # Of a bias that is read from a peg in the air: variance of one reading, what it is off by for
    # each (m/s^2)^2 that moves the peg, and what an uncertain tilt makes of it, (3, 6).
    "HANGING": 18,
    "MASSES": 18,  # from gravity in peg axes to the wrench of peg and payload, (6, 3)
    "GRAVITY": 3,  # in the axes of the configured hole
    "TURN": 6,  # from a tilt of the hole to errors of the measured angles, (3, 2)
    "JOINT": 484,  # joint covariance with all parameters, (22, 22), while it is corrected
    "SEEN": 66,  # its covariance with what is measured, (22, 3)
    "GAINS": 66,
    "WORK": len(workspace()),
}


class Cleared(NamedTuple):
    """
    Names of the places that are cleared when something begins anew; what is not here outlives it.

    Attributes
    ----------
    start : tuple of str
        A motion. The wrench outlives it, and what was learnt of friction, peg diameter, offsets.
    let_go : tuple of str
        The wrenches.
    forget : tuple of str
        What is learnt of friction, peg diameter and offsets.

    """

    start: tuple[str, ...]
    let_go: tuple[str, ...]
    forget: tuple[str, ...]


CLEARED = Cleared(
    start=(
        "X", "Z", "CROSS", "OFFSET_CROSS", "SCALES", "SLID", "ON_CONTACTS", "SLOW", "BRIDGED",
        "WITHOUT_STEP", "STOPPED", "ACCELERATION", "RATES_BEFORE", "ACCELERATION_BEFORE",
        "CHANGES", "CHANGES_SEEN", "SINCE_CORRECTION", "RATES_KNOWN", "RATE_NOISE", "LEAN",
        "STEPS_LEAN", "BESIDE_X", "BESIDE_P", "BESIDE_SINCE", "BESIDE_RATE_NOISE",
        "BESIDE_LEAN", "BESIDE_ACCELERATION",
        "BESIDE_RATES_BEFORE", "BESIDE_ACCELERATION_BEFORE", "BESIDE_CHANGES",
        "BESIDE_CHANGES_SEEN", "KEPT_FOR", "DOUBT", "TOLD_GAIN", "TOLD_SHARE", "MEAN_RATES",
        "RATES_WEIGHT", "AIR", "AIR_TOLD",
    ),
    let_go=("U", "GIVEN", "CHANGE", "RAMP", "JUMP"),
    forget=(
        "SCENE", "SPREAD", "CROSS", "FRICTION_LAG", "OFFSET", "OFFSET_SPREAD", "OFFSET_CROSS",
        "AIR", "AIR_TOLD", "PROCESS",
    ),
)  # fmt: skip


def _places():
    at = np.cumsum([0, *_SIZES.values()])
    return {name: int(place) for name, place in zip(_SIZES, at)}, int(at[-1])


_AT, SIZE = _places()
SCENE, PROCESS, X, U, Z = (_AT[name] for name in ("SCENE", "PROCESS", "X", "U", "Z"))
# The rates' own covariance within Z, in rows of 12: entry (i, j) at RATES + 12 i + j.
RATES = Z + 39
CROSS, SPREAD, LEARNT, SLIDING = (_AT[name] for name in ("CROSS", "SPREAD", "LEARNT", "SLIDING"))
NOISE, SCALES, SPEEDS, X1, Y = (_AT[name] for name in ("NOISE", "SCALES", "SPEEDS", "X1", "Y"))
SLOW, BRIDGED, WITHOUT_STEP, RATE_NOISE, FRICTION = (
    _AT[name] for name in ("SLOW", "BRIDGED", "WITHOUT_STEP", "RATE_NOISE", "FRICTION")
)
RAMP, CHANGE, JUMP = (_AT[name] for name in ("RAMP", "CHANGE", "JUMP"))
JUMPED, WEIGHT = _AT["JUMPED"], _AT["WEIGHT"]
ACCELERATION, ENDS, METHOD_USED = (_AT[name] for name in ("ACCELERATION", "ENDS", "METHOD_USED"))
CHANGES, RATES_KNOWN, SINCE_CORRECTION = (
    _AT[name] for name in ("CHANGES", "RATES_KNOWN", "SINCE_CORRECTION")
)
SAVED, ROWS, GAIN, JOSEPH = (_AT[name] for name in ("SAVED", "ROWS", "GAIN", "JOSEPH"))
RESIDUAL, S, R = (_AT[name] for name in ("RESIDUAL", "S", "R"))
REACTIONS, ANSWERS, SURPRISE, WITH, WORK = (
    _AT[name] for name in ("REACTIONS", "ANSWERS", "SURPRISE", "WITH", "WORK")
)
OFFSET, OFFSETS, OFFSET_CROSS, OFFSET_SPREAD = (
    _AT[name] for name in ("OFFSET", "OFFSETS", "OFFSET_CROSS", "OFFSET_SPREAD")
)
AIR, AIR_TOLD, UNLOAD, HANGING = (_AT[name] for name in ("AIR", "AIR_TOLD", "UNLOAD", "HANGING"))
ACROSS, BEGIN, PER_NEWTON = _AT["ACROSS"], _AT["BEGIN"], _AT["PER_NEWTON"]
LASTING, STOPPED = _AT["LASTING"], _AT["STOPPED"]
LEAN, ON_CONTACTS = _AT["LEAN"], _AT["ON_CONTACTS"]
BESIDE_X, BESIDE_P, BESIDE_SINCE, BESIDE_RATE_NOISE, BESIDE_LEAN, BESIDE_ACCELERATION = (
    _AT[f"BESIDE_{name}"] for name in ("X", "P", "SINCE", "RATE_NOISE", "LEAN", "ACCELERATION")
)
STEPS_LEAN = _AT["STEPS_LEAN"]
KEPT_FOR = _AT["KEPT_FOR"]
GIVEN = _AT["GIVEN"]
DOUBT, STATED = _AT["DOUBT"], _AT["STATED"]
FRICTION_LAG = _AT["FRICTION_LAG"]
MEAN_RATES, RATES_WEIGHT, AT_MEAN = (
    _AT[name] for name in ("MEAN_RATES", "RATES_WEIGHT", "AT_MEAN")
)
TOLD_GAIN, TOLD_SHARE = _AT["TOLD_GAIN"], _AT["TOLD_SHARE"]
UNBALANCE = _AT["UNBALANCE"]
RATES_BEFORE, ACCELERATION_BEFORE, CHANGES_SEEN = (
    _AT[name] for name in ("RATES_BEFORE", "ACCELERATION_BEFORE", "CHANGES_SEEN")
)
INTERVAL, HELD_BACK = _AT["INTERVAL"], _AT["HELD_BACK"]
LOAD, MASSES, GRAVITY, TURN = (_AT[name] for name in ("LOAD", "MASSES", "GRAVITY", "TURN"))
JOINT, SEEN, GAINS = (_AT[name] for name in ("JOINT", "SEEN", "GAINS"))
METHOD, STAGE, REFUSED = (_AT[name] for name in ("METHOD", "STAGE", "REFUSED"))


def part(memory: np.ndarray, name: str, shape=None) -> np.ndarray:
    """Return a view of one part of the memory by its name, in a shape."""
    view = memory[_AT[name] : _AT[name] + _SIZES[name]]
    return view if shape is None else view.reshape(shape)


def clear(memory: np.ndarray, names: tuple[str, ...]) -> None:
    """Set parts of the memory to zero, see `CLEARED`."""
    for name in names:
        part(memory, name)[:] = 0.0


@inlined
def process_of(m):
    """Return how far the contact dynamics are trusted, as it lies in the memory."""
    q = PROCESS
    return Process(
        m[q], m[q + 1], m[q + 2], m[q + 3], m[q + 4], m[q + 5], m[q + 6], m[q + 7]
    )  # fmt: skip


@inlined
def add_parameters(m, slopes, count):
    """
    Add the part of friction and peg diameter to ROWS, and fill WITH.

    Parameters
    ----------
    m : ndarray
        Memory; ROWS holds G Z for `count` rows, G = d(what is computed)/d(state, wrench).
    slopes : ndarray, shape (count, 14)
        G, and in columns 12, 13 the derivatives by friction and peg diameter.
    count : int

    """
    for i in range(count):
        by_f, by_d = slopes[i, 12], slopes[i, 13]
        with_f = by_f * m[SPREAD] + by_d * m[SPREAD + 2]
        with_d = by_f * m[SPREAD + 1] + by_d * m[SPREAD + 3]
        for j in range(12):
            m[ROWS + 12 * i + j] += by_f * m[CROSS + j] + by_d * m[CROSS + 12 + j]
            with_f += slopes[i, j] * m[CROSS + j]
            with_d += slopes[i, j] * m[CROSS + 12 + j]
        m[WITH + 2 * i], m[WITH + 2 * i + 1] = with_f, with_d


@inlined
def row_of(a, i):
    """Return a row of 12 as scalars, for use in a loop over columns."""
    return (
        a[i, 0], a[i, 1], a[i, 2], a[i, 3], a[i, 4], a[i, 5],
        a[i, 6], a[i, 7], a[i, 8], a[i, 9], a[i, 10], a[i, 11],
    )  # fmt: skip


@inlined
def times_Z(row, m, j):
    """Return one entry of a row times Z; in a loop over j, four or eight at a time."""
    z = Z + j
    return (
        row[0] * m[z] + row[1] * m[z + 12] + row[2] * m[z + 24] + row[3] * m[z + 36]
        + row[4] * m[z + 48] + row[5] * m[z + 60] + row[6] * m[z + 72] + row[7] * m[z + 84]
        + row[8] * m[z + 96] + row[9] * m[z + 108] + row[10] * m[z + 120] + row[11] * m[z + 132]
    )  # fmt: skip


@inlined
def times_covariance(m, slopes, count):
    """
    Fill ROWS with G Z, and WITH where friction or peg diameter are uncertain.

    Parameters
    ----------
    m : ndarray
        Memory.
    slopes : ndarray, shape (count or more, 14)
        G by rows: by state, wrench, friction and peg diameter.
    count : int

    Returns
    -------
    uncertain : bool
        Whether friction or peg diameter take part.

    """
    for i in range(count):
        row = row_of(slopes, i)
        for j in range(12):
            m[ROWS + 12 * i + j] = times_Z(row, m, j)
    uncertain = m[SPREAD] > 0.0 or m[SPREAD + 3] > 0.0
    if uncertain:
        add_parameters(m, slopes, count)
    return uncertain


@inlined
def covariance_entry(m, slopes, i, j, uncertain):
    """Return one entry of G Z G.T, after `times_covariance`."""
    total = 0.0
    if uncertain:
        total = m[WITH + 2 * i] * slopes[j, 12] + m[WITH + 2 * i + 1] * slopes[j, 13]
    for k in range(12):
        total += m[ROWS + 12 * i + k] * slopes[j, k]
    return total


@inlined
def fill_lasting(m, uncertain):
    """Fill LASTING after `times_covariance` of Y: friction and diameter each by themselves."""
    for n in range(2):
        variance = m[SPREAD + 3 * n] if uncertain else 0.0
        over = 1.0 / sqrt(variance) if variance > 0.0 else 0.0
        for i in range(6):
            m[LASTING + 6 * n + i] = m[WITH + 2 * i + n] * over
