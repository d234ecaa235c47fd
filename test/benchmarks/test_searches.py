"""Drawn searches on the plate: what they send is a plate's load, and nothing is made of it."""

from functools import partial

import numpy as np
import pytest

from benchmarks.own_cells.beside import PHASE, PLATE, SEARCH, rows_of, with_contact
from benchmarks.own_cells.cells import drawn_cell, write, write_parameters
from benchmarks.own_cells.own_cells import said_of
from peg_on_hole_ros.sim.dynamics import rotation

# Presses that a sensor turned by half a turn would read of three contacts: one 5 to 2 mm beside
# the hole, and one whose place, in the end, is within its error of where three contacts are.
NUMBERS = 43, 304


def search_alone(truth, number):
    whole = with_contact(truth, number, SEARCH)
    return rows_of(whole, 0, int((whole.phase == PHASE).sum()))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("search")


@pytest.fixture(scope="module", params=NUMBERS)
def cell(request, folder):
    return drawn_cell(request.param, folder, partial(search_alone, number=request.param))


def test_a_plate_pushes_at_the_lowest_point_beside_the_hole(cell):
    truth, scene = cell.truth, cell.truth.plan.configuration.scene
    pressed = truth.mode == PLATE
    assert pressed.any()
    peg = np.array([rotation(q) for q in truth.q])
    # Where the force of the plate acts, by its moment about the mass centre.
    centre = truth.centre[:, 0]
    force = scene.peg_mass * (truth.centre[:, 2] - np.asarray(scene.gravity)) - truth.force
    moment = -truth.moment
    around = np.linspace(0, 2 * np.pi, 721)
    rim = np.column_stack([np.cos(around), np.sin(around), 0 * around])
    for k in np.flatnonzero(pressed)[50:-50:200]:
        edge = truth.position[k] + 0.5 * scene.peg_diameter * rim @ peg[k].T
        lowest = edge[np.argmin(edge[:, 2])]
        # Half a degree of the edge, and the plate at zero.
        assert abs(lowest[2]) < 1e-5
        assert np.hypot(*lowest[:2]) > 0.5 * scene.hole_diameter
        arm = lowest - centre[k]
        assert np.abs(np.cross(arm, force[k]) - moment[k]).max() < 1e-3 * force[k, 2]
        assert force[k, 2] > 0.0


def test_nothing_is_named_of_a_search_that_is_rightly_stated(cell, folder):
    write(folder / "run.mcap", cell)
    write_parameters(folder / "run.yaml", cell)
    said = said_of(folder / "run.mcap", folder / "run.yaml")
    assert said.exit_code == 0 and said.causes == [] and said.alarms == 0
