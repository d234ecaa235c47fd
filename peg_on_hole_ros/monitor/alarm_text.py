"""The texts of the alarms, by the numbers of a row."""

from math import isnan

import numpy as np

from peg_on_hole_ros.monitor.dangers.registry import ADVICE, IN_HOLE_OUTPUTS, ON_RIM_OUTPUTS
from peg_on_hole_ros.monitor.output_row import NOT_JUDGED
from peg_on_hole_ros.records import CONTACTS, Alarm

# Places of a lost contact that is not distinguished, and of all of them.
ANY, ALL = 3, 4
# Which names an alarm's numbers have.
PLAIN, HOLE = 1, 2

# What each level states, for K, B1 and B2 where one of them is meant: built once, chosen often.
_NO_JAMMING = "nothing jams the peg ahead"
# OK, WARN, ERROR; K, B1 or B2 where it is known which, then any of them, then the whole peg.
_LOST_WHICH = tuple(f"contact {c}" for c in CONTACTS)
_CONTACT_LOSS = (
    ("no contact is being lost",) * 5,
    (
        *(f"{c} opens: press the peg on, or tilt it less" for c in _LOST_WHICH),
        "a contact opens: press the peg on, or tilt it less",
        "the peg leaves the rim: press it on, or continue the program without contact",
    ),
    (
        *(f"{c} is open: press the peg on, or tilt it less" for c in _LOST_WHICH),
        "a contact is open, the peg no longer rests on three points: press it on, or begin again",
        "the peg has left the rim: begin again from free air, or press it on",
    ),
)
_OVERLOAD = (
    ("every contact is within its allowed load",) * 3,
    tuple(f"contact {c} nears its allowed load: reduce the force" for c in CONTACTS),
    tuple(
        f"contact {c} is over its allowed load, or is about to be: reduce the force, or reverse"
        for c in CONTACTS
    ),
)
_TEXTS = (
    ((_NO_JAMMING,) * len(ADVICE), *zip(*ADVICE)),
    _CONTACT_LOSS,
    _OVERLOAD,
)
# Before what an alarm stated, while it is held without a value at its threshold.
HELD_PREFIX = "no longer above its threshold, and held for a while; it was: "
_DOUBT = "not judged: the wrench contradicts its settings (/diagnostics, filter)"
_LOSS_NAMES = (
    *(f"open_probability_{c}" for c in CONTACTS), "opened_probability", "free_probability",
)  # fmt: skip
_LOAD_NAMES = (
    "jamming_load", *(f"normal_{c}" for c in CONTACTS), *(f"max_normal_{c}" for c in CONTACTS),
)  # fmt: skip
_NAMES = (((), ON_RIM_OUTPUTS, IN_HOLE_OUTPUTS), ((), _LOSS_NAMES), ((), _LOAD_NAMES))
ALARM_NAMES = ("jamming", "contact_loss", "overload")


def alarms_of(alarms: np.ndarray, friction_before: float, friction: float) -> tuple[Alarm, ...]:
    """
    Return the alarms in words.

    Parameters
    ----------
    alarms : ndarray, shape (3,)
        Of a row, see `outputs.AlarmRow`.
    friction_before, friction : float
        Before its last step and now [-]; NaN: no step was found.

    """
    if alarms["level"][0] < 0:
        return ()
    step = _friction_step(float(friction_before), float(friction))
    jamming, *others = map(_alarm, range(len(ALARM_NAMES)), alarms.tolist())
    return jamming._replace(message=jamming.message + step), *others


def _friction_step(before: float, after: float) -> str:
    """Return what follows the text on jamming once friction has stepped."""
    if isnan(before):
        return ""
    how = "risen" if after > before else "fallen"
    return f"; friction has {how} from {before:.2f} to {after:.2f}"


def _alarm(i: int, alarm: tuple[int, int, int, int, np.ndarray]) -> Alarm:
    level, which, held, kind, numbers = alarm
    text = _DOUBT if held == NOT_JUDGED else _TEXTS[i][level][which]
    names = _NAMES[i][kind]
    values = tuple(numbers[: len(names)].tolist())
    return Alarm(ALARM_NAMES[i], level, HELD_PREFIX + text if held == 1 else text, names, values)
