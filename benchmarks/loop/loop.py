"""
A robot program in the loop: what stops, advice and plan change over drawn tries to insert.

A try draws friction, clearance, where the hole is and how it leans, how the peg is gripped, and
the sensor's noise. `examples/insert.py` then inserts in a cell of MuJoCo, in lockstep with the
pipeline, in five variants that see the same draws. Loads are the engine's. A variant whose alarms
never rose to what it reacts to is the same run as the one without, and is not run again. Touches
of the plate have measured before how the hole leans, unless `--unsurveyed` says otherwise.
"""

from pathlib import Path

import numpy as np

from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.pooled import share, spread
from benchmarks.harness.tables import table
from benchmarks.loop import drawn, variants
from benchmarks.loop.drawn import MOST_LOAD
from benchmarks.loop.program import program_module
from benchmarks.loop.variants import VARIANTS, options_of, plan_of
from benchmarks.robot_cells import arms, sensing

HERE = Path(__file__).parent
HEAD = (
    "program", "tries [-]", "inserted at first", "in the end",
    "time of harmless tries over (a), median [-]", "largest load, median, 95 %, worst [N]",
    f"above {MOST_LOAD:.0f} N", "stuck or stopped", "needless stops",
)  # fmt: skip
OTHER_STOPS = ("force limit", "nothing touched", "no hole found", "not in")


def members(options) -> list[Member]:
    """Return the draws."""
    kind = "leaning" if options.unsurveyed else "try"
    return [
        Member(f"{kind}_{number:03d}", drawn.drawn(number, not options.unsurveyed))
        for number in range(options.first, options.first + options.tries)
    ]


def tries_option(parser) -> None:
    """Add how many tries are drawn."""
    parser.add_argument("--tries", type=int, default=20, help="drawn tries (20)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (0)")
    parser.add_argument(
        "--unsurveyed", action="store_true",
        help="nothing has measured how the hole leans: by up to 1.5 degrees",
    )  # fmt: skip


def score_member(member: Member, folder: Path) -> dict:
    """Return what becomes of a draw in each variant."""
    from benchmarks.loop.lockstep import play  # MuJoCo is no part of the extra `dev`

    module, true = program_module(), member.of
    found: dict[str, dict] = {}
    for name, variant in VARIANTS.items():
        if variant.level is not None and found[variant.like]["worst_level"] < variant.level:
            found[name] = {**found[variant.like], "own": False}
            continue
        found[name] = {**play(true, module, options_of(module, true, name)), "own": True}
    possible = plan_of(true)["possible"]
    return {"plan_possible": possible, "true": true._asdict(), "variants": found}


def harmless(run: dict) -> bool:
    """Return whether a run inserted at the first try, within what contacts bear."""
    return run["outcome"] == "inserted" and run["tried"] == 1 and run["most_load"] <= MOST_LOAD


def needless(run: dict, without: dict) -> bool:
    """Return whether a run was stopped by an alarm where the one without alarms did no harm."""
    by_alarm = any(not why.startswith(OTHER_STOPS) for _, _, why in run["stops"])
    return by_alarm and harmless(without)


def slower(found: list[dict], name: str) -> float | None:
    """Return the time of a variant over that of the plain one, where both do no harm; median."""
    pairs = [(each["variants"][name], each["variants"]["plain"]) for each in found]
    ratios = [a["time"] / b["time"] for a, b in pairs if harmless(a) and harmless(b)]
    return float(np.median(ratios)) if ratios else None


def row(name: str, found: list[dict]) -> tuple:
    """Return a line of the table."""
    runs = [each["variants"][name] for each in found]
    without = [each["variants"][VARIANTS[name].like] for each in found]
    n = len(runs)
    ended = [run["outcome"] == "inserted" for run in runs]
    safe = [harmless(each) for each in without]
    loads, ratio = spread(run["most_load"] for run in runs), slower(found, name)
    return (
        VARIANTS[name].words, n,
        _share(sum(ok and run["tried"] == 1 for run, ok in zip(runs, ended)), n),
        _share(sum(ended), n),
        "-" if ratio is None else f"{ratio:.2f}",
        f"{loads['median']:.0f}, {loads['p95']:.0f}, {loads['max']:.0f}",
        _share(sum(run["most_load"] > MOST_LOAD for run in runs), n),
        _share(sum(bool(run["stops"]) for run in runs), n),
        _share(sum(needless(*both) for both in zip(runs, without)), sum(safe)),
    )  # fmt: skip


def _share(hits: int, count: int) -> str:
    found = share(hits, count)
    if not count:
        return "-"
    return f"{hits} of {count} ({100 * found['low']:.0f} to {100 * found['high']:.0f} %)"


def report(found, options) -> Report:
    """Return a row for each variant, and all runs as CSV."""
    figures = [each for _, each in found]
    rows = [row(name, figures) for name in VARIANTS]
    runs = [[
        "try", "variant", "friction", "clearance_um", "outcome", "tried", "time_s", "most_load_N",
        "errors", "stops",
    ]]  # fmt: skip
    for member, each in found:
        for name, run in each["variants"].items():
            stops = "; ".join(f"{t:.2f} s {stage}: {why}" for t, stage, why in run["stops"])
            runs.append([
                str(member), name, f"{each['true']['friction']:.3f}",
                f"{each['true']['clearance'] * 1e6:.0f}", run["outcome"], run["tried"],
                f"{run['time']:.2f}", f"{run['most_load']:.0f}", len(run["errors"]), stops,
            ])  # fmt: skip
    possible = sum(each["plan_possible"] for each in figures)
    cpu = np.median([run["cpu"] for e in figures for run in e["variants"].values() if run["own"]])
    text = (
        f"{table(HEAD, rows)}\n\nShares have 95 % intervals (Wilson). A plan was possible in "
        f"{possible} of {len(figures)}. A run takes {cpu:.0f} s of a core (median)."
    )
    return Report(f"{text} {_covered(figures)}", {"runs": runs})


def _covered(figures: list[dict]) -> str:
    """Return how often 95 % bounds contained the truth in first tries."""
    texts = []
    for words, planned in (("that turn by the plan", True), ("that close without a turn", False)):
        sums: dict[str, list[int]] = {}
        for each in figures:
            for name, run in each["variants"].items():
                if run["own"] and VARIANTS[name].planned == planned:
                    for quantity, counts in run["covered"].items():
                        sums.setdefault(quantity, []).append(counts)
        shares = ", ".join(
            f"{name} {100 * sum(a for a, _ in counts) / max(sum(b for _, b in counts), 1):.0f} %"
            for name, counts in sums.items()
        )
        texts.append(f"in runs {words} {shares}")
    return f"In contact, 95 % bounds contain the truth {'; '.join(texts)}."


FAMILY = Family(
    members, score_member, report, tries_option,
    sources=(
        drawn, variants, arms, sensing, HERE / "lockstep.py",
        HERE.parent / "robot_cells" / "cell.py",
        HERE.parents[1] / "examples" / "insert.py",
    ),
)  # fmt: skip
