"""What one wrench shows and threatens, by one compiled call on one flat memory."""

from math import fabs

import numpy as np

from peg_on_hole_ros.config.options import MonitorOptions
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.record import Estimate
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitor import (
    contacts,
    down_the_hole,
    evidence,
    jamming,
    leftover_wrench,
    one_point,
    trend,
)
from peg_on_hole_ros.monitor.down_the_hole import follow_depth
from peg_on_hole_ros.monitor.known_quantities import Known, fill_known
from peg_on_hole_ros.monitor.memory import FIELDS, LEVEL_FIELDS
from peg_on_hole_ros.monitor.output_row import ALARM_WIDTH

# An array that is handed to compiled code costs as much as 50 multiplications, and a copy of one
# array is a copy of all of it: so everything stands in one, the options too.
_SIZES = {
    "HYPOTHESES": contacts.COUNT,
    "POINTS": one_point.COUNT,
    "MEANS": leftover_wrench.SIZE,
    "MOTION": trend.SIZE,
    "DESCENT": down_the_hole.SIZE,
    "JAMMING": jamming.SIZE,
    "SETTINGS": len(evidence.Settings._fields),
    "LIMITS": len(jamming.Limits._fields),
    "DIAMETERS": 2,  # d, D [m]
    "BAND": 1,  # `monitor.singular_band`
    "SHOWN": evidence.WIDTH,
    "RISK": len(jamming.Risk._fields),
    "KNOWN": len(Known._fields),
}
_ENDS = dict(zip(_SIZES, np.cumsum(list(_SIZES.values())).tolist()))
_AT = {name: _ENDS[name] - size for name, size in _SIZES.items()}
(
    HYPOTHESES, POINTS, MEANS, MOTION, DESCENT, JAMMING, SETTINGS, LIMITS, DIAMETERS, BAND, SHOWN,
    RISK, KNOWN,
) = _AT.values()  # fmt: skip
SIZE = _ENDS["KNOWN"]


def new_judgement(options: MonitorOptions, scene: Scene, force_stddev: float) -> np.ndarray:
    """Return the memory of a judge who has seen nothing, with the noise of a force [N]."""
    m = np.zeros(SIZE)
    m[SETTINGS : _ENDS["SETTINGS"]] = evidence.settings(
        options, force_stddev, scene.clearance_stddev
    )
    m[LIMITS : _ENDS["LIMITS"]] = jamming.limits(options)
    m[DIAMETERS], m[DIAMETERS + 1] = scene.peg_diameter, scene.hole_diameter
    m[BAND] = options.singular_band
    forget(m)
    return m


def retune(m: np.ndarray, options: MonitorOptions, scene: Scene, force_stddev: float) -> None:
    """Take other options from here on; what was seen stays."""
    m[SETTINGS:SHOWN] = new_judgement(options, scene, force_stddev)[SETTINGS:SHOWN]


_NO_POINTS = one_point.no_points()
_NOTHING_SEEN = np.concatenate([contacts.no_knowledge(), _NO_POINTS, leftover_wrench.new_means()])
# All that the next judgement depends on beside the estimate: of `judge`, what is declared, each
# alarm's level, and the alarms as they were told last and of what caused them last; see `row`.
MEMORY = np.dtype(
    [
        ("numbers", float, (SIZE,)),
        ("declared", [field[:2] for field in FIELDS], (1,)),
        ("levels", [field[:2] for field in LEVEL_FIELDS], (3,)),
        ("said", float, (3, ALARM_WIDTH)),
        ("kept", float, (3, ALARM_WIDTH)),
    ]
)
_NO_RISK_SEEN = jamming.new_memory()


@compiled
def forget(m: np.ndarray) -> None:
    """Forget what was seen, but for the motion."""
    m[HYPOTHESES:MOTION] = _NOTHING_SEEN
    m[JAMMING:SETTINGS] = _NO_RISK_SEEN


@compiled
def forget_motion(m: np.ndarray) -> None:
    """Forget the motion too: what comes next has nothing to do with it."""
    m[MOTION:JAMMING] = 0.0


@compiled
def break_course(m: np.ndarray) -> None:
    """Let the course of the reactions begin anew; see `jamming.break_course`."""
    jamming.break_course(m[JAMMING:SETTINGS])


@compiled
def follow_orientation(m: np.ndarray, since: float, q: np.ndarray, R: np.ndarray) -> None:
    """Take an orientation into the motion; see `trend.follow` and `follow_depth`."""
    acceleration, memory = m[SETTINGS + 4], m[SETTINGS + 5]
    d, D, quick = m[DIAMETERS], m[DIAMETERS + 1], trend.TURN_SHARE * acceleration
    follow_depth(m, DESCENT, d, D, q[0], R[0, 0], since, quick)
    trend.follow(m[MOTION:DESCENT], since, q, R, d / D, acceleration, memory)


@compiled
def judge(
    estimate: Estimate,
    m: np.ndarray,
    dt: float,
    since: float,
    nis: float,
    determinant: float,
    displaced: float,
) -> None:
    """
    Fill in SHOWN, RISK and KNOWN.

    Parameters
    ----------
    estimate : Estimate
    m : ndarray
        Memory, from `new_judgement`.
    dt, since : float
        Since the last wrench, and since the last orientation [s].
    nis : float
        Running mean of the normalised innovation squared; below zero: it says nothing.
    determinant : float
        What `reactions.react` returned.
    displaced : float
        As for `evidence.show`.

    """
    shown, motion = m[SHOWN:RISK], m[MOTION:JAMMING]
    hypotheses, means, settings = m[HYPOTHESES:POINTS], m[MEANS:MOTION], m[SETTINGS:LIMITS]
    evidence.show(
        estimate,
        hypotheses,
        means,
        motion,
        settings,
        dt,
        since,
        nis,
        determinant,
        displaced,
        shown,
    )
    if estimate.contacts == ContactSet.TWO:
        one_point.weigh_points(m[POINTS:MEANS], estimate, dt, settings[1], settings[2])
    else:
        m[POINTS:MEANS] = _NO_POINTS
    contact, below, time, usable = 1.0 - shown[4], shown[6], shown[7], shown[10] > 0.0
    memory, limits, risk = m[JAMMING:SETTINGS], m[LIMITS:DIAMETERS], m[RISK:KNOWN]
    jamming.assess(estimate, motion, memory, limits, dt, since, contact, below, time, usable, risk)
    fill_known(estimate, min(risk[4], fabs(determinant)), m[BAND], m[KNOWN:])
