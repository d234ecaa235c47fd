"""From samples as received to measurements: the wrench on the peg, and its orientation."""

from collections.abc import Sequence
from math import atan2, copysign, cos, hypot, isfinite, pi, sin, sqrt

import numpy as np

from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.estimator.offsets import Offsets
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.record_types import ReductionRecord
from peg_on_hole_ros.records import AngleMeasurement, JointSample, WrenchSample

# Below this the two rotations about the axes are one for every sensor; the floor keeps the
# covariance of psi and phi finite (sigma / 1e-6 is thousands of turns).
SMALLEST_SINE = 1e-6
# The size of a force [N], and of a torque [N m], that no sensor in a cell measures: bytes or
# units of a driver that are wrong.
MOST_FORCE = MOST_TORQUE = 1e6
# psi or phi of a joint that counts its turns [rad]: beyond, a double is as coarse as an encoder.
MOST_TURNED = 1e6


def wrench_fault(sample: WrenchSample) -> str | None:
    """
    Return what is wrong with a wrench as received; None: nothing.

    Returns
    -------
    str or None
        `not_finite`, or `out_of_range`: a force above MOST_FORCE or a torque above MOST_TORQUE.

    """
    (f_x, f_y, f_z), (m_x, m_y, m_z) = sample.force, sample.torque
    # Neither holds for a NaN.
    if (
        f_x * f_x + f_y * f_y + f_z * f_z <= MOST_FORCE * MOST_FORCE
        and m_x * m_x + m_y * m_y + m_z * m_z <= MOST_TORQUE * MOST_TORQUE
    ):
        return None
    finite = all(map(isfinite, (*sample.force, *sample.torque)))
    return "out_of_range" if finite else "not_finite"


def sound_wrenches(values: np.ndarray) -> np.ndarray:
    """Return of which wrenches (n, 6) `wrench_fault` says nothing, shape (n,)."""
    f_x, f_y, f_z, m_x, m_y, m_z = values.T
    # Neither holds for a NaN.
    with np.errstate(over="ignore", invalid="ignore"):
        return (f_x * f_x + f_y * f_y + f_z * f_z <= MOST_FORCE * MOST_FORCE) & (
            m_x * m_x + m_y * m_y + m_z * m_z <= MOST_TORQUE * MOST_TORQUE
        )


def rotation_from_rpy(rpy: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return Rz(yaw) Ry(pitch) Rx(roll), shape (3, 3), from roll, pitch, yaw [rad]."""
    r, p, y = rpy
    cr, sr, cp, sp, cy, sy = cos(r), sin(r), cos(p), sin(p), cos(y), sin(y)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def skew(r: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the matrix of r x, shape (3, 3)."""
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]], float)


