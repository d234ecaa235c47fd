"""Stated accuracies, and what they make of reactions and friction, as typed records."""

from enum import IntEnum
from typing import Annotated

from peg_on_hole_ros.typed_record import Floats, Matrix3, Matrix6, Record, Vector3, Vector6


class Kind(IntEnum):
    """Kinds of accuracies, in the order of `records.ACCURACIES`."""

    GAIN = 0
    CROSSTALK = 1
    SENSOR_PLACE = 2
    SENSOR_AXES = 3
    PAYLOAD = 4
    ORIENTATION = 5
    DIAMETER = 6
    LOW_PASS = 7


KIND_COUNT = len(Kind)
# Independent errors: where those of each kind begin, and how many there are.
GAINS, CROSSTALKS, PLACES, AXES, PAYLOADS, TILTS, DIAMETERS, LAG = 0, 7, 13, 16, 19, 23, 25, 26
SOURCES = 27
# Rows of sensitivities: N_K, N_B1, N_B2, and friction.
ROWS, OF_FRICTION = 4, 3


class Accuracies(Record):
    """
    Accuracies as they are stated, one standard deviation each, and what they act on.

    Attributes
    ----------
    stated : int
        1 where any is above zero, else 0: nothing is computed.
    gain, crosstalk : float
        Of a channel of the sensor: share of its own load, and of that of its two neighbours [-].
    sensor_place : float
        Of each coordinate of the sensor [m].
    sensor_axes : float
        About each axis of the sensor [rad].
    payload_mass : float
        Share of the payload's weight [-].
    payload_place : float
        Of each coordinate of its mass centre [m].
    orientation : float
        Offset of the orientation about each axis across the peg [rad].
    diameter : float
        Of each of the two diameters [m].
    compliance : float
        By how much contacts that give take of the clearance [m/N].
    lag : float
        By how much the wrench lags behind the load [s]; 0: by nothing.
    sensor_map : ndarray, shape (6, 6)
        From force and torque at the sensor, its axes, to those about the mass centre, peg axes.
    payload_kg : float
        The payload's mass [kg]; 0: there is none.
    payload_arm : ndarray, shape (3,)
        Its mass centre from that of the peg, peg axes [m].
    load : ndarray, shape (6,)
        What the sensor carries at the last wrench, without its bias, sensor axes [N], [N m].
    behind : ndarray, shape (6,)
        By how much that lags behind the load, as it changes [N], [N m].
    weight : ndarray, shape (3,)
        Of the payload at the last wrench, peg axes [N].

    """

    stated: int
    gain: float
    crosstalk: float
    sensor_place: float
    sensor_axes: float
    payload_mass: float
    payload_place: float
    orientation: float
    diameter: float
    compliance: float
    lag: float
    sensor_map: Matrix6
    payload_kg: float
    payload_arm: Vector3
    load: Vector6
    behind: Vector6
    weight: Vector3


class AccuracyEffect(Record):
    """
    What stated accuracies make of the last wrench's reactions, and of friction.

    Attributes
    ----------
    stated : int
        1 where any accuracy is stated, else 0.
    by_kind : ndarray, shape (KIND_COUNT, 3)
        Variance of the reactions at K, B1, B2 by each kind [N^2].
    reactions : ndarray, shape (3,)
        By all kinds together [N^2].
    friction : float
        Variance of friction [-].

    """

    stated: int
    by_kind: Annotated[Floats, (KIND_COUNT, 3)]
    reactions: Vector3
    friction: float


class AccuracyScratch(Record):
    """
    Memory of one step, see `stated_accuracy`.

    Attributes
    ----------
    factor : ndarray, shape (6, 6)
        Cholesky factor of the residual's noise.
    white : ndarray, shape (ROWS, 6)
        Whitened columns of the reactions and of friction.
    gram, over : ndarray, shape (3, 3)
        Products of those of the reactions, and their inverse.
    by_residual : ndarray, shape (ROWS, 6)
        Derivatives of reactions and friction by an error of the residual.
    by_wrench : ndarray, shape (ROWS, 6)
        By one of the wrench on the peg.
    by_sensor : ndarray, shape (ROWS, 6)
        By one of what the sensor reads, sensor axes.
    by_friction : ndarray, shape (3,)
        Derivatives of the reactions by friction [N].
    effect : ndarray, shape (SOURCES, ROWS)
        What one standard deviation of each source makes of reactions, friction given, and of
        friction by this wrench alone [N], [-].
    over_pivot : ndarray, shape (6,)
        One over the diagonal of `factor`.
    solved : ndarray, shape (ROWS, 6)
        Derivatives by an error of the whitened residual.

    """

    factor: Matrix6
    white: Annotated[Floats, (ROWS, 6)]
    gram: Matrix3
    over: Matrix3
    by_residual: Annotated[Floats, (ROWS, 6)]
    by_wrench: Annotated[Floats, (ROWS, 6)]
    by_sensor: Annotated[Floats, (ROWS, 6)]
    by_friction: Vector3
    effect: Annotated[Floats, (SOURCES, ROWS)]
    over_pivot: Vector6
    solved: Annotated[Floats, (ROWS, 6)]
