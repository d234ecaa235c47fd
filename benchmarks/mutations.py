"""
Change one formula, constant or condition at a time, and count which changes no test notices.

    python -m benchmarks.mutations [--part monitor mechanics estimator] [--count 60] [--seed 1]
        [--minutes MINUTES] --out DIR

Each mutation is made in a copy of the checkout, whose tests of that part run until one fails; the
first are those that name the module most. In a copy without any they have to pass: else all would
be noticed. Results are kept in DIR: a run that was stopped goes on, and one with a larger count
begins with those of a smaller. Ends with 1 where fewer than LEAST are noticed. JUDGED are
survivors that change nothing a user could see.
"""

import argparse
import ast
import json
import os
import random
import re
import shutil
import subprocess
import sys
import time
from math import inf
from pathlib import Path
from typing import NamedTuple

from scipy.stats import binomtest

ROOT = Path(__file__).parents[1]
PACKAGE = "peg_on_hole_ros"
TESTS = {
    "monitor": ["test/monitor", "test/engine/test_cycles.py"],
    "mechanics": ["test/mechanics"],
    "estimator": ["test/estimator", "test/estimator/test_reset.py"],
}
NOT_MUTATED = ("generated.py", "printed.py", "examples.py")
LEAST = 0.85
# A mutation that never ends is noticed [s].
TIMEOUT = 1200.0
SWAPPED = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
    ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
# What of them is compiled depends on none of the parts, but for how.
KEPT, HOW = "sim_", "mechanics/compiling.py"
FOLDER = "import os, peg_on_hole_ros; print(os.environ['NUMBA_CACHE_DIR'])"
# By file, line and kind.
JUDGED: set[str] = set()


class Mutation(NamedTuple):
    """Where something is changed, and how: `swap` of an operator, `times` ten, `drop` a factor."""

    path: str
    line: int
    column: int
    kind: str

    def __str__(self):
        """Return a name for files and tables."""
        return f"{self.path}:{self.line}:{self.column} {self.kind}"


def sites(path: Path) -> list[Mutation]:
    """Return all mutations of a module, docstrings and annotations left alone."""
    found = []
    name = path.relative_to(ROOT / PACKAGE).as_posix()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        operator = getattr(node, "op", None) or (getattr(node, "ops", None) or [None])[0]
        if isinstance(node, ast.Constant) and type(node.value) is float and node.value:
            found.append(Mutation(name, node.lineno, node.col_offset, "times"))
        elif type(operator) in SWAPPED and isinstance(node, ast.BinOp | ast.Compare | ast.BoolOp):
            found.append(Mutation(name, node.lineno, node.col_offset, "swap"))
            if isinstance(node, ast.BoolOp) or isinstance(operator, ast.Mult):
                found.append(Mutation(name, node.lineno, node.col_offset, "drop"))
    return sorted(set(found))


class _Change(ast.NodeTransformer):
    def __init__(self, mutation):
        self.mutation, self.done = mutation, False

    def generic_visit(self, node):
        node = super().generic_visit(node)
        m = self.mutation
        here = (getattr(node, "lineno", 0), getattr(node, "col_offset", -1)) == (m.line, m.column)
        if self.done or not here:
            return node
        if m.kind == "times" and isinstance(node, ast.Constant) and type(node.value) is float:
            self.done = True
            return ast.copy_location(ast.Constant(10.0 * node.value), node)
        if not isinstance(node, ast.BinOp | ast.Compare | ast.BoolOp):
            return node
        if m.kind == "drop" and isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
            self.done = True
            return node.left
        if m.kind == "drop" and isinstance(node, ast.BoolOp):
            self.done = True
            return node.values[0]
        if m.kind == "swap":
            if isinstance(node, ast.Compare) and type(node.ops[0]) in SWAPPED:
                node.ops[0], self.done = SWAPPED[type(node.ops[0])](), True
            elif not isinstance(node, ast.Compare) and type(node.op) in SWAPPED:
                node.op, self.done = SWAPPED[type(node.op)](), True
        return node


