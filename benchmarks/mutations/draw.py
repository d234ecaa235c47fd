"""
Mutants of a part of the package: every place where one change can be made, and a draw from them.

A mutant is one change of an expression or one statement left out. Not mutated is what changes
no behaviour or what nothing defines: docstrings, messages of errors, annotations, defaults,
indices (a wrong one reads outside of its array), and constants that only keep from a division by
zero.
"""

import ast
import builtins
import hashlib
import importlib
from collections.abc import Callable, Iterator
from copy import deepcopy
from itertools import chain, zip_longest
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PACKAGE = "peg_on_hole_ros"
TURNED = {
    ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
}  # fmt: skip
OTHER_BOUND = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}
# By what a constant is scaled; smaller ones only guard a division.
SCALE, LEAST_CONSTANT = 10.0, 1e-9
# Compiled by other means, or said to a reader alone.
UNTOUCHED = {"__repr__", "__str__"}
SWITCH = "mutation"


class Mutant(NamedTuple):
    """One change: where, what stands there, and what stands there instead."""

    kind: str
    path: str
    function: str
    text: str
    old: str
    new: str
    # Of those that are alike in all this, the how-manieth.
    which: int

    def __str__(self):
        """Return a name for files and tables, which edits elsewhere in the file leave as it is."""
        again = f" ({self.which})" if self.which else ""
        return f"{self.path} {self.function}: {self.old} -> {self.new}{again}"


class Places(ast.NodeTransformer):
    """
    Visit every place of a module that can be mutated, and put in a switch where one is chosen.

    Parameters
    ----------
    path : str
        Of the module, in the package.
    text : str
        Of the module.
    number_of : callable
        The number of a mutant, from 1 on, or None where it is not made.

    """

    def __init__(self, path: str, text: str, number_of: Callable[[Mutant], int | None]):
        self.path, self.lines, self.number_of = path, text.splitlines(), number_of
        self.names, self.seen = [], {}
        module = path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
        self.module = importlib.import_module(f"{PACKAGE}.{module}")

    def visit_FunctionDef(self, node):
        """Mutate the body of a function alone."""
        if node.name not in UNTOUCHED:
            self.names.append(node.name)
            node.body = [self._statement(each) for each in node.body]
            self.names.pop()
        return node

    def visit_Subscript(self, node):
        """Leave the index as it is."""
        node.value = self.visit(node.value)
        return node

    def _as_it_is(self, node):
        return node

    visit_Raise = visit_Assert = visit_JoinedStr = visit_ClassDef_keyword = _as_it_is
    visit_Lambda = _as_it_is

    def visit_AnnAssign(self, node):
        """Leave the annotation as it is."""
        node.value = node.value and self.visit(node.value)
        return node

    def generic_visit(self, node):
        """Mutate an expression, and what stands in it."""
        if not self.names:
            return super().generic_visit(node)
        original = deepcopy(node)
        for field, value in ast.iter_fields(node):
            if isinstance(value, list):
                value[:] = [self._inner(each) for each in value]
            elif isinstance(value, ast.AST):
                setattr(node, field, self._inner(value))
        for kind, new in self._alternatives(original):
            number = self._number(kind, original, ast.unparse(original), ast.unparse(new))
            if number is not None:
                node = ast.IfExp(_is_on(number), new, node)
        return node

    def _inner(self, node):
        if isinstance(node, ast.stmt):
            return self._statement(node)
        return self.visit(node) if isinstance(node, ast.AST) else node

    def _statement(self, node):
        whole = ast.unparse(node)
        called = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
        kept = isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute)
        original = deepcopy(node)
        changed = self.visit(node)
        if called or kept:
            number = self._number("statement left out", original, whole, "pass")
            if number is not None:
                changed = ast.If(_is_on(number), [ast.Pass()], [changed])
        if isinstance(original, ast.AugAssign) and isinstance(original.op, ast.Add | ast.Sub):
            new = ast.UnaryOp(ast.USub(), original.value)
            old = ast.unparse(original.target) + (
                " += " if isinstance(original.op, ast.Add) else " -= "
            )
            number = self._number("sign", original, whole, old + ast.unparse(new))
            if number is not None:
                changed.value = ast.IfExp(_is_on(number), new, changed.value)
        if isinstance(original, ast.If) and not _about_none(original.test):
            changed.test = self._condition(original, changed.test)
        return changed

    def _condition(self, original, test):
        old = ast.unparse(original.test)
        number = self._number("condition", original, f"if {old}", f"if not ({old})")
        if number is not None:
            test = ast.IfExp(_is_on(number), ast.UnaryOp(ast.Not(), original.test), test)
        ends = isinstance(original.body[-1], ast.Return | ast.Continue | ast.Break)
        if ends and _is_bool(original.test):
            number = self._number(
                "early exit", original, f"if {old}: {ast.unparse(original.body[-1])}", "pass"
            )
            if number is not None:
                test = ast.IfExp(_is_on(number), ast.Constant(False), test)
        return test

    def _number(self, kind, node, old, new):
        line = self.lines[node.lineno - 1].strip()
        found = (kind, self.path, ".".join(self.names), line, old, new)
        which = self.seen[found] = self.seen.get(found, -1) + 1
        return self.number_of(Mutant(*found, which))

    def _alternatives(self, node) -> Iterator[tuple[str, ast.expr]]:
        match node:
            case ast.Compare(left, [operator], right) if type(operator) in TURNED:
                yield "comparison", ast.Compare(left, [TURNED[type(operator)]()], right)
            case ast.BinOp(left, ast.Add() | ast.Sub() as operator, right):
                if not _is_text(left) and not _is_text(right):
                    other = ast.Sub() if isinstance(operator, ast.Add) else ast.Add()
                    yield "sign", ast.BinOp(left, other, right)
            case ast.BinOp(left, ast.Mult(), right) if not _is_text(left):
                yield "factor", left
            case ast.BinOp(left, ast.Div(), right):
                yield "factor", ast.BinOp(left, ast.Mult(), right)
            case ast.UnaryOp(ast.USub(), operand) if not isinstance(operand, ast.Constant):
                yield "sign", operand
            case ast.BoolOp(_, values) if not any(map(_about_none, values)):
                for left_out in values:
                    rest = [each for each in values if each is not left_out]
                    yield "half", rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest)
            case ast.Call(ast.Name(name), [_, _, *_], []) if name in OTHER_BOUND:
                yield "bound", ast.Call(ast.Name(OTHER_BOUND[name]), node.args, [])
            case ast.IfExp(test, body, otherwise) if not _about_none(test):
                yield "condition", ast.IfExp(ast.UnaryOp(ast.Not(), test), body, otherwise)
            case ast.Constant(value) if type(value) is float and abs(value) > LEAST_CONSTANT:
                yield "constant", ast.Constant(SCALE * value)
            case ast.Name(name, ast.Load()) if not hasattr(builtins, name):
                value = getattr(self.module, name, None)
                if type(value) is float and abs(value) > LEAST_CONSTANT:
                    yield "constant", ast.BinOp(ast.Constant(SCALE), ast.Mult(), node)


