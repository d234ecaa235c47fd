"""Tables of the grid: one row a cell and class, and each promise with how much of it is kept."""

from math import inf

import numpy as np
from scipy.stats import norm

STATES, REACTIONS = slice(0, 6), slice(6, 9)
LISTS = (
    "coverage", "coverage_error", "coverage_determined", "ratio", "ratio_error", "ratio_median",
    "ratio_median_error", "bias", "stated", "ratio_bare", "rms",
)  # fmt: skip
SCALARS = (
    "samples", "sound", "determined", "contact", "missed", "missed_flagged", "nees_median",
    "nees_error",
)  # fmt: skip
CELL = (
    "seeds", "nis", "nis_error", "diverged", "restarts", "start_seeds", "start_diverged",
    "start_restarts",
)  # fmt: skip


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
        promise, cells (that it applies to), kept (by the figures as they are), broken (for which
        the figures lie outside with 95 % confidence, whichever quantity is the worst), worst
        (value and cell, text).

    """
    outside, window = _of(cells, "outside"), _of(cells, "window")
    steady = [(c, f) for c, f in outside if c["motion"]["name"] not in ("reversals", "weave")]
    turning = [(c, f) for c, f in outside if c["motion"]["name"] in ("reversals", "weave")]
    ran = [(c, c) for c in cells if "seeds" in c]
    found = []

    def add(promise, entries, name, part, low, high, error=None):
        kept = broken = count = 0
        worst = (-1.0, "")
        for cell, figures in entries:
            values = np.atleast_1d(figures[name] if figures.get(name) is not None else [])[part]
            if not len(values):
                continue
            errors = np.atleast_1d(figures[error])[part] if error else np.zeros(len(values))
            count += 1
            beyond = np.maximum(low - values, values - high)
            kept += bool((beyond <= 0).all())
            # Any one of so many quantities may be off by chance.
            limit = norm.ppf(1 - 0.025 / len(values))
            broken += bool((beyond > limit * errors).any())
            at = int(np.argmax(beyond))
            worst = max(worst, (beyond[at], f"{_shown(values[at])} ({name_of(cell)})"))
        found.append(
            {"promise": promise, "cells": count, "kept": kept, "broken": broken, "worst": worst[1]}
        )

    for words, part in (("states", STATES), ("reactions", REACTIONS)):
        add(
            f"steady sliding: RMSE of {words} at most 1.15 times the bound",
            steady, "ratio", part, -inf, 1.15, "ratio_error",
        )  # fmt: skip
        add(
            f"reversals: median over time of {words} at most 1.10 times the bound outside windows",
            turning, "ratio_median", part, -inf, 1.10, "ratio_median_error",
        )  # fmt: skip
    for words, part, low in (("reactions", REACTIONS, 0.93), ("states", STATES, 0.92)):
        add(
            f"outside windows: coverage of {words} at least {low:.0%}",
            outside, "coverage", part, low, inf, "coverage_error",
        )  # fmt: skip
        add(
            f"outside windows: coverage of {words} at most 97%",
            outside, "coverage", part, -inf, 0.97, "coverage_error",
        )  # fmt: skip
        add(
            f"in windows: coverage of {words} at least 90 %",
            window, "coverage", part, 0.90, inf, "coverage_error",
        )  # fmt: skip
    one = slice(None)
    add("mean NIS within 10 % of 3", ran, "nis", one, 2.7, 3.3, "nis_error")
    add(
        "outside windows: median NEES within 15 % of 6",
        outside, "nees_median", one, 5.1, 6.9, "nees_error",
    )  # fmt: skip
    singular = [
        (c, {"flagged": f["missed_flagged"] / f["missed"]})
        for c, f in _of(cells, "singular")
        if f["missed"]
    ]
    add(
        "near-singular: flag up in at least 99 % of the samples that miss",
        singular, "flagged", one, 0.99, inf,
    )  # fmt: skip
    add("no divergence", ran, "diverged", one, -inf, 0)
    add(
        "no divergence after start errors of 0.1 rad in gamma, 1 rad in psi",
        ran, "start_diverged", one, -inf, 0,
    )  # fmt: skip
    return found


def _of(cells, kind):
    return [(c, c["classes"][kind]) for c in cells if kind in c.get("classes", {})]


def _shown(value):
    return f"{value:.4g}"


def medians(cells) -> list[str]:
    """
    Return rows in Markdown: medians over the cells that have something in common.

    RMSE over the bound: the worst quantity's median over time; coverage: the worst quantity's.
    """
    common = {"name": str, "speed": "{:g} rad/s".format, "noise": "{} noise".format}
    common["friction"] = "f {:g}".format
    common["clearance"] = lambda value: f"{value * 1e3:g} mm"
    of_all = {
        (name, cell["motion"].get(name, cell["noise"]))
        for cell in cells
        for name in common
        if "seeds" in cell
    }
    rows = [
        "| cells | number | RMSE states | RMSE reactions | coverage states | reactions |"
        " in windows: states | reactions | NIS | NEES |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, value in sorted(of_all, key=lambda each: (list(common).index(each[0]), each[1])):
        some = [c for c in cells if c["motion"].get(name, c["noise"]) == value and "seeds" in c]
        figures = [
            *(_median(_of(some, "outside"), "ratio_median", p, max) for p in (STATES, REACTIONS)),
            *(_median(_of(some, "outside"), "coverage", p, min) for p in (STATES, REACTIONS)),
            *(_median(_of(some, "window"), "coverage", p, min) for p in (STATES, REACTIONS)),
            _median([(c, c) for c in some], "nis", slice(None), max),
            _median(_of(some, "outside"), "nees_median", slice(None), max),
        ]
        shown = " | ".join(f"{figure:.2f}" for figure in figures)
        rows.append(f"| {common[name](value)} | {len(some)} | {shown} |")
    return rows


def _median(entries, name, part, worst):
    values = [f[name] for _, f in entries if f.get(name) is not None]
    found = [worst(np.atleast_1d(value)[part]) for value in values if np.size(value)]
    return float(np.median(found)) if found else np.nan


def summary(cells) -> str:
    """Return the summary in Markdown: the promises, motions that were cut short, medians."""
    lines = ["| promise | cells | kept | surely not | worst |", "|---|---|---|---|---|"]
    for entry in verdicts(cells):
        lines.append("| {promise} | {cells} | {kept} | {broken} | {worst} |".format(**entry))
    ended = {name_of(c).rsplit(" ", 1)[0]: c["end"] for c in cells if c["end"] != "complete"}
    if ended:
        lines += ["", "Cut short, or without three-point contact:", ""]
        lines += [f"- {name}: {end}" for name, end in ended.items()]
    lines += ["", *medians(cells)]
    return "\n".join(lines)
