"""How `peg-on-hole node` and `ros2 run` take their arguments, and which they refuse."""

import subprocess
import sys

import pytest
from rcl_interfaces.srv import GetParameters

from cli_helpers import ROOT, command, config, fails
from dds_peer import Peer

pytestmark = pytest.mark.xdist_group("dds_starts")

ADVICE = (
    "what is for ROS stands behind --ros-args, as in --ros-args --params-file CONFIG "
    "-p scene.friction:=0.3; `peg-on-hole node` takes --config CONFIG too"
)


def friction_of(*arguments):
    """Start `peg-on-hole node`, ask it for scene.friction and scene.peg_mass, and end it."""
    started = [sys.executable, "-m", "peg_on_hole_ros.cli.main", "node", *map(str, arguments)]
    node, peer = subprocess.Popen(started, cwd=ROOT), Peer()
    try:
        request = GetParameters.Request(names=["scene.friction", "scene.peg_mass"])
        return [value.double_value for value in peer.ask("get_parameters", request).values]
    finally:
        node.kill()
        node.wait()
        peer.close()


def test_config_is_a_parameters_file_for_ros_which_single_values_override(tmp_path):
    path = config(tmp_path, "scene: {friction: 0.31, peg_mass: 0.7}\n    autostart: false")
    found = friction_of("--config", path, "--ros-args", "-p", "scene.friction:=0.4")
    assert found == [0.4, 0.7]


def test_config_is_looked_through_as_by_every_other_command(tmp_path, capsys):
    path = config(tmp_path, "scene: {frction: 0.3}")
    message = (
        f"{path}, line 3: unknown parameter 'scene.frction'; the nearest are: scene.friction, "
        "scene.friction_stddev, scene.friction_k_stddev, filter.friction"
    )
    fails(capsys, 2, message, "node", "--config", path)
    fails(capsys, 2, "there is no configuration file no.yaml", "node", "--config", "no.yaml")


@pytest.mark.nightly
def test_config_of_another_name_is_refused_by_the_node(tmp_path):
    path = config(tmp_path, "scene: {friction: 0.3}")
    done = command("node", "--config", path, "--ros-args", "-r", "__node:=left")
    assert done.returncode == 2
    assert f"{path} has parameters for /peg_on_hole, but this node is /left" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "found"),
    [
        pytest.param(
            ["--params-file", "x.yaml"], "--params-file x.yaml", marks=pytest.mark.nightly
        ),
        (["--ros-args", "-p", "autostart:=false", "--", "x.yaml"], "x.yaml"),
    ],
)
def test_arguments_that_ros_would_pass_over_are_refused(arguments, found):
    done = command("node", *arguments)
    assert done.stderr == f"peg-on-hole: error: unknown arguments: {found}; {ADVICE}\n"
    assert done.returncode == 2


def test_ros2_run_refuses_them_too():
    done = subprocess.run(
        [sys.executable, "-m", "peg_on_hole_ros.ros.node", "--config", "x.yaml"],
        capture_output=True,
        text=True,
        cwd=ROOT,
        timeout=60,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"peg-on-hole: error: unknown arguments: --config x.yaml; {ADVICE}\n"


def test_a_file_that_is_not_there_is_told_without_what_ros_logs():
    done = command("node", "--ros-args", "--params-file", "none.yaml")
    assert done.stderr == "peg-on-hole: error: there is no configuration file none.yaml\n"
    assert done.returncode == 2
