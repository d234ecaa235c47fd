"""Alarms for the cell: when each rises and falls, with the numbers that are behind it."""

from collections.abc import Sequence
from math import nan
from typing import Annotated

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.alarm_text import ALL, ANY, HOLE, PLAIN
from peg_on_hole_ros.monitor.dangers.load import Load
from peg_on_hole_ros.monitor.dangers.registry import (
    Danger,
    Dangers,
    is_in_hole,
    likeliest,
    put_numbers,
)
from peg_on_hole_ros.monitor.evidence import Shown
from peg_on_hole_ros.monitor.output_row import CONTACT_LOSS, JAMMING, OVERLOAD
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.states import AlarmLevel, Mode, since_when
from peg_on_hole_ros.monitor.tuned import CONTACT_LOSS_ALARM
from peg_on_hole_ros.outputs import AlarmRow
from peg_on_hole_ros.typed_record import Floats, Record


class Level(Record):
    """
    The level of an alarm; a time of NaN is none.

    Attributes
    ----------
    level : AlarmLevel
    warn_since, error_since : float
        Since when the value has been at the threshold of WARN, and at that of ERROR [s].
    without_cause_since : float
        Since when the level has had no cause [s].

    """

    level: AlarmLevel
    warn_since: float
    error_since: float
    without_cause_since: float


class Alarms(Record):
    """
    The alarms and what they depend on; a time of NaN is none.

    Attributes
    ----------
    levels : sequence of Level
        Of JAMMING, CONTACT_LOSS, OVERLOAD.
    published, kept : sequence of AlarmRow
        The alarms as they were published last, and of what caused them last.
    three_contacts_there : bool
        Whether there are three contacts to lose.
    three_point_since : float
        Since when the mode has been THREE_POINT [s].
    sliding_since : float
        Since when it has been so of a peg that slides [s].
    open_since : float
        Since when the mode has been OPEN [s].

    """

    levels: Annotated[Sequence[Level], (3,)]
    published: Annotated[Sequence[AlarmRow], (3,)]
    kept: Annotated[Sequence[AlarmRow], (3,)]
    three_contacts_there: bool
    three_point_since: float
    sliding_since: float
    open_since: float


@compiled
def clear_alarms(alarms: Alarms) -> None:
    """Clear every alarm."""
    alarms.three_contacts_there = False
    alarms.three_point_since = alarms.sliding_since = alarms.open_since = nan
    for i in range(3):
        level = alarms.levels[i]
        level.level = AlarmLevel.OK
        level.warn_since = level.error_since = level.without_cause_since = nan
        _clear(alarms.published[i])
        _clear(alarms.kept[i])
        # None has been looked at.
        alarms.published[i].level = -1
    jamming, contact_loss = alarms.kept[JAMMING], alarms.kept[CONTACT_LOSS]
    jamming.which, jamming.kind = Danger.STALL, PLAIN
    contact_loss.which, contact_loss.kind = ALL, PLAIN


@compiled
def _clear(alarm: AlarmRow) -> None:
    alarm.level = alarm.which = alarm.held = alarm.kind = 0
    alarm.numbers[:] = 0.0


@compiled
def follow_level(
    level: Level,
    warn: float,
    error: float,
    settings: MonitorSettings,
    t: float,
    value: float,
) -> AlarmLevel:
    """
    Return a level with hysteresis in value and in time.

    It rises once a value has been at its threshold for `alarm_dwell`, and falls by one once the
    value has been a hysteresis below the threshold for `alarm_hold`: one bad sample neither
    raises nor clears.

    Parameters
    ----------
    level : Level
        Changed.
    warn, error : float
        Thresholds.
    settings : MonitorSettings
    t : float
        [s].
    value : float

    """
    if level.level == AlarmLevel.OK and value < min(warn, error):
        level.warn_since = level.error_since = nan
        return AlarmLevel.OK
    level.warn_since = since_when(level.warn_since, value >= warn, t)
    level.error_since = since_when(level.error_since, value >= error, t)
    if t - level.error_since >= settings.alarm_dwell:
        level.level = AlarmLevel.ERROR
    elif t - level.warn_since >= settings.alarm_dwell and level.level == AlarmLevel.OK:
        level.level = AlarmLevel.WARN
    threshold = warn if level.level == AlarmLevel.WARN else error
    if level.level == AlarmLevel.OK or value >= threshold - settings.alarm_hysteresis:
        level.without_cause_since = nan
    elif level.without_cause_since != level.without_cause_since:
        level.without_cause_since = t
    elif t - level.without_cause_since >= settings.alarm_hold:
        is_error = level.level == AlarmLevel.ERROR
        level.level = AlarmLevel.WARN if is_error else AlarmLevel.OK
        level.without_cause_since = t
    return level.level


@compiled
def has_cause(level: Level) -> bool:
    """Return whether the last value was at the level's threshold, or a first: else it is held."""
    is_error = level.error_since == level.error_since
    if level.level == AlarmLevel.ERROR:
        return is_error
    return is_error or level.warn_since == level.warn_since


