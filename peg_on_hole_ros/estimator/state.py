"""The estimator's state: one typed record with named fields, all views of one array."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.kernel import workspace

# Places in the mean and covariance of a component. What a scene leaves open follows FRICTION, and
# the reactions end it: they are new with every wrench, so that nothing of them is carried over.
ANGLE, RATE, ACCELERATION, FRICTION, OPEN = 0, 3, 6, 9, 10
# What a scene may leave open, in this order; each has a place only where it is stated.
QUANTITIES = (
    "clearance",
    "friction_k",
    "bias",
    "tilt",
    "delay",
    "compliance",
)
CLEARANCE, FRICTION_K, BIAS, TILT, DELAY, COMPLIANCE = range(len(QUANTITIES))
WIDTHS = (1, 1, 6, 2, 1, 1)


class State(NamedTuple):
    """
    All that the next step depends on; n values are estimated, in m components.

    A component is one friction with one level of acceleration: number friction * levels + level.

    Attributes
    ----------
    x : ndarray, shape (m, n + 3)
        gamma, psi, phi [rad], rates [rad/s], accelerations [rad/s^2], friction, what else is
        open, N_K, N_B1, N_B2 [N].
    P : ndarray, shape (m, n + 3, n + 3)
        Covariances of x.
    weight : ndarray, shape (m,)
        Probability of each component.
    alive : ndarray, shape (frictions,)
        1 while a friction is followed.
    told : ndarray, shape (1,)
        Share of a sample's evidence that counts for the choice of a friction.
    load : ndarray, shape (1,)
        Size of what the rim carries, followed [N].
    since : ndarray, shape (2,)
        Time since the start, and since the first wrench in contact, below zero before [s].
    step : ndarray, shape (1,)
        Time since the last wrench that was taken [s].
    start_rates2 : ndarray, shape (1,)
        Variance of each rate at the start [rad^2/s^2].
    spiked : ndarray, shape (1,)
        Wrenches in a row that were far from what the contacts carry; the first is a spike.
    friction_force2 : ndarray, shape (3,)
        Mean square of the friction at each contact [N^2].
    contacts : ndarray, shape (1,)
        How many contacts the last wrench was weighed with: 3, 2 (K and B in the hole), or 0.
    mean : ndarray, shape (n + 3,)
        Mean over all components.
    covariance : ndarray, shape (n + 3, n + 3)
        Of the mean, with what components differ by.
    nis : ndarray, shape (2,)
        Normalised innovation squared of the last orientation (3) and of the last wrench (6).
    innovation : ndarray, shape (3,)
        Of the last orientation, over the lower root of its covariance.
    innovation_before : ndarray, shape (3,)
        Of the one before.
    orientations : ndarray, shape (3, 3)
        The last three, rows gamma, psi, phi; NaN: none.
    noise : ndarray, shape (3,)
        Variance of orientations as it is found, over the stated one: the lesser of what
        innovations and what orientations say, and both.

    """

    x: np.ndarray
    P: np.ndarray
    weight: np.ndarray
    alive: np.ndarray
    told: np.ndarray
    load: np.ndarray
    since: np.ndarray
    step: np.ndarray
    start_rates2: np.ndarray
    spiked: np.ndarray
    friction_force2: np.ndarray
    contacts: np.ndarray
    mean: np.ndarray
    covariance: np.ndarray
    nis: np.ndarray
    innovation: np.ndarray
    innovation_before: np.ndarray
    orientations: np.ndarray
    noise: np.ndarray


class Scratch(NamedTuple):
    """
    Memory that a step fills before it reads it, so that nothing is allocated.

    Attributes
    ----------
    x, P : ndarray
        As in the state, after mixing.
    log_likelihood, doubt : ndarray, shape (m,)
        Of the last measurement; how far the direction of friction is unknown.
    residual : ndarray, shape (6,)
    E : ndarray, shape (6, n + 3)
        Slopes of the six equations.
    R : ndarray, shape (6, 6)
        Their noise.
    unknown : ndarray, shape (6, 6)
        The part of it that is friction of unknown direction.
    root : ndarray, shape (6, 6)
    gain : ndarray, shape (n + 3, 6)
    white, scales, left : ndarray
    columns : ndarray, shape (6, 11)
        Slopes of the wrench, see `contact.applied_forces`.
    share : ndarray, shape (levels, levels)
    work : ndarray
        Of the mechanics.
    step : ndarray, shape (n + 3,)
        What an update adds to the mean.
    evidence : ndarray, shape (frictions,)
        Log weights of the frictions.
    evidence_of_wrench : ndarray, shape (1,)
        Log likelihood of a component's last wrench.
    known : ndarray, shape (6, 6)
        The noise without friction of unknown direction.
    before, P_before : ndarray
        A component before the equations are straightened again.

    """

    x: np.ndarray
    P: np.ndarray
    log_likelihood: np.ndarray
    doubt: np.ndarray
    residual: np.ndarray
    E: np.ndarray
    R: np.ndarray
    unknown: np.ndarray
    root: np.ndarray
    gain: np.ndarray
    white: np.ndarray
    scales: np.ndarray
    left: np.ndarray
    columns: np.ndarray
    share: np.ndarray
    work: np.ndarray
    step: np.ndarray
    evidence: np.ndarray
    evidence_of_wrench: np.ndarray
    known: np.ndarray
    before: np.ndarray
    P_before: np.ndarray


def places(open_quantities: tuple[str, ...]) -> tuple[np.ndarray, int]:
    """
    Return where each of QUANTITIES stands in the mean, -1 for one that is known, and n.

    Parameters
    ----------
    open_quantities : tuple of str
        Of QUANTITIES.

    """
    at, n = np.full(len(QUANTITIES), -1, np.int64), OPEN
    for k, (name, width) in enumerate(zip(QUANTITIES, WIDTHS)):
        if name in open_quantities:
            at[k] = n
            n += width
    return at, n


def new_state(n: int, frictions: int, levels: int) -> tuple[np.ndarray, State]:
    """Return the array that holds a state, and the state as views of it."""
    m, w = frictions * levels, n + 3
    shapes = {
        "x": (m, w),
        "P": (m, w, w),
        "weight": (m,),
        "alive": (frictions,),
        "told": (1,),
        "load": (1,),
        "since": (2,),
        "step": (1,),
        "start_rates2": (1,),
        "spiked": (1,),
        "friction_force2": (3,),
        "contacts": (1,),
        "mean": (w,),
        "covariance": (w, w),
        "nis": (2,),
        "innovation": (3,),
        "innovation_before": (3,),
        "orientations": (3, 3),
        "noise": (3,),
    }
    sizes = [int(np.prod(shape)) for shape in shapes.values()]
    memory, ends = np.zeros(sum(sizes)), np.cumsum(sizes)
    parts = zip(shapes, ends - sizes, ends)
    views = {name: memory[begin:end].reshape(shapes[name]) for name, begin, end in parts}
    views["noise"][:] = 1.0
    views["orientations"][:] = np.nan
    return memory, State(**views)


def new_scratch(n: int, frictions: int, levels: int) -> Scratch:
    """Return scratch memory for a state of the same sizes."""
    m, w = frictions * levels, n + 3
    return Scratch(
        np.zeros((m, w)),
        np.zeros((m, w, w)),
        np.zeros(m),
        np.zeros(m),
        np.zeros(6),
        np.zeros((6, w)),
        np.zeros((6, 6)),
        np.zeros((6, 6)),
        np.zeros((6, 6)),
        np.zeros((w, 6)),
        np.zeros(6),
        np.zeros(3),
        np.zeros(3),
        np.zeros((6, 11)),
        np.zeros((levels, levels)),
        workspace(),
        np.zeros(w),
        np.zeros(frictions),
        np.zeros(1),
        np.zeros((6, 6)),
        np.zeros(w),
        np.zeros((w, w)),
    )
