"""The last second of wrenches, and how likely each of them is under each hypothesis."""

from enum import IntEnum
from math import fabs, sqrt
from typing import Annotated

import numpy as np

from peg_on_hole_ros.diagnosis.balance import (
    MODELS,
    BalanceModel,
    contact_columns,
    fill_free_air_columns,
    fill_moment,
    fill_peg_axes,
    friction_increment,
    likelihood,
    prepare,
    unexplained,
)
from peg_on_hole_ros.diagnosis.tuned import LOOK_WINDOW, WRENCH_BALANCE
from peg_on_hole_ros.mechanics.kernel import compiled, scene_of
from peg_on_hole_ros.mechanics.linear_algebra import TORQUE
from peg_on_hole_ros.mechanics.scene import SceneScalars
from peg_on_hole_ros.typed_record import Floats, Matrix3, Record, Vector3, Vector6, dtype_of

_MODEL = dtype_of(BalanceModel)


class LookLevel(IntEnum):
    """How far a wrench of the window is looked at."""

    EMPTY = -1  # there is none yet
    NOT = 0
    ALONE = 1  # as stated
    WITH_RATES = 2  # as stated, and by the rates that its neighbours show
    TRIED = 3  # under every hypothesis
    TRIED_WITH_RATES = 4


class WindowWrench(Record):
    """
    One wrench of the window.

    Attributes
    ----------
    t : float
        Stamp [s].
    wrench : shape (6,)
        [N], [N m].
    q : shape (3,)
        gamma, psi, phi [rad].
    looked : LookLevel
    left : float
        Squares of what is left of it as stated, see `Explained`.

    """

    t: float
    wrench: Vector6
    q: Vector3
    looked: LookLevel
    left: float


class Explained(Record):
    """
    One wrench under one hypothesis.

    Attributes
    ----------
    likelihood : float
        Its logarithm.
    left : float
        Squares of what free air or three contacts leave of a wrench over the noise, at most
        `LOOK_WINDOW.nothing`.
    unbalanced : float
        What they leave unbalanced [N].

    """

    likelihood: float
    left: float
    unbalanced: float


class KnownCell(Record):
    """
    What is known of the wrench and of what it acts on.

    Attributes
    ----------
    scene : shape (11,)
        As `kernel.scene_of` has it.
    sensor : shape (3,)
        Its origin in the peg frame [m].
    payload_mass, payload_center : float, shape (3,)
        [kg], [m].
    noise : shape (6,)
        Variances of the wrench [N^2], [N^2 m^2].
    carried : float
        Variance of the force of a holder's acceleration [N^2].
    lever : float
        Of torques [m].
    base_axes : shape (3, 3)
        Axes of the robot's base in the hole.
    frictions : shape (frictions,)
        That are tried.
    slowest : float
        Speed of a peg at rest [m/s].
    angle_stddev : float
        Noise of the angles [rad].

    """

    scene: Annotated[Floats, (len(SceneScalars._fields),)]
    sensor: Vector3
    payload_mass: float
    payload_center: Vector3
    noise: Vector6
    carried: float
    lever: float
    base_axes: Matrix3
    frictions: Annotated[Floats, (WRENCH_BALANCE.frictions,)]
    slowest: float
    angle_stddev: float


@compiled
def take(
    rows: np.ndarray,
    balances: np.ndarray,
    at: int,
    meanings: np.ndarray,
    cell: np.ndarray,
    judged: bool,
) -> bool:
    """
    Evaluate the newest wrench, and once more the one whose rates it gives.

    Parameters
    ----------
    rows : ndarray of WindowWrench, shape (kept,)
        A ring; the newest is filled in but for what was looked at.
    balances : ndarray of Explained, shape (kept, n)
        Under each hypothesis; filled.
    at : int
        Place of the newest; the next is the oldest.
    meanings : ndarray of WrenchTransform, shape (n,)
        The hypotheses; the first is what is stated.
    cell : ndarray of KnownCell, shape (1,)
    judged : bool
        Whether other hypotheses than the first are to be looked at.

    Returns
    -------
    bool
        Whether wrenches surprise, more than noise does: else no other hypothesis is looked at.

    """
    rows[at].looked = LookLevel.NOT
    _look(rows, balances, at, meanings[:1], cell[0])
    _look(rows, balances, (at - LOOK_WINDOW.side) % LOOK_WINDOW.kept, meanings[:1], cell[0])
    odd = kept = 0
    for k in range(LOOK_WINDOW.kept):
        looked = rows[k].looked > LookLevel.NOT
        kept += looked
        odd += looked and rows[k].left > LOOK_WINDOW.surprise
    surprising = odd > LOOK_WINDOW.share * kept
    if surprising and judged:
        for k in range(LOOK_WINDOW.kept):
            if LookLevel.NOT < rows[k].looked < LookLevel.TRIED:
                _look(rows, balances, k, meanings, cell[0])
    return surprising


