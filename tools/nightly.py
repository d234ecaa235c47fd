"""
Run all that takes too long for every push, and print a table of what fell.

    python tools/nightly.py [--only NAME...] [--seconds SECONDS] [--out out/nightly]

`--seconds` shortens the two long runs. What each part printed is kept in the folder. Run it from
the root of the checkout.
"""

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

WORKERS = os.environ.get("WORKERS", "2")
PYTHON = (sys.executable, "-m")
PYTEST = (*PYTHON, "pytest", "-n", WORKERS)
COMMAND = (*PYTHON, "peg_on_hole_ros.cli.main")


def parts(seconds: float | None, out: Path) -> dict[str, list[str]]:
    """Return the command of each part."""
    hour = seconds or 3600
    storm = min(seconds or 600, 600)
    workers = ("--workers", WORKERS)
    fuzz = ("test/config/test_config_fuzz.py", "test/engine/test_arrivals.py")
    return {
        "tests": [*PYTEST, "-m", "nightly"],
        "python": ["tools/other_python.sh"],
        "fuzz": [*PYTEST, "--timeout", "7200", *fuzz],
        "faults": [*PYTHON, "benchmarks", "faults", *workers, "--out", f"{out}/faults"],
        "live": [*PYTHON, "benchmarks.faults.live"],
        "chart": [*COMMAND, "chart", "--quick", "--out", f"{out}/chart"],
        "stability": [*COMMAND, "stability", "--quick", "--out", f"{out}/stability"],
        "grid": [*PYTHON, "benchmarks", "grid", "--quick", "--out", f"{out}/grid"],
        "scenes": [*PYTHON, "benchmarks", "scenes", "--quick", "--out", f"{out}/scenes"],
        "hour": [*PYTHON, "benchmarks.cost.hour", "--seconds", str(hour)],
        "storm": [
            *(*PYTHON, "benchmarks.faults.storm", "--seconds", str(storm)),
            *("--out", f"{out}/storm"),
        ],
        "steps": [*PYTHON, "benchmarks.cost.long_run"],
        "mutations": [*PYTHON, "benchmarks.mutations", "--out", f"{out}/mutations"],
    }


def main(arguments=None) -> int:
    """Run the parts; return 1 if one fell."""
    names = list(parts(None, Path()))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--only", nargs="+", choices=names, default=names)
    parser.add_argument("--seconds", type=float, help="of the two long runs (3600, 600)")
    parser.add_argument("--out", type=Path, default=Path("out/nightly"))
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    rows, fell = ["| part | result | minutes | last line |", "|---|---|---|---|"], 0
    for name in options.only:
        begin, log = time.monotonic(), options.out / f"{name}.txt"
        profile = {"HYPOTHESIS_PROFILE": "nightly"} if name == "fuzz" else {}
        with log.open("w", encoding="utf-8") as file:
            code = subprocess.call(
                parts(options.seconds, options.out)[name],
                stdout=file, stderr=subprocess.STDOUT, env={**os.environ, **profile},
            )  # fmt: skip
        lines = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
        result = f"**fell, exit code {code}**" if code else "held"
        minutes = (time.monotonic() - begin) / 60.0
        last = lines[-1].replace("|", "/")[:120] if lines else ""
        rows.append(f"| {name} | {result} | {minutes:.1f} | {last} |")
        print(rows[-1], flush=True)
        fell += code != 0
    table = "\n".join(rows)
    (options.out / "table.md").write_text(f"{table}\n", encoding="utf-8")
    print(f"\n{table}")
    return int(fell > 0)


if __name__ == "__main__":
    sys.exit(main())
