"""The contact filter with the sensor's bias and the tilt of the hole's axis as further states."""

from math import sqrt

import numpy as np

from peg_on_hole_ros.estimation.filters.contact import ContactFilter
from peg_on_hole_ros.estimation.kernel.bias_in_air import hang, touched
from peg_on_hole_ros.estimation.kernel.friction_lag import friction_density
from peg_on_hole_ros.estimation.kernel.memory import part
from peg_on_hole_ros.estimation.kernel.offsets import (
    BIAS,
    COUNT,
    TILT,
    Offsets,
    correct_with_offsets,
    fill_turn,
    hold_offsets,
    innovation_with_offsets,
    offsets_are_small,
    turn_gravity,
)
from peg_on_hole_ros.estimation.measurement import angles_of, tilt_axes
from peg_on_hole_ros.estimation.orientation import angle_errors
from peg_on_hole_ros.mechanics.reference import peg_axes

NAMES = (
    *(f"bias_force_{axis}" for axis in "xyz"),
    *(f"bias_torque_{axis}" for axis in "xyz"),
    "hole_tilt_x",
    "hole_tilt_y",
)
# Standard deviations of a slip within which it is not told from none, at most: most of its spread
# is what the offsets may make of it, and nothing is learnt of them while it counts as none.
SLOW_SLIP = 1.0


