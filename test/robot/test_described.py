"""What a robot's description says of the settings: where down is, and what axes a wrench has."""

import json
from dataclasses import replace

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from arm import JOINTS, OPTIONS, URDF, Arm
from cli_helpers import fails
from hand_bags import BIAS, MASS, arm_poses
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.configuration import from_parameters, to_parameters
from peg_on_hole_ros.config.options import Configuration, WrenchInput
from peg_on_hole_ros.config.parameters_file import write_parameters
from peg_on_hole_ros.diagnosis.hypotheses import hypotheses
from peg_on_hole_ros.diagnosis.suspected.stated_gravity import contradiction
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.replay.run import stored_configuration
from peg_on_hole_ros.robot.described import described
from peg_on_hole_ros.robot.fixed_links import Tree
from peg_on_hole_ros.robot.sensor_frame import mounting
from peg_on_hole_ros.robot.urdf_file import parts

TEXT = URDF.read_text(encoding="utf-8")
DOWN = np.array([0.0, 0.0, -9.80665])
LEANS = (0.38, -0.22, 0.9)
AS_STATED = WrenchInput(sensor_pose="stated")


def cell(hole_rpy=LEANS, gravity=None, **joints):
    scene = Scene() if gravity is None else Scene(gravity=gravity)
    joints = replace(OPTIONS, hole_rpy=hole_rpy, **joints)
    return Configuration(scene=scene, wrench=AS_STATED, joints=joints)


def with_axes(axes, sensor_rpy=(0.0, 0.0, 0.0), **joints):
    return replace(cell(**joints), wrench=replace(AS_STATED, axes=axes, sensor_rpy=sensor_rpy))


def in_hole(down_R, hole_rpy=LEANS):
    return Rotation.from_euler("xyz", hole_rpy).inv().apply(down_R)


def on_world(rpy):
    """The arm on a link `world`, turned against it."""
    mount = (
        '<link name="world"/><joint name="mount" type="fixed"><parent link="world"/>'
        f'<child link="pedestal"/><origin xyz="1 2 0.5" rpy="{rpy}"/></joint>'
    )
    return TEXT.replace("</robot>", f"{mount}</robot>")


def parameters_file(path, configuration):
    path.write_text(write_parameters(to_parameters(configuration)), encoding="utf-8")
    return path


def test_gravity_pulls_along_minus_z_of_the_root_link():
    assert described(cell()).scene.gravity == pytest.approx(in_hole(DOWN), abs=1e-12)


@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_of_an_upright_hole_it_is_the_default_to_the_last_bit(yaw):
    """So bags of before, which hold the default, replay with the same numbers."""
    assert described(cell((0.0, 0.0, yaw))).scene.gravity == Scene().gravity


def test_an_arm_on_a_link_world_has_the_gravity_of_that():
    text = on_world("0.5 0 0.3")
    # The hole's axes are those in the root link, which is world now.
    found = described(cell(description=text)).scene.gravity
    assert found == pytest.approx(in_hole(DOWN), abs=1e-12)
    # A link that stands upright in a description whose root lies on its side.
    found = described(cell(description=text, gravity_link="pedestal")).scene.gravity
    turned = Rotation.from_euler("xyz", [0.5, 0.0, 0.3]).apply(DOWN)
    assert found == pytest.approx(in_hole(turned), abs=1e-12)


def test_a_link_that_is_none_or_moves_is_refused():
    with pytest.raises(PegOnHoleError, match="gravity_link = 'floor' is no link of .*; it has: "):
        described(cell(gravity_link="floor"))
    with pytest.raises(PegOnHoleError, match="'flange' moves against the root link 'pedestal'"):
        described(cell(gravity_link="flange"))


def test_the_pegs_own_joints_have_the_gravity_that_is_stated():
    plain = Configuration(joints=replace(Configuration().joints, hole_rpy=LEANS))
    assert described(plain) is plain


def test_stated_gravity_overrides_and_stated_as_a_link_the_default_too():
    given = (0.1, 0.2, -9.7)
    assert described(cell(gravity=given)).scene.gravity == given
    meant = described(cell(gravity_link="stated"))
    assert meant.scene.gravity == Scene().gravity and not contradiction(meant)


def test_what_follows_from_the_robot_is_kept_as_the_default():
    """A bag holds every parameter: its gravity is no override when the hole is corrected."""
    once = described(cell())
    assert described(once) == once
    parameters = to_parameters(once)
    assert parameters["scene.gravity"] == list(Scene().gravity)
    assert parameters["joints.gravity_link"] == ""
    again = described(from_parameters(parameters))
    assert again.scene == once.scene
    given = (0.1, 0.2, -9.7)
    stated = to_parameters(described(cell(gravity=given)))
    assert stated["scene.gravity"] == list(given)


