"""Alarms for the cell: when each rises and falls, with the numbers that are behind it."""

from math import nan

import numpy as np

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.alarm_text import (
    ALL,
    ANY,
    BY_HOLE,
    BY_LOAD,
    BY_STALL,
    BY_WEDGING,
    HOLE,
    PLAIN,
)
from peg_on_hole_ros.monitor.evidence import Shown
from peg_on_hole_ros.monitor.jamming import Risk
from peg_on_hole_ros.monitor.memory import (
    ERROR,
    IN_AIR,
    OK,
    THREE_POINT,
    TWO_POINT,
    WARN,
    since_when,
)
from peg_on_hole_ros.monitor.output_row import (
    CONTACT_LOSS,
    HELD,
    JAMMING,
    KIND,
    LEVEL,
    NUMBERS,
    OVERLOAD,
    WHICH,
)
from peg_on_hole_ros.record_types import LevelRecord, MemoryRecord, ThresholdsRecord

_LOSS_WARN, _LOSS_ERROR = 0.5, 0.95
# A peg that slides is on three contacts once that has been told for so long [s]. One at rest may
# bounce on one of them: there it takes as long as an alarm is held.
_SLID = 0.05
# One contact is named if it holds this share of the probability that any has opened.
_CLEARLY = 0.7
# A contact that opens sooner than so before gamma0 [s] opens on the way into the hole.
_ENTERING = 0.03


@compiled
def clear_alarms(memory: MemoryRecord) -> None:
    """Clear every alarm."""
    d = memory.declared[0]
    d.rested = 0
    d.resting = d.sliding = d.aloft = nan
    for i in range(3):
        r = memory.levels[i]
        r.level = OK
        r.warns = r.errs = r.below = nan
    memory.said[:, :] = 0.0
    # None has been looked at.
    memory.said[:, LEVEL] = -1.0
    memory.kept[:, :] = 0.0
    memory.kept[JAMMING, WHICH], memory.kept[JAMMING, KIND] = BY_STALL, PLAIN
    memory.kept[CONTACT_LOSS, WHICH], memory.kept[CONTACT_LOSS, KIND] = ALL, PLAIN


@compiled
def follow_level(
    r: LevelRecord, warn: float, error: float, o: ThresholdsRecord, t: float, value: float
) -> int:
    """
    Return a level with hysteresis in value and in time.

    It rises once a value has been at its threshold for `alarm_dwell`, and falls by one once the
    value has been a hysteresis below the threshold for `alarm_hold`: one bad sample neither
    raises nor clears.

    Parameters
    ----------
    r : record of LEVEL_FIELDS
        Changed.
    warn, error : float
        Thresholds.
    o : record of THRESHOLDS
    t : float
        [s].
    value : float

    """
    if r.level == OK and value < min(warn, error):
        r.warns = r.errs = nan
        return OK
    r.warns = since_when(r.warns, value >= warn, t)
    r.errs = since_when(r.errs, value >= error, t)
    if t - r.errs >= o.alarm_dwell:
        r.level = ERROR
    elif t - r.warns >= o.alarm_dwell:
        r.level = max(r.level, WARN)
    if r.level == OK or value >= (warn if r.level == WARN else error) - o.alarm_hysteresis:
        r.below = nan
    elif r.below != r.below:
        r.below = t
    elif t - r.below >= o.alarm_hold:
        r.level -= 1
        r.below = t
    return r.level


@compiled
def has_cause(r: LevelRecord) -> bool:
    """Return whether the last value was at the level's threshold, or a first: else it is held."""
    errs = r.errs == r.errs
    return errs if r.level == ERROR else errs or r.warns == r.warns


@compiled
def jamming_cause(risk: Risk) -> int:
    """Return the likeliest cause of a risk."""
    if risk.load >= max(risk.wedging, risk.stall):
        return BY_LOAD
    if risk.insertion != 0.0:
        return BY_HOLE
    return BY_STALL if risk.stall > risk.wedging else BY_WEDGING


