"""Tuned numbers that may differ from filter to filter, each with its reason; one record."""

from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.typed_record import Floats, Record, new

# Process-noise modes that there is room for.
MOST_MODES = 3
# Constants with a value for each process-noise mode, as they are shipped.
_OF_MODES: dict[str, ArrayLike] = {
    "mode_stddev": (3.0, 30.0, 500.0),
    "mode_time": (0.05, 0.05, 0.02),
    "mode_rate": (0.0, 30.0, 6.0),
}


class Settings(Record):
    """
    Constants of the estimator; an ablation changes one of them.

    The fields from `inertia` on are not constants: they state what another method leaves out or
    replaces.

    Attributes
    ----------
    modes : int
        How many process-noise modes there are; the arrays have room for more.
    mode_stddev : ndarray, shape (MOST_MODES,)
        Stationary standard deviation of the accelerations of a held peg, for each process-noise
        mode [rad/s^2]: a robot at rest or in steady motion, a reversal, a jump of the peg. A start
        uses the last but one.
    mode_time : ndarray, shape (MOST_MODES,)
        Time constant with which accelerations decay, for each process-noise mode [s]. If it is
        infinite, accelerations are constant until the next wrench, which estimates them again
        within the standard deviation; with a wide standard deviation the wrench drives the motion.
    mode_rate : ndarray, shape (MOST_MODES,)
        Rate of transitions to a mode from each mode below it [1/s]. Transitions to a lower mode
        have the rate of the second mode.
    around_axes : float
        Acceleration about any axis in space, as a share of the standard deviation of the mode [-]:
        a peg with a small tilt can easily change its azimuth.
    friction_hypotheses : int
        Number of friction hypotheses at the start, evenly spaced [hypotheses]. The standard
        deviation of each is half of its distance to the next one, so that neighbours overlap.
    reach : float
        Distance of the outermost friction hypotheses from the stated friction [stated standard
        deviations].
    joined : float
        Two friction hypotheses are merged if this loses less information [nats]. A smaller value
        costs time and makes the error of reactions in windows 4 % smaller; from 0.02 on, wrong
        hypotheses end with a probability near 1.
    direction_evidence_time : float
        Time in which the evidence of the wrenches for a friction hypothesis counts once, if the
        direction of friction is unknown [s]; see `mixture`.
    direction_time : float
        Correlation time of a friction force of unknown direction [s]: it is one constant force for
        this long, not white noise.
    reaction_prior : float
        Prior standard deviation of a reaction, over the load, at each wrench [-]: a narrow prior
        would pull reactions towards their last values.
    settling : float
        Time after a start in which only orientations are used [s]: while rates may have any size,
        the direction of friction is unknown. Within this time an acceleration changes a rate by 1
        rad/s at most.
    passes : int
        How often the equations are linearised at the first wrench of a contact, because the state
        may be far from it [passes].
    free_walk : float
        Random walk of the speed of the robot in the air [m/s per root second].
    bias_time : float
        Time in which the random walk of the bias, in the air, reaches its stated standard
        deviation [s].
    touch_time : float
        A wrench corrects the bias only if the peg touches nothing for this time after it [s]: a
        soft touch is detected so late.
    significance : float
        A larger error is not chance [standard deviations]: a tilt whose mean moves by more than
        its variance accounts for, see `contact_filter`; tilt and reactions of a peg on two points.
    place_time : float
        Time in which a measured depth counts once, longer than a peg needs to slide in [s]: the
        error of the place of the hole is the same in a whole run.
    outlier : float
        Ratio of an error to its expected variance from which on it is an outlier [-]: one wrench
        above it is a spike and gets a small weight, two in a row are not; a sample of the noise
        ratio is limited to it; a depth above it does not belong to two points.
    noise_count : float
        Number of samples over which the variance of orientations, and of the wrench, is averaged
        [samples]: with fewer, chance would look like noise.
    noise_most : float
        Largest ratio of that variance to the stated one [-]: a larger one is another unit.
    top_friction_walk : float
        Random walk of friction on three contacts in the top mode, if there is a mode below it [per
        root second]: 0.18 in the time until the mode goes back, which is how far friction may
        step. With half of it, one step in twenty is not followed.
    least_inherited : float
        Smallest weight of the top mode at which the modes below it are mixed with it [-]. In
        steady motion its weight is smaller, so that the random walk of friction stays out of them
        and friction is estimated as a constant. With ten times this value, two steps in twenty are
        not followed.
    inertia : float
        0: accelerations are left out of the equations, as in a quasi-static balance.
    direction_share : float
        0: friction points against the mean slip, however uncertain that is.
    products : float
        0: products of the errors of friction and reactions are no noise, as where all Jacobians
        are evaluated at one state.
    top_waits : float
        0: the top mode is open while friction hypotheses are being chosen, and explains anything.
    wrench_moves : float
        0: a wrench corrects the reactions alone, as in a balance of forces; motion, friction and
        what else is open are considered, and come from orientations or as stated.
    small_tilt : float
        1: lengths on the rim are those of a small tilt, to leading order, see `small_forms`.
    psi_moves, phi_moves : float
        0: this angle has neither rate nor acceleration, and is where the last orientation had it.
    sigma_points : float
        1: orientations and, after the first, wrenches on three contacts correct by sigma points,
        in place of tangents.
    particles : int
        How many particles a wrench on three contacts is weighed at, after the first; 0: none.

    """

    modes: int
    mode_stddev: Annotated[Floats, (MOST_MODES,)]
    mode_time: Annotated[Floats, (MOST_MODES,)]
    mode_rate: Annotated[Floats, (MOST_MODES,)]
    around_axes: float = 0.3
    friction_hypotheses: int = 7
    reach: float = 2.5
    joined: float = 0.01
    direction_evidence_time: float = 0.1
    direction_time: float = 0.01
    reaction_prior: float = 3.0
    settling: float = 0.020
    passes: int = 4
    free_walk: float = 0.283
    bias_time: float = 120.0
    touch_time: float = 0.05
    significance: float = 3.0
    place_time: float = 5.0
    outlier: float = 10.0
    noise_count: float = 100.0
    noise_most: float = 400.0
    top_friction_walk: float = 1.0
    least_inherited: float = 0.01
    inertia: float = 1.0
    direction_share: float = 1.0
    products: float = 1.0
    top_waits: float = 1.0
    wrench_moves: float = 1.0
    small_tilt: float = 0.0
    psi_moves: float = 1.0
    phi_moves: float = 1.0
    sigma_points: float = 0.0
    particles: int = 0


