"""The delay: wrenches and joint states of one moment bear other stamps than is stated."""

from collections import deque
from collections.abc import Generator
from dataclasses import replace
from math import hypot, pi, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.suspected.unobservable import offsets_of, stated_offsets
from peg_on_hole_ros.diagnosis.tuned import DELAY_TRIAL
from peg_on_hole_ros.identification.fisher_scoring import Search
from peg_on_hole_ros.identification.likelihood import Likelihood
from peg_on_hole_ros.identification.quantities import (
    CLEARANCE_AT,
    DELAY_AT,
    FRICTION_AT,
    IS_NOISE,
    coordinates,
    measures,
)
from peg_on_hole_ros.identification.recording import Recording, slow_slip
from peg_on_hole_ros.identification.tuned import COUNTED_EVENTS, SCORING
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.geometry import contact_geometry, velocity_jacobians
from peg_on_hole_ros.number_text import quantity
from peg_on_hole_ros.records import AngleMeasurement

# Coordinates of what else may be off, in the order of `unobservable.KINDS`.
KINDS = [FRICTION_AT], [CLEARANCE_AT], [3], [1, 2], [4, 5, 6], [7, 8]
HYPOTHESES = [], [DELAY_AT], *KINDS


class _Look(NamedTuple):
    """An orientation, and runs of stamps and wrenches since the one before."""

    passed: list[tuple[np.ndarray, np.ndarray]]
    measured: AngleMeasurement
    touches: bool

    def means(self) -> tuple[np.ndarray, np.ndarray, int]:
        """Return stamps and means of some parts of the wrenches, and how many the last is of."""
        t_ns, wrenches = (np.concatenate(each) for each in zip(*self.passed))
        parts = min(DELAY_TRIAL.means, len(t_ns))
        begins = np.arange(parts) * len(t_ns) // parts
        counts = np.diff(begins, append=len(t_ns))
        since = np.add.reduceat(t_ns - t_ns[0], begins) // counts
        means = np.add.reduceat(wrenches, begins) / counts[:, None]
        return t_ns[0] + since, means, int(counts[-1])


class _Estimate(NamedTuple):
    """A delay [s], and its variance [s^2]."""

    delay: float
    variance: float

    def agrees(self, other: "_Estimate") -> bool:
        """Return whether both may be of one delay."""
        apart = (self.delay - other.delay) ** 2
        return apart < DELAY_TRIAL.agrees**2 * (self.variance + other.variance)

    def with_other(self, other: "_Estimate") -> "_Estimate":
        """Return what both tell together."""
        variance = 1.0 / (1.0 / self.variance + 1.0 / other.variance)
        delay = variance * (self.delay / self.variance + other.delay / other.variance)
        return _Estimate(delay, variance)


