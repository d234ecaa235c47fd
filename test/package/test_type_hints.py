"""Whoever calls the package is told the type of every argument and of what comes back."""

import ast

from simulated import ROOT

SOURCES = sorted((ROOT / "peg_on_hole_ros").rglob("*.py"))


def public(body, of_class=False):
    """Yield the functions that others may call, with whether each is a method."""
    for node in body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield from public(node.body, True)
        elif isinstance(node, (ast.If, ast.Try, ast.With)):
            yield from public(node.body, of_class)
        elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            special = of_class and node.name.startswith("__") and node.name.endswith("__")
            if special or not node.name.startswith("_"):
                yield node, of_class


def untyped(function, is_method):
    """Return the names of arguments without a type, and "return" for a result without one."""
    given = function.args
    several = [each for each in (given.vararg, given.kwarg) if each is not None]
    arguments = [*given.posonlyargs, *given.args, *given.kwonlyargs, *several]
    static = any(getattr(each, "id", "") == "staticmethod" for each in function.decorator_list)
    if is_method and not static:
        arguments = arguments[1:]
    names = [each.arg for each in arguments if each.annotation is None]
    return names + ["return"] * (function.returns is None)


def test_every_public_function_has_type_hints():
    seen, found = 0, {}
    for path in SOURCES:
        for function, is_method in public(ast.parse(path.read_text(encoding="utf-8")).body):
            seen += 1
            if missing := untyped(function, is_method):
                place = f"{path.relative_to(ROOT)}:{function.lineno} {function.name}"
                found[place] = missing
    assert not found
    # The whole package was looked at.
    assert len(SOURCES) > 200 and seen > 1000
