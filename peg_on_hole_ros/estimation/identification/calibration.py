"""
Parameters of a cell from a recording, by the greatest likelihood of the filter's innovations.

Two searches, as what moves the peg and what scatters the sensors are told by different things:
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
    IS_NOISE,
    NAMES,
    NOISE,
    QUANTITIES,
    SETTLE,
    START,
    configured,
    coordinates,
    innovations,
    natural,
)
from peg_on_hole_ros.estimation.identification.noise_levels import noise_levels
from peg_on_hole_ros.estimation.identification.recording import (
    Recording,
    motion,
    quiet,
    smoothed,
    steady,
)
from peg_on_hole_ros.estimation.identification.scoring import RANGES, greatest
from peg_on_hole_ros.estimation.identification.selection import (
    NORMAL_95,
    USEFUL,
    conditional,
    kept_ones,
)
from peg_on_hole_ros.options import Configuration

# Joint states beyond this are left out, evenly: they cost time and add little.
MOST_JOINTS = 4000
# Ten blocks of them, by which the intervals are widened: see `scoring.BLOCK`.
FEWEST_INNOVATIONS = 250
# The weights of the first search rest on a guess of the noise; off by more, it is done again.
NOISE_OFF = log(1.2)


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
    count = sum(part.stop - part.start - START - SETTLE for part in parts)
    if count < FEWEST_INNOVATIONS:
        raise BagError(
            f"only {count} joint states while all three contacts slide steadily, at least "
            f"{FEWEST_INNOVATIONS} are needed: record a peg that is pressed on the rim, tilted by "
            f"more than gamma0 ({start.scene.gamma0:.3g} rad) and turned and tilted by "
            "0.1 rad/s and more; or the scene's diameters are not those of the recording"
        )
    moved, rows = motion(record), np.concatenate([np.arange(p.start, p.stop) for p in parts])
    x0 = coordinates(start)
    limits = _limits(start, moved.q[rows, 0].min())
    runs = _Runs(record, parts, start, limits, progress)
    guess = fit(record, parts, start, limits)
    for i, level in zip(range(NOISE.start, NOISE.stop), noise_levels(record)):
        if level:
            guess[i] = log(level) + (x0[i] if NAMES[i] == "position_stddev" else 0.0)
    guess = np.clip(guess, *limits)
    peak = runs.of_motion(guess, x0, ~IS_NOISE)
    noise = runs.of_noise(peak.x, x0, IS_NOISE)
    if np.abs(noise.x - peak.x).max() > NOISE_OFF:
        peak = runs.of_motion(noise.x, x0, ~IS_NOISE)
    x, covariance = noise.x.copy(), np.zeros((len(x0), len(x0)))
    x[~IS_NOISE] = peak.x[~IS_NOISE]
    covariance[np.ix_(~IS_NOISE, ~IS_NOISE)] = peak.covariance
    covariance[np.ix_(IS_NOISE, IS_NOISE)] = noise.covariance
    stddev = np.concatenate([peak.stddev, noise.stddev])
    kept = kept_ones(x - x0, covariance)
    final = conditional(x, covariance, x0, kept)
    if kept.any() and not kept.all():
        free = ~kept & ~IS_NOISE
        if free.any():
            final = runs.of_motion(final, x0, free).x
        free = ~kept & IS_NOISE
        if free.any():
            final = runs.of_noise(final, x0, free).x
    before, after = (runs.once(at) for at in (x0, final))
    progress(1.0)
    turns = moved.rates[rows, 2]
    return Calibration(
        configured(start, final),
        _estimates(x0, x, stddev, final, covariance),
        *(float(found.nis.mean()) for found in (before, after)),
        before.lost,
        after.lost,
        count,
        float(sum(record.joint_t[part.stop - 1] - record.joint_t[part.start] for part in parts)),
        float(moved.q[rows, 0].min() / start.scene.gamma0),
        float(np.ptp(moved.q[rows, 2])),
        bool(turns.min() < -0.1 < 0.1 < turns.max()),
    )


class _Runs:
    """Runs of the filter over one recording, counted for the progress."""

    # Of a usual calibration.
    USUAL = 120

    def __init__(self, record, parts, start, limits, progress):
        self._record, self._smooth, self._quiet = record, smoothed(record), quiet(record)
        self._parts, self._start, self._limits = parts, start, limits
        self._progress, self._count = progress, 0

    def once(self, x, record=None):
        self._count += 1
        # Ever nearer to the end, also where it takes longer than usual.
        self._progress(1.0 - 2.0 ** (-2.0 * self._count / self.USUAL))
        return innovations(record or self._record, self._parts, self._start, x)

    def of_motion(self, x, centre, free):
        run, still = (lambda x, r=r: self.once(x, r) for r in (self._smooth, self._quiet))
        return self._known(greatest(run, x, centre, free, self._limits, still))

    def of_noise(self, x, centre, free):
        return self._known(greatest(self.once, x, centre, free, self._limits))

    @staticmethod
    def _known(peak):
        if peak is None or not peak.converged:
            raise BagError(
                "no parameters were found under which the contact model explains this recording: "
                "look for a wrong wrench.acts_on, sensor pose, unit, mass or diameter, for "
                "filtered wrenches, or for a soft peg"
            )
        return peak


def _limits(start, least_tilt):
    """Return the least and the greatest coordinates."""
    low, high = np.full((2, len(QUANTITIES)), np.inf)
    low = -low
    low[FRICTION], high[FRICTION] = 1e-4, 2.0
    low[DELAY], high[DELAY] = -0.1, 0.1
    # The least that a configuration may hold.
    low[NOISE] = np.log([1e-6, 1e-7, 1e-9])
    # The least tilt that was seen on three contacts is above gamma0.
    scene = start.scene
    clearance = scene.hole_diameter - scene.peg_diameter
    most = scene.hole_diameter * (1 - np.cos(0.99 * least_tilt))
    low[CLEARANCE] = log(0.05 * clearance)
    high[CLEARANCE] = log(max(most, 1.001 * clearance))
    return low, high


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


def _estimates(x0, x, stddev, final, covariance):
    seen = stddev <= USEFUL
    # A coordinate that was never told apart has the spread of its prior.
    plain = np.sqrt(np.diagonal(covariance))
    correlation = np.abs(covariance / np.outer(plain, plain)) - np.eye(len(x))
    estimates = []
    for i, quantity in enumerate(QUANTITIES):
        nearest = int(np.argmax(correlation[i]))
        partner = NAMES[nearest] if not seen[i] and correlation[i, nearest] > 0.9 else ""
        half = NORMAL_95 * min(stddev[i], RANGES[i])
        values = (x0[i], x[i], x[i] - half, x[i] + half, final[i])
        values = (natural(quantity, value) for value in values)
        estimates.append(Estimate(quantity.name, quantity.unit, *values, bool(seen[i]), partner))
    return tuple(estimates)
