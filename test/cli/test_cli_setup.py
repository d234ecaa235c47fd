"""`peg-on-hole setup`: a cell on its first day, by its recordings and by answers."""

import os
import pty
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from benchmarks.setup_cell import FORCE_STDDEV, JOINT_STDDEV, PAYLOAD_COM, PAYLOAD_MASS, ZERO
from cli_helpers import ROOT, fails
from hand_bags import MASS, POSES, poses, presses
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.parameters_file import read_parameters
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy
from tiers import nightly

pytest.importorskip("pinocchio")
CELL = ROOT / "bags" / "setup_cell"
STATED, URDF = CELL / "stated.yaml", ROOT / "config" / "cell_ur_like.urdf"
BY_HAND = ("presses", "poses", "hang")
DIAMETERS_50 = (
    "--set", "scene.hole_diameter=50 mm", "--set", "scene.peg_diameter=49.9 mm"
)  # fmt: skip
DIAMETERS = ("--set", "scene.hole_diameter=30 mm", "--set", "scene.peg_diameter=29.9 mm")


def recordings(*kinds):
    return [word for kind in kinds for word in (f"--{kind}", CELL / f"{kind}.mcap")]


def setup(out, *arguments):
    return main([str(word) for word in ("setup", "--yes", "--out", out, *arguments)])


def known(out):
    """Return how each setting of a file is known, as the line above it says."""
    found, group, how = {}, "", ""
    for line in out.read_text(encoding="utf-8").splitlines():
        indent, word = len(line) - len(line.lstrip()), line.strip()
        if word.startswith("# known: "):
            how = word.removeprefix("# known: ")
        elif indent == 4 and word.endswith(":"):
            group = word.replace(":", ".")
        elif indent >= 4 and not word.startswith("#"):
            found[f"{group if indent == 6 else ''}{word.partition(':')[0]}"] = how
    return found


def check_wrench(found):
    """What three presses, four poses and a hanging peg have to tell, within their bounds."""
    assert found["wrench.acts_on"] == "robot" and found["wrench.axes"] == "base"
    assert found["topics.wrench"] == "/ft_raw/wrench"
    assert found["wrench.payload_mass"] == pytest.approx(PAYLOAD_MASS, abs=0.01)
    # Some four standard deviations, of four poses of 0.6 s.
    assert np.allclose(found["wrench.payload_com"], PAYLOAD_COM, atol=0.001)
    assert np.allclose(found["wrench.bias_force"], ZERO[:3], atol=0.1)
    assert np.allclose(found["wrench.bias_torque"], ZERO[3:], atol=0.01)
    # By 1500 wrenches and 375 joint states to some per cent.
    assert found["wrench.force_stddev"] == pytest.approx(FORCE_STDDEV, rel=0.1)
    assert found["joints.position_stddev"] == pytest.approx(JOINT_STDDEV, rel=0.15)


def test_recordings_of_the_first_day_become_settings_that_say_how_they_are_known(tmp_path, capsys):
    out = tmp_path / "cell.yaml"
    assert setup(out, "--config", STATED, *recordings(*BY_HAND)) == 0
    check_wrench(read_parameters(out))
    told, text = known(out), capsys.readouterr().out
    # Every setting of the file has its line.
    body = yaml.safe_load(out.read_text())["peg_on_hole"]["ros__parameters"]
    count = sum(len(value) if isinstance(value, dict) else 1 for value in body.values())
    assert len(re.findall("# known: ", out.read_text())) == count
    pressed = "measured: three presses of 13, 13, 13 N in presses.mcap"
    assert told["wrench.acts_on"].startswith(pressed)
    assert re.match(
        r"measured: \+- 0.00\d+ kg, 4 still poses in poses.mcap", told["wrench.payload_mass"]
    )
    assert (
        told["joints.hole_rpy"] == f"stated: by {STATED}" and told["filter.max_gap"] == "default"
    )
    assert told["joints.names"] == "follows: they move tool0"
    assert told["joints.delay"].startswith("not known: record it and give --run: ros2 bag record")
    gravity = re.search(
        r"from -z of base_link.* degrees off it, which is ([0-9.]+) N: it fits",
        told["scene.gravity"],
    )
    assert float(gravity[1]) < 0.1
    left = re.search(r"hang.mcap differs from it by ([0-9.]+) N", told["wrench.bias_force"])
    assert float(left[1]) < 0.1
    # What is missing is no error, and is told last.
    assert re.findall(r"^not known: (\S+): ", text, re.M) == ["joints.delay"]
    assert text.splitlines()[-1].startswith("1 setting is not known (above)")
    # The table says the same as the file.
    for name in ("wrench.acts_on", "scene.gravity", "wrench.payload_mass", "wrench.bias_force"):
        row = re.search(rf"^{re.escape(name)} .*$", text, re.M)[0]
        assert row.endswith(told[name])


