"""Likelihood of a recording: the innovations of the contact filter under given parameters."""

from dataclasses import replace
from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.filter import ContactFilter, Prediction
from peg_on_hole_ros.estimation.measurement import WrenchReduction
from peg_on_hole_ros.estimation.recording import Recording
from peg_on_hole_ros.options import Configuration

# A part begins with a parabola through so many joint states, which are not used again.
START = 16
# So many more go before the first that counts: what the start's error costs has then faded.
SETTLE = 8
# Integration step [s]: with longer ones the likelihood jumps with where the steps lie.
STEP = 2.5e-4
LOST = np.array([8.0, 0.0, 0.0])
MOST_LOST = 0.1


class Quantity(NamedTuple):
    """
    One parameter that enters the innovations.

    Attributes
    ----------
    name, unit : str
    step : float
        For differences; far below what a recording can tell, far above rounding.
    range : float
        How far from the start the truth may lie, as a standard deviation.
    useful : float
        A standard deviation above this tells a cell nothing.

    """

    name: str
    unit: str
    step: float
    range: float
    useful: float


# The delay's step is a usual period of the wrench: a shift by less changes where the steps of the
# integration lie, which is worth more to the likelihood than the shift.
QUANTITIES = (
    Quantity("friction", "", 1e-4, 0.5, 0.05),
    *(Quantity(f"bias_force_{axis}", "N", 2e-3, 20.0, 1.0) for axis in "xyz"),
    *(Quantity(f"bias_torque_{axis}", "N m", 1e-4, 1.0, 0.05) for axis in "xyz"),
    *(Quantity(f"tilt_{axis}", "rad", 2e-4, 0.05, 0.01) for axis in "xy"),
    Quantity("delay", "s", 1e-3, 0.01, 0.003),
    Quantity("clearance", "m", 1e-7, 2e-5, 8e-6),
)
NAMES = tuple(quantity.name for quantity in QUANTITIES)


def tilt_axes(gravity) -> tuple[np.ndarray, np.ndarray]:
    """Return two axes across a direction; for gravity along the hole's axis these are x and y."""
    down = np.asarray(gravity, float) / np.linalg.norm(gravity)
    first = np.eye(3)[int(np.argmin(np.abs(down) + [0.0, 1e-9, 2e-9]))]
    first = first - down * (down @ first)
    first /= np.linalg.norm(first)
    return first, np.cross(-down, first)


def start_values(configuration: Configuration) -> np.ndarray:
    """Return the values of QUANTITIES in a configuration; a tilt is from its gravity, so 0."""
    scene, wrench = configuration.scene, configuration.wrench
    clearance = scene.hole_diameter - scene.peg_diameter
    bias = [*wrench.bias_force, *wrench.bias_torque]
    return np.array(
        [scene.friction, *bias, 0.0, 0.0, configuration.joints.delay, clearance], float
    )


def configured(start: Configuration, values) -> Configuration:
    """Return a configuration with the values of QUANTITIES put in."""
    value = dict(zip(NAMES, map(float, values)))
    g = np.array(start.scene.gravity)
    size = np.linalg.norm(g)
    if size and (value["tilt_x"] or value["tilt_y"]):
        x, y = tilt_axes(g)
        g = g / size + value["tilt_x"] * x + value["tilt_y"] * y
        g *= size / np.linalg.norm(g)
    scene = replace(
        start.scene,
        friction=value["friction"],
        gravity=tuple(g.tolist()),
        peg_diameter=start.scene.hole_diameter - value["clearance"],
    )
    wrench = replace(
        start.wrench,
        bias_force=tuple(value[f"bias_force_{axis}"] for axis in "xyz"),
        bias_torque=tuple(value[f"bias_torque_{axis}"] for axis in "xyz"),
    )
    joints = replace(start.joints, delay=value["delay"])
    return replace(start, scene=scene, wrench=wrench, joints=joints)


