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
        Standard deviation added to the position [m]: far below the resolution of any sensor in a
        cell.
    rotation_stddev : float
        Standard deviation added to the rotation vector [rad]: far below the resolution of any
        sensor in a cell.

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
        Largest number of passes [passes]: nearly identical reactions would need an unlimited
        number.
    least_step : float
        The search ends when a pass changes every reaction by less than this [standard deviations].

    """

    most_passes: int = 1000
    least_step: float = 1e-10


class SlipFloor(NamedTuple):
    """
    Below what size slips are not distinguished in the direction of friction.

    Attributes
    ----------
    least_variance : float
        Least variance of a slip velocity [m^2/s^2]: the code divides by it, and it may be zero.
    least_scale_square : float
        Least square of the velocity scale of the mean direction of friction [m^2/s^2]: a slip
        below it has no direction.

    """

    least_variance: float = 1e-24
    least_scale_square: float = 1e-16


class MixtureWeights(NamedTuple):
    """
    How light components become, and how finely the process-noise modes are mixed.

    Attributes
    ----------
    least_weight : float
        Least weight of a process-noise mode within its friction hypothesis, so that the mode can
        return [-]. A friction hypothesis with a smaller weight is dropped.
    longest_mixing : float
        Longest time for which mode transitions are computed in one step [s]: in a longer time more
        than all of the weight would change its mode.
    least_log_ratio : float
        Least logarithm of the likelihood ratio of two modes [nats]: a mode that one wrench refutes
        can still return.

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
        Least squared sine of the tilt by which the noise about the axes of peg and hole is divided
        [-]: for an upright peg both axes are the same, and the noise would be infinite.

    """

    least_sine_square: float = 1e-8


class SceneAtMeanBounds(NamedTuple):
    """
    Bounds of tilt and clearance within which the equations are linearised.

    Attributes
    ----------
    nearest_tilt : float
        Least distance of the tilt from gamma0 at which the equations of three contacts are
        evaluated [rad]: the closed forms end at gamma0.
    steepest_tilt : float
        Largest tilt at which the equations are evaluated [rad]: beyond it the peg is nearly
        horizontal.
    most_log_clearance : float
        An estimated clearance differs from the stated one by a factor of at most e to the power of
        this [nats].
    least_clearance : float
        Least clearance under a load that compresses the contacts [m]: below zero there is no
        geometry.

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
        Least time between two wrenches in the computation [s]: correlation times are divided by
        it, and the stamps may be equal.

    """

    least_time: float = 1e-4


class ParticleDraws(NamedTuple):
    """
    What particles are drawn from.

    Attributes
    ----------
    wider : float
        Factor of the variance of the linearised update with which particles are drawn [-]: the
        true posterior may be wider.

    """

    wider: float = 1.5


class StillTurn(NamedTuple):
    """
    An angle that a method with fewer degrees of freedom treats as constant.

    Attributes
    ----------
    stddev : float
        Standard deviation of such an angle before each orientation [rad]: so large that the
        orientation alone determines the angle.

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