@compiled
def _rates(rows, at, rates):
    """
    Fill in the slopes of the angles about a wrench.

    Returns their spread for angles with a spread of 1, below 0 where its neighbours are not there.
    """
    middle = rows[at].t
    spread = 0.0
    rates[:] = 0.0
    before = -1e300
    for k in range(-LOOK_WINDOW.side, LOOK_WINDOW.side + 1):
        i = (at + k) % LOOK_WINDOW.kept
        t = rows[i].t - middle
        # Of a ring that is not full, or of what came before a pause.
        if rows[i].looked == LookLevel.EMPTY or not before < t or fabs(t) > 0.2:
            return -1.0
        before = t
        spread += t * t
        for j in range(3):
            rates[j] += t * (rows[i].q[j] - rows[at].q[j])
    for j in range(3):
        rates[j] /= spread
    return 1.0 / sqrt(spread)


@compiled
def _look(rows, balances, at, meanings, cell):
    """Fill in likelihoods of one wrench, see `take`."""
    row = rows[at]
    if row.looked == LookLevel.EMPTY:
        return
    p, sensor, noise = scene_of(cell.scene), cell.sensor, cell.noise
    q, wrench, rates = row.q, row.wrench, np.zeros(3)
    R = np.empty((3, 3))
    fill_peg_axes(q, R)
    unsure = _rates(rows, at, rates)
    moving = unsure >= 0.0
    # Ahead of what is at rest, and of the noise of the angles.
    slowest = max(cell.slowest, LOOK_WINDOW.direction * cell.angle_stddev * unsure * 0.5 * p.D)
    columns, models = np.empty((6, 3)), np.empty(MODELS + 1, _MODEL)
    reactions = WRENCH_BALANCE.reaction * WRENCH_BALANCE.reaction
    center = np.array([-sensor[0], -sensor[1], p.H_c - sensor[2]])
    fill_free_air_columns(center, columns)
    prepare(columns, cell.carried, noise, models[0])
    count = 1
    if moving and p.gamma0 < q[0] < 1.2:
        for k in range(WRENCH_BALANCE.frictions):
            if contact_columns(p, sensor, q, rates, slowest, cell.frictions[k], columns):
                prepare(columns, reactions, noise, models[count])
                count += 1
    weight = np.zeros((6, 2))
    for j in range(3):
        g = R[0, j] * p.g_x + R[1, j] * p.g_y + R[2, j] * p.g_z
        weight[j, 0], weight[j, 1] = p.m * g, cell.payload_mass * g
    fill_moment(weight, 0, center)
    fill_moment(weight, 1, cell.payload_center)
    hung = sqrt(weight[0, 0] ** 2 + weight[1, 0] ** 2 + weight[2, 0] ** 2)
    y, turn, slope = np.empty(6), np.empty((3, 3)), np.empty((6, 3))
    for h in range(len(meanings)):
        meant = meanings[h]
        by_force, by_torque = meant.force_factor, meant.torque_factor
        _axes(R, meant, cell.base_axes, turn)
        for j in range(3):
            y[j] = y[TORQUE + j] = 0.0
            for k in range(3):
                y[j] += by_force * turn[j, k] * wrench[k]
                y[TORQUE + j] += by_torque * turn[j, k] * wrench[TORQUE + k]
        load = sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2])
        if not meant.weight_removed:
            for j in range(6):
                y[j] += weight[j, 0] + weight[j, 1]
        # Of what was measured, not of what it is taken for.
        best, fits, least = (
            unexplained(wrench, hung, noise, cell.lever),
            LOOK_WINDOW.nothing,
            1e300,
        )
        scale = 3.0 * (np.log(by_force) + np.log(by_torque))
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
                    f = cell.frictions[nearest - 1]
                f += friction_increment(models[nearest], slope, y, noise)
                f = min(max(f, cell.frictions[likely]), cell.frictions[-1])
                contact_columns(p, sensor, q, rates, slowest, f, columns)
                prepare(columns, reactions, noise, models[k])
                nearest = k
            prior = reactions if k else cell.carried
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
        balance = balances[at, h]
        balance.likelihood, balance.left, balance.unbalanced = best, fits, least
    row.left = balances[at, 0].left
    if len(meanings) > 1:
        row.looked = LookLevel.TRIED_WITH_RATES if moving else LookLevel.TRIED
    else:
        row.looked = LookLevel.WITH_RATES if moving else LookLevel.ALONE


@compiled
def _axes(R, meant, base, turn):
    """Fill in what turns a measured vector to peg axes: by the sensor's, or from the base's."""
    axes, in_base_axes = meant.axes, meant.in_base_axes
    for i in range(3):
        for j in range(3):
            turn[i, j] = 0.0 if in_base_axes else axes[i, j]
        if not in_base_axes:
            continue
        for l in range(3):
            # Of the base's axis l in the peg's.
            along = R[0, i] * base[0, l] + R[1, i] * base[1, l] + R[2, i] * base[2, l]
            for j in range(3):
                turn[i, j] += along * axes[l, j]


def new_window(hypotheses: int) -> tuple[np.ndarray, np.ndarray]:
    """Return an empty window, and room for its balances under so many hypotheses."""
    rows = np.zeros(LOOK_WINDOW.kept, dtype_of(WindowWrench))
    rows["looked"] = LookLevel.EMPTY
    return rows, np.zeros((LOOK_WINDOW.kept, hypotheses), dtype_of(Explained))


def tried(rows: np.ndarray) -> np.ndarray:
    """Return which rows were looked at under every hypothesis."""
    return rows["looked"] >= LookLevel.TRIED


def full(rows: np.ndarray) -> bool:
    """Return whether as many are kept as there is room for."""
    return bool(rows["looked"].min() > LookLevel.EMPTY)
