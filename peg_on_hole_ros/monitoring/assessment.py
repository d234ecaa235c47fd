"""What an estimate says of the contact: mode, transition, risk, alarms, and what is published."""

from math import hypot, sin, sqrt

import numpy as np

from peg_on_hole_ros.estimation.filter import ContactFilter
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitoring.alarms import Alarms
from peg_on_hole_ros.monitoring.jamming import WedgingMargin, jamming_risk
from peg_on_hole_ros.monitoring.mode import ContactMode, Evidence
from peg_on_hole_ros.monitoring.remembering import recall, remember
from peg_on_hole_ros.monitoring.transition import (
    TransitionFlag,
    gamma0_stddev,
    time_to_transition,
    transition_probability,
)
from peg_on_hole_ros.options import MonitorOptions
from peg_on_hole_ros.records import Outputs

# Reactions beyond this many times the largest that a rim can wedge are rounding, not reactions.
ABSURD = 10.0


class Assessment:
    """
    From estimates to outputs, with the memory that mode, flag and alarms need.

    Parameters
    ----------
    scene : Scene
    options : MonitorOptions
    wrench_covariance : ndarray, shape (6, 6)
        Of a wrench about the mass centre, peg axes [N^2, N^2 m, N^2 m^2].
    scene_values : ndarray
        The fields of SceneScalars as the filter has them: friction and diameter may be learnt.

    """

    def __init__(self, scene: Scene, options: MonitorOptions, wrench_covariance, scene_values):
        self._scene = scene
        self._options = options
        self._mode = ContactMode(options)
        self._flag = TransitionFlag(options)
        self._alarms = Alarms(options)
        self._margin = WedgingMargin(scene_values)
        noise = np.diagonal(wrench_covariance)
        over_radius = 2 / scene.peg_diameter
        self._force_stddev = sqrt(noise[:3].max() + noise[3:].max() * over_radius**2)

    @property
    def mode(self) -> str:
        """The contact mode that was declared last."""
        return self._mode.mode

    def restart(self):
        """Forget mode, flag and alarms."""
        self.restart_mode()
        self._flag.restart()
        self._alarms.restart()

    def restart_mode(self):
        """Forget the mode: the estimate has begun anew."""
        self._mode.restart()

    def snapshot(self):
        """Return all that the next outputs depend on beside the filter, for `restore`."""
        return remember(self)

    def restore(self, snapshot):
        """Go back to a snapshot."""
        recall(snapshot)

    def outputs(self, t_ns: int, kalman: ContactFilter, nis: float) -> Outputs:
        """
        Return what is published at a stamp.

        Parameters
        ----------
        t_ns : int
        kalman : ContactFilter
            Predicted up to the stamp; its reactions are filled in.
        nis : float
            Running mean of the normalised innovation squared (3 degrees of freedom).

        """
        scene = self._scene
        # Plain floats: arithmetic on numpy's scalars costs several times as much.
        gamma, _, _, closing, _, _ = kalman.x.tolist()
        gamma_variance, covariance, rate_variance = kalman.tilt_covariance()
        gamma0, (_, clearance_stddev) = kalman.gamma0, kalman.peg_diameter
        spread0 = gamma0_stddev(gamma0, scene.hole_diameter, clearance_stddev)
        margin = gamma - gamma0
        variance = gamma_variance + spread0**2
        solution = kalman.reactions()
        force, couple = kalman.rim_load()
        # A squeezed peg feels a couple and no force: over the peg's radius it counts as one.
        carried = hypot(force, 2 * couple / scene.peg_diameter)
        # What a rim of this tilt may wedge against what it carries.
        wedged = (carried + self._force_stddev) / sin(max(gamma, gamma0))
        if solution is not None and max(map(abs, solution.normal)) > ABSURD * wedged:
            solution = None
        mode = self._mode.update(
            Evidence(
                t_ns * 1e-9,
                carried,
                self._force_stddev,
                margin,
                sqrt(variance),
                None if solution is None else solution.normal,
                None if solution is None else solution.normal_stddev,
                nis,
            )
        )
        three_point = mode == "three_point" and solution is not None
        probability = transition_probability(gamma, sqrt(gamma_variance), gamma0, spread0)
        flag = self._flag.update(probability, touching=mode in ("three_point", "two_point"))
        monitor = {
            "transition_probability": probability,
            "three_point_validity": self._mode.validity,
            "friction": kalman.friction[0],
            "friction_stddev": kalman.friction[1],
            "reactions_determined": 0.0,
        }
        risk = determinant = None
        if solution is not None and mode in ("three_point", "unknown"):
            # A wedged peg may fit no mode; what wedges it is its tilt and the direction of motion.
            determinant = self._margin.determinant(kalman.x, kalman.P)
            risk = jamming_risk(determinant)
            monitor["jamming_risk"] = risk
            monitor["determinant"] = determinant
        # Nothing is known of the reactions elsewhere, but how large they can be: none in the air,
        # and otherwise what a rim of this tilt may wedge against what it carries.
        wide = self._force_stddev
        if three_point:
            forecast = time_to_transition(margin, closing, variance, rate_variance, covariance)
            if forecast:
                monitor["time_to_transition"], monitor["time_to_transition_stddev"] = forecast
            band = self._options.singular_band
            # Beside the singular set: little is known with a spread of a third of the mean.
            spread_known = max(solution.normal_stddev) <= sum(solution.normal) / 9
            clear = spread_known and min(determinant, abs(solution.determinant)) > band
            monitor["reactions_determined"] = 1.0 if clear else 0.0
        elif mode != "open":
            wide = wedged
        estimate = kalman.describe(three_point, wide)
        normal, stddev = estimate.normal.tolist(), estimate.normal_stddev.tolist()
        alarms = self._alarms.update(t_ns * 1e-9, mode, risk, determinant, normal, stddev)
        return Outputs(
            t_ns, *estimate[:6], estimate.normal > 0, *estimate[6:], monitor, mode, flag, alarms
        )
