"""Plans: what a file may say, and what is told about mistakes."""

import copy
from dataclasses import replace

import pytest

from peg_on_hole_ros.cli.simulation_file import read_plan
from peg_on_hole_ros.config.options import Configuration, JointInput
from peg_on_hole_ros.config.parameters_file import read_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.sim.command import evaluate
from peg_on_hole_ros.sim.plan import (
    _TOP,
    Holder,
    PlanPhase,
    holder_program,
    plan_from_tree,
)
from peg_on_hole_ros.sim.truth import integrate
from simulated import ROOT, SAMPLES, plan

TREE = {
    "holder": {"stiffness": 2.0e4},
    "start": {"angles": [0.3, 0.0, 0.0]},
    "phases": {
        "press": {"kind": "contact", "duration": 0.2, "rates": [0.0, 0.0, 1.0]},
        "close": {"kind": "contact", "duration": 0.5, "rates": [-0.1, 0.0, 1.0]},
        "go_on": {"kind": "contact", "duration": 0.5, "angles": [0.2, 0.5, 1.5]},
    },
}


def changed(path, value):
    tree = copy.deepcopy(TREE)
    *groups, last = path.split("/")
    place = tree
    for group in groups:
        place = place[group]
    place[last] = value
    return tree


@pytest.mark.parametrize(
    "path, value, message",
    [
        ("sead", 1, "unknown parameter 'simulation.sead'; the nearest are: seed"),
        ("seed", 1.5, "simulation.seed = 1.5 is not an integer within 0 to 4294967295"),
        ("holder/stifness", 1.0, "'simulation.holder.stifness'; the nearest are: stiffness"),
        ("holder/stiffness", 1.0, "holder.stiffness = 1.0 N/m is not a number within 100 to 1e"),
        ("holder", 3, "simulation.holder = 3 is a value, but it is a group of names"),
        ("start", {}, "simulation.start.angles is missing"),
        ("start/angles", [2.0, 0.0, 0.0], "start.angles.0. = 2 rad, the tilt gamma, is not betw"),
        ("start/angles", [0.0, 0.0, 0.0], "start.angles.0. = 0 rad, the tilt gamma, is not betw"),
        ("start/angles", [-0.3, 0.0, 0.0], "between 0 and 1.5708 rad, both excluded: angles are"),
        ("start", 3, "simulation.start = 3 is a value, but it is a group of names"),
        ("start/load", [5.0, 5.0], "'simulation.start.load'; the nearest are: angles, rates, off"),
        ("phases", {}, "simulation.phases = {} is no group of phases: it has the name of at leas"),
        ("phases", ["a"], "simulation.phases = .'a'. is no group of phases"),
        ("phases/close/kind", ["free"], "close.kind = .'free'. is not one of free, contact, lift"),
        ("phases/close/duration", float("nan"), "duration = nan s is not a number within 0.001"),
        ("phases/close/duration", "1 s", "close.duration = '1 s' is not a number within 0.001 to"),
        ("phases/close/duration", 5000, "5000 s is not .* to 1000 s; times are in seconds: 10 ms"),
        ("phases/close/offset", [0.0, 0.0, 2.0], "to 0.5 m; lengths are in metres: 1 mm is 0.001"),
        ("phases/go_on/angles", [100.0, 0.0, 0.0], "go_on.angles.0. = 100 rad, which is not a ti"),
        ("phases/go_on/angles", [-0.1, 0.0, 0.0], "-0.1 rad, which is not a tilt from 0 to below"),
        ("phases/close/rates", [9.0, 0.0, 1.0], "close leads through gamma = 2.55 rad, which is "),
        ("phases/close/rates", [-9.0, 0.0, 1.0], "close leads through gamma = -1.95 rad, which i"),
        (
            "phases/go_on/angles",
            [0.2, 0.5, 90.0],
            "go_on turns phi at up to 334.8 rad/s, which is",
        ),
        ("start/angles", [0.06, 0.0, 0.0], "press begins in contact at gamma = 0.06 rad, but a p"),
        ("phases/close/kind", "slide", "close.kind = 'slide' is not one of free, contact, lift_o"),
        ("phases/close", {"kind": "contact"}, "simulation.phases.close.duration is missing"),
        ("phases/close/duration", -1.0, "close.duration = -1.0 s is not a number within 0.001"),
        ("phases/close/rates", [1.0], "close.rates = .* is not 3 numbers"),
        ("phases/close/rates", [0.0, 0.0, 1e9], "close.rates.2. = 1000000000.0 rad/s is not a nu"),
        ("phases/close/load", [5.0, 5.0], "close.load is for two_point; elsewhere the reactions"),
        ("phases/press/kind", "two_point", "close: contact does not follow two_point"),
        ("joint_rate", 300, "wrench_rate = 1000 Hz is not a multiple of joint_rate = 300 Hz"),
        ("lead_in", 1.2, "lead_in = 1.2 s leaves nothing of the 1.2 s that the phases last"),
        ("rtol", float("nan"), "simulation.rtol = nan is not a number within"),
    ],
)
def test_mistakes_are_told(path, value, message):
    with pytest.raises(PegOnHoleError, match=message):
        plan_from_tree(Configuration(), changed(path, value))


def test_two_point_does_not_follow_free():
    tree = changed("phases/press/kind", "free")
    tree["phases"]["close"]["kind"] = "two_point"
    with pytest.raises(PegOnHoleError, match="close: two_point does not follow free"):
        plan_from_tree(Configuration(), tree)