class OffsetFilter(ContactFilter):
    """
    Extended Kalman filter on state, friction, peg diameter and `offsets`.

    Its state is in the axes of the hole as that is now taken to lie: orientations are to be given
    through `in_hole_axes`. An offset is learnt where all contacts surely slide, as friction is.

    Parameters
    ----------
    scene, options, wrench_noise
        As for `ContactFilter`.
    offsets : Offsets

    Attributes
    ----------
    offset : ndarray, shape (8,)
        Bias of force [N] and torque [N m] beyond the one that is taken off, as the sensor reports
        them, and tilt of the hole about its configured x and y [rad].
    offset_spread : ndarray, shape (8, 10)
        Covariance of them with friction and peg diameter, and with one another.

    """

    def __init__(self, scene, options, wrench_noise, offsets: Offsets):
        super().__init__(scene, options, wrench_noise)
        self.offsets, self.active = offsets, offsets.active
        self.offset = part(self._memory, "OFFSET")
        self.offset_spread = part(self._memory, "OFFSET_SPREAD", (COUNT, 2 + COUNT))
        self._offset_cross = part(self._memory, "OFFSET_CROSS", (COUNT, 12))
        part(self._memory, "OFFSETS")[:] = (
            self.active.start,
            self.active.stop,
            offsets.bias_learnt and self.active.start < BIAS.stop,
            offsets.tilt_learnt and self.active.stop > TILT.start,
        )
        part(self._memory, "LOAD", (6, COUNT))[:, BIAS] = offsets.load
        part(self._memory, "MASSES", (6, 3))[:] = offsets.weight
        gravity2 = float(np.dot(scene.gravity, scene.gravity))
        part(self._memory, "UNLOAD", (6, 6))[:] = np.linalg.inv(offsets.load)
        part(self._memory, "HANGING", (3, 6))[:] = (
            offsets.noise,
            offsets.moved,
            offsets.moved * gravity2 * offsets.variance[TILT].max(),
        )
        self._given = part(self._memory, "GIVEN")
        part(self._memory, "GRAVITY")[:] = scene.gravity
        self._tilted = self.active.stop == COUNT
        # Of bias and tilt where nothing has been learnt: as stated, or as a tare has left it.
        self._unlearnt = np.array(offsets.variance, float)
        self.process = self.process._replace(slow_slip=min(options.slow_slip, SLOW_SLIP))
        if part(self._memory, "OFFSETS")[2:].any():
            density = friction_density(options, alone=False)
            self.process = self.process._replace(friction_density=density)
        part(self._memory, "PROCESS")[:] = self.process
        self._begin_anew()

    def _begin_anew(self):
        self.offset[:] = 0.0
        self.offset_spread[:] = 0.0
        self.offset_spread[range(COUNT), range(2, 2 + COUNT)] = self._unlearnt

    def forget(self):
        """Take bias and tilt as stated again as well; the bias as a tare has left it."""
        super().forget()
        self._begin_anew()

    @property
    def gravity(self) -> np.ndarray | None:
        """Gravity in the axes of the hole as it is now taken to lie; None: as configured."""
        if not self._tilted:
            return None
        return tilt_axes(self.offset[TILT]).T @ part(self._memory, "GRAVITY")

    def in_the_air(self, hangs: bool):
        """Learn the bias by the wrench that is held, if the peg hangs free; else stop doing so."""
        if hangs and self.offsets.bias_learnt and self.active.start < BIAS.stop:
            hang(self._memory, self._held)
        else:
            touched(self._memory)

    def tared(self, variance):
        """Begin the bias anew: known to a variance from here on, shape (6,)."""
        touched(self._memory)
        self.offset[BIAS] = 0.0
        self._offset_cross[BIAS] = 0.0
        self.offset_spread[BIAS] = 0.0
        self.offset_spread[:, 2 : 2 + BIAS.stop] = 0.0
        self._unlearnt[BIAS] = np.minimum(variance, self.offsets.variance[BIAS])
        self.offset_spread[range(6), range(2, 8)] = self._unlearnt[BIAS]

    def in_hole_axes(self, q, R):
        """Return an orientation and its covariance in the axes of the hole as it now lies."""
        if not self._tilted:
            return q, R
        R_SH = tilt_axes(self.offset[TILT])
        turned = angles_of(R_SH.T @ peg_axes(q))
        # The same rotation makes other angles: R is that of an error about the configured axes.
        by_angle = angle_errors(turned) @ R_SH.T @ np.linalg.inv(angle_errors(q))
        return turned, by_angle @ R @ by_angle.T

    def start(self, q, R):
        """Start from an orientation in hole axes; what was learnt of the offsets stays."""
        super().start(q, R)
        if not np.isfinite(self.offset.sum() + self.offset_spread.sum()):
            self._begin_anew()
        if not self._tilted:
            return
        turn_gravity(self._memory)
        fill_turn(self._memory)
        turn = part(self._memory, "TURN", (3, 2))
        tilt = self.offset_spread[TILT]
        # Measured angles are the true ones plus what the tilt is beyond its estimate.
        self.Z[:3, :3] += turn @ tilt[:, 8:] @ turn.T
        self._cross.reshape(2, 12)[:, :3] = -(turn @ tilt[:, :2]).T
        self._offset_cross[:, :3] = -(turn @ tilt[:, 2:]).T

    def hold(self, u):
        """Hold a new wrench, with its own noise and what the offsets make of it."""
        bias = self.offsets.load @ self.offset[BIAS]
        # What has changed is told by the sensor; the held one may have been corrected by more.
        self.u[:] = self._given + bias if self._given.any() else 0.0
        self._given[:] = u
        super().hold(u + bias)
        hold_offsets(self._memory)

    def _doubt_without_step(self, dt):
        if offsets_are_small(self._memory):
            super()._doubt_without_step(dt)

    @property
    def friction_is_open(self) -> bool:
        """Whether friction is to be learnt, hardly has been, and no offset may be meant."""
        return super().friction_is_open and offsets_are_small(self._memory)

    @property
    def _keeps_sliding(self):
        return True

    def innovation(self, q):
        """Fill the memory with the innovation of an orientation; return it squared, normalised."""
        return innovation_with_offsets(self._memory, q)

    def _update(self):
        correct_with_offsets(self._memory)

    def joint_covariance(self) -> np.ndarray:
        """Return the covariance of state, held wrench, friction, peg diameter, active offsets."""
        active = self.active
        cross = np.hstack([self._offset_cross[active], self.offset_spread[active, :2]])
        own = self.offset_spread[active, 2 + active.start : 2 + active.stop]
        return np.block([[super().joint_covariance(), cross.T], [cross, own]])

    def learnt(self, taken) -> dict[str, float]:
        """
        Return the active offsets and their standard deviations by name.

        Parameters
        ----------
        taken : ndarray, shape (6,)
            The bias that is taken off already, as the sensor reports it [N], [N m].

        """
        values = self.offset.copy()
        values[BIAS] += taken
        value, variance = values.tolist(), np.diagonal(self.offset_spread[:, 2:]).tolist()
        found = {}
        for i in range(self.active.start, self.active.stop):
            found[NAMES[i]] = value[i]
            found[f"{NAMES[i]}_stddev"] = sqrt(max(variance[i], 0.0))
        return found
