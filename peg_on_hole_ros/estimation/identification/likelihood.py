"""Likelihood of a recording: the innovations of the contact filter under given parameters."""

from dataclasses import replace
from math import asin, atan2, exp, inf, isfinite, log
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.filters.contact import ContactFilter, Prediction
from peg_on_hole_ros.estimation.identification.recording import Recording, turned, turning_axes
from peg_on_hole_ros.estimation.measurement import WrenchReduction, rotation_from_rpy, tilt_axes
from peg_on_hole_ros.options import Configuration

# A part begins with a parabola through so many joint states, which are not used again.
START = 16
# So many more go before the first that counts: what the start's error costs has then faded.
SETTLE = 8
# Integration step [s]: with longer ones the likelihood jumps with where the steps lie.
STEP = 2.5e-4
# Where the equations give no motion the filter runs on another model; an innovation there counts
# as this far off in one direction.
LOST = np.array([8.0, 0.0, 0.0])


class Quantity(NamedTuple):
    """
    One parameter that enters the innovations.

    Attributes
    ----------
    name, unit : str
    step : float
        For differences; far above rounding.
    range : float
        How far from the start the truth may lie, as a standard deviation.
    useful : float
        A standard deviation above this tells a cell nothing.
    log : bool
        The search is in its logarithm: step, range and useful are shares.

    Those of forces and torques are for a peg that is pressed by TYPICAL_FORCE into a hole of
    TYPICAL_DIAMETER, see `measures`.

    """

    name: str
    unit: str
    step: float
    range: float
    useful: float
    log: bool = False


# The delay's step is some periods of the wrench: within one, where the steps of the integration
# lie is worth as much as the shift.
QUANTITIES = (
    Quantity("friction", "", 1e-4, 0.5, 0.05),
    *(Quantity(f"bias_force_{axis}", "N", 2e-3, 20.0, 1.0) for axis in "xyz"),
    *(Quantity(f"bias_torque_{axis}", "N m", 1e-4, 1.0, 0.05) for axis in "xyz"),
    *(Quantity(f"tilt_{axis}", "rad", 5e-4, 0.05, 0.01) for axis in "xy"),
    Quantity("delay", "s", 4e-3, 0.02, 0.003),
    Quantity("clearance", "m", 1e-3, 0.3, 0.08, True),
    Quantity("force_stddev", "N", 0.02, 1.5, 0.3, True),
    Quantity("torque_stddev", "N m", 0.02, 1.5, 0.3, True),
    Quantity("position_stddev", "rad", 0.02, 1.5, 0.3, True),
)
NAMES = tuple(quantity.name for quantity in QUANTITIES)
# What moves the peg, and what scatters the sensors.
IS_NOISE = np.array([name.endswith("stddev") for name in NAMES])
IS_FORCE = np.array([name.startswith("bias_force") for name in NAMES])
IS_TORQUE = np.array([name.startswith("bias_torque") for name in NAMES])
# What steps, ranges and uses of forces and torques are stated for [N], [m].
TYPICAL_FORCE, TYPICAL_DIAMETER = 25.0, 0.05
FRICTION, BIAS, TILT, DELAY, CLEARANCE, NOISE = 0, slice(1, 7), slice(7, 9), 9, 10, slice(11, 14)


class Measures(NamedTuple):
    """
    Steps, ranges and uses of QUANTITIES for one peg under one load; see `Quantity`.

    Attributes
    ----------
    step, range, useful : ndarray, shape (14,)

    """

    step: np.ndarray
    range: np.ndarray
    useful: np.ndarray


def measures(diameter: float, force: float) -> Measures:
    """
    Return what is small, likely and of use for a hole of some diameter [m] and a load [N].

    Whether a bias tells a cell anything is a matter of the load it is beside, and a torque is a
    force at the rim: 0.05 N m, little beside 25 N on a peg of 50 mm, would turn one of 8 mm round.
    """
    rows = np.array([(one.step, one.range, one.useful) for one in QUANTITIES]).T
    rows[:, IS_TORQUE] *= diameter / TYPICAL_DIAMETER
    rows[2, IS_FORCE | IS_TORQUE] *= force / TYPICAL_FORCE
    return Measures(*rows)


