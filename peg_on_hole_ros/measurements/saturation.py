"""Components of a wrench that stay at the end of what the sensor measures."""

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled

# So many wrenches in a row in which one component has one value, bit for bit, while others go on.
_STAYS = 20.0
# Sensors that round repeat values anywhere: of so many runs away from the ends, at least, each may
# have so many values in the mean, and some values may differ by no more than half the noise.
_RUNS, _FINE, _SMALL = 20.0, 1.5, 0.5
# In the memory: of each component its value, how often that has come in a row, the least and the
# most so far; of force and torque how many runs have ended away from both ends, their values, and
# whether two in a row have differed by little; which component stays, counted from 1, 0: none;
# which has stayed, and where. All zeros: no wrench yet.
LAST, ROW, LEAST, MOST, ENDED, LENGTH, SMALL = 0, 6, 12, 18, 24, 26, 28
STAYS, STAYED, END, WIDTH = range(30, 34)
_NAMES = tuple(f"the {kind}'s {axis}" for kind in ("force", "torque") for axis in "xyz")


@compiled
def notice_ends(
    memory: np.ndarray, values: np.ndarray | tuple[float, ...], variance: np.ndarray
) -> None:
    """
    Take a wrench whose values are news.

    Parameters
    ----------
    memory : ndarray, shape (WIDTH,)
        Changed.
    values : ndarray or tuple
        Force and torque as received [N], [N m].
    variance : ndarray, shape (6,)
        As stated [N^2], [N^2 m^2].

    """
    m = memory
    m[STAYS] = 0.0
    for i in range(6):
        value, kind = values[i], i // 3
        if m[ROW + i] == 0.0:
            m[LEAST + i] = m[MOST + i] = value
        elif value == m[LAST + i]:
            m[ROW + i] += 1.0
            at_end = value <= m[LEAST + i] or value >= m[MOST + i]
            fine = m[ENDED + kind] >= _RUNS and m[LENGTH + kind] < _FINE * m[ENDED + kind]
            fine = fine and m[SMALL + kind] > 0.0
            # A component that is not measured is 0.
            if m[ROW + i] >= _STAYS and at_end and fine and value != 0.0:
                m[STAYS] = m[STAYED] = i + 1.0
                m[END] = value
            continue
        elif m[LEAST + i] < m[LAST + i] < m[MOST + i]:
            m[ENDED + kind] += 1.0
            m[LENGTH + kind] += m[ROW + i]
        if m[ROW + i] > 0.0 and (value - m[LAST + i]) ** 2 < _SMALL * _SMALL * variance[i]:
            m[SMALL + kind] = 1.0
        m[LAST + i], m[ROW + i] = value, 1.0
        m[LEAST + i], m[MOST + i] = min(m[LEAST + i], value), max(m[MOST + i], value)


@compiled
def is_saturated(memory: np.ndarray) -> bool:
    """Return whether the last wrench has a component at an end."""
    return memory[STAYS] > 0.0


def causes(memory: np.ndarray) -> list[str]:
    """Return what there is to say: a line, or none."""
    component = int(memory[STAYED]) - 1
    if component < 0:
        return []
    unit = "N" if component < 3 else "N m"
    return [
        f"wrench: {_NAMES[component]} stays at {memory[END]:.4g} {unit} while the others go on: "
        "the end of what the sensor measures, or its driver passes on; of such a wrench nothing "
        "is made"
    ]
