"""From a wrench as received to the wrench on the peg."""

from collections.abc import Sequence
from math import copysign, isfinite, pi, sqrt

import numpy as np

from peg_on_hole_ros.config.options import Accuracy, Configuration, WrenchInput
from peg_on_hole_ros.estimator.accuracy_record import Accuracies
from peg_on_hole_ros.estimator.offset_uncertainty import OffsetUncertainty
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy, skew
from peg_on_hole_ros.measurements.tuned import LOW_PASS_LAG, PLAUSIBLE_WRENCH
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.linear_algebra import TORQUE, in_peg_axes, peg_turns
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.typed_record import Matrix3, Matrix6, Record, Vector6, new


def wrench_fault(sample: WrenchSample) -> str | None:
    """
    Return what is wrong with a wrench as received; None: nothing.

    Returns
    -------
    str or None
        `not_finite`, or `out_of_range`: larger than `PLAUSIBLE_WRENCH`.

    """
    (f_x, f_y, f_z), (m_x, m_y, m_z) = sample.force, sample.torque
    force, torque = PLAUSIBLE_WRENCH.most_force, PLAUSIBLE_WRENCH.most_torque
    # Neither holds for a NaN.
    if (
        f_x * f_x + f_y * f_y + f_z * f_z <= force * force
        and m_x * m_x + m_y * m_y + m_z * m_z <= torque * torque
    ):
        return None
    finite = all(map(isfinite, (*sample.force, *sample.torque)))
    return "out_of_range" if finite else "not_finite"


def sound_wrenches(values: np.ndarray) -> np.ndarray:
    """Return which wrenches (n, 6) have no `wrench_fault`, shape (n,)."""
    f_x, f_y, f_z, m_x, m_y, m_z = values.T
    force, torque = PLAUSIBLE_WRENCH.most_force, PLAUSIBLE_WRENCH.most_torque
    # Neither holds for a NaN.
    with np.errstate(over="ignore", invalid="ignore"):
        return (f_x * f_x + f_y * f_y + f_z * f_z <= force * force) & (
            m_x * m_x + m_y * m_y + m_z * m_z <= torque * torque
        )


def noise_of(options: WrenchInput) -> tuple[float, float]:
    """Return the noise that is stated of forces and of torques [N], [N m]."""
    return options.force_stddev, options.torque_stddev


class ReductionSteps(Record):
    """
    The steps of a `WrenchReduction` for compiled code.

    Attributes
    ----------
    sign
    in_base : bool
        Whether the wrench comes in the axes of the base, or of another link that stands still.
    base_in_hole, peg_in_sensor : shape (3, 3)
        From axes of that link to those of the hole, from axes of the peg to those of the sensor.
    tare : shape (6,)
    matrix : shape (6, 6)
    mass, arm : float, shape (3, 3)
        Mass whose weight the sensor carries and the peg does not [kg], and the matrix of its arm
        [m]; below zero the peg's own, which a controller has taken off.

    """

    sign: float
    in_base: bool
    base_in_hole: Matrix3
    peg_in_sensor: Matrix3
    tare: Vector6
    matrix: Matrix6
    mass: float
    arm: Matrix3


