"""Rows of outputs as NumPy has them: their type, and what the table of outputs has of them."""

from typing import get_type_hints

import numpy as np

from peg_on_hole_ros.outputs import Entry, Row
from peg_on_hole_ros.typed_record import Record, dtype_of

ROW = dtype_of(Row)


def entries(record: type[Record]) -> dict[str, Entry]:
    """Return the entries of the table by the name of their field, in order."""
    hints = get_type_hints(record, include_extras=True)
    return {
        name: next(each for each in hint.__metadata__ if isinstance(each, Entry))
        for name, hint in hints.items()
    }


OUTPUTS = entries(Row)
# The names in `~/monitor`: one list in one order for the life of a node, whatever is known.
MONITOR = {name: each for name, each in OUTPUTS.items() if each.topic == "monitor"}
MONITOR_NAMES = tuple(name for field, each in MONITOR.items() for name in each.names or (field,))

# The byte of a row at which their numbers begin.
MONITOR_AT: int = ROW.fields[next(iter(MONITOR))][1]  # type: ignore[index]


def _nothing() -> np.ndarray:
    rows = np.zeros(1, ROW)
    for name in ROW.names:  # type: ignore[union-attr]
        if ROW[name].base == np.float64:
            rows[name] = np.nan
    return rows


# A row, shape (1,), in which no number exists.
NOTHING = _nothing()

# An alarm that is `held` so is not judged.
NOT_JUDGED = 2
JAMMING, CONTACT_LOSS, OVERLOAD = range(3)
