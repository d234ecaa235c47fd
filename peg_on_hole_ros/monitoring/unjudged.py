"""What is published where modes, forecast and risk are left out: the pose alone is looked at."""

from math import fabs

import numpy as np

from peg_on_hole_ros.estimator.held_peg import ContactSet, HeldPeg
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitoring.evidence import (
    below_gamma0,
    finite_reactions,
    force_noise,
    pushing,
    wedged_load,
)
from peg_on_hole_ros.monitoring.known import Known, fill_known
from peg_on_hole_ros.monitoring.remembering import recall, remember
from peg_on_hole_ros.monitoring.transition import TransitionFlag
from peg_on_hole_ros.options import MonitorOptions
from peg_on_hole_ros.records import Outputs

_WIDTH = 3 + len(Known._fields)


class Unjudged:
    """
    From estimates to outputs, as `Assessment`, for a peg that is on three contacts above gamma0.

    That is the user's word (`monitor.modes: false`), and nothing here looks whether it is true.

    Parameters
    ----------
    scene : Scene
    options : MonitorOptions
    wrench_covariance : ndarray, shape (6, 6)
        Of a wrench about the mass centre, peg axes [N^2, N^2 m, N^2 m^2].

    Attributes
    ----------
    line : str
        What is left out, for diagnostics.

    """

    mode = "unknown"
    doubtful = False
    line = "modes, forecast, risk and alarms are off (monitor.modes)"

    def __init__(self, scene: Scene, options: MonitorOptions, wrench_covariance):
        self._options = options
        self._flag = TransitionFlag(options)
        self._force_stddev = force_noise(scene, wrench_covariance)
        self._seen = np.zeros(_WIDTH)
        self.restart()

    def retune(self, options: MonitorOptions):
        """Take other thresholds and times from here on; the flag stays."""
        self._options = self._flag.options = options

    @property
    def on_contacts(self) -> bool:
        """Whether the peg is taken as on three contacts."""
        return self._on_contacts

    @property
    def contacts(self) -> ContactSet:
        """Which contacts the next wrench is weighed with."""
        return ContactSet.THREE if self._on_contacts else ContactSet.UNKNOWN

    def restart(self):
        """Lower the flag."""
        self._flag.restart()
        self.restart_mode()

    def restart_mode(self):
        """Take the peg as on three contacts until the next wrench."""
        self._on_contacts = True

    def oriented(self, t_ns: int, q, R, foreseen: bool):
        """Take no notice of an orientation: there is no forecast."""

    def placed(self, measurement, kalman: HeldPeg):
        """Take no notice of a place either."""

    def snapshot(self):
        """Return all that the next outputs depend on beside the filter, for `restore`."""
        return remember(self)

    def restore(self, snapshot):
        """Go back to a snapshot."""
        recall(snapshot)

    def outputs(self, t_ns: int, kalman: HeldPeg, nis: float, blind: bool) -> Outputs:
        """Return what is published at a stamp; see `Assessment.outputs`."""
        options, determinant = self._options, kalman.determinant
        look(kalman.record, self._force_stddev, options.singular_band, determinant, self._seen)
        below, usable, wedged, *numbers = self._seen.tolist()
        known = Known._make(numbers)
        flag = self._flag.raised if blind else self._flag.update(t_ns * 1e-9, below, 1.0)
        # An uncertain clearance is learnt by the equations of three contacts alone.
        doubt = options.transition_probability_on if known.clearance_stddev > 0.0 else 0.5
        self._on_contacts = below < doubt
        three_point = usable > 0.0 and below < 0.5 and not blind
        monitor = {
            "transition_probability": below,
            "friction": known.friction,
            "friction_stddev": known.friction_stddev,
            "clearance": known.clearance,
            "clearance_stddev": known.clearance_stddev,
            "reactions_determined": known.reactions if three_point else 0.0,
        }
        estimate = kalman.describe(three_point, wedged)
        return Outputs(
            t_ns, *estimate[:6], estimate.normal > 0, *estimate[6:], monitor, self.mode, flag, ()
        )


@compiled
def look(f, force_stddev, band, determinant, out):
    """
    Fill in what the pose and the reactions show.

    Parameters
    ----------
    f : ndarray
        Record of the estimate.
    force_stddev : float
        Of a force that the rim carries [N].
    band : float
        `monitor.singular_band`.
    determinant : float
        Of the six equations, over its frictionless value.
    out : ndarray
        Filled: probability that gamma is below gamma0; 1 where the reactions can be used; what the
        rim may wedge [N]; then as `Known`.

    """
    wedged = wedged_load(f, force_stddev)
    out[0] = below_gamma0(f)
    out[1] = 1.0 if finite_reactions(f, determinant, wedged) and pushing(f) else 0.0
    out[2] = wedged
    fill_known(f, fabs(determinant), band, out[3:])
