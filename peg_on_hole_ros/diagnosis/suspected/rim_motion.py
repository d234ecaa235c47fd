"""Hole and clearance: whether a peg moves on the rim as they are stated, by the robot's pose."""

from collections import deque
from math import exp, inf

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import RIM_MOTION_TEST
from peg_on_hole_ros.estimator.orientation_noise import THIRD_DIFFERENCE
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy, rpy_of
from peg_on_hole_ros.mechanics.reference import peg_axes

_OF_CHAMFERS = "; are the stated diameters those of chamfers? They have to be of bore and shank"


class RimMotion(Suspect):
    """
    Fits the path of the peg's lower end to its tilt, as three contacts have it.

    Where the hole is counts for nothing: the path alone shows it, and a peg that hardly tilts has
    none. Of a peg that hangs free nothing is taken.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "rim_motion"
    FINDS = (
        (
            "`joints.hole_rpy`: the hole leans by 4 to 57 degrees from where it is stated",
            "a second on the rim in which the tilt changes, with `joints.hole_xyz_stddev` stated",
        ),
        (
            "`hole_diameter - peg_diameter` off by a factor of 1.4 to 50: too large where the "
            "diameters of chamfers are stated for those of bore and shank",
            "the same",
        ),
    )
    WITHOUT_WRENCH = True

    def __init__(self, stated: Stated) -> None:
        scene, joints = stated.configuration.scene, stated.configuration.joints
        self._D, self._clearance = scene.hole_diameter, scene.hole_diameter - scene.peg_diameter
        self._R_RH = rotation_from_rpy(joints.hole_rpy)
        self.restart()

    def restart(self) -> None:
        """Forget all."""
        self._kept: deque = deque(maxlen=RIM_MOTION_TEST.kept)
        self._count = 0
        self.finding: Finding | None = None

    def take(self, instant: Instant, unsure: bool) -> None:
        """Process an orientation with the peg's place, see the package."""
        measurement, free = instant.measured, instant.in_air is not False
        if measurement.position is None or free or self.finding is not None:
            self._kept.clear()
            return
        if self._kept:
            since = measurement.t_ns - self._kept[-1][0]
            if 0 <= since < RIM_MOTION_TEST.period_ns:
                return
            if not 0 < since < RIM_MOTION_TEST.silence_ns:
                self._kept.clear()
        axis = peg_axes(measurement.q)[:, 2]
        self._kept.append((measurement.t_ns, measurement.position, axis))
        self._count += 1
        if len(self._kept) == RIM_MOTION_TEST.kept and self._count % RIM_MOTION_TEST.every == 0:
            self._judge()

    def _judge(self):
        places, axes = (np.array([row[i] for row in self._kept]) for i in (1, 2))
        third = np.diff(places, 3, axis=0)
        noise = float(np.sqrt(np.mean(np.square(third)) / THIRD_DIFFERENCE))
        way = _rms(places - places.mean(axis=0))
        stated = _rms(self._left(np.zeros(3), places, axes))
        if not stated > max(RIM_MOTION_TEST.noisy * noise, RIM_MOTION_TEST.share * way):
            return
        (leans, by_turn), (larger, by_size) = (
            self._fit(free, places, axes) for free in ((0, 1), (2,))
        )
        test = RIM_MOTION_TEST
        least = test.explained * stated
        turn = float(np.hypot(leans[0], leans[1]))
        leans_so = test.least_lean < turn < test.most_lean
        larger_so = test.least_larger < abs(larger[2]) < test.most_larger
        if leans_so and by_turn < min(least, test.apart * by_size):
            rpy = [round(x, 3) + 0.0 for x in rpy_of(self._R_RH @ _turn(leans))]
            what = f"joints.hole_rpy: {rpy}"
            self.finding = Finding(
                f"with {what} the peg's path fits its tilt to {1e3 * by_turn:.2g} mm instead of "
                f"{1e3 * stated:.2g} mm: the hole leans by {np.degrees(turn):.0f} degrees from "
                "where it is stated",
                {},
                "joints",
                voids=True,
            )
        elif larger_so and by_size < min(least, test.apart * by_turn):
            size = 1e3 * self._clearance * exp(larger[2])
            # Outer diameters of chamfers can only make it too large.
            of_chamfers = _OF_CHAMFERS if larger[2] < 0.0 else ""
            self.finding = Finding(
                f"with hole_diameter - peg_diameter of {size:.2g} mm the peg's path fits its "
                f"tilt to {1e3 * by_size:.2g} mm instead of {1e3 * stated:.2g} mm{of_chamfers}",
                {},
                "scene",
                voids=True,
            )

    def _fit(self, free, places, axes):
        """Return values that fit best, of which some are free, and what they leave [m]."""
        values, left = np.zeros(3), self._left(np.zeros(3), places, axes)
        for _ in range(RIM_MOTION_TEST.steps):
            slopes = np.empty((left.size, len(free)))
            for j, i in enumerate(free):
                moved = values.copy()
                moved[i] += RIM_MOTION_TEST.small
                changed = self._left(moved, places, axes) - left
                slopes[:, j] = changed.ravel() / RIM_MOTION_TEST.small
            if not np.isfinite(slopes).all():
                break
            step = np.zeros(3)
            step[list(free)] = np.linalg.lstsq(slopes, -left.ravel(), rcond=None)[0]
            for _ in range(RIM_MOTION_TEST.steps):
                trial = self._left(values + step, places, axes)
                if _rms(trial) < _rms(left):
                    break
                step *= 0.5
            else:
                break
            values, left = values + step, trial
        return values, _rms(left)

    def _left(self, values, places, axes):
        """
        Return what a path leaves where a hole is turned, and its clearance another, (n, 3) [m].

        Parameters
        ----------
        values : ndarray, shape (3,)
            Turn about x and y [rad], and the log of the clearance over the stated one.
        places, axes : ndarray, shape (n, 3)
            Of the peg's lower end, and of its axis, in the axes of the hole as stated.

        """
        turn = _turn(values)
        places, axes = places @ turn, axes @ turn
        D, d = self._D, self._D - self._clearance * exp(min(values[2], 4.0))
        s, c = np.hypot(axes[:, 0], axes[:, 1]), axes[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            out, up = (D - d * c) / (2.0 * s), (d - D * c) / (2.0 * s)
        # As for `geometry`: h along the lean is out * s, the height up - out * c.
        path = np.column_stack([-out * axes[:, 0], -out * axes[:, 1], up - out * c])
        left = places - path
        return left - left.mean(axis=0)


def _turn(values):
    """Return the turn of a hole about its x and y, by a rotation vector (Rodrigues)."""
    angle = float(np.hypot(values[0], values[1]))
    if angle < 1e-12:
        return np.eye(3)
    x, y = values[0] / angle, values[1] / angle
    K = np.array([[0.0, 0.0, y], [0.0, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * (K @ K)


def _rms(left):
    value = float(np.sqrt(np.mean(np.square(left))))
    return value if np.isfinite(value) else inf
