"""The estimator of a held peg: orientations and wrenches in, state and reactions out."""

from enum import Enum
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator import filter_steps
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.estimator.filter_record import FilterMemory, FilterRecord
from peg_on_hole_ros.estimator.forces import rim_load
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.estimator.open_quantities import open_quantities
from peg_on_hole_ros.estimator.orientation_noise import forget_noise_ratio
from peg_on_hole_ros.estimator.settings import Gates, Settings, default_settings
from peg_on_hole_ros.estimator.snapshot import (
    EstimateSnapshots,
    restore_estimate,
    room_for_estimates,
    save_estimate,
)
from peg_on_hole_ros.estimator.start import forget_air
from peg_on_hole_ros.estimator.state import (
    FRICTION,
    OPEN_BEGIN,
    begin_state,
    mixture_of,
    places_of,
)
from peg_on_hole_ros.mechanics.scene import Scene, scene_scalars
from peg_on_hole_ros.typed_record import Floats, at, dtype_of, new


class Correction(Enum):
    """What became of an orientation; the values are advice."""

    USED = "used"
    GATED = "refused: further from the prediction than both covariances allow"
    RESET = "restarted from the measurement: refused too often in a row, or covariance lost"


CORRECTIONS = (Correction.USED, Correction.GATED, Correction.RESET, Correction.RESET)


