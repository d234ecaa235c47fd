"""Records that compiled code takes: a class states the fields, and their NumPy type follows."""

from types import UnionType
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Vector2 = Annotated[Floats, (2,)]
Vector3 = Annotated[Floats, (3,)]
Vector6 = Annotated[Floats, (6,)]
Matrix2 = Annotated[Floats, (2, 2)]
Matrix3 = Annotated[Floats, (3, 3)]
Matrix6 = Annotated[Floats, (6, 6)]

_SCALARS = {float: np.float64, int: np.int64, bool: np.bool_}


class Record:
    """
    Base of all records: a subclass annotates its fields.

    A field is a `float`, an `int`, a `bool`, an `IntEnum` (kept as an int), another `Record`
    (nested), or `Annotated[type, shape]`: an array of a type, of a shape that is a tuple of int;
    `Annotated[NDArray[np.void], record, shape]` is one of records that is passed on as an array.
    Whatever else a field is annotated with is left to others.
    Compiled code and Python read and write the fields of what `new` returns as attributes, and
    mypy knows their types. A record is passed by reference; to assign one record to another
    copies all fields.
    """


RecordType = TypeVar("RecordType", bound=Record)

# Each record's type is made once: that takes a millisecond.
_DTYPES: dict[type[Record], np.dtype[np.void]] = {}


def dtype_of(record: type[Record]) -> np.dtype[np.void]:
    """
    Return the NumPy type of a record, aligned as C does it.

    Raises
    ------
    TypeError
        A field has a type that no record can have, or the name of a method of NumPy's records,
        which would hide it in Python (as `mean` and `copy` are).

    """
    found = _DTYPES.get(record)
    if found is None:
        found = _DTYPES[record] = _built(record)
    return found


def _built(record: type[Record]) -> np.dtype[np.void]:
    hints = get_type_hints(record, include_extras=True)
    for name in hints:
        if hasattr(np.record, name):
            raise TypeError(
                f"{record.__name__}.{name}: NumPy's records have a method of that name"
            )
    return np.dtype([(name, *_field(record, name, of)) for name, of in hints.items()], align=True)


def _field(record: type[Record], name: str, of: Any) -> tuple[Any, ...]:
    if get_origin(of) is Annotated:
        inner, *more = get_args(of)
        shape = next((each for each in more if isinstance(each, tuple)), None)
        if shape is None:
            return _field(record, name, inner)
        if get_origin(inner) is np.ndarray:
            (scalar,) = get_args(get_args(inner)[1])
            nested = [each for each in more if isinstance(each, type) and issubclass(each, Record)]
            # Numba knows no arrays of bool in a record.
            if scalar is not np.bool_:
                return dtype_of(nested[0]) if nested else scalar, shape
            raise _unknown(record, name, of)
        (item,) = get_args(inner) or (inner,)
        return (*_field(record, name, item), shape)
    if isinstance(of, type) and not isinstance(of, UnionType):
        if issubclass(of, Record):
            return (dtype_of(of),)
        for kind, scalar in _SCALARS.items():
            if of is kind or (kind is int and issubclass(of, int) and of is not bool):
                return (scalar,)
    raise _unknown(record, name, of)


def _unknown(record, name, of):
    return TypeError(f"{record.__name__}.{name} is {of}: a record has no such field")


def new(record: type[RecordType]) -> RecordType:
    """Return a record of zeros, as compiled code takes it (a `numpy.record`, one element)."""
    made: Any = np.zeros(1, dtype_of(record)).view(np.recarray)[0]
    return made


def at(record: type[RecordType], memory: NDArray[np.void]) -> RecordType:
    """Return the record that an array of one holds, shape (1,): the same memory."""
    found: RecordType = memory.view(np.recarray)[0]
    return found
