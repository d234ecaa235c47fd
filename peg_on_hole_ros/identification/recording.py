"""A recording as arrays, and the parts of it in which three contacts slide steadily."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.identification.tuned import STEADY_SLIDING
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.geometry import contact_geometry, velocity_jacobians
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample


class Recording(NamedTuple):
    """
    Wrenches and orientations in the order of their stamps, none repeated.

    Attributes
    ----------
    wrench_t, joint_t : ndarray, shape (n,), (m,)
        Stamps since the first of them [s].
    wrench : ndarray, shape (n, 6)
        As received: force and torque at the sensor, in the axes of `wrench.axes` [N], [N m].
    q : ndarray, shape (m, 3)
        gamma, psi, phi, the latter two without jumps by turns [rad].
    covariance : ndarray, shape (m, 3, 3)
        Of q [rad^2].

    """

    wrench_t: np.ndarray
    wrench: np.ndarray
    joint_t: np.ndarray
    q: np.ndarray
    covariance: np.ndarray


class FittedMotion(NamedTuple):
    """
    What local parabolas through the angles say, one for each joint state.

    Attributes
    ----------
    q, rates, accelerations : ndarray, shape (m, 3)
        [rad], [rad/s], [rad/s^2]
    valid : ndarray of bool, shape (m,)
        False beside a gap, and at both ends.

    """

    q: np.ndarray
    rates: np.ndarray
    accelerations: np.ndarray
    valid: np.ndarray


def recording(wrenches: list[WrenchSample], measurements: list[AngleMeasurement]) -> Recording:
    """Return samples as arrays; of two with one stamp the first stays."""
    wrench_ns, first_w = np.unique(
        np.array([sample.t_ns for sample in wrenches], np.int64), return_index=True
    )
    joint_ns, first_j = np.unique(
        np.array([sample.t_ns for sample in measurements], np.int64), return_index=True
    )
    begin = min(wrench_ns[:1].tolist() + joint_ns[:1].tolist(), default=0)
    wrench = np.array([[*sample.force, *sample.torque] for sample in wrenches], float)
    q = np.array([sample.q for sample in measurements], float).reshape(-1, 3)[first_j]
    q[:, 1:] = np.unwrap(q[:, 1:], axis=0)
    covariance = np.array([sample.covariance for sample in measurements], float)
    return Recording(
        (wrench_ns - begin) * 1e-9,
        wrench.reshape(-1, 6)[first_w],
        (joint_ns - begin) * 1e-9,
        q,
        covariance.reshape(-1, 3, 3)[first_j],
    )


def turned(record: Recording, R_HM: np.ndarray) -> Recording:
    """Return the recording in hole axes, given the axes M of its angles in those, shape (3, 3)."""
    R = np.einsum("ij,jkn->ikn", R_HM, peg_axes(record.q.T))
    psi = np.arctan2(-R[1, 2], -R[0, 2])
    s, c = np.sin(psi), np.cos(psi)
    gamma = np.arctan2(np.hypot(R[0, 2], R[1, 2]), R[2, 2])
    phi = np.arctan2(c * R[1, 0] - s * R[0, 0], c * R[1, 1] - s * R[0, 1])
    q = np.column_stack([gamma, np.unwrap(psi), np.unwrap(phi)])
    by_angle = np.linalg.solve(turning_axes(q), R_HM @ turning_axes(record.q))
    covariance = by_angle @ record.covariance @ np.swapaxes(by_angle, 1, 2)
    return record._replace(q=q, covariance=covariance)


def angles_at_wrenches(record: Recording, t: np.ndarray) -> np.ndarray:
    """Return gamma, psi, phi at the wrenches, given the times of the angles [s], shape (3, n)."""
    return np.array([np.interp(record.wrench_t, t, angle) for angle in record.q.T])


def in_sensor_axes(record: Recording, configuration: Configuration) -> np.ndarray:
    """Return wrenches as the sensor reads them, whatever axes the numbers are in, (n, 6)."""
    options, joints = configuration.wrench, configuration.joints
    if options.base_rpy is None:
        return record.wrench
    steps = WrenchReduction(options, configuration.scene, joints.hole_rpy).steps
    q = angles_at_wrenches(record, record.joint_t - joints.delay)
    R_SB = np.einsum("ij,kjn,kl->nil", steps.peg_in_sensor, peg_axes(q), steps.base_in_hole)
    parts = record.wrench[:, :3], record.wrench[:, 3:]
    return np.hstack([np.einsum("nij,nj->ni", R_SB, part) for part in parts])


def turning_axes(q: np.ndarray) -> np.ndarray:
    """Return the axes about which gamma, psi and phi turn, as columns, shape (m, 3, 3)."""
    (g, psi), zero = q.T[:2], np.zeros(len(q))
    s, c = np.sin(psi), np.cos(psi)
    eps, z = (s, -c, zero), (zero, zero, zero + 1.0)
    zeta = (-c * np.sin(g), -s * np.sin(g), np.cos(g))
    return np.array([eps, z, zeta]).transpose(2, 1, 0)


def smoothed(record: Recording, width: float) -> Recording:
    """
    Return the recording with the mean of the wrench over a width [s], centred.

    White noise keeps its weight in every slower motion, and loses what differs from sample to
    sample: with that the likelihood of a delay jumps with how samples and steps happen to lie.
    """
    count = 2 * round(width / np.median(np.diff(record.wrench_t)) / 2) + 1
    return record._replace(wrench=_averaged(record.wrench, np.hanning(count + 2)[1:-1]))


def _averaged(rows, weights):
    """Return the centred mean of rows over an odd number of them; ends are taken to go on."""
    half = len(weights) // 2
    padded = np.pad(rows, ((half, half), (0, 0)), mode="edge")
    columns = (np.convolve(column, weights / weights.sum(), "valid") for column in padded.T)
    return np.column_stack(list(columns))


def denoised(record: Recording) -> Recording:
    """Return the recording with most of the noise of wrench and angles smoothed away."""
    return smoothed(record, STEADY_SLIDING.quiet_width)._replace(q=motion(record).q)


def motion(record: Recording) -> FittedMotion:
    """Return angles and rates by local parabolas."""
    m, width = len(record.joint_t), 2 * STEADY_SLIDING.half_window + 1
    q, valid = record.q.copy(), np.zeros(m, bool)
    rates, accelerations = np.zeros((2, m, 3))
    if m <= width:
        return FittedMotion(q, rates, accelerations, valid)
    middle = slice(STEADY_SLIDING.half_window, m - STEADY_SLIDING.half_window)
    t = np.lib.stride_tricks.sliding_window_view(record.joint_t, width)
    t = t - record.joint_t[middle, None]
    windows = np.lib.stride_tricks.sliding_window_view(record.q, width, axis=0)
    # Scaled to the window: powers of milliseconds would cost half the digits.
    span = np.maximum(np.abs(t).max(axis=1, keepdims=True), 1e-9)
    A = (t / span)[..., None] ** np.arange(3)
    fit = np.linalg.pinv(A) @ np.swapaxes(windows, 1, 2)
    q[middle], rates[middle] = fit[:, 0], fit[:, 1] / span
    accelerations[middle] = 2.0 * fit[:, 2] / span**2
    period = np.median(np.diff(record.joint_t))
    valid[middle] = np.diff(t, axis=1).max(axis=1) < STEADY_SLIDING.gap_periods * period
    return FittedMotion(q, rates, accelerations, valid)


def load(record: Recording, moved: FittedMotion, configuration: Configuration) -> np.ndarray:
    """Return the size of the force that the rim carries at each joint state [N], shape (m,)."""
    scene, options = configuration.scene, configuration.wrench
    reduction = WrenchReduction(options, scene)
    force = in_sensor_axes(record, configuration)[:, :3] * reduction.sign - reduction.tare[:3]
    smooth = _averaged(force, np.ones(2 * (STEADY_SLIDING.half_window // 2) + 1))
    t = record.joint_t - configuration.joints.delay
    at = np.array([np.interp(t, record.wrench_t, column) for column in smooth.T])
    weight = (scene.peg_mass + options.payload_mass) * np.array(scene.gravity)
    weight_P = np.einsum("ijk,i->jk", peg_axes(moved.q.T), weight)
    return np.linalg.norm(reduction.matrix[:3, :3] @ at + weight_P, axis=0)


def slow_slip(configuration: Configuration) -> float:
    """Return the slip speed below which a contact may stick [m/s]."""
    return STEADY_SLIDING.slow_slip * configuration.scene.hole_diameter


class Conditions(NamedTuple):
    """
    What makes a joint state one of steady sliding on three contacts.

    Attributes
    ----------
    q : ndarray, shape (m, 3)
        Angles, smoothed [rad].
    valid, tilted, loaded, sliding : ndarray of bool, shape (m,)
        Beside no gap of angles or wrench; above gamma0; pressed on the rim; all three contacts
        slip.
    force : ndarray, shape (m,)
        What the rim carries [N].
    slip : ndarray, shape (m,)
        Of the slowest contact [m/s].

    """

    q: np.ndarray
    valid: np.ndarray
    tilted: np.ndarray
    loaded: np.ndarray
    sliding: np.ndarray
    force: np.ndarray
    slip: np.ndarray


def conditions(
    record: Recording, configuration: Configuration, nearest: float | None = None
) -> Conditions:
    """
    Return which conditions of steady sliding each joint state meets.

    None: `STEADY_SLIDING.nearest_tilt`.

    Judged from the angles, and from how much force the rim carries: friction, biases and noise
    need not be known.
    """
    moved, scene = motion(record), configuration.scene
    gamma, nearest = moved.q[:, 0], nearest or STEADY_SLIDING.nearest_tilt
    tilted = (gamma > nearest * scene.gamma0) & (gamma < STEADY_SLIDING.steepest_tilt)
    valid = moved.valid & _beside_wrenches(record, configuration.joints.delay)
    chosen = valid & tilted
    force = load(record, moved, configuration)
    quantile = STEADY_SLIDING.strong_quantile
    strong = np.quantile(force[chosen], quantile) if chosen.any() else 0.0
    least = STEADY_SLIDING.load_share * strong
    loaded = force > max(configuration.monitor.contact_force_threshold, least)
    gamma = np.where(chosen, gamma, 1.1 * scene.gamma0)
    geometry = contact_geometry(scene, gamma)
    jacobians = velocity_jacobians(geometry, scene.peg_diameter, scene.hole_diameter)
    velocity = np.einsum("cir...,r...->ci...", jacobians, moved.rates.T)
    slip = np.linalg.norm(velocity, axis=1).min(axis=0)
    sliding = slip >= slow_slip(configuration)
    return Conditions(moved.q, valid, tilted, loaded, sliding, force, slip)


def _beside_wrenches(record, delay):
    """Return which joint states have a wrench near: none is held over a silence, shape (m,)."""
    t, wrench_t = record.joint_t - delay, record.wrench_t
    after = np.searchsorted(wrench_t, t)
    since = t - wrench_t[np.maximum(after - 1, 0)]
    until = wrench_t[np.minimum(after, len(wrench_t) - 1)] - t
    # Before the first and after the last wrench both are to the same one.
    nearest = np.minimum(np.abs(since), np.abs(until))
    return nearest < 0.5 * STEADY_SLIDING.gap_periods * np.median(np.diff(wrench_t))


def steady(
    record: Recording, configuration: Configuration, nearest: float | None = None
) -> list[slice]:
    """Return the joint states in which three contacts slide steadily; see `conditions`."""
    _, valid, tilted, loaded, sliding, *_ = conditions(record, configuration, nearest)
    # Touch-down and lift-off shake the peg, so what lies near them goes too.
    chosen = ~_near(record.joint_t, ~(valid & tilted & loaded & sliding))
    edges = np.flatnonzero(np.diff(np.concatenate([[0], chosen.astype(int), [0]])))
    parts = [slice(a, b) for a, b in zip(edges[::2].tolist(), edges[1::2].tolist())]
    return [part for part in parts if part.stop - part.start >= STEADY_SLIDING.shortest_part]


def shortfall(record: Recording, configuration: Configuration) -> str:
    """Return what a recording has of steady sliding, and what to record instead."""
    found, scene = conditions(record, configuration), configuration.scene
    total, usable = len(record.joint_t), found.valid
    said = [f"Of {total} joint states {usable.sum()} have no gap beside them"]
    usable = usable & found.tilted
    said.append(f"{usable.sum()} of these tilted by more than gamma0 ({scene.gamma0:.3g} rad)")
    usable = usable & found.loaded
    said.append(f"{usable.sum()} of these pressed on the rim")
    slow = slow_slip(configuration)
    if usable.any():
        said[-1] += f" (median {np.median(found.force[usable]):.3g} N)"
        median = 1e3 * np.median(found.slip[usable])
        said.append(
            f"{(usable & found.sliding).sum()} of these with all contacts faster than "
            f"{1e3 * slow:.3g} mm/s (median of the slowest {median:.3g} mm/s)"
        )
    rate = STEADY_SLIDING.ample * slow / (0.5 * scene.hole_diameter)
    return (
        "record a peg that is pressed on the rim, tilted, and turned about its axis by "
        f"{rate:.2g} rad/s and more, for half a second and more without a stop; scene, wrench and "
        f"joints have to be those of the recording. {', '.join(said)}"
    )


def _near(t, marked):
    marks = t[marked]
    if not marks.size:
        return np.zeros(len(t), bool)
    after = np.searchsorted(marks, t - STEADY_SLIDING.rest)
    return (after < marks.size) & (
        marks[np.minimum(after, marks.size - 1)] <= t + STEADY_SLIDING.rest
    )