def test_an_insertion_is_explained_to_2_newtons(tmp_path, capsys):
    out = tmp_path / "cell.yaml"
    assert setup(out, "--config", STATED, "--from", CELL) == 0
    text, told = capsys.readouterr().out, known(out)
    for name in ("N_K", "N_B1", "N_B2"):
        row = re.search(rf"^{name} +N +([0-9.]+)", text, re.M)
        assert float(row[1]) < 2.0
    flag = re.search(r"flagged (\d+) ms after", text)
    assert int(flag[1]) < 20
    for name in ("joints.hole_rpy", "joints.hole_xyz"):
        assert "it fits: run.mcap ends 12.8 mm down the hole" in told[name]


def test_the_hole_is_found_where_a_run_ends_in_it(tmp_path):
    out = tmp_path / "cell.yaml"
    stated = read_parameters(STATED)
    given = [
        word
        for name, value in stated.items()
        if "hole_" not in name or name == "scene.hole_diameter"
        if name != "joints.urdf"
        for word in ("--set", f"{name}={value}")
    ]
    # That the hole leans by 22 degrees from where it is taken at first costs nothing.
    assert setup(out, "--urdf", URDF, *given, *recordings(*BY_HAND, "run")) == 0
    found = read_parameters(out)
    check_wrench(found)
    is_, was = (rotation_from_rpy(each["joints.hole_rpy"])[:, 2] for each in (found, stated))
    # 0.1 mm over 13 mm.
    assert np.degrees(np.arccos(is_ @ was)) < 0.5
    assert np.allclose(found["joints.hole_xyz"], stated["joints.hole_xyz"], atol=1e-3)
    assert known(out)["joints.hole_rpy"].startswith("measured: +- 0.4")


def test_a_touched_plate_gives_the_direction_of_the_hole(tmp_path):
    out, stated = tmp_path / "cell.yaml", read_parameters(STATED)
    names = "joints.peg_xyz", "joints.peg_rpy", "joints.hole_xyz"
    given = [word for name in names for word in ("--set", f"{name}={stated[name]}")]
    assert setup(out, "--urdf", URDF, *DIAMETERS, *given, *recordings("plate")) == 0
    is_, was = (
        rotation_from_rpy(each["joints.hole_rpy"])[:, 2] for each in (read_parameters(out), stated)
    )
    # Of touches 80 mm apart that are right to some micrometres.
    assert np.degrees(np.arccos(is_ @ was)) < 0.05
    assert known(out)["joints.hole_rpy"].startswith("measured: +- 0.14 degrees, 4 touches")
    assert "it fits 4 touches of the plate in plate.mcap" in known(out)["joints.hole_xyz"]


def test_touches_along_one_line_tell_no_plate(tmp_path, capsys):
    out = tmp_path / "cell.yaml"
    assert setup(out, "--config", STATED, "--plate", CELL / "presses.mcap") == 2
    error = capsys.readouterr().err.splitlines()[-1]
    assert "press with 10 N for a second at three or more places of the plate around the" in error
    assert "the recording has 3 presses that do not suffice" in error


@pytest.mark.parametrize(
    ("stated", "name", "remedy"),
    [
        ("scene.gravity=0,2,-9.6", "scene.gravity", "take scene.gravity out, or correct the hole"),
        *nightly(("joints.gravity_link=ft_sensor", "", "name one that stands still")),
    ],
)
def test_gravity_that_contradicts_is_told_with_the_way_out(tmp_path, capsys, stated, name, remedy):
    out = tmp_path / "cell.yaml"
    assert setup(out, "--config", STATED, "--set", stated, *recordings(*BY_HAND)) == 2
    error = capsys.readouterr().err.splitlines()[-1]
    assert name in error and remedy in error
    if name:
        assert f"{out} is written, but a setting is contradicted: scene.gravity" in error
        assert "CONTRADICTED" in known(out)["scene.gravity"]


