"""Rough: third differences of wrenches show more noise than is stated."""

from math import sqrt
from typing import Annotated

from peg_on_hole_ros.estimator.orientation_noise import THIRD_DIFFERENCE, track_noise_ratio
from peg_on_hole_ros.measurements.tuned import WRENCH_NOISE_TEST
from peg_on_hole_ros.measurements.wrench_noise.received import Received
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.number_text import quantity
from peg_on_hole_ros.typed_record import Floats, Integers, Record, Vector2


class Rough(Record):
    """
    By how much the variance of the wrench is larger than stated; of force and of torque.

    Attributes
    ----------
    found : shape (2,)
        Now.
    seen
        How many values have come.
    most : shape (2,)
        The most that was found.
    wide : shape (2,)
        Now, with a higher bound.
    off : shape (2,)
        Whether that was reached.
    in_air : shape (2,)
        In the present stay in the air.
    seen_in_air, rough_in_air
        How many values that had, and how many in a row that were too rough.
    calm
        Whether a stay in the air was calm.
    last : shape (3, 6)
        The last three values [N], [N m].

    """

    found: Vector2
    seen: int
    most: Vector2
    wide: Vector2
    off: Annotated[Integers, (2,)]
    in_air: Vector2
    seen_in_air: int
    rough_in_air: int
    calm: bool
    last: Annotated[Floats, (3, 6)]


@compiled
def forget(state: Rough) -> None:
    """Assume the stated noise until wrenches show more; what was found most stays."""
    state.seen = state.seen_in_air = state.rough_in_air = 0
    state.last[:] = 0.0
    state.found[:] = state.wide[:] = state.in_air[:] = 1.0


def begin(state: Rough) -> None:
    """Forget all that was found: other noise is stated."""
    state.most[:] = 0.0
    state.off[:] = 0
    state.calm = False
    forget(state)


@compiled
def follow(state: Rough, received: Received) -> None:
    """
    Process a wrench, see the package; as `estimator.orientation_noise` does orientations.

    Noise in contact alone is chatter: the filter uses it, and no setting is wrong.
    """
    values, variance, settings = received.values, received.variance, received.settings
    in_air = received.in_air
    if not in_air:
        state.seen_in_air = 0
        state.in_air[:] = 1.0
    for part in range(2):
        square = 0.0
        for i in range(3 * part, 3 * part + 3):
            a, b, c = state.last[0, i], state.last[1, i], state.last[2, i]
            third = values[i] - 3.0 * c + 3.0 * b - a
            square += third * third / (3.0 * THIRD_DIFFERENCE * variance[i])
            state.last[0, i], state.last[1, i], state.last[2, i] = b, c, values[i]
        if state.seen >= 3:
            _track(state.found, part, square, settings.noise_most, settings)
            _track(state.wide, part, square, 2.0 * WRENCH_NOISE_TEST.another_unit, settings)
            if in_air and state.seen_in_air >= 3:
                _track(state.in_air, part, square, settings.noise_most, settings)
    state.seen += 1
    state.seen_in_air += 1
    # Contacts chatter before they are detected.
    rough = in_air and max(state.in_air[0], state.in_air[1]) > WRENCH_NOISE_TEST.noisy
    state.rough_in_air = state.rough_in_air + 1 if rough else 0
    if in_air and not rough and state.seen_in_air >= WRENCH_NOISE_TEST.fewest:
        state.calm = True
    if state.seen < WRENCH_NOISE_TEST.fewest:
        return
    for part in range(2):
        if state.wide[part] > WRENCH_NOISE_TEST.another_unit:
            state.off[part] = 1
        found = state.found[part]
        if state.calm:
            found = state.in_air[part] if state.rough_in_air >= WRENCH_NOISE_TEST.fewest else 1.0
        if found < WRENCH_NOISE_TEST.largest_share * settings.noise_most:
            state.most[part] = max(state.most[part], found)


@compiled
def _track(ratios, part, square, most, settings):
    """Track one ratio of variances, up to a bound, by a square over the stated variance."""
    ratios[part] = track_noise_ratio(ratios[part], square / ratios[part], most, settings)


@compiled
def factor(state: Rough) -> float:
    """Return by how much the variance is larger than stated; 1 where it may be as stated."""
    most = max(state.found[0], state.found[1])
    return most if most > WRENCH_NOISE_TEST.noisy else 1.0


@compiled
def is_off(state: Rough) -> bool:
    """Return whether the wrench is too rough for any noise."""
    return max(state.wide[0], state.wide[1]) > WRENCH_NOISE_TEST.another_unit


def causes(state: Rough, variance: Floats) -> list[str]:
    """Return what is reported, a line for force and torque, by their stated variances."""
    lines, times = [], sqrt(WRENCH_NOISE_TEST.another_unit)
    for part, (name, unit) in enumerate((("force", "N"), ("torque", "N m"))):
        most = state.most.item(part)
        if state.off.item(part):
            lines.append(
                f"wrench: the {name} jumps by {times:.0f} times and more its stated noise from "
                f"message to message: is it in {unit}, of one sensor? The contact mode is unknown"
            )
        elif most > WRENCH_NOISE_TEST.noisy:
            found, stated = sqrt(most), sqrt(variance.item(3 * part))
            lines.append(
                f"wrench.{name}_stddev: the noise of the {name} is {found:.1f} times the stated "
                f"one, {quantity(found * stated, unit, 2)} for {quantity(stated, unit, 2)}: used "
                "as found"
            )
    return lines
