"""What is no regular file where one is named is told at once, and never waited for."""

import csv
import os
import socket

import pytest

from cli_helpers import config
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.cli.many_bags.task import work
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.ros import process
from recorded import motion, write
from tiers import at_push


def pipe(path):
    os.mkfifo(path)


def bound_socket(path):
    # The name of a socket has at most some 100 characters.
    before = os.getcwd()
    os.chdir(path.parent)
    try:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(path.name)
    finally:
        os.chdir(before)


def device(path):
    path.symlink_to("/dev/zero")


def folder(path):
    path.mkdir()


def dangling(path):
    path.symlink_to("nowhere")


def looping(path):
    path.symlink_to(path.name)


IRREGULAR = {f.__name__: f for f in (pipe, bound_socket, device, folder, dangling, looping)}
TOLD = {
    "folder": "{path} is a folder without metadata.yaml and without .mcap files: no bag",
    "dangling": "there is no bag {path}: it is a link to nowhere",
    "looping": "there is no bag {path}: it is a link to {path.name}",
}
USUAL = "{path} is no regular file, so it is not opened"


def last_line(capsys):
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith("peg-on-hole: error: ") and "fault of the program" not in line
    return line.removeprefix("peg-on-hole: error: ")


@pytest.mark.parametrize("suffix", at_push([".mcap"], [".mcap", ".mcap.zstd", ".db3", ""]))
@pytest.mark.parametrize("kind", IRREGULAR)
def test_as_a_bag_it_ends_with_one_line_and_code_3(kind, suffix, tmp_path, capsys):
    path = tmp_path / f"a{suffix}"
    IRREGULAR[kind](path)
    for command in ("replay", "inspect", "calibrate"):
        more = ["--out", str(tmp_path / "c.yaml")] if command == "calibrate" else []
        assert main([command, str(path), *more]) == 3
        assert last_line(capsys) == TOLD.get(kind, USUAL).format(path=path)


@pytest.mark.parametrize("kind", ["pipe", "bound_socket", "device"])
def test_in_the_folder_of_a_bag_as_well(kind, tmp_path, capsys):
    bag = tmp_path / "bag"
    bag.mkdir()
    write(bag / "bag_0.mcap", motion(50))
    IRREGULAR[kind](bag / "bag_1.mcap")
    assert main(["replay", str(bag)]) == 3
    assert last_line(capsys) == USUAL.format(path=bag / "bag_1.mcap")


def test_of_many_bags_each_is_told_and_the_others_are_replayed(tmp_path, monkeypatch):
    # In this process: starting one takes longer than the bags.
    monkeypatch.setattr(
        "peg_on_hole_ros.cli.many_bags.run.on_this_machine", lambda tasks, jobs: map(work, tasks)
    )
    bags, out = tmp_path / "bags", tmp_path / "out"
    bags.mkdir()
    for kind, make in IRREGULAR.items():
        make(bags / f"{kind}.mcap")
    write(bags / "good.mcap", motion(50))
    (bags / "around").symlink_to(bags)
    main(["replay", str(bags), "--jobs", "1", "--out", str(out)])
    with (out / "bags.csv").open(newline="", encoding="utf-8") as file:
        codes = {os.path.basename(row["bag"]): row["exit_code"] for row in csv.DictReader(file)}
    # A folder may hold bags whatever its name is; this one holds none.
    assert codes == {f"{kind}.mcap": "3" for kind in IRREGULAR if kind != "folder"} | {
        "good.mcap": "0"
    }


@pytest.mark.parametrize("kind", IRREGULAR)
def test_as_a_configuration_or_a_urdf_it_ends_with_one_line_and_code_2(kind, tmp_path, capsys):
    path, bag = tmp_path / "c.yaml", write(tmp_path / "a.mcap", motion(20))
    IRREGULAR[kind](path)
    robot = config(tmp_path, f"joints: {{source: robot, urdf: {path}, tip_frame: t}}", "r.yaml")
    for arguments in (
        ["replay", bag, "--config", path],
        ["simulate", "--config", path, "--out", tmp_path / "out.mcap"],
        ["solve", "--config", path, "--state", "0.2,0,0,-0.1,0,0"],
        ["replay", bag, "--config", robot],
    ):
        assert main([str(word) for word in arguments]) == 2
        assert str(path) in last_line(capsys)


def test_the_pipe_of_a_shell_is_read(tmp_path, capsys):
    end, begin = os.pipe()
    os.write(begin, config(tmp_path, "scene: {friction: 0.1}").read_bytes())
    os.close(begin)
    assert main(["solve", "--state", "0.2,0,0,-0.16,0,2", "--config", f"/dev/fd/{end}"]) == 0
    os.close(end)


def test_a_node_does_not_wait_for_a_pipe_as_its_parameters(tmp_path):
    os.mkfifo(tmp_path / "c.yaml")
    with pytest.raises(PegOnHoleError, match="is a named pipe, which is not read"):
        process.init(["--ros-args", "--params-file", str(tmp_path / "c.yaml")])


@pytest.mark.parametrize("kind", ["folder", "dangling", "looping", "bound_socket"])
@pytest.mark.parametrize("option", ["--out", "--summary", "--report", "--cycles"])
def test_as_an_output_it_is_refused_or_replaced(option, kind, tmp_path, capsys):
    path, bag = tmp_path / "o.mcap", write(tmp_path / "a.mcap", motion(50))
    IRREGULAR[kind](path)
    if code := main(["replay", str(bag), option, str(path)]):
        assert code == 2 and last_line(capsys).startswith(f"cannot write {path}: ")
