"""The estimator's state: typed records with named fields."""

from collections.abc import Collection, MutableSequence
from typing import Annotated, NamedTuple

import numpy as np

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.settings import MOST_MODES
from peg_on_hole_ros.typed_record import Floats, Matrix3, Record, Vector3, Vector6, new

# Places in the mean and covariance of a component. What a scene leaves open follows FRICTION, and
# the reactions end it: they are new with every wrench, so that nothing of them is carried over.
ANGLE, RATE, ACCELERATION, FRICTION, OPEN_BEGIN = 0, 3, 6, 9, 10
# What a scene may leave open, in the order of its values, with how many values each has.
OPENABLE_QUANTITIES = {
    "clearance": 1, "friction_k": 1, "bias": 6, "tilt": 2, "delay": 1, "compliance": 1,
}  # fmt: skip
# Values that there is room for, and as many components as friction hypotheses and process-noise
# modes can make. What is not used costs memory, and no time.
MOST_OPEN = sum(OPENABLE_QUANTITIES.values())
MOST_WIDTH = OPEN_BEGIN + MOST_OPEN + 3
MOST_HYPOTHESES = 7
_M, _W = MOST_HYPOTHESES * MOST_MODES, MOST_WIDTH
Values = Annotated[Floats, (_W,)]
Covariance = Annotated[Floats, (_W, _W)]
ComponentVector = Annotated[Floats, (_M,)]


class StatePlaces(Record):
    """
    Where the open quantities stand in the mean, each below zero where it is known.

    Attributes
    ----------
    clearance : int
        Logarithm of the clearance over the stated one.
    friction_k : int
        Friction coefficient at K, beyond that of the others.
    bias : int
        Of the sensor (6) [N], [N m].
    tilt : int
        Of the hole (2) [rad].
    delay : int
        Of orientations [s].
    compliance : int
        Of the contacts: by how much a load reduces the clearance [m/N].
    reactions : int
        The first of N_K, N_B1, N_B2 [N]: so many values stand before them.

    """

    clearance: int
    friction_k: int
    bias: int
    tilt: int
    delay: int
    compliance: int
    reactions: int


def places_of(open_quantities: Collection[str]) -> StatePlaces:
    """Return where each of OPENABLE_QUANTITIES stands in the mean, of which some are open."""
    places, n = new(StatePlaces), OPEN_BEGIN
    for name, width in OPENABLE_QUANTITIES.items():
        setattr(places, name, n if name in open_quantities else -1)
        n += width if name in open_quantities else 0
    places.reactions = n
    return places


class AirBatch(Record):
    """
    Wrenches of a peg that hangs free, see `bias_in_air`.

    Attributes
    ----------
    time : float
        From the wrench before the first to the last [s].
    wrenches : int
        How many.
    load : ndarray, shape (6,)
        Sum of the wrenches less the weight, peg axes [N], [N m].

    """

    time: float
    wrenches: int
    load: Vector6


