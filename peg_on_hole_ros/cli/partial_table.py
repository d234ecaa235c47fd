"""A table of numbers that is kept row by row, so that interrupted work goes on where it was."""

import csv
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.safe_text import printable


class PartialTable:
    """
    Rows of a CSV file in the making.

    Parameters
    ----------
    path : Path
        Of the finished file; until `finish` the rows are in a file beside it.
    columns : sequence of str
    state : str
        What the rows depend on, one line; rows kept under another state are dropped.
    group : int
        Rows that belong together: of a group that was cut off none is kept.

    Attributes
    ----------
    rows : list of list of str
        What is there already, and what was added.

    """

    def __init__(self, path: Path, columns: Sequence[str], state: str, group: int = 1) -> None:
        self.path, self.columns = Path(path), list(columns)
        self._partial = self.path.with_name(self.path.name + ".partial")
        self._state = state
        self.rows: list[list[str]] = []
        try:
            self._load(group)
            self._file = self._partial.open("w", newline="", encoding="utf-8")
        except OSError as error:
            raise PegOnHoleError(f"cannot write {self._partial}: {error.strerror}") from None
        self._file.write(f"{state}\n")
        self._writer = csv.writer(self._file)
        self._writer.writerows(self.rows)
        self._file.flush()

    def _load(self, group):
        if not self._partial.exists():
            return
        with self._partial.open(newline="", encoding="utf-8") as file:
            if file.readline().rstrip("\n") != self._state:
                return
            lines = file.readlines()
        # The last line may be cut off within.
        rows = list(csv.reader(line for line in lines if line.endswith("\n")))
        count = len(rows) // group * group
        self.rows = rows[:count]

    def add(self, rows: Iterable[Sequence]) -> None:
        """Append rows; they are on the disk when this returns."""
        texts = [[_cell_text(value) for value in row] for row in rows]
        self.rows += texts
        self._writer.writerows(texts)
        self._file.flush()

    def finish(self) -> None:
        """Write the finished file under its name and remove the partial one."""
        self._file.close()
        write_table(self.path, self.columns, self.rows)
        self._partial.unlink()

    def close(self) -> None:
        """Leave the partial file for another run, and say so."""
        self._file.close()
        print(
            f"kept: {len(self.rows)} rows in {printable(self._partial)}; the same command goes on "
            "from there",
            file=sys.stderr,
        )


def write_table(path: Path, columns: Sequence[str], rows: Iterable[Sequence]) -> None:
    """Write a CSV file that appears under its name when it is whole."""
    done = path.with_name(path.name + ".tmp")
    with done.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([[_cell_text(value) for value in row] for row in rows])
    done.replace(path)


def _cell_text(value) -> str:
    if isinstance(value, float):
        return "" if value != value else f"{value:.6g}"
    return str(value)
