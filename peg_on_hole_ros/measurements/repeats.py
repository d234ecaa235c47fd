"""Values that repeat bit for bit while stamps go on: how often each comes."""

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled

# Runs of one length in a row that make it a rule.
RULE = 5
# In the memory: how often the present value has come, since when [s], the length of the runs
# before it, how many of these there were in a row, since when [s], and runs at all; of the longest
# row of alike runs the length, how many, and the rate of new values [Hz]. The last values follow.
RUN, SINCE, LENGTH, ALIKE, BEGUN, RUNS, MOST_LENGTH, MOST_ALIKE, RATE, VALUES = range(10)


def new_repeats(width: int) -> np.ndarray:
    """Return a memory of values so wide that has seen none."""
    return np.zeros(VALUES + width)


@compiled
def notice(memory: np.ndarray, t: float, values: np.ndarray | tuple[float, float, float]) -> int:
    """
    Take values; return how often they have come in a row, 1: they are new.

    Parameters
    ----------
    memory : ndarray
        From `new_repeats`.
    t : float
        Stamp [s].
    values : ndarray or tuple

    """
    m = memory
    same = m[RUN] > 0.0
    for i in range(len(values)):
        same = same and m[VALUES + i] == values[i]
        m[VALUES + i] = values[i]
    if same:
        m[RUN] += 1.0
        return int(m[RUN])
    if m[RUN] > 0.0:
        # The first run may have begun before.
        if m[RUN] == m[LENGTH] and m[RUNS] > 1.0:
            m[ALIKE] += 1.0
        else:
            m[ALIKE], m[BEGUN] = 1.0, m[SINCE]
        m[LENGTH] = m[RUN]
        if m[LENGTH] > 1.0 and m[ALIKE] >= max(m[MOST_ALIKE], 1.0 * RULE) and t > m[BEGUN]:
            m[MOST_LENGTH], m[MOST_ALIKE] = m[LENGTH], m[ALIKE]
            m[RATE] = m[ALIKE] / (t - m[BEGUN])
    m[RUN], m[SINCE] = 1.0, t
    m[RUNS] += 1.0
    return 1


@compiled
def notice_all(memory: np.ndarray, t: np.ndarray, values: np.ndarray) -> None:
    """Take rows of values, each with its stamp [s]; see `notice`."""
    for k in range(len(t)):
        notice(memory, t[k], values[k])


@compiled
def held(memory: np.ndarray) -> int:
    """Return of how many messages each value is one, as a rule; 1: each is new."""
    return int(memory[LENGTH]) if memory[ALIKE] >= RULE else 1


def said(memory: np.ndarray) -> str:
    """Return what there is to say of values that come so many times each, or nothing."""
    if not memory[MOST_LENGTH]:
        return ""
    return (
        f"values repeat: each comes {memory[MOST_LENGTH]:.0f} times in a row, new ones at "
        f"{memory[RATE]:.3g} Hz, as where a driver holds those of a slower sensor; they count as "
        "one"
    )
