"""From estimates to rows of outputs, with the memory that mode, flag and alarms need."""

import numpy as np

from peg_on_hole_ros.estimator.held_peg import ContactSet, HeldPeg
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitoring import assessment, judgement, unjudged
from peg_on_hole_ros.monitoring.declared import UNKNOWN, Memory, new_memory, thresholds
from peg_on_hole_ros.monitoring.evidence import force_noise
from peg_on_hole_ros.monitoring.place import misfit
from peg_on_hole_ros.monitoring.row import SIZE
from peg_on_hole_ros.options import MonitorOptions

UNJUDGED = "modes, forecast, risk and alarms are off (monitor.modes)"
_SETS = {3: ContactSet.THREE, 2: ContactSet.TWO, 0: ContactSet.NONE, -1: ContactSet.UNKNOWN}


class Judge:
    """
    From estimates to rows of outputs, with the memory that mode, flag and alarms need.

    Parameters
    ----------
    scene : Scene
    options : MonitorOptions
    wrench_covariance : ndarray, shape (6, 6)
        Of a wrench about the mass centre, peg axes [N^2, N^2 m, N^2 m^2].

    Attributes
    ----------
    memory : Memory
        All that the next row depends on beside the filter.

    """

    def __init__(self, scene: Scene, options: MonitorOptions, wrench_covariance):
        self._scene, self._modes = scene, options.modes
        self._force_stddev = force_noise(scene, wrench_covariance)
        numbers = judgement.new_judgement(options, scene, self._force_stddev)
        self.memory: Memory = new_memory(numbers)
        self._thresholds = thresholds(options)
        self.restart()

    def retune(self, options: MonitorOptions):
        """Take other thresholds and times from here on; mode, flag, alarms and memory stay."""
        self._thresholds = thresholds(options)
        judgement.retune(self.memory.numbers, options, self._scene, self._force_stddev)

    @property
    def line(self) -> str:
        """What is left out, for diagnostics; empty: nothing."""
        return "" if self._modes else UNJUDGED

    @property
    def doubtful(self) -> bool:
        """Whether wrench and pose were looked at, and fit no mode."""
        return self._modes and self.memory.declared["mode"].item() == UNKNOWN

    @property
    def contacts(self) -> ContactSet:
        """Which contacts the next wrench is weighed with."""
        return _SETS[assessment.contacts_of(self.memory)]

    def restart(self):
        """Forget mode, flag, alarms and the motion."""
        (assessment.restart if self._modes else unjudged.restart_unjudged)(self.memory)

    def restart_mode(self):
        """Forget the mode: the estimate has begun anew."""
        (assessment.restart_mode if self._modes else unjudged.take_as_closed)(self.memory)

    def oriented(self, t_ns: int, q, R, foreseen: bool):
        """Take an orientation that the filter has used; see `assessment.take_orientation`."""
        if self._modes:
            assessment.take_orientation(self.memory, t_ns, q, R, foreseen)

    def placed(self, measurement, kalman: HeldPeg):
        """Take a measurement with a place of the peg; `kalman` knows the clearance."""
        if self._modes:
            found = misfit(measurement, *kalman.diameters)
            for name, value in zip(("offset", "deviations", "displaced"), found):
                self.memory.declared[name] = value

    def row(self, t_ns: int, kalman: HeldPeg, nis: float, blind: bool) -> np.ndarray:
        """
        Return what is published at a stamp, as laid out in `row`.

        `kalman` has taken the wrench of the stamp; for the rest see `assessment.assess`.
        """
        row = np.empty(SIZE)
        look = kalman.record, self.memory, self._thresholds, self._force_stddev
        if self._modes:
            assessment.assess(*look, kalman.scene.peg_height, t_ns, nis, blind, row)
        else:
            unjudged.look(*look, kalman.scene.peg_height, t_ns, blind, row)
        return row

    def snapshot(self) -> tuple[np.ndarray, ...]:
        """Return all that the next row depends on beside the filter, for `restore`."""
        return tuple(part.copy() for part in self.memory)

    def restore(self, snapshot: tuple[np.ndarray, ...]):
        """Go back to a snapshot; it can be gone back to again."""
        for part, kept in zip(self.memory, snapshot):
            part[:] = kept
