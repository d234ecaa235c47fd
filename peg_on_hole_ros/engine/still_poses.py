"""Payload and zero from poses that are taken one by one, as a node is asked to."""

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.identification.payload import Payload, payload_of

# Of a normal distribution, 95 % on both sides.
_INTERVAL = 1.96


class StillPoses:
    """
    Poses at which a free peg was still.

    Parameters
    ----------
    configuration : Configuration

    """

    def __init__(self, configuration: Configuration) -> None:
        self._configuration = configuration
        self._gravity: list[np.ndarray] = []
        self._wrench: list[np.ndarray] = []
        self._count: list[int] = []

    @property
    def refused(self) -> str:
        """Why no pose determines anything under these settings; empty: each does."""
        if self._configuration.wrench.gravity != "measured":
            return "payload and bias need wrench.gravity: measured, and it is compensated"
        return ""

    def take(self, gravity_S: np.ndarray, wrench: np.ndarray, count: int) -> str:
        """
        Process a pose; return what all of them show.

        Parameters
        ----------
        gravity_S : ndarray, shape (3,)
            In sensor axes [m/s^2].
        wrench : ndarray, shape (6,)
            Mean as the sensor reads it, sensor axes [N], [N m].
        count : int
            Of how many wrenches.

        """
        self._gravity.append(gravity_S)
        self._wrench.append(wrench)
        self._count.append(count)
        taken = f"pose {len(self._count)} taken"
        poses = tuple(map(np.array, (self._gravity, self._wrench, self._count)))
        try:
            return f"{taken}: {_said(payload_of(*poses, self._configuration))}"  # type: ignore[arg-type, call-arg]
        except PegOnHoleError as error:
            return f"{taken}: {error}"


def _said(found: Payload) -> str:
    parts = [f"wrench.payload_mass: {found.mass:.4g} +- {_INTERVAL * found.mass_stddev:.2g} kg"]
    if np.isfinite(found.com).all():
        parts.append(_listed("wrench.payload_com", found.com, found.com_stddev, "m"))
    else:
        parts = ["no payload beside the peg is found"]
    parts.append(_listed("wrench.bias_force", found.bias[:3], found.bias_stddev[:3], "N"))
    parts.append(_listed("wrench.bias_torque", found.bias[3:], found.bias_stddev[3:], "N m"))
    return "; ".join([*parts, *(f"missing: {line}" for line in found.missing)])


def _listed(name, values, stddev, unit):
    listed = ", ".join(f"{value:.4g}" for value in values)
    return f"{name}: [{listed}] +- {_INTERVAL * float(np.max(stddev)):.2g} {unit}"
