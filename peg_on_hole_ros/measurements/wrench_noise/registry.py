"""How noisy a wrench is, by its members: the one place that lists them."""

from peg_on_hole_ros.measurements.wrench_noise import repeated, rough
from peg_on_hole_ros.measurements.wrench_noise.received import Received
from peg_on_hole_ros.measurements.wrench_noise.repeated import Repeated
from peg_on_hole_ros.measurements.wrench_noise.rough import Rough
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats, Record


class WrenchNoise(Record):
    """
    What all members remember.

    Attributes
    ----------
    repeated : Repeated
    rough : Rough

    """

    repeated: Repeated
    rough: Rough


@compiled
def forget(noise: WrenchNoise) -> None:
    """Begin anew with the next motion."""
    repeated.forget(noise.repeated)
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
    rough.follow(noise.rough, received)


@compiled
def factor(noise: WrenchNoise) -> float:
    """Return by how much the variance of the last wrench is larger than stated."""
    return rough.factor(noise.rough) * repeated.factor(noise.repeated)


@compiled
def is_off(noise: WrenchNoise) -> bool:
    """Return whether the last wrench must not be used."""
    return repeated.is_off(noise.repeated) or rough.is_off(noise.rough)


def causes(noise: WrenchNoise, variance: Floats) -> list[str]:
    """Return what is reported to a user, a line each."""
    return [*repeated.causes(noise.repeated, variance), *rough.causes(noise.rough, variance)]
