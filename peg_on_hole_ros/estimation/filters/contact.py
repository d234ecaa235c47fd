"""The contact filter: state, covariance and the wrench that is held, over compiled steps."""

from math import sqrt

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.estimation.filters.estimate import Estimate
from peg_on_hole_ros.estimation.filters.gate import Gate
from peg_on_hole_ros.estimation.filters.model import Model, predict_at_constant_rates
from peg_on_hole_ros.estimation.filters.outcomes import Correction, Prediction, Reactions
from peg_on_hole_ros.estimation.kernel import correction, prediction
from peg_on_hole_ros.estimation.kernel.balance import learn_from_balance
from peg_on_hole_ros.estimation.kernel.bridging import walk_density
from peg_on_hole_ros.estimation.kernel.constant_rates import correct_beside
from peg_on_hole_ros.estimation.kernel.cycle import (
    bridge_unless_stepped,
    follow_innovation,
    follow_motion,
    resume_constant_rates,
)
from peg_on_hole_ros.estimation.kernel.description import Description, description
from peg_on_hole_ros.estimation.kernel.forces import rim_load
from peg_on_hole_ros.estimation.kernel.friction_doubt import (
    HARDLY_LEARNT,
    doubt_without_step,
    low_friction,
    regained_by_surprise,
)
from peg_on_hole_ros.estimation.kernel.held_wrench import hold_wrench
from peg_on_hole_ros.estimation.kernel.memory import SAVED, part
from peg_on_hole_ros.estimation.kernel.reactions import react
from peg_on_hole_ros.estimation.steps.choice import LONG_STEP
from peg_on_hole_ros.estimation.steps.implicit_euler import CONVERGED
from peg_on_hole_ros.ladder.rungs import DYNAMIC
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.options import FilterOptions

# Of a wrench's interval.
NEARLY_ALL = 0.9
# Steps that are not to be relied on, though there may be one.
_BRIDGED = {
    prediction.SLOW_SLIP: Prediction.SLOW,
    prediction.DOUBTED: Prediction.DOUBTED,
    prediction.RUNS_AWAY: Prediction.RUNAWAY,
}