class ContactFilter:
    """
    A mixture of extended Kalman filters on how a held peg moves, and on what its contacts carry.

    Parameters
    ----------
    scene : Scene
    options : FilterOptions
    wrench_noise : ndarray, shape (6, 6)
        Covariance of the wrench about the mass centre, peg axes [N^2, N^2 m, N^2 m^2].
    offsets : OffsetUncertainty, optional
        What is not known of the sensor's bias and of the hole's direction.
    settings : Settings, optional
        The tuned constants; None: as shipped.

    Attributes
    ----------
    memory : ndarray of FilterRecord, shape (1,)
        All that it consists of, for compiled code.
    fields : FilterRecord
        The same memory.
    state : State
        The part that changes.
    mixture : Mixture
        Views of its mixture.
    x : ndarray, shape (6,)
        gamma, psi, phi [rad], psi and phi unwrapped, and Euler rates [rad/s].
    P : ndarray, shape (6, 6)
        Its covariance.
    record : Estimate
        All that the last wrench has determined.

    """

    def __init__(
        self,
        scene: Scene,
        options: FilterOptions,
        wrench_noise: Floats,
        offsets: OffsetUncertainty | None = None,
        settings: Settings | None = None,
    ) -> None:
        self.scene, self.options = scene, options
        self.scalars = scene_scalars(scene)
        self.offsets = offsets or OffsetUncertainty.all_known()
        open_ = open_quantities(scene, options, self.offsets)
        self._stated_stddev = open_.stddev
        self._use(np.zeros(1, dtype_of(FilterRecord)))
        memory = self.fields
        memory.settings = default_settings() if settings is None else settings
        memory.scene[:] = self.scalars
        memory.places = places_of(open_.names)
        n = int(memory.places.reactions)
        memory.friction_open = bool(scene.friction_stddev)
        memory.bias_map[:], memory.noise[:] = -self.offsets.load, wrench_noise
        if scene.friction_stddev:
            memory.walk[FRICTION] = options.friction_noise**2
        memory.walk[OPEN_BEGIN:n] = np.square(open_.walk)
        bias_walk = self.offsets.bias_learnt * self.offsets.variance[:6]
        memory.bias_walk_in_air[:] = bias_walk / memory.settings.bias_time
        memory.estimated[: n + 3] = 1.0
        memory.estimated[FRICTION] = options.friction == "estimated"
        memory.estimated[OPEN_BEGIN:n] = open_.estimated
        self.record.wrench_noise[:] = wrench_noise
        several = scene.friction_stddev > 0.0 and options.friction == "estimated"
        hypotheses = int(memory.settings.friction_hypotheses) if several else 1
        begin_state(memory.state, n + 3, hypotheses, int(memory.settings.modes))
        self._use(self.memory)
        # What was estimated outlives a motion: friction and what is open begin from it.
        self._begin_as_stated()

    def rebind_memory(self, memory: FilterMemory) -> None:
        """Live on in another array of FilterRecord, shape (1,), a part of something larger."""
        memory[:] = self.memory
        self._use(memory)

    def _use(self, memory: FilterMemory) -> None:
        self.memory, self.fields = memory, at(FilterRecord, memory)
        self.state, self.settings = self.fields.state, self.fields.settings
        self.record: Estimate = self.fields.record
        self.wrench_noise = self.fields.noise
        self.places = self.fields.places
        self._n = int(self.places.reactions)
        self.mixture = mixture_of(self.state)
        self.x, self.P = self.mixture.mean[:6], self.mixture.covariance[:6, :6]

    @property
    def gates(self) -> Gates:
        """When an orientation is refused, by the present options."""
        gates = new(Gates)
        gates.gate_threshold = self.options.gate_threshold
        gates.gate_reset_count = self.options.gate_reset_count
        gates.initial_rate_stddev = self.options.initial_rate_stddev
        return gates

    def start(self, q: ArrayLike, R: ArrayLike) -> None:
        """Start from an orientation q [rad] with covariance R, at unknown rates."""
        filter_steps.start(self.memory, self.gates, np.asarray(q, float), np.asarray(R, float))

    def end_estimate(self) -> None:
        """End the motion; what was estimated stays for the next start."""
        filter_steps.end_estimate(self.memory)

    def forget(self) -> None:
        """Begin again with friction and open quantities as stated, or as a tare has left them."""
        forget_noise_ratio(self.state)
        self._begin_as_stated()

    def _begin_as_stated(self) -> None:
        memory, open_ = self.fields, self._n - OPEN_BEGIN
        memory.start_friction = self.scene.friction
        memory.start_friction_stddev = self.scene.friction_stddev
        memory.friction_moved[:] = 0.0
        memory.open_mean[:open_] = 0.0
        memory.open_stddev[:open_] = self._stated_stddev

    def snapshot(self) -> EstimateSnapshots:
        """Return everything that the estimate depends on, for `restore`."""
        snapshots = room_for_estimates(1, self.state)
        save_estimate(snapshots, 0, self.memory.view(np.int64), self.state)
        return snapshots

    def restore(self, snapshots: EstimateSnapshots) -> None:
        """Go back to a snapshot; what follows is then bit for bit what followed it."""
        restore_estimate(snapshots, 0, self.memory.view(np.int64), self.state)

    def predict(self, dt: float) -> None:
        """Predict by dt [s]."""
        filter_steps.predict(self.memory, dt)

    def correct(self, q: Floats, R: Floats) -> tuple[Correction, float]:
        """
        Correct with an orientation.

        Parameters
        ----------
        q : ndarray, shape (3,)
            gamma, psi, phi [rad]; psi and phi may be off by turns.
        R : ndarray, shape (3, 3)
            Covariance [rad^2].

        Returns
        -------
        Correction
            After RESET the filter has been started from the orientation.
        nis : float
            Normalised innovation squared, 3 degrees of freedom.

        """
        q, R = np.asarray(q, float), np.asarray(R, float)
        result, nis = filter_steps.gate_orientation(self.memory, self.gates, q, R)
        if result == filter_steps.USED:
            filter_steps.use_orientation(self.memory, q, R)
        elif result != filter_steps.GATED:
            if result == filter_steps.RESET:
                self.end_estimate()
            self.start(q, R)
        return CORRECTIONS[result], nis

    def weigh(self, u: Floats, contact_set: ContactSet) -> None:
        """
        Correct by a wrench on the peg, and fill in the record.

        Parameters
        ----------
        u : ndarray, shape (6,)
            Force and moment about the mass centre, peg axes [N], [N m].
        contact_set : ContactSet

        """
        filter_steps.correct_by_wrench(self.memory, np.asarray(u, float), int(contact_set))

    def mark(self, t_ns: int) -> None:
        """Note the stamp [ns] of a wrench that has been taken; a smoother does."""

    def _fill(self) -> None:
        filter_steps.fill(self.memory)

    @property
    def friction(self) -> tuple[float, float]:
        """The friction coefficient as it is now, and its standard deviation."""
        mean, variance = self.mixture.mean, self.mixture.covariance.item(FRICTION, FRICTION)
        return mean.item(FRICTION), sqrt(max(variance, 0.0))

    @property
    def clearance(self) -> tuple[float, float]:
        """D - d as it is now, and its standard deviation [m]."""
        scene, variance = self.record.scene, self.record.diameter_variance
        return scene.D - scene.d, sqrt(max(variance, 0.0))

    @property
    def orientation_noise(self) -> float:
        """Variance of orientations as their innovations show it, over the stated one."""
        return float(self.state.noise_ratio)

    @property
    def hypotheses(self) -> int:
        """How many friction hypotheses are followed."""
        return int(self.mixture.alive.sum())

    @property
    def gravity(self) -> Floats:
        """Gravity in the axes of the hole at its estimated tilt [m/s^2]."""
        return np.array(filter_steps.gravity(self.memory))

    def reactions(self) -> tuple[Floats, Floats]:
        """Return the reactions N_K, N_B1, N_B2 of the last wrench and their deviations [N]."""
        variance = np.diagonal(self.mixture.covariance)[self._n :]
        return self.mixture.mean[self._n :].copy(), np.sqrt(np.maximum(variance, 0.0))

    def rim_load(self) -> tuple[float, float]:
        """Return the sizes of the force [N] and the couple [N m] that the rim carries."""
        return rim_load(self.record)

    def restart_bias(self, variance: Floats) -> None:
        """Begin the bias anew: known to a variance from here on, shape (6,)."""
        first, last = int(self.places.bias), int(self.places.bias) + 6
        if first < 0:
            return
        stddev = np.sqrt(np.minimum(variance, self.offsets.variance[:6]))
        opened = slice(first - OPEN_BEGIN, last - OPEN_BEGIN)
        self.fields.open_mean[opened] = 0.0
        self.fields.open_stddev[opened] = stddev
        # What a tare leaves open outlives what was estimated.
        self._stated_stddev[opened] = stddev
        forget_air(self.state)
        whole = self.mixture
        for x, P in (*zip(whole.x, whole.P), (whole.mean, whole.covariance)):
            x[first:last] = 0.0
            P[first:last] = P[:, first:last] = 0.0
            P[range(first, last), range(first, last)] = stddev**2

    @property
    def bias(self) -> Floats:
        """The sensor's bias beyond what is taken off, shape (6,) [N], [N m]."""
        first = int(self.places.bias)
        return np.zeros(6) if first < 0 else self.mixture.mean[first : first + 6].copy()
