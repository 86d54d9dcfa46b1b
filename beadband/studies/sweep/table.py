"""A finished table, read as it is wanted: row by row, as arrays, or copied to Parquet."""

from __future__ import annotations

import csv
import tempfile
from array import array
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from beadband.errors import UsageError, explain
from beadband.lammps.files import refused
from beadband.observables import Column
from beadband.studies.sweep.columns import typed
from beadband.studies.sweep.row import Row

PARQUET = "sweep.parquet"
_GROUP_ROWS = 1 << 10
"""Rows of a group in a Parquet file."""


@dataclass(frozen=True, repr=False)
class Swept:
    """A finished sweep."""

    path: Path | None
    """The table, sweep.csv; None on ranks of MPI other than the first."""
    described: tuple[Column, ...]
    """Its columns: name, kind, unit and what each is."""
    summary: dict[str, Any]
    pictures: tuple[Path, ...] = ()
    scratch: tempfile.TemporaryDirectory[str] | None = field(default=None, compare=False)
    """Holds the table of a sweep without a folder of its own, as long as this is in use."""

    def __iter__(self) -> Iterator[Row]:
        """Rows in the order of the grid, one after another: numbers, texts, None for a number that is not there."""
        # A generator of its own keeps the scratch folder until it is through.
        if self.path is not None:
            yield from rows_of(self.path, self.described)

    @cached_property
    def rows(self) -> tuple[Row, ...]:
        """All of them, some 3 kB each."""
        return tuple(self)

    @cached_property
    def columns(self) -> dict[str, Any]:
        """The table as arrays of shape (rows,): numbers or text; NaN and "" where there is nothing."""
        numbers = {one.name: array("d") for one in self.described if one.kind != "text"}
        texts: dict[str, list[str]] = {one.name: [] for one in self.described if one.kind == "text"}
        for row in self:
            for name, column in numbers.items():
                column.append(np.nan if row[name] is None else row[name])
            for name, words in texts.items():
                words.append(row[name])
        return {
            one.name: np.frombuffer(numbers[one.name]) if one.name in numbers else np.array(texts[one.name])
            for one in self.described
        }

    def __getitem__(self, name: str) -> Any:
        return self.columns[name]

    def __len__(self) -> int:
        return int(self.summary.get("scenes", 0))

    def __repr__(self) -> str:
        status = Counter(self.summary.get("status", {}))
        return (
            f"<Sweep of {len(self)} scenes: {', '.join(f'{count} {name}' for name, count in sorted(status.items()))}>"
        )


def rows_of(path: Path, columns: Sequence[Column]) -> Iterator[Row]:
    """Rows of a table, one after another."""
    with open(path, encoding="utf-8", newline="") as handle:
        reader = csv.reader(handle)
        next(reader)
        for row in reader:
            yield typed(columns, row)


def require_parquet() -> None:
    """UsageError where pyarrow is missing."""
    try:
        import pyarrow  # noqa: F401
    except ImportError as error:
        raise UsageError(
            explain("Parquet needs pyarrow", str(error), "the pyarrow package", "pip install 'beadband[parquet]'")
        ) from error


def write_parquet(table: Path, columns: Sequence[Column]) -> Path:
    """Copy a table to sweep.parquet beside it, in parts; RunError when it can't be written.

    Types are those of the columns, whose units and sentences are kept as metadata of the fields.
    """
    import pyarrow as arrow
    from pyarrow import csv as reading
    from pyarrow import parquet

    kinds = {"number": arrow.float64(), "integer": arrow.int64(), "text": arrow.string()}
    fields = [
        arrow.field(one.name, kinds[one.kind], metadata={"unit": one.unit, "description": one.sentence})
        for one in columns
    ]
    schema = arrow.schema(fields)
    path = table.with_name(PARQUET)
    partial = path.with_name(f".{PARQUET}.tmp")
    types = reading.ConvertOptions(column_types=schema, strings_can_be_null=False, null_values=[""])
    names = reading.ReadOptions(use_threads=False, column_names=schema.names)
    try:
        with open(table, "rb") as lines, parquet.ParquetWriter(partial, schema) as writer:
            next(lines)
            # The reader's own streaming reads far ahead: a row is a line, and lines are given in parts.
            while some := b"".join(islice(lines, _GROUP_ROWS)):
                part = reading.read_csv(arrow.BufferReader(some), names, convert_options=types)
                writer.write_table(part.cast(schema))
        partial.replace(path)
    except OSError as error:
        raise refused(path, error) from error
    return path
