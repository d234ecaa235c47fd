"""Fixed-interval smoothing: what a whole recording says of every one of its stamps."""

import numpy as np

from peg_on_hole_ros.estimation.filters.contact import ContactFilter, Prediction
from peg_on_hole_ros.estimation.filters.flow import (
    FRICTION,
    Flow,
    joint_estimate,
    scaled_gain,
)
from peg_on_hole_ros.mechanics.kernel import WIDTH

# What stays when a wrench is let go: state, friction and peg diameter.
_KEPT = [0, 1, 2, 3, 4, 5, 12, 13]


class _Record:
    # A prediction: joint mean and covariance before and after it, derivatives, and the joint
    # estimate when the wrench was let go (None while it is held). Without derivatives: the filter
    # was restarted when it stood at `before`.
    __slots__ = ("before", "F", "after", "end")

    def __init__(self, before, F=None, after=None):
        self.before, self.F, self.after, self.end = before, F, after, None


class SmoothingFilter(ContactFilter):
    """
    The extended Kalman filter, keeping what `smooth` needs: some 7 kB a prediction.

    Its own estimates are those of `ContactFilter`, bit for bit.
    """

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self._records: list[_Record] = []
        self._marks: list[tuple[int, int]] = []
        self._before = None

    def start(self, q, R):
        """Start; nothing later tells of what was before."""
        self._cut()
        super().start(q, R)

    def let_go(self):
        """Let go of the motion; nothing later tells of it."""
        self._cut()
        super().let_go()

    def _cut(self):
        if self._records and self._records[-1].F is not None:
            self._records.append(_Record(joint_estimate(self)))

    def hold(self, u):
        """Hold a new wrench."""
        if self._records and self._records[-1].end is None:
            self._records[-1].end = joint_estimate(self)
        super().hold(u)

    def predict(self, dt, in_contact):
        """Predict and keep how."""
        result = super().predict(dt, in_contact)
        F = np.eye(WIDTH)
        if result is Prediction.CONTACT:
            _, F, _ = Flow(self, dt)(self._before[0])
        else:
            F[range(3), range(3, 6)] = dt
            if self.friction[0] != self._before[0][FRICTION]:
                # Without a step it is sought elsewhere, apart from what it was.
                F[FRICTION] = 0.0
        self._records.append(_Record(self._before, F, joint_estimate(self)))
        return result

    def _begin(self, changed):
        self._before = joint_estimate(self)

    def take_friction(self, value, variance):
        """Take friction for a value of its own: a prediction that takes no time."""
        before, F = joint_estimate(self), np.eye(WIDTH)
        # What comes later tells nothing of what it was taken for before.
        F[FRICTION] = 0.0
        super().take_friction(value, variance)
        self._records.append(_Record(before, F, joint_estimate(self)))

    def widen(self, factor):
        """Widen, and keep that the last prediction led there."""
        before = self.joint_covariance()
        super().widen(factor)
        # As if the step had been so uncertain. What was corrected since stays out of it.
        if self._records and self._records[-1].F is not None:
            mean, Z = self._records[-1].after
            self._records[-1].after = mean, Z + (self.joint_covariance() - before)

    def mark(self, t_ns):
        """Note that the estimate is that of a stamp [ns]."""
        self._marks.append((t_ns, len(self._records)))

    def snapshot(self):
        """Return what `restore` takes back."""
        last = self._records[-1] if self._records else _Record(None)
        return super().snapshot(), len(self._records), len(self._marks), (last.after, last.end)

    def restore(self, snapshot):
        """Go back to a snapshot."""
        kalman, records, marks, of_last = snapshot
        super().restore(kalman)
        del self._records[records:], self._marks[marks:]
        if self._records:
            # It may have been widened since, and its wrench let go.
            self._records[-1].after, self._records[-1].end = of_last

    def estimate(self):
        """Return what another filter goes on from; the records are of this one alone."""
        return super().snapshot()

    def go_on_from(self, estimate):
        """Take another estimate, of which nothing later tells what was before."""
        self._cut()
        super().restore(estimate)

    def smooth(self):
        """
        Return the smoothed state at every marked stamp (Rauch, Tung and Striebel).

        The wrench's error is part of the joint state while the wrench is held, and independent
        of the next one's; friction and peg diameter are part of it throughout. Nothing passes a
        restart of the filter.

        Returns
        -------
        t_ns : list of int
            [ns].
        x : ndarray, shape (n, 6)
        P : ndarray, shape (n, 6, 6)

        """
        count = len(self._records)
        mean, Z = joint_estimate(self)
        x, P = np.empty((count + 1, 6)), np.empty((count + 1, 6, 6))
        x[count], P[count] = mean[:6], Z[:6, :6]
        for k in range(count - 1, -1, -1):
            record = self._records[k]
            if record.F is None:
                mean, Z = record.before
            else:
                if record.end is not None:
                    kept = mean[_KEPT], Z[np.ix_(_KEPT, _KEPT)]
                    then, Z_then = record.end
                    before = then[_KEPT], Z_then[np.ix_(_KEPT, _KEPT)]
                    mean, Z = _back(then, Z_then, np.eye(WIDTH)[_KEPT], *before, *kept)
                mean, Z = _back(*record.before, record.F, *record.after, mean, Z)
            x[k], P[k] = mean[:6], Z[:6, :6]
        places = [place for _, place in self._marks]
        return [t_ns for t_ns, _ in self._marks], x[places], P[places]


def _back(mean, Z, F, predicted, predicted_Z, smoothed, smoothed_Z):
    gain = scaled_gain(Z @ F.T, predicted_Z)
    back = Z + gain @ (smoothed_Z - predicted_Z) @ gain.T
    return mean + gain @ (smoothed - predicted), (back + back.T) / 2
