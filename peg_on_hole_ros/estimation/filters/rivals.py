"""Filters that begin with other friction coefficients, until it is told which one fits."""

from collections.abc import Callable
from math import exp, log, sqrt

import numpy as np

from peg_on_hole_ros.estimation.filters.contact import ContactFilter
from peg_on_hole_ros.estimation.filters.outcomes import NO_STEP, Correction, Prediction
from peg_on_hole_ros.estimation.kernel.parameters import LEAST_FRICTION
from peg_on_hole_ros.estimation.steps.choice import LONG_STEP

# So many stated standard deviations from the stated friction they begin.
BEGIN_AT = (-2.0, 2.0)
# One whose log-likelihood is greater by this takes the place of the estimate, and one whose is
# smaller by that is given up. With 3 for 7 noise replaces estimates that are right.
CONVINCING = 7.0
HOPELESS = 12.0
# One that has steps gets so far ahead in this time [s] without any at the estimate's friction; but
# not at long intervals, where the noise of one wrench leaves no step just as well.
NO_STEP_FOR = 0.04
# Bridged, they are compared by their forces: how far these are out of balance, squared and white,
# may be more than a rival's by as much as it is in the mean. That is what one counts as that has
# steps; and more than UNBALANCED counts as that, so that one wrench decides nothing.
BALANCED, UNBALANCED = 3.0, 12.0
# Of a normalised innovation so much counts at most: an outlier decides nothing.
MOST = 25.0
# Two that have come together within this share of the smaller spread are one, once friction is
# known to less than that share of its stated variance.
ALIKE = 0.3
LEARNT = 0.8


class _Rival:
    __slots__ = ("filter", "ahead", "stepped", "balanced")

    def __init__(self, kalman: ContactFilter, ahead: float):
        self.filter, self.ahead, self.stepped = kalman, ahead, False
        # How much better than the estimate's its forces are in balance.
        self.balanced = 0.0

    @property
    def lead(self):
        return self.ahead + self.balanced

    def snapshot(self):
        return self.filter.snapshot(), (self.ahead, self.stepped, self.balanced)

    def restore(self, snapshot):
        kalman, (self.ahead, self.stepped, self.balanced) = snapshot
        self.filter.restore(kalman)


