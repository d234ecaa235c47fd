"""Dangers by their members: the one place that lists them, and the risk that they add up to."""

from enum import IntEnum

from peg_on_hole_ros.estimator.estimate import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.closing_push import (
    NOT_PUSHED,
    Push,
    follow_total,
    forget_push,
    pushed_on,
)
from peg_on_hole_ros.monitor.dangers import load, stall, stuck, wedging
from peg_on_hole_ros.monitor.dangers.load import Load
from peg_on_hole_ros.monitor.dangers.situation import (
    Situation,
    horizon_on_rim,
    reactions_usable,
    touches,
)
from peg_on_hole_ros.monitor.dangers.stall import Stall
from peg_on_hole_ros.monitor.dangers.stuck import Stuck
from peg_on_hole_ros.monitor.dangers.wedging import Wedging
from peg_on_hole_ros.monitor.evidence import Shown
from peg_on_hole_ros.monitor.motion_now import Passed, moving_now
from peg_on_hole_ros.monitor.motion_trend import MotionTrend
from peg_on_hole_ros.monitor.rest_in_hole import DepthTrend
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.outputs import Row
from peg_on_hole_ros.typed_record import Floats, Record

# docs/jamming.md has the definition of each danger and its derivation.


class Danger(IntEnum):
    """What may jam the peg."""

    LOAD = 0
    STUCK = 1
    STALL = 2
    WEDGING = 3


# By member: what the alarm states at WARN and at ERROR.
ADVICE = (load.ADVICE, stuck.ADVICE, stall.ADVICE, wedging.ADVICE)
# Parts of the risk as they are published, in the order of `parts`.
PARTS = ("jamming_wedging", "jamming_stall", "jamming_load")
# Names of the alarm's numbers, on the rim and in the hole, see `put_numbers`.
ON_RIM_OUTPUTS = (*PARTS, "jamming_risk", "determinant")
IN_HOLE_OUTPUTS = (*PARTS, "jamming_risk", "insertion_ratio", "whitney_margin")
# Outputs that rest on the dangers.
OUTPUTS = tuple(dict.fromkeys(ON_RIM_OUTPUTS + IN_HOLE_OUTPUTS))


class Dangers(Record):
    """
    All dangers, with the push that several of them look at.

    Attributes
    ----------
    push : Push
    wedging : Wedging
    stall : Stall
    load : Load
    stuck : Stuck
    risk : float
        Probability of any danger within the horizon, as if they were independent.

    """

    push: Push
    wedging: Wedging
    stall: Stall
    load: Load
    stuck: Stuck
    risk: float


@compiled
def forget_dangers(dangers: Dangers) -> None:
    """Begin anew with the next wrench."""
    forget_push(dangers.push)
    wedging.forget(dangers.wedging)
    stall.forget(dangers.stall)
    load.forget(dangers.load)
    stuck.forget(dangers.stuck)
    dangers.risk = 0.0


@compiled
def restart_trends(dangers: Dangers) -> None:
    """Begin the courses of values anew: the peg does not move as predicted."""
    load.restart_trends(dangers.load)


@compiled
def assess_dangers(
    estimate: Estimate,
    dangers: Dangers,
    motion: MotionTrend,
    depth: DepthTrend,
    shown: Shown,
    settings: MonitorSettings,
    passed: Passed,
) -> None:
    """
    Process a wrench: fill in each danger, and the risk of any.

    Parameters
    ----------
    estimate : Estimate
    dangers : Dangers
        Changed.
    motion : MotionTrend
        Its last orientation is taken.
    depth : DepthTrend
    shown : Shown
        By the same wrench.
    settings : MonitorSettings
    passed : Passed

    """
    moving = moving_now(motion, passed.since, settings)
    pushed = NOT_PUSHED
    if touches(shown):
        if reactions_usable(estimate, shown):
            follow_total(dangers.push, estimate.reactions.normal, passed.dt)
        ahead = horizon_on_rim(shown, settings.jamming_horizon)
        pushed = pushed_on(estimate, dangers.push, moving, passed.dt, ahead)
    else:
        forget_dangers(dangers)
    situation = Situation(
        estimate, shown, depth, motion.measured, moving, pushed, settings, passed
    )
    wedging.assess(dangers.wedging, situation)
    stall.assess(dangers.stall, situation)
    load.assess(dangers.load, situation)
    stuck.assess(dangers.stuck, situation)
    none = 1.0
    for part in parts(dangers):
        none *= 1.0 - part
    dangers.risk = 1.0 - none


@compiled
def parts(dangers: Dangers) -> tuple[float, ...]:
    """Return the parts of the risk, as PARTS; what stands on the rim is 0 in the hole."""
    inside = dangers.stuck
    return (
        dangers.wedging.probability + inside.wedged,
        dangers.stall.probability + inside.rests,
        dangers.load.probability,
    )


@compiled
def likeliest(dangers: Dangers) -> int:
    """Return the likeliest danger; of those as likely as each other, the first."""
    which, most = Danger.LOAD, dangers.load.probability
    if dangers.stuck.probability > most:
        which, most = Danger.STUCK, dangers.stuck.probability
    if dangers.wedging.probability > most:
        which, most = Danger.WEDGING, dangers.wedging.probability
    if dangers.stall.probability > most:
        which, most = Danger.STALL, dangers.stall.probability
    return which


@compiled
def is_in_hole(dangers: Dangers) -> bool:
    """Return whether numbers are IN_HOLE_OUTPUTS; otherwise they are ON_RIM_OUTPUTS."""
    return dangers.stuck.insertion != 0.0


@compiled
def put_numbers(dangers: Dangers, numbers: Floats) -> None:
    """Fill in the numbers of the alarm, as IN_HOLE_OUTPUTS or ON_RIM_OUTPUTS; see `is_in_hole`."""
    count = 0
    for part in parts(dangers):
        numbers[count] = part
        count += 1
    numbers[count] = dangers.risk
    if is_in_hole(dangers):
        numbers[count + 1], numbers[count + 2] = dangers.stuck.insertion, dangers.stuck.margin
    else:
        numbers[count + 1], numbers[count + 2] = dangers.wedging.determinant, 0.0


@compiled
def fill_dangers(dangers: Dangers, row: Row) -> None:
    """Fill in what is published."""
    row.jamming_wedging, row.jamming_stall, row.jamming_load = parts(dangers)
    row.jamming_risk = dangers.risk
    if is_in_hole(dangers):
        row.insertion_ratio, row.whitney_margin = dangers.stuck.insertion, dangers.stuck.margin
    else:
        row.determinant = dangers.wedging.determinant
