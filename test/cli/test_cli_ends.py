"""Ends that nobody plans: full disks, signals, errors of the system; one line and no half file."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import peg_on_hole_ros.cli.solve as solve_command
from cli_helpers import ROOT, fails, largest_file
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.errors import BagError, PegOnHoleError
from small_bags import JOINTS, MS, WRENCH, joints, wrench, write_bag

SOLVE = "solve", "--state", "0.2,0,0,0,0,1"


@pytest.mark.parametrize("chunk_bytes", [2000, 1 << 20])
def test_a_disk_that_fills_up_leaves_an_error_and_no_file(tmp_path, chunk_bytes):
    with (
        largest_file(8000),
        pytest.raises(PegOnHoleError, match=r"^cannot write .*/a.mcap: File too large$"),
    ):
        # With large chunks all is written at the end.
        write_bag(tmp_path / "a.mcap", count=2000, chunk_bytes=chunk_bytes)
    assert list(tmp_path.iterdir()) == []


def test_a_replay_onto_a_full_disk_is_exit_code_2(bag, replayed, tmp_path, capsys):
    out = tmp_path / "out.mcap"
    message = f"cannot write {out}: File too large"
    # Compiled code is kept in files as well, which the limit must not meet: `replayed` has it.
    with largest_file(8000):
        fails(capsys, 2, message, "replay", bag, "--out", out)
    assert list(tmp_path.iterdir()) == []


def test_stamps_below_zero_cannot_be_log_times(tmp_path, capsys):
    path, out = tmp_path / "a.mcap", tmp_path / "out.mcap"
    with BagWriter(path) as writer:
        for i in range(40):
            t_ns = -5 * 10**9 + i * MS
            writer.write("/joint_states", JOINTS, joints(t_ns), i)
            writer.write("/wrench", WRENCH, wrench(t_ns), i)
    message = (
        f"cannot write {out}: a stamp of -5 s is below 0 s, where a bag has no times; correct "
        "the stamps, or leave out this output"
    )
    fails(capsys, 2, message, "replay", path, "--out", out)
    assert main(["replay", str(path)]) == 0
    assert not out.exists()


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (PermissionError(13, "Permission denied", "/x/y"), "/x/y: Permission denied"),
        (OSError(5, "Input/output error"), "Input/output error"),
        (OSError("odd"), "odd"),
    ],
)
def test_an_error_of_the_system_is_one_line(monkeypatch, capsys, error, message):
    def run(_):
        raise error

    monkeypatch.setattr(solve_command, "run", run)
    fails(capsys, 2, message, *SOLVE)


def test_output_that_cannot_be_printed_is_one_line():
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "peg_on_hole_ros.cli.main", *SOLVE],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            check=False,
        )
    assert done.stderr == "peg-on-hole: error: No space left on device\n"
    assert done.returncode == 2


def unread(*arguments, errors_too=False):
    """Run with an output that nobody reads, as `| true` leaves it."""
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [sys.executable, "-m", "peg_on_hole_ros.cli.main", *map(str, arguments)],
        stdout=writing,
        stderr=subprocess.STDOUT if errors_too else subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=False,
    )
    os.close(writing)
    return done.returncode, done.stderr


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("buffered", "commands"), [("", ["inspect", "replay"]), ("1", ["inspect"])]
)
def test_a_reader_that_goes_changes_no_exit_code(tmp_path, monkeypatch, buffered, commands):
    monkeypatch.setenv("PYTHONUNBUFFERED", buffered)
    whole = write_bag(tmp_path / "whole.mcap", count=400, chunk_bytes=4000)
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    assert unread("inspect", whole) == (0, "")
    if not buffered:
        assert unread("--help") == (0, "")
    for command in commands:
        code, told = unread(command, cut)
        assert code == 4
        assert told.startswith(f"peg-on-hole: error: {cut} is cut off at byte ")
        assert len(told.splitlines()) == 1
    assert unread("inspect", cut, errors_too=True)[0] == 4


class Broken:
    """A file whose disk fails after some bytes."""

    name = "a.mcap"

    def __init__(self, stream, good):
        self._stream, self._good = stream, good
        self.tell, self.seek, self.close = stream.tell, stream.seek, stream.close

    def read(self, size=-1):
        if self._stream.tell() + max(size, 0) > self._good:
            raise OSError(5, "Input/output error")
        return self._stream.read(size)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def test_a_disk_that_fails_gives_what_lies_before(tmp_path, monkeypatch):
    path = write_bag(tmp_path / "a.mcap", count=400, chunk_bytes=4000)
    whole = Bag(path)
    half = path.stat().st_size // 2
    monkeypatch.setattr(
        "peg_on_hole_ros.bags.storage.mcap_file.open_packed",
        lambda path: Broken(path.open("rb"), half),
    )
    bag = Bag(path)
    assert f"{path} is unreadable after byte " in bag.damage
    assert bag.damage.endswith(": Input/output error")
    read = len(list(bag.messages(["/wrench"])))
    assert 50 < read == bag.topics["/wrench"].count < 350
    with pytest.raises(BagError, match="cannot read a.mcap: Input/output error"):
        list(whole.messages(["/wrench"]))


def test_sigterm_leaves_no_half_written_file(tmp_path):
    # On a busy machine the replay may be done before the signal comes.
    for attempt in range(10):
        folder = tmp_path / str(attempt)
        folder.mkdir()
        code, text = ended_while_writing(folder / "out.mcap")
        if code != 0:
            break
    assert code == 130, text
    assert "Traceback" not in text
    assert list(folder.iterdir()) == []


def ended_while_writing(out):
    """Replay, end that by SIGTERM as soon as there is a part of the output; return code, text."""
    command = [sys.executable, "-m", "peg_on_hole_ros.cli.main", "replay"]
    process = subprocess.Popen(
        [*command, str(ROOT / "bags" / "working_cycle.mcap"), "--out", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    try:
        part = out.with_name("out.mcap.part")
        deadline = time.monotonic() + 120
        while not (begun := part.exists()) and process.poll() is None:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        assert begun or process.returncode == 0
        process.send_signal(signal.SIGTERM)
        _, text = process.communicate(timeout=60)
    finally:
        process.kill()
    return process.returncode, text


@pytest.mark.parametrize("which", [1, 2])
def test_a_signal_just_after_a_file_is_made_leaves_none(replayed, tmp_path, monkeypatch, which):
    # A replay makes its output twice: to see whether it can, and to write it.
    opened, times = Path.open, []

    def interrupted(path, *arguments, **options):
        stream = opened(path, *arguments, **options)
        if path.name == "out.mcap.part":
            times.append(path)
            if len(times) == which:
                raise KeyboardInterrupt
        return stream

    bag = write_bag(tmp_path / "a.mcap", count=40)
    monkeypatch.setattr(Path, "open", interrupted)
    assert main(["replay", str(bag), "--out", str(tmp_path / "out.mcap")]) == 130
    assert len(times) == which
    assert list(tmp_path.iterdir()) == [bag]


def test_the_handling_of_sigterm_is_lent(capsys):
    assert main([*SOLVE]) == 0
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    codes = []
    thread = threading.Thread(target=lambda: codes.append(main([*SOLVE])))
    thread.start()
    thread.join()
    assert codes == [0]
