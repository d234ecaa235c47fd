"""A peg on its way into a hole: six degrees of freedom on contacts that give, by the samples."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.sim.hole_forces import (
    HoleContacts,
    HoleModel,
    Surface,
    acceleration,
    commanded,
    contact_forces,
    pull,
)
from peg_on_hole_ros.sim.hole_places import SLOTS, touching_places
from peg_on_hole_ros.sim.hole_steps import STEP, Body, advance

# Newton's steps to the place where the contacts carry given loads.
_LOADING_STEPS = 5
# Slower than this [m/s] a contact that is taken over is at rest, and holds nothing yet.
_AT_REST = 1e-7


class InsertionRows(NamedTuple):
    """
    Samples of an insertion.

    Attributes
    ----------
    t : ndarray, shape (n,)
        [s]
    C, V, acceleration : ndarray, shape (n, 3), (n, 6), (n, 6)
        Of the mass centre, and the angular ones, hole axes.
    R : ndarray, shape (n, 3, 3)
    force, moment : ndarray, shape (n, 3)
        Of the holder on the peg about the mass centre, hole axes [N], [N m].
    points, forces, slips : ndarray, shape (n, 4, 3)
        Of the slots of `hole_places`, hole axes [m], [N], [m/s].
    normal, azimuth, gaps : ndarray, shape (n, 4)
        [N], [rad], [m]

    """

    t: np.ndarray
    C: np.ndarray
    V: np.ndarray
    acceleration: np.ndarray
    R: np.ndarray
    force: np.ndarray
    moment: np.ndarray
    points: np.ndarray
    forces: np.ndarray
    slips: np.ndarray
    normal: np.ndarray
    azimuth: np.ndarray
    gaps: np.ndarray


class Insertion:
    """
    The simulation in the hole under way.

    Parameters
    ----------
    p : ndarray
        Scene; another friction may be put into it between two stretches.
    height : float
        Of the peg [m].
    holder, knots, coefficients : ndarray
        Holder and its program, from `place_program`; knots in the simulation's time.
    surface : Surface
        Of the contacts.
    step : float
        The largest [s].

    """

    def __init__(
        self,
        p: np.ndarray,
        height: float,
        holder: np.ndarray,
        knots: np.ndarray,
        coefficients: np.ndarray,
        surface: Surface,
        step: float = STEP,
    ) -> None:
        self.height, self.holder, self.step = float(height), holder, step
        self.knots, self.coefficients = knots, coefficients
        self.surface = surface
        self.take(p)

    def take(self, p: np.ndarray) -> None:
        """Let another scene, with another friction, hold from now on."""
        self.p = p
        self.model = HoleModel(p, self.height, self.surface, self.holder)

    def body(
        self,
        t: float,
        C: np.ndarray,
        R: np.ndarray,
        V: np.ndarray,
        normal: np.ndarray | None = None,
    ) -> Body:
        """
        Return a peg that begins here.

        Parameters
        ----------
        t : float
            [s]
        C, R, V : ndarray
            As in `Body`.
        normal : ndarray, shape (3,), optional
            What K, B1, B2 carry, on the azimuths of three-point contact [N]; the peg is moved so
            that they do.

        """
        shift = np.zeros((SLOTS, 3))
        psi = np.arctan2(-R[1, 2], -R[0, 2])
        azimuth = np.array([psi + np.pi, psi, psi - 0.5, psi + 0.5])
        C = np.array(C, float)
        if normal is not None:
            C, shift, azimuth = self._loaded(C, R, V, normal, azimuth)
        first = self._contacts(C, R, V, shift, azimuth)
        F, M = pull(self.p, self.holder, self._command(t), C, R, V)
        now = self._contacts(C, R, V, shift, first.azimuth)
        acc = acceleration(self.p, F, M, C, R, V, now.points, now.forces)
        return Body(C, R.copy(), V.copy(), acc, shift, first.slips, first.azimuth, np.eye(6))

    def _command(self, t):
        return commanded(self.p, self.knots, self.coefficients, float(t))

    def _contacts(self, C, R, V, shift, azimuth) -> HoleContacts:
        return contact_forces(self.model, C, R, V, shift, 0.0, azimuth)

    def _loaded(self, C, R, V, normal, azimuth):
        k = self.surface.normal
        for _ in range(_LOADING_STEPS):
            points, normals, gaps, azimuth, share = touching_places(
                self.p, self.height, C, R, azimuth
            )
            carries = np.array([normal[0], 0.0, normal[1], normal[2]])
            rows = [i for i in (0, 2, 3) if gaps[i] < 0.5]
            wanted = -np.maximum(carries[rows], 0.0) / (k * share[rows])
            C = C + np.linalg.lstsq(normals[rows], wanted - gaps[rows], rcond=1e-6)[0]
        slips = self._contacts(C, R, V, np.zeros((SLOTS, 3)), azimuth).slips
        shift = np.zeros((SLOTS, 3))
        for i in rows:
            speed = np.linalg.norm(slips[i])
            if speed > _AT_REST:
                most = self.p[6] * max(carries[i], 0.0) / (share[i] * self.surface.along)
                shift[i] = most * slips[i] / speed
        return C, shift, azimuth

    def run(
        self,
        t0: float,
        body: Body,
        samples: np.ndarray,
        t_end: float,
        limits: tuple[float, float],
        progress: Callable | None = None,
    ) -> tuple[InsertionRows | None, Body, float, str]:
        """
        Simulate until a time, and return rows at samples, the body then, and what ended it.

        Parameters
        ----------
        t0, t_end : float
            [s]
        body : Body
        samples : ndarray
            Times wanted, rising, from t0 on [s].
        limits : tuple of 2 float
            Force [N] and torque [N m] of the holder that end the run.
        progress : callable, optional
            Told the time reached.

        Returns
        -------
        rows : InsertionRows
        body : Body
        t : float
            Reached [s].
        ended_by : str
            `force limit`, `torque limit`, or `end`.

        """
        found, t, ended = [], t0, "end"
        for k, sample in enumerate((*samples, t_end)):
            if sample > t:
                body = self._to(t, sample, body)
                t = sample
            if k == len(samples):
                break
            row = self._row(t, body)
            load = np.linalg.norm(row[5]), np.linalg.norm(row[6])
            over = [x > limit for x, limit in zip(load, limits, strict=True)]
            if any(over):
                ended = "force limit" if over[0] else "torque limit"
                break
            found.append(row)
            if progress and k % 64 == 0:
                progress(t)
        return (
            InsertionRows(*(np.array(part) for part in zip(*found))) if found else None,
            body,
            t,
            ended,
        )

    def _to(self, t, end, body):
        good, after = advance(self.model, self.knots, self.coefficients, t, end, self.step, body)
        if not good:
            tilt = np.arctan2(np.hypot(*body.R[:2, 2]), body.R[2, 2])
            raise PegOnHoleError(
                f"no step of {self.step:g} s or shorter solves the contacts in the hole at "
                f"{t:.6f} s, tilt {tilt:.6g} rad: slow the phase, or soften the holder"
            )
        return after

    def _row(self, t, body):
        C, R, V = body.C, body.R, body.V
        F, M = pull(self.p, self.holder, self._command(t), C, R, V)
        c = self._contacts(C, R, V, body.shift, body.azimuth)
        return (
            t, C, V, body.acceleration, R, F, M,
            c.points, c.forces, c.slips, c.normal, c.azimuth, c.gaps,
        )  # fmt: skip
