"""
Drawn insertions of robot cells: three arms, two contacts, and what the estimate makes of each.

A cell is one of `bags/cell_*.mcap` (its arm, driver and configuration) with a hole elsewhere, a
friction of its own, another program and other noise. The engine is MuJoCo; `hard` contacts are
those of the shipped bags, whose loads rattle, `damped` ones do not. Truth is the engine's.
"""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.harness.draw import Draw
from benchmarks.harness.family import Family, Member, Report
from benchmarks.harness.tables import percent, table
from benchmarks.robot_cells import __main__ as bags
from benchmarks.robot_cells import sensing
from benchmarks.robot_cells.arms import ARMS, rotation
from benchmarks.robot_cells.rows import GAMMA0, D, Rows, d
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.score import Score
from peg_on_hole_ros.bags.truth import THREE_POINT, TWO_POINT, RecordedTruth, read_truth
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.mechanics.geometry import contact_geometry, velocity_jacobians
from peg_on_hole_ros.mechanics.reference import slip_directions
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.monitor.alarm_text import ALARM_NAMES
from peg_on_hole_ros.monitor.states import AlarmLevel
from peg_on_hole_ros.records import CONTACTS
from peg_on_hole_ros.replay.run import replay_bag


class Parts(NamedTuple):
    """Damping of a contact [N s/m], and which parts have a chamfer."""

    damping: float
    hole_chamfer: bool = False
    peg_chamfer: bool = False


# Those with chamfers have the same draws as `damped`, which is their sharp control.
PARTS = {
    "hard": Parts(6e3),
    "damped": Parts(2e3),
    "hole_chamfer": Parts(2e3, True, False),
    "peg_chamfer": Parts(2e3, False, True),
    "both_chamfers": Parts(2e3, True, True),
}
SEED = 62_000
# A sample slides if each contact of the peg is faster [m/s].
SLIDES = 2e-3
HEAD = (
    "arm", "contact", "number of insertions", "coverage of N_K, N_B1, N_B2",
    "coverage, lowest of a run", "RMS error of N_K, N_B1, N_B2 [N]", "determined while sliding",
    "coverage of gamma, lowest of a run", "error of the flag, median, largest [ms]",
    "share of the true mode, lowest of a run", "number of runs with an ERROR",
)  # fmt: skip
# Those that the engine's loads tell for sure; between contacts a peg bounces for milliseconds.
SURE_MODES = ("open", THREE_POINT, TWO_POINT)


class Cell(NamedTuple):
    """An arm, its contacts, and the number of the draw."""

    arm: str
    contact: str
    number: int

    @property
    def seed(self) -> list[int]:
        """Return what hole, friction, program and noise are drawn with."""
        sharp = 0 if self.contact == "hard" else 1
        return [SEED, list(ARMS).index(self.arm), sharp, self.number]


def drawn(cell: Cell) -> dict:
    """Return the fields of a `cell.Setting`; friction is within two deviations of the stated."""
    draw, parts = Draw(cell.seed), PARTS[cell.contact]
    setting = {
        "friction": draw.even(0.1, 0.3),
        "damping": parts.damping,
        "hole_xyz": (draw.even(0.47, 0.55), draw.even(-0.1, 0.12), draw.even(0.02, 0.1)),
        "hole_rpy": (draw.even(-0.1, 0.1), draw.even(-0.1, 0.1), draw.even(-0.6, 0.6)),
        "gamma": draw.even(0.2, 0.32),
        "psi": draw.even(-2.0, 2.0),
        "slip": draw.sign() * draw.even(0.5, 2.0),
        "press": (draw.even(0.001, 0.003), draw.even(0.002, 0.006)),
    }
    chamfers = {"hole_chamfer": draw.log(2e-4, 1e-3), "peg_chamfer": draw.log(2e-4, 1e-3)}
    return setting | {name: size for name, size in chamfers.items() if getattr(parts, name)}