def mutated(text: str, mutation: Mutation) -> str:
    """Return a module with a mutation."""
    change = _Change(mutation)
    tree = change.visit(ast.parse(text))
    if not change.done:
        raise ValueError(f"nothing to change at {mutation}")
    return ast.unparse(ast.fix_missing_locations(tree))


def in_order(tests: list[str], path: str) -> list[str]:
    """Return the files of tests, those first that name a module most often for their length."""
    module = Path(path)
    files = [
        file
        for place in map(ROOT.joinpath, tests)
        for file in ([place] if place.is_file() else sorted(place.rglob("test_*.py")))
    ]

    def named(file):
        text = file.read_text(encoding="utf-8")
        words = (module.stem, module.parent.name)
        return [len(re.findall(rf"\b{word}\b", text)) / len(text) for word in words]

    return [str(file.relative_to(ROOT)) for file in sorted(files, key=named, reverse=True)]


def noticed(mutation: Mutation | None, tests: list[str], folder: Path) -> bool:
    """Return whether a test fails with a mutation, or with none, in a copy in a folder."""
    copy, compiled = folder.resolve() / "checkout", folder.resolve() / "compiled"
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(".*", "out", "site", "__pycache__"))
    environment = {**os.environ, "PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": str(compiled)}
    if mutation is not None:
        path = copy / PACKAGE / mutation.path
        path.write_text(mutated(path.read_text(encoding="utf-8"), mutation), encoding="utf-8")
        tests = in_order(tests, mutation.path)
    asked = [sys.executable, "-c", FOLDER]
    told = subprocess.run(asked, cwd=copy, env=environment, capture_output=True, text=True)
    # A package that cannot be imported has no folder; the tests tell.
    own = Path(told.stdout.strip() or compiled)
    kept = folder.resolve() / "kept"
    if mutation is not None and mutation.path != HOW and kept.exists():
        shutil.copytree(kept, own, dirs_exist_ok=True)
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider"]
    # Those of the night are tests of that part as well.
    command += ["-m", "nightly or not nightly"]
    try:
        done = subprocess.run(
            [*command, *tests], cwd=copy, env=environment, capture_output=True, timeout=TIMEOUT
        )
    except subprocess.TimeoutExpired:
        return True
    finally:
        if mutation is None or mutation.path != HOW:
            for found in own.glob(f"{KEPT}*"):
                shutil.copytree(found, kept / found.name, dirs_exist_ok=True)
        shutil.rmtree(compiled, ignore_errors=True)
    return done.returncode != 0


def main(arguments=None) -> int:
    """Run and print the share that is noticed, and the survivors."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--part", nargs="+", choices=list(TESTS), default=list(TESTS))
    parser.add_argument("--count", type=int, default=60, help="mutations of each part (60)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=inf, help="begin none after so long")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    enough, end = True, time.monotonic() + 60.0 * options.minutes
    for part in options.part:
        modules = sorted((ROOT / PACKAGE / part).rglob("*.py"))
        every = [m for path in modules if path.name not in NOT_MUTATED for m in sites(path)]
        chosen = random.Random(options.seed).sample(every, len(every))[: options.count]
        kept = options.out / f"{part}.json"
        results = json.loads(kept.read_text()) if kept.exists() else {}
        if "none" not in results:
            if noticed(None, TESTS[part], options.out):
                print(f"{part}: the tests fail without any mutation")
                return 1
            results["none"] = False
        for mutation in chosen:
            if str(mutation) not in results and time.monotonic() < end:
                results[str(mutation)] = noticed(mutation, TESTS[part], options.out)
                kept.write_text(json.dumps(results, indent=1))
        counted = [m for m in map(str, chosen) if m in results and m not in JUDGED]
        if not counted:
            print(f"{part}: none was tried")
            enough = False
            continue
        found = binomtest(sum(results[m] for m in counted), len(counted))
        share, sure = found.statistic, found.proportion_ci(method="wilson")
        enough &= share >= LEAST
        between = f"95 % interval {sure.low:.0%} to {sure.high:.0%}"
        print(f"{part}: {share:.0%} of {len(counted)} mutations noticed ({between}); not noticed:")
        print(*(f"  {m}" for m in counted if not results[m]), sep="\n")
    return int(not enough)


if __name__ == "__main__":
    sys.exit(main())
