"""
What each tuned number changes when it is halved and doubled, over scenes of all kinds.

Nothing is compiled for a value: in a copy of the package compiled code reads the numbers from
memory. A scene that never reads a number is not played with another value of it, nor are numbers
varied that are read at import, as sizes of memory are.
"""

import re
from collections import Counter
from collections.abc import Iterable
from functools import cache
from math import nan
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.faults import expected, faults, injector, play, score
from benchmarks.faults import scenes as faulted
from benchmarks.harness import copied
from benchmarks.harness.family import ESTIMATE, Family, Report
from benchmarks.harness.tables import table
from benchmarks.tuned_numbers import memory, player, scenes, whole
from benchmarks.tuned_numbers.player import (
    AT_IMPORT,
    CHANGED,
    ENDED,
    NOT_READ,
    RAISED,
    SAME,
    Asked,
    Beside,
    single_numbers,
)
from benchmarks.tuned_numbers.scenes import SCENES

FACTORS = (0.5, 2.0)
# A share that changes by less is noise of another draw, and so is a relative change of an error.
SHARE, RELATIVE = 0.01, 0.05
# Scenes with changed figures after which the others are left out.
ENOUGH = 4


class Varied(NamedTuple):
    """A number with a value in the place of its own; without a name: all as shipped."""

    number: str
    value: float

    def __str__(self):
        """Return a name for files and tables."""
        return f"{self.number} {self.value:g}" if self.number else "shipped"


SHIPPED = Varied("", 0.0)


@cache
def _beside(folder):
    return Beside(folder)


def score_member(varied: Varied, folder: Path) -> dict[str, dict]:
    """
    Return what becomes of each scene, see `player.Beside.ask`.

    Once figures of ENOUGH scenes have changed the others are left out: that it matters is seen.

    """
    beside, found, large = _beside(folder), {}, 0
    for scene in SCENES:
        if large == ENOUGH:
            break
        found[scene] = beside.ask(Asked(scene, *varied))
        if found[scene]["outcome"] == CHANGED:
            shipped = beside.ask(Asked(scene))["figures"]
            changes = _changes(shipped, found[scene]["figures"])
            large += any(notable(name, *pair) for name, pair in changes.items())
    return found


def _changes(shipped, figures):
    """Return of each figure that changed what it was and is; what is found bit for bit is none."""
    return {
        name: (shipped[name], new)
        for name, new in figures.items()
        if name != "found"
        and new != shipped[name]
        and (new == new or shipped[name] == shipped[name])
    }


def values(value: float) -> list[float]:
    """Return half and twice a value, of an int as ints; none where they are the value itself."""
    scaled = [type(value)(factor * value) for factor in FACTORS]
    return [each for each in scaled if each != value]


def members(options) -> list[Varied]:
    """Return all as shipped, and each value of each number."""
    return [SHIPPED] + [
        Varied(name, scaled) for name, value in single_numbers() for scaled in values(value)
    ]


class Row(NamedTuple):
    """
    What a value of a number changed, over all scenes.

    Attributes
    ----------
    number : str
    shipped, value : float
    effect : str
        `not varied`, `never read`, `nothing` (bit for bit), `little` (no figure by more than
        noise), `figures`, or `fails`.
    read, changed : int
        Scenes that read it, and in which it changed anything.
    most : dict of str to (change, str)
        Of each figure the largest change, and in which scene.
    texts : list of str
        Where another text was said, or a scene failed.

    """

    number: str
    shipped: float
    value: float
    effect: str
    read: int
    changed: int
    most: dict[str, tuple[float, str]]
    texts: list[str]


def rows(found: Iterable[tuple[Varied, dict]]) -> list[Row]:
    """Return a row for each value of each number."""
    of, by_name = dict(found), dict(single_numbers())
    shipped = of.pop(SHIPPED, {})
    return [
        _row(number, by_name[number], value, trees, shipped)
        for (number, value), trees in of.items()
    ]


def _row(number, own, value, trees, shipped) -> Row:
    outcomes = [tree["outcome"] for tree in trees.values()]
    most: dict[str, tuple[float, str]] = {}
    texts, large = [], False
    for scene, tree in trees.items():
        if tree["outcome"] in (RAISED, ENDED):
            texts.append(f"{scene}: {tree['what']}")
        if tree["outcome"] != CHANGED or scene not in shipped:
            continue
        changes = _changes(shipped[scene]["figures"], tree["figures"])
        for name, (old, new) in changes.items():
            large |= notable(name, old, new)
            if isinstance(new, str):
                if notable(name, old, new):
                    texts.append(f"{scene}: {name}: {new or '-'} for {old or '-'}")
            elif abs(_step(old, new)) >= abs(most.get(name, (0.0, ""))[0]):
                most[name] = (_step(old, new), scene)
    read = sum(each not in (NOT_READ, AT_IMPORT) for each in outcomes)
    changed = sum(each not in (NOT_READ, AT_IMPORT, SAME) for each in outcomes)
    if AT_IMPORT in outcomes:
        effect = "not varied"
    elif not read:
        effect = "never read"
    elif not changed:
        effect = "nothing"
    elif RAISED in outcomes or ENDED in outcomes:
        effect = "fails"
    else:
        effect = "figures" if large else "little"
    return Row(number, own, value, effect, read, changed, most, texts)


