"""
Parameters of a cell from a recording, by the greatest likelihood of the estimator's innovations.

Noise levels come from what neighbouring samples differ by; friction, biases, tilt, delay and
clearance from the likelihood under these. What the recording does not tell, or does not tell from
the start, stays as it was.
"""

from collections.abc import Callable
from dataclasses import replace
from math import log
from typing import Any, NamedTuple

import numpy as np
from scipy.special import chdtri

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.identification.fisher_scoring import (
    Peak,
    Search,
)
from peg_on_hole_ros.identification.guess import guess
from peg_on_hole_ros.identification.likelihood import Likelihood
from peg_on_hole_ros.identification.low_pass import noise_of_neighbours
from peg_on_hole_ros.identification.noise_levels import noise_levels
from peg_on_hole_ros.identification.quantities import (
    CALIBRATED_QUANTITIES,
    CLEARANCE_AT,
    DELAY_AT,
    FRICTION_AT,
    IS_NOISE,
    NOISE_AT,
    QUANTITY_NAMES,
    configured,
    coordinates,
    measures,
    natural,
)
from peg_on_hole_ros.identification.recording import (
    Recording,
    denoised,
    load,
    motion,
    shortfall,
    steady,
)
from peg_on_hole_ros.identification.selection import (
    NORMAL_95,
    conditional,
    kept_ones,
)
from peg_on_hole_ros.identification.tuned import (
    CALIBRATED_RECORDING,
    CALIBRATION_SEARCH,
    COUNTED_EVENTS,
    FIRST_GUESS,
    SCORING,
)


