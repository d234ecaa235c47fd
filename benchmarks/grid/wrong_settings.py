"""
Settings that are wrong: how soon that is told, and what is made of a wrong diameter or friction.

    python -m benchmarks.grid.wrong_settings [--part told slow diameter friction] [--seeds 4]

`told`: motions of the grid at 1 kHz and nominal noise, friction learnt and known. `slow`: pegs of
4 to 150 mm that close and turn, at 100 Hz to 1 kHz. Of each the first time at which
`innovations_too_large` counts, over noise seeds; the settings are off by 1 mm or 2 % of the
diameter, ten standard deviations of the force's noise (2 N) and 0.2 degrees. `diameter`: the peg's
is off by 2 and 10 um, `scene.clearance_stddev` says by how much; which share of the reactions that
are determined lies within 95 % bounds after 50 ms, of K, B1 and B2 the least, in four times as
many seeds. `friction`: stated a half and one and a half of what it is, within 0.05 or a quarter of
itself; how far off it then is, root mean square and, in stated deviations, at most, 0.3 s after
the start and at the end, in as many seeds, beside the posterior Cramer-Rao bound of who knows it
to a half, and that it stays what it is; and which share of the runs is within 5 % after 0.3 s, and
within 1 % at the end. A run that was stopped goes on.
"""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.grid.cells import Motion, truth_of, with_noise
from benchmarks.grid.pegs import closing
from benchmarks.grid.score import INTERVAL, REACTIONS, SETTLE_NS, bound_of, run_seeds
from benchmarks.resumable import ESTIMATE, figures_of, keep, parsed, sources_key
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.measurements.measurement import tilt_axes
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.sim.measure import START_NS, measure, measured_angles, sensor_wrench

FIRST_SEED = 700
SOURCES = ("wrong_settings.py", "cells.py", "score.py", "pegs.py")
TOLD = [
    Motion(2e-5, 0.2, 0.16, "slip"),
    Motion(1e-4, 0.2, 0.16, "slip"),
    Motion(2e-3, 0.2, 0.16, "slip"),
    Motion(5e-4, 0.2, 0.16, "reversals"),
    Motion(1e-4, 0.2, 0.16, "align"),
]
# Peg, rates of wrench and joint states [Hz].
SLOW = [
    *(("50 mm", rate, min(rate, 500)) for rate in (100, 250, 500, 1000)),
    *(("10 mm", rate, min(rate, 500)) for rate in (250, 1000)),
    *(("4 mm", rate, min(rate, 500)) for rate in (100, 1000)),
    *(("150 mm", rate, min(rate, 500)) for rate in (100, 250)),
]
DIAMETER = [
    *(Motion(c, 0.2, 0.16, "slip") for c in (2e-5, 1e-4, 5e-4, 2e-3)),
    *(Motion(c, 0.5, 0.16, "slip") for c in (2e-5, 1e-4, 5e-4, 2e-3)),
    *(Motion(c, 0.2, 0.16, "reversals") for c in (1e-4, 5e-4)),
    *(Motion(c, 0.05, 0.16, "align") for c in (1e-4, 5e-4)),
    *(Motion(c, 0.2, 0.16, "align") for c in (2e-5, 1e-4, 5e-4, 2e-3)),
    *(Motion(c, 0.5, 0.16, "align") for c in (1e-4, 5e-4, 2e-3)),
]
FRICTION = [
    *(Motion(c, 0.2, 0.16, "align") for c in (1e-4, 5e-4, 2e-3)),
    Motion(1e-4, 0.2, 1.0, "align"),
    Motion(1e-4, 0.2, 0.16, "slip"),
    Motion(5e-4, 0.2, 0.16, "reversals"),
    Motion(1e-4, 0.2, 0.01, "slip"),
    Motion(5e-4, 0.2, 0.01, "align"),
    *(Motion(c, 0.5, 0.16, "align") for c in (2e-5, 1e-4, 5e-4, 2e-3)),
    Motion(1e-4, 0.5, 1.0, "align"),
    Motion(1e-4, 0.5, 0.16, "slip"),
]
# Stated friction over the true one, and its standard deviation over that; None: LEARNT.
STATED, SHARES = (0.5, 1.5), (None, 0.25)
BOUND, WITHIN = "bound", "within 5 % after 0.3 s; 1 % at the end"
SOON = 0.3  # [s]
# As near as friction is to be SOON and at the end, as a share of the true one.
NEAR = np.array([0.05, 0.01])
# Told diameter less the true one [m].
OFF = (2e-6, -2e-6, 1e-5, -1e-5)
LEARNT = 0.05
TOLD_BY = "innovations_too_large"


