"""What a filter estimates: state, covariance and parameters as named views of one memory."""

from math import isfinite, sqrt

import numpy as np

from peg_on_hole_ros.estimation.kernel.friction_doubt import take_friction
from peg_on_hole_ros.estimation.kernel.friction_lag import friction_density
from peg_on_hole_ros.estimation.kernel.memory import CLEARED, SIZE, clear, part
from peg_on_hole_ros.estimation.kernel.process import Process
from peg_on_hole_ros.estimation.steps.choice import INTEGRATORS
from peg_on_hole_ros.mechanics.kernel import WIDTH, scene_scalars
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.options import FilterOptions

# A clearance counts as wide above this share of its stated spread.
WIDE_CLEARANCE = 0.1
# No clearance is learnt better than to this share of its stated spread: contacts give, and holes
# are not round.
LEAST_CLEARANCE_SPREAD = 0.01


class Estimate:
    """
    State, held wrench, friction and peg diameter with their joint covariance.

    Parameters
    ----------
    scene : Scene
    options : FilterOptions
    wrench_noise : ndarray, shape (6, 6)
        Covariance of the wrench about the mass centre, peg axes [N^2, N^2 m, N^2 m^2].

    Attributes
    ----------
    x : ndarray, shape (6,)
        gamma, psi, phi [rad], unwrapped, and Euler rates [rad/s].
    Z : ndarray, shape (12, 12)
        Joint covariance of x and of the wrench that is held.
    u : ndarray, shape (6,)
        The wrench that is held, peg axes, about the mass centre [N], [N m].
    spread : ndarray, shape (2, 2)
        Covariance of friction and peg diameter; zero where they are known.
    scene_values : ndarray
        The fields of SceneScalars as they are now: friction and diameter may be learnt.

    """

    def __init__(self, scene: Scene, options: FilterOptions, wrench_noise):
        self.scalars = scene_scalars(scene)
        self.options = options
        self.process = Process(
            options.max_step,
            options.contact_rate_noise**2,
            options.slip_velocity_scale,
            options.slip_widening,
            friction_density(options, not _learns_clearance(scene, options)),
            options.slow_slip,
            options.wrench_jump,
            options.slow_rate_noise,
        )
        self._memory = np.zeros(SIZE)
        self._dy = np.zeros((6, WIDTH))
        self._slopes = np.zeros((6, WIDTH))
        self.x, self.u = part(self._memory, "X"), part(self._memory, "U")
        self.Z = part(self._memory, "Z", (12, 12))
        self._P = self.Z[:6, :6]
        self.wrench_noise = part(self._memory, "NOISE", (6, 6))
        self._scales = part(self._memory, "SCALES")
        self._sliding = part(self._memory, "SLIDING")
        self._slid = part(self._memory, "SLID")
        self._interval = part(self._memory, "INTERVAL")
        self._since_correction = part(self._memory, "SINCE_CORRECTION")
        self._held_back = part(self._memory, "HELD_BACK")
        self._on_contacts = part(self._memory, "ON_CONTACTS")
        self._slow = part(self._memory, "SLOW")
        self._bridged = part(self._memory, "BRIDGED")
        self._beside = part(self._memory, "BESIDE_X"), part(self._memory, "BESIDE_P", (6, 6))
        self._beside_noise = part(self._memory, "BESIDE_RATE_NOISE")
        self._steps_lean = part(self._memory, "STEPS_LEAN")
        self._doubt = part(self._memory, "DOUBT")
        self._without_step = part(self._memory, "WITHOUT_STEP")
        self._stopped = part(self._memory, "STOPPED")
        self._told = part(self._memory, "TOLD_SHARE")
        self._unbalance = part(self._memory, "UNBALANCE")
        self._ramp = part(self._memory, "RAMP")
        self._rate_noise = part(self._memory, "RATE_NOISE")
        self._rate_noise[0] = options.slow_rate_noise
        self._R = part(self._memory, "R", (3, 3))
        self._residual = part(self._memory, "RESIDUAL")
        part(self._memory, "PROCESS")[:] = self.process
        self.integrator = INTEGRATORS[options.integrator]
        part(self._memory, "METHOD")[:] = (
            self.integrator,
            options.step_tolerance,
            options.max_evaluations,
        )
        self._slow_slip = part(self._memory, "PROCESS")[Process._fields.index("slow_slip") :]
        self._attempts = part(self._memory, "REFUSED")
        self.wrench_noise[:] = wrench_noise
        part(self._memory, "WEIGHT", (6, 6))[:] = np.linalg.inv(wrench_noise)
        self.spread = part(self._memory, "SPREAD", (2, 2))
        self._cross = part(self._memory, "CROSS")
        self.scene_values = part(self._memory, "SCENE")
        self._known = (scene.friction_stddev**2, scene.clearance_stddev**2)
        part(self._memory, "STATED")[:] = scene.friction, self._known[0]
        self._friction_lag = part(self._memory, "FRICTION_LAG")
        self._take_stated()
        part(self._memory, "LEARNT")[:] = (
            options.friction == "estimated",
            options.clearance == "estimated",
        )
        self._normal = part(self._memory, "Y")[3:]
        self._normal_variance = np.diagonal(part(self._memory, "REACTIONS", (6, 6)))[3:]
        self._peg_height = scene.peg_height

    @property
    def P(self) -> np.ndarray:
        """Covariance of the state, a view, shape (6, 6)."""
        return self._P

    @property
    def friction(self) -> tuple[float, float]:
        """The friction coefficient as it is now, and its standard deviation."""
        return self.scene_values.item(7), sqrt(max(self.spread.item(0), 0.0))

    @property
    def stated_friction(self) -> tuple[float, float]:
        """The friction coefficient as it was stated, and its standard deviation."""
        return self.scalars.f, sqrt(self._known[0])

    @property
    def peg_diameter(self) -> tuple[float, float]:
        """The peg's diameter as it is now, and its standard deviation (of the clearance) [m]."""
        return self.scene_values.item(0), sqrt(max(self.spread.item(3), 0.0))

    @property
    def clearance(self) -> tuple[float, float]:
        """D - d as it is now, and its standard deviation [m]."""
        peg, stddev = self.peg_diameter
        return self.scalars.D - peg, stddev

    @property
    def gamma0(self) -> float:
        """Tilt at which three-point contact ends, with the diameter as it is now [rad]."""
        return self.scene_values.item(3)

    @property
    def held_back(self) -> bool:
        """Whether the last correction told more of friction or peg diameter than was learnt."""
        return self._held_back.item() > 0.0

    @property
    def tells_friction(self) -> bool:
        """Whether friction was learnt in the last correction, if it is learnt at all."""
        return self._sliding.item(0) > 0.0

    def doubt(self) -> bool:
        """Take a learnt friction as it was stated, if one was learnt: it does not fit."""
        learnt = self.spread.item(0) < self._known[0]
        if learnt:
            self.take_friction(self.scalars.f, self._known[0])
        return learnt

    def take_friction(self, value: float, variance: float):
        """Take friction for a value that has nothing to do with what else is known."""
        take_friction(self._memory, value, variance)

    @property
    def learns_clearance(self) -> bool:
        """Whether the peg's diameter is learnt, being uncertain."""
        return self.options.clearance == "estimated" and self.spread.item(3) > 0.0

    def _keep_least_clearance(self):
        if self.learns_clearance:
            least = LEAST_CLEARANCE_SPREAD**2 * self._known[1]
            self._widen_parameters(0.0, least - self.spread.item(3))

    @property
    def _clearance_is_wide(self):
        return self.learns_clearance and (self.spread.item(3) > WIDE_CLEARANCE**2 * self._known[1])

    def _widen_parameters(self, friction, diameter):
        """Add to the variances of friction and of the peg diameter; nothing below zero."""
        self.spread[0, 0] += max(friction, 0.0)
        self.spread[1, 1] += max(diameter, 0.0)

    def joint_covariance(self) -> np.ndarray:
        """Return the covariance of state, held wrench, friction, peg diameter, shape (14, 14)."""
        cross = self._cross.reshape(2, 12)
        return np.block([[self.Z, cross.T], [cross, self.spread]])

    @property
    def memory(self) -> np.ndarray:
        """All numbers of the filter, see `memory`, for other compiled code to read."""
        return self._memory

    def start(self, q, R):
        """Start from an orientation q [rad] with covariance R, at unknown rates."""
        clear(self._memory, CLEARED.start)
        self.x[:3] = q
        self.Z[:3, :3] = R
        rate_variance = self.options.initial_rate_stddev**2
        self.Z[range(3, 6), range(3, 6)] = rate_variance
        self.Z[6:, 6:] = self.wrench_noise
        x, P = self._beside
        x[:], P[:] = self.x, self._P
        self._beside_noise[0] = self.options.slow_rate_noise
        self._scales[:] = self.options.slip_velocity_scale
        self._rate_noise[0] = self.options.slow_rate_noise
        friction, diameter = self.scene_values.item(7), self.scene_values.item(0)
        if not isfinite(friction + diameter + self.spread.sum()):
            # Lost with the covariance, and not to stay so.
            self._take_stated()

    def let_go(self):
        """Hold no wrench: what comes next has nothing to do with what was."""
        clear(self._memory, CLEARED.let_go)

    def forget(self):
        """Take friction and peg diameter as stated again, whatever has been learnt of them."""
        clear(self._memory, CLEARED.forget)
        # When a slip counts as slow follows how well the clearance is known.
        part(self._memory, "PROCESS")[:] = self.process
        self._take_stated()

    def _take_stated(self):
        """Take friction and peg diameter for what they are stated to be."""
        self.scene_values[:] = self.scalars
        self.spread[:] = np.diag(self._known)
        self._friction_lag[:] = self.scalars.f, self._known[0], 0.0


def _learns_clearance(scene, options):
    return scene.clearance_stddev > 0.0 and options.clearance == "estimated"