def test_a_contradiction_is_named_with_both_ways_out():
    stated = tuple(in_hole(DOWN).tolist())
    assert not contradiction(described(cell(gravity=stated)))
    near = Rotation.from_euler("x", 2.0, degrees=True).apply(stated)
    assert not contradiction(described(cell(gravity=tuple(near.tolist()))))
    # No weight at all is no direction.
    assert not contradiction(described(cell(gravity=(0.0, 0.0, 0.0))))
    text = contradiction(described(cell((0.38, 0.0, 0.9), gravity=stated)))
    assert text.startswith("scene.gravity is 12.6 degrees off the robot's")
    assert "[-2.1401, -3.5498" in text
    assert "take scene.gravity out" in text
    assert "joints.hole_rpy: [0.38, -0.22, 0.9]" in text
    assert "joints.gravity_link: stated" in text


def test_a_stream_takes_gravity_with_the_description_that_comes_late():
    waiting = cell(urdf="topic")
    stream = message_stream(waiting)
    assert stream.pipeline.configuration.scene.gravity == Scene().gravity
    stream.use_robot_description(TEXT)
    known = message_stream(cell(description=TEXT))
    for each in (stream, known):
        assert each.pipeline.configuration.scene.gravity == pytest.approx(in_hole(DOWN))
        assert each.pipeline.processor.filter.gravity == pytest.approx(in_hole(DOWN))
        # What is set while it runs leaves it.
        assert each.on_event('set {"monitor.jamming_warn": 0.6}').success
        assert each.pipeline.configuration.scene.gravity == pytest.approx(in_hole(DOWN))


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("poses") / "poses.mcap"
    return arm_poses(path, replace(OPTIONS, hole_rpy=LEANS))


def test_base_is_the_link_of_that_name_where_it_stands_still_and_else_the_root_link():
    # Of this arm it is turned by 30 degrees on its pedestal.
    assert described(with_axes("base")).wrench.base_rpy == pytest.approx((0.0, 0.0, np.pi / 6))
    assert described(with_axes("pedestal")).wrench.base_rpy == (0.0, 0.0, 0.0)
    without = with_axes("base", description=TEXT.replace('"base"', '"turret"'))
    assert described(without).wrench.base_rpy == (0.0, 0.0, 0.0)
    # Where both are one the report says base, as most drivers do.
    meant = hypotheses(replace(described(without).wrench, axes="sensor"))
    tried = {setting for each in meant for setting in each.settings}
    assert "wrench.axes: base" in tried and "wrench.axes: pedestal" not in tried
    carried = TEXT.replace('"base"', '"x"').replace('"ft_sensor"', '"base"')
    moves = with_axes("base", description=carried)
    assert pytest.approx(np.eye(3)) != Tree(*parts(carried, "a")).fixed("base").R
    assert described(moves).wrench.base_rpy == (0.0, 0.0, 0.0)


def test_links_that_stand_still_below_a_world_are_axes_too():
    text = on_world("0.5 0 0.3")
    found = described(with_axes("pedestal", description=text)).wrench
    assert found.base_rpy == pytest.approx((0.5, 0.0, 0.3))
    # What a driver may send though something else is stated.
    names = [link.name for link in described(cell(description=text)).wrench.base_links]
    assert names == ["base", "world", "pedestal"]
    meant = hypotheses(replace(found, axes="sensor"))
    tried = {setting for each in meant for setting in each.settings}
    assert {"wrench.axes: base", "wrench.axes: pedestal"} <= tried
    # A wrench along the pedestal's z is one along that in the world.
    reduction = WrenchReduction(found, Scene(), (0.0, 0.0, 0.0))
    on_peg = reduction.on_peg((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), np.zeros(3), np.zeros(3))
    along = Rotation.from_euler("xyz", [0.5, 0.0, 0.3]).apply([0.0, 0.0, 1.0])
    assert on_peg[:3] == pytest.approx(along)


def test_a_link_that_the_tip_carries_has_the_axes_of_the_sensor():
    there = OPTIONS.tip_frame, "flange"
    (_, R_T, _), (_, R_F, _) = (Arm(tip=name).tip(dict.fromkeys(JOINTS, 0.3)) for name in there)
    on_tip = 2.0, 0.3, 0.4
    expected = (R_T * Rotation.from_euler("xyz", on_tip)).inv() * R_F
    found = described(with_axes("flange", peg_rpy=on_tip))
    turn = Rotation.from_euler("xyz", found.wrench.sensor_rpy).inv() * expected
    assert turn.magnitude() < 1e-8 and found.wrench.base_rpy is None
    assert described(found) == found
    # The place of the sensor is that of its frame_id still.
    placed = replace(found, wrench=replace(found.wrench, sensor_pose="frame_id"))
    mounted = mounting(placed, "ft_sensor").wrench
    assert mounted.sensor_rpy == found.wrench.sensor_rpy
    sensor = mounting(replace(cell(peg_rpy=on_tip), wrench=WrenchInput()), "ft_sensor").wrench
    assert mounted.sensor_xyz == sensor.sensor_xyz != WrenchInput().sensor_xyz
    with pytest.raises(
        PegOnHoleError, match="sensor_rpy = .* is not that of wrench.axes: 'flange'"
    ):
        described(with_axes("flange", sensor_rpy=(0.0, 0.0, 1.0)))


