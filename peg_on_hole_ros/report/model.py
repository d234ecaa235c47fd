"""What the scripts of a page draw, of one replay or of two outputs."""

from collections.abc import Sequence

import numpy as np

from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.plots.gaps import changes_with_gaps, with_gaps
from peg_on_hole_ros.records import CONTACTS
from peg_on_hole_ros.report.drawing import moving
from peg_on_hole_ros.report.words import risen

# A mode that flickers is drawn as finely as a plot has pixels, not finer.
_MOST_CHANGES = 3000


def model(
    panels: list[dict],
    tables: dict[str, dict[str, np.ndarray]],
    end_ns: int,
    modes: dict[str, list[tuple[int, str]]],
    alarms: Sequence[dict] = (),
    silence: float = float("inf"),
) -> dict:
    """
    Return plots and their data.

    Parameters
    ----------
    panels : list of dict
        See `panels`.
    tables : dict of str to dict of str to ndarray
        Columns by table and name, `t` among them.
    end_ns : int
        Passed time of the last output [ns].
    modes : dict of str to list of (int, str)
        Changes of the contact mode [ns] for each row of its plot.
    alarms : list of dict
        Changes of level, as in the summary.
    silence : float
        Without a row for longer a line breaks [s]; the times between rows are drawn by themselves.

    """

    def broken(name, changes):
        """Return changes of a mode that holds in no silence, where its table is known."""
        of = tables.get(name if name in tables else name.lower())
        return changes if of is None else changes_with_gaps(changes, of["t"], silence)

    used = {line["table"] for one in panels for line in one.get("lines", ())}
    told = [
        {"t": alarm["time"], "name": alarm["name"], "level": alarm["level"], "rises": rises}
        for alarm, rises in zip(alarms, risen(alarms))
    ]
    return {
        "panels": panels,
        "tables": {
            name: columns if name.endswith("_interval") else with_gaps(columns, silence)
            for name, columns in tables.items()
            if name in used
        },
        "end": max(end_ns * 1e-9, 1e-3),
        "begin": 0.0,
        "modes": [
            {
                "name": name,
                "changes": [[t * 1e-9, mode] for t, mode in _fewer(broken(name, changes), end_ns)],
            }
            for name, changes in modes.items()
        ],
        "alarms": told,
    }


def with_drawing(content: dict, moments: dict[str, np.ndarray], scene: Scene) -> dict:
    """Return the model with what moves in the drawing; it begins where the load is greatest."""
    if not len(moments["t"]):
        return content
    moves = moving(moments, scene)
    forces = np.array([[moves[f"{a}_{c}"] for a in "hez"] for c in CONTACTS])
    size = np.nan_to_num(np.sqrt((forces**2).sum(axis=1)))
    greatest = float(size.max(initial=0.0))
    begin = float(moves["t"][int(size.max(axis=0).argmax())]) if greatest else 0.0
    return content | {
        "moving": moves,
        "begin": begin,
        "greatest_force": greatest,
        "scene": {
            "hole_diameter": scene.hole_diameter,
            "peg_diameter": scene.peg_diameter,
            "peg_height": scene.peg_height,
            "friction": scene.friction,
        },
    }


def _fewer(changes, end_ns):
    """Return changes without modes that last less than a pixel, where there are very many."""
    if len(changes) <= _MOST_CHANGES:
        return changes
    least, kept = end_ns / _MOST_CHANGES, []
    for change in changes:
        if not kept or change[0] - kept[-1][0] >= least:
            kept.append(change)
    return kept
