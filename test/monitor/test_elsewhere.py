"""A peg that is pressed on the plate beside the hole: nothing is made of that load."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from peg_on_hole_ros.config.configuration import Configuration
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.records import AngleMeasurement, JointSample, WrenchSample

CONFIGURATION = Configuration()
SCENE, WRENCH = CONFIGURATION.scene, CONFIGURATION.wrench
UNTARED = replace(
    CONFIGURATION, wrench=replace(WRENCH, bias_force_stddev=1.0, bias_torque_stddev=0.03)
)
# Down at 0.4 s, within 0.1 s.
DOWN, PRESSED, END = 400, 700, 1200
PUSH = 15.0


def axes(gamma, psi):
    c, s, cp, sp = np.cos(gamma), np.sin(gamma), np.cos(psi), np.sin(psi)
    return np.array([[cp, -sp, 0], [sp, cp, 0], [0, 0, 1]]) @ [[c, 0, -s], [0, 1, 0], [s, 0, c]]


@cache
def search(gamma, place=None, aside=0.2, towards=0.0):
    """
    Press a peg down at its lowest point; return the outputs, and the pipeline.

    `aside`: what the push has across the hole, of that along it; `towards`: its azimuth [rad].
    """
    rng, R = np.random.default_rng(3), axes(gamma, 0.4)
    lever = np.array([-SCENE.peg_diameter / 2, 0.0, 0.0]) - WRENCH.sensor_xyz
    weight = R.T @ [0.0, 0.0, -SCENE.peg_mass * 9.80665]
    to_mass = np.array([0.0, 0.0, SCENE.peg_height / 2]) - WRENCH.sensor_xyz

    def seen(sample):
        q = np.array([gamma, 0.4, 0.0]) + rng.normal(0, 1e-4, 3) * [1, 1 / gamma, 1 / gamma]
        covariance = np.diag([1e-4, 1e-4 / gamma, 1e-4 / gamma]) ** 2
        where = () if place is None else (np.array(place), 2.5e-7 * np.eye(3))
        return AngleMeasurement(sample.t_ns, q, covariance, *where)

    seen.names = PegJoints(CONFIGURATION.joints).names
    line, outputs = Pipeline(UNTARED, seen), []
    for k in range(END):
        t_ns = k * 1_000_000
        if k % 2 == 0:
            line.on_joints(JointSample(t_ns, ("gamma", "psi", "phi"), (0.0, 0.0, 0.0)))
        push = PUSH * min(max((k - DOWN) / 100, 0.0), 1.0)
        pushed = push * R.T @ [aside * np.cos(towards), aside * np.sin(towards), 1.0]
        force = rng.normal(0, WRENCH.force_stddev, 3) - pushed - weight
        torque = rng.normal(0, WRENCH.torque_stddev, 3)
        torque -= np.cross(lever, pushed) + np.cross(to_mass, weight)
        found = line.on_wrench(WrenchSample(t_ns, tuple(force), tuple(torque)))
        outputs += [found] if found else []
    return outputs, line


def modes(outputs, begin=PRESSED):
    return {o.contact_mode for o in outputs[begin - END :]}


def bias(outputs, at):
    return np.array([outputs[at].monitor[f"bias_force_{axis}"] for axis in "xyz"])


@pytest.mark.parametrize(
    ("gamma", "place", "mode"),
    [
        # By the line of action; below gamma0 the bottom of the hole pushes so, too.
        (0.15, None, "elsewhere"),
        (0.08, None, "elsewhere"),
        (0.02, None, "unknown"),
        # By the place.
        (0.15, (8e-3, 0.0, 3.7e-3), "elsewhere"),
        (0.02, (8e-3, 0.0, 0.5e-3), "elsewhere"),
    ],
)
def test_a_press_beside_the_hole_teaches_nothing(gamma, place, mode):
    outputs, line = search(gamma, place)
    assert modes(outputs) == {mode}
    assert {o.contact_mode for o in outputs[100:DOWN]} == {"open"}
    pressed = outputs[PRESSED - END :]
    assert {o.monitor["reactions_determined"] for o in pressed} == {0.0}
    assert {a.level for o in pressed for a in o.alarms} == {0}
    before, after = bias(outputs, DOWN - END), bias(outputs, -1)
    # Where the load alone decides, the first 0.1 s are weighed with three contacts.
    np.testing.assert_allclose(after, before, atol=0.2 if place or gamma < 0.05 else 0.5)
    friction = {o.monitor["friction"] for o in pressed}
    assert max(friction) - min(friction) < 1e-6


def test_a_tare_on_a_plate_is_refused():
    for gamma in (0.15, 0.02):
        answer = search(gamma)[1].tare()
        assert not answer.success


def test_what_would_distinguish_plate_and_bottom_is_told():
    _, line = search(0.02)
    assert line.counts["contact_may_be_plate"] > 300
    assert any("joints.hole_xyz_stddev" in cause for cause in line.causes)
    _, line = search(0.15)
    assert line.counts["contact_may_be_plate"] == 0
    assert not any("hole_xyz_stddev" in cause for cause in line.causes)


def test_a_load_high_above_the_plate_is_the_sensors():
    assert modes(search(0.02, (8e-3, 0.0, 0.3))[0]) == {"open"}


def test_a_peg_whose_place_is_in_the_hole_needs_no_other_way():
    assert modes(search(0.02, (0.0, 0.0, -4e-3))[0]) == {"two_point"}


def test_a_force_that_no_plate_has_shows_the_hole():
    """A wall pushes aslant: the peg has a way in by that alone."""
    assert modes(search(0.02, None, aside=3.0)[0]) == {"two_point"}


# The lower edge stands on a cone of 45 degrees, which pushes inwards as much as up.
BESIDE_THE_THROAT, ON_A_CONE = (3.5e-4, 0.0, 3e-4), 1.0


@pytest.mark.parametrize(("gamma", "place"), [(0.004, BESIDE_THE_THROAT), (0.003, None)])
def test_a_landing_on_a_cone_teaches_nothing(gamma, place):
    """Two points would be 25 mm deep at this tilt, half a diameter, and could not carry it."""
    outputs, line = search(gamma, place, ON_A_CONE)
    assert modes(outputs) == {"unknown"}
    pressed = outputs[PRESSED - END :]
    assert {o.monitor["reactions_determined"] for o in pressed} == {0.0}
    assert {a.level for o in outputs for a in o.alarms} == {0}
    friction = {o.monitor["friction"] for o in outputs}
    assert max(friction) - min(friction) < 1e-6


def test_a_load_of_a_cone_is_one_of_walls_where_the_peg_is_in_the_hole():
    assert modes(search(0.004, (0.0, 0.0, -20e-3), ON_A_CONE)[0]) == {"two_point"}
    # It has a couple about where it comes from: two points 0.05 d deep carry it by friction.
    assert modes(search(0.04, None, ON_A_CONE)[0]) == {"two_point"}


# The cone pushes the lowest point towards the axis, that is, where the peg leans from.
INWARDS = 0.4


@pytest.mark.parametrize(("gamma", "aside"), [(0.01, 1.0), (0.04, 1.0), (0.04, 0.6), (0.055, 1.4)])
def test_a_landing_on_a_cone_is_told_by_its_line_of_action(gamma, aside):
    """By friction 0.2 a cone of 45 degrees pushes aside by 0.67 to 1.5 of what it carries."""
    outputs, _ = search(gamma, None, aside, INWARDS)
    assert modes(outputs) == {"unknown"}
    assert {a.level for o in outputs for a in o.alarms} == {0}
    friction = {o.monitor["friction"] for o in outputs}
    assert max(friction) - min(friction) < 1e-6


def test_a_wall_at_the_lower_edge_is_no_cone():
    """It pushes the same point, farther aside than its friction reaches."""
    assert modes(search(0.04, None, 5.0, INWARDS)[0]) == {"two_point"}
