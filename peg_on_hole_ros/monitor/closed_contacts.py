"""Whether contacts are closed: by the contact mode, and by their load if that leaves it open."""

from typing import Any

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.states import Mode


def are_closed(mode: Any, normal: Any) -> Any:
    """
    Return whether contacts are closed: by the mode, and by their load if the mode leaves it open.

    A load that is published as none, near zero or before it is determined, opens no contact.

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
