"""C for the expressions of Python sources that numba compiles, each with its type."""

import ast
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


class Expressions:
    """
    The expressions of one function.

    Who inherits has `tree` (of the function), `types` (of its variables by name), `constants`
    (arguments that are None), `globals`, `translation`, and `_temporary(text, kind)`.
    """

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
        if isinstance(node.op, ast.Mod) and kind == other == I:
            return f"({left} % {right})", I
        if type(node.op) not in _OPERATORS:
            raise TranslationError(f"{self.tree.name}: operator in {ast.unparse(node)}")
        if isinstance(node.op, ast.Div):
            return f"((double)({left}) / ({right}))", D
        return f"({left} {_OPERATORS[type(node.op)]} {right})", wider(kind, other)

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
        return f"({test} ? {left} : {right})", wider(kind, other)

    def _of_Call(self, node):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else node.func.id
        arguments = [self._value(item) for item in (*node.args, *self._by_name(node))]
        texts = [text for text, _ in arguments]
        if name in ("min", "max"):
            return self._extreme(name, arguments)
        if name == "int":
            return f"((long)({texts[0]}))", I
        if name in _MATH:
            return f"{name}({', '.join(texts)})", D
        if name == "isfinite":
            return f"isfinite({texts[0]})", I
        if name == "reshape":
            return self._value(node.func.value)[0], Matrix(int(texts[1]))
        target = self._called(node.func)
        if hasattr(target, "_fields"):
            return self._packed(arguments, target._fields)
        if getattr(target, "py_func", None) is None:
            raise TranslationError(f"{self.tree.name}: call of {ast.unparse(node)}")
        c_name, kind = self.translation.add(target, [kind for _, kind in arguments])
        return f"{c_name}({', '.join(texts)})", kind

    def _by_name(self, node):
        """Return the values given by name, in their order; only the next ones in line may be."""
        if not node.keywords:
            return []
        code = self._called(node.func).py_func.__code__
        names = code.co_varnames[len(node.args) : code.co_argcount]
        given = [keyword.arg for keyword in node.keywords]
        if given != list(names[: len(given)]):
            raise TranslationError(f"{self.tree.name}: names out of order in {ast.unparse(node)}")
        return [keyword.value for keyword in node.keywords]

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


def value_kind(value):
    """Return the type of a constant, or None where it is none that C knows."""
    if isinstance(value, (bool, int)):
        return I
    return D if isinstance(value, float) else None


def wider(kind, other):
    """Return the type that holds values of both."""
    if kind == other:
        return kind
    if {kind, other} == {D, I}:
        return D
    raise TranslationError(f"one name for {kind} and {other}")
