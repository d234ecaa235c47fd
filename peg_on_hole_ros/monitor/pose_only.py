"""What is published where modes, forecast and risk are left out: the pose alone is looked at."""

from math import fabs, nan

import numpy as np
from numba.np.unsafe.ndarray import to_fixed_tuple

from peg_on_hole_ros.estimator.description import SIZE as DESCRIBED
from peg_on_hole_ros.estimator.description import describe
from peg_on_hole_ros.estimator.record import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.alarms import clear_alarms
from peg_on_hole_ros.monitor.assessment import fill_declared, fill_known
from peg_on_hole_ros.monitor.evidence import (
    below_gamma0,
    finite_reactions,
    pushing,
    wedged_load,
)
from peg_on_hole_ros.monitor.judgement import BAND, KNOWN
from peg_on_hole_ros.monitor.known_quantities import Known
from peg_on_hole_ros.monitor.known_quantities import fill_known as know
from peg_on_hole_ros.monitor.memory import UNKNOWN
from peg_on_hole_ros.monitor.output_row import MODE, MONITOR
from peg_on_hole_ros.monitor.transition import lower_flag, raise_flag
from peg_on_hole_ros.record_types import MemoryRecord, ThresholdsRecord

LINE = "modes, forecast, risk and alarms are off (monitor.modes)"
_KNOWN = len(Known._fields)


@compiled
def take_as_closed(memory: MemoryRecord) -> None:
    """Take the peg as on three contacts until the next wrench."""
    memory.declared[0].mode = UNKNOWN
    memory.declared[0].on_trial = 1


@compiled
def restart_unjudged(memory: MemoryRecord) -> None:
    """Lower the flag; no alarm is looked at."""
    lower_flag(memory.declared[0])
    clear_alarms(memory)
    take_as_closed(memory)


@compiled
def look(
    estimate: Estimate,
    memory: MemoryRecord,
    o: ThresholdsRecord,
    force_stddev: float,
    peg_height: float,
    t_ns: int,
    blind: bool,
    row: np.ndarray,
) -> None:
    """
    Fill in what is published, as `assess`, for a peg that is on three contacts above gamma0.

    That is the user's word (`monitor.modes: false`), and nothing here looks whether it is true.
    """
    d, m = memory.declared[0], memory.numbers
    determinant, below = estimate.determinant, below_gamma0(estimate)
    wedged = wedged_load(estimate, force_stddev)
    usable = finite_reactions(estimate, determinant, wedged) and pushing(estimate)
    know(estimate, fabs(determinant), m[BAND], m[KNOWN:])
    known = Known(*to_fixed_tuple(m[KNOWN:], _KNOWN))  # type: ignore[call-arg]
    if not blind:
        raise_flag(d, o, t_ns * 1e-9, below, 1.0)
    # An uncertain clearance is learnt by the equations of three contacts alone.
    doubt = o.transition_probability_on if known.clearance_stddev > 0.0 else 0.5
    d.on_trial = below < doubt
    three_point = usable and below < 0.5 and not blind
    row[MONITOR:MODE] = nan
    fill_known(row, below, known, three_point)
    describe(estimate, peg_height, 3 if three_point else 0, wedged, row[:DESCRIBED])
    fill_declared(row, memory)
