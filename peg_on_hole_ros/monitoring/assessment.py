"""What an estimate says of the contact: mode, transition, risk, alarms, and what is published."""

from peg_on_hole_ros.estimator.held_peg import ContactSet, HeldPeg
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitoring.alarms import Alarms
from peg_on_hole_ros.monitoring.evidence import Shown, force_noise
from peg_on_hole_ros.monitoring.jamming import Risk
from peg_on_hole_ros.monitoring.judgement import (
    KNOWN,
    RISK,
    SHOWN,
    break_course,
    follow_orientation,
    forget,
    forget_motion,
    judge,
    new_judgement,
    retune,
)
from peg_on_hole_ros.monitoring.known import Known
from peg_on_hole_ros.monitoring.mode import ContactMode
from peg_on_hole_ros.monitoring.place import Misfit, misfit
from peg_on_hole_ros.monitoring.remembering import recall, remember
from peg_on_hole_ros.monitoring.transition import TransitionFlag
from peg_on_hole_ros.options import MonitorOptions
from peg_on_hole_ros.records import Alarm, Outputs


class Assessment:
    """
    From estimates to outputs, with the memory that mode, flag and alarms need.

    Parameters
    ----------
    scene : Scene
    options : MonitorOptions
    wrench_covariance : ndarray, shape (6, 6)
        Of a wrench about the mass centre, peg axes [N^2, N^2 m, N^2 m^2].

    Attributes
    ----------
    line : str
        What is left out, for diagnostics: nothing.

    """

    line = ""

    def __init__(self, scene: Scene, options: MonitorOptions, wrench_covariance):
        self._options, self._scene = options, scene
        self._mode = ContactMode(options)
        self._flag = TransitionFlag(options)
        self._alarms = Alarms(options)
        self._force_stddev = force_noise(scene, wrench_covariance)
        self._memory = new_judgement(options, scene, self._force_stddev)
        self._t_ns: int | None = None
        self._oriented_ns: int | None = None
        self._on_trial = False
        self._misfit: Misfit | None = None

    def retune(self, options: MonitorOptions):
        """Take other thresholds and times from here on; mode, flag, alarms and memory stay."""
        self._options = self._mode.options = self._flag.options = options
        self._alarms.retune(options)
        retune(self._memory, options, self._scene, self._force_stddev)

    @property
    def mode(self) -> str:
        """The contact mode that was declared last."""
        return self._mode.mode

    @property
    def doubtful(self) -> bool:
        """Whether wrench and pose were looked at, and fit no mode."""
        return self._mode.mode == "unknown"

    @property
    def on_contacts(self) -> bool:
        """
        Whether the peg is to be predicted on three contacts.

        Beside the mode: where an uncertain clearance alone leaves it open whether the peg is
        already in the hole, only the equations of three contacts can tell, by learning it.
        """
        return self._mode.mode == "three_point" or self._on_trial

    @property
    def contacts(self) -> ContactSet:
        """Which contacts the next wrench is weighed with."""
        if self.on_contacts:
            return ContactSet.THREE
        return ContactSet.NONE if self._mode.mode == "open" else ContactSet.UNKNOWN

    def restart(self):
        """Forget mode, flag, alarms and the motion."""
        self.restart_mode()
        forget_motion(self._memory)
        self._flag.restart()
        self._alarms.restart()
        self._told: tuple[Alarm, ...] = ()

    def restart_mode(self):
        """Forget the mode: the estimate has begun anew."""
        self._mode.restart()
        forget(self._memory)
        self._t_ns = self._oriented_ns = None
        self._on_trial = False
        self._misfit = None

    def oriented(self, t_ns: int, q, R, foreseen: bool):
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
        foreseen : bool
            Whether the peg has moved as the filter predicted, without any widening.

        """
        since = -1.0 if self._oriented_ns is None else (t_ns - self._oriented_ns) * 1e-9
        self._oriented_ns = t_ns
        follow_orientation(self._memory, since, q, R)
        if not foreseen:
            break_course(self._memory)

    def placed(self, measurement, kalman: HeldPeg):
        """Take a measurement with a place of the peg; `kalman` knows the clearance."""
        self._misfit = misfit(measurement, *kalman.diameters)

    def snapshot(self):
        """Return all that the next outputs depend on beside the filter, for `restore`."""
        return remember(self)

    def restore(self, snapshot):
        """Go back to a snapshot."""
        recall(snapshot)

    def outputs(self, t_ns: int, kalman: HeldPeg, nis: float, blind: bool) -> Outputs:
        """
        Return what is published at a stamp.

        Parameters
        ----------
        t_ns : int
        kalman : HeldPeg
            Which has taken the wrench of the stamp.
        nis : float
            Running mean of the normalised innovation squared (3 degrees of freedom).
        blind : bool
            Whether no orientation has come for long: where the peg is is a guess, so that no risk
            is told, and flag and alarms stay as they are.

        """
        if blind:
            self.restart_mode()
        t = t_ns * 1e-9
        dt = 0.0 if self._t_ns is None else (t_ns - self._t_ns) * 1e-9
        self._t_ns = t_ns
        determinant = kalman.determinant
        since = 0.0 if self._oriented_ns is None else (t_ns - self._oriented_ns) * 1e-9
        # Constant rates say nothing for or against three contacts.
        nis = nis if self.on_contacts else -1.0
        displaced = 0.0 if self._misfit is None else self._misfit.evidence
        judge(kalman.record, self._memory, dt, since, nis, determinant, displaced)
        numbers = self._memory[SHOWN:].tolist()
        shown = Shown._make(numbers[: RISK - SHOWN])
        risk = Risk._make(numbers[RISK - SHOWN : KNOWN - SHOWN])
        known = Known._make(numbers[KNOWN - SHOWN :])
        mode = self._mode.update(t, shown)
        if not blind:
            self._flag.update(t, shown.below, 1.0 - shown.free)
        flag = self._flag.raised
        options = self._options
        self._on_trial = (
            known.clearance_stddev > 0.0
            and not flag
            and shown.three_point >= 1.0 - options.transition_probability_on
            and shown.three_point + shown.two_point >= options.mode_probability_on
        )
        three_point = mode == "three_point" and shown.usable > 0.0
        monitor = {
            "transition_probability": shown.below,
            "three_point_validity": shown.three_point + shown.stuck,
            "mode_probability_three_point": shown.three_point,
            "mode_probability_two_point": shown.two_point,
            "mode_probability_opened": shown.opened,
            "mode_probability_stuck": shown.stuck,
            "mode_probability_free": shown.free,
            "mode_probability_unknown": shown.other,
            "friction": known.friction,
            "friction_stddev": known.friction_stddev,
            "clearance": known.clearance,
            "clearance_stddev": known.clearance_stddev,
            "reactions_determined": known.reactions if three_point else 0.0,
        }
        if self._misfit is not None:
            monitor["position_offset"] = self._misfit.offset
            monitor["position_misfit"] = self._misfit.deviations
        touch = self._mode.touch
        if touch is not None:
            monitor["contact_age" if touch.onset else "free_age"] = t - touch.t
            monitor["contact_latency" if touch.onset else "free_latency"] = touch.latency
        if mode != "open" and not blind:
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
        elif mode != "open":
            wide = shown.wedged
        estimate = kalman.describe(three_point, wide)
        normal = estimate.normal.tolist()
        if not blind:
            self._told = self._alarms.update(t, mode, risk, shown, normal)
        alarms = self._told
        return Outputs(
            t_ns, *estimate[:6], estimate.normal > 0, *estimate[6:], monitor, mode, flag, alarms
        )