@pytest.mark.parametrize("kind", ["free", "two_point"])
def test_a_guided_peg_is_not_led_through_upright(kind):
    tree = changed("phases/go_on", {"kind": kind, "duration": 0.5, "rates": [-2.0, 0.0, 1.0]})
    tree["phases"]["close"]["kind"] = "lift_off" if kind == "free" else "two_point"
    with pytest.raises(PegOnHoleError, match="go_on leads through gamma = -0.2[0-9]* rad, which"):
        plan_from_tree(Configuration(), tree)
    tree["phases"]["go_on"] = {"kind": kind, "duration": 0.5, "angles": [0.0, 0.5, 1.5]}
    plan_from_tree(Configuration(), tree)


def test_a_free_peg_is_not_set_down_below_gamma0():
    tree = changed("phases/press", {"kind": "free", "duration": 0.5, "angles": [0.05, 0.0, 0.0]})
    with pytest.raises(
        PegOnHoleError,
        match=r"close begins in contact at gamma = 0.05 rad, but a peg rests on three contacts "
        r"above gamma0 = 0.0632\d* rad only",
    ):
        plan_from_tree(Configuration(), tree)


def test_a_motion_beyond_all_bounds_is_told():
    tree = changed("start/offset", [0.0, 0.0, -0.001]) | {"lead_in": 0.1}
    tree["phases"] = {"fling": {"kind": "contact", "duration": 1.0}}
    plain = plan_from_tree(Configuration(), tree)
    rates = (90.0, 0.0, 0.0)
    flung = replace(
        plain,
        start=replace(plain.start, rates=rates),
        phases=(replace(plain.phases[0], rates=rates),),
    )
    with pytest.raises(PegOnHoleError, match="no finite acceleration after 0.01.* slow the phase"):
        integrate(flung)


def test_robot_joints_are_not_simulated():
    configuration = Configuration(joints=JointInput(source="robot"))
    with pytest.raises(PegOnHoleError, match="joints.source = robot is not simulated"):
        plan_from_tree(configuration, TREE)


def test_program_meets_the_phases_and_is_smooth():
    knots, pieces = holder_program(plan_from_tree(Configuration(), TREE))
    assert knots.tolist() == [0.0, 0.2, 0.7, 1.2]
    # Without angles a phase goes on at the mean of the rates at its ends.
    assert evaluate(knots, pieces, 0.7)[0, :3] == pytest.approx([0.275, 0.0, 0.6], abs=1e-12)
    assert evaluate(knots, pieces, 1.2)[0, :3] == pytest.approx([0.2, 0.5, 1.5], abs=1e-12)
    assert evaluate(knots, pieces, 1.2)[1, :3] == pytest.approx(0, abs=1e-12)
    for knot in knots[1:-1]:
        before, after = (evaluate(knots, pieces, knot + d) for d in (-1e-9, 1e-9))
        # Jerk times 2 ns.
        assert before == pytest.approx(after, abs=1e-6)


def test_a_file_without_a_simulation_says_so(tmp_path):
    path = tmp_path / "only_filter.yaml"
    path.write_text("peg_on_hole:\n  ros__parameters:\n    scene: {friction: 0.3}\n")
    with pytest.raises(PegOnHoleError, match="only_filter.yaml has no part 'simulation:' with"):
        read_plan(path)


def test_a_mistake_in_a_file_names_the_file(tmp_path):
    text = (ROOT / "config" / "closing_with_slip.yaml").read_text()
    path = tmp_path / "wrong.yaml"
    path.write_text(text.replace("lead_in", "leadin"))
    with pytest.raises(PegOnHoleError, match="wrong.yaml: unknown parameter 'simulation.leadin'"):
        read_plan(path)


def test_a_list_by_which_ros_refuses_the_file_is_refused_here_too(tmp_path):
    text = (ROOT / "config" / "closing_with_slip.yaml").read_text()
    path = tmp_path / "wrong.yaml"
    path.write_text(text.replace("angles: [0.186, 0.0, 0.0]", "angles: [0.186, 0, 0.0]"))
    with pytest.raises(PegOnHoleError) as caught:
        read_plan(path)
    assert str(caught.value) == (
        f"{path}: simulation.start.angles = [0.186, 0, 0.0] has values of several types, for "
        "which ROS 2 does not read the file; a double needs its point (0.0, not 0)"
    )


@pytest.mark.parametrize("name", SAMPLES)
def test_sample_files_state_the_papers_scene(name):
    scene = plan(name).configuration.scene
    assert (scene.hole_diameter, scene.peg_diameter, scene.peg_height) == (0.05, 0.0499, 0.07)
    assert (scene.friction, scene.peg_mass) == (0.2, 0.5)
    assert read_parameters(ROOT / "config" / f"{name}.yaml")["wrench.force_stddev"] == 0.2


@pytest.mark.parametrize("name", (*SAMPLES, "insertion"))
def test_ros_takes_the_sample_files(name):
    rclpy = pytest.importorskip("rclpy")
    context = rclpy.Context()
    file = str(ROOT / "config" / f"{name}.yaml")
    rclpy.init(args=["--ros-args", "--params-file", file], context=context)
    try:
        node = rclpy.create_node(
            "peg_on_hole", context=context, automatically_declare_parameters_from_overrides=True
        )
        assert node.get_parameter("scene.peg_diameter").value == 0.0499
        node.destroy_node()
    finally:
        rclpy.shutdown(context=context)


def test_every_key_is_documented():
    text = (ROOT / "docs" / "simulation.md").read_text()
    keys = {*_TOP, *PlanPhase.__dataclass_fields__} - {"name", "holder", "phases"}
    keys |= {f"holder.{name}" for name in Holder.__dataclass_fields__}
    assert [key for key in sorted(keys) if f"`{key}`" not in text] == []
