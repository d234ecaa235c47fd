"""Which parameters a motion tells of, by the estimator's own spread with all of them open."""

from dataclasses import replace
from math import inf, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimator.contact_filter import ContactFilter, Correction
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.estimator.orientation import fill_orientation_jacobian
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.state import FRICTION, OPEN_BEGIN, places_of
from peg_on_hole_ros.identification.quantities import (
    CALIBRATED_QUANTITIES,
    TYPICAL_DIAMETER,
    TYPICAL_FORCE,
    measures,
)
from peg_on_hole_ros.identification.tuned import OBSERVED_MOTION
from peg_on_hole_ros.mechanics.scene import Scene

# Of a parameter vector: friction, clearance, bias (6) and tilt (2).
PARAMETER_NAMES = (
    "friction", "clearance",
    "bias_force_x", "bias_force_y", "bias_force_z",
    "bias_torque_x", "bias_torque_y", "bias_torque_z",
    "tilt_x", "tilt_y",
)  # fmt: skip
# As many values as they are, from friction on.
_ASKED = slice(FRICTION, FRICTION + len(PARAMETER_NAMES))


class Observability(NamedTuple):
    """
    What a motion tells of each of PARAMETER_NAMES.

    Standard deviations are those of the best estimate that a tangent allows, over the whole
    motion: [-], [m], [N], [N m], [rad].

    Attributes
    ----------
    alone : ndarray, shape (10,)
        Where all others are known; infinite: it moves nothing that is measured.
    together : ndarray, shape (10,)
        Where none is known beyond `range`.
    useful, range : ndarray, shape (10,)
        A standard deviation above this tells a cell nothing; what is known without any motion.
    partner : tuple of str
        Of one that is seen alone and not together, what it looks like; empty: nothing alone.
    rank : int
        How many independent combinations are told better than `useful`.
    condition : float
        Of the best told combination over the worst, in units of `useful`.
    seconds : float
        How long all contacts surely slid [s]; nothing is learnt elsewhere, but a bias in the air.
    free : float
        How long the peg hung free [s].
    turn : float
        How far the peg turned about its own axis meanwhile [rad].
    swing : float
        How far the direction in which it leans turned meanwhile [rad].

    """

    alone: np.ndarray
    together: np.ndarray
    useful: np.ndarray
    range: np.ndarray
    partner: tuple[str, ...]
    rank: int
    condition: float
    seconds: float
    free: float
    turn: float
    swing: float

    @property
    def seen(self) -> np.ndarray:
        """Whether each is told well enough to be of use, shape (10,)."""
        return self.together <= self.useful


class ObservingFilter(ContactFilter):
    """
    The estimator, gathering what a motion tells of all parameters.

    Beside the estimate runs the covariance of an estimator that has all of them open, from the
    range of each on, with its Jacobian evaluated at the estimate. What its spread has lost over a
    motion is information; that of several motions adds up. The estimate is that of
    `ContactFilter`.
    """

    def __init__(
        self,
        scene: Scene,
        options: FilterOptions,
        wrench_noise: np.ndarray,
        offsets: OffsetUncertainty,
    ) -> None:
        super().__init__(scene, options, wrench_noise, offsets)
        rows, scale = _rows(), measures(scene.hole_diameter, TYPICAL_FORCE)
        self._clearance = scene.hole_diameter - scene.peg_diameter
        self._prior = np.square(scale.range[rows])
        share = self._prior[1] ** 0.5 * self._clearance
        friction = self._prior[0] ** 0.5
        opened = replace(
            scene, friction_stddev=friction, friction_k_stddev=0.0, clearance_stddev=share,
            clearance_drift=0.0, compliance_stddev=0.0,
        )  # fmt: skip
        everything = replace(
            options, friction="estimated", clearance="estimated", friction_noise=0.0,
            gate_threshold=inf,
        )  # fmt: skip
        unknown = OffsetUncertainty(self._prior[2:], offsets.load, np.zeros(6))
        # What is observed of constants: friction among them.
        alone = default_settings(friction_hypotheses=1, products=0.0, top_friction_walk=0.0)
        self._open = ContactFilter(opened, everything, wrench_noise, unknown, alone)
        self._told, self._runs = np.zeros((len(PARAMETER_NAMES), len(PARAMETER_NAMES))), False
        self.seconds = self._pressed = self.free = self._dt = 0.0
        self._least, self._most = np.full(2, inf), np.full(2, -inf)

    def start(self, q: ArrayLike, R: ArrayLike) -> None:
        """Start; what was gathered stays."""
        super().start(q, R)
        self._gather()
        opened = self._open
        opened.forget()
        opened.start(q, R)
        self._runs = True
        self._pin()
        # The estimate begins where the tilt puts it.
        places = places_of(("clearance", "bias", "tilt"))
        n, first = int(places.reactions), int(places.tilt)
        E = np.zeros((6, n))
        fill_orientation_jacobian(self.mixture.mean, places, n, E)
        tilt = slice(first, first + 2)
        for P in (*opened.mixture.P, opened.mixture.covariance):
            P[:3, tilt] = -E[:3, tilt] * self._prior[8:]
            P[tilt, :3] = P[:3, tilt].T
            P[:3, :3] -= P[:3, tilt] @ E[:3, tilt].T

    def _gather(self):
        self._told, self._runs = self.information, False

    @property
    def information(self) -> np.ndarray:
        """Information so far on PARAMETER_NAMES, the clearance in logarithms, shape (10, 10)."""
        if not self._runs:
            return self._told
        scale = np.sqrt(self._prior)
        scaled = self._open.mixture.covariance[_ASKED, _ASKED] / np.outer(scale, scale)
        told = np.linalg.inv(scaled) - np.eye(len(PARAMETER_NAMES))
        return self._told + 0.5 * (told + told.T) / np.outer(scale, scale)

    def _pin(self):
        """Evaluate the Jacobian of all that is open at the estimate."""
        own, opened = self.mixture, self._open.mixture
        n = len(opened.mean) - 3
        for x in (*opened.x, opened.mean):
            x[: FRICTION + 1] = own.mean[: FRICTION + 1]
            x[OPEN_BEGIN:n] = 0.0
            x[n:] = own.mean[-3:]
        modes = int(self.settings.modes)
        opened.weight[:] = own.weight.reshape(-1, modes).sum(axis=0)

    def end_estimate(self) -> None:
        """End the motion; what was gathered stays."""
        super().end_estimate()
        self._gather()

    def predict(self, dt: float) -> None:
        """Move the estimate on by dt [s]."""
        super().predict(dt)
        self._dt += dt
        self._open.predict(dt)
        self._pin()

    def correct(self, q: np.ndarray, R: np.ndarray) -> tuple[Correction, float]:
        """Correct with an orientation, as `ContactFilter`."""
        result, nis = super().correct(q, R)
        if result is Correction.USED:
            self._open.correct(q, R)
            self._pin()
        return result, nis

    def weigh(self, u: np.ndarray, contacts: ContactSet) -> None:
        """Take a wrench, as `ContactFilter`."""
        before = self._dt
        super().weigh(u, contacts)
        self._dt = 0.0
        if not self._runs or not np.isfinite(self.x[0]):
            return
        tells = contacts
        if contacts is ContactSet.NONE:
            self.free += before
        elif contacts is ContactSet.THREE and self._slides():
            self.seconds += before
            self._pressed += before * self.rim_load()[0]
            self._least = np.minimum(self._least, self.x[1:3])
            self._most = np.maximum(self._most, self.x[1:3])
        else:
            tells = ContactSet.UNKNOWN
        self._open.weigh(u, tells)
        self._pin()

    def _slides(self):
        sigmas = OBSERVED_MOTION.significance
        return all(slip.speed > sigmas * sqrt(slip.variance) for slip in self.record.slips)

    def observability(self) -> Observability:
        """Return what was gathered so far."""
        travel = np.maximum(self._most - self._least, 0.0)
        slid = self.seconds > OBSERVED_MOTION.shortest_sliding
        force = self._pressed / self.seconds if slid else TYPICAL_FORCE
        unit = np.ones(len(PARAMETER_NAMES))
        unit[1] = 1.0 / self._clearance
        return observability(  # type: ignore[call-arg]
            self.information * np.outer(unit, unit), self._clearance, self.seconds,
            *travel[::-1], self.scene.hole_diameter, force, self.free,
        )  # fmt: skip


