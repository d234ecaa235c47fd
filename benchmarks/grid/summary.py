"""Tables of the grid: all cells, beside another checkout's, and each kind of cell."""

from typing import NamedTuple

import numpy as np

from benchmarks.harness.errors import QUANTITIES, REACTIONS, STATES
from benchmarks.harness.tables import table

ANGLES, RATES = slice(0, 3), slice(3, 6)
# Share of the samples within 95 % bounds that a cell has to reach.
STATES_COVERED, REACTIONS_COVERED, COVERED_IN_WINDOWS = 0.92, 0.93, 0.90
# Below this, what is called determined is not.
LEAST_DETERMINED = 0.85
LISTS = ("coverage", "coverage_error", "coverage_determined", "rms", "bound", "sharp", "ratio")
SCALARS = ("samples", "sound", "determined", "contact", "missed", "missed_flagged", "nees_median")
CELL = (
    "seeds", "nis", "diverged", "restarts", "start_seeds", "start_diverged", "start_restarts",
)  # fmt: skip


class Gate(NamedTuple):
    """
    What all cells come to.

    Attributes
    ----------
    cells, outside, window : int
        Cells that ran, and that have samples outside and in windows.
    states, reactions, states_in_windows, reactions_in_windows : float
        Root mean square of the worst quantity over the bound's median, geometric mean of cells.
    states_covered, reactions_covered : int
        Cells in which the least covered quantity reaches STATES_COVERED, REACTIONS_COVERED.
    states_covered_in_windows, reactions_covered_in_windows : int
        The same with COVERED_IN_WINDOWS.
    sharp_angles, sharp_rates, sharp_reactions : float
        Median stated deviation over root mean square of the errors, outside windows; median of
        cells and quantities.
    determined : float
        Share of the samples outside windows whose reactions are declared determined; mean.
    surely_wrong : int
        Cells of which the reactions that are declared determined are covered in less than
        LEAST_DETERMINED, in either class.
    nis : float
        Median of the cells.
    diverged, start_diverged : int
        Runs.

    """

    cells: int
    outside: int
    window: int
    states: float
    reactions: float
    states_in_windows: float
    reactions_in_windows: float
    states_covered: int
    reactions_covered: int
    states_covered_in_windows: int
    reactions_covered_in_windows: int
    sharp_angles: float
    sharp_rates: float
    sharp_reactions: float
    determined: float
    surely_wrong: int
    nis: float
    diverged: int
    start_diverged: int


def gate(cells) -> Gate:
    """Return what all cells come to."""
    ran = [cell for cell in cells if "seeds" in cell]
    outside, window = _of(ran, "outside"), _of(ran, "window")
    return Gate(
        len(ran), len(outside), len(window),
        _worst(outside, STATES), _worst(outside, REACTIONS),
        _worst(window, STATES), _worst(window, REACTIONS),
        _covered(outside, STATES, STATES_COVERED),
        _covered(outside, REACTIONS, REACTIONS_COVERED),
        _covered(window, STATES, COVERED_IN_WINDOWS),
        _covered(window, REACTIONS, COVERED_IN_WINDOWS),
        *(_median([f["sharp"][part] for f in outside]) for part in (ANGLES, RATES, REACTIONS)),
        float(np.mean([f["determined"] for f in outside])) if outside else float("nan"),
        sum(any(_surely_wrong(f) for f in cell["classes"].values()) for cell in ran),
        _median([cell["nis"] for cell in ran if cell["nis"] is not None]),
        sum(cell["diverged"] for cell in ran),
        sum(cell["start_diverged"] for cell in ran),
    )  # fmt: skip


def _of(cells, kind):
    return [cell["classes"][kind] for cell in cells if kind in cell["classes"]]


def _worst(entries, part):
    worst = [np.max(np.divide(f["rms"][part], f["bound"][part])) for f in entries]
    return float(np.exp(np.mean(np.log(worst)))) if worst else float("nan")


