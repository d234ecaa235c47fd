"""Rows of a peg that closes, and what is derived in them: by other constructions."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from late_samples import ordered, pipeline
from peg_on_hole_ros.monitor.output_row import MONITOR_NAMES, NOT_JUDGED, NOTHING, OUTPUTS, ROW
from peg_on_hole_ros.monitor.states import Mode
from peg_on_hole_ros.monitor.while_in_doubt import withhold


@pytest.fixture(scope="module")
def found():
    return list(pipeline().play(ordered(300)))


def test_torques_are_about_the_origin_of_the_hole(found):
    assert sum(out.normal.any() for out in found) > 100
    for out in found:
        for (x, y, z), wrench in zip(out.contact_point, out.contact_wrench):
            # r x F as a skew matrix, not by the cross product that the code uses.
            skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            np.testing.assert_allclose(wrench[3:], skew @ wrench[:3], rtol=0, atol=1e-13)


def test_the_pose_can_be_used_by_others(found):
    for out in found:
        turn = Rotation.from_matrix(out.rotation)
        assert (Rotation.from_quat(out.orientation).inv() * turn).magnitude() < 1e-14
        assert out.orientation[3] >= 0.0
    # Of rank 3 on three contacts; a program that inverts it needs the floor of 1e-6.
    assert found[-1].contact_mode == "three_point"
    least = [np.linalg.eigvalsh(out.pose_covariance)[0] for out in found]
    assert least[-1] == pytest.approx(1e-12, rel=1e-3)
    assert min(least) > 0.999e-12


def test_standard_deviations_are_those_of_the_covariance(found):
    for out in found:
        expected = np.sqrt(np.diagonal(out.state_covariance))
        np.testing.assert_allclose(out.state_stddev, expected, rtol=1e-15)


def test_a_number_that_nobody_fills_in_does_not_exist(found):
    assert not {name for out in found for name in out.monitor if name.startswith("hole_tilt")}
    assert {"friction", "reactions_determined"} <= found[-1].monitor.keys()
    assert found[-1].monitor.keys() <= set(MONITOR_NAMES)


def test_the_table_has_every_field_of_the_row_with_a_meaning():
    assert tuple(OUTPUTS) == ROW.names
    assert all(output.meaning for output in OUTPUTS.values())
    for name, output in OUTPUTS.items():
        numbers = int(np.prod(ROW[name].shape, dtype=int))
        shares = len(output.topic.split()) * len(output.field.split()) or 1
        assert numbers % shares == 0
        assert not output.names or numbers == shares * len(output.names)


def test_in_doubt_nothing_that_rests_on_the_wrench_is_left():
    rows = np.repeat(NOTHING, 3)
    rows["contact_mode"] = Mode.THREE_POINT, Mode.OPEN, Mode.UNKNOWN
    rows["normal"], rows["closed"] = (5.0, 0.0, 1.0), 1.0
    rows["jamming_risk"] = rows["friction"] = 0.5
    rows["alarms"]["level"] = [[2, 0, 1], [1, 1, 1], [-1, -1, -1]]
    withhold(rows, True)
    assert rows["contact_mode"].tolist() == [Mode.UNKNOWN, Mode.OPEN, Mode.UNKNOWN]
    assert rows["closed"].tolist() == [[1.0, 0.0, 1.0], [0.0] * 3, [1.0, 0.0, 1.0]]
    assert np.isnan(rows["jamming_risk"]).all() and (rows["friction"] == 0.5).all()
    assert not rows["reactions_determined"].any() and rows["transition"].all()
    assert rows["alarms"]["level"].tolist() == [[0] * 3, [0] * 3, [-1] * 3]
    assert (rows["alarms"]["held"][:2] == NOT_JUDGED).all() and not rows["alarms"]["held"][2].any()