def _is_on(number):
    called = ast.Call(ast.Name(SWITCH), [], [])
    return ast.Compare(called, [ast.Eq()], [ast.Constant(number)])


def _about_none(node):
    # numba leaves out one of both branches before it runs.
    parts = (each for each in ast.walk(node) if isinstance(each, ast.Constant))
    return any(each.value is None for each in parts)


def _is_bool(node):
    if isinstance(node, ast.BoolOp):
        return all(map(_is_bool, node.values))
    return isinstance(node, ast.Compare) or (
        isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)
    )


def _is_text(node):
    text = isinstance(node, ast.Constant) and not isinstance(node.value, int | float)
    return text or isinstance(node, ast.JoinedStr | ast.List | ast.Tuple)


def switched(path: str, text: str, number_of: Callable[[Mutant], int | None]) -> str:
    """Return the text of a module, each mutant that has a number behind a switch."""
    tree = Places(path, text, number_of).visit(ast.parse(text))
    after = next(
        i for i, each in enumerate(tree.body)
        if not isinstance(each, ast.Expr) and getattr(each, "module", "") != "__future__"
    ) if tree.body[1:] else len(tree.body)  # fmt: skip
    name = f"{PACKAGE}.{SWITCH}_switch"
    tree.body.insert(after, ast.ImportFrom(name, [ast.alias(SWITCH)], 0))
    return ast.unparse(ast.fix_missing_locations(tree))


def places(part: str) -> list[Mutant]:
    """Return all mutants of a part of the package."""
    found: list[Mutant] = []
    for path in sorted((ROOT / PACKAGE / part).rglob("*.py")):
        name = path.relative_to(ROOT / PACKAGE).as_posix()
        if path.name != "generated.py":
            switched(name, path.read_text(encoding="utf-8"), found.append)
    return found


def drawn(part: str, seed: int, count: int) -> list[Mutant]:
    """
    Return so many mutants of a part, of each kind about as many.

    Their order comes from what each is: a draw stays what it was where only other places are
    edited, and begins a larger one.
    """
    kinds: dict[str, list[Mutant]] = {}
    for each in sorted(places(part), key=lambda mutant: _drawn_at(seed, mutant)):
        kinds.setdefault(each.kind, []).append(each)
    turns = zip_longest(*(kinds[kind] for kind in sorted(kinds)))
    return [each for each in chain.from_iterable(turns) if each is not None][:count]


def _drawn_at(seed, mutant):
    return hashlib.sha256(f"{seed} {mutant.kind} {mutant}".encode()).digest()
