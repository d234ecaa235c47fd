"""The transition flag: three-point contact has become two-point contact."""

from math import nan

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.settings import MonitorSettings
from peg_on_hole_ros.monitor.states import since_when
from peg_on_hole_ros.monitor.tuned import TRANSITION_FLAG
from peg_on_hole_ros.typed_record import Record


class Transition(Record):
    """
    The flag, and what it depends on; a time of NaN is none.

    Attributes
    ----------
    flag : bool
    contact_above_gamma0 : bool
        Whether there was contact above gamma0, so that the flag may rise.
    above_gamma0_since : float
        Since when the tilt has been above gamma0 again [s].
    in_air_above_gamma0_since : float
        Since when the peg has been in the air above gamma0 [s].

    """

    flag: bool
    contact_above_gamma0: bool
    above_gamma0_since: float
    in_air_above_gamma0_since: float


@compiled
def lower_flag(transition: Transition) -> None:
    """Lower the flag, and forget what it was raised for."""
    transition.flag = transition.contact_above_gamma0 = False
    transition.above_gamma0_since = transition.in_air_above_gamma0_since = nan


@compiled
def update_flag(
    transition: Transition, settings: MonitorSettings, t: float, below: float, touching: float
) -> None:
    """
    Raise the flag once three-point contact has become two-point contact, or lower it.

    It can rise after contact above gamma0 only, and not once the peg has left the rim again: one
    that comes upright through the air has not gone through three-point contact. It falls once the
    tilt has been above gamma0 for a while, beyond its uncertainty.

    Parameters
    ----------
    transition : Transition
        Changed.
    settings : MonitorSettings
    t : float
        [s].
    below, touching : float
        Probabilities that gamma is below gamma0, and that anything touches.

    """
    if transition.flag:
        is_above = not below >= settings.transition_probability_off
        since = since_when(transition.above_gamma0_since, is_above, t)
        transition.above_gamma0_since = since
        if t - since >= settings.transition_hold and t > since:
            lower_flag(transition)
        return
    if touching * (1.0 - below) > settings.transition_probability_on:
        transition.contact_above_gamma0 = True
    in_air = not (1.0 - touching) * (1.0 - below) <= 0.5
    since = since_when(transition.in_air_above_gamma0_since, in_air, t)
    transition.in_air_above_gamma0_since = since
    if t - since >= TRANSITION_FLAG.left:
        transition.contact_above_gamma0 = False
    inside = touching * below > settings.transition_probability_on
    transition.flag = transition.contact_above_gamma0 and inside
    transition.above_gamma0_since = nan
