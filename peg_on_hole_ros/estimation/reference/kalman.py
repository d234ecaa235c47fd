"""The same filter by filterpy on the numpy model: slow, readable, what the kernel answers to."""

from contextlib import contextmanager
from copy import deepcopy

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from peg_on_hole_ros.estimation.kernel.bridging import ONE_WRENCH
from peg_on_hole_ros.estimation.kernel.held_wrench import AT_ANY_TIME, JUMP_LIMIT
from peg_on_hole_ros.estimation.kernel.parameters import (
    learning_share,
    learnt_variance,
    tells_diameter,
)
from peg_on_hole_ros.estimation.kernel.prediction import (
    HIDDEN,
    SELECTED,
    SELECTED_OVER,
    SURELY,
)
from peg_on_hole_ros.estimation.reference.acceleration import FollowedAcceleration, MeanRates
from peg_on_hole_ros.estimation.reference.balance import correct_by_balance
from peg_on_hole_ros.estimation.reference.bridging import ConstantRates, RateNoise, random_walk
from peg_on_hole_ros.estimation.reference.friction import FrictionLag
from peg_on_hole_ros.estimation.reference.reactions import reactions
from peg_on_hole_ros.estimation.reference.slip import bridged_scales, friction_scales, slip
from peg_on_hole_ros.estimation.reference.steps import (
    DIAMETER,
    FRICTION,
    RATES,
    SIZE,
    STATE,
    WRENCH,
    implicit_euler,
    implicit_euler_tangent,
    second_order,
)
from peg_on_hole_ros.estimation.steps.choice import LONG_STEP
from peg_on_hole_ros.estimation.steps.second_order import SHARE


def _random_walk_implicit(density, h, size):
    """Return what a random walk of the rates adds in an implicit step."""
    # The implicit step moves the angle with the rate at its end.
    carried = np.zeros((size, 3))
    carried[:3], carried[RATES] = h * np.eye(3), np.eye(3)
    return h * carried * density @ carried.T


