"""What a method is to node, replay and studies: something that makes an estimator."""

from collections.abc import Mapping
from typing import NamedTuple, Protocol

from numpy.typing import ArrayLike

from peg_on_hole_ros.config.options import FilterOptions
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.typed_record import Floats


class Make(Protocol):
    """Makes an estimator of scene, filter options, wrench noise and what is not known."""

    def __call__(
        self,
        scene: Scene,
        options: FilterOptions,
        wrench_noise: Floats,
        offsets: OffsetUncertainty | None = None,
        /,
    ) -> ContactFilter:
        """
        Return the estimator.

        Parameters
        ----------
        scene : Scene
        options : FilterOptions
        wrench_noise : ndarray, shape (6, 6)
            Covariance of the wrench about the mass centre, peg axes [N^2], [N^2 m], [N^2 m^2].
        offsets : OffsetUncertainty, optional
            What is not known of bias and tilt.

        """


class Method(NamedTuple):
    """
    A method.

    Attributes
    ----------
    make : Make
    settings : Mapping or None
        Of the estimator, in place of the default ones, where it is a `ContactFilter` with
        something left out; None: it is a class of its own.

    """

    make: Make
    settings: Mapping[str, ArrayLike] | None = None


def of_settings(settings: Mapping[str, ArrayLike]) -> Method:
    """Return the method that is a `ContactFilter` with settings in place of the default ones."""

    def make(
        scene: Scene,
        options: FilterOptions,
        wrench_noise: Floats,
        offsets: OffsetUncertainty | None = None,
    ) -> ContactFilter:
        return ContactFilter(scene, options, wrench_noise, offsets, default_settings(**settings))

    return Method(make, settings)