class WrenchReduction:
    """
    The map from the sensor's wrench to the wrench on the peg at its mass centre, peg axes.

    Steps: sign, axes of the base to those of the sensor, tare, sensor axes to peg axes, sensor
    origin to mass centre, weight of the payload, or of all that hangs where it is taken off.

    Parameters
    ----------
    options : WrenchInput
    scene : Scene
    hole_rpy : sequence of 3 float
        Hole axes in the root link [rad], for a wrench in the axes of a link that stands still.

    Attributes
    ----------
    matrix : ndarray, shape (6, 6)
        From force and torque at the sensor, sensor axes, to those at the mass centre, peg axes.
    noise : ndarray, shape (6,)
        Variance of a wrench as received [N^2], [N^2 m^2].
    covariance : ndarray, shape (6, 6)
        Of the reduced wrench [N^2, N^2 m, N^2 m^2].
    tare : ndarray, shape (6,)
        Subtracted from the sensor's wrench after the sign [N], [N m]; until one is taken, the bias
        of the configuration.

    """

    def __init__(
        self, options: WrenchInput, scene: Scene, hole_rpy: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> None:
        self.sign = -1.0 if options.acts_on == "robot" else 1.0
        R_PS = rotation_from_rpy(options.sensor_rpy)
        center_P = np.array([0.0, 0.0, scene.mass_center_height])
        r_P = np.array(options.sensor_xyz) - center_P
        self.matrix = np.block([[R_PS, np.zeros((3, 3))], [skew(r_P) @ R_PS, R_PS]])
        self.take_noise(options)
        steps = new(ReductionSteps)
        self.tare = steps.tare
        self._stated = self.sign * np.array([*options.bias_force, *options.bias_torque])
        self.tare[:] = self._stated
        payload_P = np.array(options.sensor_xyz) + R_PS @ np.array(options.payload_com)
        mass, arm = float(options.payload_mass), skew(payload_P - center_P)
        if options.gravity == "compensated":
            # A controller that compensates the weight leaves none of the payload, nor of the peg.
            mass, arm = -scene.peg_mass, np.zeros((3, 3))
        steps.sign, steps.peg_in_sensor[:] = self.sign, R_PS.T
        base_rpy, R_HB = options.base_rpy, rotation_from_rpy(hole_rpy).T
        steps.in_base = base_rpy is not None
        if base_rpy is not None and any(base_rpy):
            R_HB = R_HB @ rotation_from_rpy(base_rpy)
        steps.base_in_hole[:] = R_HB
        steps.matrix[:], steps.arm[:], steps.mass = self.matrix, arm, mass
        self.steps = steps
        self._payload = float(options.payload_mass), payload_P - center_P
        self._peg_mass = scene.peg_mass
        lowest = LOW_PASS_LAG.lowest_cutoff
        self._lag = 0.0
        if options.low_pass > 0.0:
            self._lag = 1.0 / (2.0 * pi * max(options.low_pass, lowest))
        self._gravity_H = np.array(scene.gravity, float)

    def take_noise(self, options: WrenchInput) -> None:
        """Use the noise that is stated."""
        stddev = [options.force_stddev] * 3 + [options.torque_stddev] * 3
        self.noise = np.square(stddev)
        self.covariance = self.matrix @ np.diag(self.noise) @ self.matrix.T

    def offsets(self, configuration: Configuration) -> OffsetUncertainty:
        """Return what is not known of the sensor's zero and of the hole's direction."""
        wrench, options = configuration.wrench, configuration.filter
        stddev = [wrench.bias_force_stddev] * 3 + [wrench.bias_torque_stddev] * 3
        stddev += [configuration.joints.hole_tilt_stddev] * 2
        drift = [wrench.bias_force_drift] * 3 + [wrench.bias_torque_drift] * 3
        return OffsetUncertainty(
            np.square(stddev),
            -self.sign * self.matrix,
            np.array(drift),
            options.wrench_bias == "estimated",
            options.hole_tilt == "estimated",
            configuration.joints.delay_stddev,
        )

    def fill_accuracies(self, stated: Accuracies, accuracy: Accuracy) -> None:
        """Fill in the accuracies as stated, and what of this sensor and payload they act on."""
        stated.gain, stated.crosstalk = accuracy.gain, accuracy.crosstalk
        stated.sensor_place, stated.sensor_axes = accuracy.sensor_xyz, accuracy.sensor_rpy
        stated.payload_mass, stated.payload_place = accuracy.payload_mass, accuracy.payload_com
        stated.orientation, stated.diameter = accuracy.orientation, accuracy.diameter
        stated.compliance = accuracy.compliance
        stated.lag = self._lag
        stated.stated = int(accuracy != Accuracy.exact() or self._lag > 0.0)
        stated.sensor_map[:] = self.matrix
        stated.payload_kg, stated.payload_arm[:] = self._payload

    @property
    def stated(self) -> np.ndarray:
        """The `tare` that the configured bias is, shape (6,) [N], [N m]."""
        return self._stated

    @property
    def taken_off(self) -> np.ndarray:
        """What is taken off, as the sensor reports it: tare or configured bias, shape (6,)."""
        return self.sign * self.tare

    def gravity_in_sensor(self, q: np.ndarray, gravity_H: np.ndarray) -> np.ndarray:
        """Return gravity, given in hole axes, in sensor axes, shape (3,) [m/s^2]."""
        gravity_H = self._gravity_H if gravity_H is None else gravity_H
        return self.steps.peg_in_sensor @ peg_axes(q).T @ gravity_H

    def on_peg(
        self,
        force: Sequence[float] | np.ndarray,
        torque: Sequence[float] | np.ndarray,
        q: np.ndarray | None,
        gravity_H: np.ndarray | None = None,
    ) -> np.ndarray:
        """
        Return the wrench on the peg about its mass centre, peg axes, shape (6,).

        Parameters
        ----------
        force, torque : sequence of 3 float
            As received, sensor axes [N], [N m].
        q : ndarray, shape (3,), or None
            gamma, psi, phi [rad]; they matter where there is a payload, for `wrench.axes: base`
            and for `wrench.gravity: compensated`.
        gravity_H : ndarray, shape (3,), optional
            In the hole axes of q [m/s^2]; None: those of the configuration.

        """
        wrench, q = np.empty(6), np.zeros(3) if q is None else q
        gravity_H = self._gravity_H if gravity_H is None else gravity_H
        reduce_wrench(self.steps, np.array([*force, *torque]), q, tuple(gravity_H), wrench)
        return wrench

    def take_tare(
        self,
        force: Sequence[float] | np.ndarray,
        torque: Sequence[float] | np.ndarray,
        q: np.ndarray,
        gravity_H: np.ndarray | None = None,
    ) -> None:
        """
        Use a wrench as that of a peg which hangs free.

        What stays is the weight of peg and payload: with the reading itself set to zero the model
        would have the peg fall.
        """
        self.tare[:] = self.zero_of(force, torque, q, gravity_H)

    def zero_of(
        self,
        force: Sequence[float] | np.ndarray,
        torque: Sequence[float] | np.ndarray,
        q: np.ndarray,
        gravity_H: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return the `tare` with which a wrench is that of a peg which hangs free, shape (6,)."""
        gravity_H = tuple(self._gravity_H if gravity_H is None else gravity_H)
        measured, below = np.array([*force, *torque]), np.zeros(6)
        turn_to_sensor(self.steps, measured, q)
        add_weight_below(self.steps, q, gravity_H, below)
        hanging = -self._peg_mass * np.array([*turned_to_peg(q, gravity_H), 0.0, 0.0, 0.0])
        return measured - np.linalg.solve(self.matrix, hanging - below)


@compiled
def reduce_wrench(
    steps: ReductionSteps,
    measured: np.ndarray,
    q: np.ndarray,
    gravity: tuple[float, float, float],
    out: np.ndarray,
) -> None:
    """
    Fill in the wrench on the peg about its mass centre, peg axes.

    Parameters
    ----------
    steps : ReductionSteps
    measured : ndarray, shape (6,)
        As received [N], [N m]; changed.
    q : ndarray, shape (3,)
        gamma, psi, phi [rad].
    gravity : tuple of 3 float
        In the hole axes of q [m/s^2].
    out : ndarray, shape (6,)

    """
    turn_to_sensor(steps, measured, q)
    for i in range(6):
        out[i] = 0.0
        for j in range(6):
            out[i] += steps.matrix[i, j] * (measured[j] - steps.tare[j])
    add_weight_below(steps, q, gravity, out)


@compiled
def note_payload(stated: Accuracies, q: np.ndarray, gravity: tuple[float, float, float]) -> None:
    """Note what the payload weighs in peg axes."""
    if stated.payload_kg > 0.0:
        x, y, z = turned_to_peg(q, gravity)
        mass = stated.payload_kg
        stated.weight[0], stated.weight[1], stated.weight[2] = mass * x, mass * y, mass * z


@compiled
def note_load(
    stated: Accuracies,
    steps: ReductionSteps,
    measured: np.ndarray,
    variance: np.ndarray,
    since: float,
) -> None:
    """
    Note what the sensor carries, and by how much it lags behind the load.

    A first-order low-pass lags by its time constant times the rate of what comes out of it.

    Parameters
    ----------
    stated : Accuracies
        Changed.
    steps : ReductionSteps
    measured : ndarray, shape (6,)
        What `reduce_wrench` has left of a reading.
    variance : ndarray, shape (6,)
        Of the noise of a reading.
    since : float
        The last wrench [s].

    """
    for i in range(6):
        load = measured[i] - steps.tare[i]
        change = load - stated.load[i]
        # Two readings have noise; a change of less than so many deviations may be that alone.
        surely = change * change - LOW_PASS_LAG.deviations**2 * 2.0 * variance[i]
        stated.behind[i] = 0.0
        if stated.lag > 0.0 and since > 0.0 and surely > 0.0:
            stated.behind[i] = copysign(sqrt(surely), change) * stated.lag / since
        stated.load[i] = load


@compiled
def turn_to_sensor(steps: ReductionSteps, measured: np.ndarray, q: np.ndarray) -> None:
    """Turn a wrench as received, in place, to that on the peg in sensor axes, before the tare."""
    for i in range(6):
        measured[i] *= steps.sign
    if not steps.in_base:
        return
    for part in (measured[:3], measured[3:]):
        v = turned_to_peg(q, _times(steps.base_in_hole, (part[0], part[1], part[2])))
        part[0], part[1], part[2] = _times(steps.peg_in_sensor, v)


@compiled
def add_weight_below(
    steps: ReductionSteps, q: np.ndarray, gravity: tuple[float, float, float], out: np.ndarray
) -> None:
    """Add the payload's weight that the sensor carries, or the peg's that it lacks, (6,)."""
    if steps.mass == 0.0:
        return
    x, y, z = turned_to_peg(q, gravity)
    weight = (steps.mass * x, steps.mass * y, steps.mass * z)
    moment = _times(steps.arm, weight)
    for i in range(3):
        out[i] += weight[i]
        out[TORQUE + i] += moment[i]


@compiled
def turned_to_peg(q: np.ndarray, v: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return a vector in hole axes as it is in peg axes, by gamma, psi, phi [rad]."""
    return in_peg_axes(peg_turns(q[0], q[1], q[2]), v)


@compiled
def _times(M, v):
    return (
        M[0, 0] * v[0] + M[0, 1] * v[1] + M[0, 2] * v[2],
        M[1, 0] * v[0] + M[1, 1] * v[1] + M[1, 2] * v[2],
        M[2, 0] * v[0] + M[2, 1] * v[1] + M[2, 2] * v[2],
    )
