"""What the innovations tell of settings and of the contact mode: too large, or leaning one way."""

from math import nan, sqrt

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.record_types import InnovationsRecord

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

# Name, type and meaning of what the innovations have told.
FIELDS = (
    ("count", "i8", "corrections so far"),
    ("watched", "i8", "of them in contact, or in a mode that is doubtful"),
    ("mean", "f8", "of the last MEAN_OF, normalised and squared; EXPECTED before"),
    ("misfit", "f8", "that mean with MOST_AGAINST_MODE of each at most"),
    ("median", "f8", "of the window; NaN until it is full"),
    ("drift", "f8", "square of the sum over the window of what is whitened, over WINDOW"),
    ("large", "i8", "whether the median is above TOO_LARGE, of fewer by a wider margin"),
    ("too_large", "i8", "whether that, or the drift is above DRIFTS"),
    ("s0", "f8", "that sum"),
    ("s1", "f8", ""),
    ("s2", "f8", ""),
)


# Running mean, median and drift of the innovations.
#
# A wrong lever arm, tare, direction of the hole or level of noise raises every innovation; a
# reversal raises a few of them very much. The median sees the one and not the other. What a
# parameter that is learnt can nearly make up for, as friction for a tilt, hardly raises them and
# yet pushes all one way: that is the drift, of 3 degrees of freedom.
INNOVATIONS = np.dtype(
    [
        ("told", [field[:2] for field in FIELDS], (1,)),
        ("last", float, (MEAN_OF,)),  # the latest, a ring
        ("window", float, (WINDOW, 4)),  # normalised and squared, and whitened; a ring
        ("ordered", float, (WINDOW,)),  # the squares of the window by size
    ]
)


@compiled
def forget_innovations(innovations: InnovationsRecord) -> None:
    """Forget all of them."""
    t = innovations.told[0]
    t.count = t.watched = 0
    t.mean = t.misfit = EXPECTED
    t.median = t.drift = nan
    t.s0 = t.s1 = t.s2 = 0.0
    t.large = t.too_large = 0


@compiled
def add_innovation(
    innovations: InnovationsRecord,
    nis: float,
    white: np.ndarray,
    used: bool,
    in_contact: bool,
    touching: bool,
) -> bool:
    """
    Take an innovation.

    Parameters
    ----------
    innovations : record of INNOVATIONS
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
    t, last = innovations.told[0], innovations.last
    # Without contacts they say nothing for or against three: what they miss by must not keep
    # the mode from being tried again.
    last[t.count % MEAN_OF] = nis if in_contact else EXPECTED
    t.count += 1
    kept = min(t.count, MEAN_OF)
    first = t.count - kept
    total = against = 0.0
    for i in range(kept):
        value = last[(first + i) % MEAN_OF]
        total += value
        against += min(value, MOST_AGAINST_MODE)
    t.mean, t.misfit = total / kept, against / kept
    if not touching:
        return False
    watch(innovations, nis, white, used)
    return t.too_large == 1


@compiled
def watch(innovations: InnovationsRecord, nis: float, white: np.ndarray, used: bool) -> None:
    """Take an innovation into median and drift; parameters as for `add_innovation`."""
    t, window, ordered = innovations.told[0], innovations.window, innovations.ordered
    row = window[t.watched % WINDOW]
    count = min(t.watched, WINDOW)
    s0, s1, s2 = t.s0, t.s1, t.s2
    w0, w1, w2 = (white[0], white[1], white[2]) if used else (0.0, 0.0, 0.0)
    old = 0.0, 0.0, 0.0
    if count == WINDOW:
        old = row[1], row[2], row[3]
        at = np.searchsorted(ordered, row[0])
        for i in range(at, WINDOW - 1):
            ordered[i] = ordered[i + 1]
        count -= 1
    i = count
    while i > 0 and ordered[i - 1] > nis:
        ordered[i] = ordered[i - 1]
        i -= 1
    ordered[i] = nis
    row[0], row[1], row[2], row[3] = nis, w0, w1, w2
    t.watched += 1
    t.s0, t.s1, t.s2 = s0 - old[0] + w0, s1 - old[1] + w1, s2 - old[2] + w2
    n = count + 1
    if n < ENOUGH:
        return
    median = 0.5 * (ordered[(n - 1) // 2] + ordered[n // 2])
    drift = (t.s0 * t.s0 + t.s1 * t.s1 + t.s2 * t.s2) / n
    above = (TOO_LARGE - MEDIAN) * sqrt(WINDOW / n)
    large = median > MEDIAN + above
    # Of a few, friction that is still learnt pushes all one way.
    leans = n == WINDOW and drift > DRIFTS
    t.large = 1 if large else 0
    t.too_large = 1 if large or leans else 0
    if n == WINDOW:
        t.median, t.drift = median, drift
    if large and n > ENOUGH and not leans:
        latest = np.empty((ENOUGH, 4))
        for i in range(ENOUGH):
            latest[i] = window[(t.watched - ENOUGH + i) % WINDOW]
        # The last are about as they should be, as of noise that was found: what is over is over.
        if np.sort(latest[:, 0])[ENOUGH // 2] < MEDIAN + 0.5 * above:
            _keep(innovations, latest)


@compiled
def _keep(innovations, latest):
    """Forget all but the latest ENOUGH."""
    t, window = innovations.told[0], innovations.window
    t.watched = ENOUGH
    t.median = t.drift = nan
    t.large = t.too_large = 0
    t.s0 = t.s1 = t.s2 = 0.0
    for i in range(ENOUGH):
        window[i] = latest[i]
        t.s0, t.s1, t.s2 = t.s0 + latest[i, 1], t.s1 + latest[i, 2], t.s2 + latest[i, 3]
    innovations.ordered[:ENOUGH] = np.sort(latest[:, 0])
