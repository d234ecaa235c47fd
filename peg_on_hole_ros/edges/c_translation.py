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
from typing import NamedTuple

D, I, P = "double", "long", "double *"  # noqa: E741
_MATH = (
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt", "hypot", "exp", "expm1", "log",
    "log1p", "erf", "erfc", "floor", "ceil", "fabs",
)  # fmt: skip
_OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
_COMPARISONS = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip


class Matrix(NamedTuple):
    """A C-contiguous matrix of doubles of a given width."""

    width: int


class Tuple(NamedTuple):
    """A tuple by the types of its items, with their names where it is a named one."""

    items: tuple
    names: tuple = ()


class TranslationError(Exception):
    """The sources use something that is not translated."""


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


class _Function:
    """One function for one tuple of argument types."""

    def __init__(self, translation, function, types):
        self.translation, self.globals = translation, function.__globals__
        tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
        self.tree, self.types, self.returns = tree, {}, None
        names = [argument.arg for argument in tree.args.args]
        defaults = [None] * (len(names) - len(types))
        self.arguments = list(zip(names, [*types, *defaults]))
        self.constants = {n: None for n, kind in self.arguments if kind is None}
        self.types = {n: kind for n, kind in self.arguments if kind is not None}
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
        given = [n for n, kind in self.arguments if kind is not None]
        listed = ", ".join(f"{c_type(self.types[n])} {n}" for n in given)
        own = [f"    {c_type(k)} {n};" for n, k in self.types.items() if n not in given]
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
        self.returns = kind if self.returns is None else _wider(self.returns, kind)
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
            self.types[target.id] = kind if known is None else _wider(known, kind)
            self._emit(f"{target.id} = {text};")
        else:
            self._emit(f"{self._value(target)[0]} = {text};")

    # Expressions; each gives its text and its type.

    def _value(self, node):
        kind = type(node).__name__
        method = getattr(self, f"_of_{kind}", None)
        if method is None:
            raise TranslationError(f"{self.tree.name}: no translation of {ast.unparse(node)}")
        return method(node)

    def _of_Constant(self, node):
        return self._constant(node.value, node)

    def _constant(self, value, node):
        if isinstance(value, (bool, int)):
            return repr(int(value)), I
        if isinstance(value, float):
            return ("NAN" if value != value else repr(value).replace("inf", "INFINITY")), D
        raise TranslationError(f"{self.tree.name}: constant {ast.unparse(node)} = {value!r}")

    def _of_Name(self, node):
        if node.id in self.types:
            return node.id, self.types[node.id]
        if node.id in self.globals:
            return self._constant(self.globals[node.id], node)
        raise TranslationError(f"{self.tree.name}: {node.id} is read before it is known")

    def _of_Attribute(self, node):
        if node.attr == "real":
            return self._value(node.value)
        text, kind = self._value(node.value)
        return f"{text}.v{kind.names.index(node.attr)}", kind.items[kind.names.index(node.attr)]

    def _of_Tuple(self, node):
        parts = [self._value(item) for item in node.elts]
        return self._packed(parts)

    def _packed(self, parts, names=()):
        kind = Tuple(tuple(kind for _, kind in parts), tuple(names))
        inner = ", ".join(text for text, _ in parts)
        return f"(({self.translation.c_type(kind)}){{{inner}}})", kind

    def _of_Subscript(self, node):
        text, kind = self._value(node.value)
        if isinstance(node.slice, ast.Slice):
            low = self._value(node.slice.lower)[0] if node.slice.lower else "0"
            return f"({text} + {low})", P
        if isinstance(kind, Tuple):
            if isinstance(node.slice, ast.Constant):
                return f"{text}.v{node.slice.value}", kind.items[node.slice.value]
            if set(kind.items) != {D}:
                raise TranslationError(f"{self.tree.name}: place in {ast.unparse(node)}")
            return f"((double *)&{text})[{self._value(node.slice)[0]}]", D
        if isinstance(kind, Matrix):
            row, column = (self._value(item)[0] for item in node.slice.elts)
            return f"{text}[({row}) * {kind.width} + {column}]", D
        return f"{text}[{self._value(node.slice)[0]}]", D

    def _of_BinOp(self, node):
        left, kind = self._value(node.left)
        right, other = self._value(node.right)
        if isinstance(node.op, ast.Pow):
            return self._power(left, kind, node)
        if isinstance(node.op, ast.FloorDiv) and kind == other == I:
            # Of counts and places, which are not negative.
            return f"({left} / {right})", I
        if type(node.op) not in _OPERATORS:
            raise TranslationError(f"{self.tree.name}: operator in {ast.unparse(node)}")
        if isinstance(node.op, ast.Div):
            return f"((double)({left}) / ({right}))", D
        return f"({left} {_OPERATORS[type(node.op)]} {right})", _wider(kind, other)

    def _power(self, text, kind, node):
        exponent = ast.literal_eval(node.right)
        if not isinstance(exponent, int) or not 1 <= abs(exponent) <= 4:
            raise TranslationError(f"{self.tree.name}: power {ast.unparse(node)}")
        held = self._temporary(text, kind)
        product = " * ".join([held] * abs(exponent))
        return (f"({product})", kind) if exponent > 0 else (f"(1.0 / ({product}))", D)

    def _of_UnaryOp(self, node):
        text, kind = self._value(node.operand)
        return (f"(!{text})", I) if isinstance(node.op, ast.Not) else (f"(-{text})", kind)

    def _of_Compare(self, node):
        operands = [self._value(item)[0] for item in (node.left, *node.comparators)]
        pairs = zip(operands, node.ops, operands[1:])
        return " && ".join(f"({a} {_COMPARISONS[type(op)]} {b})" for a, op, b in pairs), I

    def _of_BoolOp(self, node):
        sign = " && " if isinstance(node.op, ast.And) else " || "
        return f"({sign.join(f'({self._value(item)[0]})' for item in node.values)})", I

    def _of_IfExp(self, node):
        if isinstance(node.test, ast.Compare) and isinstance(node.test.ops[0], ast.Is):
            absent = node.test.left.id in self.constants
            return self._value(node.body if absent else node.orelse)
        test = self._value(node.test)[0]
        (left, kind), (right, other) = self._value(node.body), self._value(node.orelse)
        return f"({test} ? {left} : {right})", _wider(kind, other)

    def _of_Call(self, node):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else node.func.id
        arguments = [self._value(item) for item in node.args]
        texts = [text for text, _ in arguments]
        if name in ("min", "max"):
            return self._extreme(name, arguments)
        if name == "int":
            return f"((long)({texts[0]}))", I
        if name in _MATH:
            return f"{name}({', '.join(texts)})", D
        if name == "isfinite":
            return f"isfinite({texts[0]})", I
        target = self._called(node.func)
        if hasattr(target, "_fields"):
            return self._packed(arguments, target._fields)
        if getattr(target, "py_func", None) is None:
            raise TranslationError(f"{self.tree.name}: call of {ast.unparse(node)}")
        c_name, kind = self.translation.add(target, [kind for _, kind in arguments])
        return f"{c_name}({', '.join(texts)})", kind

    def _called(self, node):
        if isinstance(node, ast.Attribute):
            return getattr(self.globals[node.value.id], node.attr)
        return self.globals[node.id]

    def _extreme(self, name, arguments):
        kind = D if any(kind == D for _, kind in arguments) else I
        first, *more = (self._temporary(text, kind) for text, _ in arguments)
        sign = "<" if name == "min" else ">"
        for other in more:
            first = f"({other} {sign} {first} ? {other} : {first})"
        return first, kind


def _wider(kind, other):
    if kind == other:
        return kind
    if {kind, other} == {D, I}:
        return D
    raise TranslationError(f"one name for {kind} and {other}")