class ContactFilter(Estimate):
    """
    Extended Kalman filter on gamma, psi, phi and their rates.

    Parameters
    ----------
    scene : Scene
    options : FilterOptions
    wrench_noise : ndarray, shape (6, 6)
        Covariance of the wrench about the mass centre, peg axes [N^2, N^2 m, N^2 m^2].
    offsets : Offsets, optional
        What is not known of bias and tilt; `OffsetFilter` alone carries any.

    Attributes
    ----------
    evaluations, pieces : int
        Of the last prediction: how often the six equations were solved, and in how many steps.
    model : Model
        The rung of the ladder that is in use.
    refused, inaccurate : int
        Attempts at it that were refused, since no step was found or since its error was too large.

    """

    def __init__(self, scene: Scene, options: FilterOptions, wrench_noise, offsets=None):
        if offsets is not None and offsets.variance.any():
            raise PegOnHoleError(
                f"{type(self).__name__} does not carry an uncertain bias or hole tilt: set "
                "wrench.bias_force_stddev, bias_torque_stddev and joints.hole_tilt_stddev to 0.0"
            )
        super().__init__(scene, options, wrench_noise)
        self.model = Model(options.model, options.reaction_tolerance, self._memory)
        self.evaluations = self.pieces = self.refused = self.inaccurate = 0
        self._gate = Gate()
        # How long the present wrench has been held, and the one before it was [s].
        self._held = self._held_before = 0.0

    def start(self, q, R):
        """Start from an orientation q [rad] with covariance R, at unknown rates."""
        super().start(q, R)
        self._gate.refused = 0

    def snapshot(self):
        """Return everything that the estimate depends on, for `restore`."""
        # What follows in the memory is filled anew before it is read.
        times = self._held, self._held_before
        return self._memory[:SAVED].copy(), self._gate.refused, times, self.model.snapshot()

    def restore(self, snapshot):
        """Go back to a snapshot; what follows is then bit for bit what followed it."""
        memory, self._gate.refused, times, model = snapshot
        self.model.restore(model)
        self._held, self._held_before = times
        self._memory[:SAVED] = memory

    def estimate(self):
        """Return what another filter of the same settings needs to `go_on_from` here."""
        return self.snapshot()

    def go_on_from(self, estimate):
        """Take an estimate for the own one."""
        self.restore(estimate)

    def let_go(self):
        """Hold no wrench: what comes next has nothing to do with what was."""
        super().let_go()
        self._held = self._held_before = 0.0
        self.model.restart()

    def hold(self, u):
        """Hold a new wrench, with its own noise, from here on."""
        self._held_before, self._held = self._held, 0.0
        hold_wrench(self._memory, np.asarray(u, float))
        self.model.held()

    def predict(self, dt: float, in_contact: bool) -> Prediction:
        """Predict over dt [s], under the contact equations if in_contact."""
        self.evaluations = self.pieces = self.refused = self.inaccurate = 0
        self._held += dt
        self._ramp_over(dt)
        constant = self.model.at_constant_rates(in_contact)
        self._unbalance[0] = 0.0
        learnt = in_contact and not constant and self._learn_from_balance(dt)
        self._begin(learnt)
        self._since_correction += dt
        if not in_contact:
            self._predict_free(dt)
            return Prediction.FREE
        status = self._predict_contact(dt, constant)
        bridged = _BRIDGED.get(status)
        stepped = status == CONVERGED
        if not stepped and bridged is None:
            self._doubt_without_step(dt)
        if resume_constant_rates(self._memory, status, dt):
            self._begin(True)
        bridge_unless_stepped(self._memory, self._slopes, status, dt, self.options.free_rate_noise)
        if stepped:
            self._slid[0] = self._sliding[0]
            return Prediction.HELD if constant else Prediction.CONTACT
        if bridged is None:
            self._slid[0] = 0.0
            return Prediction.LIMITED if status == prediction.LIMITED else Prediction.FAILED
        self.model.full()
        if self._keeps_sliding:
            # What is not known of them alone can hide a slip after one step; what that
            # step tells of them must not be lost, or nothing ever is told.
            self._sliding[0] = self._slid[0]
        return bridged

    def in_the_air(self, hangs: bool):
        """Take note of whether the peg hangs free under the wrench that is held; some learn."""

    def _predict_free(self, dt):
        self._on_contacts[0] = self._slow[0] = self._bridged[0] = 0.0
        self._without_step[0] = self._slid[0] = 0.0
        # Which steps noise has selected, and what balance told, was of another contact.
        self._stopped[0] = self._told[0] = 0.0
        self._scales[:] = self.options.slip_velocity_scale
        prediction.predict_free(self._memory, self._slopes, dt, self.options.free_rate_noise**2)

    def _doubt_without_step(self, dt):
        # Held for long, the noise of one wrench leaves no step just as well.
        if max(self._held, self._held_before) <= LONG_STEP:
            # What friction was learnt to be beside a clearance hardly known rests on a wrong one.
            patient = not self._clearance_is_wide
            doubt_without_step(self._memory, dt, patient)

    def _walk_at_constant_rates(self, result: Prediction) -> np.ndarray:
        """Return the random walk of each rate in the last prediction [rad/s^1.5], shape (3,)."""
        walk, free = self._rate_noise.item(), self.options.free_rate_noise
        if not self._bridged.item():
            return np.full(3, free)
        walk = walk if result in _BRIDGED.values() else max(walk, free)
        return np.sqrt([walk_density(self._memory, walk, i) for i in range(3)])

    def _predict_contact(self, dt, constant) -> int:
        if constant:
            density = self.options.free_rate_noise**2
            return predict_at_constant_rates(self._memory, self._slopes, dt, density)
        if self.learns_clearance:
            # A spread that is the clearance's own does not make the slip doubtful.
            slow = self.process.slow_slip
            self._slow_slip[0] = min(slow, 1.0) if self._clearance_is_wide else slow
        status, self.evaluations, self.pieces = prediction.predict_contact(
            self._memory, self._dy, self._slopes, dt
        )
        refused, inaccurate = self._attempts.tolist()
        self.refused, self.inaccurate = int(refused), int(inaccurate)
        return status

    def _ramp_over(self, dt):
        """Say which share of the wrench's interval this is; intervals are much alike."""
        interval = self._held_before
        if interval > 0.0:
            begin = min((self._held - dt) / interval, 1.0)
            end = min(self._held / interval, 1.0)
            # Stamps are in whole nanoseconds, and jitter.
            self._ramp[6:] = begin, (1.0 if end > NEARLY_ALL else end)

    def _learn_from_balance(self, dt) -> bool:
        stddev = self.options.acceleration_stddev
        return learn_from_balance(self._memory, self._dy, dt, stddev)

    def _begin(self, changed: bool):
        """Take note of what a prediction starts from; changed: apart from any correction."""

    @property
    def unbalance(self) -> tuple[float, float, float] | None:
        """
        By how much the last prediction found the forces out of balance; None: not weighed.

        What the equations say of the accelerations, less those of late, over the lower root of
        its covariance.
        """
        weighed, *white = self._unbalance.tolist()
        return tuple(white) if weighed else None

    @property
    def friction_is_open(self) -> bool:
        """Whether friction is to be learnt, and hardly has been."""
        learns = self.options.friction == "estimated" and self.model.rung == DYNAMIC
        return learns and self.spread.item(0) > HARDLY_LEARNT * self._known[0] > 0.0

    def seek_friction(self, q, R):
        """
        Start from an orientation q [rad] with covariance R; seek friction below the stated one.

        More friction holds a peg more only up to some coefficient, and beyond less, since it
        relieves the contacts: one motion fits two coefficients. From above the estimate may run
        to the greater, with which in the end a contact would pull; from below it finds the lower.
        """
        self.take_friction(low_friction(self._memory), self._known[0])
        self.start(q, R)

    def correct(self, q, R) -> tuple[Correction, float]:
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
        nis : float
            Normalised innovation squared before any widening, 3 degrees of freedom.

        """
        self._R[:] = R
        nis = self.innovation(q)
        follow_innovation(self._memory, nis, self._since_correction.item())
        result = self._gate.judge(self, q, nis)
        if result is Correction.RESET:
            self.start(q, R)
        elif result is not Correction.GATED:
            self._take()
        return result, nis

    def _take(self):
        self._interval[:] = self._since_correction
        correct_beside(self._memory, self._interval.item())
        self._update()
        follow_motion(self._memory, self._interval.item())
        self._slid[0] = 0.0
        self._keep_least_clearance()

    def last_innovation(self) -> tuple[list[float], list[float]]:
        """Return the last innovation, 3 values, and the lower root of its covariance, by rows."""
        l = part(self._memory, "S").tolist()
        root = [l[0], 0.0, 0.0, l[3], l[4], 0.0, l[6], l[7], l[8]]
        return part(self._memory, "RESIDUAL").tolist(), root

    def white_innovation(self) -> tuple[float, float, float]:
        """Return the last innovation over the lower root of its covariance."""
        return correction.white_innovation(self._memory)

    def innovation(self, q) -> float:
        """Fill the memory with the innovation of an orientation; return it squared, normalised."""
        return correction.innovation(self._memory, q)

    def trust_steps(self):
        """Forget how the innovations of steps leaned."""
        self._steps_lean[:] = self._doubt[:] = 0.0

    def widen(self, factor: float):
        """Let the rates' covariance grow by a factor of it, as after a motion not predicted."""
        self._widen_rates(factor)
        if self.learns_clearance:
            # Friction that has changed is not to be taken for another clearance.
            self._widen_parameters(regained_by_surprise(self._memory), 0.0)

    def _widen_rates(self, factor):
        correction.widen_rates(self._memory, self._since_correction.item(), factor)

    @property
    def _keeps_sliding(self):
        return self.learns_clearance

    def _update(self):
        correction.correct(self._memory)

    def mark(self, t_ns: int):
        """Take note of a stamp [ns] that the estimate has come to; a smoother does."""

    def react(self) -> float:
        """Fill the memory with the reactions; return the determinant, NaN where there are none."""
        if self.model.rung < DYNAMIC:
            return self.model.react(self._dy)
        return react(self._memory, self._dy, self.options.acceleration_stddev)

    def reactions(self) -> "Reactions | None":
        """Return the reactions of three-point contact; None where the equations have none."""
        determinant = self.react()
        if determinant != determinant:
            return None
        # Rounding can leave a variance a little below zero where the equations are near singular.
        stddev = tuple(sqrt(max(variance, 0.0)) for variance in self._normal_variance.tolist())
        return Reactions(tuple(self._normal.tolist()), stddev, determinant)

    def rim_load(self) -> tuple[float, float]:
        """Return the sizes of the force [N] and the couple [N m] that the rim carries."""
        return rim_load(self._memory)

    def describe(self, on_contacts: bool, wide: float) -> Description:
        """Return the estimate with the last reactions if on_contacts, and else without any."""
        return description(self._memory, self._peg_height, on_contacts, wide)
