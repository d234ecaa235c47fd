"""The package builds with colcon, and what it installs starts."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from simulated import ROOT


@pytest.fixture(scope="module")
def install_space(tmp_path_factory):
    base = tmp_path_factory.mktemp("colcon")
    environment = {
        name: value
        for name, value in os.environ.items()
        # A child of another wheel environment would load this one's libraries.
        if name not in ("_ROS_WHEELS_BOOTSTRAP_COMPLETE", "LD_LIBRARY_PATH", "PYTHONPATH")
    }
    environment["AMENT_PREFIX_PATH"] = sys.prefix
    environment["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{environment['PATH']}"
    command = [
        *(sys.executable, "-m", "colcon", "--log-base", base / "log", "build"),
        *("--paths", ROOT, "--build-base", base / "build", "--install-base", base / "install"),
    ]
    build = subprocess.run(command, cwd=base, env=environment, capture_output=True, text=True)
    assert build.returncode == 0, build.stdout + build.stderr
    return base / "install" / "peg_on_hole_ros", environment


def test_installs_what_ros_looks_for(install_space):
    prefix, _ = install_space
    share = prefix / "share"
    assert (share / "ament_index/resource_index/packages/peg_on_hole_ros").is_file()
    assert (share / "peg_on_hole_ros/package.xml").is_file()
    assert (share / "peg_on_hole_ros/launch/peg_on_hole.launch.py").is_file()
    for name in ("peg_on_hole", "peg-on-hole"):
        assert os.access(prefix / "lib/peg_on_hole_ros" / name, os.X_OK)
    assert list(prefix.rglob("ros/fastdds_local.xml"))
    assert list(prefix.rglob("peg_on_hole_ros/py.typed"))
    page = {path.name for path in prefix.rglob("report/page/*")}
    assert {"style.css", "plots.js", "drawing.js", "page.js", "licences.txt"} <= page


def test_pip_installs_what_a_page_is_made_of(tmp_path):
    # The step of a wheel that gathers what belongs to the packages.
    command = [sys.executable, "setup.py", "-q", "build_py", "--build-lib", tmp_path]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    folder = Path("peg_on_hole_ros", "report", "page")
    kept = {path.name: path.read_bytes() for path in (ROOT / folder).iterdir()}
    assert {path.name: path.read_bytes() for path in (tmp_path / folder).iterdir()} == kept


def installed(install_space, name, *arguments):
    """Run an installed executable as `ros2 run` does, with the install space sourced."""
    prefix, environment = install_space
    environment = environment | {
        "PYTHONPATH": str(next(prefix.glob("lib/python3*/site-packages")))
    }
    command = [prefix / "lib/peg_on_hole_ros" / name, *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120)


def test_installed_node_starts(install_space):
    # It gets as far as its own check of the parameters, from the installed copy.
    run = installed(install_space, "peg_on_hole", "--ros-args", "-p", "scene.friction:=3.0")
    assert run.stderr.splitlines() == [
        "peg-on-hole: error: scene.friction = 3 is not within 0 to 2; the default is 0.2"
    ]
    assert run.returncode == 2
