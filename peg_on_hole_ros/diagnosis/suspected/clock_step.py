"""A clock that was set: stamps of one input, or of both, jump and go on from there."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.leads import Leads
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import CLOCK_STEP_TEST
from peg_on_hole_ros.number_text import number


class _Jump(NamedTuple):
    """
    Where stamps of one input jump.

    Attributes
    ----------
    place : int
        Of the first message behind it, among those that are kept.
    size_ns, to_ns : int
        How far the stamp lies beyond the one that was due, and the stamp [ns].
    at_ns : int
        When it came: the stamp of the wrench before it, or the one that was due [ns].

    """

    place: int
    size_ns: int
    at_ns: int
    to_ns: int


class ClockStep(Suspect):
    """
    Looks for stamps that jump, in messages that go on as before.

    Stamps of joint states against those of wrenches tell which clock was set. Where both jump
    ahead together nothing came for a while, which is no step. A recording that is played in a
    loop goes back to its first stamps; two publishers whose clocks differ take turns.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "clock_step"
    FINDS = (
        (
            "`the clock of /joint_states was set forward by 0.4 s at 3.000 s`, or back, or that "
            "of the wrench, or both back by less than 1 s. While the clocks are apart, and for a "
            "second after that, the mode is `unknown`, and `reactions_determined` is 0",
            "anywhere, 25 messages later",
        ),
    )
    LASTS = True
    OF_STAMPS = True
    WITHOUT_WRENCH = True

    def __init__(self, stated: Stated) -> None:
        topics = stated.configuration.topics
        self._topics = {True: topics.wrench, False: topics.joint_states}
        self._told: list[Finding] = []
        self._begun_ns: dict[bool, int] = {}
        self._apart_ns, self._set_ns = 0, -1
        self.restart()

    def restart(self) -> None:
        """Forget the stamps so far."""
        self._of_wrench, self._t_ns = np.empty(0, bool), np.empty(0, np.int64)
        # Messages before those that are kept, and of the last that was judged, by input.
        self._gone = 0
        self._judged = {True: -1, False: -1}
        self._apart_ns = 0

    @property
    def unsure(self) -> bool:
        """Whether the clocks are apart, or were a moment ago."""
        return self._set_ns >= 0 or self._is_apart

    @property
    def hides(self) -> bool:  # type: ignore[override]
        """Whether what others make of the stamps is no setting."""
        return self.unsure

    @property
    def _is_apart(self):
        return abs(self._apart_ns) > CLOCK_STEP_TEST.least_ns

    def findings(self) -> tuple[Finding, ...]:
        """Return each step."""
        return tuple(self._told)

    def take_stamps(self, of_wrench: np.ndarray, t_ns: np.ndarray) -> None:
        """Process messages in the order in which they came, see the package."""
        for kind in (True, False):
            first = t_ns[of_wrench == kind][:1]
            if len(first):
                self._begun_ns.setdefault(kind, int(first[0]))
        self._of_wrench = np.concatenate([self._of_wrench, of_wrench])
        self._t_ns = np.concatenate([self._t_ns, t_ns])
        gone = max(len(self._t_ns) - CLOCK_STEP_TEST.kept, 0)
        self._of_wrench, self._t_ns = self._of_wrench[gone:], self._t_ns[gone:]
        self._gone += gone

    def take(self, instant: Instant, unsure: bool) -> None:
        """Look at the jumps behind which enough has come."""
        now_ns = instant.sample.t_ns
        if not 0 <= now_ns - self._set_ns < CLOCK_STEP_TEST.settles_ns:
            self._set_ns = -1
        for of_wrench in (True, False):
            for jump in self._jumps(of_wrench):
                self._judge(of_wrench, jump, now_ns)

    def _jumps(self, of_wrench):
        """Return jumps of one input that are alone, and not yet judged."""
        around, least = CLOCK_STEP_TEST.around, CLOCK_STEP_TEST.least_ns
        places = np.flatnonzero(self._of_wrench == of_wrench)
        if len(places) <= 2 * around:
            return []
        stamps = self._t_ns[places]
        steps = np.diff(stamps)
        period = int(np.median(steps))
        at = np.flatnonzero(np.abs(steps - period) > least)
        found = []
        for k in at[at + around < len(steps)].tolist():
            number = int(places[k + 1]) + self._gone
            if number <= self._judged[of_wrench]:
                continue
            self._judged[of_wrench] = number
            alone = np.count_nonzero(np.abs(at - k) <= around) == 1
            if alone and k + 1 >= around and period > 0:
                size = int(steps[k]) - period
                at_ns = (
                    int(stamps[k]) + period if of_wrench else self._wrench_before(places[k + 1])
                )
                found.append(_Jump(int(places[k + 1]), size, at_ns, int(stamps[k + 1])))
        return found

    def _wrench_before(self, place):
        """Return the stamp of the wrench before a place [ns]."""
        before = np.flatnonzero(self._of_wrench[:place])
        return int(self._t_ns[before[-1]]) if len(before) else self._begun_ns.get(True, 0)

    def _judge(self, of_wrench, jump, now_ns):
        """Report a jump that is the clock's."""
        around = CLOCK_STEP_TEST.around
        begun_ns = self._begun_ns[of_wrench]
        again = jump.size_ns < 0 and jump.to_ns - begun_ns < CLOCK_STEP_TEST.again_ns
        leads = Leads().of(self._of_wrench, self._t_ns)[:, 1]
        joints = len(leads) - np.count_nonzero(~self._of_wrench[jump.place :])
        # While no wrench comes, joint states are ever farther ahead of the last one.
        wrenches = np.flatnonzero(self._of_wrench[: jump.place])
        silent = jump.place - int(wrenches[-1]) - 1 if of_wrench and len(wrenches) else 0
        last = max(joints - silent, 0)
        before, after = leads[max(last - around, 0) : last], leads[joints : joints + around]
        if again or min(len(before), len(after)) < CLOCK_STEP_TEST.fewest:
            return
        moved = float(np.median(after) - np.median(before))
        alone = -jump.size_ns if of_wrench else jump.size_ns
        near = CLOCK_STEP_TEST.near * abs(jump.size_ns)
        if abs(moved - alone) < near:
            self._apart_ns += alone
            self._set_ns = now_ns
            self._tell(self._said(of_wrench, jump))
        elif of_wrench and abs(moved) < near and -CLOCK_STEP_TEST.both_ns < jump.size_ns < 0:
            self._tell(self._said_of_both(jump))

    def _tell(self, text):
        if len(self._told) < CLOCK_STEP_TEST.most:
            self._told.append(Finding(text, {}, "clocks"))
            self.finding = self._told[0]

    def _since(self, jump):
        return f"{(jump.at_ns - self._begun_ns.get(True, jump.at_ns)) * 1e-9:.3f} s"

    def _said(self, of_wrench, jump):
        return (
            f"the clock of {self._topics[of_wrench]} was set {_by(jump)} at {self._since(jump)}, "
            f"and that of {self._topics[not of_wrench]} was not: while they are apart "
            "reactions are withheld. Let clocks be slewed, or set before the drivers start"
        )

    def _said_of_both(self, jump):
        return (
            f"the clocks of {self._topics[True]} and {self._topics[False]} were set {_by(jump)} "
            f"at {self._since(jump)}: what bears stamps of before that counts as late, and is not "
            "used. Let clocks be slewed, or set before the drivers start"
        )


def _by(jump):
    return (
        f"{'forward' if jump.size_ns > 0 else 'back'} by {number(abs(jump.size_ns) * 1e-9, 4)} s"
    )
