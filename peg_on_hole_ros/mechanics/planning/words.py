"""A plan in words, and what is still possible from a present state in one sentence."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.mechanics.planning.cell import Cell
from peg_on_hole_ros.mechanics.planning.outlook import Outlook
from peg_on_hole_ros.mechanics.planning.search import MotionPlan
from peg_on_hole_ros.mechanics.planning.way_on import way_on
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.records import CONTACTS


def in_words(
    plan: MotionPlan, cell: Cell, max_normal: Sequence[float], remedies: Sequence[str] = ()
) -> str:
    """Return a plan as lines of text; `remedies` are those of `search.remedies`."""
    motion, lines = plan.motion, []
    if not plan.possible:
        lines.append("No motion within these limits is safe; the nearest is this one.")
    lines.append(f"From a tilt of {motion.start_tilt:.4g} rad, pushing {_press(cell)}:")
    before = (motion.start_tilt, motion.start_rates)
    for number, stage in enumerate(motion.stages, 1):
        lines.append(f"  {number}. {_stage(stage, before)}")
        before = stage.tilt, stage.rates
    lines.append(
        f"The motion takes {motion.duration:.3g} s and turns the peg by {motion.turning:.3g} rad. "
        f"{_outlook(plan.outlook, max_normal)}"
    )
    plain = f"at {-plan.plain.stages[-1].rates[0]:.3g} rad/s without turning"
    if motion.turn_tilt is None and plan.possible:
        lines.append("No turning is needed.")
    else:
        lines.append(f"Closing {plain}: {_lower(_outlook(plan.plain_outlook, max_normal))}")
    if not plan.possible:
        lines.append(
            "Each of these changes makes a motion possible: " + "; or ".join(remedies) + "."
            if remedies
            else "Reduce friction, or increase the clearance or the limits: neither a tenth of "
            "the push, nor eight times the slip, nor a tenth of the closing rate makes a "
            "motion possible."
        )
    return "\n".join(lines)


def advice(
    scene: Scene, cell: Cell, max_normal: Sequence[float], tilt: float, rates: ArrayLike
) -> str:
    """Return what `way_on` found in one sentence; parameters are those of it."""
    found = way_on(scene, cell, max_normal, tilt, rates)
    if not found.possible:
        ways = [f"turning up to {cell.max_slip_rate:g} rad/s"] if cell.max_slip_rate else []
        ways += [f"sliding up to {cell.max_slide_rate:g} rad/s"] if cell.max_slide_rate else []
        # Where less than a cause's least share is allowed, none may be named.
        why = [
            f" ({cause.value} with a probability of {_share(chance)})"
            for cause, chance in found.outlook.causes[:1]
        ]
        way = " or ".join(ways) or "closing"
        return f"lift the peg off, as no {way} keeps the limits{''.join(why)}"
    under = f", so that the load at {CONTACTS[found.contact]} stays under {found.load:g} N"
    if found.goes_on:
        return f"continue this motion and do not push harder{under}"
    lighter = f"push with at most {found.share:.0%}, " if found.share < 1 else ""
    return f"{lighter}{_change(found.motion.stages[-1].rates, rates)}{under}"


def _change(new, rates):
    closing, slide, slip = new
    slower = not np.isclose(closing, np.asarray(rates, float)[0], rtol=0.1)
    do = [f"close at {-closing:.2g} rad/s"] if slower else []
    do += [f"turn at {slip:.2g} rad/s"] if slip else []
    do += [f"slide at {slide:.2g} rad/s"] if slide else []
    return ", ".join(do) or "stop turning"


def _stage(stage, before):
    tilt, rates = before
    if rates == stage.rates:
        return (
            f"{_words(rates)}{_turn(rates)} for {stage.duration:.3g} s, "
            f"down to {stage.tilt:.4g} rad"
        )
    what = "begin to turn" if any(stage.rates[1:]) else "begin to close"
    return (
        f"{what} at {tilt:.4g} rad; after {stage.duration:.2g} s "
        f"{_words(stage.rates)}{_turn(stage.rates)}"
    )


def _words(rates):
    return f"close at {-rates[0]:.3g} rad/s"


def _turn(rates):
    parts = [
        f"{name} at {rate:.3g} rad/s" for name, rate in zip(("slide", "slip"), rates[1:]) if rate
    ]
    return "".join(f", {part}" for part in parts)


def _press(cell):
    return (
        ", ".join(f"{x:g} N along {axis}" for x, axis in zip(cell.press, "hez") if x) or "nothing"
    )


def _outlook(ahead: Outlook, max_normal):
    loads = ", ".join(
        f"{name} {mean:.3g} N (95 %: {high:.3g} N, limit {limit:g} N)"
        for name, mean, high, limit in zip(CONTACTS, ahead.peak, ahead.peak_high, max_normal)
    )
    text = (
        f"The peg wedges with a probability of {_share(ahead.wedge)}, and exceeds another limit "
        f"with {_share(ahead.overload)}. Largest loads: {loads}."
    )
    if ahead.expected:
        text += (
            f" With friction as stated {ahead.expected.value} at {ahead.expected_tilt:.4g} rad."
        )
    return text


def _lower(text):
    return text[0].lower() + text[1:]


def _share(probability):
    if probability < 1e-3:
        return "under 0.1 %"
    return f"{100 * probability:.2g} %" if probability < 0.99 else "over 99 %"


def as_data(plan: MotionPlan, cell: Cell, remedies: Sequence[str] = ()) -> dict:
    """Return a plan as plain data for a robot program; units as in the records."""
    motion = plan.motion
    return {
        "possible": plan.possible,
        "aim": cell.aim,
        "press": dict(zip("hez", map(float, cell.press))),
        "start": {"tilt": motion.start_tilt, "rates": _rates(motion.start_rates)},
        "turn_tilt": motion.turn_tilt,
        "duration": motion.duration,
        "turning": motion.turning,
        "stages": [
            {
                "name": stage.name,
                "duration": stage.duration,
                "tilt": stage.tilt,
                "rates": _rates(stage.rates),
            }
            for stage in motion.stages
        ],
        "outlook": _data(plan.outlook),
        "plain": {"closing_rate": -plan.plain.stages[-1].rates[0], **_data(plan.plain_outlook)},
        "remedies": list(remedies),
    }


def _rates(rates):
    return dict(zip(("gamma", "psi", "phi"), map(float, rates)))


def _data(ahead: Outlook):
    return {
        "wedge_probability": ahead.wedge,
        "overload_probability": ahead.overload,
        "expected": ahead.expected.name.lower() if ahead.expected else None,
        "expected_tilt": ahead.expected_tilt,
        "causes": {cause.name.lower(): chance for cause, chance in ahead.causes},
        "peak": dict(zip(CONTACTS, ahead.peak)),
        "peak_high": dict(zip(CONTACTS, ahead.peak_high)),
        "least_determinant": ahead.least_determinant,
    }