def _covered(entries, part, least):
    return sum(min(f["coverage"][part]) >= least for f in entries)


def _surely_wrong(figures):
    covered = figures["coverage_determined"]
    return covered is not None and min(covered) < LEAST_DETERMINED


def _median(values):
    return float(np.median(values)) if len(values) else float("nan")


# Field of Gate, what it is, whether it counts cells of a class, limit over another checkout's.
_ROWS = (
    ("states", "error over the bound, worst state, outside windows", None, "<= 0.95"),
    ("reactions", "error over the bound, worst reaction, outside windows", None, "<= 0.95"),
    ("states_in_windows", "error over the bound, worst state, in windows", None, "<= 1.0"),
    ("reactions_in_windows", "error over the bound, worst reaction, in windows", None, "<= 1.0"),
    (
        "states_covered",
        "cells whose states are covered in 92 %, outside windows",
        "outside",
        ">= 0.95",
    ),
    (
        "reactions_covered",
        "cells whose reactions are covered in 93 %, outside windows",
        "outside",
        ">= 0.95",
    ),
    (
        "states_covered_in_windows",
        "cells whose states are covered in 90 %, in windows",
        "window",
        ">= 0.95",
    ),
    (
        "reactions_covered_in_windows",
        "cells whose reactions are covered in 90 %, in windows",
        "window",
        ">= 0.95",
    ),
    (
        "surely_wrong",
        "cells whose determined reactions are covered in less than 85 %",
        "cells",
        "",
    ),
    ("sharp_angles", "standard deviation over RMS error, angles", None, ""),
    ("sharp_rates", "standard deviation over RMS error, rates", None, ""),
    ("sharp_reactions", "standard deviation over RMS error, reactions", None, ""),
    ("determined", "share of samples with determined reactions, outside windows", None, ""),
    ("nis", "mean NIS of orientations (expected: 3)", None, ""),
    ("diverged", "number of runs that diverged", None, ""),
    (
        "start_diverged",
        "number that diverged after start errors of 0.1 rad in gamma, 1 rad in psi",
        None,
        "",
    ),
)


def gate_table(cells, others=None) -> str:
    """Return a table of what all cells come to, beside those of another checkout."""
    this, other = gate(cells), gate(others) if others else None
    head = ["quantity", "this", "other", "this over other", "limit of the ratio"]
    head = head if other else ["quantity", "found"]
    rows = []
    for name, words, of, limit in _ROWS:
        shown = [_shown(one, name, of) for one in (this, other) if one]
        if other:
            before = getattr(other, name)
            over = f"{getattr(this, name) / before:.2f}" if limit and before else ""
            shown += [over, limit]
        rows.append([words, *shown])
    return table(head, rows)


def _shown(gate, name, of):
    value = getattr(gate, name)
    if of:
        return f"{value} of {getattr(gate, of)}"
    return f"{value}" if isinstance(value, int) else f"{value:.2f}"


def name_of(cell) -> str:
    """Return a cell's name."""
    m = cell["motion"]
    scene = f"{m['clearance'] * 1e3:g} mm f {m['friction']:g} {m['speed']:g} rad/s"
    return f"{m['name']} {scene} {cell['noise']}"


def flat_rows(cells, quantities):
    """Return the CSV's rows: a head, then one for each cell and class."""
    head = ["motion", "clearance_m", "friction", "speed_rad_s", "noise", "end", "duration_s"]
    head += [*CELL, "class", *SCALARS]
    for name in LISTS:
        head += [f"{name}_{q}" for q in _quantities(name, quantities)]
    rows = [head]
    for cell in cells:
        m = cell["motion"]
        first = [m["name"], m["clearance"], m["friction"], m["speed"], cell["noise"]]
        first += [cell["end"], cell["duration"], *(cell.get(name, "") for name in CELL)]
        for kind, figures in cell.get("classes", {}).items() or {"": {}}.items():
            row = [*first, kind, *(figures.get(name, "") for name in SCALARS)]
            for name in LISTS:
                row += figures.get(name) or [""] * len(_quantities(name, quantities))
            rows.append([f"{v:.5g}" if isinstance(v, float) else v for v in row])
    return rows


