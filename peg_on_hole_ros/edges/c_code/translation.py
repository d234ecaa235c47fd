"""
Translate the compiled filter step to C, from the same Python sources that numba compiles.

Only what those sources use is known: floats, integers, flat arrays and slices of them, rows of a
matrix, tuples and named tuples, loops over ranges, branches. Anything else raises, so that a step
that is translated is the whole step. Functions are specialised by the types of their arguments, as
numba does.
"""

import ast
import inspect
import textwrap

from peg_on_hole_ros.edges.c_code.expressions import (
    D,
    Expressions,
    I,
    Matrix,
    P,
    TranslationError,
    Tuple,
    value_kind,
    wider,
)


class Translation:
    """
    A C source in the making.

    Methods
    -------
    add(function, types)
        Translate a compiled function for argument types; returns its name in C and return type.
    text()
        Return the source.

    """

    def __init__(self):
        self._done: dict = {}
        self._bodies: list[str] = []
        self._structs: dict = {}

    def add(self, function, types) -> tuple[str, object]:
        """Translate a function and all that it calls."""
        function = getattr(function, "py_func", function)
        key = (function, tuple(types))
        if key not in self._done:
            body = _Function(self, function, types)
            name = f"{function.__name__.lstrip('_')}_{len(self._done)}"
            self._done[key] = (name, body.returns)
            self._bodies.append(body.text(name))
        return self._done[key]

    def c_type(self, kind) -> str:
        """Return how C writes a type."""
        if isinstance(kind, Matrix):
            return P
        if isinstance(kind, Tuple):
            if kind.items not in self._structs:
                parts = [self.c_type(item) for item in kind.items]
                name = f"tuple{len(self._structs)}"
                fields = " ".join(f"{part} v{i};" for i, part in enumerate(parts))
                self._structs[kind.items] = (name, f"typedef struct {{ {fields} }} {name};")
            return self._structs[kind.items][0]
        return "void" if kind is None else kind

    def text(self) -> str:
        """Return the C source, functions before those that call them."""
        head = ["#include <math.h>", *(text for _, text in self._structs.values())]
        return "\n".join(head) + "\n\n" + "\n".join(self._bodies)


class _Function(Expressions):
    """One function for one tuple of argument types."""

    def __init__(self, translation, function, types):
        self.translation, self.globals = translation, function.__globals__
        tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
        self.tree, self.types, self.returns = tree, {}, None
        names = [argument.arg for argument in tree.args.args]
        missing = names[len(types) :]
        defaults = (function.__defaults__ or ())[-len(missing) :] if missing else ()
        self.arguments = list(zip(names, types))
        self.constants = {n: None for n, value in zip(missing, defaults) if value is None}
        self.initial = {n: v for n, v in zip(missing, defaults) if value_kind(v) is not None}
        self.types = dict(self.arguments)
        self.types.update({n: value_kind(v) for n, v in self.initial.items()})
        self.lines, self.depth, self.temporaries = [], 1, 0
        # Types are found by going over the body until none changes.
        for _ in range(4):
            before = dict(self.types)
            self._body()
            if before == self.types:
                break

    def _body(self):
        self.lines, self.depth, self.temporaries = [], 1, 0
        for statement in self.tree.body:
            self._statement(statement)

    def text(self, name):
        c_type = self.translation.c_type
        self._body()
        given = [n for n, _ in self.arguments]
        listed = ", ".join(f"{c_type(self.types[n])} {n}" for n in given)
        own = [f"    {c_type(k)} {n};" for n, k in self.types.items() if n not in given]
        own += [f"    {n} = {v + 0!r};" for n, v in self.initial.items()]
        head = f"static inline {c_type(self.returns)} {name}({listed})\n{{"
        return "\n".join([head, *own, *self.lines, "}\n"])

    # Statements.

    def _emit(self, line):
        self.lines.append("    " * self.depth + line)

    def _statement(self, node):
        kind = type(node).__name__
        method = getattr(self, f"_on_{kind}", None)
        if method is None:
            raise TranslationError(f"{self.tree.name}: no translation of {ast.unparse(node)}")
        method(node)

    def _on_Expr(self, node):
        if isinstance(node.value, ast.Constant):
            return
        self._emit(f"{self._value(node.value)[0]};")

    def _on_Assign(self, node):
        first, *more = node.targets
        if more:
            text, kind = self._value(node.value)
            for target in node.targets:
                self._store(target, text, kind)
            return
        if isinstance(first, ast.Tuple) and isinstance(node.value, ast.Tuple):
            # All values are taken before any target is changed.
            held = []
            for value in node.value.elts:
                text, kind = self._value(value)
                held.append((self._temporary(text, kind), kind))
            for target, (text, kind) in zip(first.elts, held):
                self._store(target, text, kind)
            return
        self._store(first, *self._value(node.value))

    def _on_AugAssign(self, node):
        value = ast.BinOp(node.target, node.op, node.value)
        self._store(node.target, *self._value(value))

    def _on_Return(self, node):
        if node.value is None:
            self._emit("return;")
            return
        text, kind = self._value(node.value)
        self.returns = kind if self.returns is None else wider(self.returns, kind)
        self._emit(f"return {text};")

    def _on_If(self, node):
        self._emit(f"if ({self._value(node.test)[0]}) {{")
        self._block(node.body)
        if node.orelse:
            self._emit("} else {")
            self._block(node.orelse)
        self._emit("}")

    def _on_For(self, node):
        bounds = [self._value(a)[0] for a in node.iter.args]
        if node.iter.func.id != "range" or node.orelse or len(bounds) > 2:
            raise TranslationError(f"{self.tree.name}: loop over {ast.unparse(node.iter)}")
        low, high = ("0", *bounds)[-2:]
        name = node.target.id
        self.types[name] = I
        self._emit(f"for ({name} = {low}; {name} < {high}; {name}++) {{")
        self._block(node.body)
        self._emit("}")

    def _on_Break(self, node):
        self._emit("break;")

    def _on_Continue(self, node):
        self._emit("continue;")

    def _on_Pass(self, node):
        pass

    def _block(self, statements):
        self.depth += 1
        for statement in statements:
            self._statement(statement)
        self.depth -= 1

    def _temporary(self, text, kind):
        self.temporaries += 1
        name = f"held{self.temporaries}"
        self._emit(f"{self.translation.c_type(kind)} {name} = {text};")
        return name

    def _store(self, target, text, kind):
        if isinstance(target, ast.Tuple):
            held = self._temporary(text, kind)
            for i, item in enumerate(target.elts):
                if isinstance(kind, Tuple):
                    self._store(item, f"{held}.v{i}", kind.items[i])
                else:
                    self._store(item, f"{held}[{i}]", D)
        elif isinstance(target, ast.Name):
            known = self.types.get(target.id)
            self.types[target.id] = kind if known is None else wider(known, kind)
            self._emit(f"{target.id} = {text};")
        else:
            self._emit(f"{self._value(target)[0]} = {text};")
