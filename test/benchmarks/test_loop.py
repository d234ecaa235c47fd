"""The loop of cell, pipeline and program: what is drawn, and what the table says."""

import math

import numpy as np
import pytest

from benchmarks.loop import drawn, loop
from peg_world import insert


def test_axes_and_quaternion_are_one():
    lean, spin = np.array([0.03, -0.2]), 0.7
    x, y, z, w = insert.quaternion(lean, spin)
    about_z = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    along_x = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)])
    assert np.allclose(drawn.axes(lean, spin)[:, [2, 0]].T, [about_z, along_x], atol=1e-12)


def test_draws_are_within_what_is_said_of_them():
    surveyed = [drawn.drawn(number, surveyed=True) for number in range(200)]
    assert np.std([each.lean for each in surveyed]) == pytest.approx(drawn.SURVEY, rel=0.15)
    assert [each.grasp for each in surveyed] == [drawn.drawn(k).grasp for k in range(200)]
    tries = [drawn.drawn(number) for number in range(200)]
    assert len({each.friction for each in tries}) == 200
    assert all(0.05 <= each.friction <= 0.5 for each in tries)
    assert all(20e-6 <= each.clearance <= 200e-6 for each in tries)
    assert 1.3e-3 < max(math.hypot(*each.off) for each in tries) <= 1.5e-3
    assert max(math.hypot(*each.lean) for each in tries) <= math.radians(1.5)
    assert max(math.hypot(*each.grasp) for each in tries) <= math.radians(0.5)
    assert drawn.drawn(7) == tries[7]


RUN = {
    "outcome": "inserted", "tried": 1, "time": 5.0, "stops": [], "most_load": 100.0,
    "errors": [], "worst_level": 0, "own": True, "cpu": 20.0,
}  # fmt: skip


def test_the_table_counts_needless_stops_of_tries_that_do_no_harm():
    stopped = RUN | {"tried": 2, "stops": [[3.0, "align", "jamming: wedges"]], "errors": [3.0]}
    harm = RUN | {"most_load": 300.0}
    without_need = {"variants": {"plain": RUN, "stop": stopped}}
    with_need = {"variants": {"plain": harm, "stop": stopped}}
    found = loop.row("stop", [without_need, with_need])
    assert found[1] == 2
    assert found[2].startswith("0 of 2") and found[3].startswith("2 of 2")
    assert found[8].startswith("1 of 1")
    limit = RUN | {"tried": 2, "stops": [[3.0, "align", "force limit: 130 N"]]}
    assert not loop.needless(limit, RUN)


@pytest.mark.nightly
def test_a_try_in_lockstep_is_the_same_twice():
    pytest.importorskip("mujoco")
    pytest.importorskip("pinocchio")
    from benchmarks.loop import lockstep

    true, modes = drawn.drawn(0, surveyed=True), []
    options = insert.Options(peg_diameter=0.05 - true.clearance)

    def watch(t, row, command, published, cell):
        if command.stage == "align":
            modes.append((published.mode, published.loads, row[6]))

    runs = [lockstep.play(true, insert, options, watch, longest=2.5) for _ in range(2)]
    assert all(run.pop("cpu") > 0 for run in runs)
    assert runs[0] == runs[1]
    # It has touched, and the peg carries what it is pressed with.
    assert runs[0]["stage"] == "align"
    assert 10.0 < runs[0]["most_load"] < 400.0
    # The pipeline has the cell as it is: the levers follow from the wrench's frame.
    assert np.mean([mode == "three_point" for mode, _, _ in modes]) > 0.9
    known = [(a, b) for _, a, b in modes if np.isfinite(a).all()]
    assert all(abs(a[0] - b[0]) < 30.0 for a, b in known)
