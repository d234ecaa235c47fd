"""
Tuned numbers that compiled code reads from memory at run time, so that they vary within a process.

`benchmarks.tuned_numbers.whole` puts this file into a copy of the package, where `stand_in`
replaces each record of a `tuned.py`. Were the numbers constants, as they are in the package, each
value would be compiled anew. Beside each number a byte says whether it was read.
"""

import ctypes
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir
from numba.core import types
from numba.core.imputils import lower_constant, lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, models, register_model, typeof_impl

# By the type of a number: where it lies, and its type in compiled code.
KINDS = {
    float: (ctypes.c_double, types.float64, ir.DoubleType()),
    int: (ctypes.c_int64, types.int64, ir.IntType(64)),
}
STANDING_IN: dict[str, "StandIn"] = {}


class StandIn:
    """Has the fields of a record, which lie in memory."""

    def __init__(self, name: str, record: Any):
        fields = record._asdict()
        self.__dict__["name"] = name
        self.__dict__["places"] = {field: _place_of(value) for field, value in fields.items()}
        self.__dict__["marks"] = {field: ctypes.c_uint8(0) for field in fields}
        for field in fields:
            for symbol, of in zip(symbols(name, field), (self.places, self.marks), strict=True):
                llvm.add_symbol(symbol, ctypes.addressof(of[field]))

    def __getattr__(self, field: str) -> Any:
        """Return a number, or several."""
        if field not in self.places:
            raise AttributeError(field)
        self.marks[field].value = 1
        place = self.places[field]
        return tuple(place) if isinstance(place, ctypes.Array) else place.value

    def __setattr__(self, field: str, value: Any) -> None:
        """Put another number in its place, or others in those of several."""
        if isinstance(value, tuple):
            self.places[field][:] = value
        else:
            self.places[field].value = value


def _place_of(value):
    """Return memory that holds a number, or several floats."""
    if isinstance(value, tuple):
        return (ctypes.c_double * len(value))(*value)
    return KINDS[type(value)][0](value)


def symbols(name: str, field: str) -> tuple[str, str]:
    """Return the names by which compiled code finds a number, and the mark of its reading."""
    symbol = f"peg_on_hole_tuned_{name}_{field}".replace(".", "_")
    return symbol, f"{symbol}_read"


def stand_in(room: str, namespace: dict[str, Any]) -> None:
    """Replace the records of a room, which its `tuned.py` names in capitals."""
    for constant, record in list(namespace.items()):
        if isinstance(record, tuple) and hasattr(record, "_asdict"):
            name = f"{room}.{constant.lower()}"
            namespace[constant] = STANDING_IN[name] = StandIn(name, record)


def read_since() -> set[str]:
    """Return which numbers were read since it was last asked."""
    found = set()
    for name, record in STANDING_IN.items():
        for field, mark in record.marks.items():
            if mark.value:
                found.add(f"{name}.{field}")
                mark.value = 0
    return found


class StandInType(types.Opaque):
    """The type of one that stands in; its name tells which."""

    def __init__(self, name: str, fields: dict[str, types.Type]):
        self.of, self.fields = name, fields
        super().__init__(f"StandIn({name})")


register_model(StandInType)(models.OpaqueModel)


@typeof_impl.register(StandIn)
def _typeof(value, context):
    return StandInType(value.name, {f: _type_of(place) for f, place in value.places.items()})


def _type_of(place):
    if isinstance(place, ctypes.Array):
        return types.UniTuple(types.float64, len(place))
    return next(number for kept, number, _ in KINDS.values() if isinstance(place, kept))


@lower_constant(StandInType)
def _constant(context, builder, kind, value):
    return context.get_dummy_value()


@infer_getattr
class _Fields(AttributeTemplate):
    key = StandInType

    def generic_resolve(self, kind, field):
        return kind.fields.get(field)


@lower_getattr_generic(StandInType)
def _load(context, builder, kind, value, field):
    number, mark = symbols(kind.of, field)
    byte, of = ir.IntType(8), kind.fields[field]
    builder.store(byte(1), _place(builder.module, mark, byte))
    if not isinstance(of, types.UniTuple):
        width = next(each for each in KINDS.values() if each[1] == of)[2]
        return builder.load(_place(builder.module, number, width))
    row = builder.load(_place(builder.module, number, ir.ArrayType(ir.DoubleType(), of.count)))
    return context.make_tuple(
        builder, of, [builder.extract_value(row, i) for i in range(of.count)]
    )


def _place(module, symbol, width):
    if symbol in module.globals:
        return module.get_global(symbol)
    place = ir.GlobalVariable(module, width, symbol)
    place.linkage = "external"
    return place
