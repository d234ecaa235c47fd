"""The estimator of a held peg: orientations and wrenches in, state and reactions out."""

from enum import Enum
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator import from_python, held
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.forces import rim_load
from peg_on_hole_ros.estimator.held import GATED, GATES, HELD, REFUSED, RESET, USED, fill_settings
from peg_on_hole_ros.estimator.kept import (
    KeptEstimates,
    keep_estimate,
    put_estimate_back,
    room_for_estimates,
)
from peg_on_hole_ros.estimator.offsets import Offsets
from peg_on_hole_ros.estimator.record import Estimate
from peg_on_hole_ros.estimator.settings import Settings, default_settings
from peg_on_hole_ros.estimator.state import (
    BIAS,
    FRICTION,
    OPEN,
    begin_state,
    named,
    places,
)
from peg_on_hole_ros.mechanics.kernel import scene_scalars
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.record_types import GatesRecord
from peg_on_hole_ros.typed_record import record_in


class Correction(Enum):
    """What became of an orientation; the values are advice."""

    USED = "used"
    GATED = "refused: further from the prediction than both covariances allow"
    RESET = "restarted from the measurement: refused too often in a row, or covariance lost"


class HeldPeg:
    """
    A mixture of extended Kalman filters on how a held peg moves, and on what its contacts carry.

    Parameters
    ----------
    scene : Scene
    options : FilterOptions
    wrench_noise : ndarray, shape (6, 6)
        Covariance of the wrench about the mass centre, peg axes [N^2, N^2 m, N^2 m^2].
    offsets : Offsets, optional
        What is not known of the sensor's zero and of the hole's direction.
    constants : Settings, optional
        The tuned constants; None: as shipped.

    Attributes
    ----------
    x : ndarray, shape (6,)
        gamma, psi, phi [rad], psi and phi unwrapped, and Euler rates [rad/s].
    P : ndarray, shape (6, 6)
        Its covariance.
    record : Estimate
        All that the last wrench has said.

    """

    def __init__(
        self,
        scene: Scene,
        options: FilterOptions,
        wrench_noise: np.ndarray,
        offsets: Offsets | None = None,
        constants: Settings | None = None,
    ) -> None:
        self.scene, self.options = scene, options
        self.scalars = scene_scalars(scene)
        self.offsets = offsets or Offsets.none()
        self.constants = constants or default_settings()
        names, mean, stddev, walk, learnt = _open_quantities(scene, options, self.offsets)
        self._at, self._n = places(names)
        several = scene.friction_stddev > 0.0 and options.friction == "estimated"
        frictions = self.constants.frictions if several else 1
        self._stated = stddev
        memory = np.zeros(1, HELD)
        held = memory[0]
        fill_settings(held["constants"], self.constants)
        held["scene"], held["at"], held["n"] = self.scalars, self._at, self._n
        held["friction_open"] = bool(scene.friction_stddev)
        held["bias_map"], held["noise"] = -self.offsets.load, wrench_noise
        if scene.friction_stddev:
            held["walk"][FRICTION] = options.friction_noise**2
        held["walk"][OPEN : self._n] = np.square(walk)
        learns = self.offsets.bias_learnt
        held["wander"] = learns * self.offsets.variance[:6] / self.constants.zero_time
        held["learnt"][: self._n + 3] = 1.0
        held["learnt"][FRICTION] = options.friction == "estimated"
        held["learnt"][OPEN : self._n] = learnt
        held["record"]["wrench_noise"] = wrench_noise
        # What was learnt outlives a motion: friction and what is open begin from it.
        held["begin"][:REFUSED] = scene.friction, scene.friction_stddev
        held["open_stddev"][: len(stddev)] = stddev
        begin_state(held["state"], self._n, frictions, len(self.constants.level))
        self._live_in(memory)

    def move_to(self, memory: np.ndarray) -> None:
        """Live on in another array of HELD, shape (1,), as in a part of something larger."""
        memory[:] = self._memory
        self._live_in(memory)

    def _live_in(self, memory):
        self._memory, held = memory, memory[0]
        self.held, self.record = held, record_in(memory, "record", Estimate)
        self.wrench_noise, self._u, self._begin = held["noise"], held["u"], held["begin"]
        open_ = self._n - OPEN
        self._open_mean, self._open_stddev = held["open_mean"][:open_], held["open_stddev"][:open_]
        self.state = named(held["state"])
        self.x, self.P = self.state.mean[:6], self.state.covariance[:6, :6]

    @property
    def gates(self) -> GatesRecord:
        """When an orientation is refused, as the options say now, a record of GATES."""
        gates = np.zeros(1, GATES)[0]
        for name in GATES.names:  # type: ignore[union-attr]
            gates[name] = getattr(self.options, name)
        return gates

    def start(self, q: ArrayLike, R: ArrayLike) -> None:
        """Start from an orientation q [rad] with covariance R, at unknown rates."""
        from_python.start(self._memory, self.gates, np.asarray(q, float), np.asarray(R, float))

    def let_go(self) -> None:
        """Let go of the motion; what was learnt stays for the next start."""
        from_python.let_go(self._memory)

    def forget(self) -> None:
        """Take what was learnt as it was stated again, or as a tare has left it."""
        self.state.noise[:] = 1.0
        self._begin[:REFUSED] = self.scene.friction, self.scene.friction_stddev
        self._open_mean[:] = 0.0
        self._open_stddev[:] = self._stated

    def snapshot(self) -> KeptEstimates:
        """Return everything that the estimate depends on, for `restore`."""
        kept = room_for_estimates(1, self.held["state"])
        keep_estimate(kept, 0, self._memory.view(np.int64), self.held["state"])
        return kept

    def restore(self, kept: KeptEstimates) -> None:
        """Go back to a snapshot; what follows is then bit for bit what followed it."""
        put_estimate_back(kept, 0, self._memory.view(np.int64), self.held["state"])

    def predict(self, dt: float) -> None:
        """Move the estimate on by dt [s]."""
        from_python.move_on(self._memory, dt)

    def correct(self, q: np.ndarray, R: np.ndarray) -> tuple[Correction, float]:
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
        result, nis = from_python.hold_against(self._memory, self.gates, q, R)
        if result == USED:
            from_python.orient(self._memory, q, R)
        elif result != GATED:
            if result == RESET:
                self.let_go()
            self.start(q, R)
        return CORRECTIONS[result], nis

    def weigh(self, u: np.ndarray, contacts: ContactSet) -> None:
        """
        Take a wrench on the peg, and fill in the record.

        Parameters
        ----------
        u : ndarray, shape (6,)
            Force and moment about the mass centre, peg axes [N], [N m].
        contacts : ContactSet

        """
        from_python.weigh(self._memory, np.asarray(u, float), int(contacts))

    def mark(self, t_ns: int) -> None:
        """Take note of the stamp [ns] of a wrench that has been taken; a smoother does."""

    def _fill(self):
        held.fill(self.held)

    @property
    def friction(self) -> tuple[float, float]:
        """The friction coefficient as it is now, and its standard deviation."""
        s = self.state
        return s.mean.item(FRICTION), sqrt(max(s.covariance.item(FRICTION, FRICTION), 0.0))

    @property
    def clearance(self) -> tuple[float, float]:
        """D - d as it is now, and its standard deviation [m]."""
        scene = self.record.scene
        return scene.D - scene.d, sqrt(max(self.record.diameter_variance, 0.0))

    @property
    def orientation_noise(self) -> float:
        """Variance of orientations as their innovations show it, over the stated one."""
        return self.state.noise.item(0)

    @property
    def frictions(self) -> int:
        """How many frictions are followed."""
        return int(self.state.alive.sum())

    @property
    def gravity(self) -> np.ndarray:
        """Gravity in the axes of the hole as it is now taken to lie [m/s^2]."""
        return np.array(held.gravity(self.held))

    def reactions(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the reactions N_K, N_B1, N_B2 of the last wrench and their deviations [N]."""
        n, s = self._n, self.state
        variance = np.diagonal(s.covariance)[n:]
        return s.mean[n:].copy(), np.sqrt(np.maximum(variance, 0.0))

    def rim_load(self) -> tuple[float, float]:
        """Return the sizes of the force [N] and the couple [N m] that the rim carries."""
        return rim_load(self.record)

    def tared(self, variance: np.ndarray) -> None:
        """Begin the bias anew: known to a variance from here on, shape (6,)."""
        first = self._at[BIAS]
        if first < 0:
            return
        s, last = self.state, first + 6
        stddev = np.sqrt(np.minimum(variance, self.offsets.variance[:6]))
        self._open_mean[first - OPEN : last - OPEN] = 0.0
        self._open_stddev[first - OPEN : last - OPEN] = stddev
        # What a tare leaves open outlives what was learnt.
        self._stated[first - OPEN : last - OPEN] = stddev
        s.air[:] = 0.0
        for x, P in (*zip(s.x, s.P), (s.mean, s.covariance)):
            x[first:last] = 0.0
            P[first:last] = P[:, first:last] = 0.0
            P[range(first, last), range(first, last)] = stddev**2

    @property
    def bias(self) -> np.ndarray:
        """The sensor's bias beyond what is taken off, shape (6,) [N], [N m]."""
        first = self._at[BIAS]
        return np.zeros(6) if first < 0 else self.state.mean[first : first + 6].copy()


CORRECTIONS = (Correction.USED, Correction.GATED, Correction.RESET, Correction.RESET)


def _open_quantities(scene, options, offsets):
    """Return what a configuration leaves open: names, means, deviations, walks, if learnt."""
    clearance = scene.hole_diameter - scene.peg_diameter
    rows = [
        (
            "clearance",
            [scene.clearance_stddev / clearance],
            [scene.clearance_drift / clearance],
            options.clearance,
        ),
        ("friction_k", [scene.friction_k_stddev], [0.0], "estimated"),
        ("bias", np.sqrt(offsets.variance[:6]), offsets.bias_drift, _word(offsets.bias_learnt)),
        ("tilt", np.sqrt(offsets.variance[6:]), [0.0] * 2, _word(offsets.tilt_learnt)),
        ("delay", [offsets.delay_stddev], [0.0], "considered"),
        ("compliance", [scene.compliance_stddev], [0.0], "estimated"),
    ]
    names, stddevs, walks, learnt = [], [], [], []
    for name, stddev, walk, how in rows:
        if np.any(stddev) or np.any(walk):
            names.append(name)
            stddevs.extend(stddev)
            walks.extend(walk)
            learnt.extend([how == "estimated"] * len(stddev))
    return (
        tuple(names),
        np.zeros(len(stddevs)),
        np.array(stddevs, float),
        np.array(walks, float),
        learnt,
    )


def _word(learnt):
    return "estimated" if learnt else "considered"