def configuration_of(cell: Cell, setting: dict) -> Configuration:
    """
    Return what is stated of a cell: its file, and where its hole is.

    With chamfers that is where the plate's face is, and the peg's outermost end.
    """
    configuration, _ = load(f"config/cell_{cell.arm}.yaml")
    joints, scene = configuration.joints, configuration.scene
    above, below = setting.get("hole_chamfer", 0.0), setting.get("peg_chamfer", 0.0)
    axis = rotation(setting["hole_rpy"])[:, 2]
    x, y, z = joints.peg_xyz
    joints = replace(
        joints,
        hole_xyz=tuple((np.array(setting["hole_xyz"]) + above * axis).tolist()),
        hole_rpy=setting["hole_rpy"],
        peg_xyz=(x, y, z + below),
    )
    scene = replace(scene, hole_chamfer=above, peg_chamfer=below)
    return replace(configuration, joints=joints, scene=scene)


def rows_of(cell: Cell, setting: dict, folder: Path) -> Rows:
    """Return what the engine gives, kept in a folder."""
    path = folder / f"{cell.arm}_{cell.contact}_{cell.number}.npz"
    if path.exists():
        return Rows(**np.load(path))
    from benchmarks.robot_cells.cell import Setting, run

    rows = run(ARMS[cell.arm], bags.CELLS[cell.arm].period, setting=Setting(**setting))
    np.savez(path, **rows._asdict())
    return rows


class Recording(NamedTuple):
    """A cell's bag with its truth, what is stated of the cell, and what the engine gave."""

    path: Path
    configuration: Configuration
    rows: Rows


def recorded(cell: Cell, folder: Path, noise: int = 1, thin: int = 1) -> Recording:
    """Write what a cell's robot sends, with noise of a number, each so manieth message of it."""
    setting = drawn(cell)
    rows = rows_of(cell, setting, folder)
    configuration = configuration_of(cell, setting)
    path = folder / f"{cell.arm}_{cell.contact}_{cell.number}.mcap"
    seed = int(np.random.SeedSequence([*cell.seed, noise]).generate_state(1)[0])
    driver = replace(bags.CELLS[cell.arm].driver, seed=seed)
    bags.write(path, rows, cell.arm, configuration, driver, thin)
    return Recording(path, configuration, rows)


def score(cell: Cell, folder: Path) -> dict:
    """Return what a replay tells of a cell, against the engine."""
    path, configuration, rows = recorded(cell, folder)
    bag = Bag(path)
    truth = read_truth(bag)
    told, outputs = Score(truth), _Outputs(truth, rows)
    replay_bag(bag, configuration, 0.0, [told, outputs])
    path.unlink()
    coverage, rmse = told.coverage95(), told.rmse()
    return {
        "samples": int(told.count[3]),
        "covered": [coverage[name] for name in CONTACTS],
        "rmse": [rmse[name] for name in CONTACTS],
        "gamma": coverage["gamma"],
        "sliding": outputs.sliding,
        "determined": outputs.determined,
        "modes": {name: right / count for name, (right, count) in outputs.modes.items()},
        "flags_ms": [None if delay is None else 1e3 * delay for delay in told.flag_delays()],
        "errors": sorted(outputs.errors),
    }


