"""Hole and clearance: whether a peg moves on the rim as they are stated, by the robot's pose."""

from collections import deque
from math import exp, inf

import numpy as np

from peg_on_hole_ros.diagnosis.finding import CLEARANCE_OFF, Finding, listed
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import RIM_MOTION_TEST
from peg_on_hole_ros.estimator.orientation_noise import THIRD_DIFFERENCE
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy, rpy_of, tilt_axes
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.number_text import number

# What may be off: turns of the hole, the logarithm of the clearance, turns of the peg in its tool,
# and the way from the peg's lower end as stated to where it is, in its own axes.
_HOLE, _SIZE, _PEG, _TIP = slice(0, 2), slice(2, 3), slice(3, 5), slice(5, 8)
_KINDS = _HOLE, _SIZE, _PEG, _TIP
_VALUES = 8
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
        ("`joints.peg_rpy`: the peg leans by 1 to 57 degrees from where it is stated", "the same"),
        (
            "`joints.tip_frame`, `joints.peg_xyz`: the peg's lower end is elsewhere in the robot, "
            "by 5 mm and more",
            "the same",
        ),
    )
    WITHOUT_WRENCH = True

    def __init__(self, stated: Stated) -> None:
        scene, joints = stated.configuration.scene, stated.configuration.joints
        self._D, self._clearance = scene.hole_diameter, scene.hole_diameter - scene.peg_diameter
        self._R_RH = rotation_from_rpy(joints.hole_rpy)
        self._R_TP, self._tip = rotation_from_rpy(joints.peg_rpy), np.array(joints.peg_xyz)
        self.restart()

    def restart(self) -> None:
        """Forget all."""
        self._kept: deque = deque(maxlen=RIM_MOTION_TEST.kept)
        self._count = self._nearly = 0
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
        self._kept.append((measurement.t_ns, measurement.position, peg_axes(measurement.q)))
        self._count += 1
        if len(self._kept) == RIM_MOTION_TEST.kept and self._count % RIM_MOTION_TEST.every == 0:
            self._judge()

    def _judge(self):
        places, axes = (np.array([row[i] for row in self._kept]) for i in (1, 2))
        third = np.diff(places, 3, axis=0)
        noise = float(np.sqrt(np.mean(np.square(third)) / THIRD_DIFFERENCE))
        way = _rms(places - places.mean(axis=0))
        stated = _rms(self._left(np.zeros(_VALUES), places, axes))
        # Nearly upright no three contacts carry, and what they would ask for is far away.
        if not stated < self._D:
            self._nearly = 0
            return
        if not stated > max(RIM_MOTION_TEST.noisy * noise, RIM_MOTION_TEST.share * way):
            self._nearly = 0
            return
        fits = {kind.start: self._fit(kind, places, axes) for kind in _KINDS}
        test = RIM_MOTION_TEST

        def apart(kind):
            """Return what the others leave, over what a kind may leave beside them."""
            lefts = {other.start: fits[other.start][1] for other in _KINDS if other != kind}
            if kind in (_HOLE, _SIZE):
                # Gears that bend look like a peg that leans a little.
                lefts |= {at: lefts[at] / test.apart**2 for at in (_PEG.start, _TIP.start)}
            return test.apart * min(lefts.values())

        best = min(_KINDS, key=lambda kind: fits[kind.start][1] / apart(kind))
        values, left = fits[best.start]
        surely = {_PEG.start: test.surely, _TIP.start: test.surely_way}.get(best.start, 1.0)
        least = min(test.explained * stated, max(surely * stated, test.at_noise * noise))
        off = f"{number(1e3 * stated, 2)} mm"
        if left < min(least, apart(best)):
            to = f"{number(1e3 * left, 2)} mm instead of {off}"
            fits_so = f"with it the peg's path fits its tilt to {to}"
            self.finding = self._said(best, values, fits_so)
        # A path that nearly fits is one on the rim, and whatever is off, no contact is where it is
        # stated.
        self._nearly = self._nearly + 1 if left < test.explained * stated else 0
        if self.finding is None and self._nearly >= test.often:
            self.finding = Finding(
                f"the peg's path on the rim does not fit its tilt, by {off}, and no one setting "
                "explains it: check joints.peg_rpy, hole_rpy, peg_xyz, tip_frame, the order "
                "of joints.names, a joint's zero, and hole_diameter - peg_diameter",
                {},
                "joints",
                voids=True,
                hint=True,
            )

    def _said(self, kind, values, fits):
        """Return what is found where a kind fits; None: it is none that is told."""
        test = RIM_MOTION_TEST
        found = values[kind]
        off = float(np.linalg.norm(found))
        if kind is _HOLE and test.least_lean < off < test.most_lean:
            rpy = listed(rpy_of(self._R_RH @ tilt_axes(found)), 3)
            text = (
                f"the hole leans by {np.degrees(off):.0f} degrees from where it is stated: set "
                f"joints.hole_rpy: {rpy}; {fits}; a joint's zero that is off looks the same"
            )
            return Finding(text, {}, "joints", voids=True)
        if kind is _SIZE and test.least_larger < off < test.most_larger:
            size = 1e3 * self._clearance * exp(found[0])
            # Outer diameters of chamfers can only make it too large.
            of_chamfers = _OF_CHAMFERS if found[0] < 0.0 else ""
            text = f"{CLEARANCE_OFF} {number(size, 2)} mm; {fits}{of_chamfers}"
            return Finding(text, {}, "scene", voids=True)
        if kind is _PEG and test.least_turn < off < test.most_lean:
            rpy = listed(rpy_of(self._R_TP @ tilt_axes(found)), 3)
            text = (
                f"the peg leans by {np.degrees(off):.1f} degrees from where it is stated: set "
                f"joints.peg_rpy: {rpy}; {fits}"
            )
            return Finding(text, {}, "joints", voids=True)
        if kind is _TIP and test.least_way < off < test.most_way:
            xyz = listed(self._tip + self._R_TP @ found, 3)
            text = (
                f"the peg's lower end is {number(off)} m from where it is stated: set "
                f"joints.peg_xyz: {xyz}, or another joints.tip_frame; {fits}"
            )
            return Finding(text, {}, "joints", voids=True)
        return None

    def _fit(self, kind, places, axes):
        """Return values that fit best, of which some are free, and what they leave [m]."""
        free = range(kind.start, kind.stop)
        values = np.zeros(_VALUES)
        left = self._left(values, places, axes)
        for _ in range(RIM_MOTION_TEST.steps):
            slopes = np.empty((left.size, len(free)))
            for j, i in enumerate(free):
                moved = values.copy()
                moved[i] += RIM_MOTION_TEST.small
                changed = self._left(moved, places, axes) - left
                slopes[:, j] = changed.ravel() / RIM_MOTION_TEST.small
            if not np.isfinite(slopes).all():
                break
            step = np.zeros(_VALUES)
            step[kind] = np.linalg.lstsq(slopes, -left.ravel(), rcond=None)[0]
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
        Return what a path leaves where something is off, (n, 3) [m].

        Parameters
        ----------
        values : ndarray, shape (8,)
            How far it is off, see `_KINDS` [rad], [m].
        places, axes : ndarray, shape (n, 3), (n, 3, 3)
            Of the peg's lower end, and of the peg, in the axes of the hole as stated.

        """
        turn = tilt_axes(values[_HOLE])
        places = (places + axes @ values[_TIP]) @ turn
        up = (axes @ tilt_axes(values[_PEG])[:, 2]) @ turn
        larger = float(np.clip(values[_SIZE][0], -6.0, 4.0))
        D, d = self._D, self._D - self._clearance * exp(larger)
        s, c = np.hypot(up[:, 0], up[:, 1]), up[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            out, high = (D - d * c) / (2.0 * s), (d - D * c) / (2.0 * s)
        # As for `geometry`: h along the lean is out * s, the height high - out * c.
        path = np.column_stack([-out * up[:, 0], -out * up[:, 1], high - out * c])
        left = places - path
        return left - left.mean(axis=0)


def _rms(left):
    value = float(np.sqrt(np.mean(np.square(left))))
    return value if np.isfinite(value) else inf
