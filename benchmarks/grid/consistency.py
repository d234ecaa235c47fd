"""
How well the estimate keeps its promises: errors against stated covariance over noise seeds.

    python -m benchmarks.grid.consistency [--seeds 20] [--csv FILE] [SCENE ...]

Every scene is a configuration in config/; its truth is integrated once and measured anew for each
seed. Samples fall into classes: `steady` (three contacts in truth and estimate, all sliding,
reactions declared determined), `reversal` (a contact slower than 2 mm/s, 25 ms around) and
`singular` (reactions declared not determined). What is promised holds for `steady`; the figures of
the others are printed beside it, nothing is left out.
"""

import argparse
import csv
import sys
from pathlib import Path

import numpy as np

from peg_on_hole_ros.cli.simulation_file import read_plan
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.records import ANGLES, CONTACTS
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.sim.truth import integrate

ROOT = Path(__file__).parents[2]
SCENES = ("closing_without_slip", "closing_with_slip", "working_cycle")
CLASSES = ("steady", "reversal", "singular")
SLOW_SLIP = 2e-3
WINDOW_NS = 25_000_000
# The estimate starts from one orientation and no rates; what it says meanwhile is counted too.
TITLES = ("rms", "mean sd", "ratio", "95 %", "rel")
COLUMNS = (
    "scene", "class", "quantity", "samples", "rms", "mean_stddev", "ratio", "coverage95",
    "relative",
)  # fmt: skip
QUANTITIES = (*ANGLES, *(f"{name}_rate" for name in ANGLES), *(f"N_{name}" for name in CONTACTS))


def near_reversal(truth) -> np.ndarray:
    """Return for each sample whether a contact is slower than SLOW_SLIP within WINDOW_NS."""
    slow = (truth.slip_speed < SLOW_SLIP).any(axis=1) & (truth.mode == "three_point")
    marks = truth.t_ns[slow]
    if not marks.size:
        return np.zeros(len(truth.t_ns), bool)
    after = np.searchsorted(marks, truth.t_ns - WINDOW_NS)
    return (after < marks.size) & (
        marks[np.minimum(after, marks.size - 1)] <= truth.t_ns + WINDOW_NS
    )


def play(truth, seed):
    """Yield (row of the truth, outputs) of the pipeline over one measurement of a truth."""
    for outputs in Pipeline(truth.plan.configuration).play(measure(truth, seed)):
        yield int(np.searchsorted(truth.t_ns, outputs.t_ns - START_NS)), outputs


def residuals(truth, seeds):
    """
    Return what the estimate did on each sample of all seeds.

    Returns
    -------
    error, stddev : ndarray, shape (n, 9)
        Angles [rad], rates [rad/s], reactions [N].
    kind : ndarray of str, shape (n,)
        A member of CLASSES, or empty.
    true_normal : ndarray, shape (n, 3)
        [N]
    finite : bool
        No output held a NaN or an infinity.

    """
    reversal = near_reversal(truth)
    errors, stddevs, kinds, normals = [], [], [], []
    finite = True
    for seed in seeds:
        for row, outputs in play(truth, seed):
            angles = outputs.state[:3] - truth.q[row]
            angles[1:] -= 2 * np.pi * np.round(angles[1:] / (2 * np.pi))
            rates = outputs.state[3:] - truth.rates[row]
            spread = np.sqrt(np.diagonal(outputs.state_covariance))
            errors.append([*angles, *rates, *(outputs.normal - truth.normal[row])])
            stddevs.append([*spread, *outputs.normal_stddev])
            normals.append(truth.normal[row])
            finite &= bool(np.isfinite(errors[-1]).all() and np.isfinite(stddevs[-1]).all())
            three_point = truth.mode[row] == "three_point" and truth.known[row]
            if not three_point or outputs.contact_mode != "three_point":
                kinds.append("")
            elif not outputs.monitor["reactions_determined"]:
                kinds.append("singular")
            else:
                kinds.append("reversal" if reversal[row] else "steady")
    return np.array(errors), np.array(stddevs), np.array(kinds), np.array(normals), finite


def figures(error, stddev, true_normal):
    """
    Return the figures of one class.

    Returns
    -------
    dict of str to ndarray
        rms, mean_stddev, ratio (rms over mean_stddev), coverage95, shape (9,); relative, the
        reactions' rms over their mean, shape (3,); samples.

    """
    rms = np.sqrt((error**2).mean(axis=0))
    mean_stddev = stddev.mean(axis=0)
    return {
        "rms": rms,
        "mean_stddev": mean_stddev,
        "ratio": rms / mean_stddev,
        "coverage95": (np.abs(error) < 1.96 * stddev).mean(axis=0),
        "relative": rms[6:] / true_normal.mean(axis=0),
        "samples": len(error),
    }


def score(truth, seeds):
    """Return the figures of each class that occurs, and whether all outputs were finite."""
    error, stddev, kind, normal, finite = residuals(truth, seeds)
    found = {}
    for name in CLASSES:
        chosen = kind == name
        if chosen.any():
            found[name] = figures(error[chosen], stddev[chosen], normal[chosen])
    return found, finite


def main(arguments=None):
    """Print the table and write the numbers."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("scenes", nargs="*", default=SCENES, metavar="SCENE")
    parser.add_argument("--seeds", type=int, default=20, help="noise seeds a scene (20)")
    parser.add_argument("--csv", type=Path, help="write every figure here")
    options = parser.parse_args(arguments)
    rows = []
    for scene in options.scenes:
        truth = integrate(read_plan(ROOT / "config" / f"{scene}.yaml"))
        found, finite = score(truth, range(1000, 1000 + options.seeds))
        print(f"{scene}: {options.seeds} seeds, outputs {'finite' if finite else 'NOT FINITE'}")
        for kind, figure in found.items():
            print(f"  {kind}, {figure['samples'] / options.seeds:.0f} samples a seed")
            print("    {:10} {:>10} {:>10} {:>6} {:>6} {:>7}".format("", *TITLES))
            for i, name in enumerate(QUANTITIES):
                relative = figure["relative"][i - 6] if i >= 6 else float("nan")
                shown = f"{100 * relative:6.2f}%" if i >= 6 else ""
                values = [figure[k][i] for k in ("rms", "mean_stddev", "ratio", "coverage95")]
                numbers = "{:10.3g} {:10.3g} {:6.2f} {:6.3f}".format(*values)
                print(f"    {name:10} {numbers} {shown}")
                rows.append([scene, kind, name, figure["samples"], *values, relative])
            sys.stdout.flush()
    if options.csv:
        with options.csv.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(COLUMNS)
            writer.writerows(rows)


if __name__ == "__main__":
    main()
