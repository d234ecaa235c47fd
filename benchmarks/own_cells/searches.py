"""
Drawn cells of one's own that search on the plate before they insert, rightly set.

The peg hangs still, for the automatic tare, comes down 5 to 8 mm beside the hole, slides over the
plate under 8 to 20 N to 2 mm, lifts off, and goes through the cycle of `own_cells`: it touches
down, slides on three contacts, goes through the transition and in. Asked: what the mode is while
the plate carries, whether anything is named as wrong, whether an alarm of level ERROR comes of
the search, and whether what follows is covered as it is without a search.
"""

from argparse import Namespace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.harness.family import ESTIMATE, Family, Member, Report
from benchmarks.harness.tables import percent, table
from benchmarks.own_cells import arms, cells, search
from benchmarks.own_cells.cells import EVERY, Cell, drawn_cell, write, write_parameters
from benchmarks.own_cells.own_cells import said_of
from benchmarks.own_cells.search import PLATE, with_search
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.truth import TWO_POINT
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.messages.columns import OutputColumns
from peg_on_hole_ros.monitor.alarm_text import ALARM_NAMES
from peg_on_hole_ros.monitor.states import AlarmLevel, Mode
from peg_on_hole_ros.replay.run import replay_bag
from peg_on_hole_ros.robot.described import described
from peg_on_hole_ros.sim.measure import START_NS

FIRST, CELLS = 40, 60
# What may be told while the plate carries.
RIGHT = (Mode.ELSEWHERE, Mode.UNKNOWN)
# A push is there after 50 ms, and a mode is declared 50 ms later.
BEGINS_NS = 100_000_000
HEAD = (
    "cell", "elsewhere or unknown", "elsewhere", "two_point", "three_point", "causes",
    "ERROR in the search", "covered", "without search", "flag off [ms]",
)  # fmt: skip


class Told(NamedTuple):
    """What was told of each wrench: stamp, mode, transition, and whether an alarm was ERROR."""

    t_ns: np.ndarray
    mode: np.ndarray
    flag: np.ndarray
    error: np.ndarray


class _Modes:
    """Collects what a replay tells."""

    def __init__(self) -> None:
        self.parts: list[Told] = []

    def take(self, columns: OutputColumns) -> None:
        """Take outputs of stamps that rise."""
        level = columns["alarms"]["level"].reshape(len(columns), len(ALARM_NAMES))
        error = (level == AlarmLevel.ERROR).any(axis=1)
        mode, flag = columns["contact_mode"].copy(), columns["transition"].copy()
        self.parts.append(Told(columns.t_ns.copy(), mode, flag, error))

    def told(self) -> Told:
        """Return all of it."""
        return Told(*(np.concatenate(each) for each in zip(*self.parts)))


def after_search(cell: Cell) -> Cell:
    """Return the cell without its search."""
    first = int((cell.truth.phase == search.PHASE).sum())
    first += -first % EVERY
    return cell._replace(
        truth=search.rows_of(cell.truth, first),
        wrench=cell.wrench[first:],
        joints=cell.joints[first // EVERY :],
    )


def score(member: Member, folder: Path) -> dict:
    """Return what came of one cell, with its search and without."""
    (number,) = member.of
    place = folder / f"cell_{number}"
    place.mkdir(parents=True, exist_ok=True)
    cell = drawn_cell(number, place, partial(with_search, number=number))
    parameters = place / "right.yaml"
    write_parameters(parameters, cell)
    found = {}
    for name, of in (("search", cell), ("alone", after_search(cell))):
        bag = place / f"{name}.mcap"
        write(bag, of)
        said = said_of(bag, parameters)
        found |= {f"{name}_causes": said.causes, f"{name}_covered": said.covered}
        if of is cell:
            found |= _in_search(cell, _told(bag, parameters))
        bag.unlink()
    return found


def _told(bag: Path, parameters: Path) -> Told:
    configuration, _ = load(str(parameters))
    modes = _Modes()
    replay_bag(Bag(bag), described(configuration), 0.0, [modes])
    return modes.told()


def _in_search(cell: Cell, told: Told) -> dict:
    truth = cell.truth
    row = np.searchsorted(truth.t_ns, told.t_ns - START_NS)
    on_plate = np.flatnonzero(truth.mode == PLATE)
    begun = told.t_ns - START_NS >= truth.t_ns[on_plate[0]] + BEGINS_NS
    carries = begun & (truth.mode[row] == PLATE)
    mode = told.mode[carries]
    searching = truth.phase[row] == search.PHASE
    through = np.flatnonzero(truth.mode[row] == TWO_POINT)[0]
    flagged = told.t_ns[told.flag.astype(bool)]
    off = float(flagged[0] - told.t_ns[through]) * 1e-9 if len(flagged) else None
    shares = {each.name.lower(): float((mode == each).mean()) for each in Mode}
    return {
        "right": float(np.isin(mode, RIGHT).mean()),
        "modes": shares,
        "flag": off,
        "errors": int(told.error[searching].sum()),
    }


def members(options: Namespace) -> list[Member]:
    """Return the cells."""
    return [Member(str(n), (n,)) for n in range(options.first, options.first + options.cells)]


def report(found: list, options: Namespace) -> Report:
    """Return a row a cell, and what all of them have."""
    rows = []
    for member, it in found:
        flag = it["flag"]
        rows.append((
            member.of[0], percent(it["right"]),
            *(percent(it["modes"][name]) for name in ("elsewhere", "two_point", "three_point")),
            "; ".join(it["search_causes"]) or "none", it["errors"],
            *("none" if c is None else percent(c) for c in
              (it["search_covered"], it["alone_covered"])),
            "missed" if flag is None else f"{1e3 * flag:.0f}",
        ))  # fmt: skip
    all_ = [it for _, it in found]
    lines = [
        f"{len(all_)} cells: elsewhere or unknown in 95 % of the time on the plate in "
        f"{sum(it['right'] >= 0.95 for it in all_)}, ever two_point in "
        f"{sum(it['modes']['two_point'] > 0 for it in all_)}; something named in "
        f"{sum(bool(it['search_causes']) for it in all_)}, an ERROR of the search in "
        f"{sum(it['errors'] > 0 for it in all_)}."
    ]
    return Report("\n".join([*lines, "", table(HEAD, rows)]))


def add_options(parser) -> None:
    """Add which cells are drawn."""
    parser.add_argument("--cells", type=int, default=CELLS, help=f"how many ({CELLS})")
    parser.add_argument("--first", type=int, default=FIRST, help=f"number of the first ({FIRST})")


FAMILY = Family(
    members, score, report, add_options, sources=(arms, cells, search),
    parts=(*ESTIMATE, "cli", "replay", "robot", "messages", "bags"),
)  # fmt: skip
