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
from benchmarks.own_cells import arms, beside, cells
from benchmarks.own_cells.beside import PHASE, PLATE, SEARCH, Beside, rows_of, with_contact
from benchmarks.own_cells.cells import EVERY, Cell, drawn_cell, write, write_parameters
from benchmarks.own_cells.own_cells import said_of
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
# What follows may be covered by so much less than without the contact beside the hole [-].
LESS = 0.05
HEAD = (
    "cell", "right mode beside the hole", "elsewhere", "two_point", "three_point", "causes",
    "ERROR in the search", "friction off after it [stddev]", "covered", "without search",
    "flag off [ms]",
)  # fmt: skip


class Told(NamedTuple):
    """
    What was published of each wrench.

    Attributes
    ----------
    t_ns, mode, flag : ndarray, shape (n,)
        Stamp, contact mode, transition.
    error : ndarray, shape (n,)
        Whether an alarm was ERROR.
    friction : ndarray, shape (n, 2)
        Friction, and its standard deviation [-].

    """

    t_ns: np.ndarray
    mode: np.ndarray
    flag: np.ndarray
    error: np.ndarray
    friction: np.ndarray


class _Modes:
    """Collects what a replay tells."""

    def __init__(self) -> None:
        self.parts: list[Told] = []

    def take(self, columns: OutputColumns) -> None:
        """Take outputs of stamps that rise."""
        level = columns["alarms"]["level"].reshape(len(columns), len(ALARM_NAMES))
        error = (level == AlarmLevel.ERROR).any(axis=1)
        mode, flag = columns["contact_mode"].copy(), columns["transition"].copy()
        friction = np.column_stack([columns["friction"], columns["friction_stddev"]])
        self.parts.append(Told(columns.t_ns.copy(), mode, flag, error, friction))

    def told(self) -> Told:
        """Return all of it."""
        return Told(*(np.concatenate(each) for each in zip(*self.parts)))


def after_search(cell: Cell) -> Cell:
    """Return the cell without its search."""
    first = int((cell.truth.phase == PHASE).sum())
    first += -first % EVERY
    return cell._replace(
        truth=rows_of(cell.truth, first),
        wrench=cell.wrench[first:],
        joints=cell.joints[first // EVERY :],
    )


def score(kind: Beside, member: Member, folder: Path) -> dict:
    """Return what came of one cell, with its contact beside the hole and without."""
    (number,) = member.of
    place = folder / f"cell_{number}"
    place.mkdir(parents=True, exist_ok=True)
    cell = drawn_cell(number, place, partial(with_contact, number=number, kind=kind))
    parameters = place / "right.yaml"
    write_parameters(parameters, cell)
    found = {}
    for name, of in (("search", cell), ("alone", after_search(cell))):
        bag = place / f"{name}.mcap"
        write(bag, of)
        said = said_of(bag, parameters)
        found |= {f"{name}_causes": said.causes, f"{name}_covered": said.covered}
        if of is cell:
            found |= _beside(cell, _told(bag, parameters), kind)
        bag.unlink()
    return found


def _told(bag: Path, parameters: Path) -> Told:
    configuration, _ = load(str(parameters))
    modes = _Modes()
    replay_bag(Bag(bag), described(configuration), 0.0, [modes])
    return modes.told()


def _beside(cell: Cell, told: Told, kind: Beside) -> dict:
    truth, scene = cell.truth, cell.truth.plan.configuration.scene
    row = np.searchsorted(truth.t_ns, told.t_ns - START_NS)
    on_plate = np.flatnonzero(truth.mode == PLATE)
    begun = told.t_ns - START_NS >= truth.t_ns[on_plate[0]] + kind.settles * 1e9
    carries = begun & (truth.mode[row] == PLATE)
    mode = told.mode[carries]
    searching = truth.phase[row] == PHASE
    through = np.flatnonzero(truth.mode[row] == TWO_POINT)[0]
    flagged = told.t_ns[told.flag.astype(bool)]
    off = float(flagged[0] - told.t_ns[through]) * 1e-9 if len(flagged) else None
    shares = {each.name.lower(): float((mode == each).mean()) for each in Mode}
    after = told.friction[np.flatnonzero(searching)[-1]]
    return {
        "right": float(np.isin(mode, kind.right).mean()),
        "friction": float(abs(after[0] - scene.friction) / after[1]),
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
            "; ".join(it["search_causes"]) or "none", it["errors"], f"{it['friction']:.1f}",
            *("none" if c is None else percent(c) for c in
              (it["search_covered"], it["alone_covered"])),
            "missed" if flag is None else f"{1e3 * flag:.0f}",
        ))  # fmt: skip
    all_ = [it for _, it in found]
    known = [it for it in all_ if it["alone_covered"] is not None]
    lost = sum((it["search_covered"] or 0.0) < it["alone_covered"] - LESS for it in known)
    counts = [
        ("a right mode in 95 % of the time beside the hole", [it["right"] >= 0.95 for it in all_]),
        ("ever two_point there", [it["modes"]["two_point"] > 0 for it in all_]),
        ("something named as wrong", [bool(it["search_causes"]) for it in all_]),
        ("an ERROR of the contact beside the hole", [it["errors"] > 0 for it in all_]),
        ("friction within two standard deviations after it", [it["friction"] <= 2 for it in all_]),
        (
            "flag within 10 ms",
            [abs(np.inf if it["flag"] is None else it["flag"]) <= 0.01 for it in all_],
        ),
    ]
    told = "; ".join(f"{words} in {sum(those)}" for words, those in counts)
    lines = [
        f"Of {len(all_)} cells: {told}; "
        f"what follows withheld, or covered by 5 % less than alone, in {lost} of {len(known)}."
    ]
    return Report("\n".join([*lines, "", table(HEAD, rows)]))


def add_options(parser) -> None:
    """Add which cells are drawn."""
    parser.add_argument("--cells", type=int, default=CELLS, help=f"how many ({CELLS})")
    parser.add_argument("--first", type=int, default=FIRST, help=f"number of the first ({FIRST})")


def family(kind: Beside) -> Family:
    """Return the family of a kind of contact."""
    return Family(
        members, partial(score, kind), report, add_options, sources=(arms, cells, beside),
        parts=(*ESTIMATE, "cli", "replay", "robot", "messages", "bags"),
    )  # fmt: skip


FAMILY = family(SEARCH)
