"""
Transition, forecast, modes and alarms over insertion scenes with drawn parameters.

Labels come from the simulated motion and loads alone. Scenes of `--tuning` are for choosing
thresholds; those scored otherwise share no seed with them. Truths are kept as well, and not
integrated again for another monitor. With `--mismatch` the estimator is told a wrong friction and
clearance too, and closings are scored that another engine simulated.
"""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from benchmarks.harness.events import score_run
from benchmarks.harness.family import Family, Report
from benchmarks.harness.truths import play, truth_of
from benchmarks.scenes import draw, engine, families, labels, setting
from benchmarks.scenes.draw import FAMILIES, Case, estimator_of, noise_seeds, plan_of
from benchmarks.scenes.labels import labels_of
from benchmarks.scenes.tables import by_family, flat_runs, flat_scores, summary, tables

# What the estimator is told; the second try is that of a mismatch which has been through one.
VARIANTS = ("matched", "mismatch", "second_try")
QUICK_RUNS = 2 * len(FAMILIES)


class Scene(NamedTuple):
    """A case, what the estimator is told, and the rate of wrenches [Hz]; None: as it is."""

    case: Case
    variant: str = "matched"
    rate: int | None = None

    def __str__(self):
        """Return a name for files and tables."""
        at = "" if self.rate is None else f"_{self.rate}hz"
        return f"{self.case}_{self.variant}{at}"


def cases(runs: int, of: str = "scoring") -> list[Case]:
    """Return so many scenes, of all families in turn."""
    return [Case(FAMILIES[i % len(FAMILIES)], i // len(FAMILIES), of) for i in range(runs)]


def at_rate(plan, rate: int | None):
    """Return a plan with wrenches at a rate [Hz], orientations at no more; None: as it is."""
    if rate is None:
        return plan
    # Each orientation comes with a wrench.
    return replace(plan, wrench_rate=rate, joint_rate=rate // -(-rate // plan.joint_rate))


def score_member(scene: Scene, folder: Path) -> dict:
    """Return the figures of one scene, and how its truth ended."""
    case, variant = scene.case, scene.variant
    tree = {"variant": variant, **case._asdict()}
    if variant in engine.VARIANTS:
        return tree | {"end": "end"} | engine.score(case.number, variant)
    plan = at_rate(plan_of(case), scene.rate)
    truth, why = truth_of(plan, folder / "truths")
    if truth is None:
        return tree | {"end": why}
    configuration = estimator_of(case, plan, variant != "matched")
    record = play(truth, configuration, noise_seeds(case, 2 if variant == "second_try" else 1))
    return tree | {"end": truth.ended_by, **score_run(labels_of(truth), record)}


def members(options) -> list[Scene]:
    """Return the scenes asked for, with each of what the estimator is told."""
    variants = VARIANTS if options.mismatch else VARIANTS[:1]
    chosen = cases(_count(options), "tuning" if options.tuning else "scoring")
    found = [Scene(case, variant, options.wrench_rate) for case in chosen for variant in variants]
    if options.mismatch and options.wrench_rate is None:
        closings = [Case("mujoco", number) for number in engine.numbers()]
        found += [Scene(case, variant) for case in closings for variant in engine.VARIANTS]
    return found


def _count(options) -> int:
    default = QUICK_RUNS if options.quick else 300
    return default if options.runs is None else options.runs


def by_variant(found) -> dict[str, list[dict]]:
    """Return the figures of scenes that could be begun, {variant: runs}."""
    runs: dict[str, list[dict]] = {}
    for scene, tree in found:
        if "duration" in tree:
            runs.setdefault(scene.variant, []).append(tree)
    return runs


def report(found, options) -> Report:
    """Return the tables, figures of each run and score, and pictures."""
    from benchmarks.scenes import plot

    runs = by_variant(found)
    drawn = {name: of for name, of in runs.items() if name in VARIANTS}
    pictures = plot.draw({name: by_family(of) for name, of in drawn.items()}, drawn, options.out)
    short = summary(runs)
    text = f"{short}\n\n{tables(runs)}"
    out = [f"{scene}: {tree['end']}" for scene, tree in found if "duration" not in tree]
    if out:
        text += "\n\nLeft out, as they cannot be begun:\n\n- " + "\n- ".join(out)
    return Report(
        text,
        {"scores": flat_scores(runs), "runs": flat_runs(runs)},
        short,
        [path for path in pictures if path.suffix == ".png"],
    )


def add_options(parser) -> None:
    """Add how many scenes, and of which kind."""
    parser.add_argument("--runs", type=int, help=f"scenes (300; quick: {QUICK_RUNS})")
    parser.add_argument("--quick", action="store_true", help="two scenes of each family")
    parser.add_argument("--mismatch", action="store_true", help="wrong friction, clearance too")
    parser.add_argument("--tuning", action="store_true", help="scenes for choosing thresholds")
    parser.add_argument("--wrench-rate", type=int, metavar="HZ", help="slower than 1 kHz")


def check(options) -> str:
    """Return what is wrong with options."""
    rate = options.wrench_rate
    if _count(options) < 1:
        return "--runs is at least 1"
    if rate is not None and not 50 <= rate <= 1000:
        return f"--wrench-rate = {rate} Hz is not within 50 to 1000 Hz"
    if rate is not None and options.page:
        return "--page is for the scenes as they are: leave out --wrench-rate"
    return ""


FAMILY = Family(
    members, score_member, report, add_options, check,
    group=lambda scene: scene.case,
    sources=(draw, engine, families, labels, setting, engine.TRACES),
)  # fmt: skip
