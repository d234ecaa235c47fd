"""How much noisier than stated a wrench is, by its members: the one place that lists them."""

from peg_on_hole_ros.measurements.wrench_noise import repeated, rough, saturated
from peg_on_hole_ros.measurements.wrench_noise.received import Received
from peg_on_hole_ros.measurements.wrench_noise.repeated import Repeated
from peg_on_hole_ros.measurements.wrench_noise.rough import Rough
from peg_on_hole_ros.measurements.wrench_noise.saturated import Saturated
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats, Record


class WrenchNoise(Record):
    """
    What all members remember.

    Attributes
    ----------
    repeated : Repeated
    saturated : Saturated
    rough : Rough

    """

    repeated: Repeated
    saturated: Saturated
    rough: Rough


@compiled
def forget(noise: WrenchNoise) -> None:
    """Begin anew with the next motion."""
    repeated.forget(noise.repeated)
    saturated.forget(noise.saturated)
    rough.forget(noise.rough)


def begin(noise: WrenchNoise) -> None:
    """Forget what was found of the noise that was stated: another is."""
    rough.begin(noise.rough)


@compiled
def follow(noise: WrenchNoise, received: Received) -> None:
    """Process a wrench."""
    repeated.follow(noise.repeated, received)
    if not repeated.is_news(noise.repeated):
        return
    saturated.follow(noise.saturated, received)
    rough.follow(noise.rough, received)


@compiled
def factor(noise: WrenchNoise) -> float:
    """Return by how much the variance of the last wrench is larger than stated."""
    times = repeated.factor(noise.repeated) * saturated.factor(noise.saturated)
    return times * rough.factor(noise.rough)


@compiled
def is_off(noise: WrenchNoise) -> bool:
    """Return whether the last wrench must not be used."""
    off = repeated.is_off(noise.repeated) or saturated.is_off(noise.saturated)
    return off or rough.is_off(noise.rough)


def causes(noise: WrenchNoise, variance: Floats) -> list[str]:
    """Return what is reported to a user, a line each."""
    return [
        *repeated.causes(noise.repeated, variance),
        *saturated.causes(noise.saturated, variance),
        *rough.causes(noise.rough, variance),
    ]
