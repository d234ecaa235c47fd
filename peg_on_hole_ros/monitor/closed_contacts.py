"""Whether contacts are closed: by the contact mode, and by their load where that says nothing."""

from typing import Any

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.states import Mode


def are_closed(mode: Any, normal: Any) -> Any:
    """
    Return whether contacts are closed: as the mode says, and by their load where it says nothing.

    A load that is told as none, near zero or before it is told at all, opens no contact.

    Parameters
    ----------
    mode : int or ndarray
        Place in MODES; broadcast.
    normal : float or ndarray
        Reactions [N].

    """
    touches = (mode == Mode.THREE_POINT.value) | (mode == Mode.TWO_POINT.value)
    return touches | ((mode == Mode.UNKNOWN.value) & (normal > 0.0))


is_closed = compiled(are_closed)
