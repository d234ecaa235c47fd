"""Whether the peg is in the hole as deep as is stated, by its measured place."""

from math import nan

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.evidence import Shown
from peg_on_hole_ros.monitor.place_check import PlaceMisfit
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.states import Mode, since_when
from peg_on_hole_ros.monitor.tuned import INSERTED
from peg_on_hole_ros.typed_record import Record


class Insertion(Record):
    """
    Whether the peg is inserted.

    Attributes
    ----------
    inserted : bool
    deep_since : float
        Since when it has touched in the hole at the stated depth [s]; NaN: it does not.

    """

    inserted: bool
    deep_since: float


@compiled
def forget_insertion(insertion: Insertion) -> None:
    """Forget where the peg was."""
    insertion.inserted = False
    insertion.deep_since = nan


@compiled
def follow_insertion(
    insertion: Insertion,
    mode: Mode,
    shown: Shown,
    place: PlaceMisfit,
    settings: MonitorSettings,
    t: float,
) -> None:
    """
    Process a declared mode.

    Two points, a peg that rests on its seat, and any other contact in the hole count alike: where
    the peg is decides, and the seat pushes as a plate does.

    Parameters
    ----------
    insertion : Insertion
        Changed.
    mode : Mode
        As declared.
    shown : Shown
    place : PlaceMisfit
        As it was measured last.
    settings : MonitorSettings
    t : float
        [s].

    """
    depth = settings.inserted_depth
    touches = mode == Mode.TWO_POINT or (mode == Mode.UNKNOWN and shown.free <= 0.5)
    in_hole = depth > 0.0 and touches and place.inside
    if insertion.inserted:
        insertion.inserted = in_hole and place.depth >= depth - INSERTED.back * place.depth_stddev
        return
    deep = in_hole and place.depth >= depth
    insertion.deep_since = since_when(insertion.deep_since, deep, t)
    insertion.inserted = deep and t - insertion.deep_since >= settings.mode_dwell


@compiled
def published_mode(insertion: Insertion, mode: Mode) -> Mode:
    """Return the mode that is published, by the one that is declared."""
    return Mode.INSERTED if insertion.inserted else mode
