"""A zero that jumps: a driver zeroes its sensor in mid-run."""

from math import hypot, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.steps_of_wrench import Step, find_steps
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import ZERO_JUMP_TEST
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.number_text import number, quantity
from peg_on_hole_ros.typed_record import Floats


class _Turn(NamedTuple):
    """Stamp [ns], axes of the peg (9,), and the standard deviation of the tilt [rad]."""

    t_ns: int
    axes: Floats
    stddev: float


class ZeroJump(Suspect):
    """
    Looks for a wrench that steps from one message to the next to zero, and stays there.

    A sensor that is zeroed reads zero in all six components at once, where a free peg would read
    its weight: whatever the peg does. Where a controller takes the weight off, the motion decides:
    with the load of contacts it would change. A step to another level is none of these: friction
    that steps, or a touch of hard parts, looks alike.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "zero_jump"
    FINDS = (
        (
            "`the zero has jumped by 8 N`, because the driver zeroes its sensor in mid-run: the "
            "jump is subtracted (`wrench.adopt_found`; else the mode is `unknown`), and "
            "`reactions_determined` is 0 until a tare",
            "a step between two wrenches of 6 times the noise, to zero in all six components, "
            "where a free peg reads its weight, or while the motion continues; after 0.1 s",
        ),
    )
    OF_ZERO = True
    LASTS = True
    WITHOUT_WRENCH = True

    def __init__(self, stated: Stated) -> None:
        self._found: list[Finding] = []
        self._begun_ns: int | None = None
        self._jumped_ns: int | None = None
        self._jump: Floats | None = None
        self._air, self._in_air = np.zeros(6), 0
        self.restate(stated)
        self.restart()

    def restate(self, stated: Stated) -> None:
        """Go on by other settings."""
        wrench, monitor = stated.configuration.wrench, stated.configuration.monitor
        self._reduction, self._adopts = stated.reduction, wrench.adopt_found
        self._noise = np.array([wrench.force_stddev] * 3 + [wrench.torque_stddev] * 3)
        # A tare, or a zero that is stated, is known.
        open_to = 0.0 if np.any(stated.taken_off) else ZERO_JUMP_TEST.sure
        spreads = [wrench.bias_force_stddev] * 3 + [wrench.bias_torque_stddev] * 3
        reach = hypot(*wrench.sensor_xyz) + 0.5 * stated.configuration.scene.peg_diameter
        force = monitor.contact_force_threshold
        self._touch = np.array([force] * 3 + [reach * force] * 3)
        self._zero = open_to * np.array(spreads)

    def restart(self) -> None:
        """Forget what has come; a zero that has jumped stays so."""
        self._passed: list[tuple[np.ndarray, np.ndarray]] = []
        self._t_ns, self._rows = np.empty(0, np.int64), np.empty((0, 6))
        self._turns: list[_Turn] = []
        self._seen_ns = 0
        self._pending = False

    def forget_zero(self) -> None:
        """Forget a jump: a tare has taken it."""
        self._jumped_ns = None
        self._found = []
        self._air, self._in_air = np.zeros(6), 0
        self.restart()

    @property
    def unsure(self) -> bool:
        """Whether a step waits to be decided, or was a jump a moment ago."""
        if self._jumped_ns is None:
            return self._pending
        recent = self._seen_ns - self._jumped_ns < ZERO_JUMP_TEST.settles_ns
        return recent or not self._adopts or self._pending

    @property
    def hides(self) -> bool:  # type: ignore[override]
        """Whether what others make of the wrench is no setting."""
        return self.unsure

    @property
    def withholds(self) -> bool:
        """Whether the zero rests on how well a jump is known."""
        return self._jumped_ns is not None

    def take_zero_jump(self) -> Floats | None:
        """Return by how much the zero has jumped since this was asked last, sensor axes, (6,)."""
        jump, self._jump = self._jump, None
        return jump if self._adopts else None

    def findings(self) -> tuple[Finding, ...]:
        """Return each jump."""
        return tuple(self._found)

    def take_every_wrench(self, t_ns: np.ndarray, wrenches: np.ndarray) -> None:
        """Process every wrench, see the package."""
        if len(t_ns):
            self._passed.append((t_ns, wrenches))
            self._begun_ns = int(t_ns[0]) if self._begun_ns is None else self._begun_ns

    def take(self, instant: Instant, unsure: bool) -> None:
        """Look at the steps that have come."""
        if unsure or instant.standing is not None:
            self.restart()
            return
        now_ns, measured = instant.sample.t_ns, instant.measured
        self._seen_ns = now_ns
        angle = sqrt(max(float(measured.covariance[0, 0]), 0.0))
        self._turns.append(_Turn(now_ns, peg_axes(measured.q).ravel(), angle))
        self._turns = self._turns[-ZERO_JUMP_TEST.looks :]
        if instant.in_air and self._passed and not self.unsure:
            self._follow_air(np.concatenate([rows for _, rows in self._passed]), measured.q)
        parts = [(self._t_ns, self._rows), *self._passed]
        self._passed = []
        t_ns, rows = (np.concatenate(each) for each in zip(*parts))
        kept = np.searchsorted(t_ns, now_ns - ZERO_JUMP_TEST.kept_ns)
        self._t_ns, self._rows = t_ns[kept:], rows[kept:]
        self._decide(measured.q, now_ns)

    def _decide(self, q: Floats, now_ns: int) -> None:
        """Decide on steps to zero that have stayed; one that has not waits in doubt."""
        self._pending = False
        for step in find_steps(self._t_ns, self._rows, self._noise):
            told = self._jumped_ns is not None and step.at_ns <= self._jumped_ns
            if told or not step.zeroes:
                continue
            if now_ns - step.at_ns < ZERO_JUMP_TEST.stays_ns:
                self._pending = True
            elif step.stays and (self._is_zeroed(step, q) or self._goes_on(step.at_ns)):
                self._tell(step, q)

    def _is_free(self, step: Step, q: Floats) -> bool:
        """Return whether a free peg reads as is read behind a step."""
        zero, open_to = self._reduction.zero_of(step.after[:3], step.after[3:], q), self._zero
        known = self._reduction.tare
        if self._in_air >= ZERO_JUMP_TEST.looks:
            # What a free peg has read is known better than what is stated.
            known, open_to = self._air, np.zeros(6)
        limits = self._touch + open_to + ZERO_JUMP_TEST.sure * step.noise
        return bool((np.abs(zero - known) < limits).all())

    def _is_zeroed(self, step: Step, q: Floats) -> bool:
        """Return whether it reads no force, which nothing that hangs or touches there does."""
        return step.no_force and not self._is_free(step, q)

    def _follow_air(self, rows: Floats, q: Floats) -> None:
        """Take what a free peg reads beside its weight, rows (n, 6)."""
        mean = rows.mean(axis=0)
        self._in_air += 1
        share = 1.0 / min(self._in_air, ZERO_JUMP_TEST.in_air)
        self._air += share * (self._reduction.zero_of(mean[:3], mean[3:], q) - self._air)

    def _goes_on(self, at_ns: int) -> bool:
        """Return whether the peg turns behind a stamp as it did before."""
        before = [turn for turn in self._turns if turn.t_ns < at_ns]
        after = [turn for turn in self._turns if turn.t_ns > at_ns]
        if min(len(before), len(after)) < ZERO_JUMP_TEST.fewest_looks:
            return False
        t = np.array([turn.t_ns - at_ns for turn in before]) * 1e-9
        line = np.column_stack([np.ones(len(t)), t])
        found = np.linalg.lstsq(line, np.array([turn.axes for turn in before]), rcond=None)[0]
        behind = (after[-1].t_ns - at_ns) * 1e-9
        off = np.abs(after[-1].axes - found[0] - behind * found[1]).max()
        noise = ZERO_JUMP_TEST.turned * after[-1].stddev
        return bool(off < noise + ZERO_JUMP_TEST.rate * behind * np.abs(found[1]).max())

    def _tell(self, step: Step, q: Floats) -> None:
        before, after = (
            self._reduction.zero_of(level[:3], level[3:], q)
            for level in (step.after - step.jump, step.after)
        )
        self._jump = after - before if self._jump is None else self._jump + after - before
        self._air += after - before
        self._jumped_ns, self._pending = step.at_ns, False
        jump = step.jump
        shown = ", ".join(number(x, 2) for x in jump[:3])
        begun_ns = step.at_ns if self._begun_ns is None else self._begun_ns
        meanwhile = (
            "the jump is subtracted, and reactions are withheld until then"
            if self._adopts
            else "the contact mode is unknown until then (wrench.adopt_found)"
        )
        finding = Finding(
            f"wrench.bias_force: the zero has jumped by {quantity(hypot(*jump[:3]), 'N')}, "
            f"[{shown}] N as received, and {quantity(hypot(*jump[3:]), 'N m', 2)} at "
            f"{(step.at_ns - begun_ns) * 1e-9:.3f} s, from one wrench to the next all six "
            "components read zero: the driver zeroes its sensor in mid-run. Tare it where it "
            f"hangs free (~/tare), and keep the driver from zeroing meanwhile: {meanwhile}",
            {},
        )
        self._found.append(finding)
