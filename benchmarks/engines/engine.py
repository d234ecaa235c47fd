"""
Another engine's reactions against the estimate's, over traces with one setting for all.

`data/mujoco_traces.npz` holds four motions that MuJoCo 4.0.0 simulated, by a simulation that
shares nothing with this package, nor with `mujoco_peg.py`: a rim of 1440 boxes, a peg of 48 mm
and 1 kg in a hole of 50 mm, f = 0.2. In `held` runs a holder on springs closes the tilt at
0.16 rad/s, without slip and with 2 rad/s about the peg's axis, and a sensor stands between both;
in `driven` runs gravity closes it, and a servo turns the peg. Rows are 1 ms apart: orientation at
their end, and means over them of the sensor's wrench (peg axes, 70 mm above the lower end), of the
normal forces at K, B1, B2, and of friction over normal force. Integers, as differences from row
to row, in UNITS.

Sensors add white noise of what the configuration states. Compared is after 0.3 s, with the mean
reaction over the interval of the wrench; and as long as all contacts slide: the engine lets a
contact that sticks creep, and what friction it then carries is its own.

Beside it stands the Cramér-Rao bound along each trace: how near any estimator can come with such
sensors, told what the filter is told. It is one of tangents, and counts where it means something.
"""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
from scipy.signal import savgol_filter

from benchmarks.grid import score as grid_score
from benchmarks.grid.score import bound_along
from benchmarks.harness.errors import coverage, rms
from benchmarks.harness.exact import exactly
from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.player import record_of
from benchmarks.harness.tables import table, three
from peg_on_hole_ros.config.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.sim.measure import START_NS, measure
from peg_on_hole_ros.study.bound import Meaning

TRACES = Path(__file__).parent / "data" / "mujoco_traces.npz"
UNITS = {"q": 1e-8, "wrench": np.repeat([1e-3, 1e-5], 3), "normal": 1e-3, "friction": 1e-4}
AFTER_NS = 300_000_000
# A contact whose friction is below this share of f times its normal force sticks.
SLIDES = 0.98
# Rows over which friction is looked at, so that a facet of the rim is no stick.
AROUND = 21
# Rows over which angles are parabolas, for the rates that the bound is taken at.
RATES_OVER = 9
# Of the friction that the bound is taken with [m/s].
BOUND_SCALE = 2e-5
FIRST_SEED = 3000
HEAD = (
    "motion", "mean of N_K, N_B1, N_B2 [N]", "error: RMS over the mean",
    "bound over the mean; error over the bound", "coverage of 95 % bounds", "determined",
    "without noise: error; coverage",
)  # fmt: skip


def names() -> list[str]:
    """Return the traces that there are."""
    with np.load(TRACES) as stored:
        return [name[2:] for name in stored.files if name.startswith("q_")]


def trace(name: str):
    """
    Return a trace as a truth that `measure` takes.

    Returns
    -------
    SimpleNamespace
        plan; t_ns (n,); q (n, 3) [rad]; wrench (n, 6) at the sensor [N], [N m]; normal (n, 3) [N];
        slides: rows before a contact sticks.

    """
    with np.load(TRACES) as stored:
        D, d, H, mass, f, g = stored[f"scene_{name}"].tolist()
        rows = {
            kind: np.cumsum(stored[f"{kind}_{name}"], axis=0) * unit
            for kind, unit in UNITS.items()
        }
    scene = Scene(D, d, H, mass, f, gravity=(0.0, 0.0, -g))
    configuration = Configuration(scene=scene, wrench=WrenchInput(sensor_xyz=(0.0, 0.0, H)))
    plan = SimpleNamespace(
        configuration=configuration, seed=0, wrench_rate=1000, joint_rate=500,
        slip_velocity_scale=BOUND_SCALE,
    )  # fmt: skip
    return SimpleNamespace(
        plan=plan,
        t_ns=np.arange(len(rows["q"])) * 1_000_000,
        q=rows["q"],
        wrench=rows["wrench"],
        normal=rows["normal"],
        slides=_slides(rows["friction"] > SLIDES * f),
    )


