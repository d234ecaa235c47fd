"""Settings that the motion does not tell: how far off each leaves the reactions."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import UNOBSERVABLE_TEST
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.contact_sets import three_on_rim
from peg_on_hole_ros.estimator.estimate import scene_of
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.orientation import fill_orientation_jacobian
from peg_on_hole_ros.estimator.state import FRICTION, OPEN_BEGIN, places_of
from peg_on_hole_ros.measurements.rotations import skew
from peg_on_hole_ros.number_text import number, quantity
from peg_on_hole_ros.records import UNOBSERVABLE_SETTINGS
from peg_on_hole_ros.typed_record import Floats, new

_PLACES, _TILT_PLACES = places_of(("clearance",)), places_of(("tilt",))
_N, _TILT_N = int(_PLACES.reactions), int(_TILT_PLACES.reactions)
_CLEARANCE_AT, _TILT_AT = int(_PLACES.clearance), int(_TILT_PLACES.tilt)
_MOTION = slice(0, FRICTION)


class Kind(NamedTuple):
    """
    One kind of setting that may be off.

    Attributes
    ----------
    width : int
        How many components it has.
    typical : float
        By how much it may be off where nothing is stated.
    unit, what : str

    """

    width: int
    typical: float
    unit: str
    what: str


# Of each of UNOBSERVABLE_SETTINGS. Torques are those of a hole of 50 mm; the clearance is a share.
KINDS = (
    Kind(1, 0.05, "", "of friction"),
    Kind(1, 0.1, "of it", "of clearance"),
    Kind(1, 5.0, "N", "along the peg"),
    Kind(2, 5.0, "N", "across the peg"),
    Kind(3, 0.1, "N m", "of the torque's zero"),
    Kind(2, 0.01, "rad", "of the hole's direction"),
    Kind(1, 2e-3, "rad", "of gamma"),
    Kind(1, 2e-3, "m", "of the sensor's height"),
)
_KIND_OF = np.repeat(np.arange(len(KINDS)), [kind.width for kind in KINDS])
_OF_KIND = np.eye(len(KINDS))[_KIND_OF]
_FRICTION, _CLEARANCE, _TILT, _GAMMA, _LEVER = 0, 1, slice(8, 10), 10, 11
_FORCE, _ZERO = slice(2, 5), slice(2, 8)


class Unobservable(Suspect):
    """
    Tests settings that may be off, by the six equations, while a peg slides on three contacts.

    Each look determines something of all of them together, with reactions and motion open. What is
    left of the offset that each may have, times what it moves the reactions by, is its cost. A
    quantity that the estimator learns gives way to the others, as it would.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "unobservable"
    FINDS = (
        (
            "`scene.friction`: its estimate is far from the stated value; an error of a force "
            "along the peg, of a lever or of a weight looks the same",
            "three looks in a row on three contacts, where `scene.friction_stddev` is stated",
        ),
    )

    def __init__(self, stated: Stated) -> None:
        configuration = stated.configuration
        scene, wrench = configuration.scene, configuration.wrench
        options, known = configuration.filter, stated_offsets(configuration)
        learns = (
            options.friction, options.clearance, *[options.wrench_bias] * 3, options.hole_tilt,
        )  # fmt: skip
        learnt = (known > 0.0) & [*(how == "estimated" for how in learns), False, False]
        offsets = offsets_of(configuration)
        self._prior = 1.0 / np.square(offsets[_KIND_OF])
        self._learnt = learnt[_KIND_OF]
        # Settings that are off, and those that give way to them: what is learnt of other kinds.
        offs = [~self._learnt, *(kind == _KIND_OF for kind in np.flatnonzero(learnt))]
        self._gives_way = [
            (np.flatnonzero(off), np.flatnonzero(self._learnt & ~off)) for off in offs
        ]
        self._lever = np.array(wrench.sensor_xyz) - [0.0, 0.0, scene.mass_center_height]
        self._scene = scene
        # The filter as it would be with the clearance open, to linearise with.
        self._kalman = new(FilterRecord)
        self._kalman.places = _PLACES
        self.finding: Finding | None = None
        self.restart()

    @property
    def reaction_errors(self) -> Floats | None:
        """Of KINDS, at the contact that each moves most [N]; None: not on three contacts."""
        return self._costs

    def restart(self) -> None:
        """Forget what a motion has shown."""
        self._costs: Floats | None = None
        self._information = np.zeros((len(_KIND_OF), len(_KIND_OF)))
        self._looked_ns: int | None = None
        self._refuted = self._wrenches = 0

    def leave_three_contacts(self) -> None:
        """Record that the peg is not on three contacts."""
        self.restart()

    def count(self, wrenches: int) -> None:
        """Count so many wrenches whose estimate was given."""
        self._wrenches += wrenches

    def take_estimate(self, t_ns: int, peg: ContactFilter, determined: bool) -> None:
        """Process an estimate on three contacts, see the package."""
        if (
            self._looked_ns is not None
            and 0 <= t_ns - self._looked_ns < UNOBSERVABLE_TEST.period_ns
        ):
            return
        self._looked_ns, wrenches = t_ns, max(self._wrenches, 1)
        self._wrenches = 0
        if determined:
            self._look(peg, wrenches)
            estimate = peg.record
            self._test(estimate.scene.f, sqrt(max(estimate.friction_variance, 0.0)))

    def _look(self, peg, wrenches):
        slopes, reactions, noise = self._slopes(peg, wrenches)
        try:
            over = np.linalg.inv(noise)
            seen = reactions.T @ over
            gain = np.linalg.solve(seen @ reactions, seen)
        except np.linalg.LinAlgError:
            return
        information = self._information + slopes.T @ over @ (slopes - reactions @ gain @ slopes)
        if not np.isfinite(information).all():
            return
        self._information = 0.5 * (information + information.T)
        scale = np.sqrt(self._prior)
        scaled = self._information / np.outer(scale, scale) + np.eye(len(scale))
        # Twice its deviation, as for a bound; no more than it may be off at all.
        left = np.minimum(1.0, 2.0 * np.sqrt(np.diagonal(np.linalg.inv(scaled)))) / scale
        moved = gain @ slopes
        moves = moved.copy()
        own = self._information + np.diag(self._prior)
        for off, learnt in self._gives_way:
            if len(learnt):
                given = np.linalg.solve(own[np.ix_(learnt, learnt)], own[np.ix_(learnt, off)])
                moves[:, off] -= moved[:, learnt] @ given
        sizes = np.square(moves * left) @ _OF_KIND
        self._costs = np.sqrt(sizes.max(axis=0))

    def _slopes(self, peg, wrenches):
        """Return slopes of the six equations by settings, by reactions, and what is not known."""
        # By the record of the last wrench: an orientation of its stamp may have come since.
        n, estimate, kalman = _N, peg.record, self._kalman
        p, motion, settings = scene_of(estimate), estimate.motion, peg.settings
        x, P = np.zeros(n + 3), np.zeros((OPEN_BEGIN, OPEN_BEGIN))
        x[:3] = motion.gamma, motion.psi, motion.phi
        x[3:6] = motion.gamma_rate, motion.psi_rate, motion.phi_rate
        x[6:9], x[FRICTION], x[n:] = estimate.accelerations, p.f, estimate.reactions.normal
        P[:6, :6] = motion.covariance
        u = estimate.wrench.copy()
        kalman.settings, kalman.wrench[:], kalman.noise[:] = settings, u, peg.wrench_noise
        kalman.state.load = peg.state.load
        kalman.state.friction_force2[:] = peg.state.friction_force2
        three_on_rim.linearise(kalman, p, x, P, 0.0)
        scratch = kalman.scratch
        E, columns = scratch.jacobian[:, : n + 3].copy(), scratch.applied_jacobian
        by_wrench = -columns[:, 3:9]
        slopes = np.zeros((6, len(_KIND_OF)))
        slopes[:, _FRICTION], slopes[:, _CLEARANCE] = E[:, FRICTION], E[:, _CLEARANCE_AT]
        # What the sensor reads too much is taken for a wrench on the peg.
        sensed = np.eye(6)
        sensed[3:, :3] = skew(self._lever)
        # Along comes before across.
        slopes[:, _ZERO] = (by_wrench @ sensed)[:, [2, 0, 1, 3, 4, 5]]
        turned = np.zeros((6, _TILT_N))
        fill_orientation_jacobian(x, _TILT_PLACES, _TILT_N, turned)
        by_turn = turned[:3, _TILT_AT:]
        slopes[:, _TILT] = -columns[:, 9:11] - E[:, :3] @ by_turn
        slopes[:, _GAMMA] = E[:, 0]
        slopes[:, _LEVER] = by_wrench[:, 3:] @ [-u[1], u[0], 0.0]
        # The mean acceleration between two looks is what the rates have changed by.
        period = 1e-9 * UNOBSERVABLE_TEST.period_ns
        P[6:9, 6:9] = 2.0 / period**2 * P[3:6, 3:6]
        E_motion = E[:, _MOTION]
        # Noise of the wrench is that of each; a force of unknown direction lasts, and the motion.
        noise = scratch.noise / wrenches
        noise += settings.direction_time / period * scratch.direction_noise
        noise += E_motion @ P[_MOTION, _MOTION] @ E_motion.T
        return slopes, E[:, n:], noise

    def _test(self, friction, stddev):
        """Test the estimated friction against the stated one by a likelihood ratio."""
        stated = self._scene.friction_stddev
        open_ = stated**2 - stddev**2
        if not self._learnt[_FRICTION] or not open_ > 0.0:
            return
        # What is learnt may lie from what is stated by no more than what it has learnt.
        off = abs(friction - self._scene.friction) / sqrt(open_)
        nats = 0.5 * off * off
        self._refuted = self._refuted + 1 if nats > UNOBSERVABLE_TEST.refuted else 0
        if self._refuted >= UNOBSERVABLE_TEST.looks and self.finding is None:
            self.finding = Finding(
                f"friction seems to be {friction:.3f} +- {stddev:.2g} instead of scene.friction = "
                f"{self._scene.friction:g} +- {stated:g}, a change of {off:.1f} standard "
                "deviations; an error of a force along the peg, of a lever or of a weight looks "
                "the same",
                {},
                "scene",
                hint=True,
            )


