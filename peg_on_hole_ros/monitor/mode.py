"""The contact mode that is declared, with dwell and hysteresis, and when contact came and went."""

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.evidence import Shown
from peg_on_hole_ros.monitor.memory import IN_AIR, UNKNOWN
from peg_on_hole_ros.record_types import DeclaredRecord, ThresholdsRecord

# A motion that orientations have refuted is believed again once it has gone on for so long [s]. A
# wrong setting is refuted every 25 ms, and must not be declared a mode in between.
CONFIRMED = 0.05


@compiled
def forget_mode(d: DeclaredRecord) -> None:
    """Forget all evidence."""
    d.mode = d.candidate = d.weighed = UNKNOWN
    d.since = d.last_free = d.last_touch = 0.0
    d.touching = d.onset = -1
    d.refuted = 0


@compiled
def declare_mode(d: DeclaredRecord, o: ThresholdsRecord, t: float, shown: Shown) -> None:
    """
    Take the probabilities at a time.

    A mode is declared once it is probable enough for a while, and kept until it no longer is.

    Parameters
    ----------
    d : record of FIELDS
        Changed.
    o : record of THRESHOLDS
    t : float
        [s].
    shown : Shown

    """
    # In the order of MODES.
    probabilities = (
        shown.three_point + shown.stuck,
        shown.two_point,
        shown.free,
        shown.opened + shown.other,
    )
    best = 0
    for i in range(1, len(probabilities)):
        if probabilities[i] > probabilities[best]:
            best = i
    if probabilities[best] < o.mode_probability_on:
        kept = probabilities[d.weighed] >= o.mode_probability_off
        best = d.weighed if kept else UNKNOWN
    if best != d.candidate:
        d.candidate, d.since = best, t
    if best != d.weighed and t - d.since >= o.mode_dwell:
        d.weighed = best
    dwell = max(o.mode_dwell, CONFIRMED) if d.refuted else o.mode_dwell
    if best != d.mode and t - d.since >= dwell:
        d.mode, d.refuted = best, 0
    _follow_touch(d, o, t, shown.free)


@compiled
def _follow_touch(d, o, t, free):
    # Evidence for the other side begins where that for this side was last strong.
    certain = 1.0 - o.mode_probability_on
    if free >= 1.0 - certain:
        d.last_free = t
    if free <= certain:
        d.last_touch = t
    if d.touching < 0:
        if d.mode != UNKNOWN:
            d.touching = 1 if free <= 0.5 else 0
    elif d.touching == 1 and d.mode == IN_AIR:
        d.touching = d.onset = 0
        d.turned, d.latency = d.last_touch, t - d.last_touch
    elif d.touching == 0 and free <= certain and d.mode != IN_AIR:
        d.touching = d.onset = 1
        d.turned, d.latency = d.last_free, t - d.last_free
