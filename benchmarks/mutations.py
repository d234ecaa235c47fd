"""
Change one formula, constant or condition at a time, and count which changes no test notices.

    python -m benchmarks.mutations [--part monitor mechanics estimator] [--count 60] [--seed 1]
        [--minutes MINUTES] --out DIR

Each mutation is made in a copy of the checkout, whose tests of that part run until one fails. In a
copy without any they have to pass: else all would be noticed. Results are kept in DIR, so that a
run which was stopped goes on. Ends with 1 where fewer than LEAST are noticed. JUDGED are survivors
that change nothing a user could see.
"""

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from math import inf
from pathlib import Path
from typing import NamedTuple

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


def noticed(mutation: Mutation | None, tests: list[str]) -> bool:
    """Return whether a test fails with a mutation, or with none."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "checkout"
        leave = shutil.ignore_patterns(".*", "out", "site", "__pycache__")
        shutil.copytree(ROOT, copy, ignore=leave)
        if mutation is not None:
            path = copy / PACKAGE / mutation.path
            path.write_text(mutated(path.read_text(encoding="utf-8"), mutation), encoding="utf-8")
        environment = {
            **os.environ, "PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": str(copy / "compiled"),
        }  # fmt: skip
        command = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider"]
        try:
            done = subprocess.run(
                [*command, *tests], cwd=copy, env=environment, capture_output=True, timeout=TIMEOUT
            )
        except subprocess.TimeoutExpired:
            return True
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
        chosen = random.Random(options.seed).sample(every, min(options.count, len(every)))
        kept = options.out / f"{part}.json"
        results = json.loads(kept.read_text()) if kept.exists() else {}
        if "none" not in results:
            if noticed(None, TESTS[part]):
                print(f"{part}: the tests fail without any mutation")
                return 1
            results["none"] = False
        for mutation in chosen:
            if str(mutation) not in results and time.monotonic() < end:
                results[str(mutation)] = noticed(mutation, TESTS[part])
                kept.write_text(json.dumps(results, indent=1))
        counted = [m for m in map(str, chosen) if m in results and m not in JUDGED]
        share = sum(results[m] for m in counted) / max(len(counted), 1)
        enough &= share >= LEAST
        print(f"{part}: {share:.0%} of {len(counted)} mutations noticed; not noticed:")
        print(*(f"  {m}" for m in counted if not results[m]), sep="\n")
    return int(not enough)


if __name__ == "__main__":
    sys.exit(main())