def _rows():
    names = [one.name for one in CALIBRATED_QUANTITIES]
    return [names.index(name) for name in PARAMETER_NAMES]


def observability(
    information: np.ndarray,
    clearance: float,
    seconds: float = 0.0,
    turn: float = 0.0,
    swing: float = 0.0,
    diameter: float = TYPICAL_DIAMETER,
    force: float = TYPICAL_FORCE,
    free: float = 0.0,
) -> Observability:
    """
    Return what an information matrix says of each of PARAMETER_NAMES.

    Parameters
    ----------
    information : ndarray, shape (10, 10)
        Inverse of the covariance that a best estimate would have, in the units of PARAMETER_NAMES.
    clearance : float
        D - d; its useful share is that of the calibration [m].
    seconds, turn, swing, free : float
        See `Observability`.
    diameter, force : float
        Of the hole [m], and that the rim carries [N]: what biases are of use beside.

    Raises
    ------
    PegOnHoleError
        The matrix has no finite numbers: the motion has none, as at gamma = 0.

    """
    if not np.isfinite(information).all():
        raise PegOnHoleError(
            "take a part of the recording in which the peg leans: for an upright peg (gamma = 0), "
            "which has no angles psi and phi, observability cannot be computed"
        )
    scale = measures(diameter, force)
    rows = _rows()
    unit = np.array([clearance if CALIBRATED_QUANTITIES[row].log else 1.0 for row in rows])
    useful, known = unit * scale.useful[rows], unit * scale.range[rows]
    scaled = information * np.outer(useful, useful)
    diagonal = np.diagonal(scaled)
    alone = np.where(diagonal > 0, useful / np.sqrt(np.where(diagonal > 0, diagonal, 1.0)), inf)
    covariance = np.linalg.inv(scaled + np.diag((useful / known) ** 2))
    stddev = np.sqrt(np.diagonal(covariance))
    correlation = np.abs(covariance / np.outer(stddev, stddev)) - np.eye(len(PARAMETER_NAMES))
    together = useful * stddev
    partner = []
    for i in range(len(PARAMETER_NAMES)):
        nearest = int(np.argmax(correlation[i]))
        hidden = alone[i] <= useful[i] < together[i]
        alike = correlation[i, nearest] > OBSERVED_MOTION.alike
        partner.append(PARAMETER_NAMES[nearest] if hidden and alike else "")
    told = np.linalg.eigvalsh(scaled)
    condition = float(np.sqrt(told[-1] / told[0])) if told[0] > 1e-14 * told[-1] > 0 else inf
    rank = int((told > 1.0).sum())
    return Observability(
        alone, together, useful, known, tuple(partner), rank, condition, seconds, free, turn, swing
    )
