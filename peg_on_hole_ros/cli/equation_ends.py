"""The picture and the file of where the equations end, which `peg-on-hole stability` writes."""

from collections.abc import Callable, Sequence

import numpy as np

from peg_on_hole_ros.cli.partial_table import PartialTable
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.study.equation_ends import MOST_FRICTION, MOTIONS, Wedging, wedging
from peg_on_hole_ros.study.fixed_steps import INTEGRATORS, SLIP_SCALES, Steps, longest_steps
from peg_on_hole_ros.study.map_places import USUAL, truth_at

EQUATION_COLUMNS = ("what", "of", "at", "value")
# What a row tells: the least friction that wedges over the tilt [rad]; the longest step [s], and
# what the law itself is off by, over the slip scale [m/s].
WEDGES, LONGEST_STEP, LAW = "wedges", "step", "law"
# Every so many slip scales where a quick look is enough.
_QUICK = 4


def fill_in(
    rows: PartialTable,
    configuration: Configuration,
    quick: bool,
    progress: Callable[[float], None],
) -> None:
    """
    Measure what is not there yet of `equations.csv`.

    Parameters
    ----------
    rows : PartialTable
        Of EQUATION_COLUMNS.
    configuration : Configuration
        Of its scene wedging is told; steps are told of the map's usual place in it.
    quick : bool
        Fewer slip scales.
    progress : callable
        Told the share done, 0 to 1.

    """
    kept = {tuple(row[:3]) for row in rows.rows}

    def add(found):
        texts = [[str(what), of, f"{at:.9g}", f"{value:.6g}"] for what, of, at, value in found]
        rows.add(row for row in texts if tuple(row[:3]) not in kept)

    for motion in MOTIONS:
        found = wedging(configuration.scene, motion)
        add([WEDGES, motion, t, f] for t, f in zip(found.tilt, found.friction))
    truth = truth_at(USUAL, configuration)
    scales = SLIP_SCALES[:: _QUICK if quick else 1] if truth is not None else ()
    for k, scale in enumerate(scales):
        # The last row of a scale.
        if (LAW, "", f"{scale:.9g}") not in kept:
            assert truth is not None
            steps = longest_steps(truth, scale)
            longest = [[LONGEST_STEP, name, scale, step] for name, step in steps.longest.items()]
            add([*longest, [LAW, "", scale, steps.law_off]])
        progress((k + 1) / len(scales))


def drawn_of(rows: Sequence[Sequence[str]]) -> tuple[list[Wedging], list[Steps]]:
    """Return what the rows of `equations.csv` say."""
    wedges = {motion: [] for motion in MOTIONS}
    longest: dict[float, dict[str, float]] = {}
    law: dict[float, float] = {}
    for what, of, at, value in rows:
        if what == WEDGES:
            wedges[of].append((float(at), float(value)))
        elif what == LONGEST_STEP:
            longest.setdefault(float(at), dict.fromkeys(INTEGRATORS, float("nan")))[of] = float(
                value
            )
        else:
            law[float(at)] = float(value)
    found = [Wedging(motion, *np.array(pairs).T) for motion, pairs in wedges.items()]
    return found, [Steps(scale, law[scale], longest[scale]) for scale in sorted(longest)]


def in_words(found: Sequence[Wedging], steps: Sequence[Steps]) -> str:
    """Return where the equations end, a line each."""
    lines = ["Where the equations of three contacts end:"]
    for one in found:
        lines.append(f"  {one.motion} {_wedges(one)}")
    if steps:
        first = steps[0]
        limits = (f"{name} {_microseconds(step)}" for name, step in first.longest.items())
        lines.append(f"  longest step, friction as sharp as it is: {', '.join(limits)}")
    return "\n".join(lines)


def _wedges(one):
    stretches = wedged_stretches(one)
    if not stretches:
        return f"wedges at no tilt up to a friction of {MOST_FRICTION:g}"
    return "wedges " + ", ".join(
        f"from {low:.3g} to {high:.3g} degrees where friction is {least:.2g} or more"
        for low, high, least in stretches
    )


def wedged_stretches(one: Wedging) -> list[tuple[float, float, float]]:
    """Return each stretch of tilts that wedges: from, to [degrees], and its least friction."""
    wedges = np.flatnonzero(~np.isnan(one.friction))
    parts = np.split(wedges, np.flatnonzero(np.diff(wedges) > 1) + 1)
    degrees = np.degrees(one.tilt)
    return [
        (float(degrees[part[0]]), float(degrees[part[-1]]), float(one.friction[part].min()))
        for part in parts
        if len(part)
    ]


def _microseconds(step):
    return f"{step * 1e6:.0f} us" if step == step else "none of those tried"
