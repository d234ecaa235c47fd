"""Fixed-interval smoothing: what a whole recording says of every one of its stamps."""

import numpy as np

from peg_on_hole_ros.estimation.filters.contact import ContactFilter, Prediction
from peg_on_hole_ros.estimation.filters.flow import Flow, joint_estimate, scaled_gain
from peg_on_hole_ros.mechanics.kernel import WIDTH

# What stays when a wrench is let go: state, friction and peg diameter.
_KEPT = [0, 1, 2, 3, 4, 5, 12, 13]


class _Record:
    # A prediction: joint mean and covariance before and after it, derivatives, and the joint
    # estimate when the wrench was let go (None while it is held); cut: the filter then restarted.
    __slots__ = ("before", "F", "after", "end", "cut")

    def __init__(self, before, F, after):
        self.before, self.F, self.after = before, F, after
        self.end, self.cut = None, False


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
        if self._records:
            self._records[-1].cut = True
        super().start(q, R)

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
        self._records.append(_Record(self._before, F, joint_estimate(self)))
        return result

    def _begin(self, learnt):
        self._before = joint_estimate(self)

    def take_friction(self, value, variance):
        """Take friction for a value of its own: a prediction that takes no time."""
        before = joint_estimate(self)
        super().take_friction(value, variance)
        self._records.append(_Record(before, np.eye(WIDTH), joint_estimate(self)))

    def widen(self, factor):
        """Widen, and keep that the last prediction led there."""
        super().widen(factor)
        # As if the step had been so uncertain.
        if self._records:
            self._records[-1].after = self._records[-1].after[0], self.joint_covariance()

    def mark(self, t_ns):
        """Note that the estimate is that of a stamp [ns]."""
        self._marks.append((t_ns, len(self._records)))

    def snapshot(self):
        """Return what `restore` takes back."""
        cut = bool(self._records) and self._records[-1].cut
        return super().snapshot(), len(self._records), len(self._marks), cut

    def restore(self, snapshot):
        """Go back to a snapshot."""
        kalman, records, marks, cut = snapshot
        super().restore(kalman)
        del self._records[records:], self._marks[marks:]
        if self._records:
            self._records[-1].end, self._records[-1].cut = None, cut

    def estimate(self):
        """Return what another filter goes on from; the records are of this one alone."""
        return super().snapshot()

    def go_on_from(self, estimate):
        """Take another estimate, of which nothing later tells what was before."""
        if self._records:
            self._records[-1].cut = True
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
            if record.cut:
                mean, Z = record.after
            elif record.end is not None:
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
