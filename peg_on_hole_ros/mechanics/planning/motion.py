"""A closing in stages: ramps between constant rates, down to gamma0."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.mechanics.planning.fineness import PLANNED, Fineness

# Nearest to gamma0 that is looked at [rad].
NEAREST_TO_GAMMA0 = 3e-6


class Stage(NamedTuple):
    """
    One stretch of a motion; rates run from those of the stage before to its own.

    Attributes
    ----------
    name : str
    duration : float
        [s]
    tilt : float
        At its end [rad].
    rates : tuple of 3 float
        gamma', psi', phi' at its end [rad/s].

    """

    name: str
    duration: float
    tilt: float
    rates: tuple[float, float, float]


class ClosingMotion(NamedTuple):
    """
    A whole closing.

    Attributes
    ----------
    start_tilt : float
        [rad]
    start_rates : tuple of 3 float
        [rad/s]
    stages : tuple of Stage

    """

    start_tilt: float
    start_rates: tuple[float, float, float]
    stages: tuple[Stage, ...]

    @property
    def duration(self) -> float:
        """Time that it takes [s]."""
        return sum(stage.duration for stage in self.stages)

    @property
    def turning(self) -> float:
        """Way of slip and slide together [rad]."""
        before, total = self.start_rates, 0.0
        for stage in self.stages:
            turn = sum(abs(a + b) / 2 for a, b in zip(before[1:], stage.rates[1:]))
            total += turn * stage.duration
            before = stage.rates
        return total

    @property
    def turn_tilt(self) -> float | None:
        """Tilt at which turning begins; None: never [rad]."""
        tilt, before = self.start_tilt, self.start_rates
        for stage in self.stages:
            if any(before[1:]) or any(stage.rates[1:]):
                return tilt
            tilt, before = stage.tilt, stage.rates
        return None


def motion_of(
    tilt: float,
    rates: Sequence[float] | np.ndarray,
    legs: Sequence[tuple],
    gamma0: float,
    max_acceleration: float,
) -> ClosingMotion | None:
    """
    Return the motion through legs of constant rates.

    Parameters
    ----------
    tilt : float
        At the begin [rad].
    rates : sequence of 3 float
        At the begin [rad/s].
    legs : sequence of (rates, tilt)
        Each leg's rates, gamma' below 0, and the tilt at which the ramp to the next begins; the
        last ends at gamma0.
    gamma0 : float
        [rad]
    max_acceleration : float
        Of each angle [rad/s^2].

    Returns
    -------
    ClosingMotion or None
        None where ramps leave no room for a leg.

    """
    start = (float(tilt), tuple(map(float, rates)))
    stages, now, before = [], start[0], np.array(start[1])
    for k, (target, end) in enumerate(legs):
        target, last = np.asarray(target, float), k == len(legs) - 1
        turns = bool(np.any(target[1:]))
        # Rates rise as 3 u^2 - 2 u^3, whose steepest slope is 1.5.
        ramp = 1.5 * np.max(np.abs(target - before)) / max_acceleration
        if ramp > 0:
            now += (target[0] + before[0]) / 2 * ramp
            stages.append(
                _stage("begin to turn" if turns else "begin to close", ramp, now, target)
            )
        end = gamma0 if last else end
        if now <= end:
            return None
        duration = (now - end) / -target[0]
        stages.append(_stage("close and turn" if turns else "close", duration, end, target))
        now, before = end, target
    return ClosingMotion(*start, tuple(stages))  # type: ignore[arg-type]


def _stage(name, duration, tilt, rates):
    return Stage(name, float(duration), float(tilt), tuple(map(float, rates)))  # type: ignore[arg-type]


class Path(NamedTuple):
    """
    A motion in samples.

    Attributes
    ----------
    time, gamma : ndarray, shape (n,)
        [s], [rad]; the tilt falls.
    rates : ndarray, shape (3, n)
        [rad/s]

    """

    time: np.ndarray
    gamma: np.ndarray
    rates: np.ndarray


def path_of(motion: ClosingMotion, gamma0: float, fineness: Fineness = PLANNED) -> Path:
    """Return a motion in samples, dense towards gamma0."""
    begin, tilt, before = 0.0, motion.start_tilt, np.array(motion.start_rates)
    times, tilts, rates = [], [], []
    for stage in motion.stages:
        target = np.array(stage.rates)
        if np.array_equal(target, before):
            # Even steps of the tilt, and of the logarithm of what is left of it until gamma0.
            left = np.geomspace(
                tilt - gamma0, max(stage.tilt - gamma0, NEAREST_TO_GAMMA0), fineness.stage
            )
            u = (tilt - gamma0 - left) / (tilt - stage.tilt)
            u = np.unique(np.concatenate([u, np.linspace(0, u[-1], fineness.stage // 2)]))
        else:
            # At rest there is no direction of slip.
            u = np.linspace(0.02, 1, fineness.ramp)
        shape = 3 * u**2 - 2 * u**3
        way = u**3 - u**4 / 2
        times.append(begin + stage.duration * u)
        change = target - before
        tilts.append(tilt + stage.duration * (before[0] * u + change[0] * way))
        rates.append(before[:, None] + change[:, None] * shape)
        begin, tilt, before = begin + stage.duration, stage.tilt, target
    gamma = np.concatenate(tilts)
    falling = np.concatenate([[True], np.diff(np.minimum.accumulate(gamma)) < 0])
    rates = np.concatenate(rates, axis=1)
    return Path(np.concatenate(times)[falling], gamma[falling], rates[:, falling])