class ReferenceFilter(ExtendedKalmanFilter):
    """
    The contact filter as one of 14 states.

    The held wrench is six of them, which restart with each wrench; friction and peg diameter are
    the last two, learnt where their variance is not zero. What `ContactFilter` does about
    parameters that are only considered, surprises and limits of what is learnt is not here.

    Parameters
    ----------
    scene : Scene
    process : estimation.kernel.process.Process
    wrench_noise : ndarray, shape (6, 6)

    """

    def __init__(self, scene, process, wrench_noise, size=SIZE):
        super().__init__(dim_x=size, dim_z=3)
        self.scene = scene
        self.process = process
        self.wrench_noise = wrench_noise
        self.change = np.zeros(6)
        self.ramp, self.jump, self.ramp_shares = np.zeros(6), np.zeros(6), (0.0, 1.0)
        self.acceleration, self.since_correction = FollowedAcceleration(), 0.0
        self.mean_rates = MeanRates()
        self.friction_lag = FrictionLag(scene.friction, scene.friction_stddev**2)
        self.scales = np.full(3, process.slip_velocity_scale)
        self.across = np.zeros(3)
        # slid: all contacts did in a step since the last correction.
        self.sliding = self.slid = self.slow = self.bridged = self.on_contacts = False
        self.stopped = self.without_step = 0.0
        self.rate_noise = RateNoise(process.slow_rate_noise)
        # Constant rates beside it.
        self.beside = None
        self.balance = self.unbalance = None
        self.x = np.zeros(size)
        self.x[FRICTION], self.x[DIAMETER] = scene.friction, scene.peg_diameter

    @property
    def learns_geometry_or_bias(self):
        """Whether clearance, bias or tilt is learnt: constants that steps alone tell well."""
        return self.P[DIAMETER, DIAMETER] > 0

    @property
    def keeps_sliding(self):
        """Whether what a step told is not lost where the next has no direction."""
        return self.P[DIAMETER, DIAMETER] > 0

    # Bias and tilt, of which there are none here.
    carries_offsets, offsets_are_small, learns_bias = False, True, False

    def begin_beside(self):
        """Let constant rates beside it begin where it stands."""
        own = self.P[STATE, STATE]
        self.beside = ConstantRates(self.process.slow_rate_noise, self.x[STATE], own)

    def hold(self, u):
        """Hold a new wrench."""
        before, self.change = self.change, u - self.x[WRENCH]
        size, new = self._size(self.change), self._size(self.change - before)
        # Two noises differ by twice the covariance of one. Before the first wrench there is none.
        share = max(0.0, 1 - 2 * JUMP_LIMIT / size) if self.x[WRENCH].any() and size > 0 else 0.0
        self.ramp = self.process.wrench_jump * np.sqrt(share) * self.change
        # A change that goes on as before is a ramp; of what is new the time is not known.
        self.jump = np.sqrt(AT_ANY_TIME * (new / size if new < size else 1.0)) * self.ramp
        self.ramp_shares = 0.0, 1.0
        self.x[WRENCH] = u
        self.P[WRENCH, :] = self.P[:, WRENCH] = 0
        self.P[WRENCH, WRENCH] = self.wrench_noise

    def _size(self, change):
        return change @ np.linalg.solve(self.wrench_noise, change)

    def predict_contact(self, dt, pieces=1):
        """Predict over dt [s] in equal pieces by filterpy's own covariance equation."""
        self.slow, self.bridged, self.without_step = False, False, 0.0
        self.on_contacts = True
        self.since_correction += dt
        speed, variance = slip(self)
        self.sliding = bool((speed**2 >= variance).all())
        at_mean = self.learns_geometry_or_bias and not self.ramp.any()
        at_mean &= self.stopped <= SELECTED
        at_mean &= self.mean_rates.known(self.x[RATES], np.diagonal(self.P)[RATES])
        self.scales = friction_scales(self)
        h = dt / pieces
        for piece in range(pieces):
            if self.ramp.any():
                end, stage = self._on_ramp(piece + 1, pieces), self._on_ramp(piece + SHARE, pieces)
                full = np.concatenate([self.x[STATE], end, self.x[FRICTION:SIZE]])
                x1, F = second_order(self.scene, full, stage, h, self.scales)
                self.Q = random_walk(self.process.rate_density, h, self.dim_x)
            else:
                x1, F = implicit_euler(self.scene, self.x[:SIZE], h, self.scales)
                if at_mean:
                    late = np.concatenate([x1[:3], self.mean_rates.mean, self.x[6:SIZE]])
                    F = implicit_euler_tangent(self.scene, late, h, self.scales)
                self.Q = _random_walk_implicit(self.process.rate_density, h, self.dim_x)
            self._motion = x1
            self.F = np.eye(self.dim_x)
            self.F[STATE, :SIZE] = F
            self.predict()
        end, end_variance = slip(self)
        kept = (speed**2 > SURELY**2 * variance) & (end**2 > SURELY**2 * end_variance)
        surely = (kept & (end > 0.5 * speed)).any()
        self.stopped *= 0.0 if surely else 1 - min(dt / SELECTED_OVER, 1.0)
        selected = self.stopped > (HIDDEN if self.P[DIAMETER, DIAMETER] > 0 else SELECTED)
        self.sliding = self.slid = self.sliding and not selected
        jumped = pieces * F[:, WRENCH] @ self.jump
        self.P[STATE, STATE] += np.outer(jumped, jumped)
        if self.P[FRICTION, FRICTION] > 0:
            self.P[FRICTION, FRICTION] += self.process.friction_density * dt

    def _on_ramp(self, step, steps):
        begin, end = self.ramp_shares
        return self.x[WRENCH] - (1 - begin - (end - begin) * step / steps) * self.ramp

    def predict_slow(self, dt):
        """Predict as if free: a slip is not told from none."""
        apart = not (self.learns_geometry_or_bias or self.carries_offsets)
        if not self.slow and self.beside and apart:
            self._take_beside()
        self.predict_runaway(dt)
        self.slow = True
        self._note_unbelieved(dt)

    def predict_runaway(self, dt):
        """Predict as if free: the motion would run away, and is held."""
        self._bridge(dt)
        self.scales = bridged_scales(self)
        if self.keeps_sliding:
            self.sliding = self.slid

    def predict_limited(self, dt, rate_noise):
        """Predict as if free: no step was found within the evaluations that are allowed."""
        self.predict_without_step(dt, rate_noise)
        if dt > LONG_STEP:
            self._note_unbelieved(dt)

    def _note_unbelieved(self, dt):
        self.stopped += min(dt / SELECTED_OVER, 1.0) * (1 - self.stopped)

    def predict_without_step(self, dt, rate_noise):
        """Predict as if free: the equations have no step; random walk at least [rad/s^1.5]."""
        own, lasted = self.rate_noise.value, self.without_step + dt
        self.rate_noise.value = max(own, rate_noise)
        self._bridge(dt)
        if lasted <= ONE_WRENCH:
            self.rate_noise.value = own
        self.without_step, self.slid = lasted, False

    def _bridge(self, dt):
        slid, stopped, balance = self.slid, self.stopped, self.balance
        density = self.rate_noise.density(self.acceleration.mean)
        self.predict_free(dt, np.sqrt(density))
        self.bridged, self.on_contacts, self.slid = True, True, slid
        self.stopped, self.balance = stopped, balance

    def _take_beside(self):
        beside = self.beside
        if self.acceleration.rates is None or not beside.steady(self._walk_grows):
            return
        beside.advance(self.since_correction)
        if np.linalg.det(beside.P[3:, 3:]) < np.linalg.det(self.P[RATES, RATES]):
            self.x[STATE] = beside.x
            self.P[STATE, :] = self.P[:, STATE] = 0
            self.P[STATE, STATE] = beside.P
            self.rate_noise, self.acceleration = deepcopy((beside.noise, beside.acceleration))

    def learn_from_balance(self, dt, acceleration_stddev):
        """
        Correct, before a prediction, by how a held peg accelerates [rad/s^2].

        Friction, and where a slip was not told also angles and rates. The wrench is
        measured at the end of its interval: the angles are taken there.
        """
        moved = dt * self.x[RATES]
        self.x[:3] += moved
        correct_by_balance(self, dt, acceleration_stddev)
        self.x[:3] -= moved

    def predict_free(self, dt, rate_noise):
        """Predict over dt [s] at constant rates, with their random walk(s) [rad/s^1.5]."""
        self.slow = self.bridged = self.sliding = self.slid = self.on_contacts = False
        self.without_step, self.stopped, self.balance = 0.0, 0.0, None
        self.since_correction += dt
        self.scales = np.full(3, self.process.slip_velocity_scale)
        self.F = np.eye(self.dim_x)
        self.F[range(3), range(3, 6)] = dt
        self._motion = (self.F @ self.x)[STATE]
        self.Q = random_walk(rate_noise**2, dt, self.dim_x)
        self.predict()

    def predict_x(self, u=0):
        """Put the implicit step where filterpy puts F x."""
        self.x = np.concatenate([self._motion, self.x[6:]])

    def measured(self):
        """Return the derivatives of the measured angles."""
        return np.eye(self.dim_x)[:3]

    def correct(self, q, R):
        """
        Correct with an orientation q [rad] of covariance R by filterpy's update.

        Friction and peg diameter are only considered where the peg may not slide (Schmidt's
        filter), a diameter also where little tells of it, and on a ridge they are learnt with a
        share of the gain.
        """
        H = self.measured()
        self.adapt(q - self.x[:3], self.P[:3, :3] + R)
        self.correct_beside(q, R)
        shares = self.learning_shares(R)
        with self.bent_friction():
            if (shares == 1.0).all():
                self.update(q, lambda x: H, lambda x: x[:3], R=R)
            else:
                self.update_in_part(q - self.x[:3], H, R, np.r_[np.ones(FRICTION), shares])
        self.follow_motion()
        self.slid = False

    def correct_beside(self, q, R):
        """Correct the constant rates beside it, if there are any."""
        if self.beside:
            self.beside.correct(q, R, self.since_correction, self._walk_grows)

    def follow_motion(self):
        """Let acceleration, mean rates and how friction moved follow a correction."""
        self.mean_rates.follow(self.x[RATES], np.diagonal(self.P)[RATES], self.since_correction)
        self.acceleration.follow(self.x[RATES], self.since_correction)
        value, variance = self.x[FRICTION], max(self.P[FRICTION, FRICTION], 0.0)
        if self.learns_geometry_or_bias:
            self.friction_lag.rest(value, variance)
        else:
            self.P[FRICTION, FRICTION] = self.friction_lag.follow(value, variance)
        self.since_correction = 0.0

    @contextmanager
    def bent_friction(self):
        """Leave friction known no better than a tangent that moved it so far can tell."""
        value, before = self.x[FRICTION], self.P[FRICTION, FRICTION]
        yield
        after, moved = self.P[FRICTION, FRICTION], self.x[FRICTION] - value
        self.P[FRICTION, FRICTION] = learnt_variance(after, before, moved)

    def learning_shares(self, R):
        """Return the shares of the gain with which friction and peg diameter are learnt."""
        (ff, fd), (_, dd) = self.P[FRICTION:SIZE, FRICTION:SIZE]
        share = learning_share(ff, fd, dd) if self.sliding else 0.0
        seen = self.P[DIAMETER, :3]
        told = seen @ np.linalg.solve(self.P[:3, :3] + R, seen)
        tells = dd == 0.0 or tells_diameter(dd, told, self.since_correction)
        return np.array([share, share if tells else 0.0])

    def update_in_part(self, residual, H, R, share):
        """Update with a share of each gain, shape (14 or more,), in Joseph's form."""
        # filterpy has no gain but the optimal one.
        K = share[:, None] * (self.P @ H.T @ np.linalg.inv(H @ self.P @ H.T + R))
        self.x = self.x + K @ residual
        left = np.eye(self.dim_x) - K @ H
        self.P = left @ self.P @ left.T + K @ R @ K.T

    def adapt(self, residual, covariance):
        """Let the random walk at constant rates follow an innovation."""
        if self.bridged:
            rates, spread = self.x[RATES], self.P[RATES, RATES]
            self.rate_noise.adapt(residual, covariance, rates, spread, self._walk_grows)

    @property
    def _walk_grows(self):
        return self.P[DIAMETER, DIAMETER] == 0

    def reactions(self, acceleration_stddev):
        """Return normal reactions [N], weighed with the accelerations' prior, and covariance."""
        return reactions(self, acceleration_stddev)
