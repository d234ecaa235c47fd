"""Which method and which rate of the wrench are enough for a cell's own motion, and why."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.estimator.methods.registry import METHODS
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.sim.measure import measure, sensor_wrench
from peg_on_hole_ros.sim.truth import Truth
from peg_on_hole_ros.study.chart import LEAST_DETERMINED
from peg_on_hole_ros.study.cost_floor import Noted, noted, taken_anew
from peg_on_hole_ros.study.motions import on_three
from peg_on_hole_ros.study.runs import (
    INSIDE_STDDEVS,
    LEAST_COVERED,
    Compared,
    Track,
    compared,
    run,
    thinned,
)
from peg_on_hole_ros.study.scenes import first_samples

# The wrench of a motion is thinned by these.
THINNED = (1, 2, 4, 10)
# What is off by so many times the tolerance after so many draws is given no more of them.
FAR, FEW = 3.0, 2
# What may limit it: a name, and what a half of it is, or twice the rate.
HALVED = ("force_stddev", "torque_stddev", "position_stddev")
_NOISE_WORDS = {
    "force_stddev": "noise of the force",
    "torque_stddev": "noise of the torque",
    "position_stddev": "noise of the orientation",
}


class Tolerances(NamedTuple):
    """
    What is enough.

    Attributes
    ----------
    reactions : float
        Root mean square of their error, over the mean reaction.
    tilt_rate : float
        The same of gamma', over the root mean square of gamma'.
    flag : float
        By how much the transition may be told early or late, in nine of ten seeds [s].

    """

    reactions: float = 0.03
    tilt_rate: float = 0.1
    flag: float = 0.01


class Tried(NamedTuple):
    """
    A method at a rate, over all seeds.

    Attributes
    ----------
    method : str
    rate : float
        Of the wrench [Hz].
    reactions, tilt_rate : float
        As of `Tolerances`.
    covered : float
        Least share of a determined reaction within its 95 % bounds.
    determined : float
        Share of samples.
    flag : float
        How far off the transition is told in the worst of ten seeds [s]; infinite: not told; NaN:
        the motion has none.
    lost : float
        Share of the seeds.
    step : float
        Computing time of the compiled step for a wrench [us]; NaN without a clock, as `whole`.
    whole : float
        The same of the whole path, for a millisecond of motion.
    draws : int
        Of the noise, that all this is told from.

    """

    method: str
    rate: float
    reactions: float
    tilt_rate: float
    covered: float
    determined: float
    flag: float
    lost: float
    step: float
    whole: float
    draws: int

    @property
    def holds(self) -> bool:
        """Whether its bounds hold, it tells enough, and is never lost."""
        return (
            self.covered >= LEAST_COVERED
            and self.determined >= LEAST_DETERMINED
            and self.lost == 0.0
        )

    def enough(self, within: Tolerances) -> bool:
        """Return whether it holds and is as near as asked for."""
        return bool(self.holds and self.beside(within) <= 1.0)

    def beside(self, within: Tolerances) -> float:
        """Return the largest of its errors over what is asked for; 1 is just enough."""
        # A motion that ends before the transition does not test the flag.
        flag = 0.0 if np.isnan(self.flag) else self.flag / within.flag
        return float(
            max(self.reactions / within.reactions, self.tilt_rate / within.tilt_rate, flag)
        )


class Limit(NamedTuple):
    """What another cell would give: in words, and the errors there beside the present ones."""

    what: str
    reactions: float
    tilt_rate: float


class Seeds(NamedTuple):
    """The first seed of the sensors' noise, and how many are drawn."""

    first: int
    drawn: int

    def numbers(self) -> range:
        """Return the seeds."""
        return range(self.first, self.first + self.drawn)


class Measured:
    """
    A motion, and what its sensors say of it: drawn once, for all methods and rates.

    Parameters
    ----------
    truth : Truth
    seeds : Seeds

    """

    def __init__(self, truth: Truth, seeds: Seeds) -> None:
        self.truth, self.drawn = truth, seeds.drawn
        exact = sensor_wrench(truth)
        self._draws = [list(measure(truth, seed, exact=exact)) for seed in seeds.numbers()]
        self._noted: dict[int, Noted] = {}

    def thinned(self, turn: int, every: int) -> list:
        """Return a draw's so manieth wrenches, with the orientations of these."""
        plan = self.truth.plan
        period, joint_period = 10**9 // plan.wrench_rate, 10**9 // plan.joint_rate
        # Another begin for each draw, where an orientation comes with the wrench.
        begin = turn * period // joint_period * joint_period % (every * period)
        return thinned(self._draws[turn], every * period, begin)

    def noted(self, every: int, clock: Callable[[], float]) -> Noted:
        """Return the first draw's steps of the default estimator."""
        if every not in self._noted:
            configuration = self.truth.plan.configuration
            self._noted[every] = noted(configuration, self.thinned(0, every), clock)
        return self._noted[every]


