"""One table of many bags: a row for each try to insert, and one for each bag without any."""

import csv
from collections.abc import Iterable
from io import StringIO
from pathlib import Path

from peg_on_hole_ros.cli.output_paths import write_text
from peg_on_hole_ros.records import ALARM_LEVELS, CONTACTS

CSV, PARQUET = "bags.csv", "bags.parquet"
# Each column with its type; what does not exist is empty.
COLUMNS: dict[str, type] = {
    "bag": str,
    "folder": str,
    "sha256": str,
    "exit_code": int,
    "error": str,
    "messages_read": int,
    "messages_used": int,
    "bag_duration": float,
    "bag_alarms": int,
    "doubts": int,
    "doubt": str,
    "tries": int,
    "try": int,
    "outcome": str,
    "start_time": float,
    "duration": float,
    "transition_time": float,
    **{f"peak_{name}": float for name in CONTACTS},
    "alarms": int,
    "worst_alarm": str,
}


def rows_of(result: dict) -> list[dict]:
    """
    Return the rows of a bag, as `COLUMNS` has them: times [s], peaks [N].

    Parameters
    ----------
    result : dict
        Of `work`.

    """
    row = dict.fromkeys(COLUMNS) | {
        "bag": result["path"],
        "folder": result["name"],
        "sha256": (result["key"] or {}).get("bag"),
        "exit_code": result["exit_code"],
        "error": result["error"],
        "doubts": len(result["doubts"]),
        "doubt": next(iter(result["doubts"]), None),
    }
    summary = result["summary"]
    if summary is None:
        return [row]
    row |= {
        "messages_read": summary["messages"]["read"],
        "messages_used": summary["messages"]["used"],
        "bag_duration": summary["duration"],
        "bag_alarms": sum(alarm["level"] != "OK" for alarm in summary["alarms"]),
        "tries": len(summary["cycles"]),
    }
    return [row | _try(i, one) for i, one in enumerate(summary["cycles"], 1)] or [row]


def _try(number, cycle):
    peaks = {f"peak_{name}": cycle["peak_normal"][name] for name in CONTACTS}
    alarms = cycle["alarms"]
    worst = max(alarms, key=lambda alarm: ALARM_LEVELS.index(alarm["level"]), default=None)
    return {
        "try": number,
        "outcome": cycle["outcome"],
        "start_time": cycle["start_time"],
        "duration": cycle["duration"],
        "transition_time": cycle["transition_time"],
        **peaks,
        "alarms": cycle["alarm_count"],
        "worst_alarm": worst and f"{worst['name']} {worst['level']}",
    }


def write_tables(folder: Path, rows: Iterable[dict]) -> list[Path]:
    """Write CSV, and Parquet where pyarrow is installed; return what was written."""
    rows = list(rows)
    text = StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(folder / CSV, text.getvalue())
    written = [folder / CSV]
    try:
        import pyarrow
        from pyarrow import parquet
    except ModuleNotFoundError:
        return written
    types = {str: pyarrow.string(), int: pyarrow.int64(), float: pyarrow.float64()}
    schema = pyarrow.schema([(name, types[kind]) for name, kind in COLUMNS.items()])
    part = folder / f"{PARQUET}.part"
    parquet.write_table(pyarrow.Table.from_pylist(rows, schema), part)
    part.replace(folder / PARQUET)
    return [*written, folder / PARQUET]
