"""/step of recordings as one table: a row a step, nested values in columns of their own."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from asddpg.atomic_write import locked
from asddpg.errors import UserError, import_extra
from asddpg.recording.messages.topics import STEP_SCHEMA

FILE = "file"  # the column that names the recording
SUFFIXES = (".csv", ".parquet")
_EXTRA = ("parquet", ".parquet files")

Row = dict[str, Any]


def row_of(file: str, step: Mapping[str, Any]) -> Row:
    """A step as a row: action_v, terms_progress and so on; missing values leave their columns empty."""
    row: Row = {FILE: file}
    for name, schema in STEP_SCHEMA["properties"].items():
        value = step.get(name)
        if "properties" in schema:
            parts = dict.fromkeys(schema["properties"]) | dict(value if isinstance(value, Mapping) else {})
            row |= {f"{name}_{part}": each for part, each in parts.items()}
        else:
            row[name] = value
    return row


def write_table(path: Path, rows: Sequence[Row]) -> None:
    """Write all rows; those of one recording may lack columns that another has.

    Raises:
        UserError: it cannot be written.
    """
    columns = list(dict.fromkeys(name for row in rows for name in row))
    part = path.with_name(path.name + ".part")
    try:
        with locked(path.parent):
            if path.suffix == ".csv":
                _write_csv(part, columns, rows)
            else:
                _write_parquet(part, columns, rows)
            part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise UserError(f"the table {path} cannot be written: {error.strerror or error}") from error


def check_can_write(path: Path) -> None:
    """UserError where a table of that name cannot be written; called before any recording is read."""
    if path.suffix not in SUFFIXES:
        raise UserError(f"a table's file must end in {' or '.join(SUFFIXES)}, not {path.name!r}")
    if not path.parent.is_dir():
        raise UserError(f"the table {path} cannot be written: there is no folder {path.parent}")
    if path.suffix == ".parquet":
        import_extra("pyarrow", *_EXTRA)


def _write_csv(path: Path, columns: Sequence[str], rows: Sequence[Row]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns)
        writer.writeheader()
        writer.writerows(rows)


def _write_parquet(path: Path, columns: Sequence[str], rows: Sequence[Row]) -> None:
    arrow, parquet = import_extra("pyarrow", *_EXTRA), import_extra("pyarrow.parquet", *_EXTRA)
    arrays = [arrow.array([row.get(name) for row in rows]) for name in columns]
    # A column without a value has no type of its own, which other programs cannot read.
    arrays = [array.cast(arrow.float64()) if arrow.types.is_null(array.type) else array for array in arrays]
    parquet.write_table(arrow.table(arrays, names=list(columns)), str(path))
