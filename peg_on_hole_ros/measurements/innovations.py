"""What innovations show of settings and of the contact mode: too large, or of one sign."""

from math import nan, sqrt
from typing import Annotated

import numpy as np

from peg_on_hole_ros.measurements.tuned import INNOVATION_WINDOW
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats, Record, Vector3

# Mean of a chi-squared variable of 3 degrees of freedom, and its median.
EXPECTED, MEDIAN = 3.0, 2.366


class StoredInnovation(Record):
    """
    One innovation that is kept for median and drift.

    Attributes
    ----------
    square
        Its innovation, normalised and squared.
    white : shape (3,)
        Its innovation, whitened; zeros: it does not count.

    """

    square: float
    white: Vector3


class Innovations(Record):
    """
    Running mean, median and drift of the innovations.

    A wrong lever arm, tare, direction of the hole or level of noise raises every innovation; a
    reversal raises a few of them very much. The median sees the one and not the other. What a
    parameter that is learnt can nearly make up for, as friction for a tilt, hardly raises them and
    yet pushes all one way: that is the drift, of 3 degrees of freedom.

    Attributes
    ----------
    corrections
        How many there were.
    watched
        How many of them in contact, or in a mode that is doubtful.
    average
        Of the last `mode_count`, normalised and squared; EXPECTED before.
    misfit
        That average with `most_against_mode` of each at most.
    median
        Of the window; NaN until it is full.
    drift
        Square of the sum over the window of what is whitened, over its length; NaN until it is
        full.
    large
        Whether the median is above `large_median`, of fewer by a wider margin.
    too_large
        Whether that, or the drift is above its bound.
    total : shape (3,)
        Sum over the window of what is whitened.
    last : shape (`mode_count`,)
        The latest, normalised and squared; a ring.
    window : StoredInnovation, shape (`settings_count`,)
        A ring.
    ordered : shape (`settings_count`,)
        The squares of the window by size.

    """

    corrections: int
    watched: int
    average: float
    misfit: float
    median: float
    drift: float
    large: bool
    too_large: bool
    total: Vector3
    last: Annotated[Floats, (INNOVATION_WINDOW.mode_count,)]
    window: Annotated[list[StoredInnovation], (INNOVATION_WINDOW.settings_count,)]
    ordered: Annotated[Floats, (INNOVATION_WINDOW.settings_count,)]


@compiled
def forget_innovations(seen: Innovations) -> None:
    """Forget all of them."""
    seen.corrections = seen.watched = 0
    seen.average = seen.misfit = EXPECTED
    seen.median = seen.drift = nan
    seen.total[:] = 0.0
    seen.large = seen.too_large = False


@compiled
def add_innovation(
    seen: Innovations,
    nis: float,
    white: Floats,
    used: bool,
    in_contact: bool,
    touching: bool,
) -> bool:
    """
    Process an innovation.

    Parameters
    ----------
    seen : Innovations
        Changed.
    nis : float
        Normalised and squared, 3 degrees of freedom, finite.
    white : ndarray, shape (3,)
        Over the lower root of its covariance.
    used : bool
        Whether `white` counts: it was used as predicted, and innovations are white.
    in_contact : bool
        Whether the contact equations are in force.
    touching : bool
        Whether it counts for or against the settings: in contact, or in a doubtful mode.

    Returns
    -------
    bool
        Whether the innovations are larger than stated.

    """
    mean_of = INNOVATION_WINDOW.mode_count
    # Without contacts they count neither for nor against three: their size must not keep
    # the mode from being tried again.
    seen.last[seen.corrections % mean_of] = nis if in_contact else EXPECTED
    seen.corrections += 1
    kept = min(seen.corrections, mean_of)
    first = seen.corrections - kept
    total = against = 0.0
    for i in range(kept):
        value = seen.last[(first + i) % mean_of]
        total += value
        against += min(value, INNOVATION_WINDOW.most_against_mode)
    seen.average, seen.misfit = total / kept, against / kept
    if not touching:
        return False
    watch(seen, nis, white, used)
    return seen.too_large


@compiled
def watch(seen: Innovations, nis: float, white: Floats, used: bool) -> None:
    """Add an innovation to median and drift; parameters as for `add_innovation`."""
    full, fewest = INNOVATION_WINDOW.settings_count, INNOVATION_WINDOW.fewest
    ordered, newest = seen.ordered, seen.window[seen.watched % full]
    count = min(seen.watched, full)
    if count == full:
        at = np.searchsorted(ordered, newest.square)
        for i in range(at, full - 1):
            ordered[i] = ordered[i + 1]
        count -= 1
    else:
        newest.white[:] = 0.0
    i = count
    while i > 0 and ordered[i - 1] > nis:
        ordered[i] = ordered[i - 1]
        i -= 1
    ordered[i] = nis
    newest.square = nis
    for i in range(3):
        new = white[i] if used else 0.0
        seen.total[i] = seen.total[i] - newest.white[i] + new
        newest.white[i] = new
    seen.watched += 1
    n = count + 1
    if n < fewest:
        return
    median = 0.5 * (ordered[(n - 1) // 2] + ordered[n // 2])
    drift = (seen.total[0] ** 2 + seen.total[1] ** 2 + seen.total[2] ** 2) / n
    above = (INNOVATION_WINDOW.large_median - MEDIAN) * sqrt(full / n)
    large = median > MEDIAN + above
    # Of a few, friction that is still learnt pushes all one way.
    leans = n == full and drift > INNOVATION_WINDOW.drift
    seen.large, seen.too_large = large, large or leans
    if n == full:
        seen.median, seen.drift = median, drift
    if large and n > fewest and not leans:
        squares = np.empty(fewest)
        for i in range(fewest):
            squares[i] = seen.window[(seen.watched - fewest + i) % full].square
        # The last are about as they should be, as of noise that was found: what is over is over.
        if np.sort(squares)[fewest // 2] < MEDIAN + 0.5 * above:
            _keep_latest(seen, squares)


@compiled
def _keep_latest(seen, squares):
    """Forget all but the latest, by their squares."""
    full, fewest = INNOVATION_WINDOW.settings_count, INNOVATION_WINDOW.fewest
    white = np.empty((fewest, 3))
    seen.total[:] = 0.0
    for i in range(fewest):
        white[i] = seen.window[(seen.watched - fewest + i) % full].white
        for j in range(3):
            seen.total[j] += white[i, j]
    for i in range(fewest):
        seen.window[i].square = squares[i]
        seen.window[i].white[:] = white[i]
    seen.watched = fewest
    seen.median = seen.drift = nan
    seen.large = seen.too_large = False
    seen.ordered[:fewest] = np.sort(squares)
