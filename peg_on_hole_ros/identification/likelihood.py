"""Likelihood of a recording under given parameters: that of the estimator that runs over it."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.state import FRICTION, OPEN_BEGIN, begin_state, places_of
from peg_on_hole_ros.identification.accumulate import (
    BEGIN,
    ORIENTATION,
    UNCOUNTED,
    WRENCH,
    Events,
    Found,
    accumulate,
)
from peg_on_hole_ros.identification.quantities import DELAY_AT, TILT_AT, configured
from peg_on_hole_ros.identification.recording import (
    Recording,
    angles_at_wrenches,
    in_sensor_axes,
    turned,
)
from peg_on_hole_ros.identification.tuned import COUNTED_EVENTS
from peg_on_hole_ros.measurements.rotations import tilt_axes
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.mechanics.scene import scene_scalars
from peg_on_hole_ros.typed_record import new


class RunInnovations(NamedTuple):
    """
    Innovations of one component of the mixture at each event; rows beyond three are zero.

    Attributes
    ----------
    chosen : ndarray of int, shape (n,)
        Which component: the heaviest, unless it is given.
    residual : ndarray, shape (n, 6)
    covariance : ndarray, shape (n, 6, 6)

    """

    chosen: np.ndarray
    residual: np.ndarray
    covariance: np.ndarray


class LikelihoodRun(NamedTuple):
    """
    What a run says of its parameters.

    Attributes
    ----------
    log_likelihood : ndarray, shape (n,)
        Of each event, up to a constant.
    nis : ndarray, shape (m,)
        Normalised innovations squared of all that counts, 3 degrees of freedom.
    innovations : RunInnovations or None

    """

    log_likelihood: np.ndarray
    nis: np.ndarray
    innovations: RunInnovations | None

    @property
    def total(self) -> float:
        """Log likelihood of the recording."""
        return float(self.log_likelihood.sum())


def rows_of(record: Recording, parts: Sequence[slice], delay: float) -> tuple[np.ndarray, ...]:
    """
    Return which joint states and wrenches are events, and which joint states begin a part.

    They stay the same whatever delay is tried: other measurements have another likelihood.
    """
    joints, wrenches, uncounted = [], [], []
    for part in parts:
        t = record.joint_t[part] - delay
        first, last = np.searchsorted(record.wrench_t, (t[0] + COUNTED_EVENTS.settling, t[-1]))
        joints.append(np.arange(part.start, part.stop))
        wrenches.append(np.arange(first, last))
        first_ones = COUNTED_EVENTS.uncounted_orientations
        uncounted.append(np.arange(part.stop - part.start) < first_ones)
    return tuple(map(np.concatenate, (joints, wrenches, uncounted)))


class Likelihood:
    """
    The likelihood of parts of a recording.

    Parameters
    ----------
    record : Recording
        Read under the configuration of the start.
    parts : list of slice
        Of its joint states: where three contacts slide.
    start : Configuration

    """

    def __init__(self, record: Recording, parts: Sequence[slice], start: Configuration) -> None:
        self._start = start
        joints, wrenches, uncounted = rows_of(record, parts, start.joints.delay)
        self._smooth = [_spline(record.joint_t[part], record.q[part]) for part in parts]
        self._record = record._replace(
            joint_t=record.joint_t[joints],
            q=record.q[joints],
            covariance=record.covariance[joints],
            wrench_t=record.wrench_t[wrenches],
            wrench=record.wrench[wrenches],
        )
        kind = np.where(uncounted, UNCOUNTED, ORIENTATION)
        kind[np.cumsum([0, *(part.stop - part.start for part in parts)])[:-1]] = BEGIN
        self._kind = np.concatenate([kind, np.full(len(wrenches), WRENCH)])
        self.counted = int((~uncounted).sum())

    def events(self, x: np.ndarray, configuration: Configuration) -> Events:
        """
        Return what the sensors say under coordinates x that give a configuration.

        A delay moves the angles along their smooth motion; stamp and noise stay with each. Moved
        stamps would pair other samples of noise, which is worth more than a millisecond.
        """
        record, start = self._record, self._start
        ahead = x[DELAY_AT] - start.joints.delay
        if ahead:
            moved = [smooth(t + ahead) - smooth(t) for t, smooth in self._smooth]
            record = record._replace(q=record.q + np.concatenate(moved))
        t = record.joint_t - start.joints.delay
        # As the angles have it that are measured, whatever the hole's tilt.
        record = record._replace(wrench=in_sensor_axes(record, start))
        if any(x[TILT_AT]):
            record = turned(record, tilt_axes(x[TILT_AT]).T)
        wide = configuration.joints.position_stddev / start.joints.position_stddev
        on_peg = _on_peg(record, t, configuration)
        n, m = len(t), len(on_peg)
        value, covariance = np.zeros((n + m, 6)), np.zeros((n + m, 3, 3))
        value[:n, :3], value[n:] = record.q, on_peg
        covariance[:n] = record.covariance * wide**2
        volume = np.zeros(n + m)
        volume[:n] = np.log(np.sin(np.abs(record.q[:, 0])))
        times = np.concatenate([t, record.wrench_t])
        # Of one stamp the orientation comes first, as in the pipeline; rounding must not tell.
        order = np.argsort(np.round(times * 1e7), kind="stable")
        return Events(*(rows[order] for rows in (times, self._kind, value, covariance, volume)))

    def run(
        self, x: np.ndarray, chosen: np.ndarray | None = None, detailed: bool = False
    ) -> LikelihoodRun | None:
        """
        Run the estimator under coordinates x, with all of CALIBRATED_QUANTITIES known.

        Parameters
        ----------
        x : ndarray, shape (14,)
        chosen : ndarray of int, shape (n,), optional
            The component whose innovations are given.
        detailed : bool
            Whether innovations are given.

        Returns
        -------
        LikelihoodRun or None
            None where the likelihood is not finite.

        """
        configuration = configured(self._start, x)
        scene, options = configuration.scene, configuration.filter
        events = self.events(x, configuration)
        n = len(events.t)
        chosen = np.full(n, -1, np.int64) if chosen is None else chosen.copy()
        size = n if detailed else 0
        residual, covariance = np.zeros((size, 6)), np.zeros((size, 6, 6))
        found, nis = np.zeros(n), np.full(n, np.nan)
        kalman = new(FilterRecord)
        kalman.settings = default_settings(
            friction_hypotheses=1, reaction_prior=COUNTED_EVENTS.reaction_prior
        )
        kalman.scene[:], kalman.places = scene_scalars(scene), places_of(())
        kalman.estimated[: OPEN_BEGIN + 3] = 1.0
        kalman.estimated[FRICTION] = 0.0
        kalman.start_friction = scene.friction
        kalman.noise[:] = WrenchReduction(configuration.wrench, scene).covariance
        begin_state(kalman.state, OPEN_BEGIN + 3, 1, int(kalman.settings.modes))
        into = Found(found, nis, chosen, residual, covariance)
        accumulate(kalman, options.initial_rate_stddev, events, into)
        if not np.isfinite(found).all():
            return None
        details = RunInnovations(chosen, residual, covariance) if detailed else None
        return LikelihoodRun(found, nis[np.isfinite(nis)], details)


def _spline(t, q) -> tuple[np.ndarray, Callable]:
    """Return the stamps of a part [s], and a smooth motion through its angles."""
    pieces = max(round((t[-1] - t[0]) / COUNTED_EVENTS.knot_spacing), 1)
    inner = np.linspace(t[0], t[-1], pieces + 1)[1:-1]
    # A third of a second to import, and few recordings are refitted.
    from scipy.interpolate import make_lsq_spline

    return t, make_lsq_spline(t, q, np.r_[[t[0]] * 4, inner, [t[-1]] * 4], k=3)


def _on_peg(record: Recording, t, configuration: Configuration) -> np.ndarray:
    """Return wrenches, sensor axes, as those on the peg about its mass centre, (n, 6)."""
    wrench = replace(configuration.wrench, axes="sensor")
    reduction = WrenchReduction(wrench, configuration.scene)
    on_peg = (reduction.sign * record.wrench - reduction.tare) @ reduction.matrix.T
    if reduction.steps.mass:
        R_HP = peg_axes(angles_at_wrenches(record, t))
        gravity_P = np.einsum("ijk,i->kj", R_HP, configuration.scene.gravity)
        nothing, upright = np.zeros(3), np.zeros(3)
        still = reduction.on_peg(nothing, nothing, upright, np.zeros(3))
        on_peg += gravity_P @ [
            reduction.on_peg(nothing, nothing, upright, axis) - still for axis in np.eye(3)
        ]
    return on_peg
