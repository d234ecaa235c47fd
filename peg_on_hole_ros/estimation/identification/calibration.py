"""
Parameters of a cell from a recording, by the greatest likelihood of the filter's innovations.

Two likelihoods, as what moves the peg and what scatters the sensors are told by different things:
friction, biases, tilt, delay and clearance by the mean of the innovations, noise levels by their
spread. What the recording does not tell, or does not tell from the start, stays as it was.
"""

from collections.abc import Callable
from math import log
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.estimation.identification.inverse_dynamics import fit
from peg_on_hole_ros.estimation.identification.likelihood import (
    CLEARANCE,
    DELAY,
    FRICTION,
    NAMES,
    NOISE,
    QUANTITIES,
    SETTLE,
    START,
    configured,
    coordinates,
    measures,
    natural,
)
from peg_on_hole_ros.estimation.identification.noise_levels import noise_levels
from peg_on_hole_ros.estimation.identification.recording import (
    Recording,
    load,
    motion,
    shortfall,
    steady,
)
from peg_on_hole_ros.estimation.identification.runs import Runs
from peg_on_hole_ros.estimation.identification.selection import NORMAL_95, Selected, search
from peg_on_hole_ros.options import Configuration

# Joint states beyond this are left out, evenly: they cost time and add little.
MOST_JOINTS = 4000
# Ten blocks of them, by which the intervals are widened: see `scoring.BLOCK`.
FEWEST_INNOVATIONS = 250
# With a clearance that is stated too small, tilts nearer than so many gamma0 as stated may be
# those of a peg in the hole, of which no parameters of three contacts make anything. gamma0 goes
# with the root of the clearance: up to twice the stated one.
FARTHER_TILT = 1.5
# A start whose innovations squared are less than a third too large is not far off: where nothing
# better is found beside it, noise is too large for the filter's tangents, and it stays.
EXPLAINED = 4.0


class Estimate(NamedTuple):
    """
    One parameter.

    Attributes
    ----------
    name, unit : str
    start, best, low, high, value : float
        Of the start; most likely, with its 95 % interval; as the configuration has it now.
    seen : bool
        Whether the interval is narrow enough to tell a cell anything.
    partner : str
        Of a parameter that is not seen, another that looks nearly the same; empty: none.

    """

    name: str
    unit: str
    start: float
    best: float
    low: float
    high: float
    value: float
    seen: bool
    partner: str

    @property
    def changed(self) -> bool:
        """Whether the value is another than at the start."""
        return self.value != self.start


class Calibration(NamedTuple):
    """
    What a recording tells.

    Attributes
    ----------
    configuration : Configuration
        The start with all that was found put in.
    estimates : tuple of Estimate
        In the order of QUANTITIES.
    nis_before, nis : float
        Mean normalised innovation squared at the start and at the end; 3 if all is right.
    lost_before, lost : float
        Share of the innovations where the parameters leave no motion; these count 64 in the mean.
    innovations : int
    seconds : float
        Of steady sliding that was used [s].
    least_tilt : float
        The nearest that the tilt came in what was used, over gamma0.
    turn : float
        How far the peg turned about its own axis [rad].
    both_ways : bool
        Whether it turned both ways.

    """

    configuration: Configuration
    estimates: tuple[Estimate, ...]
    nis_before: float
    nis: float
    lost_before: float
    lost: float
    innovations: int
    seconds: float
    least_tilt: float
    turn: float
    both_ways: bool


def calibrate(
    record: Recording,
    start: Configuration,
    progress: Callable[[float], None] = lambda share: None,
) -> Calibration:
    """
    Return what a recording tells of the parameters.

    Parameters
    ----------
    record : Recording
        Read under the configuration of the start.
    start : Configuration
        Everything that is not calibrated, and what the result is held against.
    progress : callable
        Told the share done, 0 to 1.

    Raises
    ------
    BagError
        The recording shows no steady sliding on three contacts, or none that the model fits.

    """
    parts = _thinned(steady(record, start))
    count = _count(parts)
    if count < FEWEST_INNOVATIONS:
        raise BagError(
            f"only {count} joint states while all three contacts slide steadily, at least "
            f"{FEWEST_INNOVATIONS} are needed: {shortfall(record, start)}"
        )
    moved = motion(record)
    runs, found = _searched(record, moved, parts, start, progress)
    if found is None:
        farther = _thinned(steady(record, start, FARTHER_TILT))
        if farther != parts and _count(farther) >= FEWEST_INNOVATIONS:
            left = runs.left
            again = _searched(
                record, moved, farther, start, lambda share: progress(1.0 - left * (1.0 - share))
            )
            if again[1] is not None:
                parts, (runs, found) = farther, again
    x0 = coordinates(start)
    if found is None:
        raise BagError(_unexplained(runs.once(x0), start.joints.delay))
    rows = _rows(parts)
    before, after = (runs.once(at) for at in (x0, found.x))
    progress(1.0)
    turns = moved.rates[rows, 2]
    return Calibration(
        configured(start, found.x),
        _estimates(x0, found, runs.scale),
        *(float(one.nis.mean()) for one in (before, after)),
        before.lost,
        after.lost,
        _count(parts),
        float(sum(record.joint_t[part.stop - 1] - record.joint_t[part.start] for part in parts)),
        float(moved.q[rows, 0].min() / start.scene.gamma0),
        float(np.ptp(moved.q[rows, 2])),
        bool(turns.min() < -0.1 < 0.1 < turns.max()),
    )


