"""The estimator's state and its scratch memory: typed records with named fields."""

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
    All that the next step depends on, as views of a record of STATE.

    n values are estimated, in m components.

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
    oriented : ndarray, shape (1,)
        Time since an orientation was used [s].
    departed : ndarray, shape (3,)
        How far off the last orientation was that was refused, over its own noise.
    jumped : ndarray, shape (1,)
        Time since the motion jumped, see `step.jump_to` [s].
    start_rates2 : ndarray, shape (1,)
        Variance of each rate at the start [rad^2/s^2].
    spiked : ndarray, shape (1,)
        Wrenches in a row that were far from what the contacts carry; the first is a spike.
    friction_force2 : ndarray, shape (3,)
        Mean square of the friction at each contact [N^2].
    contacts : ndarray, shape (1,)
        How many contacts the last wrench was weighed with: 3, 2 (K and B in the hole), or 0.
    air : ndarray, shape (3, 14)
        Wrenches of a peg that hangs free, see `free`.
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
    oriented: np.ndarray
    departed: np.ndarray
    jumped: np.ndarray
    start_rates2: np.ndarray
    spiked: np.ndarray
    friction_force2: np.ndarray
    contacts: np.ndarray
    air: np.ndarray
    mean: np.ndarray
    covariance: np.ndarray
    nis: np.ndarray
    innovation: np.ndarray
    innovation_before: np.ndarray
    orientations: np.ndarray
    noise: np.ndarray


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


# Places that there are room for: all that a scene can leave open with the reactions, and as many
# components as frictions and levels can make. What is not used costs memory, and no time.
MOST_WIDTH = OPEN + sum(WIDTHS) + 3
MOST_FRICTIONS, MOST_LEVELS = 7, 3
_M, _W = MOST_FRICTIONS * MOST_LEVELS, MOST_WIDTH

# The state as compiled code has it; see `State`. Components come last, for most are empty.
STATE = np.dtype(
    [
        ("frictions", np.int64),
        ("components", np.int64),
        ("width", np.int64),
        ("weight", float, (_M,)),
        ("alive", float, (MOST_FRICTIONS,)),
        ("told", float, (1,)),
        ("load", float, (1,)),
        ("since", float, (2,)),
        ("step", float, (1,)),
        ("oriented", float, (1,)),
        ("departed", float, (3,)),
        ("jumped", float, (1,)),
        ("start_rates2", float, (1,)),
        ("spiked", float, (1,)),
        ("friction_force2", float, (3,)),
        ("contacts", float, (1,)),
        ("air", float, (3, 14)),
        ("mean", float, (_W,)),
        ("covariance", float, (_W, _W)),
        ("nis", float, (2,)),
        ("innovation", float, (3,)),
        ("innovation_before", float, (3,)),
        ("orientations", float, (3, 3)),
        ("noise", float, (3,)),
        ("x", float, (_M, _W)),
        ("P", float, (_M, _W, _W)),
    ]
)
SCRATCH = np.dtype(
    [
        ("x", float, (_M, _W)),
        ("P", float, (_M, _W, _W)),
        ("log_likelihood", float, (_M,)),
        ("doubt", float, (_M,)),
        ("residual", float, (6,)),
        ("E", float, (6, _W)),
        ("R", float, (6, 6)),
        ("unknown", float, (6, 6)),
        ("by_friction", float, (6, 3)),
        ("product", float, (_M, 3, 3)),
        ("root", float, (6, 6)),
        ("gain", float, (6, _W)),
        ("white", float, (6,)),
        ("scales", float, (3,)),
        ("left", float, (3,)),
        ("columns", float, (6, 11)),
        ("share", float, (MOST_LEVELS, MOST_LEVELS)),
        ("work", float, workspace().shape),
        ("step", float, (_W,)),
        ("evidence", float, (MOST_FRICTIONS,)),
        ("evidence_of_wrench", float, (1,)),
        ("known", float, (6, 6)),
        ("before", float, (_W,)),
        ("P_before", float, (_W, _W)),
    ]
)


def begin_state(state: np.void, n: int, frictions: int, levels: int) -> None:
    """
    Give a record of STATE its sizes.

    Raises
    ------
    ValueError
        There is no room for so many frictions or levels.

    """
    if frictions > MOST_FRICTIONS or levels > MOST_LEVELS:
        raise ValueError(
            f"{frictions} frictions with {levels} levels: at most {MOST_FRICTIONS} with "
            f"{MOST_LEVELS}"
        )
    m, w = frictions * levels, n + 3
    state["frictions"], state["components"], state["width"] = frictions, m, w
    state["noise"], state["jumped"] = 1.0, np.inf
    state["orientations"] = np.nan


def named(state: np.void) -> State:
    """Return a record of STATE by name, as far as its sizes reach."""
    m, w, frictions = state["components"], state["width"], state["frictions"]
    reach = {"x": (m, w), "P": (m, w, w), "weight": (m,), "alive": (frictions,)}
    reach |= {"mean": (w,), "covariance": (w, w)}
    return State(*(state[name][tuple(map(slice, reach.get(name, ())))] for name in State._fields))
