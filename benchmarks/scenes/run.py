"""
Score transition, forecast, modes and alarms over insertion scenes with drawn parameters.

    python -m benchmarks.scenes.run [--runs 300] [--quick] [--mismatch] [--tuning]
        [--wrench-rate HZ] --out DIR

Labels come from the simulated motion and loads alone. Scenes of `--tuning` are for choosing
thresholds; those scored otherwise share no seed with them. Truths and figures are kept in DIR, so
that a run which was stopped goes on, and truths are not integrated again for another monitor.
"""

import argparse
import csv
import os
import shutil
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

from benchmarks.resumable import ESTIMATE, keep, kept, put_between, sources_key, work_through
from benchmarks.scenes import engine as scenes_engine
from benchmarks.scenes.draw import FAMILIES, Case, estimator_of, noise_seeds, plan_of
from benchmarks.scenes.labels import labels_of
from benchmarks.scenes.play import play, truth_of
from benchmarks.scenes.score import score_run
from benchmarks.scenes.summary import summary
from benchmarks.scenes.table import by_family, tables

HERE = Path(__file__).parent
OWN = [
    f"{name}.py" for name in ("setting", "families", "draw", "labels", "play", "score", "engine")
]
# What the estimator is told; the second try is that of a mismatch which has been through one.
VARIANTS = ("matched", "mismatch", "second_try")
MARKS = "<!-- summary -->", "<!-- end of summary -->"
QUICK_RUNS = 2 * len(FAMILIES)


@cache
def figures_key() -> str:
    """Return a name for the state of everything that the figures come from."""
    return sources_key(ESTIMATE, [*(HERE / name for name in OWN), scenes_engine.TRACES])


