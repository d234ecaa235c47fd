"""The edges of the range in which the default works: found by bisection, and put in words."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.study.chart import LEAST_DETERMINED
from peg_on_hole_ros.study.map_places import Axis, MapPlace
from peg_on_hole_ros.study.runs import LEAST_COVERED
from peg_on_hole_ros.study.stability import DEFAULT, Result, Verdict

# A value at which it works and one at which it does not are apart by at most this factor.
EDGE_RATIO = 1.1
SIDES = ("below", "above")
Found = Mapping[tuple[MapPlace, str], Result]


class Edge(NamedTuple):
    """
    One side of an axis, from the usual value on.

    Attributes
    ----------
    axis : Axis
    side : str
        Of SIDES.
    last : float or None
        The furthest value up to which all work; None: not even the usual one does.
    first : float or None
        The next one, which does not; None: all work.
    results : tuple of (float, Result)
        Away from the usual value, which comes first.

    """

    axis: Axis
    side: str
    last: float | None
    first: float | None
    results: tuple[tuple[float, Result], ...]


def edge_of(found: Found, axis: Axis, side: str) -> Edge:
    """Return an edge as far as it is found."""
    usual, sign = axis.usual, -1.0 if side == "below" else 1.0
    own = {
        float(getattr(place, axis.name)): result
        for (place, method), result in found.items()
        if method == DEFAULT and place == axis.place(getattr(place, axis.name))
    }
    values = sorted((v for v in own if sign * v >= sign * usual), key=lambda v: sign * v)
    last = first = None
    for value in values:
        if own[value].verdict is not Verdict.HOLDS:
            first = value
            break
        last = value
    return Edge(axis, side, last, first, tuple((value, own[value]) for value in values))


def next_value(edge: Edge, ratio: float = EDGE_RATIO) -> float | None:
    """Return the value to look at next, halfway in its logarithm; None: the edge is found."""
    if edge.last is None or edge.first is None or not edge.axis.halved:
        return None
    low, high = sorted((edge.last, edge.first))
    if low <= 0.0 or not np.isfinite(high) or high / low <= ratio:
        return None
    middle = edge.axis.rounded(float(np.sqrt(low * high)))
    return middle if low < middle < high else None


def in_words(edge: Edge) -> str:
    """Return where a side ends, and how: one phrase."""
    axis, results = edge.axis, dict(edge.results)
    furthest = edge.results[-1][0]
    if edge.last is None:
        return f"not at {axis.text(axis.usual)}: {what(results[axis.usual])}"
    if edge.first is None:
        if furthest == axis.usual:
            return ""
        return f"works {'down' if edge.side == 'below' else 'up'} to {axis.text(furthest)}"
    text = f"{edge.side} {axis.text(edge.last)}: {what(results[edge.first])}"
    if not axis.halved:
        text = f"at {axis.text(edge.first)}: {what(results[edge.first])}"
    beyond = [value for value, _ in edge.results if _beyond(edge, value)]
    if beyond:
        far = results[furthest]
        if far.verdict is not Verdict.HOLDS:
            text += f"; at {axis.text(furthest)}: {what(far)}"
        again = [axis.text(v) for v in beyond if results[v].verdict is Verdict.HOLDS]
        if again:
            text += f"; works again at {', '.join(again)}"
    return text


def _beyond(edge, value):
    return value < edge.first if edge.side == "below" else value > edge.first


def what(result: Result) -> str:
    """Return the result of an estimator that does not work, in words and figures."""
    if result.verdict is Verdict.NONE:
        return "no motion on three contacts"
    if result.verdict is Verdict.DIVERGED:
        return f"{result.lost} of {result.seeds} runs diverge"
    if result.verdict is Verdict.ERRS:
        return f"bounds of {result.worst} cover {_percent(result.inside, LEAST_COVERED)} %"
    if result.verdict is Verdict.UNDETERMINED:
        return f"reactions determined in {_percent(result.determined, LEAST_DETERMINED)} %"
    return "works"


def _percent(share, limit):
    """Return percent, with as many digits as it takes to distinguish it from a limit."""
    text = ""
    for digits in range(3):
        text = f"{100.0 * share:.{digits}f}"
        if float(text) != 100.0 * limit:
            break
    return text