def tilt_axes(tilt: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return R_SH, axes of a hole turned by a small (x, y) [rad] in its own axes at the start."""
    angle = float(np.hypot(*tilt))
    K = skew([*tilt, 0.0])
    return np.eye(3) + np.sinc(angle / np.pi) * K + 0.5 * np.sinc(angle / 2 / np.pi) ** 2 * K @ K


def noise_of(options: WrenchInput) -> tuple[float, float]:
    """Return the noise that is stated of forces and of torques [N], [N m]."""
    return options.force_stddev, options.torque_stddev


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
        Hole axes in the base [rad], for a wrench in the base's axes.

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
        steps = np.zeros(1, REDUCTION)[0]
        self.tare = steps["tare"]
        self._stated = self.sign * np.array([*options.bias_force, *options.bias_torque])
        self.tare[:] = self._stated
        payload_P = np.array(options.sensor_xyz) + R_PS @ np.array(options.payload_com)
        mass, arm = float(options.payload_mass), skew(payload_P - center_P)
        if options.gravity == "compensated":
            # A controller that takes the weight off leaves none of the payload, nor of the peg.
            mass, arm = -scene.peg_mass, np.zeros((3, 3))
        steps["sign"], steps["in_base"] = self.sign, options.axes == "base"
        steps["base_in_hole"], steps["peg_in_sensor"] = rotation_from_rpy(hole_rpy).T, R_PS.T
        steps["matrix"], steps["mass"], steps["arm"] = self.matrix, mass, arm
        self.steps = steps
        self._peg_mass = scene.peg_mass
        self._gravity_H = np.array(scene.gravity, float)

    def take_noise(self, options: WrenchInput) -> None:
        """Take the noise that is stated."""
        stddev = [options.force_stddev] * 3 + [options.torque_stddev] * 3
        self.noise = np.square(stddev)
        self.covariance = self.matrix @ np.diag(self.noise) @ self.matrix.T

    def offsets(self, configuration: Configuration) -> Offsets:
        """Return what is not known of the sensor's zero and of the hole's direction."""
        wrench, options = configuration.wrench, configuration.filter
        stddev = [wrench.bias_force_stddev] * 3 + [wrench.bias_torque_stddev] * 3
        stddev += [configuration.joints.hole_tilt_stddev] * 2
        drift = [wrench.bias_force_drift] * 3 + [wrench.bias_torque_drift] * 3
        return Offsets(
            np.square(stddev),
            -self.sign * self.matrix,
            np.array(drift),
            options.wrench_bias == "estimated",
            options.hole_tilt == "estimated",
            configuration.joints.delay_stddev,
        )

    @property
    def stated(self) -> np.ndarray:
        """The `tare` that the configured bias is, shape (6,) [N], [N m]."""
        return self._stated

    @property
    def taken_off(self) -> np.ndarray:
        """What is taken off, as the sensor reports it: tare or configured bias, shape (6,)."""
        return self.sign * self.tare

    def in_sensor(self, q: np.ndarray, gravity_H: np.ndarray) -> np.ndarray:
        """Return gravity of the hole's axes in those of the sensor, shape (3,) [m/s^2]."""
        gravity_H = self._gravity_H if gravity_H is None else gravity_H
        return self.steps["peg_in_sensor"] @ peg_axes(q).T @ gravity_H

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
        Take a wrench as that of a peg which hangs free.

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
        in_sensor(self.steps, measured, q)
        add_weight_below(self.steps, q, gravity_H, below)
        hanging = -self._peg_mass * np.array([*turned_to_peg(q, gravity_H), 0.0, 0.0, 0.0])
        return measured - np.linalg.solve(self.matrix, hanging - below)


# The steps of a `WrenchReduction` for compiled code.
REDUCTION = np.dtype(
    [
        ("sign", float),
        ("in_base", np.int64),
        ("base_in_hole", float, (3, 3)),
        ("peg_in_sensor", float, (3, 3)),
        ("tare", float, (6,)),
        ("matrix", float, (6, 6)),
        # Mass whose weight the sensor carries and the peg does not [kg], and its arm; below zero
        # the peg's own, which a controller has taken off.
        ("mass", float),
        ("arm", float, (3, 3)),
    ]
)


@compiled
def reduce_wrench(
    steps: ReductionRecord,
    measured: np.ndarray,
    q: np.ndarray,
    gravity: tuple[float, float, float],
    out: np.ndarray,
) -> None:
    """
    Fill in the wrench on the peg about its mass centre, peg axes.

    Parameters
    ----------
    steps : record of REDUCTION
    measured : ndarray, shape (6,)
        As received [N], [N m]; changed.
    q : ndarray, shape (3,)
        gamma, psi, phi [rad].
    gravity : tuple of 3 float
        In the hole axes of q [m/s^2].
    out : ndarray, shape (6,)

    """
    in_sensor(steps, measured, q)
    for i in range(6):
        out[i] = 0.0
        for j in range(6):
            out[i] += steps.matrix[i, j] * (measured[j] - steps.tare[j])
    add_weight_below(steps, q, gravity, out)


@compiled
def in_sensor(steps: ReductionRecord, measured: np.ndarray, q: np.ndarray) -> None:
    """Turn a wrench as received to that on the peg side, sensor axes, before the tare, (6,)."""
    for i in range(6):
        measured[i] *= steps.sign
    if not steps.in_base:
        return
    for part in (measured[:3], measured[3:]):
        v = turned_to_peg(q, _times(steps.base_in_hole, (part[0], part[1], part[2])))
        part[0], part[1], part[2] = _times(steps.peg_in_sensor, v)


@compiled
def add_weight_below(
    steps: ReductionRecord, q: np.ndarray, gravity: tuple[float, float, float], out: np.ndarray
) -> None:
    """Add what the sensor carries of the payload's weight, or lacks of the peg's, (6,)."""
    if steps.mass == 0.0:
        return
    x, y, z = turned_to_peg(q, gravity)
    weight = (steps.mass * x, steps.mass * y, steps.mass * z)
    moment = _times(steps.arm, weight)
    for i in range(3):
        out[i] += weight[i]
        out[3 + i] += moment[i]


@compiled
def turned_to_peg(q: np.ndarray, v: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return a vector in hole axes as it is in peg axes, by gamma, psi, phi [rad]."""
    c, s = cos(q[1]), sin(q[1])
    x, y, z = c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]
    c, s = cos(q[0]), sin(q[0])
    x, z = c * x + s * z, c * z - s * x
    c, s = cos(q[2]), sin(q[2])
    return c * x + s * y, c * y - s * x, z


@compiled
def _times(M, v):
    return (
        M[0, 0] * v[0] + M[0, 1] * v[1] + M[0, 2] * v[2],
        M[1, 0] * v[0] + M[1, 1] * v[1] + M[1, 2] * v[2],
        M[2, 0] * v[0] + M[2, 1] * v[1] + M[2, 2] * v[2],
    )


def angle_covariance(gamma: float, orientation_stddev: float) -> np.ndarray:
    """
    Return the covariance of (gamma, psi, phi) for an isotropic error of the orientation.

    Parameters
    ----------
    gamma : float
        [rad].
    orientation_stddev : float
        Of the rotation vector between true and measured orientation, each component [rad].

    Returns
    -------
    ndarray, shape (3, 3)
        [rad^2]; psi and phi grow like 1/sin(gamma), their sum stays.

    Notes
    -----
    A rotation by (gamma, psi, phi) errors is J = [eps, z, zeta] times them; J.T J has the cosine
    of gamma between psi and phi as its only other entry.

    """
    R = np.empty(9)
    fill_covariance(float(gamma), float(orientation_stddev), R)
    return R.reshape(3, 3)


@compiled
def fill_covariance(gamma: float, orientation_stddev: float, R: np.ndarray) -> None:
    """Fill in what `angle_covariance` returns, by rows, shape (9,)."""
    variance = orientation_stddev * orientation_stddev
    c, sine = cos(gamma), abs(sin(gamma))
    if sine < SMALLEST_SINE:
        # With its cosine: the variance of the sum of psi and phi is what the two leave.
        c, sine = copysign(sqrt(1.0 - SMALLEST_SINE * SMALLEST_SINE), c), SMALLEST_SINE
    over = variance / (sine * sine)
    R[:] = 0.0
    R[0] = variance
    R[4] = R[8] = over
    R[5] = R[7] = -c * over


@compiled
def fill_orientations(angles: np.ndarray, orientation_stddev: float, rows: np.ndarray) -> None:
    """Fill in the rows (n, 24) of an AngleMeasurement without a place, from gamma, psi, phi."""
    for i in range(len(angles)):
        rows[i, :] = np.nan
        for j in range(3):
            rows[i, j] = angles[i, j]
        fill_covariance(angles[i, 0], orientation_stddev, rows[i, 3:12])


def angles_of(rotation: np.ndarray) -> np.ndarray:
    """
    Return gamma, psi, phi of R_HP = Rz(psi) Ry(-gamma) Rz(phi).

    Parameters
    ----------
    rotation : ndarray, shape (3, 3)
        Peg axes in hole axes.

    Returns
    -------
    ndarray, shape (3,)
        gamma in [0, pi], psi and phi in [-pi, pi] [rad].

    Notes
    -----
    gamma comes from an arctangent, as an arccosine loses half the digits near zero. psi is the
    direction in which the axis leans, of little meaning near zero and 0 where it leans nowhere;
    phi is what remains once psi is turned back, so their sum is exact for any psi.

    """
    (xx, xy, xz), (yx, yy, yz), (_, _, zz) = np.asarray(rotation).tolist()
    lean = hypot(xz, yz)
    gamma = atan2(lean, zz)
    psi = atan2(-yz, -xz) if lean else 0.0
    s, c = sin(psi), cos(psi)
    return np.array([gamma, psi, atan2(c * yx - s * xx, c * yy - s * xy)])


class NamedPositions:
    """
    Picks the positions of some joints out of joint states, in any order, among others.

    Parameters
    ----------
    names : tuple of str

    """

    def __init__(self, names: tuple[str, ...]) -> None:
        self.names = names
        self._order: tuple[str, ...] | None = None
        self._index: list[int] | None = None

    def __call__(self, sample: JointSample) -> list[float] | str:
        """Return the positions in the order of the names, or `missing_joint`, `not_finite`."""
        if sample.names != self._order:
            self._order = sample.names
            known = {name: i for i, name in reversed(list(enumerate(sample.names)))}
            complete = all(name in known for name in self.names)
            self._index = [known[name] for name in self.names] if complete else None
        if self._index is None:
            return "missing_joint"
        every = sample.position
        position = [every[i] for i in self._index]
        return position if all(map(isfinite, position)) else "not_finite"


class PegJoints:
    """
    The peg's own joints as orientation: gamma, psi, phi by name, in any order, among others.

    Calling it with a JointSample returns an AngleMeasurement, or a reason why there is none.
    """

    def __init__(self, options: JointInput) -> None:
        self.stddev = options.position_stddev
        self._positions = NamedPositions(options.names)
        self._R_HM = rotation_from_rpy(options.hole_rpy).T if any(options.hole_rpy) else None

    def rows(self, names: tuple[str, ...], positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return the measurements of joint states of one order, as far as they need no second look.

        Parameters
        ----------
        names : tuple of str
            Of the joints.
        positions : ndarray, shape (n, len(names))
            [rad].

        Returns
        -------
        sound : ndarray of bool, shape (n,)
            Whether there is a row; the others are to be given as samples.
        rows : ndarray, shape (n, 24)
            See `AngleMeasurement.row`.

        """
        rows = np.full((len(positions), 24), np.nan)
        if self._R_HM is not None or not set(self._positions.names) <= set(names):
            return np.zeros(len(positions), bool), rows
        angles = positions[:, [names.index(name) for name in self._positions.names]]
        sound = (angles[:, 0] >= 0.0) & (angles[:, 0] < pi / 2)
        sound &= (np.abs(angles[:, 1:]) <= MOST_TURNED).all(axis=1)
        fill_orientations(angles, float(self.stddev), rows)
        return sound, rows

    def __call__(self, sample: JointSample) -> AngleMeasurement | str:
        """
        Return the measurement, or the reason why there is none.

        Returns
        -------
        AngleMeasurement or str
            `missing_joint`, `not_finite`, or `out_of_range`: tilted by a quarter turn or more, or
            turned by more than MOST_TURNED. A tilt below zero is one to the other side.

        """
        position = self._positions(sample)
        if isinstance(position, str):
            return position
        gamma, psi, phi = position
        if not (abs(gamma) < pi and abs(psi) <= MOST_TURNED and abs(phi) <= MOST_TURNED):
            return "out_of_range"
        if self._R_HM is not None:
            gamma, psi, phi = angles_of(self._R_HM @ peg_axes(position))
        if gamma < 0.0:
            # The same orientation, leaning to the other side.
            gamma, psi, phi = -gamma, psi + pi, phi - pi
        if not gamma < pi / 2:
            return "out_of_range"
        covariance = angle_covariance(gamma, self.stddev)
        return AngleMeasurement(sample.t_ns, np.array([gamma, psi, phi], float), covariance)
