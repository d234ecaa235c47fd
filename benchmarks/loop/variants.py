"""The five variants of the program that see the same draws, and their options in a draw."""

from functools import cache
from types import ModuleType
from typing import NamedTuple

from benchmarks.loop import drawn
from peg_on_hole_ros.mechanics.planning.search import plan_motion
from peg_on_hole_ros.mechanics.planning.words import as_data

QUIET = {"follow_modes": False, "stop_on_error": False, "follow_warn": False}


class Variant(NamedTuple):
    """
    A variant of the program.

    Attributes
    ----------
    words, short : str
        Its name in tables, and in pictures.
    options : dict
        Of the program, where they differ from the defaults.
    planned : bool
        Whether it closes by the plan.
    level : int or None
        Of alarms, from which it differs from the variant `like`: below it the run is the same.
    like : str

    """

    words: str
    short: str
    options: dict
    planned: bool = False
    level: int | None = None
    like: str = "plain"


VARIANTS = {
    "plain": Variant(
        "(a) plain, the controller's force limit alone", "(a) force limit alone", QUIET
    ),
    "stop": Variant(
        "(b) stops on ERROR and tries again", "(b) stops on ERROR",
        QUIET | {"stop_on_error": True}, level=2,
    ),
    "advice": Variant(
        "(c) also follows modes, flag and WARN", "(c) modes, flag, WARN", {}
    ),
    "plan": Variant("(d) plain, by the plan", "(d) the plan alone", QUIET, True, like="plan"),
    "all": Variant("(e) all", "(e) all", {}, True),
}  # fmt: skip


@cache
def plan_of(true: drawn.Try) -> dict:
    """Return the plan for what is stated of a draw; it takes half a second."""
    stated = drawn.configuration_of(true)
    found = plan_motion(stated.scene, stated.plan, stated.monitor.max_normal)
    return as_data(found, stated.plan, ())


def options_of(module: ModuleType, true: drawn.Try, name: str):
    """Return the options of the program in a variant."""
    variant, scene = VARIANTS[name], drawn.configuration_of(true).scene
    plan = plan_of(true) if variant.planned else None
    return module.Options(scene.hole_diameter, scene.peg_diameter, **variant.options, plan=plan)