def with_scene(truth, **values):
    """Return a truth of whose scene something else is told."""
    return _with_told(truth, scene=replace(truth.plan.configuration.scene, **values))


def with_filter(truth, **values):
    """Return a truth that is estimated with other settings."""
    return _with_told(truth, filter=replace(truth.plan.configuration.filter, **values))


def _with_told(truth, **sections):
    configuration = replace(truth.plan.configuration, **sections)
    return replace(truth, plan=replace(truth.plan, configuration=configuration))


def with_lever(configuration, axis):
    """Return a configuration whose sensor is 2 % of the diameter away from where it is."""
    at = np.array(configuration.wrench.sensor_xyz)
    at[axis] += 0.02 * configuration.scene.hole_diameter
    wrench = replace(configuration.wrench, sensor_xyz=tuple(at.tolist()))
    return replace(configuration, wrench=wrench)


def with_tare(sample, off):
    """Return a wrench whose force is off by so much [N]; others as they are."""
    if not isinstance(sample, WrenchSample):
        return sample
    return sample._replace(force=tuple((np.array(sample.force) + off).tolist()))


def tilted(sample, tilt):
    """Return a joint state in axes turned about x and y by a tilt [rad]; others as they are."""
    if not isinstance(sample, JointSample):
        return sample
    q = measured_angles(np.array([sample.position]), np.zeros((1, 3)), tilt_axes(tilt))[0]
    return sample._replace(position=tuple(q.tolist()))


def settings(right):
    """Return what may be wrong by name: the configuration, and what samples become."""
    force = 10 * right.wrench.force_stddev
    return {
        "nothing": (right, lambda sample: sample),
        "tare, across the peg": (right, partial(with_tare, off=np.array([force, 0.0, 0.0]))),
        "tare, along it": (right, partial(with_tare, off=np.array([0.0, 0.0, force]))),
        "lever arm, across": (with_lever(right, 0), lambda sample: sample),
        "lever arm, along": (with_lever(right, 2), lambda sample: sample),
        "hole leans": (right, partial(tilted, tilt=(0.0, np.radians(0.2)))),
    }


def first_told(truth, configuration, change, seeds):
    """Return of each seed when something is first told [s], or None."""
    exact, found = sensor_wrench(truth), []
    for seed in seeds:
        pipeline, told = Pipeline(configuration), None
        for sample in measure(truth, seed, exact=exact):
            pipeline.on_sample(change(sample))
            if pipeline.counts[TOLD_BY]:
                told = (sample.t_ns - START_NS) * 1e-9
                break
        found.append(told)
    return found


def told_in(truth, seeds):
    """Return `first_told` of every setting, friction learnt and known."""
    found = {}
    for stddev in (LEARNT, 0.0):
        right = with_scene(truth, friction_stddev=stddev).plan.configuration
        for name, (told, change) in settings(right).items():
            learnt = "learnt" if stddev else "known"
            found[f"{name}; friction {learnt}"] = first_told(truth, told, change, seeds)
    return found


def covered(truth, seeds):
    """Return the least share of reactions within their bounds, for each diameter in OFF."""
    scene, found = truth.plan.configuration.scene, []
    later = truth.t_ns >= SETTLE_NS
    for off in OFF:
        diameter = scene.peg_diameter + off
        if not diameter < scene.hole_diameter:
            found.append(None)
            continue
        told = with_scene(truth, peg_diameter=diameter, clearance_stddev=abs(off))
        runs = run_seeds(told, seeds, sensor_wrench(truth))
        chosen = later & runs.determined
        error, stddev = (a[..., REACTIONS][chosen] for a in (runs.error, runs.stddev))
        found.append(float((np.abs(error) <= INTERVAL * stddev).mean(axis=0).min()))
    return found


def sought(truth, seeds):
    """
    Return of each start and spread how far off friction is, SOON and at the end.

    Thrice two figures: the root mean square over seeds, as a share of the true one, the largest in
    stated deviations, and the share of the seeds within NEAR. Under BOUND two, see `best`.
    """
    right, exact = truth.plan.configuration.scene.friction, sensor_wrench(truth)
    found = {BOUND: best(truth)}
    for share in SHARES:
        stddev = LEARNT if share is None else share * right
        for start in STATED:
            told = with_scene(truth, friction=start * right, friction_stddev=stddev)
            off = []
            for seed in seeds:
                soon = last = None
                for outputs in Pipeline(told.plan.configuration).play(
                    measure(truth, seed, exact=exact)
                ):
                    last = outputs.monitor["friction"] - right, outputs.monitor["friction_stddev"]
                    if soon is None and (outputs.t_ns - START_NS) * 1e-9 >= SOON:
                        soon = last
                off.append((soon or last, last))
            error, stated = np.moveaxis(np.array(off), 2, 0)
            within = LEARNT if share is None else f"{share:g} of it"
            found[f"{start:g} of it, within {within}"] = [
                (np.sqrt((error**2).mean(axis=0)) / right).tolist(),
                np.abs(error / stated).max(axis=0).tolist(),
                (np.abs(error) <= NEAR * right).mean(axis=0).tolist(),
            ]
    return found


