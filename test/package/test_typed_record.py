"""Records for compiled code: types of fields, nesting, and what is refused."""

from collections.abc import Sequence
from enum import IntEnum
from typing import Annotated

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from peg_on_hole_ros.typed_record import Record, Vector3, at, dtype_of, new


class Shape(IntEnum):
    ROUND = 0
    SQUARE = 4


class Inner(Record):
    rate: float
    on: bool
    v: Vector3


class Outer(Record):
    tilt: Inner
    form: Shape
    loads: Annotated[Sequence[Inner], (2,)]


@njit
def change(record):
    record.tilt.rate = 4.0
    record.loads[1].v[2] = 5.0
    record.form = Shape.SQUARE
    record.loads[0] = record.loads[1]
    return record.form == Shape.SQUARE


def test_compiled_code_and_python_write_the_same_nested_fields():
    record = new(Outer)
    assert change(record)
    assert record.tilt.rate == 4.0
    assert record.loads[0].v.tolist() == [0.0, 0.0, 5.0]
    record.tilt.on = True
    assert record.tilt.on and record.form == Shape.SQUARE


def test_fields_are_aligned_and_of_their_types():
    kinds = dtype_of(Inner)
    assert kinds.isalignedstruct
    assert [kinds[name] for name in ("rate", "on")] == [np.float64, np.bool_]
    assert kinds["v"].shape == (3,)


def test_an_array_of_records_is_one_that_may_be_passed_on():
    class Holder(Record):
        count: int
        outer: Annotated[NDArray[np.void], Outer, (1,)]

    memory = np.zeros(1, dtype_of(Holder))
    part = memory[0]["outer"]
    assert part.dtype == dtype_of(Outer) and part.shape == (1,)
    assert change(at(Outer, part))
    assert memory["outer"]["tilt"]["rate"] == 4.0


def test_what_no_record_can_have_is_refused():
    class Text(Record):
        name: str

    class Bools(Record):
        seen: Annotated[NDArray[np.bool_], (2,)]

    class Hidden(Record):
        mean: float

    with pytest.raises(TypeError, match="Text.name is .*: a record has no such field"):
        dtype_of(Text)
    with pytest.raises(TypeError, match="Bools.seen is .*: a record has no such field"):
        dtype_of(Bools)
    with pytest.raises(TypeError, match="Hidden.mean: NumPy's records have a method"):
        dtype_of(Hidden)


def test_a_field_may_be_annotated_with_more_than_its_shape():
    class Noted(Record):
        rate: Annotated[float, "a note"]
        v: Annotated[Vector3, "another"]
        loads: Annotated[Sequence[Inner], (2,), "a third"]

    kinds = dtype_of(Noted)
    assert kinds["rate"] == np.float64
    assert (kinds["v"].shape, kinds["loads"].shape) == ((3,), (2,))