def test_axes_of_no_link_or_of_one_that_moves_are_refused():
    there = (
        "pedestal, base, shoulder, upper_arm, upper_roll, forearm, forearm_roll, wrist, flange, "
    )
    match = (
        f"'tool0' is neither sensor nor base, nor a link of .*; it has: {there}ft_sensor and 4 "
    )
    with pytest.raises(PegOnHoleError, match=match):
        described(with_axes("tool0"))
    with pytest.raises(PegOnHoleError, match="'forearm' is a link that moves against the root"):
        described(with_axes("forearm"))
    for axes in ("flange", ""):
        with pytest.raises(PegOnHoleError, match=f"wrench.axes = '{axes}' is not one of sensor"):
            from_parameters({"wrench.axes": axes})


def test_the_payload_is_found_of_numbers_in_the_base(tmp_path):
    path = tmp_path / "poses.mcap"
    arm_poses(path, replace(OPTIONS, hole_rpy=LEANS), in_base=True)
    config, out = parameters_file(tmp_path / "c.yaml", with_axes("pedestal")), tmp_path / "o.yaml"
    arguments = ["calibrate", path, "--payload", "--config", config, "--out", out]
    assert main([str(a) for a in arguments]) == 0
    found = yaml.safe_load(out.read_text())["peg_on_hole"]["ros__parameters"]["wrench"]
    assert found["axes"] == "pedestal"
    assert found["payload_mass"] == pytest.approx(MASS, abs=0.01)
    assert found["bias_force"] == pytest.approx(BIAS[:3], abs=0.1)
    assert found["bias_torque"] == pytest.approx(BIAS[3:], abs=0.01)


def test_the_payload_is_found_below_a_hole_that_leans(bag, tmp_path, capsys):
    config, out = parameters_file(tmp_path / "c.yaml", cell()), tmp_path / "found.yaml"
    arguments = ["calibrate", bag, "--payload", "--config", config, "--out", out]
    assert main([str(a) for a in arguments]) == 0
    assert "scene.gravity" not in capsys.readouterr().out
    found = yaml.safe_load(out.read_text())["peg_on_hole"]["ros__parameters"]
    # Three times their intervals.
    assert found["wrench"]["payload_mass"] == pytest.approx(MASS, abs=0.01)
    assert found["wrench"]["bias_force"] == pytest.approx(BIAS[:3], abs=0.1)
    assert found["scene"]["gravity"] == list(Scene().gravity)


def test_a_calibration_names_gravity_that_contradicts(bag, tmp_path, capsys):
    wrong = cell(gravity=(0.0, 0.0, -9.81))
    config, out = parameters_file(tmp_path / "c.yaml", wrong), tmp_path / "found.yaml"
    arguments = ["calibrate", bag, "--payload", "--config", config, "--out", out]
    assert main([str(a) for a in arguments]) == 0
    assert "scene: scene.gravity is 25.0 degrees off the robot's" in capsys.readouterr().out


@pytest.mark.parametrize("gravity", [None, (0.0, 0.0, -9.81)])
def test_a_replay_names_it_first_and_is_silent_where_they_agree(bag, tmp_path, capsys, gravity):
    weight = replace(cell(gravity=gravity), wrench=replace(AS_STATED, payload_mass=MASS))
    config, out = parameters_file(tmp_path / "c.yaml", weight), tmp_path / "out.mcap"
    assert main(["replay", str(bag), "--config", str(config), "--out", str(out)]) == 0
    lines = capsys.readouterr().out.splitlines()
    named = [line for line in lines if line.startswith(("scene:", "wrench:", "joints:"))]
    assert any("scene.gravity" in line for line in named) == (gravity is not None)
    if gravity is not None:
        assert named[0].startswith("scene: scene.gravity is 25.0 degrees off the robot's")
    stored = Bag(out).metadata["peg_on_hole_configuration"]["scene.gravity"]
    assert json.loads(stored) == list(gravity or Scene().gravity)
    assert stored_configuration(Bag(out)).scene.gravity == (gravity or Scene().gravity)


def test_a_link_for_gravity_that_is_none_ends_a_replay_in_one_line(bag, tmp_path, capsys):
    config = parameters_file(tmp_path / "c.yaml", cell(gravity_link="floor"))
    message = (
        f"joints.gravity_link = 'floor' is no link of {URDF}; it has: pedestal, base, shoulder, "
        "upper_arm, upper_roll, forearm, forearm_roll, wrist, flange, ft_sensor and 4 more"
    )
    fails(capsys, 2, message, "replay", bag, "--config", config)
