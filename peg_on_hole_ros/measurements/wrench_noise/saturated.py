"""Saturated: a component of the wrench stays at the end of what the sensor measures."""

from typing import Annotated

from peg_on_hole_ros.measurements.tuned import SATURATION_TEST
from peg_on_hole_ros.measurements.wrench_noise.received import Received
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.number_text import quantity
from peg_on_hole_ros.records import WRENCH_COMPONENTS
from peg_on_hole_ros.typed_record import Floats, Integers, Record, Vector6


class Saturated(Record):
    """
    What was seen of each component of the wrench.

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
    in_a_row: Annotated[Integers, (6,)]
    least: Vector6
    most: Vector6
    runs: Annotated[Integers, (2,)]
    values: Annotated[Integers, (2,)]
    close: Annotated[Integers, (2,)]
    stays: int
    stayed: int
    end: float


@compiled
def forget(state: Saturated) -> None:
    """Forget nothing: the ends of the range are the same in every motion."""


@compiled
def follow(state: Saturated, received: Received) -> None:
    """Process a wrench, see the package."""
    state.stays, small = 0, SATURATION_TEST.small_step
    for i in range(6):
        value, kind = received.values[i], i // 3
        step = value - state.latest[i]
        if state.in_a_row[i] == 0:
            state.least[i] = state.most[i] = value
        elif value == state.latest[i]:
            state.in_a_row[i] += 1
            at_end = value <= state.least[i] or value >= state.most[i]
            fine = state.runs[kind] >= SATURATION_TEST.fewest_runs and state.close[kind] == 1
            fine = fine and state.values[kind] < SATURATION_TEST.longest_mean * state.runs[kind]
            # A component that is not measured is 0.
            if state.in_a_row[i] >= SATURATION_TEST.stays and at_end and fine and value != 0.0:
                state.stays = state.stayed = i + 1
                state.end = value
            continue
        elif state.least[i] < state.latest[i] < state.most[i]:
            state.runs[kind] += 1
            state.values[kind] += state.in_a_row[i]
        if state.in_a_row[i] > 0 and step**2 < small * small * received.variance[i]:
            state.close[kind] = 1
        state.latest[i], state.in_a_row[i] = value, 1
        state.least[i], state.most[i] = min(state.least[i], value), max(state.most[i], value)


@compiled
def factor(state: Saturated) -> float:
    """Return 1: the other components are as noisy as stated, and the wrench is off as a whole."""
    return 1.0


@compiled
def is_off(state: Saturated) -> bool:
    """Return whether the last wrench has a component at an end."""
    return state.stays > 0


def causes(state: Saturated, variance: Floats) -> list[str]:
    """Return what is reported to a user: a line, or none."""
    component = state.stayed - 1
    if component < 0:
        return []
    name, unit = WRENCH_COMPONENTS[component], "N" if component < 3 else "N m"
    return [
        f"wrench: {name} stays at {quantity(state.end, unit)} while the others go on: "
        "the end of what the sensor measures, or its driver passes on; such a wrench is "
        "not used"
    ]
