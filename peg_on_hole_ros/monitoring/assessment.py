"""What an estimate says of the contact: mode, transition, risk, alarms, and what is published."""

from math import sqrt

import numpy as np

from peg_on_hole_ros.estimation.filter import ContactFilter
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitoring import jamming
from peg_on_hole_ros.monitoring.alarms import Alarms
from peg_on_hole_ros.monitoring.carried import new_means
from peg_on_hole_ros.monitoring.contacts import no_knowledge
from peg_on_hole_ros.monitoring.evidence import WIDTH, Shown, settings, show
from peg_on_hole_ros.monitoring.jamming import Risk
from peg_on_hole_ros.monitoring.mode import ContactMode
from peg_on_hole_ros.monitoring.place import Misfit, misfit
from peg_on_hole_ros.monitoring.remembering import recall, remember
from peg_on_hole_ros.monitoring.transition import TransitionFlag
from peg_on_hole_ros.monitoring.trend import follow, new_trend
from peg_on_hole_ros.options import MonitorOptions
from peg_on_hole_ros.records import Outputs

_NO_DETERMINANT = float("nan")


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
        self._options = options
        self._mode = ContactMode(options)
        self._flag = TransitionFlag(options)
        self._alarms = Alarms(options)
        noise = np.diagonal(wrench_covariance)
        over_radius = 2 / scene.peg_diameter
        self._force_stddev = sqrt(noise[:3].max() + noise[3:].max() * over_radius**2)
        self._settings = settings(options, self._force_stddev, scene.clearance_stddev)
        self._ratio = scene.peg_diameter / scene.hole_diameter
        self._contacts, self._motion = no_knowledge(), new_trend()
        self._means = new_means()
        self._shown = np.zeros(WIDTH)
        self._limits, self._jamming = jamming.limits(options), jamming.new_memory()
        self._risk = np.zeros(len(Risk._fields))
        self._t_ns: int | None = None
        self._oriented_ns: int | None = None
        self._on_trial = False
        self._misfit: Misfit | None = None

    @property
    def mode(self) -> str:
        """The contact mode that was declared last."""
        return self._mode.mode

    @property
    def on_contacts(self) -> bool:
        """
        Whether the peg is to be predicted on three contacts.

        Beside the mode: where an uncertain clearance alone leaves it open whether the peg is
        already in the hole, only the equations of three contacts can tell, by learning it.
        """
        return self._mode.mode == "three_point" or self._on_trial

    def restart(self):
        """Forget mode, flag and alarms."""
        self.restart_mode()
        self._flag.restart()
        self._alarms.restart()

    def restart_mode(self):
        """Forget the mode: the estimate has begun anew."""
        self._mode.restart()
        self._contacts[:], self._means[:] = no_knowledge(), new_means()
        self._jamming[:] = jamming.new_memory()
        self._t_ns = self._oriented_ns = None
        self._on_trial = False
        self._misfit = None

    def oriented(self, t_ns: int, q, R):
        """
        Take an orientation that the filter has used.

        Parameters
        ----------
        t_ns : int
            [ns].
        q : ndarray, shape (3,)
            gamma, psi, phi [rad].
        R : ndarray, shape (3, 3)
            Covariance [rad^2].

        """
        options = self._options
        since = -1.0 if self._oriented_ns is None else (t_ns - self._oriented_ns) * 1e-9
        self._oriented_ns = t_ns
        follow(
            self._motion,
            since,
            q,
            R,
            self._ratio,
            options.forecast_acceleration_stddev,
            options.forecast_acceleration_time,
        )

    def placed(self, measurement, kalman: ContactFilter):
        """Take a measurement with a place of the peg; `kalman` knows the clearance."""
        self._misfit = misfit(measurement, kalman.scene_values, kalman.spread.item(3))

    def _assess_risk(self, kalman, shown, dt, since):
        contact, usable = 1.0 - shown.free, shown.usable > 0.0
        memories = kalman.memory, self._motion, self._jamming, self._limits
        jamming.assess(*memories, dt, since, contact, shown.below, shown.time, usable, self._risk)
        return Risk(*self._risk.tolist())

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
        t = t_ns * 1e-9
        dt = 0.0 if self._t_ns is None else (t_ns - self._t_ns) * 1e-9
        self._t_ns = t_ns
        solution = kalman.reactions()
        since = 0.0 if self._oriented_ns is None else (t_ns - self._oriented_ns) * 1e-9
        show(
            kalman.memory,
            self._contacts,
            self._means,
            self._motion,
            self._settings,
            dt,
            since,
            # Constant rates say nothing for or against three contacts.
            nis if self.on_contacts else -1.0,
            _NO_DETERMINANT if solution is None else solution.determinant,
            0.0 if self._misfit is None else self._misfit.evidence,
            self._shown,
        )
        shown = Shown(*self._shown.tolist())
        if not shown.usable:
            solution = None
        mode = self._mode.update(t, shown)
        flag = self._flag.update(t, shown.below, 1.0 - shown.free)
        clearance = kalman.clearance
        options = self._options
        self._on_trial = (
            clearance[1] > 0.0
            and not flag
            and shown.three_point >= 1.0 - options.transition_probability_on
            and shown.three_point + shown.two_point >= options.mode_probability_on
        )
        three_point = mode == "three_point" and solution is not None
        monitor = {
            "transition_probability": shown.below,
            "three_point_validity": shown.three_point + shown.stuck,
            "mode_probability_three_point": shown.three_point,
            "mode_probability_two_point": shown.two_point,
            "mode_probability_opened": shown.opened,
            "mode_probability_stuck": shown.stuck,
            "mode_probability_free": shown.free,
            "mode_probability_unknown": shown.other,
            "friction": kalman.friction[0],
            "friction_stddev": kalman.friction[1],
            "clearance": clearance[0],
            "clearance_stddev": clearance[1],
            "reactions_determined": 0.0,
        }
        if self._misfit is not None:
            monitor["position_offset"] = self._misfit.offset
            monitor["position_misfit"] = self._misfit.deviations
        touch = self._mode.touch
        if touch is not None:
            monitor["contact_age" if touch.onset else "free_age"] = t - touch.t
            monitor["contact_latency" if touch.onset else "free_latency"] = touch.latency
        risk = self._assess_risk(kalman, shown, dt, since)
        if mode != "open":
            monitor["jamming_risk"] = risk.risk
            monitor["jamming_wedging"] = risk.wedging
            monitor["jamming_stall"] = risk.stall
            monitor["jamming_load"] = risk.load
            if risk.insertion:
                monitor["insertion_ratio"] = risk.insertion
                monitor["whitney_margin"] = risk.margin
            else:
                monitor["determinant"] = risk.determinant
        # Nothing is known of the reactions elsewhere, but how large they can be: none in the air,
        # and otherwise what a rim of this tilt may wedge against what it carries.
        wide = self._force_stddev
        if three_point:
            if shown.time >= 0.0:
                monitor["time_to_transition"] = shown.time
                monitor["time_to_transition_stddev"] = shown.time_stddev
            band = self._options.singular_band
            # Beside the singular set: little is known with a spread of a third of the mean.
            spread_known = max(solution.normal_stddev) <= sum(solution.normal) / 9
            clear = spread_known and min(risk.determinant, abs(solution.determinant)) > band
            monitor["reactions_determined"] = 1.0 if clear else 0.0
        elif mode != "open":
            wide = shown.wedged
        estimate = kalman.describe(three_point, wide)
        normal = estimate.normal.tolist()
        alarms = self._alarms.update(t, mode, risk, shown, normal)
        return Outputs(
            t_ns, *estimate[:6], estimate.normal > 0, *estimate[6:], monitor, mode, flag, alarms
        )
