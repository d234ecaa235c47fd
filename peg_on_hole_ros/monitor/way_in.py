"""Whether a peg below gamma0 may be in the hole: by its way there, by its place or its load."""

from enum import IntEnum
from math import nan

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.evidence import Evidence
from peg_on_hole_ros.monitor.place_check import PlaceMisfit
from peg_on_hole_ros.monitor.states import Mode, since_when
from peg_on_hole_ros.monitor.tuned import WAY_IN
from peg_on_hole_ros.typed_record import Record

NOT_TOLD = (
    "contact mode: a peg that came from the air stands below gamma0 on what may be a plate beside "
    "the hole, the cone of a chamfer or the bottom of the hole: unknown until it slips in, or its "
    "place decides (joints.hole_xyz_stddev, with joints.source: robot)"
)


class Found(IntEnum):
    """What is known of a way into the hole."""

    NOT_LOOKED = -1
    NONE = 0
    THERE = 1


class WayIn(Record):
    """
    Whether there is a way into the hole.

    Attributes
    ----------
    found : Found
    touches_since : float
        Since when the peg has touched the rim or in the hole, and no plate [s]; NaN: it does not.

    """

    found: Found
    touches_since: float


@compiled
def forget_way(way: WayIn) -> None:
    """Forget what was known of a way."""
    way.found = Found.NOT_LOOKED
    way.touches_since = nan


@compiled
def has_no_way(way: WayIn) -> bool:
    """Return whether the peg has come from the air, and nothing has shown it in the hole."""
    return way.found == Found.NONE


@compiled
def may_be_plate(way: WayIn, mode: Mode, evidence: Evidence) -> bool:
    """Return whether the mode is unknown as a plate and the bottom of the hole push alike."""
    undecided = mode == Mode.UNKNOWN and has_no_way(way)
    return undecided and evidence.plate * evidence.shown.below > 0.5


@compiled
def follow_way(
    way: WayIn, mode: Mode, evidence: Evidence, place: PlaceMisfit, flag: bool, t: float
) -> None:
    """
    Process a declared mode.

    A way is lost in the air above gamma0, where no peg is in its hole, and on anything elsewhere.

    Parameters
    ----------
    way : WayIn
        Changed.
    mode : Mode
        As declared.
    evidence : Evidence
    place : PlaceMisfit
    flag : bool
        Whether three-point contact has become two-point contact.
    t : float
        [s].

    """
    on_hole = mode == Mode.THREE_POINT or mode == Mode.TWO_POINT
    touches = on_hole and evidence.plate <= WAY_IN.plate
    way.touches_since = since_when(way.touches_since, touches, t)
    begun_so = way.found == Found.NOT_LOOKED and on_hole
    if begun_so or place.inside or flag or t - way.touches_since >= WAY_IN.lasts:
        way.found = Found.THERE
        return
    above = not evidence.shown.below > 0.5
    left = mode == Mode.OPEN and (above or way.found == Found.NOT_LOOKED)
    if left or mode == Mode.ELSEWHERE:
        way.found = Found.NONE
