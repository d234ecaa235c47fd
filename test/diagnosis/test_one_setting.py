"""One thing that is wrong in a drawn cell: it is named first; of a right cell nothing is."""

import pytest

from benchmarks.own_cells.cells import drawn_cell, write, write_parameters
from benchmarks.own_cells.own_cells import RIGHT, outcome, said_of
from benchmarks.own_cells.wrong import WRONG
from tiers import at_push

pytest.importorskip("pinocchio")

# Of each the cause comes first; what cannot be told apart in every cell withholds reactions.
NAMED = (
    "payload_twice", "sensor_height_half", "joints_20_ms_late", "tip_frame", "kilonewtons",
    "peg_rpy_of_another_tool", "peg_mass_a_tenth", "peg_mass_times_10", "payload_forgotten",
    "gravity_compensated", "sensor_height_0", "joints_10_ms_late", "peg_rpy_3_degrees",
)  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("cell")


@pytest.fixture(scope="module")
def cell(folder):
    return drawn_cell(2, folder)


def said(kind, cell, folder):
    changed = cell if kind == RIGHT else WRONG[kind].change(cell)
    write(folder / f"{kind}.mcap", changed)
    write_parameters(folder / f"{kind}.yaml", changed)
    return said_of(folder / f"{kind}.mcap", folder / f"{kind}.yaml")


def test_nothing_is_said_of_a_cell_that_is_right(cell, folder):
    assert outcome(RIGHT, cell, said(RIGHT, cell, folder)) == "quiet"


@pytest.mark.parametrize("kind", at_push(NAMED[:6], NAMED))
def test_what_is_wrong_is_named_first_and_voids_the_reactions(kind, cell, folder):
    found = said(kind, cell, folder)
    assert outcome(kind, cell, found) == "named", found.causes
    assert found.withheld