@compiled
def follow_alarms(
    alarms: Alarms,
    mode: Mode,
    settings: MonitorSettings,
    t: float,
    dangers: Dangers,
    shown: Shown,
    normal: Floats,
) -> None:
    """
    Fill in the three alarms.

    While a level is held without a cause, the alarm states what its cause was, with the numbers
    that it had.

    Parameters
    ----------
    alarms : Alarms
        Changed; `published` is filled in.
    mode : Mode
        As declared.
    settings : MonitorSettings
    t : float
        [s].
    dangers : Dangers
        By the wrench of that time.
    shown : Shown
        Probabilities of the contacts, and the time to gamma0.
    normal : ndarray, shape (3,)
        Reactions [N].

    """
    _follow_jamming(alarms, settings, t, dangers)
    _follow_contact_loss(alarms, mode, settings, t, shown)
    _follow_overload(alarms, mode, settings, t, dangers.load, normal)


@compiled
def _follow_jamming(alarms: Alarms, settings: MonitorSettings, t: float, dangers: Dangers) -> None:
    followed = alarms.levels[JAMMING]
    published, kept = alarms.published[JAMMING], alarms.kept[JAMMING]
    warn, error = settings.jamming_warn, settings.jamming_error
    level = follow_level(followed, warn, error, settings, t, dangers.risk)
    cause = has_cause(followed)
    if cause:
        # It is kept while the alarm is held.
        kept.which = likeliest(dangers)
    if cause or level == AlarmLevel.OK:
        put_numbers(dangers, kept.numbers)
        kept.kind = HOLE if is_in_hole(dangers) else PLAIN
    _publish(published, kept, level, cause)


@compiled
def _publish(published: AlarmRow, kept: AlarmRow, level: AlarmLevel, cause: bool) -> None:
    published.which, published.kind = kept.which, kept.kind
    published.numbers[:] = kept.numbers
    published.level = level
    published.held = 1 if level != AlarmLevel.OK and not cause else 0


@compiled
def _follow_contact_loss(
    alarms: Alarms, mode: Mode, settings: MonitorSettings, t: float, shown: Shown
) -> None:
    """Tell of three contacts that were there and are no longer, other than by entry."""
    followed = alarms.levels[CONTACT_LOSS]
    _follow_three_contacts(alarms, mode, settings, t, shown)
    entering = 0.0 <= shown.time < CONTACT_LOSS_ALARM.entering
    # The reactions of a peg that jams are not determined, and show nothing of its contacts.
    jams = alarms.levels[JAMMING].level != AlarmLevel.OK
    jams = jams and alarms.kept[JAMMING].which != Danger.LOAD
    opened = 0.0 if entering or jams else shown.opened
    value = opened + shown.free if alarms.three_contacts_there else 0.0
    level = follow_level(
        followed, CONTACT_LOSS_ALARM.warn, CONTACT_LOSS_ALARM.error, settings, t, value
    )
    cause = has_cause(followed)
    published, kept = alarms.published[CONTACT_LOSS], alarms.kept[CONTACT_LOSS]
    lost = (shown.lost_K, shown.lost_B1, shown.lost_B2)
    if cause or level == AlarmLevel.OK:
        which = ALL
        if cause and opened > shown.free:
            most = max(lost[0], lost[1], lost[2])
            which = ANY
            for i in range(2, -1, -1):
                if most > CONTACT_LOSS_ALARM.clearly * opened and lost[i] == most:
                    which = i
        kept.which = which
        numbers = (shown.lost_K, shown.lost_B1, shown.lost_B2, shown.opened, shown.free)
        for i in range(len(numbers)):
            kept.numbers[i] = numbers[i]
    _publish(published, kept, level, cause)


@compiled
def _follow_three_contacts(
    alarms: Alarms, mode: Mode, settings: MonitorSettings, t: float, shown: Shown
) -> None:
    """Follow whether there are three contacts to lose."""
    alarms.open_since = since_when(alarms.open_since, mode == Mode.OPEN, t)
    three_point = mode == Mode.THREE_POINT
    alarms.three_point_since = since_when(alarms.three_point_since, three_point, t)
    slides = three_point and shown.three_point > shown.stuck
    alarms.sliding_since = since_when(alarms.sliding_since, slides, t)
    slid = t - alarms.sliding_since >= CONTACT_LOSS_ALARM.slid
    if slid or t - alarms.three_point_since >= settings.alarm_hold:
        alarms.three_contacts_there = True
    in_air = t - alarms.open_since >= settings.alarm_hold
    if mode == Mode.TWO_POINT or mode == Mode.ELSEWHERE or in_air:
        # In the hole, not on the rim, or in the air for long enough to be a state and no event.
        alarms.three_contacts_there = False


@compiled
def _follow_overload(
    alarms: Alarms, mode: Mode, settings: MonitorSettings, t: float, load: Load, normal: Floats
) -> None:
    """Follow whether the load of a contact passes its limit."""
    followed, there = alarms.levels[OVERLOAD], mode == Mode.THREE_POINT
    warn, error = settings.jamming_warn, settings.jamming_error
    level = follow_level(followed, warn, error, settings, t, load.probability if there else 0.0)
    cause = has_cause(followed)
    published, kept = alarms.published[OVERLOAD], alarms.kept[OVERLOAD]
    if cause or level == AlarmLevel.OK:
        kept.which = int(load.which) if cause else 0
        kept.kind = PLAIN if there else 0
        kept.numbers[0] = load.probability
        for i in range(3):
            kept.numbers[1 + i] = normal[i]
            kept.numbers[4 + i] = settings.max_normal[i]
    _publish(published, kept, level, cause)