def _count(parts):
    """Return how many innovations count."""
    return sum(part.stop - part.start - START - SETTLE for part in parts)


def _rows(parts):
    return np.concatenate([np.arange(part.start, part.stop) for part in parts])


def _searched(record, moved, parts, start, progress):
    """Return the runs over some parts, and what they make of the start; None where nothing."""
    rows, x0 = _rows(parts), coordinates(start)
    limits = _limits(start, x0, moved.q[rows, 0].min())
    force = float(np.median(load(record, moved, start)[rows]))
    scale = measures(start.scene.hole_diameter, force)
    runs = Runs(record, parts, start, limits, scale, progress)
    found = search(runs, x0) or _as_started(runs, x0)
    if found is None:
        far = _from_far(runs, record, parts, start, limits, scale)
        found = search(runs, x0, far) if far is not None else None
    return runs, found


def _as_started(runs, x0):
    """Return the start itself, if only its covariances may be somewhat off; else None."""
    at = runs.tangent(x0)
    if at is None or at.found.nis.mean() > EXPLAINED:
        return None
    return Selected(x0, x0 + at.step, at.covariance, at.stddev)


def _from_far(runs, record, parts, start, limits, scale):
    """Return the most likely coordinates, however far from the start; None where none are."""
    guess, x0 = fit(record, parts, start, limits, scale), coordinates(start)
    for i, level in zip(range(NOISE.start, NOISE.stop), noise_levels(record)):
        if level:
            guess[i] = log(level) + (x0[i] if NAMES[i] == "position_stddev" else 0.0)
    return runs.climb(np.clip(guess, *limits), np.ones(len(x0), bool))


def _unexplained(before, delay):
    """Return what a recording shows that no parameters explain; the delay [s] at the start."""
    return (
        f"at the start {100 * before.lost:.0f} % of the joint states are without a motion under "
        f"the contact model, and the mean NIS of all is {before.nis.mean():.1f} (3 if all is "
        "right); no parameters were found that explain the recording better. Which of these it "
        "is, is not told: a wrong wrench.acts_on, sensor pose, unit, mass or diameter; stamps of "
        f"joint states that are some 0.1 s off those of the wrench (joints.delay, {delay:g} s at "
        "the start); filtered wrenches; a soft peg; wrench noise that is large for so light a "
        "peg; or slides too short or too slow to tell so many parameters"
    )


def _limits(start, x0, least_tilt):
    """Return the least and the greatest coordinates; the start's are within them."""
    low, high = np.full((2, len(QUANTITIES)), np.inf)
    low = -low
    low[FRICTION], high[FRICTION] = 0.0, 2.0
    low[DELAY], high[DELAY] = -0.1, 0.1
    # The least that a configuration may hold.
    low[NOISE] = np.log([1e-6, 1e-7, 1e-9])
    # The least tilt that was seen on three contacts is above gamma0.
    scene = start.scene
    clearance = scene.hole_diameter - scene.peg_diameter
    most = scene.hole_diameter * (1 - np.cos(0.99 * least_tilt))
    low[CLEARANCE] = log(0.05 * clearance)
    high[CLEARANCE] = log(max(most, 1.001 * clearance))
    # What stays as it was is never moved to a limit.
    return np.minimum(low, x0), np.maximum(high, x0)


def _thinned(parts):
    """Return pieces spread over all parts that together have at most MOST_JOINTS."""
    total = sum(part.stop - part.start for part in parts)
    if total <= MOST_JOINTS:
        return parts
    share = MOST_JOINTS / total
    pieces = []
    for part in parts:
        for begin in range(part.start, part.stop, 1000):
            length = min(1000, part.stop - begin)
            kept = max(round(length * share), 4 * (START + SETTLE))
            pieces.append(slice(begin, min(begin + kept, part.stop)))
    pieces = [piece for piece in pieces if piece.stop - piece.start > 2 * (START + SETTLE)]
    every = max(1, sum(piece.stop - piece.start for piece in pieces) // MOST_JOINTS)
    return pieces[::every]


def _estimates(x0, found, scale):
    x, stddev, final = found.best, found.stddev, found.x
    seen = stddev <= scale.useful
    # A coordinate that was never told apart has the spread of its prior.
    plain = np.sqrt(np.diagonal(found.covariance))
    correlation = np.abs(found.covariance / np.outer(plain, plain)) - np.eye(len(x))
    estimates = []
    for i, quantity in enumerate(QUANTITIES):
        nearest = int(np.argmax(correlation[i]))
        partner = NAMES[nearest] if not seen[i] and correlation[i, nearest] > 0.9 else ""
        half = NORMAL_95 * min(stddev[i], scale.range[i])
        values = (x0[i], x[i], x[i] - half, x[i] + half, final[i])
        values = (natural(quantity, value) for value in values)
        estimates.append(Estimate(quantity.name, quantity.unit, *values, bool(seen[i]), partner))
    return tuple(estimates)
