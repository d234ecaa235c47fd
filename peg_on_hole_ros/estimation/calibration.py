"""
Parameters of a cell from a recording, with intervals.

Noise levels come from the noise itself, and are held: a fit would let them take up what the model
does not explain. Friction, biases, tilt, delay and clearance then make the six equations fit best,
robustly; the innovations of the filter under them are the check. The filter's likelihood itself
is no better a guide: it is rough in the delay, flat along friction and force, and blind where a
friction a few percent off leaves no motion. What the recording does not tell keeps its value.
"""

from collections.abc import Callable
from math import inf
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.estimation.inverse_dynamics import fit
from peg_on_hole_ros.estimation.likelihood import (
    NAMES,
    QUANTITIES,
    SETTLE,
    START,
    configured,
    innovations,
    start_values,
    with_noise,
)
from peg_on_hole_ros.estimation.noise_levels import noise_levels
from peg_on_hole_ros.estimation.recording import Recording, motion, steady
from peg_on_hole_ros.options import Configuration

# A normal variable lies within so many standard deviations in 95 of 100 cases.
NORMAL_95 = 1.96
# Noise in the slopes makes scores look sharper than they are. Set by hand after intervals of a
# few simulated recordings of one cycle missed; not yet confirmed over many seeds and scenes.
WIDENING = 1.4
# Joint states beyond this are left out, evenly: they cost time and add little.
MOST_JOINTS = 6000
FEWEST_INNOVATIONS = 100


class Estimate(NamedTuple):
    """
    One parameter.

    Attributes
    ----------
    name, unit : str
    value : float
        If not seen, that of the start.
    low, high : float
        95 % interval.
    seen : bool
        Whether the recording tells it.
    partner : str
        Of a parameter that is not seen, another that looks nearly the same; empty: none.

    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    seen: bool
    partner: str


class Calibration(NamedTuple):
    """
    What a recording tells.

    Attributes
    ----------
    configuration : Configuration
        The start with all that was seen put in.
    estimates : tuple of Estimate
        QUANTITIES, and then the noise levels.
    nis_before, nis : float
        Mean normalised innovation squared at the start and at the end; 3 if all is right,
        infinite where the parameters leave no motion.
    innovations : int
    seconds : float
        Of steady sliding that was used [s].
    least_tilt : float
        The nearest that the tilt came, over gamma0.
    turn : float
        How far the peg turned about its own axis [rad].
    both_ways : bool
        Whether it turned both ways.

    """

    configuration: Configuration
    estimates: tuple[Estimate, ...]
    nis_before: float
    nis: float
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
    start : Configuration
        Everything that is not calibrated, and where the search begins.
    progress : callable
        Told the share done, 0 to 1.

    Raises
    ------
    BagError
        The recording shows no steady sliding on three contacts, or none that the model fits.

    """
    levels = noise_levels(record)
    noisy, noise = _noise(start, levels)
    scale = noisy.joints.position_stddev / start.joints.position_stddev
    record = record._replace(covariance=record.covariance * scale**2)
    parts = _thinned(steady(record, noisy))
    count = sum(part.stop - part.start - START - SETTLE for part in parts)
    if count < FEWEST_INNOVATIONS:
        raise BagError(
            f"only {count} joint states while all three contacts slide steadily, at least "
            f"{FEWEST_INNOVATIONS} are needed: record a peg that is pressed on the rim, tilted by "
            f"more than gamma0 ({start.scene.gamma0:.3g} rad) and turned and tilted by "
            "0.1 rad/s and more; or the scene's diameters are not those of the recording"
        )
    progress(0.05)
    origin = start_values(start)
    before = innovations(record, parts, noisy)
    values, covariance = fit(record, parts, noisy, origin)
    covariance = covariance * WIDENING**2
    progress(0.6)
    stddev = np.sqrt(np.diagonal(covariance))
    seen = stddev <= [quantity.useful for quantity in QUANTITIES]
    if not seen.all():
        # Their spread stays in the intervals of the others.
        values, _ = fit(record, parts, noisy, origin, seen)
    progress(0.9)
    found = innovations(record, parts, configured(noisy, values))
    progress(1.0)
    moved = motion(record)
    rows = np.concatenate([np.arange(part.start, part.stop) for part in parts])
    estimates = _estimates(values, stddev, seen, covariance) + noise
    turns = moved.rates[rows, 2]
    return Calibration(
        configured(noisy, values),
        estimates,
        inf if before is None else float(before.nis.mean()),
        inf if found is None else float(found.nis.mean()),
        count,
        float(sum(record.joint_t[part.stop - 1] - record.joint_t[part.start] for part in parts)),
        float(moved.q[rows, 0].min() / start.scene.gamma0),
        float(np.ptp(moved.q[rows, 2])),
        bool(turns.min() < -0.1 < 0.1 < turns.max()),
    )


def _noise(start, levels):
    wrench, joints = start.wrench, start.joints
    was = (wrench.force_stddev, wrench.torque_stddev, joints.position_stddev)
    units, factors = ("N", "N m", "rad"), (1.0, 1.0, joints.position_stddev)
    names = ("force_stddev", "torque_stddev", "position_stddev")
    # The least that a configuration may hold.
    least = (1e-6, 1e-7, 1e-9)
    estimates, values = [], []
    for name, unit, level, old, factor, floor in zip(names, units, levels, was, factors, least):
        seen = level is not None and level.value * factor > floor
        value = level.value * factor if seen else old
        half = NORMAL_95 * level.stddev * factor if seen else inf
        low = max(value - half, 0.0)
        estimates.append(Estimate(name, unit, value, low, value + half, seen, ""))
        values.append(value)
    return with_noise(start, *values), tuple(estimates)


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


def _estimates(values, stddev, seen, covariance):
    correlation = covariance / np.outer(stddev, stddev)
    estimates = []
    for i, quantity in enumerate(QUANTITIES):
        others = np.abs(correlation[i])
        others[i] = 0.0
        nearest = int(np.argmax(others))
        partner = NAMES[nearest] if not seen[i] and others[nearest] > 0.9 else ""
        half = NORMAL_95 * stddev[i]
        row = (quantity.name, quantity.unit, float(values[i]))
        estimates.append(Estimate(*row, *(values[i] - half, values[i] + half), seen[i], partner))
    return tuple(
        estimate._replace(low=float(estimate.low), high=float(estimate.high), seen=bool(seen[i]))
        for i, estimate in enumerate(estimates)
    )
