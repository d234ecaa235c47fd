"""What a tree of objects holds, kept so that it can be gone back to."""

from collections import deque
from dataclasses import is_dataclass
from enum import Enum

import numpy as np

_PACKAGE = __name__.rpartition(".")[0]
_MUTABLE = (list, deque, dict, np.ndarray)
_UNCHANGING, _COPIED, _PART = range(3)


class _Kinds(dict):
    # What becomes of a value, by its type; looked up once.
    def __missing__(self, kind):
        self[kind] = _kind(kind)
        return self[kind]


def _kind(kind):
    if issubclass(kind, _MUTABLE):
        return _COPIED
    own = kind.__module__.startswith(_PACKAGE) and kind.__dictoffset__
    # Records do not change.
    return (
        _PART
        if own and not is_dataclass(kind) and not issubclass(kind, (tuple, Enum))
        else _UNCHANGING
    )


_kinds = _Kinds()


def remember(part) -> list:
    """
    Return what an object, and those of this package that it is made of, hold.

    Lists, deques, dicts and arrays are copied, one level deep; all else counts as unchanging.
    """
    kept: list = []
    _remember(part, kept)
    return kept


def _remember(part, kept):
    values = vars(part).copy()
    copied = []
    for name, value in values.items():
        kind = _kinds[type(value)]
        if kind == _COPIED:
            copied.append((name, value.copy()))
        elif kind == _PART:
            _remember(value, kept)
    kept.append((part, values, copied))


def recall(kept: list) -> None:
    """Go back to what `remember` returned; it can be gone back to again."""
    for part, values, copied in kept:
        vars(part).clear()
        vars(part).update(values)
        for name, value in copied:
            if isinstance(value, np.ndarray):
                # In place: others may look at the same memory.
                values[name][...] = value
            else:
                vars(part)[name] = value.copy()
