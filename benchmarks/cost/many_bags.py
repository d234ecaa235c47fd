"""
What 200 small bags take by one job, two, a two-worker dask cluster, and with a worker killed.

    python -m benchmarks.cost.many_bags [--bags 200] [--out FOLDER]

Each bag is the simulated closing with slip, 0.67 s, with noise of its own. Printed are the wall
clock's seconds of each run, how many bags were read whole, and whether its table is the one of one
job, byte by byte. In the last run one of two workers is killed once a quarter of the bags is done.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from distributed import LocalCluster

from peg_on_hole_ros.bags.simulated_bag import write_bag
from peg_on_hole_ros.cli.simulation_file import read_plan
from peg_on_hole_ros.sim.truth import integrate

ROOT = Path(__file__).parents[2]
PLAN = ROOT / "config" / "closing_with_slip.yaml"


def _started(bags, out, *how):
    command = [sys.executable, "-m", "peg_on_hole_ros.cli.main", "replay", str(bags), *how]
    return subprocess.Popen(
        [*command, "--out", str(out)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )


def _by_cluster(bags, out):
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        return _started(bags, out, "--dask", cluster.scheduler_address).communicate()[0]


def _with_a_killed_worker(bags, out, count):
    process = _started(bags, out, "--jobs", "2")
    while len(list(out.glob("*/result.json"))) < count // 4:
        time.sleep(0.05)
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    workers = [
        int(pid) for pid in children if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()
    ]
    os.kill(workers[0], signal.SIGKILL)
    return process.communicate()[0]


def main(arguments=None) -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--bags", type=int, default=200)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(dir=options.out) as folder:
        bags, count, first = Path(folder) / "bags", options.bags, None
        bags.mkdir()
        truth = integrate(read_plan(PLAN))
        for seed in range(count):
            write_bag(bags / f"{seed:03d}.mcap", truth, seed)
        ways = {
            "jobs 1": lambda out: _started(bags, out, "--jobs", "1").communicate()[0],
            "jobs 2": lambda out: _started(bags, out, "--jobs", "2").communicate()[0],
            "dask, 2 workers": lambda out: _by_cluster(bags, out),
            "a worker killed": lambda out: _with_a_killed_worker(bags, out, count),
        }
        print(f"{'':16s}{'[s]':>8s}{'read whole':>12s}  table")
        for name, run in ways.items():
            out, begun = Path(folder) / name.replace(" ", "_"), time.perf_counter()
            told = run(out)
            seconds = time.perf_counter() - begun
            table = (out / "bags.csv").read_bytes()
            first = table if first is None else first
            whole = next(line for line in told.splitlines() if " bags: " in line)
            same = "the same" if table == first else "ANOTHER"
            print(f"{name:16s}{seconds:8.1f}  {whole}  {same}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
