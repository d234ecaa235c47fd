"""Many bags: the same table whoever replays them, whatever dies, and nothing done twice."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cli_helpers import ROOT, config, fails
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.cli.many_bags.task import work
from peg_on_hole_ros.cli.output_paths import alone_in
from recorded import described, motion, write

BAGS = ROOT / "bags"
SHORT = BAGS / "closing_with_slip.mcap", BAGS / "closing_without_slip.mcap"


@pytest.fixture(scope="module")
def shift(tmp_path_factory):
    """Return a folder of bags: two real ones, small ones, a cut-off one, an unreadable one."""
    folder = tmp_path_factory.mktemp("shift")
    for bag in SHORT:
        shutil.copy(bag, folder)
    recorded = folder / "night" / "rosbag2_0"
    recorded.mkdir(parents=True)
    write(recorded / "rosbag2_0.mcap", motion(50))
    (recorded / "metadata.yaml").write_text(described("rosbag2_0.mcap"))
    cut = write(folder / "cut.mcap", motion(200), chunk_size=4000)
    os.truncate(cut, 2 * cut.stat().st_size // 3)
    (folder / "rubbish.mcap").write_bytes(b"no bag at all")
    return folder


def replay(out, *arguments, code=0):
    assert main(["replay", *map(str, arguments), "--out", str(out)]) == code
    return rows(out)


def rows(out):
    with (out / "bags.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture
def no_workers(monkeypatch):
    """Let the work be done in this process: starting one takes longer than a short bag."""
    monkeypatch.setattr(
        "peg_on_hole_ros.cli.many_bags.run.on_this_machine", lambda tasks, jobs: map(work, tasks)
    )


@pytest.fixture(scope="module")
def one_job(shift, tmp_path_factory):
    out = tmp_path_factory.mktemp("one")
    return out, replay(out, shift, "--jobs", 1, code=3)


def test_every_bag_has_its_outcome_and_one_that_is_bad_stops_no_other(one_job, shift):
    out, found = one_job
    by_bag = {Path(row["bag"]).name: row for row in found}
    assert {name: row["exit_code"] for name, row in by_bag.items()} == {
        "closing_with_slip.mcap": "0",
        "closing_without_slip.mcap": "0",
        "cut.mcap": "4",
        "rubbish.mcap": "3",
        "rosbag2_0": "0",
    }
    assert "not an MCAP file" in by_bag["rubbish.mcap"]["error"]
    assert "cut off" in by_bag["cut.mcap"]["error"]
    # What was read before the cut is kept.
    assert 100 < int(by_bag["cut.mcap"]["messages_used"]) < 300
    for name in ("closing_with_slip.mcap", "cut.mcap"):
        summary = json.loads((out / by_bag[name]["folder"] / "summary.json").read_text())
        (cycle,) = summary["cycles"]
        assert by_bag[name]["outcome"] == cycle["outcome"] == "unfinished"
        assert by_bag[name]["peak_K"] == str(cycle["peak_normal"]["K"] or "")


def test_the_summary_is_that_of_a_replay_alone(one_job, shift, tmp_path):
    out, found = one_job
    bag = shift / "closing_with_slip.mcap"
    assert main(["replay", str(bag), "--summary", str(tmp_path / "s.json")]) == 0
    alone = json.loads((tmp_path / "s.json").read_text())
    (folder,) = (row["folder"] for row in found if row["bag"] == str(bag))
    among = json.loads((out / folder / "summary.json").read_text())
    assert among == alone | {"realtime_factor": None}


def tables(out):
    return (out / "bags.csv").read_bytes(), json.loads(parquet(out))


def parquet(out):
    reader = pytest.importorskip("pyarrow.parquet")
    return json.dumps(reader.read_table(out / "bags.parquet").to_pylist())


@pytest.mark.nightly
def test_two_jobs_have_the_same_results(one_job, shift, tmp_path):
    replay(tmp_path, shift, "--jobs", 2, code=3)
    assert tables(tmp_path) == tables(one_job[0])


def test_parquet_holds_what_csv_does(one_job):
    out, found = one_job
    told = json.loads(parquet(out))
    assert [{k: "" if v is None else str(v) for k, v in row.items()} for row in told] == found
    assert isinstance(told[0]["peak_K"], float) and isinstance(told[0]["tries"], int)


@pytest.mark.nightly
def test_a_cluster_of_two_workers_has_the_same_results(one_job, shift, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        replay(tmp_path, shift, "--dask", cluster.scheduler_address, code=3)
    assert tables(tmp_path) == tables(one_job[0])


def test_where_no_scheduler_answers_it_is_said(shift, tmp_path, capsys, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("peg_on_hole_ros.cli.many_bags.workers._PATIENCE", 0.3)
    assert main(["replay", str(shift), "--dask", "127.0.0.1:9", "--out", str(tmp_path)]) == 2
    assert "no dask scheduler answers at 127.0.0.1:9" in capsys.readouterr().err


@pytest.mark.nightly
def test_what_is_done_is_not_done_again_unless_bag_or_settings_change(
    tmp_path, capsys, no_workers
):
    bags, out = tmp_path / "bags", tmp_path / "out"
    bags.mkdir()
    for i in range(3):
        write(bags / f"{i}.mcap", motion(40 + i))

    def done_before(*more):
        replay(out, bags, "--jobs", 1, *more)
        lines = capsys.readouterr().out.splitlines()
        return [line.endswith("(done before)") for line in sorted(lines) if ".mcap: " in line]

    assert done_before() == [False] * 3
    first = tables(out)
    assert done_before() == [True] * 3
    assert tables(out) == first
    write(bags / "1.mcap", motion(60))
    (lost,) = out.glob("2-*/summary.json")
    lost.unlink()
    assert done_before() == [True, False, False]
    friction = config(tmp_path, "scene: {friction: 0.3}")
    assert done_before("--config", friction) == [False] * 3
    # A comment is no setting.
    friction.write_text("# by hand\n" + friction.read_text())
    assert done_before("--config", friction) == [True] * 3


def children(pid):
    return [int(p) for p in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def is_worker(pid):
    return b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()


def wait_for(condition, process):
    while not condition():
        assert process.poll() is None, "it has ended before"
        time.sleep(0.01)


def started(out, bags, jobs):
    command = [sys.executable, "-m", "peg_on_hole_ros.cli.main", "replay", *map(str, bags)]
    return subprocess.Popen(
        [*command, "--jobs", str(jobs), "--out", str(out)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def under_way(out, name):
    """Return whether a bag has been begun and is not done."""
    return any(out.glob(f"{name}-*")) and not any(out.glob(f"{name}-*/result.json"))


@pytest.mark.nightly
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_worker_that_is_killed_loses_nothing(tmp_path, jobs, shift, one_job):
    out = tmp_path / "out"
    process = started(out, [shift], jobs)
    wait_for(lambda: under_way(out, "closing_with_slip"), process)
    victims = [pid for pid in children(process.pid) if is_worker(pid)]
    for pid in victims:
        os.kill(pid, signal.SIGKILL)
    told, errors = process.communicate(timeout=120)
    assert len(victims) == jobs and process.returncode == 3, errors
    assert "5 bags: 3 read whole" in told
    assert tables(out) == tables(one_job[0])


@pytest.mark.nightly
def test_what_was_done_when_all_was_killed_is_kept_and_no_worker_goes_on(tmp_path):
    out = tmp_path / "out"
    process = started(out, SHORT, 1)
    wait_for(lambda: under_way(out, "closing_without_slip"), process)
    workers = [pid for pid in children(process.pid) if is_worker(pid)]
    process.kill()
    process.communicate()
    for pid in workers:
        while Path(f"/proc/{pid}").exists() and is_worker(pid):
            time.sleep(0.01)
    process = started(out, SHORT, 1)
    told, _ = process.communicate(timeout=120)
    assert process.returncode == 0
    assert told.count("(done before)") == 1 and "2 bags: 2 read whole; 1 done before" in told


def test_two_do_not_write_into_one_folder(tmp_path, capsys, no_workers):
    out = tmp_path / "out"
    out.mkdir()
    bag = write(tmp_path / "a.mcap", motion(40))
    with alone_in(out):
        told = f"another replay writes into {out}: wait for it, or name another folder"
        fails(capsys, 2, told, "replay", bag, "--jobs", 1, "--out", out)
    replay(out, bag, "--jobs", 1)


def test_a_bag_that_links_lead_to_in_circles_has_its_shortest_name(tmp_path, capsys, no_workers):
    folder = tmp_path / "shift" / "night"
    folder.mkdir(parents=True)
    bag = write(folder / "a.mcap", motion(40))
    (folder / "again").symlink_to(folder.parent)
    replay(tmp_path / "out", folder.parent / "**" / "*.mcap", "--jobs", 1)
    assert capsys.readouterr().out.startswith(f"{bag}: ")


@pytest.mark.parametrize(
    ("message", "arguments"),
    [
        ("many bags need a folder for their results: name one with --out DIR", ["--jobs", "2"]),
        ("--jobs = 0 is not within 1 to 256", ["--jobs", "0", "--out", "o"]),
        (
            "--jobs and --dask exclude each other: a cluster has its workers",
            ["--jobs", "2", "--dask", "a:1", "--out", "o"],
        ),
        (
            "--summary is for one bag: with many bags each has its summary, with the tries, in "
            "--out",
            ["--jobs", "2", "--summary", "s.json", "--out", "o"],
        ),
    ],
)
def test_arguments_that_do_not_fit_are_refused(capsys, tmp_path, monkeypatch, message, arguments):
    monkeypatch.chdir(tmp_path)
    fails(capsys, 2, message, "replay", SHORT[0], *arguments)


def test_what_names_no_bag_is_refused_before_the_work(capsys, tmp_path):
    (tmp_path / "empty").mkdir()
    out = tmp_path / "out"
    folder = tmp_path / "empty"
    told = f"{folder} is a folder that holds no bag"
    fails(capsys, 3, told, "replay", SHORT[0], folder, "--out", out)
    told = f"there is no bag {tmp_path}/*.mcap"
    fails(capsys, 3, told, "replay", f"{tmp_path}/*.mcap", "--out", out)
    assert not any(out.iterdir())