class State(Record):
    """
    All that the next step depends on.

    n values are estimated, in m components. A component is one friction hypothesis with one
    process-noise mode: number hypothesis * modes + mode. The components come last, for most of
    the room is empty.

    Attributes
    ----------
    hypotheses, components, width : int
        How many friction hypotheses there are at a start, how many components m, and n + 3.
    weight : ndarray, shape (m,)
        Probability of each component.
    alive : ndarray, shape (hypotheses,)
        1 while a friction hypothesis is followed.
    gathered : int
        1 until the first wrench in contact: before it all friction hypotheses move alike, and the
        first one stands for all, with the mean and variance of them; see `split`.
    evidence_share : float
        Share of a sample's evidence that counts for the choice of a friction hypothesis.
    load : float
        Size of what the rim carries, at the last wrench [N].
    time_since_start : float
        [s]
    time_in_contact : float
        Since the first wrench in contact; below zero before [s].
    time_since_wrench : float
        Since the last wrench that was taken [s].
    time_since_orientation : float
        Since an orientation was used [s].
    time_since_jump : float
        Since the motion jumped, see `orientation_update.jump_to` [s].
    refused_innovation : ndarray, shape (3,)
        Innovation of the last orientation that was refused, whitened by its own noise.
    start_rate_variance : float
        Variance of each rate at the start [rad^2/s^2].
    misfits : int
        Wrenches in a row that were far from what the contacts carry; the first is a spike.
    friction_force2 : ndarray, shape (3,)
        Mean square of the friction at each contact [N^2].
    friction_floor : ndarray, shape (m,)
        Of each component the floor of its friction's variance, see `friction_walk`.
    contact_set : ContactSet
        Which contacts the last wrench was weighed with; UNKNOWN: it corrected nothing.
    air : sequence of 3 AirBatch
        Wrenches of a peg that hangs free: the batch that is filled, one that waits until no touch
        follows it, and the one that corrects the bias.
    mixture_mean : ndarray, shape (n + 3,)
        Mean over all components.
    mixture_covariance : ndarray, shape (n + 3, n + 3)
        About that mean, with what components differ by.
    nis_orientation, nis_wrench : float
        Normalised innovation squared of the last orientation (3 degrees of freedom) and of the
        last wrench (6).
    innovation : ndarray, shape (3,)
        Of the last orientation, whitened by the Cholesky factor of its covariance.
    innovation_before : ndarray, shape (3,)
        Of the one before.
    orientations : ndarray, shape (3, 3)
        The last three, rows gamma, psi, phi; NaN: none.
    noise_ratio : float
        Variance of orientations as it is found, over the stated one: the lesser of both below.
    innovation_noise_ratio, roughness_noise_ratio : float
        As innovations show it, and as orientations themselves do.
    wrenches_drawn : int
        Wrenches that particles were drawn for: each has numbers of its own, and a replay the same.
    x : ndarray, shape (m, n + 3)
        gamma, psi, phi [rad], rates [rad/s], accelerations [rad/s^2], friction, what else is
        open, N_K, N_B1, N_B2 [N].
    P : ndarray, shape (m, n + 3, n + 3)
        Covariances of x.

    """

    hypotheses: int
    components: int
    width: int
    weight: ComponentVector
    alive: Annotated[Floats, (MOST_HYPOTHESES,)]
    gathered: int
    evidence_share: float
    load: float
    time_since_start: float
    time_in_contact: float
    time_since_wrench: float
    time_since_orientation: float
    time_since_jump: float
    refused_innovation: Vector3
    start_rate_variance: float
    misfits: int
    friction_force2: Vector3
    friction_floor: ComponentVector
    contact_set: ContactSet
    air: Annotated[MutableSequence[AirBatch], (3,)]
    mixture_mean: Values
    mixture_covariance: Covariance
    nis_orientation: float
    nis_wrench: float
    innovation: Vector3
    innovation_before: Vector3
    orientations: Matrix3
    noise_ratio: float
    innovation_noise_ratio: float
    roughness_noise_ratio: float
    wrenches_drawn: int
    x: Annotated[Floats, (_M, _W)]
    P: Annotated[Floats, (_M, _W, _W)]


def begin_state(state: State, width: int, hypotheses: int, modes: int) -> None:
    """
    Give a state its sizes.

    Raises
    ------
    ValueError
        There is no room for so many friction hypotheses or process-noise modes.

    """
    if hypotheses > MOST_HYPOTHESES or modes > MOST_MODES:
        raise ValueError(
            f"{hypotheses} friction hypotheses with {modes} process-noise modes: at most "
            f"{MOST_HYPOTHESES} with {MOST_MODES}"
        )
    state.hypotheses, state.components, state.width = hypotheses, hypotheses * modes, width
    state.noise_ratio = state.innovation_noise_ratio = state.roughness_noise_ratio = 1.0
    state.time_since_jump = np.inf
    state.orientations[:] = np.nan


class Mixture(NamedTuple):
    """Views of a state's mixture as far as its sizes reach; see `State`."""

    x: Floats
    P: Floats
    weight: Floats
    alive: Floats
    mean: Floats
    covariance: Floats


def mixture_of(state: State) -> Mixture:
    """Return the mixture of a state."""
    m, w = int(state.components), int(state.width)
    return Mixture(
        state.x[:m, :w],
        state.P[:m, :w, :w],
        state.weight[:m],
        state.alive[: int(state.hypotheses)],
        state.mixture_mean[:w],
        state.mixture_covariance[:w, :w],
    )
