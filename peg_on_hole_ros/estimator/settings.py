"""Every tuned constant of the estimator, each with its reason; compiled code takes them as one."""

from typing import Any, NamedTuple

import numpy as np


class Settings(NamedTuple):
    """
    Constants of the estimator; an ablation switches one of them.

    The last four are no constants: what a reduced estimator leaves out.

    Attributes
    ----------
    level, time : ndarray, shape (levels,)
        Stationary deviation of a held peg's accelerations [rad/s^2], and the time in which they
        fade [s]. A robot at rest or in steady motion, one that turns round, a peg that jumps.
        The last but one is that of a start.
        An infinite time: accelerations are held until the next wrench, which finds them anew
        within the level; with a wide level the wrench drives the motion.
    up : ndarray, shape (levels,)
        How often a second the motion changes to a level from one below it [1/s]; it goes back to
        each level below as often as it comes to the second.
    around_axes : float
        Acceleration about any axis in space, as a share of the level: a small tilt turns easily.
    frictions : int
        Frictions that are followed at the start, evenly spread; each is half as wide as it is
        far from the next: neighbours meet.
    reach : float
        How far they reach [stated deviations].
    joined : float
        Two frictions become one where that loses less [nats]: less takes time, and brings
        reactions in windows 4 % nearer; from 0.02 on wrong frictions are surely wrong.
    doubt : float
        What a friction of unknown direction tells, it tells once in so long [s]; see `mixture`.
    direction_time : float
        Friction of unknown direction is one force for so long, no white noise [s].
    reaction_prior : float
        What a reaction may be, over the load, before the wrench is looked at.
    settling : float
        After a start only orientations are used for so long [s]: rates of any size leave the
        direction of friction open. No acceleration is taken to change a rate by more than
        1 rad/s within it.
    passes : int
        How often the equations are straightened anew with the first wrench, far from which the
        state may be.
    free_walk : float
        In the air a holder's speed walks by so much [m/s per root second].
    zero_time : float
        In the air a zero wanders by its stated deviation in this time [s].
    touch_time : float
        Nothing may have touched the peg for so long after a wrench that tells of the zero [s]: a
        soft touch is seen that late.
    sure : float
        What is off by so many deviations is surely no chance: a tilt that moves by more of what
        was learnt, see `held`; tilt and reactions of a peg that two points surely carry.
    place_time : float
        A measured depth counts once in this time, longer than a peg slides in: the hole's own
        place is off by the same for a whole run [s].
    outlier : float
        So many times the variance that is expected: a wrench beyond it is a spike and counts
        little, two in a row are none; what tells of more noise counts as so much at most; a
        depth beyond it is none of two points.
    noise_count, noise_most : float
        The variance of orientations, and of the wrench, is followed over so many, and is so many
        times the stated one at most, for more is another unit.
    inertia : float
        0: accelerations are left out of the equations, as in a quasi-static balance.
    direction_share : float
        0: friction points against the mean slip, however uncertain that is.
    products : float
        0: products of the errors of friction and reactions are no noise, as where all slopes are
        taken at one place.
    top_waits : float
        0: the top level is open while frictions are being chosen, and explains anything.

    """

    level: np.ndarray
    time: np.ndarray
    up: np.ndarray
    around_axes: float = 0.3
    frictions: int = 7
    reach: float = 2.5
    joined: float = 0.01
    doubt: float = 0.1
    direction_time: float = 0.01
    reaction_prior: float = 3.0
    settling: float = 0.020
    passes: int = 4
    free_walk: float = 0.283
    zero_time: float = 120.0
    touch_time: float = 0.05
    sure: float = 3.0
    place_time: float = 5.0
    outlier: float = 10.0
    noise_count: float = 100.0
    noise_most: float = 400.0
    inertia: float = 1.0
    direction_share: float = 1.0
    products: float = 1.0
    top_waits: float = 1.0


def default_settings(**changed: Any) -> Settings:
    """Return the constants as they are shipped, some of them changed by name."""
    given = {
        "level": (3.0, 30.0, 500.0),
        "time": (0.05, 0.05, 0.02),
        "up": (0.0, 30.0, 6.0),
    } | changed
    for name in ("level", "time", "up"):
        given[name] = np.array(given[name], float)
    return Settings(**given)