def cases(runs: int, of: str = "scoring") -> list[Case]:
    """Return so many scenes, of all families in turn."""
    return [Case(FAMILIES[i % len(FAMILIES)], i // len(FAMILIES), of) for i in range(runs)]


def at_rate(plan, rate: int | None):
    """Return a plan with wrenches at a rate [Hz], orientations at no more; None: as it is."""
    if rate is None:
        return plan
    # Each orientation comes with a wrench.
    return replace(plan, wrench_rate=rate, joint_rate=rate // -(-rate // plan.joint_rate))


def file_of(folder: Path, case: Case, variant: str, rate: int | None = None) -> Path:
    """Return where a run's figures are kept."""
    at = "" if rate is None else f"_{rate}hz"
    return folder / "runs" / f"{case}_{variant}{at}.json"


def score_case(task):
    """Compute and keep the figures of one scene; returns its name and how its truth ended."""
    case, variants, folder, key, rate = task
    plan = at_rate(plan_of(case), rate)
    truth, why = truth_of(plan, folder / "truths")
    for variant in variants:
        tree = {"key": key, "variant": variant, **case._asdict(), "end": why}
        if truth is not None:
            configuration = estimator_of(case, plan, variant != "matched")
            tries = 2 if variant == "second_try" else 1
            record = play(truth, configuration, noise_seeds(case, tries))
            tree |= {"end": truth.ended_by, **score_run(labels_of(truth), record)}
        keep(file_of(folder, case, variant, rate), tree)
    return str(case), why or truth.ended_by


def run(
    chosen, variants, folder: Path, workers=1, report=print, rate=None
) -> dict[str, list[dict]]:
    """
    Compute what is missing of the runs and return all, {variant: runs}.

    Scenes that could not be begun are told and left out. A rate [Hz] of the wrench: `at_rate`.

    """
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    key = figures_key()
    tasks, asked = [], {"key": key}
    for case in chosen:
        missing = [v for v in variants if kept(file_of(folder, case, v, rate), asked) is None]
        if missing:
            tasks.append((case, missing, folder, key, rate))
    report(f"{len(chosen)} scenes, {' and '.join(variants)}: {len(tasks)} to compute")
    work_through(score_case, tasks, workers, report)
    found = {v: [kept(file_of(folder, c, v, rate), asked) for c in chosen] for v in variants}
    begun = {v: [r for r in runs if "duration" in r] for v, runs in found.items()}
    for r in found[variants[0]]:
        if "duration" not in r:
            report(f"  left out: {r['family']} {r['number']}: {r['end']}")
    return begun


def score_engine(task):
    """Compute and keep the figures of one scene of another engine; returns its name and end."""
    number, variants, folder, key = task
    for variant in variants:
        tree = {"key": key, **scenes_engine.score(number, variant)}
        keep(engine_file(folder, number, variant), tree)
    return f"mujoco_{number:03d}", "end"


def engine_file(folder: Path, number: int, variant: str) -> Path:
    """Return where a run's figures are kept."""
    return folder / "runs" / f"mujoco_{number:03d}_{variant}.json"


def run_engine(folder: Path, workers=1, report=print) -> dict[str, list[dict]]:
    """Compute what is missing of the other engine's scenes and return all, {variant: runs}."""
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    key, variants = figures_key(), scenes_engine.VARIANTS
    files = {v: [engine_file(folder, n, v) for n in scenes_engine.numbers()] for v in variants}
    tasks = [
        (n, variants, folder, key)
        for n, *paths in zip(scenes_engine.numbers(), *files.values(), strict=True)
        if any(kept(path, {"key": key}) is None for path in paths)
    ]
    work_through(score_engine, tasks, workers, report)
    return {v: [kept(path, {"key": key}) for path in paths] for v, paths in files.items()}


def flat_scores(variants):
    """Return the CSV's rows: a head, then one number a row with its interval and count."""
    rows = [["told", "family", "score", "value", "low", "high", "count"]]

    def walk(told, family, name, value):
        if isinstance(value, dict) and "hits" in value:
            numbers = [value[k] for k in ("value", "low", "high", "count")]
            rows.append([told, family, name, *numbers])
        elif isinstance(value, dict):
            for key, part in value.items():
                walk(told, family, f"{name}.{key}" if name else key, part)
        elif not isinstance(value, list):
            rows.append([told, family, name, value, "", "", ""])

    for told, runs in variants.items():
        for family, scores in by_family(runs).items():
            walk(told, family, "", scores)
    return rows


def flat_runs(variants):
    """Return the CSV's rows: a head, then one run a row."""
    head = ["told", "family", "number", "end", "duration", "events", "transition", "flag_error"]
    head += ["flag_missed", "flag_false", "forecast_z"]
    head += [
        f"{a}_{x}" for a in ("jamming", "contact_loss", "overload") for x in ("false", "leads")
    ]
    rows = [head]
    for told, runs in variants.items():
        for r in runs:
            flag, forecast = r["transition"], r["forecast"] or {}
            events = " ".join(f"{cause}@{begin:.3f}" for cause, begin, *_ in r["events"])
            row = [told, r["family"], r["number"], r["end"], r["duration"], events]
            row += [flag["true"], flag["error"], int(flag["missed"]), flag["false"]]
            row.append(forecast.get("z"))
            for alarm in ("jamming", "contact_loss", "overload"):
                judged = r["alarms"][alarm]["error"]
                leads = ("-" if x is None else f"{x:.3f}" for _, x, _ in judged["events"])
                row += [judged["false"], " ".join(leads)]
            rows.append([f"{v:.6g}" if isinstance(v, float) else v for v in row])
    return rows


def renew(page: Path, short: str, pictures: list[Path]) -> None:
    """Put the summary between a page's marks in place of what is there, pictures into figures."""
    put_between(page, *MARKS, short)
    (page.parent / "figures").mkdir(exist_ok=True)
    for path in pictures:
        if path.suffix == ".png":
            shutil.copyfile(path, page.parent / "figures" / f"scenes_{path.name}")


def main(arguments=None):
    """Run the scenes, write figures, tables and pictures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--runs", type=int, help="scenes (300; quick: 18)")
    parser.add_argument("--quick", action="store_true", help="two scenes of each family")
    parser.add_argument("--mismatch", action="store_true", help="wrong friction, clearance too")
    parser.add_argument("--tuning", action="store_true", help="scenes for choosing thresholds")
    parser.add_argument("--wrench-rate", type=int, metavar="HZ", help="slower than 1 kHz")
    parser.add_argument("--out", type=Path, required=True, help="figures, tables, pictures")
    parser.add_argument("--page", type=Path, help="renew summary, pictures of docs/scenes.md")
    parser.add_argument("--workers", type=int, default=min(2, os.cpu_count() or 1))
    options = parser.parse_args(arguments)
    count = QUICK_RUNS if options.quick else 300
    count = count if options.runs is None else options.runs
    if count < 1:
        parser.error("--runs is at least 1")
    chosen = cases(count, "tuning" if options.tuning else "scoring")
    variants = VARIANTS if options.mismatch else VARIANTS[:1]
    rate = options.wrench_rate
    if rate is not None and not 50 <= rate <= 1000:
        parser.error(f"--wrench-rate = {rate} Hz is not within 50 to 1000 Hz")
    if rate is not None and options.page:
        parser.error("--page is for the scenes as they are: leave out --wrench-rate")
    found = run(chosen, variants, options.out, options.workers, _say, rate)
    drawn = dict(found)
    if options.mismatch and rate is None:
        found |= run_engine(options.out, options.workers, _say)
    for name, rows in (("scores", flat_scores(found)), ("runs", flat_runs(found))):
        with (options.out / f"{name}.csv").open("w", newline="") as file:
            csv.writer(file).writerows(rows)
    short, text = summary(found), tables(found)
    (options.out / "scenes.md").write_text(f"{short}\n\n{text}\n")
    print(short)
    print(text)
    from benchmarks.scenes.plot import draw

    families = {name: by_family(runs) for name, runs in drawn.items()}
    pictures = draw(families, drawn, options.out)
    if options.page:
        renew(options.page, short, pictures)
    for path in pictures:
        _say(f"written: {path}")


def _say(text):
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
