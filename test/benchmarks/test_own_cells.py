"""Drawn cells of one's own: what they send fits what they state, and what came out is judged."""

import numpy as np
import pytest

from benchmarks.harness.family import Member
from benchmarks.own_cells.cells import EVERY, URDF, drawn_cell, write
from benchmarks.own_cells.own_cells import RIGHT, Said, outcome, report
from benchmarks.own_cells.wrong import WRONG
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.robot.described import described
from peg_on_hole_ros.robot.kinematics import orientation_source


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("cell")


@pytest.fixture(scope="module")
def cell(folder):
    return drawn_cell(2, folder)


def test_joints_hold_the_peg_where_it_is(cell, folder):
    # The second cell stands on `world`: what its description says is read by the package.
    urdf = {"joints.urdf": str(folder / URDF)}
    configuration = described(from_parameters(cell.parameters | urdf))
    # The same direction whether it is stated or follows from the root link.
    assert np.allclose(configuration.scene.gravity, configuration.joints.robot_gravity, atol=1e-6)
    source = orientation_source(configuration.joints)
    rows = source.rows(tuple(configuration.joints.names), cell.joints[::200]).rows
    truth = cell.truth
    # Six joints of 3e-5 rad, on levers of up to a metre.
    assert np.abs(rows[:, 0] - truth.q[:: 200 * EVERY, 0]).max() < 4e-4
    assert np.abs(rows[:, 12:15] - truth.position[:: 200 * EVERY]).max() < 4e-4


def test_each_thing_that_is_wrong_changes_a_cell_and_no_other(cell):
    before = dict(cell.parameters), cell.wrench.copy(), cell.joints.copy()
    for kind, wrong in WRONG.items():
        changed = wrong.change(cell)
        same = (
            changed.parameters == cell.parameters
            and np.array_equal(changed.wrench, cell.wrench)
            and np.array_equal(changed.joints, cell.joints)
            and changed.late == cell.late
        )
        # Gravity is stated in half of the cells.
        assert same == (kind == "gravity_forgotten" and "scene.gravity" not in before[0]), kind
    assert cell.parameters == before[0]
    assert np.array_equal(cell.wrench, before[1]) and np.array_equal(cell.joints, before[2])


def test_a_bag_of_a_cell_has_wrench_joints_and_truth(cell, tmp_path):
    write(tmp_path / "run.mcap", cell)
    bag = Bag(tmp_path / "run.mcap")
    assert bag.topics["/ft/wrench"].count == len(cell.truth.t_ns)
    assert bag.topics["/joint_states"].count == len(cell.joints)
    assert {"/truth/state", "/truth/contacts", "/truth/contact_mode"} <= set(bag.topics)


def said(*causes, code=0, withheld=False, covered=0.96):
    return Said(code, list(causes), withheld, covered, 0)


def test_what_came_out_is_judged(cell):
    right = cell.parameters
    size = 1e3 * (right["scene.hole_diameter"] - right["scene.peg_diameter"])
    line = "scene: the clearance is off: set hole_diameter - peg_diameter to {:.3f} mm; with it"
    for found, kind, of in (
        ("quiet", RIGHT, said()),
        ("false cause", RIGHT, said("wrench: set wrench.axes: base")),
        ("named", "sign", said("wrench: set wrench.acts_on: robot")),
        ("withheld", "sign", said("joints: set joints.delay: 0.01", withheld=True)),
        ("false cause", "sign", said("joints: set joints.delay: 0.01")),
        ("refused", "diameters_in_mm", said("peg-on-hole: error: units", code=2)),
        ("exit code", "diameters_in_mm", said()),
        ("named", "clearance_2.5_times", said(line.format(size))),
        ("false cause", "clearance_2.5_times", said(line.format(2 * size))),
        ("sure", "tip_frame", said(covered=0.5)),
        ("untold", "tip_frame", said()),
        ("harmless", "friction_0.5", said()),
    ):
        assert outcome(kind, cell, of) == found, kind


def test_the_table_counts_what_came_out_as_it_has_to(cell):
    rows = [("right", "quiet"), ("sign", "named"), ("tip_frame", "sure")]
    found = [(Member(f"2_{kind}", (2, kind)), {"outcome": out}) for kind, out in rows]
    text = report(found, None).text
    assert "| tip_frame | sure |" in text and "| as it has to | 1 of 2 |" in text