def _slides(slid):
    """Return the rows before a contact is stuck in most of AROUND rows, after AFTER_NS."""
    share = np.array([np.convolve(row, np.ones(AROUND) / AROUND, "same") for row in slid.T])
    stuck = np.flatnonzero((share < 0.5).any(axis=0))
    stuck = stuck[(stuck > AFTER_NS // 1_000_000) & (stuck < len(slid) - AROUND)]
    return int(stuck[0]) if stuck.size else len(slid)


def least_stddev(truth):
    """
    Return how well any estimator can know the reactions that are compared.

    Returns
    -------
    stddev : ndarray, shape (n, 3)
        [N].
    sound : ndarray of bool, shape (n,)
        Where it means something.

    """
    configuration = truth.plan.configuration
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    rates = savgol_filter(truth.q, RATES_OVER, 2, deriv=1, delta=1e-3, axis=0)
    wrench = reduction.sign * truth.wrench @ reduction.matrix.T
    bound = bound_along(truth.plan, truth.t_ns, np.hstack([truth.q, rates]), wrench)
    stddev = np.sqrt(np.diagonal(bound.reactions, axis1=1, axis2=2))
    return stddev, bound.meaning == Meaning.SOUND


def residuals(truth, seeds, noise=True):
    """
    Return reactions' errors and stated deviations [N], true reactions, what is determined, rows.

    The first three are (n, 3), of all samples; the others (n,) say which of them the estimate
    declares determined, and which row of the trace each is.

    Parameters
    ----------
    truth : SimpleNamespace
        From `trace`.
    seeds : iterable of int
        Of the sensors' noise.
    noise : bool
        False: the traces as they are.

    """
    plan = truth.plan
    if not noise:
        quiet = Configuration(
            scene=plan.configuration.scene,
            wrench=WrenchInput(force_stddev=0.0, torque_stddev=0.0),
            joints=JointInput(position_stddev=0.0),
        )
        plan = SimpleNamespace(**{**vars(plan), "configuration": quiet})
    measured = SimpleNamespace(plan=plan, t_ns=truth.t_ns, q=truth.q)
    found = []
    for seed in seeds:
        samples = measure(measured, seed, exact=truth.wrench)
        record = record_of(Pipeline(exactly(truth.plan.configuration)), samples)
        rows = (record.t_ns - START_NS) // 1_000_000
        told = (record.t_ns - START_NS >= AFTER_NS) & (rows < truth.slides)
        rows, normal = rows[told], truth.normal[rows[told]]
        stddev = record.normal_stddev[told]
        found.append((record.normal[told] - normal, stddev, normal, record.determined[told], rows))
    return tuple(np.concatenate(part) for part in zip(*found, strict=True))


def score(name, seeds, noise=True) -> dict[str, np.ndarray]:
    """
    Return the figures of a trace, shape (3,) each, of the samples that are declared determined.

    relative (rms error over mean reaction), coverage of 95 % bounds, stated deviation over mean
    reaction, mean [N]; and determined, the share of such samples. With noise also what the bound
    means something for, declared determined or not: over_bound, the rms error there over the
    bound's, bound over mean reaction, and sound, the share of these samples.
    """
    truth = trace(name)
    error, stddev, normal, declared, rows = residuals(truth, seeds, noise)
    figures = {}
    if noise:
        least, sound = least_stddev(truth)
        told = sound[rows]
        bound = rms(least[rows[told]])
        figures = {
            "bound": bound / normal[told].mean(axis=0),
            "over_bound": rms(error[told]) / bound,
            "sound": told.mean(),
        }
    error, stddev, mean = error[declared], stddev[declared], normal[declared].mean(axis=0)
    found = coverage(error, stddev)
    return figures | {
        "relative": found.rms / mean,
        "coverage": found.covered,
        "stated": stddev.mean(axis=0) / mean,
        "mean": mean,
        "determined": declared.mean(),
    }


def row(name, noisy, exact) -> tuple:
    """Return the table's row of a trace, by its figures with noise and without."""
    over = "" if noisy["sound"] > 0.995 else f" (in {noisy['sound']:.0%})".replace("%", " %")

    def percents(of, name, digits):
        return f"{three([100 * x for x in of[name]], digits)} %"

    return (
        f"`{name}`",
        three(noisy["mean"], 0),
        percents(noisy, "relative", 1),
        f"{percents(noisy, 'bound', 1)}; {three(noisy['over_bound'], 1)}{over}",
        percents(noisy, "coverage", 0),
        f"{100 * noisy['determined']:.0f} %",
        f"{percents(exact, 'relative', 1)}; {percents(exact, 'coverage', 0)}",
    )


def members(options) -> list[Member]:
    """Return the traces, with noise and without."""
    return [
        member
        for name in names()
        for member in (Member(name, name, options.seeds), Member(f"{name}_exact", name))
    ]


def score_member(trace: Member, folder: Path) -> dict:
    """Return the figures of a trace as a plain tree."""
    seeds = range(FIRST_SEED, FIRST_SEED + max(trace.seeds, 1))
    found = score(trace.of, seeds, noise=trace.seeds > 0)
    return {name: np.asarray(value).tolist() for name, value in found.items()}


def report(found, options) -> Report:
    """Return a row for each trace that has both."""
    of = {(trace.of, trace.seeds > 0): figures for trace, figures in found}
    both = [name for name in names() if {(name, True), (name, False)} <= of.keys()]
    return Report(table(HEAD, [row(name, of[name, True], of[name, False]) for name in both]))


FAMILY = Family(members, score_member, report, seeds=20, sources=(TRACES, grid_score))
