"""The noise of the wrench as it shows it itself, where it is more than is stated."""

from math import sqrt
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from peg_on_hole_ros.estimator.noise import track_noise_ratio
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.measurements.tuned import WRENCH_NOISE_TEST
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats, Record

# What white noise makes of a third difference, squared; a motion leaves next to nothing.
_THIRD = 20.0

_OfForceAndTorque = Annotated[Floats, (2,)]
_Whether = Annotated[NDArray[np.int64], (2,)]


class WrenchNoise(Record):
    """
    By how much the variance of the wrench is more than stated; of force and of torque.

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

    found: _OfForceAndTorque
    seen: int
    most: _OfForceAndTorque
    wide: _OfForceAndTorque
    off: _Whether
    in_air: _OfForceAndTorque
    seen_in_air: int
    rough_in_air: int
    calm: bool
    last: Annotated[Floats, (3, 6)]


@compiled
def forget_noise(m: WrenchNoise) -> None:
    """Take noise as stated, until it shows more; what was found most stays."""
    m.seen = m.seen_in_air = m.rough_in_air = 0
    m.last[:] = 0.0
    m.found[:] = m.wide[:] = m.in_air[:] = 1.0


def begin(m: WrenchNoise) -> None:
    """Forget all that was found, as where other noise is stated."""
    m.most[:] = 0.0
    m.off[:] = 0
    m.calm = False
    forget_noise(m)


@compiled
def follow_wrench(
    m: WrenchNoise,
    values: Floats | tuple[float, float, float],
    variance: Floats,
    in_air: bool,
    settings: Settings,
) -> None:
    """
    Take a wrench with values that have not come before; the law is that of orientations.

    What is rough in contact alone chatters: it is used as noise, and is no setting's.

    Parameters
    ----------
    m : WrenchNoise
        Changed.
    values : ndarray or tuple
        Force and torque as received [N], [N m].
    variance : ndarray, shape (6,)
        As stated [N^2], [N^2 m^2].
    in_air : bool
        Whether the peg is told to touch nothing.
    settings : Settings

    """
    if not in_air:
        m.seen_in_air = 0
        m.in_air[:] = 1.0
    for part in range(2):
        square = 0.0
        for i in range(3 * part, 3 * part + 3):
            a, b, c = m.last[0, i], m.last[1, i], m.last[2, i]
            third = values[i] - 3.0 * c + 3.0 * b - a
            square += third * third / (3.0 * _THIRD * variance[i])
            m.last[0, i], m.last[1, i], m.last[2, i] = b, c, values[i]
        if m.seen >= 3:
            _track(m.found, part, square, settings.noise_most, settings)
            _track(m.wide, part, square, 2.0 * WRENCH_NOISE_TEST.another_unit, settings)
            if in_air and m.seen_in_air >= 3:
                _track(m.in_air, part, square, settings.noise_most, settings)
    m.seen += 1
    m.seen_in_air += 1
    # Contacts chatter before they are told.
    rough = in_air and max(m.in_air[0], m.in_air[1]) > WRENCH_NOISE_TEST.noisy
    m.rough_in_air = m.rough_in_air + 1 if rough else 0
    if in_air and not rough and m.seen_in_air >= WRENCH_NOISE_TEST.fewest:
        m.calm = True
    if m.seen < WRENCH_NOISE_TEST.fewest:
        return
    for part in range(2):
        if m.wide[part] > WRENCH_NOISE_TEST.another_unit:
            m.off[part] = 1
        found = m.found[part]
        if m.calm:
            found = m.in_air[part] if m.rough_in_air >= WRENCH_NOISE_TEST.fewest else 1.0
        if found < WRENCH_NOISE_TEST.largest_share * settings.noise_most:
            m.most[part] = max(m.most[part], found)


@compiled
def _track(ratios, part, square, most, settings):
    """Track one ratio of variances, up to a bound, by a square over the stated variance."""
    ratios[part] = track_noise_ratio(ratios[part], square / ratios[part], most, settings)


@compiled
def factor(m: WrenchNoise) -> float:
    """Return by how much the variance is more than stated; 1 where it may be as stated."""
    most = max(m.found[0], m.found[1])
    return most if most > WRENCH_NOISE_TEST.noisy else 1.0


@compiled
def is_off(m: WrenchNoise) -> bool:
    """Return whether the wrench is too rough for any noise."""
    return max(m.wide[0], m.wide[1]) > WRENCH_NOISE_TEST.another_unit


def causes(m: WrenchNoise, variance: Floats) -> list[str]:
    """Return what there is to say, a line for force and torque, by their stated variances."""
    told, times = [], sqrt(WRENCH_NOISE_TEST.another_unit)
    for part, (name, unit) in enumerate((("force", "N"), ("torque", "N m"))):
        most = m.most.item(part)
        if m.off.item(part):
            told.append(
                f"wrench: the {name} jumps by {times:.0f} times and more its stated noise "
                f"from message to message: is it in {unit}, of one sensor? no contact is told"
            )
        elif most > WRENCH_NOISE_TEST.noisy:
            found, stated = sqrt(most), sqrt(variance.item(3 * part))
            told.append(
                f"wrench.{name}_stddev: the noise of the {name} is {found:.1f} times the "
                f"stated one, {found * stated:.2g} {unit} for {stated:.2g} {unit}: used as "
                "found"
            )
    return told
