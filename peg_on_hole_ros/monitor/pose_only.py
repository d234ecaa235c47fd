"""What is published where `monitor.modes` is off: above gamma0 three contacts are assumed."""

from math import fabs

from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.estimator.fill_outputs import fill_outputs
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.alarms import clear_alarms
from peg_on_hole_ros.monitor.assessment import fill_declared, fill_known_outputs
from peg_on_hole_ros.monitor.evidence import (
    below_gamma0,
    finite_reactions,
    pushing,
    wedged_load,
)
from peg_on_hole_ros.monitor.known_quantities import fill_known
from peg_on_hole_ros.monitor.memory import Memory
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.states import Mode
from peg_on_hole_ros.monitor.transition import lower_flag, update_flag
from peg_on_hole_ros.outputs import Row

MODES_OFF = "modes, forecast, risk and alarms are off (monitor.modes)"


@compiled
def take_as_closed(memory: Memory) -> None:
    """Assume three contacts until the next wrench."""
    memory.declared.mode = Mode.UNKNOWN
    memory.declared.three_point_tried = True


@compiled
def restart_unjudged(memory: Memory) -> None:
    """Lower the flag; no alarm is looked at."""
    lower_flag(memory.transition)
    clear_alarms(memory.alarms)
    take_as_closed(memory)


@compiled
def assess_pose_only(
    estimate: Estimate,
    memory: Memory,
    settings: MonitorSettings,
    t_ns: int,
    blind: bool,
    row: Row,
) -> None:
    """
    Fill in what is published, as `assess`, for a peg that is on three contacts above gamma0.

    That is the user's word (`monitor.modes: false`), and nothing here looks whether it is true.
    """
    known, below = memory.known, below_gamma0(estimate)
    wedged = wedged_load(estimate, settings.force_stddev)
    usable = finite_reactions(estimate, wedged) and pushing(estimate)
    fill_known(known, estimate, fabs(estimate.determinant), settings.singular_band)
    if not blind:
        update_flag(memory.transition, settings, t_ns * 1e-9, below, 1.0)
    # An uncertain clearance is learnt by the equations of three contacts alone.
    doubt = settings.transition_probability_on if known.clearance_stddev > 0.0 else 0.5
    memory.declared.three_point_tried = below < doubt
    three_point = usable and below < 0.5 and not blind
    fill_known_outputs(row, below, known, three_point)
    fill_outputs(estimate, settings.peg_height, 3 if three_point else 0, wedged, row)
    fill_declared(row, memory)