def coordinates(configuration: Configuration) -> np.ndarray:
    """Return where the search for QUANTITIES starts, shape (14,); tilts are against the start."""
    scene, wrench, joints = configuration.scene, configuration.wrench, configuration.joints
    x = np.zeros(len(QUANTITIES))
    x[FRICTION], x[DELAY] = scene.friction, joints.delay
    x[BIAS] = *wrench.bias_force, *wrench.bias_torque
    x[CLEARANCE] = log(scene.hole_diameter - scene.peg_diameter)
    x[NOISE] = np.log([wrench.force_stddev, wrench.torque_stddev, joints.position_stddev])
    return x


def natural(quantity: Quantity, coordinate: float) -> float:
    """Return a value from its coordinate in the search."""
    return exp(min(coordinate, 700.0)) if quantity.log else float(coordinate)


def configured(start: Configuration, x) -> Configuration:
    """Return a configuration with coordinates put in."""
    value = [natural(quantity, coordinate) for quantity, coordinate in zip(QUANTITIES, x)]
    force, torque, position = value[NOISE]
    scene = replace(
        start.scene,
        friction=value[FRICTION],
        peg_diameter=start.scene.hole_diameter - value[CLEARANCE],
    )
    wrench = replace(
        start.wrench,
        bias_force=tuple(value[BIAS][:3]),
        bias_torque=tuple(value[BIAS][3:]),
        force_stddev=force,
        torque_stddev=torque,
    )
    joints = replace(start.joints, delay=value[DELAY], position_stddev=position)
    if any(value[TILT]):
        R_SH = tilt_axes(value[TILT])
        scene = replace(scene, gravity=tuple((R_SH.T @ scene.gravity).tolist()))
        R = rotation_from_rpy(joints.hole_rpy) @ R_SH
        rpy = atan2(R[2, 1], R[2, 2]), asin(-R[2, 0]), atan2(R[1, 0], R[0, 0])
        joints = replace(joints, hole_rpy=rpy)
    return replace(start, scene=scene, wrench=wrench, joints=joints)


class Innovations(NamedTuple):
    """
    Innovations of the filter with the roots of their covariances.

    As rotation vectors in the axes of the measured angles: densities of angles that a parameter
    turns are not to be compared.

    Attributes
    ----------
    residual : ndarray, shape (n, 3)
        [rad]
    root : ndarray, shape (n, 3, 3)
        A root of the covariance [rad].
    lost : float
        Share of them where the parameters leave no motion.

    """

    residual: np.ndarray
    root: np.ndarray
    lost: float

    @property
    def nis(self) -> np.ndarray:
        """Normalised innovations squared, 3 degrees of freedom, shape (n,)."""
        return (np.linalg.solve(self.root, self.residual[:, :, None])[:, :, 0] ** 2).sum(axis=1)

    @property
    def log_likelihood(self) -> np.ndarray:
        """Logarithm of the likelihood of each innovation, up to a constant, shape (n,)."""
        return -0.5 * self.nis - np.linalg.slogdet(self.root)[1]


