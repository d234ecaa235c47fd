"""Components of a wrench that stay at the end of what the sensor measures."""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from peg_on_hole_ros.measurements.tuned import SATURATION_TEST
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats, Record, Vector6

_NAMES = tuple(f"the {kind}'s {axis}" for kind in ("force", "torque") for axis in "xyz")

_OfComponents = Annotated[NDArray[np.int64], (6,)]
_OfForceAndTorque = Annotated[NDArray[np.int64], (2,)]


class Saturation(Record):
    """
    What was seen of each component of the wrench; all zeros: no wrench yet.

    Attributes
    ----------
    latest, in_a_row : shape (6,)
        Value of each component, and how often that has come in a row.
    least, most : shape (6,)
        Of each component, so far.
    runs, values : shape (2,)
        Of force and torque: runs that ended away from both ends, and the values in them.
    close : shape (2,)
        Of force and torque: whether two values in a row have differed by little.
    stays
        Component that is at an end now, counted from 1; 0: none.
    stayed, end
        Component that was last, and the value there.

    """

    latest: Vector6
    in_a_row: _OfComponents
    least: Vector6
    most: Vector6
    runs: _OfForceAndTorque
    values: _OfForceAndTorque
    close: _OfForceAndTorque
    stays: int
    stayed: int
    end: float


@compiled
def notice_ends(m: Saturation, values: Floats | tuple[float, ...], variance: Floats) -> None:
    """
    Take a wrench whose values are news.

    Parameters
    ----------
    m : Saturation
        Changed.
    values : ndarray or tuple
        Force and torque as received [N], [N m].
    variance : ndarray, shape (6,)
        As stated [N^2], [N^2 m^2].

    """
    m.stays = 0
    for i in range(6):
        value, kind = values[i], i // 3
        if m.in_a_row[i] == 0:
            m.least[i] = m.most[i] = value
        elif value == m.latest[i]:
            m.in_a_row[i] += 1
            at_end = value <= m.least[i] or value >= m.most[i]
            fine = m.runs[kind] >= SATURATION_TEST.fewest_runs and m.close[kind] == 1
            fine = fine and m.values[kind] < SATURATION_TEST.longest_mean * m.runs[kind]
            # A component that is not measured is 0.
            if m.in_a_row[i] >= SATURATION_TEST.stays and at_end and fine and value != 0.0:
                m.stays = m.stayed = i + 1
                m.end = value
            continue
        elif m.least[i] < m.latest[i] < m.most[i]:
            m.runs[kind] += 1
            m.values[kind] += m.in_a_row[i]
        small = SATURATION_TEST.small_step
        if m.in_a_row[i] > 0 and (value - m.latest[i]) ** 2 < small * small * variance[i]:
            m.close[kind] = 1
        m.latest[i], m.in_a_row[i] = value, 1
        m.least[i], m.most[i] = min(m.least[i], value), max(m.most[i], value)


@compiled
def is_saturated(memory: Saturation) -> bool:
    """Return whether the last wrench has a component at an end."""
    return memory.stays > 0


def causes(memory: Saturation) -> list[str]:
    """Return what there is to say: a line, or none."""
    component = memory.stayed - 1
    if component < 0:
        return []
    unit = "N" if component < 3 else "N m"
    return [
        f"wrench: {_NAMES[component]} stays at {memory.end:.4g} {unit} while the others go on: "
        "the end of what the sensor measures, or its driver passes on; of such a wrench nothing "
        "is made"
    ]