class Delay(Suspect):
    """
    Refits the last second of three sliding contacts at several delays of the joint states.

    The estimator runs over each, as it does to calibrate; a look does one such run or climb, so
    that no wrench waits long. A delay is reported if it is likelier by far than the stated one,
    and than another friction, zero, tilt or clearance. At a steady rate it looks like a turned
    hole: a second in which no rate changes is not judged.

    One second alone reports nothing: what it makes of the delay has to explain the next one, which
    took no part in it, far better than the stated delay does, and both have to agree.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "delay"
    FINDS = (
        (
            "`joints.delay`: wrench or joint states come 10 to 50 ms late, also behind a filter "
            "(`replay` alone)",
            "two seconds of slip on three contacts in which a rate changes by half, if the delay "
            "of the one explains the other, and nothing else is found",
        ),
    )
    OFFLINE = True

    def __init__(self, stated: Stated) -> None:
        configuration = stated.configuration
        self._reduction = WrenchReduction(
            configuration.wrench, configuration.scene, configuration.joints.hole_rpy
        )
        # A tare, in place of the zero that is stated.
        self._tare = stated.taken_off - self._reduction.taken_off
        self._stated = configuration.joints.delay
        # Orientations bear the stamps that the stated delay gives them.
        joints = replace(configuration.joints, delay=0.0)
        self._configuration = replace(configuration, joints=joints)
        offsets = stated_offsets(configuration)
        self._open = [i for kind, offset in zip(KINDS, offsets) if offset > 0.0 for i in kind]
        self.finding: Finding | None = None
        # By how much a delay is likelier than each hypothesis [nats], what each has come to, and
        # how often in a row a second has decided nothing.
        self._gains = np.zeros(len(HYPOTHESES))
        self._spreads: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        self._undecided = 0
        # What the seconds before make of the delay; None: nothing yet.
        self._earlier: _Estimate | None = None
        self.restart()

    def restart(self) -> None:
        """Forget what a motion has shown so far."""
        self._kept: deque[_Look] = deque(maxlen=DELAY_TRIAL.kept)
        self._passed: list[tuple[np.ndarray, np.ndarray]] = []
        self._judging: Generator[None, None, None] | None = None
        self._wait = DELAY_TRIAL.every

    def take_every_wrench(self, t_ns: np.ndarray, wrenches: np.ndarray) -> None:
        """Process every wrench, see the package."""
        if self.finding is None and len(t_ns):
            self._passed.append((t_ns, wrenches))

    def take(self, instant: Instant, unsure: bool) -> None:
        """Look at the latest orientation, see the package."""
        measured, touches = instant.measured, instant.in_air is False and not unsure
        if self.finding is not None or not self._passed:
            return
        if self._kept:
            last, from_ns = self._kept[-1], int(self._passed[0][0][0])
            apart = measured.t_ns - last.measured.t_ns, from_ns - int(last.passed[-1][0][-1])
            if not all(0 < each <= DELAY_TRIAL.silence_ns for each in apart):
                self._kept.clear()
        self._kept.append(_Look(self._passed, measured, touches))
        self._passed = []
        self._wait -= 1
        if self._judging is not None:
            self._go_on(self._judging)
        elif self._wait <= 0 and len(self._kept) == DELAY_TRIAL.kept and self._tells():
            self._wait = DELAY_TRIAL.every
            self._judging = self._judge(*self._record())

    def _go_on(self, judging):
        try:
            next(judging)
        except StopIteration as end:
            self._judging = None
            if not end.value:
                # A second that decides nothing is followed by others like it.
                self._undecided = min(self._undecided + 1, DELAY_TRIAL.doubled)
                self._wait = DELAY_TRIAL.every << self._undecided

    def _tells(self):
        """Return whether three loaded contacts slide, and some rate changes."""
        if not all(look.touches for look in self._kept):
            return False
        q = np.unwrap([look.measured.q for look in self._kept], axis=0)
        t_ns = np.array([look.measured.t_ns for look in self._kept])
        t = (t_ns - t_ns[0]) * 1e-9
        scene = self._configuration.scene
        if not DELAY_TRIAL.nearest_tilt * scene.gamma0 < q[:, 0].min() <= q[:, 0].max() < 1.2:
            return False
        rates = (q[2:] - q[:-2]) / (t[2:] - t[:-2])[:, None]
        jacobians = velocity_jacobians(
            contact_geometry(scene, q[1:-1, 0]), scene.peg_diameter, scene.hole_diameter
        )
        velocities = np.einsum("cir...,r...->ci...", jacobians, rates.T)
        slip, slow = (
            np.linalg.norm(velocities, axis=1).min(),
            DELAY_TRIAL.slides * slow_slip(self._configuration),
        )
        least = np.maximum(
            DELAY_TRIAL.changes * np.abs(rates).max(axis=0), slow / scene.hole_diameter
        )
        changes = np.ptp(rates, axis=0) > least
        return bool(slip > slow and changes.any())

    def _judge(self, record, load, count):
        """
        Compare delays over the last second, a run or a climb at each look.

        Returns whether the second has added to the evidence for or against a delay.
        """
        configuration, left = self._configuration, DELAY_TRIAL.unexplained * load
        scene, wrench = configuration.scene, configuration.wrench
        wrench = replace(
            wrench,
            force_stddev=hypot(wrench.force_stddev / sqrt(count), left),
            torque_stddev=hypot(
                wrench.torque_stddev / sqrt(count), 0.5 * left * scene.hole_diameter
            ),
        )
        configuration = replace(configuration, wrench=wrench)
        likelihood = Likelihood(record, [slice(0, DELAY_TRIAL.kept)], configuration)
        x = coordinates(configuration)
        first = DELAY_TRIAL.first
        values = yield from _values(likelihood, x, (0.0, -first, first))
        # A delay of half as much is as likely as none.
        if max(values[first], values[-first]) < values[0.0] - DELAY_TRIAL.likelier:
            self._forget()
            return False
        return (yield from self._try_all(likelihood, x, self._sizes(load)))

    def _forget(self):
        """Forget what seconds have shown of a delay: another contradicts them."""
        self._gains[:], self._spreads, self._earlier = 0.0, {}, None

    def _try_all(self, likelihood, x, sizes):
        """Report a delay that is likelier by far than what is stated, and than other settings."""
        spread = np.where(IS_NOISE, 0.0, 4.0 * sizes.range)
        limits = x - spread, x + spread
        limits[0][FRICTION_AT] = 0.0
        spreads = [self._spreads.get(i, (x, sizes.range)) for i in range(len(HYPOTHESES))]

        def climb(i, begin):
            centre, range_ = spreads[i]
            measures_ = sizes._replace(range=range_)
            search = Search(likelihood, likelihood, centre, measures_, limits)
            return search.climb(begin, self._free(HYPOTHESES[i]), DELAY_TRIAL.iterations)

        stated = climb(0, x)
        yield
        if stated is None:
            return False
        begin, first = stated.x.copy(), DELAY_TRIAL.first
        values = yield from _values(likelihood, begin, (-first, 0.0, first))
        side = 1.0 if values[first] > values[-first] else -1.0
        values |= yield from _values(likelihood, begin, [side * x for x in DELAY_TRIAL.tried])
        best = max(values, key=values.__getitem__)
        if abs(best) == DELAY_TRIAL.tried[-1] or values[best] - values[0.0] < DELAY_TRIAL.likelier:
            return False
        begin[DELAY_AT] = best
        late = climb(1, begin)
        yield
        # It is where it was seen.
        if late is None or abs(late.x[DELAY_AT] - best) > max(first, 0.5 * abs(best)):
            return False
        small = abs(late.x[DELAY_AT]) < DELAY_TRIAL.least
        if small or late.run.nis.mean() > SCORING.explained_nis:
            return False
        peaks = [stated, late]
        for i in range(2, len(HYPOTHESES)):
            peaks.append(climb(i, spreads[i][0]))
            yield
        if any(peak is None for peak in peaks):
            return False
        now = self._estimate(late, sizes)
        told = False
        if self._earlier is not None:
            # It had no part in what the seconds before have made of the delay.
            before = self._earlier.delay
            held_out = yield from _values(likelihood, stated.x, (before,))
            explains = held_out[before] - values[0.0] > DELAY_TRIAL.likelier
            if explains and now.agrees(self._earlier):
                told, now = True, now.with_other(self._earlier)
            else:
                self._forget()
        # As many seconds as it takes. What one has shown of a zero holds in the next.
        self._gains += [late.value - peak.value for peak in peaks]
        self._spreads = {i: self._spread(i, peak, spreads[i][1]) for i, peak in enumerate(peaks)}
        self._earlier = now
        self._wait = DELAY_TRIAL.kept
        likeliest = self._gains[0] > DELAY_TRIAL.sure and self._gains[2:].min() > DELAY_TRIAL.apart
        if told and likeliest and now.variance < DELAY_TRIAL.known**2:
            self.finding = self._said(now.delay, self._gains[0])
        return True

    def _estimate(self, late, sizes):
        """Return what a second by itself makes of the delay."""
        free = self._free(HYPOTHESES[1])
        covariance = np.linalg.inv(late.information + np.diag(sizes.range[free] ** -2.0))
        at = free.tolist().index(DELAY_AT)
        return _Estimate(float(late.x[DELAY_AT]), covariance[at, at] + DELAY_TRIAL.finest**2)

    def _spread(self, i, peak, range_):
        """Return where a hypothesis has come to, and how well that is known by now."""
        free, range_ = self._free(HYPOTHESES[i]), range_.copy()
        covariance = np.linalg.inv(peak.information + np.diag(range_[free] ** -2.0))
        range_[free] = np.sqrt(np.diagonal(covariance))
        # A second's own delay is held against that of those before.
        x = peak.x.copy()
        x[DELAY_AT], range_[DELAY_AT] = 0.0, DELAY_TRIAL.tried[-1]
        return x, range_

    def _free(self, kind):
        """Return coordinates that are open as stated, and those of a kind."""
        return np.union1d(self._open, kind).astype(int)

    def _said(self, found, gain):
        late, other = ("wrenches", "joint states") if found < 0 else ("joint states", "wrenches")
        filtered = (
            f", or behind a low-pass of {quantity(0.5 / pi / -found, 'Hz', 2)}"
            if found < 0
            else ""
        )
        return Finding(
            f"{late} come some {1e3 * abs(found):.0f} ms behind {other} of the same "
            f"moment{filtered}: set joints.delay: {round(self._stated + found, 3):g}; with it "
            f"what slides is e^{gain:.0f} times likelier",
            {},
            hint=True,
        )

    def _sizes(self, load):
        """Return how far off the other settings may be, and steps for a load [N]."""
        sizes = measures(self._configuration.scene.hole_diameter, load)
        offsets, range_ = offsets_of(self._configuration), sizes.range.copy()
        for kind, offset in zip(KINDS, offsets):
            range_[kind] = offset
        range_[DELAY_AT] = DELAY_TRIAL.tried[-1]
        return sizes._replace(range=range_)

    def _record(self):
        """Return what is kept as a recording, its median load [N], and wrenches in a mean."""
        kept = list(self._kept)
        stamps, wrenches, counts = zip(*(look.means() for look in kept))
        begin = min(int(stamps[0][0]), kept[0].measured.t_ns)
        q = np.array([look.measured.q for look in kept])
        q[:, 1:] = np.unwrap(q[:, 1:], axis=0)
        # Rates are known once the orientations that do not count have come.
        first = COUNTED_EVENTS.uncounted_orientations
        record = Recording(
            (np.concatenate(stamps[first:]) - begin) * 1e-9,
            np.concatenate(wrenches[first:]) - self._tare,
            np.array([look.measured.t_ns - begin for look in kept]) * 1e-9,
            q,
            np.array([look.measured.covariance for look in kept]),
        )
        last = [each[-1] - self._tare for each in wrenches]
        forces = [self._reduction.on_peg(w[:3], w[3:], at)[:3] for w, at in zip(last, q)]
        load = float(np.median(np.linalg.norm(forces, axis=1)))
        return record, load, min(counts)


def _values(likelihood, x, delays):
    """Return log likelihoods of delays, all else as given, one run at each look."""
    values = {}
    for delay in delays:
        moved = x.copy()
        moved[DELAY_AT] = delay
        run = likelihood.run(moved)
        values[delay] = -np.inf if run is None else run.total
        yield
    return values