def innovations(record: Recording, parts, start: Configuration, x) -> Innovations | None:
    """
    Run the contact filter over parts of a recording, each on its own.

    Parameters
    ----------
    record : Recording
        Read under the configuration of the start.
    parts : list of slice
        Of its joint states.
    start : Configuration
    x : ndarray, shape (14,)
        From `coordinates`.

    Returns
    -------
    Innovations or None
        None where one is not finite.

    """
    configuration = configured(start, x)
    # Nothing is widened, gated or left to constant rates: that would hide what a wrong parameter
    # does. A cheaper model of the contact, which a configuration may ask for, predicts these.
    options = replace(
        configuration.filter,
        model="dynamic",
        slow_slip=0.0,
        # Reversals tell of a delay; what the wrench did within an interval would hide that.
        wrench_jump=0.0,
        inflation_threshold=inf,
        gate_threshold=inf,
        max_step=min(configuration.filter.max_step, STEP),
    )
    # Nor learnt: the values given are those in question.
    scene = replace(configuration.scene, friction_stddev=0.0, clearance_stddev=0.0)
    reduction = WrenchReduction(configuration.wrench, scene)
    try:
        kalman = ContactFilter(scene, options, reduction.covariance)
    except np.linalg.LinAlgError:
        # A noise of force far below that of torque at its lever, or the reverse.
        return None
    R_SH = tilt_axes(x[TILT])
    if any(x[TILT]):
        record = turned(record, R_SH.T)
    # A wrench is held around its stamp, not up to it: that would look like a delay.
    half = 0.5 * float(np.median(np.diff(record.wrench_t)))
    scale = configuration.joints.position_stddev / start.joints.position_stddev
    record = record._replace(
        wrench_t=record.wrench_t + half,
        joint_t=record.joint_t - configuration.joints.delay,
        covariance=record.covariance * scale**2,
    )
    rows, residuals, roots, lost = [], [], [], []
    for part in parts:
        if not _run(record, part, reduction, kalman, rows, residuals, roots, lost):
            return None
    turn = R_SH @ turning_axes(record.q[rows])
    root = turn @ np.array(roots).reshape(-1, 3, 3)
    residual = np.einsum("nij,nj->ni", turn, residuals)
    at = np.flatnonzero(lost)
    residual[at] = root[at] @ LOST
    return Innovations(residual, root, len(at) / len(lost))


def _run(record, part, reduction, kalman, rows, residuals, roots, lost):
    first = part.start + START
    now = record.joint_t[first - 1]
    _begin(kalman, record, slice(part.start, first))
    times = record.joint_t[first : part.stop].tolist()
    waiting = list(zip(times, record.q[first : part.stop], record.covariance[first : part.stop]))
    i, settled, lost_to = 0, SETTLE, -1
    from_wrench = int(np.searchsorted(record.wrench_t, now, side="right"))
    for k in range(from_wrench, len(record.wrench_t) + 1):
        # A delay may leave joint states after the last wrench, which then holds on.
        t = record.wrench_t.item(k) if k < len(record.wrench_t) else inf
        row = record.wrench[min(k, len(record.wrench_t) - 1)]
        kalman.hold(reduction.on_peg(row[:3], row[3:], kalman.x[:3]))
        while i < len(waiting) and waiting[i][0] <= t:
            at, q, R = waiting[i]
            if at > now:
                if kalman.predict(at - now, True) is not Prediction.CONTACT:
                    lost_to = i + SETTLE
                now = at
            _, nis = kalman.correct(q, R)
            if not isfinite(nis):
                return False
            if i >= settled:
                residual, root = kalman.last_innovation()
                rows.append(first + i)
                residuals.append(residual)
                roots.append(root)
                lost.append(i <= lost_to)
            i += 1
        if i == len(waiting):
            return True
        if t > now:
            if kalman.predict(t - now, True) is not Prediction.CONTACT:
                lost_to = i + SETTLE
            now = t
    return False


def _begin(kalman, record, chosen):
    """Start from a parabola through joint states, with the covariance of its end."""
    t = record.joint_t[chosen] - record.joint_t[chosen.stop - 1]
    span = max(-t[0], 1e-9)
    A = (t / span)[:, None] ** np.arange(3)
    inverse = np.linalg.inv(A.T @ A)
    fit = inverse @ A.T @ record.q[chosen]
    R = record.covariance[chosen].mean(axis=0)
    kalman.start(fit[0], R)
    kalman.x[3:] = fit[1] / span
    scale = np.diag([1.0, 1.0 / span])
    # A parabola is not the motion: what a jerk leaves is counted as three times the noise.
    spread = 9.0 * scale @ inverse[:2, :2] @ scale
    kalman.Z[:6, :6] = np.kron(spread, R)
