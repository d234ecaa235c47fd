"""The last second of wrenches, and how likely each of them is under each hypothesis."""

from math import fabs, sqrt

import numpy as np

from peg_on_hole_ros.diagnosis.balance import (
    MODELS,
    contact_columns,
    fill_moment,
    free_columns,
    friction_step,
    likelihood,
    peg_in_hole,
    prepare,
    unexplained,
)
from peg_on_hole_ros.diagnosis.tuned import LOOK_WINDOW, WRENCH_BALANCE
from peg_on_hole_ros.mechanics.kernel import compiled, scene_of

# Of one wrench: stamp [s], wrench (6), angles (3), how far it is looked at, and squares of
# what is left as stated.
_T, _WRENCH, _Q, _LOOKED, _LEFT = 0, 1, 7, 10, 11
ROW = 12
_ALONE, _WITH_RATES, _TRIED, _TRIED_WITH_RATES = 1.0, 2.0, 3.0, 4.0
# What is known of the wrench: scene (11), sensor (3), payload's mass and centre (4), noise (6),
# free acceleration's variance of force, lever, base axes in the hole (9), frictions (3),
# speed of rest, noise of the angles.
SCENE, SENSOR, PAYLOAD, NOISE, CARRIED, LEVER, BASE, FRICTION = 0, 11, 14, 18, 24, 25, 26, 35
REST = FRICTION + WRENCH_BALANCE.frictions
ANGLE = REST + 1
SETTINGS = ANGLE + 1


@compiled
def take(
    rows: np.ndarray,
    told: np.ndarray,
    at: int,
    hypotheses: np.ndarray,
    settings: np.ndarray,
    judged: bool,
) -> bool:
    """
    Look at the newest wrench, and anew at the one whose rates are known by it.

    Parameters
    ----------
    rows : ndarray, shape (kept, ROW)
        A ring; the newest is filled in but for what was looked at.
    told : ndarray, shape (kept, n, 3)
        Under each hypothesis: log likelihood, squares of what free air or three contacts leave of
        a wrench over the noise, at most `nothing`, and what they leave unbalanced [N]; filled.
    at : int
        Place of the newest; the next is the oldest.
    hypotheses : ndarray, shape (n, WIDTH)
        The first is what is stated.
    settings : ndarray, shape (SETTINGS,)
    judged : bool
        Whether other hypotheses than the first are to be looked at.

    Returns
    -------
    bool
        Whether wrenches surprise, more than noise does: else no other hypothesis is looked at.

    """
    rows[at, _LOOKED] = 0.0
    _look(rows, told, at, hypotheses[:1], settings)
    _look(rows, told, (at - LOOK_WINDOW.side) % LOOK_WINDOW.kept, hypotheses[:1], settings)
    odd = kept = 0
    for k in range(LOOK_WINDOW.kept):
        kept += rows[k, _LOOKED] > 0.0
        odd += rows[k, _LOOKED] > 0.0 and rows[k, _LEFT] > LOOK_WINDOW.surprise
    surprising = odd > LOOK_WINDOW.share * kept
    if surprising and judged:
        for k in range(LOOK_WINDOW.kept):
            if 0.0 < rows[k, _LOOKED] < _TRIED:
                _look(rows, told, k, hypotheses, settings)
    return surprising


@compiled
def _rates(rows, at, rates):
    """
    Fill in the slopes of the angles about a wrench.

    Returns their spread for angles with a spread of 1, below 0 where its neighbours are not there.
    """
    middle = rows[at, _T]
    spread = 0.0
    rates[:] = 0.0
    before = -1e300
    for k in range(-LOOK_WINDOW.side, LOOK_WINDOW.side + 1):
        i = (at + k) % LOOK_WINDOW.kept
        t = rows[i, _T] - middle
        # Of a ring that is not full, or of what came before a pause.
        if rows[i, _LOOKED] < 0.0 or not before < t or fabs(t) > 0.2:
            return -1.0
        before = t
        spread += t * t
        for j in range(3):
            rates[j] += t * (rows[i, _Q + j] - rows[at, _Q + j])
    for j in range(3):
        rates[j] /= spread
    return 1.0 / sqrt(spread)


