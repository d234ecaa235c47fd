"""The names in `~/monitor`: one list in one order for the life of a node, whatever is known."""

from math import nan

_BIAS = tuple(f"bias_{kind}_{axis}" for kind in ("force", "torque") for axis in "xyz")
_LEARNT = (*_BIAS, "hole_tilt_x", "hole_tilt_y")

MONITOR_NAMES = (
    "transition_probability",
    "time_to_transition",
    "time_to_transition_stddev",
    "jamming_risk",
    "jamming_wedging",
    "jamming_stall",
    "jamming_load",
    "determinant",
    "insertion_ratio",
    "whitney_margin",
    "three_point_validity",
    "mode_probability_three_point",
    "mode_probability_two_point",
    "mode_probability_opened",
    "mode_probability_stuck",
    "mode_probability_free",
    "mode_probability_unknown",
    "contact_age",
    "contact_latency",
    "free_age",
    "free_latency",
    "reactions_determined",
    "friction",
    "friction_stddev",
    "clearance",
    "clearance_stddev",
    "position_offset",
    "position_misfit",
    "nis_median",
    "nis_drift",
    "joints_noise",
    *_LEARNT,
    *(f"{name}_stddev" for name in _LEARNT),
)
_KNOWN = frozenset(MONITOR_NAMES)


def monitor_values(told: dict[str, float]) -> list[float]:
    """
    Return a value for each of MONITOR_NAMES, NaN for one that does not exist at present.

    Raises
    ------
    KeyError
        A name that is not in the list: it would be lost without a word.

    """
    if not told.keys() <= _KNOWN:
        raise KeyError(f"not in MONITOR_NAMES: {sorted(told.keys() - _KNOWN)}")
    return [float(told.get(name, nan)) for name in MONITOR_NAMES]
