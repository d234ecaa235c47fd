"""Every tuned constant of the estimator, each with its reason; compiled code takes them as one."""

from typing import Any, NamedTuple

import numpy as np


class Settings(NamedTuple):
    """
    Constants of the estimator; an ablation switches one of them.

    Attributes
    ----------
    level, time : ndarray, shape (levels,)
        Stationary deviation of a held peg's accelerations [rad/s^2], and the time in which they
        fade [s]. A robot at rest or in steady motion, one that turns round, a peg that jumps.
        An infinite time: accelerations are held until the next wrench, which finds them anew
        within the level; with a wide level the wrench drives the motion.
    up : ndarray, shape (levels,)
        How often a second the motion changes to a level from one below it [1/s].
    down : float
        How often a second it changes back, to each level below [1/s].
    around_axes : float
        Acceleration about any axis in space, as a share of the level: a small tilt turns easily.
    top_waits : float
        1: the top level stays shut while frictions are being chosen, since it explains anything.
    frictions : int
        Frictions that are followed at the start, evenly spread over the stated uncertainty.
    reach, width : float
        How far they reach [stated deviations], and how wide each is [distances between them].
    dropped, merged : float
        A friction goes below this weight, and joins another within so many deviations.
    doubt : float
        How much less a sample tells of friction where its direction is unknown; see `mixture`.
    friction_doubt : float
        Friction is learnt no better than to this share of what a slip elsewhere would make of it.
    direction_time : float
        Friction of unknown direction is one force for so long, no white noise [s].
    direction_share : float
        Share of the rates' variance that makes the direction of slip uncertain.
    reaction_prior : float
        What a reaction may be, over the load, before the wrench is looked at. Wide: it only
        keeps the singular set finite.
    load_time : float
        The load is followed within this time [s].
    wrench_gate : float
        A wrench with a mean NIS beyond it is a spike and counts little; two in a row are none.
    settling : float
        After a start only orientations are used for so long [s].
    passes : int
        How often the equations are straightened anew with the first wrench.
    acceleration_start : float
        Deviation of accelerations at the start [rad/s^2].
    free_acceleration, free_time : float
        How a holder moves a peg in the air [m/s^2], and for how long one way [s].
    zero_time : float
        In the air a zero wanders by its stated deviation in this time [s].
    noise_count, noise_step, noise_margin, noise_most : float
        The variance of orientations is followed over so many; one counts as so much at most; so
        much more than stated is none; and it is so many times the stated one at most.
    inertia : float
        0: accelerations are left out of the equations, as in a quasi-static balance.

    """

    level: np.ndarray
    time: np.ndarray
    up: np.ndarray
    down: float = 50.0
    around_axes: float = 0.3
    top_waits: float = 1.0
    frictions: int = 7
    reach: float = 2.5
    width: float = 0.5
    dropped: float = 1e-4
    merged: float = 0.5
    doubt: float = 20.0
    friction_doubt: float = 0.7
    direction_time: float = 0.01
    direction_share: float = 1.0
    reaction_prior: float = 3.0
    load_time: float = 0.01
    wrench_gate: float = 60.0
    settling: float = 0.020
    passes: int = 4
    acceleration_start: float = 20.0
    free_acceleration: float = 2.0
    free_time: float = 0.02
    zero_time: float = 120.0
    noise_count: float = 100.0
    noise_step: float = 10.0
    noise_margin: float = 0.3
    noise_most: float = 400.0
    inertia: float = 1.0


def default_settings(**changed: Any) -> Settings:
    """Return the constants as they are shipped, some of them changed by name."""
    given = {
        "level": (3.0, 30.0, 500.0),
        "time": (0.05, 0.05, 0.02),
        "up": (0.0, 50.0, 10.0),
    } | changed
    for name in ("level", "time", "up"):
        given[name] = np.array(given[name], float)
    return Settings(**given)
