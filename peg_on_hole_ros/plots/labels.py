"""Put labels beside points so that none covers another or a point."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

# Where a label may stand beside its point: direction, and from near to far [points].
_DIRECTIONS = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
_DISTANCES = (5, 10, 17, 26, 38, 54, 74)


def place_labels(
    axis: Axes, points: Sequence[tuple], texts: Sequence[str],
    sizes: Sequence[float] | None = None, weights: Sequence[str] | None = None,
    radii: Sequence[float] | None = None, bars: Sequence[tuple] = (), levels: Sequence[tuple] = (),
) -> list:  # fmt: skip
    """
    Label points; a label far from its point has a line to it.

    Parameters
    ----------
    axis : Axes
        With its limits and scales set, in a figure whose layout is done.
    points : sequence of tuple
        (x, y) in data coordinates.
    texts : sequence of str
    sizes, weights : sequence, optional
        Of the texts.
    radii : sequence of float, optional
        Of the markers [points].
    bars : sequence of tuple
        (x, low, high): vertical bars that no label covers, data coordinates.
    levels : sequence of tuple
        (y, left, right): horizontal ones.

    Returns
    -------
    list of Text
        One a point; where no free place was found the label stands as near as it can.

    """
    fig: Any = axis.get_figure()
    renderer = fig.canvas.get_renderer()
    pixels = axis.transData.transform(np.asarray(points, float))
    scale = fig.dpi / 72
    radii = radii or [3.0] * len(texts)
    taken = [_around(x, y, r * scale) for (x, y), r in zip(pixels, radii)]
    barred = []
    for x, low, high in bars:
        (left, bottom), (_, top) = axis.transData.transform([(x, low), (x, high)])
        barred.append((left - scale, bottom, left + scale, top))
    for y, start, end in levels:
        (left, bottom), (right, _) = axis.transData.transform([(start, y), (end, y)])
        barred.append((left, bottom - scale, right, bottom + scale))
    inside = axis.get_window_extent(renderer)
    frame = (inside.x0, inside.y0, inside.x1, inside.y1)
    labels = []
    for k, (x, y) in enumerate(pixels):
        text = axis.annotate(
            texts[k], points[k], xytext=(0, 0), textcoords="offset points", va="center",
            fontsize=sizes[k] if sizes else 8, weight=weights[k] if weights else "normal",
            color="black", zorder=5,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.3},
        )  # fmt: skip
        extent = text.get_window_extent(renderer)
        width, height = extent.width, extent.height
        others = barred + taken[:k] + taken[k + 1 :]
        offset = _free(x, y, radii[k], width, height, others, frame, scale)
        # The label's left end and middle are what is placed.
        text.set_position(offset)
        box = _box(x, y, offset, width, height, scale)
        # Two labels in one line keep a space between them.
        taken.append((box[0] - 4 * scale, box[1], box[2] + 4 * scale, box[3]))
        if np.hypot(*_gap(x, y, box)) > (9 + radii[k]) * scale:
            end = (min(max(x, box[0]), box[2]), min(max(y, box[1]), box[3]))
            ends = axis.transData.inverted().transform([(x, y), end])
            axis.plot(*ends.T, color="grey", linewidth=0.5, zorder=1, scalex=False, scaley=False)
        labels.append(text)
    return labels


def _free(x, y, radius, width, height, taken, frame, scale):
    best, least = (5.0, 0.0), np.inf
    for distance in _DISTANCES:
        for dx, dy in _DIRECTIONS:
            along = (distance + radius - 3) / np.hypot(dx, dy)
            left = dx * along - (width / scale if dx < 0 else width / scale / 2 if dx == 0 else 0)
            offset = (left, dy * (along + height / scale / 2))
            box = _box(x, y, offset, width, height, scale)
            covered = sum(_common(box, other) for other in taken) + _outside(box, frame)
            if covered == 0:
                return offset
            if covered < least:
                best, least = offset, covered
    return best


def _around(x, y, size):
    return x - size, y - size, x + size, y + size


def _box(x, y, offset, width, height, scale):
    left, middle = x + offset[0] * scale, y + offset[1] * scale
    return left, middle - height / 2, left + width, middle + height / 2


def _common(a, b):
    across = min(a[2], b[2]) - max(a[0], b[0])
    up = min(a[3], b[3]) - max(a[1], b[1])
    return across * up if across > 0 and up > 0 else 0.0


def _outside(box, frame):
    beyond = max(frame[0] - box[0], 0) + max(box[2] - frame[2], 0)
    return 100 * (beyond + max(frame[1] - box[1], 0) + max(box[3] - frame[3], 0))


def _gap(x, y, box):
    return max(box[0] - x, x - box[2], 0), max(box[1] - y, y - box[3], 0)