class Innovations(NamedTuple):
    """
    Innovations of the filter with the roots of their covariances.

    Attributes
    ----------
    whitened : ndarray, shape (n, 3)
        Standard normal if all is right.
    residual : ndarray, shape (n, 3)
        [rad]
    root : ndarray, shape (n, 3, 3)
        Lower root of the covariance [rad].

    """

    whitened: np.ndarray
    residual: np.ndarray
    root: np.ndarray

    @property
    def nis(self) -> np.ndarray:
        """Normalised innovations squared, 3 degrees of freedom, shape (n,)."""
        return (self.whitened**2).sum(axis=1)

    def against(self, root) -> "Innovations":
        """Return the innovations whitened by other roots."""
        return Innovations(_whitened(self.residual, root), self.residual, root)


def _whitened(residual, root):
    return np.linalg.solve(root, residual[:, :, None])[:, :, 0]


def innovations(record: Recording, parts: list[slice], configuration: Configuration):
    """
    Run the contact filter over parts of a recording, each on its own.

    Where the equations give no motion, the filter goes on at constant rates; what it says there
    is of another model, and the innovations count as if they were far off. Returns None where that
    is so for more than MOST_LOST of them, or where they are not finite.
    """
    # Nothing is widened or gated here: either would hide what a wrong parameter does.
    options = replace(
        configuration.filter,
        inflation_threshold=inf,
        gate_threshold=inf,
        max_step=min(configuration.filter.max_step, STEP),
    )
    # Nor learnt: the values given are those in question.
    scene = replace(configuration.scene, friction_stddev=0.0, clearance_stddev=0.0)
    reduction = WrenchReduction(configuration.wrench, scene)
    kalman = ContactFilter(scene, options, reduction.covariance)
    # A wrench is held around its stamp, not up to it: that would look like a delay.
    half = 0.5 * float(np.median(np.diff(record.wrench_t)))
    record = record._replace(wrench_t=record.wrench_t + half)
    joint_t = record.joint_t - configuration.joints.delay
    residuals, roots, lost = [], [], []
    for part in parts:
        if not _run(record, joint_t, part, reduction, kalman, residuals, roots, lost):
            return None
    if sum(lost) > MOST_LOST * len(lost):
        return None
    residual, root = np.array(residuals), np.array(roots).reshape(-1, 3, 3)
    at = np.flatnonzero(lost)
    residual[at] = root[at] @ LOST
    return Innovations(_whitened(residual, root), residual, root)


def _run(record, joint_t, part, reduction, kalman, residuals, roots, lost):
    first = part.start + START
    now = joint_t[first - 1]
    _begin(kalman, record, joint_t, slice(part.start, first))
    times = joint_t[first : part.stop].tolist()
    waiting = list(zip(times, record.q[first : part.stop], record.covariance[first : part.stop]))
    i, settled, lost_to = 0, SETTLE, -1
    from_wrench = int(np.searchsorted(record.wrench_t, now, side="right"))
    for k in range(from_wrench, len(record.wrench_t)):
        t = record.wrench_t.item(k)
        row = record.wrench[k]
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
    return True


def _begin(kalman, record, joint_t, chosen):
    """Start from a parabola through joint states, with the covariance of its end."""
    t = joint_t[chosen] - joint_t[chosen.stop - 1]
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


def log_likelihood(found: Innovations) -> float:
    """Return the logarithm of the likelihood, up to a constant."""
    return float(-0.5 * found.nis.sum() - np.log(np.einsum("nii->ni", found.root)).sum())


def with_noise(configuration: Configuration, force, torque, orientation) -> Configuration:
    """Return a configuration with noise levels [N], [N m], [rad] put in."""
    wrench = replace(configuration.wrench, force_stddev=force, torque_stddev=torque)
    joints = replace(configuration.joints, position_stddev=orientation)
    return replace(configuration, wrench=wrench, joints=joints)