def stated_offsets(configuration: Configuration) -> np.ndarray:
    """Return how far each of KINDS may be off as stated; 0: nothing is stated, shape (8,)."""
    scene, wrench = configuration.scene, configuration.wrench
    clearance = scene.clearance_stddev / (scene.hole_diameter - scene.peg_diameter)
    return np.array(
        [
            scene.friction_stddev, clearance, wrench.bias_force_stddev, wrench.bias_force_stddev,
            wrench.bias_torque_stddev, configuration.joints.hole_tilt_stddev, 0.0, 0.0,
        ]
    )  # fmt: skip


def offsets_of(configuration: Configuration) -> np.ndarray:
    """Return by how much each of KINDS may be off: as stated, else as is typical, shape (8,)."""
    typical, stated = np.array([kind.typical for kind in KINDS]), stated_offsets(configuration)
    of_torque = np.array([kind.unit == "N m" for kind in KINDS])
    typical[of_torque] *= configuration.scene.hole_diameter / 0.05
    return np.where(stated > 0.0, stated, typical)


# How far off each of KINDS is meant to be, in words.
_OFF_BY = (
    "friction by {}", "the clearance by {}", "a force along the peg of {}",
    "a force across the peg of {}", "the torque's bias by {}", "the hole's direction by {}",
    "gamma by {}", "the sensor's height by {}",
)  # fmt: skip


def words(costs: dict[str, float | None], configuration: Configuration) -> str:
    """
    Return which settings the motion cannot determine, and what that means [N], as one line.

    The dearest comes first, nothing below 1 N. Near wedging a cost has no limit: above that of
    the reactions it is not written as a number.
    """
    found = []
    most = max(configuration.monitor.max_normal)
    for name, kind, off_by, offset in zip(
        UNOBSERVABLE_SETTINGS, KINDS, _OFF_BY, offsets_of(configuration).tolist()
    ):
        if (cost := costs[name]) is not None and cost >= 1.0:
            off = (
                f"{number(100 * offset)} %"
                if kind.unit == "of it"
                else quantity(offset, kind.unit)
            )
            moves = quantity(cost, "N", 2) if cost <= most else f"more than {quantity(most, 'N')}"
            found.append((cost, f"{off_by.format(off)}: {moves}"))
    lines = [text for _, text in sorted(found, reverse=True)]
    if not lines:
        return ""
    return (
        "settings that this motion cannot determine, each with an offset and the error of a "
        f"reaction that it causes: {'; '.join(lines)}"
    )
