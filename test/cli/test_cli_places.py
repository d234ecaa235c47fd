"""What commands write goes nowhere where something is read, and is tried before the work."""

import os

import pytest

import peg_on_hole_ros.cli.replay as replay_command
from cli_helpers import config, fails, largest_file
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli import demo
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.cli.output_paths import write_text
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.startup.exit_codes import INTERNAL
from small_bags import JOINTS, MS, WRENCH, joints, wrench, write_bag

DESCRIPTION = (
    "rosbag2_bagfile_information:\n  storage_identifier: mcap\n"
    "  relative_file_paths: [rec_0.mcap, rec_1.mcap]\n"
)
READ = "it is the file that is read"
# All before was well: the replay itself is not there, see `recording`.
NO_REPLAY = (
    "a fault of the program, please report it: TypeError: 'NoneType' object is not callable"
)


@pytest.fixture
def recording(tmp_path, monkeypatch):
    """A folder bag, read in the folder above it, and no replay whatever is asked for."""
    folder = tmp_path / "rec"
    folder.mkdir()
    write_bag(folder / "rec_0.mcap", count=20)
    write_bag(folder / "rec_1.mcap", count=20, start=2 * 10**9)
    (folder / "metadata.yaml").write_text(DESCRIPTION)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(replay_command, "replay", None)
    return folder


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


@pytest.mark.parametrize("option", ["--out", "--summary", "--cycles", "--report"])
@pytest.mark.parametrize("name", ["rec_0.mcap", "rec_1.mcap", "metadata.yaml"])
def test_no_file_of_a_folder_is_overwritten(recording, capsys, option, name):
    before = contents(recording)
    fails(capsys, 2, f"cannot write rec/{name}: {READ}", "replay", "rec", option, f"rec/{name}")
    assert contents(recording) == before


def test_no_other_name_of_what_is_read_is_overwritten(recording, capsys):
    os.symlink("rec/rec_0.mcap", "soft.mcap")
    os.link("rec/rec_1.mcap", "hard.mcap")
    for name in ("soft.mcap", "hard.mcap", "rec/../rec/rec_0.mcap"):
        fails(capsys, 2, f"cannot write {name}: {READ}", "replay", "rec", "--out", name)
    # A bag is first written under this name.
    os.link("rec/rec_0.mcap", "out.mcap.part")
    arguments = "replay", "out.mcap.part", "--out", "out.mcap"
    fails(capsys, 2, f"cannot write out.mcap: {READ}", *arguments)


def test_nothing_is_put_among_the_parts_of_a_bag_that_nothing_describes(recording, capsys):
    (recording / "metadata.yaml").unlink()
    message = (
        "cannot write rec/rec_2.mcap: it would be read as a part of the bag rec, which has no "
        "metadata.yaml"
    )
    fails(capsys, 2, message, "replay", "rec", "--out", "rec/rec_2.mcap")


def test_configuration_and_robot_are_not_overwritten(recording, tmp_path, capsys):
    path = config(tmp_path, "scene: {friction: 0.3}")
    for arguments in (
        ("replay", "rec", "--config", path, "--summary", path),
        ("calibrate", "rec", "--config", path, "--out", path),
        ("simulate", "--config", path, "--out", path),
    ):
        fails(capsys, 2, f"cannot write {path}: {READ}", *arguments)
    robot = "source: robot, urdf: r.urdf, tip_frame: t, names: [j]"
    path = config(tmp_path, f"joints: {{{robot}}}", "robot.yaml")
    fails(
        capsys,
        2,
        f"cannot write r.urdf: {READ}",
        *("replay", "rec", "--config", path, "--summary", "r.urdf"),
    )
    stored = {"joints.source": "robot", "joints.urdf": "r.urdf", "joints.tip_frame": "t"}
    with BagWriter("a.mcap", from_parameters(stored)) as writer:
        writer.write("/wrench", WRENCH, wrench(MS), MS)
        writer.write("/joint_states", JOINTS, joints(MS), MS)
    fails(
        capsys,
        2,
        f"cannot write r.urdf: {READ}",
        "replay",
        "a.mcap",
        "--bag-urdf",
        "--summary",
        "r.urdf",
    )
    message = "result.csv is named as the results that go into .; rename it to .yaml"
    config(tmp_path, "scene: {friction: 0.3}", "result.csv")
    for command in ("chart", "stability"):
        fails(capsys, 2, message, command, "--out", ".", "--config", "result.csv")