class _Outputs:
    """
    What a replay told: alarms, and how many samples of three sliding contacts it determined.

    Attributes
    ----------
    sliding, determined : int
        Samples that slide, and those of them whose reactions are called determined.
    modes : dict of str to (int, int)
        Of SURE_MODES: samples in it that were told so, and all of them.
    errors : set of str
        Alarms that were ERROR.

    """

    def __init__(self, truth: RecordedTruth, rows: Rows) -> None:
        self._truth, self._t, self._speed = truth, rows.t, slip_speed(rows)
        self.sliding = self.determined = 0
        self.modes: dict[str, tuple[int, int]] = {}
        self.errors: set[str] = set()

    def take(self, columns: OutputColumns) -> None:
        """Take the outputs of stamps that rise."""
        t = (columns.t_ns - bags.START_NS) * 1e-9
        slides = np.interp(t, self._t, self._speed) > SLIDES
        modes = np.array([self._truth.mode_at(t_ns) for t_ns in columns.t_ns.tolist()])
        three, told = modes == THREE_POINT, np.array(columns.modes)
        for name in SURE_MODES:
            true = modes == name
            if true.any():
                right, count = self.modes.get(name, (0, 0))
                right += int((told[true] == name).sum())
                self.modes[name] = right, count + int(true.sum())
        self.sliding += int((slides & three).sum())
        self.determined += int((slides & three & columns.determined).sum())
        levels = columns["alarms"]["level"]
        worst = levels.max(axis=0).tolist()
        self.errors.update(
            name for name, level in zip(ALARM_NAMES, worst) if level == AlarmLevel.ERROR
        )


def slip_speed(rows: Rows) -> np.ndarray:
    """Return how fast the slowest of K, B1 and B2 slips [m/s], shape (n,); 0 below gamma0."""
    speeds, above = np.zeros(len(rows.t)), rows.q[:, 0] > GAMMA0
    geometry = contact_geometry(Scene(hole_diameter=D, peg_diameter=d), rows.q[above, 0])
    _, velocities = slip_directions(velocity_jacobians(geometry, d, D), rows.rates[above].T, 0.0)
    speeds[above] = np.linalg.norm(velocities, axis=1).min(axis=0)
    return speeds


def members(options) -> list[Member]:
    """Return the drawn cells of each arm and contact."""
    return [
        Member(f"{arm}_{contact}_{number:02d}", Cell(arm, contact, number))
        for number in range(options.cells)
        for arm in ARMS
        for contact in PARTS
    ]


def score_member(cell: Member, folder: Path) -> dict:
    """Return the figures of a cell."""
    return score(Cell(*cell.of), folder)


def row(arm: str, contact: str, found: list[dict]) -> tuple:
    """Return a row of the table: all samples of an arm's cells together."""
    samples = np.array([figures["samples"] for figures in found], float)
    known = samples > 0
    covered = np.array([figures["covered"] for figures in found], float)
    together = (covered[known] * samples[known, None]).sum(axis=0) / samples[known].sum()
    rmse = np.array([figures["rmse"] for figures in found], float)[known]
    rms = np.sqrt((rmse**2 * samples[known, None]).sum(axis=0) / samples[known].sum())
    determined, sliding = (
        sum(figures[name] for figures in found) for name in ("determined", "sliding")
    )
    flags = [flag for figures in found for flag in figures["flags_ms"]]
    came = np.abs([np.inf if flag is None else flag for flag in flags])
    return (
        arm, contact, len(found),
        ", ".join(percent(share) for share in together),
        percent(np.nanmin(covered[known])),
        ", ".join(f"{newtons:.1f}" for newtons in rms),
        percent(determined / sliding),
        percent(min(figures["gamma"] for figures in found)),
        f"{np.median(came):.0f}, {came.max():.0f}",
        percent(min(min(figures["modes"].values()) for figures in found)),
        sum(bool(figures["errors"]) for figures in found),
    )  # fmt: skip


def report(found, options) -> Report:
    """Return a row for each arm and contact."""
    of = {}
    for cell, figures in found:
        of.setdefault(cell.of[:2], []).append(figures)
    return Report(table(HEAD, [row(*name, figures) for name, figures in of.items()]))


def cells_option(parser) -> None:
    """Add how many cells are drawn."""
    parser.add_argument("--cells", type=int, default=20, help="of each arm and contact (20)")


FAMILY = Family(
    members, score_member, report, cells_option,
    sources=(bags, sensing, Path(__file__).with_name("cell.py")),
)  # fmt: skip
