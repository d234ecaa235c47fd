"""Drawn robot cells: what is drawn, how fast contacts slip, and what the table says."""

from argparse import Namespace

import numpy as np
import pytest

from benchmarks.robot_cells import drawn
from benchmarks.robot_cells.rows import GAMMA0, D, Rows, d

FIGURES = {
    "samples": 100, "covered": [0.95, 0.9, 1.0], "rmse": [3.0, 2.0, 1.0], "gamma": 0.99,
    "sliding": 200, "determined": 150, "flags_ms": [4.0], "errors": [],
    "modes": {"open": 0.99, "three_point": 0.97},
}  # fmt: skip


def test_each_cell_has_a_draw_of_its_own():
    members = drawn.members(Namespace(cells=4))
    assert len({member.name for member in members}) == len(members) == 60
    draws = [drawn.drawn(drawn.Cell(*member.of)) for member in members]
    # Those with chamfers are the same cells as their sharp control.
    assert len({draw["friction"] for draw in draws}) == 24
    assert drawn.drawn(drawn.Cell(*members[5].of)) == draws[5]
    # Within two deviations of what the cells state.
    assert all(0.1 <= draw["friction"] <= 0.3 for draw in draws)


def test_what_is_stated_has_the_drawn_hole():
    cell = drawn.Cell("ur_like", "damped", 1)
    setting = drawn.drawn(cell)
    joints = drawn.configuration_of(cell, setting).joints
    assert (joints.hole_xyz, joints.hole_rpy) == (setting["hole_xyz"], setting["hole_rpy"])


def rows(gamma, rates):
    n = len(gamma)
    q = np.column_stack([gamma, np.zeros((n, 2))])
    return Rows(
        np.arange(n) * 1e-3, np.zeros((n, 6)), np.zeros((n, 6)), np.zeros((n, 3, 3)),
        q, np.array(rates, float), np.zeros((n, 3)), np.zeros((n, 3)),
    )  # fmt: skip


def test_a_peg_that_turns_about_its_axis_slips_by_its_radius():
    spun = rows([0.2, 0.2, 0.5 * GAMMA0], [[0, 0, 2.0], [0, 0, 0], [0, 0, 2.0]])
    found = drawn.slip_speed(spun)
    # K lies on the rim, a little farther out than the peg is thick.
    assert found[0] == pytest.approx(2.0 * d / 2, rel=(D - d) / d + 1e-3)
    assert found[1] == found[2] == 0.0


def test_the_table_pools_the_samples_of_an_arm():
    cells = [drawn.Cell("ur_like", "hard", 0), drawn.Cell("ur_like", "hard", 1)]
    other = {**FIGURES, "samples": 300, "covered": [0.91, 0.9, 1.0], "flags_ms": [None]}
    other |= {"errors": ["jamming"], "gamma": 0.8, "modes": {"open": 0.98, "two_point": 0.93}}
    found = [(Namespace(of=cell), each) for cell, each in zip(cells, (FIGURES, other))]
    line = drawn.report(found, None).text.splitlines()[-1]
    assert "| ur_like | hard | 2 | 92 %, 90 %, 100 % | 90 % | 3.0, 2.0, 1.0 | 75 % |" in line
    # A flag that never came is the worst, as is the least of a mode; one of two had an alarm.
    assert line.endswith("| 80 % | inf, inf | 93 % | 1 |")
