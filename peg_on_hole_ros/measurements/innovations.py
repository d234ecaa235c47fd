"""What the innovations tell of settings and of the contact mode: too large, or leaning one way."""

from math import nan, sqrt
from typing import Annotated

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats, Record, Vector3

# Over so many corrections the mean is taken that says whether a contact mode fits.
MEAN_OF = 20
# One that noise has thrown is no other contact, which surprises again and again: against a mode
# each counts as so much at most.
MOST_AGAINST_MODE = 30.0
EXPECTED = 3.0
# Enough to tell 3.3 from the median of a chi-squared variable of 3 degrees of freedom, 2.37, by
# five standard deviations of a median (0.19). Of fewer it has to be farther above, by the root.
WINDOW = 200
TOO_LARGE = 3.3
MEDIAN, ENOUGH = 2.366, 60
# A chi-squared variable of 3 degrees of freedom is above it once in 7e5 windows. Over 11 s of a
# working cycle the largest was 17, in a friction that is not as learnt after each turn.
DRIFTS = 30.0


class Watched(Record):
    """
    A correction in contact, or in a mode that is doubtful.

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
        Of the last MEAN_OF, normalised and squared; EXPECTED before.
    misfit
        That average with MOST_AGAINST_MODE of each at most.
    median
        Of the window; NaN until it is full.
    drift
        Square of the sum over the window of what is whitened, over WINDOW; NaN until it is full.
    large
        Whether the median is above TOO_LARGE, of fewer by a wider margin.
    too_large
        Whether that, or the drift is above DRIFTS.
    total : shape (3,)
        Sum over the window of what is whitened.
    last : shape (MEAN_OF,)
        The latest, normalised and squared; a ring.
    window : Watched, shape (WINDOW,)
        A ring.
    ordered : shape (WINDOW,)
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
    last: Annotated[Floats, (MEAN_OF,)]
    window: Annotated[list[Watched], (WINDOW,)]
    ordered: Annotated[Floats, (WINDOW,)]


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
    Take an innovation.

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
        Whether it says something of the settings: in contact, or in a mode that is doubtful.

    Returns
    -------
    bool
        Whether the innovations are larger than stated.

    """
    # Without contacts they say nothing for or against three: what they miss by must not keep
    # the mode from being tried again.
    seen.last[seen.corrections % MEAN_OF] = nis if in_contact else EXPECTED
    seen.corrections += 1
    kept = min(seen.corrections, MEAN_OF)
    first = seen.corrections - kept
    total = against = 0.0
    for i in range(kept):
        value = seen.last[(first + i) % MEAN_OF]
        total += value
        against += min(value, MOST_AGAINST_MODE)
    seen.average, seen.misfit = total / kept, against / kept
    if not touching:
        return False
    watch(seen, nis, white, used)
    return seen.too_large


@compiled
def watch(seen: Innovations, nis: float, white: Floats, used: bool) -> None:
    """Take an innovation into median and drift; parameters as for `add_innovation`."""
    ordered, newest = seen.ordered, seen.window[seen.watched % WINDOW]
    count = min(seen.watched, WINDOW)
    if count == WINDOW:
        at = np.searchsorted(ordered, newest.square)
        for i in range(at, WINDOW - 1):
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
    if n < ENOUGH:
        return
    median = 0.5 * (ordered[(n - 1) // 2] + ordered[n // 2])
    drift = (seen.total[0] ** 2 + seen.total[1] ** 2 + seen.total[2] ** 2) / n
    above = (TOO_LARGE - MEDIAN) * sqrt(WINDOW / n)
    large = median > MEDIAN + above
    # Of a few, friction that is still learnt pushes all one way.
    leans = n == WINDOW and drift > DRIFTS
    seen.large, seen.too_large = large, large or leans
    if n == WINDOW:
        seen.median, seen.drift = median, drift
    if large and n > ENOUGH and not leans:
        squares = np.empty(ENOUGH)
        for i in range(ENOUGH):
            squares[i] = seen.window[(seen.watched - ENOUGH + i) % WINDOW].square
        # The last are about as they should be, as of noise that was found: what is over is over.
        if np.sort(squares)[ENOUGH // 2] < MEDIAN + 0.5 * above:
            _keep_latest(seen, squares)


@compiled
def _keep_latest(seen, squares):
    """Forget all but the latest ENOUGH, by their squares."""
    white = np.empty((ENOUGH, 3))
    seen.total[:] = 0.0
    for i in range(ENOUGH):
        white[i] = seen.window[(seen.watched - ENOUGH + i) % WINDOW].white
        for j in range(3):
            seen.total[j] += white[i, j]
    for i in range(ENOUGH):
        seen.window[i].square = squares[i]
        seen.window[i].white[:] = white[i]
    seen.watched = ENOUGH
    seen.median = seen.drift = nan
    seen.large = seen.too_large = False
    seen.ordered[:ENOUGH] = np.sort(squares)