class CalibratedParameter(NamedTuple):
    """
    One parameter.

    Attributes
    ----------
    name, unit : str
    start, best, low, high, value : float
        Of the start; most likely, with its 95 % interval; as the configuration has it now.
    seen : bool
        Whether the interval is narrow enough to tell a cell anything.
    alike : tuple of str
        Of a parameter that is not seen, the others that it cannot be told apart from.

    """

    name: str
    unit: str
    start: float
    best: float
    low: float
    high: float
    value: float
    seen: bool
    alike: tuple[str, ...]

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
    estimates : tuple of CalibratedParameter
        In the order of CALIBRATED_QUANTITIES.
    nis_before, nis : float
        Mean normalised innovation squared at the start and at the end; 3 if all is right.
    innovations : int
    seconds : float
        Of steady sliding that was used [s].
    least_tilt : float
        The nearest that the tilt came in what was used, over gamma0.
    turn : float
        How far the peg turned about its own axis [rad].
    both_ways : bool
        Whether it turned both ways.
    low_pass : float
        Cut-off of a low-pass before the wrench that its noise shows [Hz]; 0: none.

    """

    configuration: Configuration
    estimates: tuple[CalibratedParameter, ...]
    nis_before: float
    nis: float
    innovations: int
    seconds: float
    least_tilt: float
    turn: float
    both_ways: bool
    low_pass: float


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
    fewest = CALIBRATED_RECORDING.fewest_innovations
    if count < fewest:
        raise BagError(
            f"only {count} joint states while all three contacts slide steadily, at least "
            f"{fewest} are needed: {shortfall(record, start)}"
        )
    moved = motion(record)
    told = _counted_progress(progress)
    stated = start.wrench.force_stddev, start.wrench.torque_stddev
    filtered = noise_of_neighbours(record.wrench_t, record.wrench, stated)
    found = _Found.of(record, moved, parts, start, told, filtered.pole)
    if found is None or found.nis > SCORING.explained_nis:
        farther = _thinned(steady(record, start, CALIBRATED_RECORDING.farther_tilt))
        if farther != parts and _count(farther) >= fewest:
            again = _Found.of(record, moved, farther, start, told, filtered.pole)
            if again is not None and (found is None or again.nis < found.nis):
                parts, found = farther, again
    if found is None or found.nis > CALIBRATED_RECORDING.unexplained_nis:
        raise BagError(_unexplained(found, start.joints.delay))
    progress(1.0)
    rows = _rows(parts)
    turns, fast = moved.rates[rows, 2], CALIBRATED_RECORDING.turning_rate
    configuration = configured(start, found.x)
    if filtered.cutoff > 0.0:
        wrench = replace(configuration.wrench, low_pass=filtered.cutoff)
        configuration = replace(configuration, wrench=wrench)
    return Calibration(
        configuration,
        _estimates(coordinates(start), found),
        found.nis_before,
        found.nis,
        _count(parts),
        float(sum(record.joint_t[part.stop - 1] - record.joint_t[part.start] for part in parts)),
        float(moved.q[rows, 0].min() / start.scene.gamma0),
        float(np.ptp(moved.q[rows, 2])),
        bool(turns.min() < -fast < fast < turns.max()),
        filtered.cutoff,
    )


def _counted_progress(progress):
    """Return what is called after each run: ever nearer to the end, also where it takes long."""
    count = 0

    def count_run():
        nonlocal count
        count += 1
        progress(1.0 - 2.0 ** (-2.0 * count / CALIBRATION_SEARCH.usual_runs))

    return count_run


def _count(parts):
    """Return how many joint states count."""
    uncounted = COUNTED_EVENTS.uncounted_orientations
    return sum(part.stop - part.start - uncounted for part in parts)


def _rows(parts):
    return np.concatenate([np.arange(part.start, part.stop) for part in parts])


class _Found(NamedTuple):
    # Coordinates, of which those that stay are the start's; likeliest ones if nothing has to
    # stay, their covariance, and each one's deviation.
    x: np.ndarray
    best: np.ndarray
    covariance: np.ndarray
    stddev: np.ndarray
    nis_before: float
    nis: float
    scale: Any

    @staticmethod
    def of(record, moved, parts, start, told, pole):
        rows, x0 = _rows(parts), coordinates(start)
        likelihood = Likelihood(record, parts, start)
        force = float(np.median(load(record, moved, start)[rows]))
        scale = measures(start.scene.hole_diameter, force)
        limits = _limits(start, x0, moved.q[rows, 0].min())
        begin, noise = _with_noise(record, pole, x0, limits)
        still = Likelihood(denoised(record), parts, start)
        search = Search(likelihood, still, x0, scale, limits, told)
        free = np.flatnonzero(~IS_NOISE)
        # A short recording shows its noise less well than a configuration may know it.
        begin = x0 if search.at(x0) > search.at(begin) else begin
        peaks = _peaks(search, likelihood, start, begin, free, force)
        if not peaks:
            return None
        best = peaks[0]
        covariance, stddev = _spread(best, peaks, free, scale, noise)
        kept = kept_ones(best.x - x0, covariance)
        before = likelihood.run(x0)
        stated = -np.inf if before is None else search.value(before, x0)
        chance = chdtri(free.size, CALIBRATION_SEARCH.change_level)
        if best.value - stated < CALIBRATION_SEARCH.short_recording_factor * chance:
            # Nothing that was found is surely likelier than what is stated.
            last = best._replace(x=x0, value=stated, run=before)
        else:
            last = _with(search, best, covariance, x0, kept)
        nis_before = np.inf if before is None else float(before.nis.mean())
        nis = float(last.run.nis.mean())
        return _Found(last.x, best.x, covariance, stddev, nis_before, nis, scale)


def _with(search: Search, best: Peak, covariance, x0, kept) -> Peak:
    """
    Return the most likely coordinates with those kept that may be kept.

    Far from its top the likelihood falls faster than its curvature there says: what is not borne
    out is set free.
    """
    kept = kept.copy()
    away = np.abs(best.x - x0) / np.sqrt(np.diagonal(covariance))
    level, freed = CALIBRATION_SEARCH.change_level, CALIBRATION_SEARCH.freed_at_once
    while kept.any():
        x = conditional(best.x, covariance, x0, kept)
        free = np.flatnonzero(~kept & ~IS_NOISE)
        last = search.climb(x, free, SCORING.most_iterations)
        if last is not None and best.value - last.value < chdtri(kept.sum(), level):
            return last
        kept[np.flatnonzero(kept)[np.argsort(away[kept])[-freed:]]] = False
    return best


def _with_noise(record, pole, x0, limits):
    """Return the coordinates with the noise that is seen, and its deviations, shape (3,)."""
    x, stddev = x0.copy(), np.full(3, 1e3)
    for k, level in enumerate(noise_levels(record, pole)):
        if level is not None:
            # That of the orientation is over what was stated.
            stated = x0[NOISE_AT][k] if k == 2 else 0.0
            x[NOISE_AT.start + k], stddev[k] = stated + level.log, level.stddev
    return np.clip(x, *limits), stddev


def _peaks(search: Search, likelihood, start, begin, free, force) -> list[Peak]:
    """Return where the climbs from several starts end, the best first."""
    near, far = FIRST_GUESS.small_bias_share * force, FIRST_GUESS.large_bias_share * force
    starts = [begin, *(guess(likelihood, start, begin, bias) for bias in (near, far))]
    values = [search.at(x) for x in starts]
    first, second, *_ = np.argsort(values)[::-1]
    if not np.isfinite(values[first]):
        return []
    peaks, x = [], starts[first]
    for _ in range(CALIBRATION_SEARCH.most_climbs):
        peak = search.climb(x, free, SCORING.most_iterations)
        if peak is None or peak.converged:
            break
        # What was open so far may now be told the better.
        x = max((guess(likelihood, start, peak.x, near), peak.x), key=search.at)
    if peak is None:
        return []
    peaks = [peak]
    if values[second] > peak.value - CALIBRATION_SEARCH.second_start_loss:
        peaks.append(search.climb(starts[second], free, SCORING.few_iterations))
    return sorted(filter(None, peaks), key=lambda peak: -peak.value)


def _spread(best: Peak, peaks, free, scale, noise):
    """
    Return covariance and deviations of all coordinates.

    The covariance is that of the curvature. Deviations are wider where scores vary by more than
    the curvature promises, and where starts that are as likely end elsewhere.
    """
    prior = np.diag(scale.range[free] ** -2.0)
    curvature = np.linalg.inv(best.information + prior)
    varied = best.scores - best.scores.mean(axis=0)
    sandwich = curvature @ (varied.T @ varied + prior) @ curvature
    wider = np.maximum(np.diagonal(sandwich) / np.diagonal(curvature), 1.0)
    equal = CALIBRATION_SEARCH.equal_likelihood
    others = [one.x for one in peaks if best.value - one.value < equal]
    apart = np.ptp(np.array(others), axis=0)[free]
    covariance = np.zeros((len(CALIBRATED_QUANTITIES), len(CALIBRATED_QUANTITIES)))
    covariance[np.ix_(free, free)] = curvature * np.sqrt(np.outer(wider, wider))
    covariance[free, free] += apart**2
    covariance[range(NOISE_AT.start, NOISE_AT.stop), range(NOISE_AT.start, NOISE_AT.stop)] = (
        noise**2
    )
    return covariance, np.sqrt(np.diagonal(covariance))


def _unexplained(found, delay):
    """Return what a recording shows that no parameters explain; the delay [s] at the start."""
    nis = "is not finite" if found is None else f"stays {found.nis:.1f}"
    return (
        "no parameters explain the recording. Check wrench.acts_on, the sensor's pose, units, "
        "masses and diameters, and joints.delay "
        f"({delay:g} s at the start; it may be off by some 0.1 s); filtered wrenches, a soft peg, "
        "or wrench noise that is large for so light a peg are other possible causes, and the "
        f"recording does not distinguish them. The mean NIS {nis} (3 if all is right) with every "
        "friction, wrench bias, tilt, delay and clearance that was tried"
    )


def _limits(start, x0, least_tilt):
    """Return the least and the greatest coordinates; the start's are within them."""
    low, high = np.full((2, len(CALIBRATED_QUANTITIES)), np.inf)
    low = -low
    low[FRICTION_AT], high[FRICTION_AT] = 0.0, CALIBRATION_SEARCH.most_friction
    low[DELAY_AT], high[DELAY_AT] = -CALIBRATION_SEARCH.most_delay, CALIBRATION_SEARCH.most_delay
    # The least that a configuration may hold.
    low[NOISE_AT] = np.log([1e-6, 1e-7, 1e-9])
    # The least tilt that was seen on three contacts is above gamma0.
    scene = start.scene
    clearance = scene.hole_diameter - scene.peg_diameter
    most = scene.hole_diameter * (1 - np.cos(0.99 * least_tilt))
    low[CLEARANCE_AT] = log(CALIBRATION_SEARCH.least_clearance_share * clearance)
    high[CLEARANCE_AT] = log(max(most, 1.001 * clearance))
    # What stays as it was is never moved to a limit.
    return np.minimum(low, x0), np.maximum(high, x0)