def test_demonstration_does_not_overwrite_its_bag(recording, capsys):
    assert demo.main(["rec/rec_0.mcap", "--out", "rec"]) == 2
    assert capsys.readouterr().err.endswith(f"cannot write rec/rec_0.mcap: {READ}\n")


def test_two_outputs_do_not_go_to_one_place(recording, capsys):
    message = "cannot write rec/../x.mcap: two outputs have this place"
    fails(capsys, 2, message, "replay", "rec", "--out", "x.mcap", "--summary", "rec/../x.mcap")
    fails(capsys, 2, message, "replay", "rec", "--summary", "x.mcap", "--cycles", "rec/../x.mcap")


def test_a_calibration_tries_its_place_before_the_work(recording, capsys):
    assert main(["calibrate", "rec", "--out", "/proc/x"]) == 2
    assert "error: cannot write /proc/x: " in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--out", "--summary", "--cycles", "--report"])
def test_places_are_tried_before_the_work_and_left_as_they_were(recording, capsys, option):
    assert main(["replay", "rec", option, "/proc/none/x"]) == 2
    assert main(["replay", "rec", option, "/proc/x"]) == 2
    assert main(["replay", "rec", option, "x" * 300]) == 2
    no_folder, refused, long = capsys.readouterr().err.splitlines()
    assert no_folder.endswith("cannot write /proc/none/x: there is no folder /proc/none")
    assert refused.startswith("peg-on-hole: error: cannot write /proc/x: ")
    assert long.endswith("xxx: File name too long")
    message = "the path of an output is empty; name a file"
    fails(capsys, 2, message, "replay", "rec", option, "")
    (recording.parent / "old").write_text("kept")
    for name in ("old", "new"):
        assert main(["replay", "rec", option, name]) == INTERNAL
        assert NO_REPLAY in capsys.readouterr().err
    assert contents(recording.parent) == {"old": b"kept"}


def test_texts_may_go_to_devices_and_bags_may_not(recording, capsys):
    assert main(["replay", "rec", "--summary", os.devnull, "--cycles", os.devnull]) == INTERNAL
    assert NO_REPLAY in capsys.readouterr().err
    message = f"cannot write {os.devnull}: a bag is written to a regular file only"
    fails(capsys, 2, message, "replay", "rec", "--out", os.devnull)


def test_an_empty_path_is_no_configuration(recording, capsys):
    message = "the path of the configuration is empty; name a file, or leave it out"
    for command in ("replay", "inspect"):
        fails(capsys, 2, message, command, "rec", "--config", "")
    fails(capsys, 2, message, "node", "--config", "")
    fails(capsys, 2, message, "node", "--config=", "--ros-args", "-p", "autostart:=false")


def test_a_text_on_a_full_disk_is_an_error_that_names_it():
    with pytest.raises(PegOnHoleError, match="^cannot write /dev/full: No space left on device$"):
        write_text("/dev/full", "text")
    assert os.path.exists("/dev/full")


def test_a_text_that_cannot_be_finished_leaves_what_was_there(tmp_path):
    path = tmp_path / "summary.json"
    path.write_text("kept")
    for name in (path, tmp_path / "new.json"):
        refused = pytest.raises(PegOnHoleError, match=f"^cannot write {name}: File too large$")
        with largest_file(1000), refused:
            write_text(name, "x" * 10_000)
    assert contents(tmp_path) == {"summary.json": b"kept"}
    write_text(path, "whole")
    assert contents(tmp_path) == {"summary.json": b"whole"}


def test_a_text_goes_through_a_link(tmp_path):
    path, link = tmp_path / "target", tmp_path / "link"
    path.write_text("old")
    link.symlink_to(path)
    write_text(link, "new")
    assert link.is_symlink() and contents(tmp_path) == {"target": b"new", "link": b"new"}


def test_the_place_of_a_text_in_the_making_is_tried_too(recording, capsys):
    os.link("rec/rec_0.mcap", "out.json.part")
    fails(capsys, 2, f"cannot write out.json: {READ}", "replay", "out.json.part", "--summary",
          "out.json")  # fmt: skip
