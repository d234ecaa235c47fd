"""The parameter table, its records, and the errors of both."""

from dataclasses import fields

import pytest

from peg_on_hole_ros.config.configuration import (
    PARAMETERS,
    from_parameters,
    half_stated_zero,
    node_options,
    to_parameters,
)
from peg_on_hole_ros.config.options import Configuration, NodeOptions
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.scene import Scene


def test_every_field_has_a_row_with_the_same_default():
    expected = {f.name: f.default for f in fields(NodeOptions)}
    for group in fields(Configuration):
        for f in fields(group.default_factory()):
            expected[f"{group.name}.{f.name}"] = f.default
    # Of a description: by a bag, and by what it says.
    for name in ("description", "described_by", "robot_gravity"):
        del expected[f"joints.{name}"]
    del expected["wrench.base_links"]
    assert {row.name: row.default for row in PARAMETERS} == expected


def test_every_default_is_within_its_own_range_and_says_its_effect():
    assert from_parameters({}) == Configuration()
    assert node_options({}) == NodeOptions()
    for row in PARAMETERS:
        assert row.effect and "\n" not in row.effect, row.name
        if row.type.startswith(("double", "integer")):
            assert row.low is not None and row.low < row.high, row.name


def test_values_reach_their_fields_and_come_back():
    given = {
        "scene.friction": 0.31,
        "wrench.acts_on": "robot",
        "wrench.sensor_xyz": [0.01, 0.02, 0.03],
        "joints.names": ["g", "p", "f"],
        "filter.gate_reset_count": 7,
        "autostart": False,
        "use_sim_time": True,
        "qos_overrides./wrench.subscription.depth": 3,
    }
    configuration = from_parameters(given)
    assert configuration.scene == Scene(friction=0.31)
    assert configuration.wrench.sensor_xyz == (0.01, 0.02, 0.03)
    assert configuration.joints.names == ("g", "p", "f")
    assert configuration.filter.gate_reset_count == 7
    node = node_options(given)
    assert node.autostart is False
    back = to_parameters(configuration, node)
    assert list(back) == [row.name for row in PARAMETERS]
    assert back["wrench.sensor_xyz"] == [0.01, 0.02, 0.03]
    assert from_parameters(back) == configuration
    assert node_options(back) == node
    assert "autostart" not in to_parameters(configuration)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"scene.hole_diamter": 0.05},
            (
                "unknown parameter 'scene.hole_diamter'; the nearest are: scene.hole_diameter, "
                "scene.peg_diameter, scene.hole_chamfer"
            ),
        ),
        (
            {"friction": 0.1},
            "unknown parameter 'friction'; the nearest are: scene.friction, filter.friction",
        ),
        (
            {"zzz": 1},
            (
                "unknown parameter 'zzz'; there are: accuracy, autostart, filter, frames, joints, "
                "markers_rate, monitor, plan, qos_depth, record_arrivals, scene, topics, wrench"
            ),
        ),
        (
            {"scene.hole_diameter": 50.0},
            (
                "scene.hole_diameter = 50 m is not within 0.0001 to 1 m; 0.05 m would be: the "
                "units look slipped by 1000"
            ),
        ),
        (
            {"wrench.sensor_xyz": [0.0, 0.0, 70.0]},
            (
                "wrench.sensor_xyz[2] = 70 m is not within -10 to 10 m; 0.07 m would be: the "
                "units look slipped by 1000"
            ),
        ),
        (
            {"scene.gravity": [0.0, -9806.65, 0.0]},
            "scene.gravity[1] = -9806.65 m/s^2 is not within -100 to 100 m/s^2; -9.80665 m/s^2 "
            "would be: the units look slipped by 1000",
        ),
        # Just out of range, it is no other unit, though a thousandth of it would be within.
        (
            {"joints.delay": 0.6},
            "joints.delay = 0.6 s is not within -0.5 to 0.5 s; the default is 0 s",
        ),
        (
            {"joints.delay": -2.0},
            "joints.delay = -2 s is not within -0.5 to 0.5 s; the default is 0 s",
        ),
        (
            {"scene.gravity": [0.0, 0.0, "9.8"]},
            "scene.gravity[2] = '9.8' is a string, not a double; it is a double such as 0.0",
        ),
        (
            {"joints.names": ["gamma", "psi", ""]},
            "joints.names[2] = '' is empty; it is a string such as 'gamma'",
        ),
        (
            {"wrench.sensor_rpy": [180.0, 0.0, 0.0]},
            "wrench.sensor_rpy[0] = 180 rad is not within -6.3 to 6.3 rad; degrees? 180 of them "
            "are 3.14159 rad",
        ),
        (
            {"filter.initial_rate_stddev": 5000.0},
            "filter.initial_rate_stddev = 5000 rad/s is not within 1e-06 to 1000 rad/s; degrees? "
            "5000 of them a second are 87.2665 rad/s",
        ),
        (
            {"scene.friction": -0.1},
            "scene.friction = -0.1 is not within 0 to 2; the default is 0.2",
        ),
        (
            {"scene.friction": float("nan")},
            "scene.friction = nan is not within 0 to 2; the default is 0.2",
        ),
        (
            {"scene.friction": 1},
            (
                "scene.friction = 1 is an integer, not a double; write 1.0 (ROS 2 does not take "
                "an integer for a double)"
            ),
        ),
        (
            {"scene.gravity": [0.0, 0, -9.8]},
            (
                "scene.gravity[1] = 0 is an integer, not a double; write 0.0 (ROS 2 does not take "
                "an integer for a double)"
            ),
        ),
        (
            {"scene.gravity": [0.0, -9.8]},
            (
                "scene.gravity = [0.0, -9.8] has 2 values, not 3; it is a double[] such as "
                "[0.0, 0.0, -9.80665]"
            ),
        ),
        (
            {"scene.gravity": -9.8},
            "scene.gravity = -9.8 is not double[]; it is a double[] such as [0.0, 0.0, -9.80665]",
        ),
        (
            {"scene.friction": "0.2"},
            "scene.friction = '0.2' is a string, not a double; it is a double such as 0.2",
        ),
        (
            {"qos_depth": True},
            "qos_depth = True is a bool, not an integer; it is an integer such as 200",
        ),
        ({"wrench.acts_on": "tool"}, "wrench.acts_on = 'tool' is not one of peg, robot"),
        (
            {"topics.wrench": "ft sensor"},
            (
                "topics.wrench = 'ft sensor' is not the name of a topic; it is a string such as "
                "'/wrench'"
            ),
        ),
        (
            {"topics.wrench": "/joint_states"},
            "topics.wrench = '/joint_states' and topics.joint_states = '/joint_states' are one "
            "topic; they have to be two",
        ),
        (
            {"topics.wrench": "/a/b", "topics.joint_states": "a/b"},
            "topics.wrench = '/a/b' and topics.joint_states = 'a/b' are one topic; they have to "
            "be two",
        ),
        (
            {"scene.peg_diameter": 0.051},
            (
                "scene.peg_diameter = 0.051 m is not below scene.hole_diameter = 0.05 m: a peg "
                "rests on three points of a rim only if it is thinner than the hole; check "
                "whether the two are exchanged"
            ),
        ),
        (
            {"joints.names": ["gamma", "psi"]},
            (
                "joints.names = ['gamma', 'psi'] has 2 names; joints.source peg needs 3, in the "
                "order gamma, psi, phi"
            ),
        ),
        (
            {"joints.names": ["gamma", "psi", "psi"]},
            "joints.names = ['gamma', 'psi', 'psi'] names a joint twice",
        ),
        (
            {"joints.source": "robot"},
            "joints.urdf is empty, but joints.source robot needs it",
        ),
        (
            {"monitor.jamming_warn": 0.99},
            (
                "monitor.jamming_warn = 0.99 is above monitor.jamming_error = 0.9; it has to be "
                "at most that"
            ),
        ),
        (
            {"monitor.jamming_warn": 0.1},
            (
                "monitor.alarm_hysteresis = 0.1 is not below monitor.jamming_warn = 0.1: a risk "
                "of 0 would clear no alarm; make it smaller, such as a seventh of that"
            ),
        ),
    ],
)
def test_impossible_parameters_are_named_with_value_range_and_remedy(given, message):
    with pytest.raises(PegOnHoleError) as caught:
        from_parameters(given)
    assert str(caught.value) == message
    assert caught.value.exit_code == 2


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            {"wrench.bias_torque_stddev": 0.01},
            "state wrench.bias_force_stddev too, unless the bias of the forces is known, as 0 "
            "means: wrench.bias_torque_stddev is 0.01 N m",
        ),
        (
            {"wrench.bias_force_stddev": 0.5},
            "state wrench.bias_torque_stddev too, unless the bias of the torques is known, as 0 "
            "means: wrench.bias_force_stddev is 0.5 N",
        ),
        ({}, ""),
        ({"wrench.bias_force_stddev": 0.5, "wrench.bias_torque_stddev": 0.01}, ""),
    ],
)
def test_what_is_stated_by_half_is_told(given, said):
    assert half_stated_zero(from_parameters(given)) == said