@compiled
def _look(rows, told, at, hypotheses, settings):
    """Fill in likelihoods of one wrench, see `take`."""
    row = rows[at]
    if row[_LOOKED] < 0.0:
        return
    p, sensor = scene_of(settings), settings[SENSOR:PAYLOAD]
    noise, lever = settings[NOISE:CARRIED], settings[LEVER]
    q, rates = row[_Q : _Q + 3], np.zeros(3)
    R = np.empty((3, 3))
    peg_in_hole(q, R)
    unsure = _rates(rows, at, rates)
    moving = unsure >= 0.0
    # Ahead of what is at rest, and of the noise of the angles.
    slowest = max(settings[REST], LOOK_WINDOW.direction * settings[ANGLE] * unsure * 0.5 * p.D)
    columns, models = np.empty((6, 3)), np.empty((MODELS + 1, 28))
    reactions = WRENCH_BALANCE.reaction * WRENCH_BALANCE.reaction
    center = np.array([-sensor[0], -sensor[1], p.H_c - sensor[2]])
    free_columns(center, columns)
    prepare(columns, settings[CARRIED], noise, models[0])
    count = 1
    if moving and p.gamma0 < q[0] < 1.2:
        for k in range(WRENCH_BALANCE.frictions):
            if contact_columns(p, sensor, q, rates, slowest, settings[FRICTION + k], columns):
                prepare(columns, reactions, noise, models[count])
                count += 1
    weight = np.zeros((6, 2))
    payload = settings[PAYLOAD:NOISE]
    for j in range(3):
        g = R[0, j] * p.g_x + R[1, j] * p.g_y + R[2, j] * p.g_z
        weight[j, 0], weight[j, 1] = p.m * g, payload[0] * g
    fill_moment(weight, 0, center)
    fill_moment(weight, 1, payload[1:])
    hung = sqrt(weight[0, 0] ** 2 + weight[1, 0] ** 2 + weight[2, 0] ** 2)
    y, turn, slope = np.empty(6), np.empty((3, 3)), np.empty((6, 3))
    for h in range(len(hypotheses)):
        H = hypotheses[h]
        _axes(R, H, settings[BASE:FRICTION], turn)
        for j in range(3):
            y[j] = y[3 + j] = 0.0
            for k in range(3):
                y[j] += H[0] * turn[j, k] * row[_WRENCH + k]
                y[3 + j] += H[1] * turn[j, k] * row[_WRENCH + 3 + k]
        load = sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2])
        if H[3] == 0.0:
            for j in range(6):
                y[j] += weight[j, 0] + weight[j, 1]
        # Of what was measured, not of what it is taken for.
        best, fits, least = (
            unexplained(row[_WRENCH : _WRENCH + 6], hung, noise, lever),
            LOOK_WINDOW.nothing,
            1e300,
        )
        scale = 3.0 * (np.log(H[0]) + np.log(H[1]))
        # As stated any friction may be, also one between those that are tried.
        between = h == 0 and count == MODELS
        nearest, f, near = 1, 0.0, 1e300
        if between:
            contact_columns(p, sensor, q, rates, slowest, 0.0, columns)
            contact_columns(p, sensor, q, rates, slowest, 1.0, slope)
            slope -= columns
        likely = WRENCH_BALANCE.likely_frictions
        tries = count + between * LOOK_WINDOW.steps if h == 0 else min(count, 1 + likely)
        for step in range(tries):
            k = min(step, MODELS)
            if step >= MODELS:
                if step == MODELS:
                    f = settings[FRICTION + nearest - 1]
                f += friction_step(models[nearest], slope, y, noise)
                f = min(max(f, settings[FRICTION + likely]), settings[REST - 1])
                contact_columns(p, sensor, q, rates, slowest, f, columns)
                prepare(columns, reactions, noise, models[k])
                nearest = k
            prior = reactions if k else settings[CARRIED]
            value, over = likelihood(models[k], prior, k > 0, y, noise, load if k else hung)
            if value + scale > best:
                best, fits = value + scale, min(over, LOOK_WINDOW.nothing)
            if k:
                over *= 1.0 + (WRENCH_BALANCE.unexplained * load) ** 2 / noise[0]
                if likely < k < MODELS and over < near:
                    nearest, near = k, over
            else:
                over = 0.0
                for j in range(6):
                    over += y[j] * y[j] / noise[j]
            # Torques count by the noise that they have beside that of the forces.
            least = min(least, sqrt(0.5 * over * noise[0]))
        told[at, h, 0], told[at, h, 1], told[at, h, 2] = best, fits, least
    row[_LEFT] = told[at, 0, 1]
    tried = len(hypotheses) > 1
    row[_LOOKED] = (
        (_TRIED_WITH_RATES if moving else _TRIED) if tried else _WITH_RATES if moving else _ALONE
    )


@compiled
def _axes(R, H, base, turn):
    """Fill in what turns a measured vector to peg axes: by the sensor's, or from the base's."""
    for i in range(3):
        for j in range(3):
            turn[i, j] = H[4 + 3 * i + j] if H[2] == 0.0 else 0.0
        if H[2] == 0.0:
            continue
        for l in range(3):
            # Of the base's axis l in the peg's.
            along = R[0, i] * base[l] + R[1, i] * base[3 + l] + R[2, i] * base[6 + l]
            for j in range(3):
                turn[i, j] += along * H[4 + 3 * l + j]


def ring(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return rows that hold nothing yet, and what is told of them, for so many hypotheses."""
    rows = np.zeros((LOOK_WINDOW.kept, ROW))
    rows[:, _LOOKED] = -1.0
    return rows, np.zeros((LOOK_WINDOW.kept, count, 3))


def tried(rows: np.ndarray) -> np.ndarray:
    """Return which rows were looked at under every hypothesis."""
    return rows[:, _LOOKED] >= _TRIED


def full(rows: np.ndarray) -> bool:
    """Return whether as many are kept as there is room for."""
    return bool(rows[:, _LOOKED].min() >= 0.0)