class Rivals:
    """
    Filters beside the estimate's own, each with a friction coefficient of its own.

    A filter follows one tangent. Where a motion fits two coefficients it finds the one that lies
    downhill from where it began, and states it surely. The likelihood of the innovations tells
    them apart: sums of filters (Alspach and Sorenson, IEEE Trans. Automatic Control 17, 1972), of
    which here the likeliest alone is given out. While the estimate is bridged its innovations tell
    nothing of friction, and the balance of forces does.

    Parameters
    ----------
    make : callable
        Returns a filter of the estimate's settings and method; nobody else sees it.

    Attributes
    ----------
    count : int
        How many there are; none once it is told which one fits, or before it is asked.

    """

    def __init__(self, make: Callable[[], ContactFilter]):
        self._make = make
        self.restart()

    def restart(self):
        """Give all of them up; a friction that is open asks again with the next contact."""
        self._all: list[_Rival] = []
        self._asked = self._stepped = False

    def ask_again(self):
        """Begin once more with the next contact of a friction that is open, if there are none."""
        self._asked = bool(self._all)

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self._all)

    def begin(self, kalman: ContactFilter):
        """Begin beside an estimate that comes into contact, if its friction is open; once."""
        wanted = kalman.options.friction_rivals and kalman.friction_is_open
        # Beside a clearance that is learnt as well more than two pairs fit a motion.
        if self._asked or not wanted or kalman.learns_clearance:
            return
        self._asked = True
        stated, stddev = kalman.stated_friction
        for distance in BEGIN_AT:
            rival = self._make()
            rival.go_on_from(kalman.estimate())
            rival.take_friction(max(stated + distance * stddev, LEAST_FRICTION), stddev**2)
            self._all.append(_Rival(rival, -0.5 * distance**2))

    def start(self, q, R):
        """Start from an orientation."""
        for rival in self._all:
            rival.filter.start(q, R)

    def let_go(self):
        """Let go of the motion; what they know of friction stays."""
        for rival in self._all:
            rival.filter.let_go()

    def hold(self, u):
        """Hold a new wrench."""
        for rival in self._all:
            rival.filter.hold(u)

    def predict(self, dt: float, in_contact: bool, kalman: ContactFilter, own: Prediction):
        """
        Predict over dt [s].

        Parameters
        ----------
        dt : float
            [s].
        in_contact : bool
            Whether under the contact equations.
        kalman : ContactFilter
            The estimate, right after its own prediction.
        own : Prediction
            What became of that.

        """
        self._stepped = own is Prediction.CONTACT
        off = _unbalance(kalman, self._stepped)
        for rival in self._all:
            rival.stepped = rival.filter.predict(dt, in_contact) is Prediction.CONTACT
            if own in NO_STEP and rival.stepped and dt <= LONG_STEP:
                rival.ahead += (CONVINCING + 2.0) * dt / NO_STEP_FOR
            its = _unbalance(rival.filter, rival.stepped)
            if off is not None and its is not None:
                rival.balanced = max(rival.balanced + 0.5 * (off - its - BALANCED), 0.0)

    def correct(self, q, R, kalman: ContactFilter, correction: Correction, nis: float) -> bool:
        """
        Correct by an orientation; put the likeliest in the place of the estimate.

        One whose friction leaves no step is bridged, and foretells no worse than many that still
        learn theirs: it says nothing of friction, so that it can lose by it and not win.

        Parameters
        ----------
        q, R : ndarray
            As for `ContactFilter.correct`.
        kalman : ContactFilter
            The estimate, right after its own correction by them.
        correction : Correction
            What became of that.
        nis : float
            The normalised innovation squared of it.

        Returns
        -------
        bool
            Whether the estimate is another one now.

        """
        if not self._all:
            return False
        for rival in self._all:
            result, its = rival.filter.correct(q, R)
            if Correction.RESET in (result, correction) or not self._stepped:
                # Begun anew, or bridged, the estimate has foretold nothing by its friction.
                continue
            gain = _likelihood(rival.filter, its) - _likelihood(kalman, nis)
            rival.ahead += gain if rival.stepped else min(gain, 0.0)
        for one in (kalman, *(rival.filter for rival in self._all)):
            # As long as friction may be another one, it is friction that makes innovations lean.
            one.trust_steps()
        replaced = self._replace(kalman)
        value, spread = kalman.friction
        known = _learnt(kalman)
        self._all = [
            rival
            for rival in self._all
            if rival.lead > -HOPELESS and not (known and _alike(rival, value, spread))
        ]
        return replaced

    def widened(self, kalman: ContactFilter, normal, stddev) -> tuple[float, np.ndarray]:
        """
        Return by how much friction and reactions may be off, should a rival be right.

        Root of the second moment about what is given out, of the sum of all by their likelihood;
        no less than the estimate's own. Until friction is learnt its own spread holds them all.

        Parameters
        ----------
        kalman : ContactFilter
            The estimate.
        normal, stddev : ndarray, shape (3,)
            Its reactions as they are given out, and their standard deviations [N].

        Returns
        -------
        friction : float
        normal : ndarray, shape (3,)
            [N].

        """
        value, spread = kalman.friction
        if not self._all or not _learnt(kalman):
            return spread, stddev
        total, forces = 1.0, 1.0
        friction, squares = spread**2, stddev**2
        for rival in self._all:
            weight = exp(min(rival.lead, CONVINCING))
            its, its_spread = rival.filter.friction
            total += weight
            friction += weight * (its_spread**2 + (its - value) ** 2)
            found = rival.filter.reactions()
            if found is not None:
                forces += weight
                off = np.square(np.subtract(found.normal, normal))
                squares = squares + weight * (np.square(found.normal_stddev) + off)
        return (
            max(spread, sqrt(friction / total)),
            np.maximum(stddev, np.sqrt(squares / forces)),
        )

    def _replace(self, kalman):
        best = max(self._all, key=lambda rival: rival.lead)
        lead = best.lead
        if lead <= CONVINCING or not (best.stepped or best.balanced > 0.0):
            return False
        own = kalman.estimate()
        kalman.go_on_from(best.filter.estimate())
        best.filter.go_on_from(own)
        for rival in self._all:
            rival.ahead, rival.balanced = rival.lead - lead, 0.0
        best.ahead = -lead
        return True

    def snapshot(self):
        """Return what `restore` takes back."""
        rivals = [(rival, rival.snapshot()) for rival in self._all]
        return self._asked, self._stepped, rivals

    def restore(self, snapshot):
        """Go back to a snapshot; it can be gone back to again."""
        self._asked, self._stepped, rivals = snapshot
        self._all = []
        for rival, its in rivals:
            rival.restore(its)
            self._all.append(rival)


def _learnt(kalman):
    return kalman.friction[1] ** 2 < LEARNT * kalman.stated_friction[1] ** 2


def _likelihood(kalman, nis):
    """Return the logarithm of an innovation's density, but for a constant."""
    # One that the gate has widened for it has foretold worse than MOST lets it count. As it was
    # before, pure align at 1 rad/s that is told half as much again is 19 % off, for 2 %.
    _, root = kalman.last_innovation()
    return -0.5 * min(nis, MOST) - log(root[0] * root[4] * root[8])


def _unbalance(kalman, stepped):
    """Return how far its forces are out of balance, squared and white; None: nothing says."""
    white = kalman.unbalance
    if white is None:
        return BALANCED if stepped else None
    return min(sum(one * one for one in white), UNBALANCED)


def _alike(rival, value, spread):
    its, its_spread = rival.filter.friction
    return abs(its - value) < ALIKE * min(spread, its_spread)