def _thinned(parts):
    """Return pieces spread over all parts that together have no more than counts."""
    total = sum(part.stop - part.start for part in parts)
    most, piece = CALIBRATED_RECORDING.most_joint_states, CALIBRATED_RECORDING.piece
    if total <= most:
        return parts
    share = most / total
    pieces = []
    for part in parts:
        for begin in range(part.start, part.stop, piece):
            length = min(piece, part.stop - begin)
            kept = min(max(round(length * share), CALIBRATED_RECORDING.shortest_piece), length)
            pieces.append(slice(begin, begin + kept))
    every = max(1, sum(piece.stop - piece.start for piece in pieces) // most)
    return pieces[::every]


def _estimates(x0, found: _Found):
    x, stddev, scale = found.best, found.stddev, found.scale
    seen = stddev <= scale.useful
    estimates = []
    for i, quantity in enumerate(CALIBRATED_QUANTITIES):
        alike = () if seen[i] else _alike(i, found.covariance, scale.useful)
        half = NORMAL_95 * min(stddev[i], scale.range[i])
        start, best, low, high, value = (
            natural(quantity, coordinate)
            for coordinate in (x0[i], x[i], x[i] - half, x[i] + half, found.x[i])
        )
        estimates.append(
            CalibratedParameter(
                quantity.name, quantity.unit, start, best, low, high, value, bool(seen[i]), alike
            )
        )
    return tuple(estimates)


def _alike(i, covariance, useful):
    """Return the names of what goes with one quantity along the directions that are not told."""
    rows = np.flatnonzero(~IS_NOISE)
    if i not in rows:
        return ()
    scaled = (covariance / np.outer(useful, useful))[np.ix_(rows, rows)]
    variance, directions = np.linalg.eigh(scaled)
    at = rows.tolist().index(i)
    # That direction which makes most of what is not known of the quantity.
    v = directions[:, int(np.argmax(variance * directions[at] ** 2))]
    named = np.abs(v) > CALIBRATION_SEARCH.named_share * np.abs(v).max()
    return tuple(QUANTITY_NAMES[rows[k]] for k in np.flatnonzero(named) if k != at)