def tried(
    motion: Measured,
    method: str,
    every: int,
    clock: Callable[[], float] | None,
    within: Tolerances | None = None,
) -> Tried:
    """
    Return what becomes of a method on a motion, by the whole path, modes and alarms too.

    Parameters
    ----------
    motion : Measured
    method : str
        Of `filter.method`.
    every : int
        It is given each so manieth wrench, and the orientations of these; seeds begin at others.
    clock : callable or None
        Returns a time [s]; None: what it costs is not asked.
    within : Tolerances, optional
        What is off by FAR times them after FEW draws is given no more.

    """
    truth = motion.truth
    given = truth.plan.configuration
    configuration = replace(given, filter=replace(given.filter, method=method))
    count = on_three(truth)
    three = first_samples(truth, count)
    changes = float(truth.t_ns[count]) * 1e-9 if count < len(truth.t_ns) else float("nan")
    found: list[Compared | None] = []
    flags: list[float] = []
    seconds = float("nan")
    for turn in range(motion.drawn):
        if turn == FEW and within is not None and _far(found, three, within):
            break
        # The first draw tells what a node would cost.
        live = clock is not None and turn == 0
        track = run(configuration, motion.thinned(turn, every), clock or _none, live=live)
        seconds = track.seconds if live else seconds
        flag = float("inf") if track.flag_ns is None else track.flag_ns * 1e-9 - changes
        flags.append(abs(flag))
        found.append(compared(three, _first(track, int(three.t_ns[-1]))))
    duration_ms = (truth.t_ns[-1] - truth.t_ns[0]) * 1e-6
    return Tried(
        method, truth.plan.wrench_rate / every, *_pooled(found, three),
        float("nan") if np.isnan(changes) else float(np.quantile(flags, 0.9, method="higher")),
        1.0 - sum(not one.lost for one in _telling(found)) / len(found),
        1e6 * _step(motion, method, every, clock), 1e6 * seconds / duration_ms, len(found),
    )  # fmt: skip


def _none() -> float:
    return float("nan")


def _step(motion: Measured, method: str, every: int, clock: Callable[[], float] | None) -> float:
    """Return the computing time of the compiled step for a wrench [s]."""
    if clock is None:
        return float("nan")
    calls, settings = motion.noted(every, clock), METHODS[method].settings or {}
    return min(taken_anew(calls, default_settings(**settings), clock)[1] for _ in range(3))


def _far(found: Sequence[Compared | None], truth: Truth, within: Tolerances) -> bool:
    """Return whether more draws cannot bring what was found near to the tolerances."""
    reactions, tilt_rate, *_ = _pooled(found, truth)
    return reactions > FAR * within.reactions or tilt_rate > FAR * within.tilt_rate


def _telling(found: Sequence[Compared | None]) -> list[Compared]:
    return [one for one in found if one is not None and len(one.error)]


def _first(track: Track, until_ns: int) -> Track:
    """Return a track until a stamp."""
    n = int(np.searchsorted(track.t_ns, until_ns, side="right"))
    return track._replace(
        t_ns=track.t_ns[:n], values=track.values[:n], stddev=track.stddev[:n],
        determined=track.determined[:n],
    )  # fmt: skip


def _pooled(found: Sequence[Compared | None], truth: Truth) -> tuple[float, float, float, float]:
    """Return errors of reactions and of the tilt's rate, coverage, and what is determined."""
    told = _telling(found)
    if not told:
        return float("inf"), float("inf"), 0.0, 0.0
    error = np.concatenate([one.error for one in told])
    stddev = np.concatenate([one.stddev for one in told])
    determined = np.concatenate([one.determined for one in told])
    inside = np.abs(error[determined, 6:]) <= INSIDE_STDDEVS * stddev[determined, 6:]
    rate = float(np.sqrt(np.mean(truth.rates[:, 0] ** 2)))
    # What is not told of a reaction is as wrong as the reaction itself.
    known = np.where(np.isfinite(error[:, 6:]), error[:, 6:], told[0].load)
    return (
        float(np.sqrt(np.mean(known**2))) / told[0].load,
        float(np.sqrt(np.mean(error[:, 3] ** 2))) / rate,
        float(inside.mean(axis=0).min()) if len(inside) else 0.0,
        float(determined.mean()),
    )


def cheapest(found: Sequence[Tried], within: Tolerances) -> Tried | None:
    """Return what is enough at the least cost of the whole path, a lower rate before another."""
    enough = [one for one in found if one.enough(within)]
    return min(enough, key=lambda one: (one.rate, one.step), default=None)


def nearest(found: Sequence[Tried], within: Tolerances) -> Tried:
    """Return what is nearest to enough: of those that hold, else of all."""
    holding = [one for one in found if one.holds]
    return min(holding or found, key=lambda one: one.beside(within))


def limits(
    truth: Truth, chosen: Tried, seeds: Seeds, clock: Callable[[], float]
) -> Iterator[Limit]:
    """
    Yield what half of each noise, and twice the rate, would give with the same motion.

    Parameters
    ----------
    truth : Truth
    chosen : Tried
    seeds : Seeds
    clock : callable

    """
    every = round(truth.plan.wrench_rate / chosen.rate)
    for name in HALVED:
        other = Measured(_with_half(truth, name), seeds)
        one = tried(other, chosen.method, every, clock)
        yield Limit(f"half of the {_NOISE_WORDS[name]}", one.reactions, one.tilt_rate)
    if every > 1:
        faster = max(each for each in THINNED if each < every)
        one = tried(Measured(truth, seeds), chosen.method, faster, clock)
        yield Limit(f"a wrench at {one.rate:g} Hz", one.reactions, one.tilt_rate)


def _with_half(truth: Truth, name: str) -> Truth:
    given = truth.plan.configuration
    part = "joints" if hasattr(given.joints, name) else "wrench"
    group = getattr(given, part)
    changed: Configuration = replace(
        given, **{part: replace(group, **{name: 0.5 * getattr(group, name)})}
    )
    return replace(truth, plan=replace(truth.plan, configuration=changed))
