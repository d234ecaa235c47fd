"""Settings fitted to wrenches and motion of a cycle together, by the six equations row by row."""

from typing import Any, NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.diagnosis.tuned import SETTING_FIT_TEST
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy, skew, tilt_axes
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.geometry import (
    ContactGeometry,
    closed_forms,
    contact_points,
    normals,
    velocity_jacobians,
)
from peg_on_hole_ros.mechanics.reference import peg_axes, wrench_axes
from peg_on_hole_ros.typed_record import Floats

# Coordinates of what may be off: the sensor's zero [N], [N m] and friction, which are open always;
# a mass and its moment about the mass centre [kg], [kg m]; the sensor's place [m]; turns of the
# hole and of the peg in its tool [rad]; the logarithm of the clearance; the delay [s].
ZERO, FRICTION, MASS, PLACE = slice(0, 6), slice(6, 7), slice(7, 11), slice(11, 14)
HOLE, PEG, CLEARANCE, DELAY = slice(14, 16), slice(16, 18), slice(18, 19), slice(19, 20)
COORDINATES = 20
_STEPS = np.repeat(
    [0.1, 0.01, 1e-3, 1e-2, 1e-3, 1e-4, 1e-4, 1e-4, 1e-3, 1e-3], [3, 3, 1, 1, 3, 3, 2, 2, 1, 1]
)
# Of a deviation below which nothing is known.
_TINY = 1e-12


class Cycle(NamedTuple):
    """
    What was looked at of a cycle.

    Attributes
    ----------
    t, knots : ndarray, shape (n,)
        Stamps of wrenches, and of orientations, which rise [s].
    wrench : ndarray, shape (n, 6)
        Means of wrenches as received [N], [N m].
    counts : ndarray, shape (n,)
        Wrenches in each mean.
    q : ndarray, shape (m, 3)
        gamma, psi, phi at the knots, unwrapped [rad].
    taken_off : ndarray, shape (6,)
        What is taken off in the sensor's axes [N], [N m].

    """

    t: Floats
    wrench: Floats
    counts: Floats
    knots: Floats
    q: Floats
    taken_off: Floats


class Fit(NamedTuple):
    """
    What fits best of one kind.

    Attributes
    ----------
    x : ndarray, shape (COORDINATES,)
    left : ndarray, shape (rows,)
        Squares of what it leaves of each row over the noise, at most `SETTING_FIT_TEST.nothing`.

    """

    x: Floats
    left: Floats

    @property
    def total(self) -> float:
        """What it leaves of all rows."""
        return float(self.left.sum())


