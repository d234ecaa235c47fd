"""
Tuned numbers of the estimator that are the same for every filter, each with its reason.

Those that a method or a study may change for one filter are fields of `settings.Settings`.
"""

from typing import NamedTuple


class PoseFloor(NamedTuple):
    """
    What is added to the diagonal of the published pose's covariance.

    Three-point contact leaves three degrees of freedom, so that covariance has rank 3, and
    programs that invert it would fail.

    Attributes
    ----------
    position_stddev : float
        Of the place [m]: far below what any sensor of a cell resolves.
    rotation_stddev : float
        Of the rotation vector [rad]: far below what any sensor of a cell resolves.

    """

    position_stddev: float = 1.0e-6
    rotation_stddev: float = 1.0e-6


class PushingReactions(NamedTuple):
    """
    When the search for reactions that all push ends (Hildreth's iteration).

    It converges linearly: each pass multiplies the error by the squared correlation of the
    reactions that would pull.

    Attributes
    ----------
    most_passes : int
        Bound of the passes [passes]: reactions that are almost one would need them without end.
    least_step : float
        The search ends where a pass moves no reaction by more [standard deviations].

    """

    most_passes: int = 1000
    least_step: float = 1e-10


class SlipFloor(NamedTuple):
    """
    Below what size slips are not distinguished in the direction of friction.

    Attributes
    ----------
    least_variance : float
        Of a slip [m^2/s^2]: it is divided by, and may be zero.
    least_scale_square : float
        Of the velocity scale of friction's mean direction [m^2/s^2]: below it a slip has no
        direction.

    """

    least_variance: float = 1e-24
    least_scale_square: float = 1e-16


class MixtureWeights(NamedTuple):
    """
    How light components become, and how finely the process-noise modes are mixed.

    Attributes
    ----------
    least_weight : float
        A mode never goes below this weight among those of its friction hypothesis, so that it can
        return; a hypothesis that does is dropped [-].
    longest_mixing : float
        Mode transitions are counted over no longer a time at once [s]: beyond, more than all
        would change.
    least_log_ratio : float
        Logarithm of the least likelihood ratio of two modes that counts [nats]: a mode
        that one wrench refutes can still return.

    """

    least_weight: float = 1e-9
    longest_mixing: float = 0.002
    least_log_ratio: float = -50.0


class ProcessNoiseFloor(NamedTuple):
    """
    Bounds of the process noise.

    Attributes
    ----------
    least_sine_square : float
        Least squared sine of the tilt that noise about the peg's and the hole's axis is divided
        by [-]: at the upright both axes are one, and the noise would be infinite.

    """

    least_sine_square: float = 1e-8


class SceneAtMeanBounds(NamedTuple):
    """
    Bounds of tilt and clearance within which the equations are linearised.

    Attributes
    ----------
    nearest_tilt : float
        The equations are taken no nearer to the tilt at which three contacts become two [rad]:
        the closed forms end there.
    steepest_tilt : float
        They are taken for no peg that lies [rad].
    most_log_clearance : float
        A clearance is estimated within a factor of e to this of the stated one [nats].
    least_clearance : float
        What a load leaves of the clearance at least [m]: below zero there is no geometry.

    """

    nearest_tilt: float = 1e-5
    steepest_tilt: float = 1.5
    most_log_clearance: float = 3.0
    least_clearance: float = 1e-7


class WrenchStep(NamedTuple):
    """
    How close wrenches follow each other.

    Attributes
    ----------
    least_time : float
        Two wrenches count as no closer [s]: correlation times are divided by the time between
        them, which stamps may leave at zero.

    """

    least_time: float = 1e-4


class ParticleDraws(NamedTuple):
    """
    What particles are drawn from.

    Attributes
    ----------
    wider : float
        Of the variance that tangents leave [-]: particles reach a little further, as the true
        posterior may.

    """

    wider: float = 1.5


class StillTurn(NamedTuple):
    """
    An angle that a method with fewer degrees of freedom takes for still.

    Attributes
    ----------
    stddev : float
        Of such an angle before each orientation [rad]: so wide that it is where that has it.

    """

    stddev: float = 1.0


POSE_FLOOR = PoseFloor()
PUSHING_REACTIONS = PushingReactions()
SLIP_FLOOR = SlipFloor()
MIXTURE_WEIGHTS = MixtureWeights()
PROCESS_NOISE_FLOOR = ProcessNoiseFloor()
SCENE_AT_MEAN_BOUNDS = SceneAtMeanBounds()
WRENCH_STEP = WrenchStep()
PARTICLE_DRAWS = ParticleDraws()
STILL_TURN = StillTurn()


class EstimatorNumbers(NamedTuple):
    """All of them, by subject."""

    pose_floor: PoseFloor = POSE_FLOOR
    pushing_reactions: PushingReactions = PUSHING_REACTIONS
    slip_floor: SlipFloor = SLIP_FLOOR
    mixture_weights: MixtureWeights = MIXTURE_WEIGHTS
    process_noise_floor: ProcessNoiseFloor = PROCESS_NOISE_FLOOR
    scene_at_mean_bounds: SceneAtMeanBounds = SCENE_AT_MEAN_BOUNDS
    wrench_step: WrenchStep = WRENCH_STEP
    particle_draws: ParticleDraws = PARTICLE_DRAWS
    still_turn: StillTurn = STILL_TURN
