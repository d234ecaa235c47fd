"""What one wrench shows and threatens, by one compiled call on one flat memory."""

from math import fabs, sqrt
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.memory import REACTIONS, SCENE, SPREAD, Y
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitoring import carried, contacts, evidence, jamming, trend
from peg_on_hole_ros.options import MonitorOptions


class Known(NamedTuple):
    """
    What is known of the scene and of the reactions.

    Attributes
    ----------
    friction, friction_stddev : float
    clearance, clearance_stddev : float
        [m].
    determined : float
        1 where the reactions of three contacts, if there are three, are numbers to trust.

    """

    friction: float
    friction_stddev: float
    clearance: float
    clearance_stddev: float
    determined: float


# An array that is handed to compiled code costs as much as 50 multiplications, and a copy of one
# array is a copy of all of it: so everything stands in one, the options too.
_SIZES = {
    "HYPOTHESES": contacts.COUNT,
    "MEANS": carried.SIZE,
    "MOTION": trend.SIZE,
    "JAMMING": jamming.SIZE,
    "SETTINGS": len(evidence.Settings._fields),
    "LIMITS": len(jamming.Limits._fields),
    "RATIO": 1,  # d / D
    "BAND": 1,  # `monitor.singular_band`
    "SHOWN": evidence.WIDTH,
    "RISK": len(jamming.Risk._fields),
    "KNOWN": len(Known._fields),
}
_ENDS = dict(zip(_SIZES, np.cumsum(list(_SIZES.values())).tolist()))
_AT = {name: _ENDS[name] - size for name, size in _SIZES.items()}
HYPOTHESES, MEANS, MOTION, JAMMING, SETTINGS, LIMITS, RATIO, BAND, SHOWN, RISK, KNOWN = (
    _AT.values()
)
SIZE = _ENDS["KNOWN"]
# Reactions are known where no spread is more than a third of their mean.
_KNOWN_SHARE = 9.0


def new_judgement(options: MonitorOptions, scene: Scene, force_stddev: float) -> np.ndarray:
    """Return the memory of a judge who has seen nothing, with the noise of a force [N]."""
    m = np.zeros(SIZE)
    m[SETTINGS : _ENDS["SETTINGS"]] = evidence.settings(
        options, force_stddev, scene.clearance_stddev
    )
    m[LIMITS : _ENDS["LIMITS"]] = jamming.limits(options)
    m[RATIO] = scene.peg_diameter / scene.hole_diameter
    m[BAND] = options.singular_band
    forget(m)
    return m


def forget(m: np.ndarray) -> None:
    """Forget what was seen, but for the motion."""
    m[HYPOTHESES : _ENDS["HYPOTHESES"]] = contacts.no_knowledge()
    m[MEANS : _ENDS["MEANS"]] = carried.new_means()
    m[JAMMING : _ENDS["JAMMING"]] = jamming.new_memory()


@compiled
def follow_orientation(m, since, q, R):
    """Take an orientation into the motion; see `trend.follow`."""
    acceleration, memory = m[SETTINGS + 4], m[SETTINGS + 5]
    trend.follow(m[MOTION:JAMMING], since, q, R, m[RATIO], acceleration, memory)


@compiled
def judge(f, m, dt, since, nis, determinant, displaced):
    """
    Fill in SHOWN, RISK and KNOWN.

    Parameters
    ----------
    f : ndarray
        Memory of the filter, after `reactions.react`.
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
    hypotheses, means, settings = m[HYPOTHESES:MEANS], m[MEANS:MOTION], m[SETTINGS:LIMITS]
    evidence.show(
        f, hypotheses, means, motion, settings, dt, since, nis, determinant, displaced, shown
    )
    contact, below, time, usable = 1.0 - shown[4], shown[6], shown[7], shown[10] > 0.0
    memory, limits, risk = m[JAMMING:SETTINGS], m[LIMITS:RATIO], m[RISK:KNOWN]
    jamming.assess(f, motion, memory, limits, dt, since, contact, below, time, usable, risk)
    m[KNOWN] = f[SCENE + 7]
    m[KNOWN + 1] = sqrt(max(f[SPREAD], 0.0))
    m[KNOWN + 2] = f[SCENE + 1] - f[SCENE]
    m[KNOWN + 3] = sqrt(max(f[SPREAD + 3], 0.0))
    m[KNOWN + 4] = _determined(f, min(risk[4], fabs(determinant)), m[BAND])


@compiled
def _determined(f, determinant, band):
    """Return 1.0 where reactions are numbers to trust, if they are those of three contacts."""
    if not determinant > band:
        return 0.0
    total = f[Y + 3] + f[Y + 4] + f[Y + 5]
    for i in range(3):
        if not sqrt(max(f[REACTIONS + 21 + 7 * i], 0.0)) <= total / _KNOWN_SHARE:
            return 0.0
    return 1.0
