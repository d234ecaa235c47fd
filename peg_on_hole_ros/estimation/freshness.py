"""Which wrenches and orientations are news, where drivers repeat values under fresh stamps."""

from math import cos, sin, sqrt

from peg_on_hole_ros.estimation.repeats import SINCE, held, new_repeats, notice, said
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample

# Standard deviations by which the peg has turned away from a value that is repeated.
TURNED = 5.0
# A value that is repeated for so long while the peg turns is told [s].
TOLD = 0.05


class Freshness:
    """
    Tells values that are news from those that a driver repeats.

    Attributes
    ----------
    still : bool
        Whether orientations repeat one value while the peg turns, for longer than TOLD.
    stuck : float
        For how long orientations have repeated one value while the peg turned, at most [s].

    """

    def __init__(self):
        self._wrench, self._joints = new_repeats(6), new_repeats(3)
        self._left = self.still = False
        self.stuck = 0.0

    def snapshot(self):
        """Return what `restore` takes back."""
        return self._wrench.copy(), self._joints.copy(), self._left, self.still

    def restore(self, snapshot) -> None:
        """Go back to a snapshot; it can be gone back to again."""
        wrench, joints, self._left, self.still = snapshot
        self._wrench, self._joints = wrench.copy(), joints.copy()

    def wrench(self, sample: WrenchSample) -> int:
        """Take a wrench; return of how many messages its value is one, as a rule."""
        notice(self._wrench, sample.t_ns * 1e-9, (*sample.force, *sample.torque))
        return held(self._wrench)

    def orientation(self, measurement: AngleMeasurement, q, variance: float) -> bool:
        """
        Take an orientation; return whether it is news.

        Encoders at rest, and coarse ones, repeat what is true. So a repeated value is none where
        each comes several times as a rule, or where the peg has turned away from it.

        Parameters
        ----------
        measurement : AngleMeasurement
        q : ndarray, shape (3,)
            gamma, psi, phi as predicted [rad].
        variance : float
            Of the prediction's tilt [rad^2].

        """
        found = measurement.q
        if notice(self._joints, measurement.t_ns * 1e-9, found) == 1:
            self._left = self.still = False
            return True
        if held(self._joints) > 1:
            return False
        gamma, psi, phi = (q - found).tolist()
        s, c = sin(found.item(0)), cos(found.item(0))
        turned = sqrt(gamma * gamma + (s * psi) ** 2 + (phi + c * psi) ** 2)
        noise = sqrt(measurement.covariance.item(0) + max(variance, 0.0))
        # The prediction's spread grows without news: what has left a value does not come back.
        self._left = self._left or turned > TURNED * noise
        if self._left:
            seconds = measurement.t_ns * 1e-9 - self._joints.item(SINCE)
            self.still = seconds > TOLD
            self.stuck = max(self.stuck, seconds)
        return not self._left

    @property
    def causes(self) -> list[str]:
        """What there is to say, a line for each source."""
        held_wrench, held_joints = said(self._wrench), said(self._joints)
        told = [f"wrench: {held_wrench}"] if held_wrench else []
        if held_joints:
            told.append(f"joints: {held_joints}")
        elif self.stuck > TOLD:
            told.append(
                f"joints: joint states that do not change for {self.stuck:.2f} s while the peg "
                "turns: the encoders or their driver stand still; they are not used"
            )
        return told