class SettingFit:
    """
    Residuals of wrenches in the air and on three contacts, by settings that may be off.

    Of a row in contact three reactions are free, so that three of six components are left.

    Parameters
    ----------
    configuration : Configuration
    cycle : Cycle
    rows : ndarray of int, shape (rows,)
        Those of the cycle that are used.
    in_contact : ndarray of bool, shape (rows,)
        The others hang free.
    share : float
        Of a load that friction and levers leave unexplained.

    """

    def __init__(
        self,
        configuration: Configuration,
        cycle: Cycle,
        rows: np.ndarray,
        in_contact: np.ndarray,
        share: float = SETTING_FIT_TEST.unexplained,
    ) -> None:
        scene, wrench = configuration.scene, configuration.wrench
        self._scene, self._wrench, self._cycle = scene, wrench, cycle
        self.in_contact = in_contact
        reduction = WrenchReduction(wrench, scene, configuration.joints.hole_rpy)
        self._turn_S = rotation_from_rpy(wrench.sensor_rpy)
        self._in_base = bool(reduction.steps.in_base)
        self._base_H = np.array(reduction.steps.base_in_hole)
        self._centre = np.array([0.0, 0.0, scene.mass_center_height])
        self._noise = reduction.noise
        self._t, self._read = cycle.t[rows], reduction.sign * cycle.wrench[rows]
        self._zero = reduction.sign * cycle.taken_off
        at_rest = self._read[~in_contact].mean(axis=0) if not in_contact.all() else self._zero
        load = np.linalg.norm((self._read - at_rest)[:, :3], axis=1)
        lever = np.repeat([1.0, 0.5 * scene.hole_diameter], 3)
        self._spare = np.square(share * load)[:, None, None] * np.diag(lever**2)
        self._counts = cycle.counts[rows][:, None, None]
        self._hung = wrench.payload_mass, np.array(wrench.payload_com)
        self._spread = np.repeat(
            [SETTING_FIT_TEST.zero_force, SETTING_FIT_TEST.zero_torque, SETTING_FIT_TEST.friction],
            [3, 3, 1],
        )

    @property
    def freedoms(self) -> float:
        """How many squares of noise are left of all rows."""
        return 6.0 * len(self.in_contact) - 3.0 * np.count_nonzero(self.in_contact) - 7.0

    @property
    def start(self) -> Floats:
        """All as stated, shape (COORDINATES,)."""
        x = np.zeros(COORDINATES)
        x[FRICTION] = self._scene.friction
        return x

    def slowest(self) -> Floats:
        """Return the slip of the slowest contact of each row as stated [m/s]."""
        q, rates = self._motion(self.start)
        geo = self._geometry(q[0], 0.0)
        speeds = velocity_jacobians(geo, self._scene.peg_diameter, self._scene.hole_diameter)
        return np.linalg.norm(np.einsum("cirn,rn->cin", speeds, rates), axis=1).min(axis=0)

    def fitted(self, kind: slice | None, begin: Floats, compensated: bool) -> Fit:
        """
        Return what fits best where one kind is open, beside zero and friction.

        Parameters
        ----------
        kind : slice or None
        begin : ndarray, shape (COORDINATES,)
        compensated : bool
            Whether the weight is taken off already.

        """
        free = np.arange(7) if kind is None else np.r_[0:7, kind]
        x = begin.copy()
        for nothing in SETTING_FIT_TEST.nothings:
            x = self._climb(x, free, compensated, nothing)
        return Fit(x, self._squares(x, compensated, SETTING_FIT_TEST.nothing))

    def at(self, x: Floats, compensated: bool) -> Fit:
        """Return what given settings leave, with zero and friction as they fit."""
        return self.fitted(None, x, compensated)

    def _climb(self, x, free, compensated, nothing):
        """Return where least is left (Gauss, Newton); a row that nothing explains hardly pulls."""
        left, by_zero = self._left(x, compensated)
        value = self._value(x, left, nothing)
        for _ in range(SETTING_FIT_TEST.steps):
            weight = 1.0 / np.maximum(np.square(left).sum(axis=1) / nothing, 1.0)
            slopes = np.empty((len(free), *left.shape))
            # Of the zero what is left is linear.
            slopes[:6] = by_zero
            for j, i in enumerate(free[6:], 6):
                moved = x.copy()
                moved[i] += _STEPS[i]
                slopes[j] = (self._left(moved, compensated)[0] - left) / _STEPS[i]
            pulled = (slopes * weight[:, None]).reshape(len(free), -1)
            normal = pulled @ slopes.reshape(len(free), -1).T
            down = -pulled @ left.ravel()
            prior = self._spread**-2.0
            normal[range(7), range(7)] += prior
            down[:7] -= prior * (x - self.start)[:7]
            normal += np.diag(_TINY + 1e-9 * np.diagonal(normal))
            if not np.isfinite(normal).all():
                break
            step = np.zeros(COORDINATES)
            step[free] = np.linalg.solve(normal, down)
            for _ in range(SETTING_FIT_TEST.shortenings):
                trial, moves = self._left(x + step, compensated)
                better = self._value(x + step, trial, nothing)
                if better < value:
                    break
                step *= 0.4
            else:
                break
            gained, x, left, by_zero, value = value - better, x + step, trial, moves, better
            if gained < SETTING_FIT_TEST.gained:
                break
        return x

    def _value(self, x, left, nothing):
        off = (x - self.start)[:7] / self._spread
        squares = np.minimum(np.square(left).sum(axis=1), nothing)
        value = float(squares.sum() + off @ off)
        return value if np.isfinite(value) else np.inf

    def _squares(self, x, compensated, nothing):
        squares = np.square(self._left(x, compensated)[0]).sum(axis=1)
        return np.where(squares < nothing, squares, nothing)

    def _left(self, x, compensated):
        """Return what is left over the noise, (rows, 6), and its slopes by the zero."""
        q, rates = self._motion(x)
        turns = np.moveaxis(np.asarray(peg_axes(q)), -1, 0)
        turn_H, wrench = tilt_axes(x[HOLE]), self._wrench
        # Of the hole as stated, in the axes of the one that is tried.
        read = self._read
        if self._in_base:
            to_S = self._turn_S.T @ np.swapaxes(turns, 1, 2) @ (turn_H.T @ self._base_H)
            read = np.hstack([np.einsum("nij,nj->ni", to_S, read[:, part]) for part in _PARTS])
        read = read - self._zero - x[ZERO]
        place = np.array(wrench.sensor_xyz) + x[PLACE] - self._centre
        forces = read[:, :3] @ self._turn_S.T
        torques = read[:, 3:] @ self._turn_S.T + np.cross(place, forces)
        gravity = np.einsum("nji,j->ni", turns, turn_H.T @ np.array(self._scene.gravity))
        if not compensated:
            mass, centre = self._hung
            forces = forces + (mass + self._scene.peg_mass) * gravity
            torques = torques + np.cross(place + self._turn_S @ centre, mass * gravity)
        more = x[MASS]
        forces = forces + more[0] * gravity
        torques = torques + np.cross(more[1:], gravity)
        turn = self._turn_S
        map_ = np.block([[turn, np.zeros((3, 3))], [skew(place) @ turn, turn]])
        noise = map_ @ np.diag(self._noise) @ map_.T / self._counts + self._spare
        over = np.linalg.inv(np.linalg.cholesky(noise))
        left = np.einsum("nij,nj->ni", over, np.hstack([forces, torques]))
        rim = self.in_contact
        columns = over[rim] @ self._columns(q[:, rim], rates[:, rim], x)
        across, _ = np.linalg.qr(columns)
        both = np.concatenate([left[:, :, None], -over @ map_], axis=2)
        both[rim] -= across @ (np.swapaxes(across, 1, 2) @ both[rim])
        return both[:, :, 0], np.moveaxis(both[:, :, 1:], 2, 0)

    def _motion(self, x):
        """Return angles and rates at the wrenches' stamps, shape (3, rows) each."""
        at = self._t + float(x[DELAY][0])
        q, rates = _smooth(self._cycle.knots, self._cycle.q, at)
        if not x[HOLE].any() and not x[PEG].any():
            return q, rates
        before, after = q - SETTING_FIT_TEST.ahead * rates, q + SETTING_FIT_TEST.ahead * rates
        before, q, after = (self._turned(each, x) for each in (before, q, after))
        rates = (after - before + np.pi) % (2.0 * np.pi) - np.pi
        return q, rates / (2.0 * SETTING_FIT_TEST.ahead)

    @staticmethod
    def _turned(q, x):
        turns = np.moveaxis(np.asarray(peg_axes(q)), -1, 0)
        return _angles(tilt_axes(x[HOLE]).T @ turns @ tilt_axes(x[PEG]))

    def _geometry(self, gamma, larger):
        scene = self._scene
        clearance = (scene.hole_diameter - scene.peg_diameter) * np.exp(np.clip(larger, -4, 4))
        d = scene.hole_diameter - clearance
        gamma0 = float(np.arccos(d / scene.hole_diameter))
        tilt = np.clip(gamma, SETTING_FIT_TEST.nearest_tilt * gamma0, 1.5)
        forms: Any = closed_forms(d, scene.hole_diameter, scene.mass_center_height, gamma0, tilt)
        return ContactGeometry(gamma0, *forms)

    def _columns(self, q, rates, x):
        """Return wrenches of one newton at K, B1, B2, peg axes, about the mass centre."""
        scene = self._scene
        geo = self._geometry(q[0], float(x[CLEARANCE][0]))
        D, d = scene.hole_diameter, scene.hole_diameter * np.cos(geo.gamma0)
        slips = np.einsum("cirn,rn->cin", velocity_jacobians(geo, d, D), rates)
        speeds = np.maximum(np.linalg.norm(slips, axis=1), SETTING_FIT_TEST.slowest)
        forces = normals(geo) - float(x[FRICTION][0]) * slips / speeds[:, None]
        centre = np.array([geo.h_c, 0.0 * geo.h_c, geo.z_c])
        moments = np.cross(contact_points(geo, D) - centre, forces, axis=1)
        axes = np.asarray(wrench_axes(q[0], q[2]))
        turned = [np.einsum("ijn,cin->njc", axes, each) for each in (forces, moments)]
        return np.concatenate(turned, axis=1)