def _quantities(name, quantities):
    return quantities[REACTIONS] if name == "coverage_determined" else quantities


def sharpness(cells) -> str:
    """Return a table of stated deviation over RMS error, median of cells."""
    ran = [cell for cell in cells if "seeds" in cell]
    columns = []
    for kind in ("outside", "window"):
        sharp = [figures["sharp"] for figures in _of(ran, kind)]
        columns.append(np.median(sharp, axis=0) if sharp else np.full(len(QUANTITIES), np.nan))
    rows = [(name, f"{a:.2f}", f"{b:.2f}") for name, a, b in zip(QUANTITIES, *columns)]
    return table(
        ("standard deviation over RMS error", "ratio outside windows", "ratio in windows"), rows
    )


def kinds(cells) -> str:
    """Return a table of the same of the cells that have something in common."""
    common = {"name": str, "speed": "{:g} rad/s".format, "noise": "{} noise".format}
    common["friction"] = "f {:g}".format
    common["clearance"] = lambda value: f"{value * 1e3:g} mm"
    of_all = {
        (name, cell["motion"].get(name, cell["noise"]))
        for cell in cells
        for name in common
        if "seeds" in cell
    }
    head = (
        "cells", "number of cells", "error over the bound: worst state, reaction",
        "error over the bound in windows", "cells covered: states, reactions",
        "cells covered in windows", "share determined",
    )  # fmt: skip
    rows = []
    for name, value in sorted(of_all, key=lambda each: (list(common).index(each[0]), each[1])):
        g = gate([c for c in cells if c["motion"].get(name, c["noise"]) == value])
        rows.append(
            (
                common[name](value), g.cells, f"{g.states:.2f}, {g.reactions:.2f}",
                f"{g.states_in_windows:.2f}, {g.reactions_in_windows:.2f}",
                f"{g.states_covered}, {g.reactions_covered} of {g.outside}",
                f"{g.states_covered_in_windows}, {g.reactions_covered_in_windows} of {g.window}",
                f"{g.determined:.2f}",
            )
        )  # fmt: skip
    return table(head, rows)


def shortfalls(cells, most: int = 12) -> list[str]:
    """Return lines on the cells whose reactions are called determined and least covered."""
    found = []
    for cell in cells:
        for kind, figures in cell.get("classes", {}).items():
            if _surely_wrong(figures):
                found.append((min(figures["coverage_determined"]), name_of(cell), kind))
    found.sort()
    more = [f"- and {len(found) - most} more"] if len(found) > most else []
    return [f"- {name}, {kind}: {100 * c:.0f} %" for c, name, kind in found[:most]] + more


def summary(cells, others=None) -> str:
    """Return the summary in Markdown: all cells, kinds of cells, what falls short."""
    ran = [cell for cell in cells if "seeds" in cell]
    seeds = "; ".join(sorted({f"{c['seeds']} and {c['start_seeds']}" for c in ran}))
    lines = [
        f"{len(ran)} cells. Noise seeds of each, and runs with a wrong start: {seeds}.", "",
        gate_table(cells, others), "", sharpness(cells), "", kinds(cells),
    ]  # fmt: skip
    short = shortfalls(cells)
    if short:
        lines += [
            "",
            "Cells whose determined reactions are covered in less than 85 %:",
            "",
            *short,
        ]
    ended = {name_of(c).rsplit(" ", 1)[0]: c["end"] for c in cells if c["end"] != "complete"}
    if ended:
        lines += [
            "",
            f"Number of motions that end early or lose three-point contact: {len(ended)}.",
        ]
    return "\n".join(lines)