def best(truth):
    """Return the bound on friction's error, as a share of it, SOON and at the end."""
    right = truth.plan.configuration.scene.friction
    told = with_scene(truth, friction_stddev=max(abs(s - 1.0) for s in STATED) * right)
    told = with_filter(told, friction_noise=0.0)
    stddev = np.sqrt(bound_of(told).parameters[:, 0, 0]) / right
    soon = min(np.searchsorted(truth.t_ns, SOON * 1e9), len(stddev) - 1)
    return [float(stddev[soon]), float(stddev[-1])]


MEASURED = {"told": told_in, "slow": told_in, "diameter": covered, "friction": sought}


def compute(task):
    """Keep the figures of one case of a part; returns (name, "done")."""
    part, case, seeds, path, asked = task
    if part == "slow":
        truth = closing(*case, duration=0.9)
    else:
        truth = with_noise(truth_of(case)[0], "nominal", LEARNT)
    keep(path, asked | {"figures": MEASURED[part](truth, range(FIRST_SEED, FIRST_SEED + seeds))})
    return f"{part}: {named(case)}", "done"


def named(case):
    """Return a case as text."""
    return str(case) if isinstance(case, Motion) else f"{case[0]} at {case[1]} Hz"


def span(found):
    """Return as text from when to when seeds were told, and how many of them."""
    told = [one for one in found if one is not None]
    if not told:
        return "no"
    first, last = (f"{pick(told):.2f}" for pick in (min, max))
    times = first if first == last else f"{first} to {last}"
    return times if len(told) == len(found) else f"{times} ({len(told)} of {len(found)})"


def _error(head, figures):
    if head == BOUND:
        return "; ".join(f"{100 * error:.2g} %" for error in figures)
    return "; ".join(f"{100 * e:.2g} % ({d:.1f})" for e, d in zip(*figures[:2], strict=True))


def table(part, rows):
    """Return a part's figures as lines of a table."""
    if part == "diameter":
        heads = [f"{1e6 * off:+.0f} um" for off in OFF]
        cells = {
            name: ["" if share is None else f"{100 * share:.0f} %" for share in row]
            for name, row in rows.items()
        }
    elif part == "friction":
        heads = list(next(iter(rows.values())))
        cells = {name: [_error(head, row[head]) for head in heads] for name, row in rows.items()}
    elif part == WITHIN:
        heads = [head for head in next(iter(rows.values())) if head != BOUND]
        cells = {
            name: ["; ".join(f"{100 * share:.0f} %" for share in row[head][2]) for head in heads]
            for name, row in rows.items()
        }
    else:
        heads = list(next(iter(rows.values())))
        cells = {name: [span(row[head]) for head in heads] for name, row in rows.items()}
    lines = [f"| {part} | {' | '.join(heads)} |", "|---" * (len(heads) + 1) + "|"]
    return lines + [f"| {name} | {' | '.join(row)} |" for name, row in cells.items()]


def main(arguments=None):
    """Compute the parts asked for, print them as tables, keep the figures."""
    cases = {"told": TOLD, "slow": SLOW, "diameter": DIAMETER, "friction": FRICTION}
    options = parsed(__doc__, cases, 4, Path("out/wrong_settings"), arguments)
    key = sources_key(ESTIMATE, [Path(__file__).with_name(name) for name in SOURCES])
    tasks = []
    for part in options.part:
        seeds = options.seeds * (1 if part in ("told", "slow") else 4)
        for case in cases[part]:
            name = f"{part}_{named(case)}".replace(" ", "_").replace("/", "_")
            asked = {"key": key, "seeds": seeds}
            tasks.append((part, case, seeds, options.folder / f"{name}.json", asked))
    found = figures_of(compute, tasks, options.workers)
    for part in options.part:
        rows = {named(t[1]): row for t, row in zip(tasks, found, strict=True) if t[0] == part}
        print("\n".join(["", *table(part, rows)]))
        if part == "friction":
            print("\n".join(["", *table(WITHIN, rows)]))


if __name__ == "__main__":
    main()
