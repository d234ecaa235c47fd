"""Tables of the grid: one row a cell and class, and each promise with how much of it is kept."""

import numpy as np

STATES, REACTIONS = slice(0, 6), slice(6, 9)
LISTS = (
    "coverage", "coverage_determined", "ratio", "ratio_median", "bias", "stated", "ratio_bare",
    "rms",
)  # fmt: skip
SCALARS = (
    "samples", "sound", "determined", "contact", "missed", "missed_flagged", "nees_median",
)  # fmt: skip
CELL = ("seeds", "nis", "diverged", "restarts", "start_seeds", "start_diverged", "start_restarts")


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
        reactions_only = name in ("coverage_determined", "ratio_bare")
        head += [f"{name}_{q}" for q in (quantities[6:] if reactions_only else quantities)]
    rows = [head]
    for cell in cells:
        m = cell["motion"]
        first = [m["name"], m["clearance"], m["friction"], m["speed"], cell["noise"]]
        first += [cell["end"], cell["duration"], *(cell.get(name, "") for name in CELL)]
        for kind, figures in cell.get("classes", {}).items() or {"": {}}.items():
            row = [*first, kind, *(figures.get(name, "") for name in SCALARS)]
            for name in LISTS:
                width = 3 if name in ("coverage_determined", "ratio_bare") else 9
                row += figures.get(name) or [""] * width
            rows.append([f"{v:.5g}" if isinstance(v, float) else v for v in row])
    return rows


def verdicts(cells) -> list[dict]:
    """
    Return one entry for each promise: what it is, how many cells keep it, and the worst.

    Returns
    -------
    list of dict
        promise, cells (that it applies to), kept, worst (value and cell, text).

    """
    outside, window = _of(cells, "outside"), _of(cells, "window")
    steady = [(c, f) for c, f in outside if c["motion"]["name"] not in ("reversals", "weave")]
    turning = [(c, f) for c, f in outside if c["motion"]["name"] in ("reversals", "weave")]
    ran = [(c, c) for c in cells if "seeds" in c]
    found = []

    def add(promise, entries, value, keeps, badness):
        values = [(value(f), c) for c, f in entries if value(f) is not None]
        kept = sum(bool(keeps(v)) for v, _ in values)
        worst = max(values, key=lambda pair: badness(pair[0]), default=None)
        text = "" if worst is None else f"{_shown(worst[0])} ({name_of(worst[1])})"
        found.append({"promise": promise, "cells": len(values), "kept": kept, "worst": text})

    def worst_of(name, part, side):
        return lambda f: None if not f.get(name) else float(side(f[name][part]))

    def far(low, high):
        return lambda v: max(low - v, v - high)

    for words, part in (("states", STATES), ("reactions", REACTIONS)):
        add(
            f"steady sliding: RMSE of {words} at most 1.15 times the bound",
            steady, worst_of("ratio", part, np.max), lambda v: v <= 1.15, float,
        )  # fmt: skip
        add(
            f"reversals: median over time of {words} at most 1.10 times the bound outside windows",
            turning, worst_of("ratio_median", part, np.max), lambda v: v <= 1.10, float,
        )  # fmt: skip
    for words, part, low in (("reactions", REACTIONS, 0.93), ("states", STATES, 0.92)):
        for side, which in ((np.min, "lowest"), (np.max, "highest")):
            add(
                f"outside windows: {which} coverage of {words} within {low:.0%} to 97%",
                outside, worst_of("coverage", part, side),
                lambda v, low=low: low <= v <= 0.97, far(low, 0.97),
            )  # fmt: skip
        add(
            f"in windows: coverage of {words} at least 90 %",
            window, worst_of("coverage", part, np.min), lambda v: v >= 0.90, lambda v: -v,
        )  # fmt: skip
    add(
        "mean NIS within 10 % of 3",
        ran, lambda c: c["nis"], lambda v: 2.7 <= v <= 3.3, far(2.7, 3.3),
    )  # fmt: skip
    add(
        "outside windows: median NEES within 15 % of 6",
        outside, lambda f: f["nees_median"], lambda v: 5.1 <= v <= 6.9, far(5.1, 6.9),
    )  # fmt: skip
    add(
        "near-singular: flag up in at least 99 % of the samples that miss",
        _of(cells, "singular"),
        lambda f: f["missed_flagged"] / f["missed"] if f["missed"] else None,
        lambda v: v >= 0.99, lambda v: -v,
    )  # fmt: skip
    add("no divergence", ran, lambda c: c["diverged"], lambda v: v == 0, float)
    add(
        "no divergence after start errors of 0.1 rad in gamma, 1 rad in psi",
        ran, lambda c: c["start_diverged"], lambda v: v == 0, float,
    )  # fmt: skip
    return found


def _of(cells, kind):
    return [(c, c["classes"][kind]) for c in cells if kind in c.get("classes", {})]


def _shown(value):
    return f"{value:.4g}"


def summary(cells) -> str:
    """Return the summary in Markdown: the promises, and the motions that were cut short."""
    lines = ["| promise | cells | kept | worst |", "|---|---|---|---|"]
    for entry in verdicts(cells):
        lines.append("| {promise} | {cells} | {kept} | {worst} |".format(**entry))
    ended = {name_of(c).rsplit(" ", 1)[0]: c["end"] for c in cells if c["end"] != "complete"}
    if ended:
        lines += ["", "Cut short, or without three-point contact:", ""]
        lines += [f"- {name}: {end}" for name, end in ended.items()]
    return "\n".join(lines)