@pytest.mark.parametrize(
    ("stated", "kinds", "told"),
    [
        (
            "scene.peg_mass=3.5",
            BY_HAND,
            "scene.peg_mass: weigh the peg: 4 still poses in poses.mcap weigh 1.15 kg in all, "
            "less than the peg of 3.5 kg",
        ),
        (
            "wrench.gravity=compensated",
            BY_HAND,
            "wrench.gravity: state measured: the wrench contains the weight, as the force "
            "changes by [0-9.]+ N between 4 still poses in poses.mcap",
        ),
        (
            "joints.peg_rpy=0,0,0",
            (),
            "the peg points away from the hole; the tip's -z is nearest to the hole's axis in "
            r"presses.mcap, off by \d+ degrees: .* would fit",
        ),
        *nightly(
            (
                "joints.peg_rpy=3.14159,0,1",
                BY_HAND,
                "wrench.axes: state wrench.axes: base; .*: still poses in poses.mcap are "
                "[0-9.]+ N from any weight and bias, and 0.0[0-9]+ N with base",
            )
        ),
    ],
)
def test_a_wrong_setting_is_the_first_that_is_told(tmp_path, capsys, stated, kinds, told):
    given = ["--config", STATED, "--set", stated, *recordings(*kinds or ("presses",))]
    assert setup(tmp_path / "cell.yaml", *given) == 2
    error = capsys.readouterr().err.splitlines()[-1]
    assert re.search(told, error)
    # Of a cause nothing else is told that comes of it.
    assert "more, above" not in error


def test_a_root_link_that_leans_is_told_by_the_weight_of_poses(tmp_path, capsys):
    """An arm on a wall, whose root link's z is not up."""
    urdf = tmp_path / "wall.urdf"
    text = URDF.read_text(encoding="utf-8").replace(
        '<link name="base_link"/>',
        '<link name="wall"/><joint name="mount" type="fixed"><parent link="wall"/>'
        '<child link="base_link"/><origin xyz="0 0 0" rpy="0.5 0 0"/></joint>'
        '<link name="base_link"/>',
    )
    urdf.write_text(text, encoding="utf-8")
    # The hole lies as it did to the arm, which the wall turns by 0.5 about x.
    hole = Rotation.from_euler("x", 0.5) * Rotation.from_euler("xyz", [0.3, 0.25, 0.6])
    turned = "--set", f"joints.hole_rpy={hole.as_euler('xyz').tolist()}", "--urdf", urdf
    out = tmp_path / "cell.yaml"
    assert setup(out, "--config", STATED, *turned, *recordings("presses", "poses")) == 2
    error = capsys.readouterr().err.splitlines()[-1]
    off = re.search(r"is ([0-9.]+) \+- [0-9.]+ degrees off it", error)
    assert float(off[1]) == pytest.approx(np.degrees(0.5), abs=1.0)
    assert "set joints.gravity_link: base_link" in error


