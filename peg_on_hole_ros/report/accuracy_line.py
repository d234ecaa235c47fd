"""Which stated accuracy bounds the reactions, in words."""

from math import hypot

from peg_on_hole_ros.number_text import quantity
from peg_on_hole_ros.records import ACCURACY_PARAMETERS

# Kinds that are named, and what is worth a line [N].
_MOST_NAMED, _LEAST = 3, 0.05


def accuracy_line(deviations: dict[str, float | None]) -> str:
    """
    Return what stated accuracies add to the reactions, the largest first; empty: nothing.

    Parameters
    ----------
    deviations : dict of str to float or None
        By kind: standard deviation of the reaction that it moves most [N]; None: not determined.

    """
    known = {name: value for name, value in deviations.items() if value is not None}
    total = hypot(*known.values())
    if total < _LEAST:
        return ""
    largest = sorted(known, key=lambda name: -known[name])[:_MOST_NAMED]
    parts = ", ".join(
        f"{quantity(known[name], 'N', 2)} by {' and '.join(ACCURACY_PARAMETERS[name])}"
        for name in largest
        if known[name] >= _LEAST
    )
    return (
        f"stated accuracies add {quantity(total, 'N', 2)} to the standard deviation of the "
        f"reactions: {parts}"
    )