def default_settings(**changed: ArrayLike) -> Settings:
    """
    Return the constants as they are shipped, some of them changed by name.

    Raises
    ------
    ValueError
        A name is no constant, or there is no room for so many process-noise modes.

    """
    settings, given = new(Settings), dict(changed)
    of_modes = {name: np.array(given.pop(name, _OF_MODES[name]), float) for name in _OF_MODES}
    settings.modes = len(of_modes["mode_stddev"])
    if settings.modes > MOST_MODES:
        raise ValueError(f"{settings.modes} process-noise modes: at most {MOST_MODES}")
    for name, values in of_modes.items():
        getattr(settings, name)[: settings.modes] = values[: settings.modes]
    for name in Settings.__annotations__:
        if hasattr(Settings, name):
            setattr(settings, name, given.pop(name, getattr(Settings, name)))
    if given:
        raise ValueError(f"no constants of the estimator: {', '.join(given)}")
    return settings


class Gates(Record):
    """
    When an orientation is refused, and how a start begins; see `FilterOptions`.

    Attributes
    ----------
    gate_threshold : float
        Normalised innovation squared above which an orientation is refused.
    gate_reset_count : float
        Refused orientations in a row after which the filter restarts.
    initial_rate_stddev : float
        Standard deviation of each rate at a start [rad/s].

    """

    gate_threshold: float
    gate_reset_count: float
    initial_rate_stddev: float