@pytest.mark.parametrize("kinds", [("plate",), (*BY_HAND, "run")])
def test_a_hole_that_is_stated_upright_is_told(tmp_path, capsys, kinds):
    out = tmp_path / "cell.yaml"
    upright = "--set", "joints.hole_rpy=0,0,0"
    assert setup(out, "--config", STATED, *upright, *recordings(*kinds)) == 2
    error = capsys.readouterr().err.splitlines()[-1]
    found = re.search(r"joints.hole_rpy: set \[([^]]*)\], unless", error)
    rpy = [float(x) for x in found[1].split(",")]
    # Up the hole as the cell was made; how it is turned about that nobody sees.
    was = rotation_from_rpy([0.30, 0.25, 0.6])[:, 2]
    assert np.degrees(np.arccos(rotation_from_rpy(rpy)[:, 2] @ was)) < 0.5


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (
            [*DIAMETERS, *recordings("presses")],
            2,
            "no robot: name its description with --urdf FILE (or topic, where a recording has "
            "/robot_description), or state --set joints.source=peg for a peg that has joint "
            "states of its own",
        ),
        (
            ["--urdf", URDF],
            2,
            "gauge bore and shank, and state scene.hole_diameter and scene.peg_diameter, such as "
            "--set scene.hole_diameter=30.00mm: no recording measures the diameters",
        ),
        (
            ["--config", STATED, "--poses", CELL / "hang.mcap"],
            2,
            f"{CELL}/hang.mcap: tilt the peg by 20 degrees and more between still poses: 1 with "
            "one direction of gravity in the sensor's axes do not distinguish weight from bias",
        ),
        (
            ["--config", STATED, "--presses", CELL / "hang.mcap"],
            2,
            f"{CELL}/hang.mcap: push the still peg up at its lower end, then along its x, then "
            "along its y, with 5 N and more for 0.3 s and more, and a pause between: the "
            "recording has 0 such presses, not 3",
        ),
        (["--config", STATED, "--run", CELL / "no.mcap"], 3, f"there is no bag {CELL}/no.mcap"),
        (
            ["--config", STATED, "--set", "scene.peg_mass"],
            2,
            "--set scene.peg_mass is not NAME=VALUE, such as scene.peg_mass=0.35",
        ),
        (
            ["--config", STATED, "--set", "joints.tip_frame=tool"],
            2,
            "joints.tip_frame = 'tool' is no link; there are: base_link, link_1, link_2, link_3, "
            "link_4, link_5, link_6, ft_sensor, tool0",
        ),
    ],
)
def test_what_is_missing_or_wrong_is_told_in_one_line(tmp_path, capsys, arguments, code, message):
    out = tmp_path / "cell.yaml"
    fails(capsys, code, message, "setup", "--yes", "--out", out, *arguments)
    assert not out.exists()


def test_a_name_that_does_not_exist_lists_the_nearest(tmp_path, capsys):
    assert setup(tmp_path / "c.yaml", "--set", "scene.hole_diametre=1") == 2
    assert "scene.hole_diameter" in capsys.readouterr().err


def test_presses_that_fit_neither_the_sensors_link_nor_another_name_the_pegs_axes(
    tmp_path, capsys
):
    """The link that frame_id names has the sensor's axes more exactly than a hand does."""
    urdf, out = tmp_path / "arm.urdf", tmp_path / "cell.yaml"
    urdf.write_text(URDF.read_text().replace('"ft_sensor"', '"ft_raw"'))
    turned = "--set", f"joints.urdf={urdf}", "--set", "joints.peg_rpy=3.14159,0.4,0.3"
    assert setup(out, *DIAMETERS, *turned, *recordings("presses", "poses")) == 2
    assert "a setting is contradicted: joints.peg_rpy" in capsys.readouterr().err
    assert "wrench.sensor_rpy" not in known(out) or "follows" in known(out)["wrench.sensor_rpy"]
    right = "--set", f"joints.urdf={urdf}", "--set", "joints.peg_rpy=3.14159,0,0"
    assert setup(out, *DIAMETERS, *right, *recordings("presses", "poses")) == 0
    assert read_parameters(out)["wrench.axes"] == "base"


def test_a_peg_with_joints_of_its_own_needs_no_robot(tmp_path):
    presses(tmp_path / "presses.mcap", (0.0, 0.0, 0.0), "robot")
    poses(tmp_path / "poses.mcap", POSES, -1.0)
    out = tmp_path / "cell.yaml"
    own = "--set", "joints.source=peg", "--from", tmp_path
    assert setup(out, *own, *DIAMETERS_50) == 0
    found = read_parameters(out)
    assert found["wrench.acts_on"] == "robot" and found["wrench.axes"] == "sensor"
    assert found["wrench.payload_mass"] == pytest.approx(MASS, abs=0.05)


ANSWERS = [
    "nowhere.urdf",  # asked again
    str(URDF),
    "tool",  # asked again
    "",  # the tip that is proposed
    "0 0 55 mm",
    "180 0 0 deg",
    "thirty",  # asked again
    "30 mm",
    "29900 um",
    "60 mm",
    "350 g",
    "",
    "0.48, 0.12, 0.25",
    "[0.30, 0.25, 0.6]",
    str(CELL / "plate.mcap"),
    "",
    str(CELL / "hang.mcap"),  # no presses in it: asked again
    str(CELL / "presses.mcap"),
    "0 0 0.12",
    str(CELL / "poses.mcap"),
    str(CELL / "hang.mcap"),
    "",
]


