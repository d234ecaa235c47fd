"""One thing that is wrong in a drawn cell: it is named first; of a right cell nothing is."""

from collections import Counter

import numpy as np
import pytest

from benchmarks.own_cells.cells import EVERY, drawn_cell, write, write_parameters
from benchmarks.own_cells.own_cells import RIGHT, outcome, said_of
from benchmarks.own_cells.wrong import WRONG
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.diagnosis.suspected.one_setting import OneSetting
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated
from peg_on_hole_ros.engine.settings_against_data import SettingsAgainstData
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample
from peg_on_hole_ros.robot.described import described
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


def looked_at(cell, folder, beside_s, tared_s):
    """
    Return the look at a cell by its truth.

    While it comes near, so long before it touches, the place tells a peg beside the hole, as a
    load does that a wrong weight makes; and it is tared so long before it touches [s].
    """
    write_parameters(folder / "looked_at.yaml", cell)
    configuration = described(load(str(folder / "looked_at.yaml"))[0])
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    look, truth = OneSetting(Stated(configuration, reduction, np.zeros(6))), cell.truth
    t = truth.t_ns * 1e-9
    free = truth.mode == "open"
    left = t[np.flatnonzero(~free)[0]] - t
    last, tared = 0, False
    for i in range(9, len(t), 10):
        some = slice(last, i + 1)
        look.take_every_wrench(truth.t_ns[some], cell.wrench[some])
        at = EVERY * (i // EVERY)
        measured = AngleMeasurement(int(truth.t_ns[at]), truth.q[at], 1e-9 * np.eye(3))
        beside = bool(0.0 < left[i] < beside_s)
        sample = WrenchSample(int(truth.t_ns[i]), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        look.take(Instant(sample, measured, None, bool(free[i]) and not beside, beside), False)
        if not tared and left[i] < tared_s:
            look.restate(Stated(configuration, reduction, np.zeros(6)))
            tared = True
        last = i + 1
    return look


@pytest.mark.parametrize(("beside_s", "tared_s"), [(0.0, 0.0), (0.4, 0.0), (0.0, 0.3)])
def test_what_hung_in_the_air_counts_whatever_came_between(cell, folder, beside_s, tared_s):
    found = looked_at(WRONG["payload_forgotten"].change(cell), folder, beside_s, tared_s).finding
    assert found is not None and "payload_mass" in found.text


def test_a_tare_does_not_make_the_fit_begin_anew(cell, folder):
    """It keeps wrenches as received, as those of the air before an automatic tare."""
    configuration = described(load(str(folder / "looked_at.yaml"))[0])
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    against = SettingsAgainstData(configuration, reduction, Counter(), offline=True)
    look = against._looks[OneSetting].look
    against.look(configuration, reduction, np.ones(6), tared=True)
    assert against._looks[OneSetting].look is look
    against.look(configuration, reduction, np.ones(6))
    assert against._looks[OneSetting].look is not look
