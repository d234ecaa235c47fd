"""The transition flag: three-point contact has become two-point contact."""

from math import nan

from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.monitor.memory import since_when
from peg_on_hole_ros.record_types import DeclaredRecord, ThresholdsRecord

# A peg that has been in the air above gamma0 for so long [s] has left the rim.
LEFT = 0.2


@compiled
def lower_flag(d: DeclaredRecord) -> None:
    """Lower the flag, and forget what it was raised for."""
    d.flag = d.armed = 0
    d.fallen = d.left = nan


@compiled
def raise_flag(
    d: DeclaredRecord, o: ThresholdsRecord, t: float, below: float, touching: float
) -> None:
    """
    Raise the flag once three-point contact has become two-point contact, or lower it.

    It can rise after contact above gamma0 only, and not once the peg has left the rim again: one
    that comes upright through the air has not gone through three-point contact. It falls once the
    tilt has surely been above gamma0 for a while.

    Parameters
    ----------
    d : record of FIELDS
        Changed.
    o : record of THRESHOLDS
    t : float
        [s].
    below, touching : float
        Probabilities that gamma is below gamma0, and that anything touches.

    """
    if d.flag:
        d.fallen = since_when(d.fallen, not below >= o.transition_probability_off, t)
        if t - d.fallen >= o.transition_hold and t > d.fallen:
            lower_flag(d)
        return
    above = touching * (1.0 - below)
    if above > o.transition_probability_on:
        d.armed = 1
    d.left = since_when(d.left, not (1.0 - touching) * (1.0 - below) <= 0.5, t)
    if t - d.left >= LEFT:
        d.armed = 0
    d.flag = 1 if d.armed and touching * below > o.transition_probability_on else 0
    d.fallen = nan