_PARTS = slice(0, 3), slice(3, 6)


def _angles(turns):
    """Return gamma, psi, phi of rotations, shape (3, n)."""
    gamma = np.arctan2(np.hypot(turns[:, 0, 2], turns[:, 1, 2]), turns[:, 2, 2])
    psi = np.arctan2(-turns[:, 1, 2], -turns[:, 0, 2])
    return np.array([gamma, psi, np.arctan2(-turns[:, 2, 1], turns[:, 2, 0])])


def _smooth(knots, q, at):
    """Return values and slopes of parabolas through five knots about each time, (3, n) each."""
    side, last = 2, len(knots) - 1
    middle = np.searchsorted(0.5 * (knots[1:] + knots[:-1]), at)
    middle = np.clip(middle, side, last - side)
    near = middle[:, None] + np.arange(-side, side + 1)
    u = knots[near] - at[:, None]
    scale = np.maximum(np.abs(u).max(axis=1), _TINY)[:, None]
    u = u / scale
    powers = np.stack([np.ones_like(u), u, u * u], axis=-1)
    normal = np.einsum("nki,nkj->nij", powers, powers)
    found = np.linalg.solve(normal, np.einsum("nki,nkd->nid", powers, q[near]))
    return found[:, 0].T, (found[:, 1] / scale).T