def asked(out, answers):
    """Run the command with answers on its stdin, which ends behind them."""
    done = subprocess.run(
        [sys.executable, "-m", "peg_on_hole_ros.cli.main", "setup", "--out", str(out)],
        input="".join(f"{answer}\n" for answer in answers),
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=False,
    )
    return done.returncode, done.stdout


def test_answers_lead_to_the_same_settings(tmp_path):
    out = tmp_path / "cell.yaml"
    code, text = asked(out, ANSWERS)
    assert code == 0
    found, stated = read_parameters(out), read_parameters(STATED)
    check_wrench(found)
    for name in stated.keys() - {"joints.urdf"}:
        assert found[name] == pytest.approx(stated[name], abs=1e-9), name
    assert "there is no file" in text and "'thirty' is no number, such as 1.5 m or 1.5 mm" in text
    assert "the recording has 0 such presses" in text
    assert "scene.peg_mass [kg], 1e-06 to 10000: Of the peg alone" in text
    assert "ros2 bag record -s mcap -o poses /ft_raw/wrench /joint_states" in text
    assert "-axis_6 (revolute)-> link_6" in text


def test_an_end_of_answers_keeps_what_was_found_and_the_file_goes_on(tmp_path):
    out, again = tmp_path / "cell.yaml", tmp_path / "again.yaml"
    code, text = asked(out, ANSWERS[:8])
    assert code == 0
    assert f"no more answers: what was found is kept in {out}" in text
    assert known(out)["scene.hole_diameter"] == "stated: by an answer"
    assert known(out)["scene.peg_diameter"] == "not known: gauge the shank and state it"
    # The rest is given, and what was answered is known as it was.
    rest = read_parameters(STATED)
    given = [
        word
        for name in ("scene.peg_diameter", "joints.hole_xyz", "joints.hole_rpy")
        for word in ("--set", f"{name}={rest[name]}")
    ]
    assert setup(again, "--config", out, *given, *recordings("presses")) == 0
    assert known(again)["scene.hole_diameter"] == "stated: by an answer"
    assert known(again)["scene.peg_diameter"] == "stated: by --set"
    # The command that goes on, as it is printed, names no other file: it is written in its place.
    assert setup(again, "--config", again, "--set", "scene.peg_mass=0.4") == 0
    assert known(again)["scene.peg_mass"] == "stated: by --set"
    assert known(again)["scene.hole_diameter"] == "stated: by an answer"


def test_a_file_of_somebody_else_is_not_written_over(tmp_path, capsys):
    start = tmp_path / "start.yaml"
    start.write_text(STATED.read_text(encoding="utf-8"), encoding="utf-8")
    message = f"cannot write {start}: it is the file that is read"
    fails(capsys, 2, message, "setup", "--yes", "--config", start, "--out", start)
    assert start.read_text(encoding="utf-8") == STATED.read_text(encoding="utf-8")


def test_an_interrupt_keeps_what_was_found(tmp_path):
    """In a terminal, where Ctrl-C comes while an answer is waited for."""
    out = tmp_path / "cell.yaml"
    own, its = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "peg_on_hole_ros.cli.main", "setup", "--out", str(out)],
        stdin=its,
        stdout=its,
        stderr=its,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        start_new_session=True,
    )
    os.close(its)

    def until(text):
        seen = ""
        while text not in seen:
            seen += os.read(own, 4096).decode()
        return seen

    try:
        until("joints.urdf: ")
        os.write(own, f"{URDF}\n".encode())
        until("joints.tip_frame (Enter: tool0): ")
        process.send_signal(signal.SIGINT)
        assert "interrupted: what was found is kept" in until("continue with")
        deadline = time.monotonic() + 60.0
        while process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)
        assert process.returncode == 130
    finally:
        process.kill()
        process.wait()
        os.close(own)
    assert known(out)["joints.tip_frame"].startswith("follows: the last link")
