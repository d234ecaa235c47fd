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
    Constants of the estimator; an ablation switches one of them.

    Those from `inertia` on are no constants: what another method leaves out or does in place of
    the default.

    Attributes
    ----------
    modes : int
        How many process-noise modes there are; the arrays have room for more.
    mode_stddev : ndarray, shape (MOST_MODES,)
        Stationary standard deviation of a held peg's accelerations [rad/s^2], for each
        process-noise mode: a robot at rest or in steady motion, one that turns round, a peg that
        jumps. The last but one is that of a start.
    mode_time : ndarray, shape (MOST_MODES,)
        Time in which accelerations fade [s], for each process-noise mode. An infinite time:
        accelerations are constant until the next wrench, which finds them anew within the standard
        deviation; with a wide one the wrench drives the motion.
    mode_rate : ndarray, shape (MOST_MODES,)
        How often a second the motion changes to a mode from one below it [1/s]; it goes back to
        each mode below as often as it comes to the second.
    around_axes : float
        Acceleration about any axis in space, as a share of the mode's standard deviation [-]: a
        small tilt turns easily.
    friction_hypotheses : int
        Friction hypotheses at the start [hypotheses], evenly spread; the standard deviation of
        each is half its distance to the next: neighbours meet.
    reach : float
        How far they reach [stated standard deviations].
    joined : float
        Two friction hypotheses become one where that loses less [nats]: less takes time, and
        brings reactions in windows 4 % nearer; from 0.02 on wrong hypotheses end up certain.
    direction_evidence_time : float
        The evidence of a wrench for a friction hypothesis counts once in this time [s] where the
        direction of friction is unknown; see `mixture`.
    direction_time : float
        Friction of unknown direction is one force for so long, no white noise [s].
    reaction_prior : float
        Prior standard deviation of a reaction, over the load, at each wrench [-]: a narrow one
        would pull reactions towards what they were.
    settling : float
        After a start only orientations are used for so long [s]: rates of any size leave the
        direction of friction open. No acceleration is taken to change a rate by more than
        1 rad/s within it.
    passes : int
        How often the equations are linearised with the first wrench [passes], far from which the
        state may be.
    free_walk : float
        In the air the speed of the robot walks by so much [m/s per root second].
    bias_time : float
        In the air the bias walks by its stated standard deviation in this time [s].
    touch_time : float
        A wrench corrects the bias only if nothing has touched the peg for so long after it [s]: a
        soft touch is detected that late.
    significance : float
        What is off by more is no chance [standard deviations]: a tilt whose mean moves by more
        than its variance accounts for, see `contact_filter`; tilt and reactions of a peg that two
        points carry.
    place_time : float
        A measured depth counts once in this time, longer than a peg slides in: the hole's own
        place is off by the same for a whole run [s].
    outlier : float
        So many times the variance that is expected [-]: a wrench beyond it is a spike and counts
        little, two in a row are none; a sample of the noise ratio counts as so much at most; a
        depth beyond it is none of two points.
    noise_count : float
        The variance of orientations, and of the wrench, is an average over so many [samples]: over
        fewer, chance would show as noise.
    noise_most : float
        That variance is so many times the stated one at most [-]: more is another unit.
    top_friction_walk : float
        On three contacts friction walks by so much in the top mode, if there is a mode below it
        [per root second]: by 0.18 in the time until the mode goes back, as far as friction may
        step. With half of it a step in twenty is not followed.
    least_inherited : float
        The modes below the top inherit from it only while its weight is at least this [-]. In
        steady motion it is less: the walk of friction stays out of them, and friction is learnt
        as one that stays. With ten times as much, two steps in twenty are not followed.
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