def _step(old, new):
    """Return a change; where a figure comes or goes it is the figure itself, with its sign."""
    if old != old or new != new:
        return new if old != old else -old
    return new - old


def notable(name: str, old: Any, new: Any) -> bool:
    """Return whether a figure has changed by more than another draw of the noise changes it."""
    if isinstance(new, str) and isinstance(old, str):
        return _without_numbers(new) != _without_numbers(old)
    if name in _COUNTS or old != old or new != new:
        return True
    if name in _SIZES:
        return abs(new - old) > RELATIVE * max(abs(old), abs(new))
    return abs(new - old) > SHARE


def _without_numbers(text):
    return re.sub(r"\d+(\.\d+)?(e[-+]?\d+)?", "#", text)


_COUNTS = {
    "wrong flags", "false alarms", "missed alarms", "wrenches answered", "poses",
    "spikes left out", "joint states", "turned both ways",
}  # fmt: skip
_SIZES = {
    "tilt RMS [mrad]", "reaction RMS [N]", "flag after [ms]", "error over stated",
    "stated deviation", "NIS", "mass error [g]", "mass known to [g]", "zero error [N]", "left [N]",
    "turned [degrees]", "missed [degrees]", "force [N]",
}  # fmt: skip
HEAD = ("number", "shipped", "value", "effect", "scenes that read it", "scenes changed")


def report(found, options) -> Report:
    """Return which numbers change nothing, and of each value the largest change of each figure."""
    made = rows(found)
    figures = list(dict.fromkeys(name for row in made for name in row.most))
    csv = [[*HEAD, *figures, "texts"]]
    for row in made:
        cells = [
            f"{row.most[n][0]:+.3g} {row.most[n][1]}" if n in row.most else "" for n in figures
        ]
        csv.append([
            row.number, f"{row.shipped:g}", f"{row.value:g}", row.effect, row.read, row.changed,
            *cells, " | ".join(row.texts),
        ])  # fmt: skip
    lines = [table(("effect of both values", "numbers"), _by_effect(made))]
    return Report("\n".join(lines), {"numbers": csv, "scenes": _scenes(found)})


_ORDER = ("fails", "figures", "little", "nothing", "never read", "not varied")


def _by_effect(made):
    """Yield numbers by the larger effect of their values; those with one value alone are told."""
    best: dict[str, str] = {}
    played = Counter(row.number for row in made)
    for row in made:
        best[row.number] = min(best.get(row.number, row.effect), row.effect, key=_ORDER.index)
    one = {name for name, of in single_numbers() if played[name] < len(values(of))}
    for effect in _ORDER:
        names = [f"`{n}`{' (one value)' * (n in one)}" for n, of in best.items() if of == effect]
        if names:
            yield f"{effect} ({len(names)})", ", ".join(names)
    missing = [name for name, of in single_numbers() if values(of) and not played[name]]
    rooms = {name.partition(".")[0] for name in played}
    names = [n if n.partition(".")[0] in rooms else f"{n.partition('.')[0]}.*" for n in missing]
    if missing:
        listed_once = ", ".join(f"`{name}`" for name in dict.fromkeys(names))
        yield f"not run ({len(missing)})", listed_once


def _scenes(found):
    """Yield a line for each scene, with what comes of it as shipped."""
    came = dict(found).get(SHIPPED, {})
    trees = {scene: tree["figures"] for scene, tree in came.items()}
    names = list(dict.fromkeys(name for tree in trees.values() for name in tree))
    yield ["scene", *names]
    for scene, tree in trees.items():
        yield [scene, *(_text(tree.get(name, nan)) for name in names)]


def _text(value):
    if isinstance(value, str):
        return value
    return "" if value != value else f"{value:.6g}"


FAMILY = Family(
    members, score_member, report, sources=(
        copied, expected, faulted, faults, injector, memory, play, player, score, scenes, whole,
    ),
    parts=(*ESTIMATE, "identification", "messages", "ros/diagnostics.py"),
)  # fmt: skip
