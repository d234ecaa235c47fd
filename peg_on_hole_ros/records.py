"""Records that travel from message to estimator and from monitor to message."""

from typing import NamedTuple

import numpy as np

ANGLES = ("gamma", "psi", "phi")
CONTACTS = ("K", "B1", "B2")
# The quantities that estimates are compared in: the angles, and the reaction at each contact.
SIX_QUANTITIES = (*ANGLES, *CONTACTS)
ALARM_LEVELS = ("OK", "WARN", "ERROR")
# Components of a wrench, as users read of them.
WRENCH_COMPONENTS = tuple(f"the {kind}'s {axis}" for kind in ("force", "torque") for axis in "xyz")
# Settings that a motion may not determine, by what each would cost; `diagnosis.suspected` has
# them in `unobservable`.
UNOBSERVABLE_SETTINGS = (
    "friction", "clearance", "force_along", "force_across", "torque", "hole_tilt", "gamma",
    "lever",
)  # fmt: skip


# By which parameters each kind of accuracy is stated; it is never learnt. Their order is that of
# `estimator.accuracy_record`.
ACCURACY_PARAMETERS = {
    "gain": ("accuracy.gain",),
    "crosstalk": ("accuracy.crosstalk",),
    "sensor_place": ("accuracy.sensor_xyz",),
    "sensor_axes": ("accuracy.sensor_rpy",),
    "payload": ("accuracy.payload_mass", "accuracy.payload_com"),
    "orientation": ("accuracy.orientation",),
    "diameter": ("accuracy.diameter", "accuracy.compliance"),
    "low_pass": ("wrench.low_pass",),
}
ACCURACIES = tuple(ACCURACY_PARAMETERS)


class Answer(NamedTuple):
    """
    What came of something that was asked for.

    Attributes
    ----------
    success : bool
        Whether it was done.
    message : str
        What was done, or why not.

    """

    success: bool
    message: str


class WrenchSample(NamedTuple):
    """
    One wrench message as it was received.

    Attributes
    ----------
    t_ns : int
        Stamp of the message [ns].
    force, torque : tuple of 3 float
        At the sensor origin, in sensor axes [N], [N m]; sign as the source has it.

    """

    t_ns: int
    force: tuple[float, float, float]
    torque: tuple[float, float, float]

    @classmethod
    def of_row(cls, t_ns: int, row: np.ndarray) -> "WrenchSample":
        """Return the wrench of a stamp whose force and torque a row has, shape (6,)."""
        force_x, force_y, force_z, *torque = row.tolist()
        return cls(int(t_ns), (force_x, force_y, force_z), tuple(torque))


class JointSample(NamedTuple):
    """
    One joint-state message as it was received.

    Attributes
    ----------
    t_ns : int
        Stamp of the message [ns].
    names : tuple of str
        In the order of the message.
    position : tuple of float
        One for each name [rad or m].

    """

    t_ns: int
    names: tuple[str, ...]
    position: tuple[float, ...]


class AngleMeasurement(NamedTuple):
    """
    Orientation of the peg in the hole, mapped to the paper's angles.

    Attributes
    ----------
    t_ns : int
        Stamp [ns].
    q : ndarray, shape (3,)
        gamma, psi, phi [rad].
    covariance : ndarray, shape (3, 3)
        Of q [rad^2], mapped from the orientation error by its Jacobian.
    position : ndarray, shape (3,), or None
        Of the peg's origin in the hole frame [m], where the source gives it.
    position_covariance : ndarray, shape (3, 3), or None
        [m^2]

    """

    t_ns: int
    q: np.ndarray
    covariance: np.ndarray
    position: np.ndarray | None = None
    position_covariance: np.ndarray | None = None

    @classmethod
    def of_row(cls, t_ns: int, row: np.ndarray) -> "AngleMeasurement":
        """Return the measurement whose `row` this is."""
        place = (row[12:15].copy(), row[15:].reshape(3, 3).copy()) if row[12] == row[12] else ()
        return cls(int(t_ns), row[:3].copy(), row[3:12].reshape(3, 3).copy(), *place)

    @property
    def row(self) -> np.ndarray:
        """The numbers in this order, NaN where there is no place, shape (24,)."""
        row = np.full(24, np.nan)
        row[:3], row[3:12] = self.q, self.covariance.ravel()
        if self.position is not None:
            row[12:15], row[15:] = self.position, self.position_covariance.ravel()  # type: ignore[union-attr]
        return row


class Arrivals(NamedTuple):
    """
    Wrenches and orientations in the order in which they arrived.

    Attributes
    ----------
    of_wrench : ndarray of bool, shape (n,)
        Whether a message is a wrench.
    t_ns : ndarray of int64, shape (n,)
        Stamps; of an orientation, of when it was measured [ns].
    sound : ndarray of bool, shape (n,)
        Whether it is given here; others have to be given as samples.
    wrenches : ndarray, shape (w, 6)
        Of all that are wrenches, as received [N], [N m].
    orientations : ndarray, shape (n - w, 24)
        Of all others, see `AngleMeasurement.row`.
    positions : ndarray, shape (n - w, joints)
        Of all others, what the joints read as received, in the order of `joints.names` [rad or
        m]; NaN where it was not read.

    """

    of_wrench: np.ndarray
    t_ns: np.ndarray
    sound: np.ndarray
    wrenches: np.ndarray
    orientations: np.ndarray
    positions: np.ndarray


class Rows(NamedTuple):
    """
    Outputs as numbers.

    Attributes
    ----------
    t_ns : ndarray of int64, shape (n,)
        Stamps of the wrenches [ns].
    values : ndarray of `output_row.ROW`, shape (n,)

    """

    t_ns: np.ndarray
    values: np.ndarray


class Alarm(NamedTuple):
    """
    One alarm as published.

    Attributes
    ----------
    name : str
        `jamming`, `contact_loss` or `overload`.
    level : int
        0 OK, 1 WARN, 2 ERROR (diagnostic_msgs/DiagnosticStatus).
    message : str
        What happens and what an operator or a program can do.
    names : tuple of str
    numbers : tuple of float
        What is behind it, by name.

    """

    name: str
    level: int
    message: str
    names: tuple[str, ...]
    numbers: tuple[float, ...]

    @property
    def values(self) -> tuple[tuple[str, float], ...]:
        """The numbers, each with its name."""
        return tuple(zip(self.names, self.numbers))
