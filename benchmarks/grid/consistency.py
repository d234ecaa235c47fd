"""
How well the estimate keeps its promises in the shipped scenes: errors against stated covariance.

Every scene is a configuration in config/; its truth is integrated once and measured anew for each
seed. Samples fall into classes: `steady` (three contacts in truth and estimate, all sliding,
reactions declared determined), `reversal` (a contact slower than 2 mm/s, 25 ms around) and
`singular` (reactions declared not determined). What is promised holds for `steady`; the figures of
the others are printed beside it, nothing is left out.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.harness.errors import QUANTITIES, REACTIONS, inside, near_reversal, rms, runs_of
from benchmarks.harness.exact import exactly
from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.player import record_of
from benchmarks.harness.tables import percent, table
from peg_on_hole_ros.cli.simulation_file import read_plan
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.sim.truth import integrate

ROOT = Path(__file__).parents[2]
SCENES = ("closing_without_slip", "closing_with_slip", "working_cycle")
CLASSES = ("steady", "reversal", "singular")
FIRST_SEED = 1000
COLUMNS = (
    "scene", "class", "quantity", "samples", "rms", "mean_stddev", "ratio", "coverage95",
    "relative",
)  # fmt: skip


class Residuals(NamedTuple):
    """
    What the estimate did on each sample of all seeds that has an output.

    Attributes
    ----------
    error, stddev : ndarray, shape (n, 9)
        Angles [rad], rates [rad/s], reactions [N].
    kind : ndarray of str, shape (n,)
        A member of CLASSES, or empty.
    true_normal : ndarray, shape (n, 3)
        [N]
    finite : bool
        No output held a NaN or an infinity.

    """

    error: np.ndarray
    stddev: np.ndarray
    kind: np.ndarray
    true_normal: np.ndarray
    finite: bool


def residuals(truth, seeds) -> Residuals:
    """Return what the estimate did, measured with each of the seeds."""
    # What is stated is not drawn: the scenes are played as they are shipped.
    told = exactly(truth.plan.configuration)
    records = [record_of(Pipeline(told), measure(truth, s)) for s in seeds]
    runs = runs_of(truth, records)
    three_point = (truth.mode == "three_point") & truth.known
    kind = np.where(near_reversal(truth), "reversal", "steady")
    kinds = np.where(runs.determined, kind, "singular")
    kinds[~(runs.contact & three_point)] = ""
    told = runs.mode != ""
    error, stddev = runs.error[told], runs.stddev[told]
    normal = np.broadcast_to(truth.normal, (*told.shape, 3))[told]
    finite = bool(np.isfinite(error).all() and np.isfinite(stddev).all())
    return Residuals(error, stddev, kinds[told], normal, finite)


def figures(error, stddev, true_normal) -> dict:
    """
    Return the figures of one class.

    Returns
    -------
    dict of str to ndarray
        rms, mean_stddev, ratio (rms over mean_stddev), coverage95, shape (9,); relative, the
        reactions' rms over their mean, shape (3,); samples.

    """
    off, mean_stddev = rms(error), stddev.mean(axis=0)
    return {
        "rms": off,
        "mean_stddev": mean_stddev,
        "ratio": off / mean_stddev,
        "coverage95": inside(error, stddev).mean(axis=0),
        "relative": off[REACTIONS] / true_normal.mean(axis=0),
        "samples": len(error),
    }


def score(truth, seeds) -> tuple[dict[str, dict], bool]:
    """Return the figures of each class that occurs, and whether all outputs were finite."""
    found = residuals(truth, seeds)
    of = {}
    for name in CLASSES:
        chosen = found.kind == name
        if chosen.any():
            of[name] = figures(
                found.error[chosen], found.stddev[chosen], found.true_normal[chosen]
            )
    return of, found.finite


def score_member(scene: Member, folder: Path) -> dict:
    """Return the figures of a scene as a plain tree."""
    truth = integrate(read_plan(ROOT / "config" / f"{scene.name}.yaml"))
    found, finite = score(truth, range(FIRST_SEED, FIRST_SEED + scene.seeds))
    classes = {
        kind: {name: np.asarray(value).tolist() for name, value in of.items()}
        for kind, of in found.items()
    }
    return {"finite": finite, "classes": classes}


def report(found, options) -> Report:
    """Return a table of each scene and class."""
    lines, flat = [], [COLUMNS]
    for scene, tree in found:
        finite = "finite" if tree["finite"] else "NOT FINITE"
        lines += [f"{scene}: {scene.seeds} seeds, outputs {finite}", ""]
        for kind, of in tree["classes"].items():
            rows = []
            for i, name in enumerate(QUANTITIES):
                relative = of["relative"][i - 6] if i >= 6 else None
                values = [of[k][i] for k in ("rms", "mean_stddev", "ratio", "coverage95")]
                shown = "{:.3g} {:.3g} {:.2f} {:.3f}".format(*values).split()
                rows.append((name, *shown, percent(relative, 2)))
                flat.append([scene, kind, name, of["samples"], *values, relative])
            title = f"{kind}, {of['samples'] / scene.seeds:.0f} samples a seed"
            lines += [table((title, "rms", "mean sd", "ratio", "95 %", "rel"), rows), ""]
    return Report("\n".join(lines).rstrip(), {"consistency": flat})


FAMILY = Family(
    lambda options: [Member(name, name, options.seeds) for name in SCENES],
    score_member, report, seeds=20,
)  # fmt: skip