@compiled
def follow_alarms(
    memory: MemoryRecord,
    o: ThresholdsRecord,
    t: float,
    risk: Risk,
    shown: Shown,
    normal: np.ndarray,
) -> None:
    """
    Fill in the three alarms.

    While a level is held without a cause, the alarm says what its cause was, with the numbers
    that it had.

    Parameters
    ----------
    memory : record of MEMORY
        Changed; `said` is filled in.
    o : record of THRESHOLDS
    t : float
        [s].
    risk : Risk
        Of jamming, with its causes.
    shown : Shown
        Probabilities of the contacts, and the time to gamma0.
    normal : ndarray, shape (3,)
        Reactions [N].

    """
    _follow_jamming(memory, o, t, risk)
    _follow_contact_loss(memory, o, t, shown)
    _follow_overload(memory, o, t, risk, normal)


@compiled
def _follow_jamming(memory, o, t, risk):
    r, said, kept = memory.levels[JAMMING], memory.said[JAMMING], memory.kept[JAMMING]
    level = follow_level(r, o.jamming_warn, o.jamming_error, o, t, risk.risk)
    cause = has_cause(r)
    if cause:
        # It is kept while the alarm is held.
        kept[WHICH] = jamming_cause(risk)
    if cause or level == OK:
        numbers = (risk.wedging, risk.stall, risk.load, risk.risk)
        for i in range(4):
            kept[NUMBERS + i] = numbers[i]
        in_hole = risk.insertion != 0.0
        kept[KIND] = HOLE if in_hole else PLAIN
        kept[NUMBERS + 4] = risk.insertion if in_hole else risk.determinant
        kept[NUMBERS + 5] = risk.margin
    _say(said, kept, level, cause)


@compiled
def _say(said, kept, level, cause):
    said[:] = kept
    said[LEVEL] = level
    said[HELD] = 1.0 if level != OK and not cause else 0.0


@compiled
def _follow_contact_loss(memory, o, t, shown):
    """Tell of three contacts that were there and are no longer, other than by entry."""
    d, r = memory.declared[0], memory.levels[CONTACT_LOSS]
    d.aloft = since_when(d.aloft, d.mode == IN_AIR, t)
    d.resting = since_when(d.resting, d.mode == THREE_POINT, t)
    slides = d.mode == THREE_POINT and shown.three_point > shown.stuck
    d.sliding = since_when(d.sliding, slides, t)
    if t - d.sliding >= _SLID or t - d.resting >= o.alarm_hold:
        d.rested = 1
    if d.mode == TWO_POINT or t - d.aloft >= o.alarm_hold:
        # In the hole, or in the air for long enough to be a state and no event.
        d.rested = 0
    entering = 0.0 <= shown.time < _ENTERING
    # The reactions of a peg that jams are not determined, and say nothing of its contacts.
    jams = memory.levels[JAMMING].level != OK and memory.kept[JAMMING, WHICH] != BY_LOAD
    opened = 0.0 if entering or jams else shown.opened
    value = opened + shown.free if d.rested else 0.0
    level = follow_level(r, _LOSS_WARN, _LOSS_ERROR, o, t, value)
    cause = has_cause(r)
    said, kept = memory.said[CONTACT_LOSS], memory.kept[CONTACT_LOSS]
    lost = (shown.lost_K, shown.lost_B1, shown.lost_B2)
    if cause or level == OK:
        which = ALL
        if cause and opened > shown.free:
            most = max(lost[0], lost[1], lost[2])
            which = ANY
            for i in range(2, -1, -1):
                if most > _CLEARLY * opened and lost[i] == most:
                    which = i
        kept[WHICH] = which
        for i in range(3):
            kept[NUMBERS + i] = lost[i]
        kept[NUMBERS + 3], kept[NUMBERS + 4] = shown.opened, shown.free
    _say(said, kept, level, cause)


@compiled
def _follow_overload(memory, o, t, risk, normal):
    """Tell of a contact whose load passes its limit."""
    r, there = memory.levels[OVERLOAD], memory.declared[0].mode == THREE_POINT
    level = follow_level(r, o.jamming_warn, o.jamming_error, o, t, risk.load if there else 0.0)
    cause = has_cause(r)
    said, kept = memory.said[OVERLOAD], memory.kept[OVERLOAD]
    if cause or level == OK:
        kept[WHICH] = risk.loaded if cause else 0.0
        kept[KIND] = PLAIN if there else 0.0
        kept[NUMBERS] = risk.load
        for i in range(3):
            kept[NUMBERS + 1 + i] = normal[i]
            kept[NUMBERS + 4 + i] = o.max_normal[i]
    _say(said, kept, level, cause)
