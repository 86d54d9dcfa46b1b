"""The table of a sweep on disk: rows are appended as they finish, and a killed sweep goes on where it was.

While a sweep runs, sweep.csv holds its finished rows as they came, and there is no sweep.json. At the end the rows are
put in the order of the grid, and sweep.json is written last. No column depends on the clock, so the same grid ends with
the same bytes however it was run.
"""

from __future__ import annotations

import csv
import fcntl
import io
import os
from collections.abc import Iterable
from pathlib import Path
from typing import IO

from beadband.errors import RunError, UsageError, explain
from beadband.runs.folder import write_text
from beadband.studies.sweep.grid import Grid
from beadband.studies.sweep.row import Row, columns, key_of

TABLE = "sweep.csv"
SUMMARY = "sweep.json"


class Store:
    """Rows of a sweep in a folder, for one process at a time; a context manager."""

    def __init__(self, folder: str | os.PathLike[str], grid: Grid) -> None:
        """Open or make the folder; UsageError when it holds something else, another grid, or a running sweep."""
        self.folder = Path(folder)
        self.columns = ("key", *(axis.key for axis in grid.axes), *columns())
        self._order = {key_of(values): place for place, values in enumerate(grid.scenes())}
        self.rows: dict[str, Row] = {}
        self._handle: IO[str] | None = None
        try:
            self._open()
        except OSError as error:
            self.close()
            raise UsageError(
                explain(
                    "the output folder can't be used",
                    f"{str(folder)!r} ({error.strerror})",
                    "a folder that can be made and written",
                    "choose another with --out",
                )
            ) from error
        except BaseException:
            self.close()
            raise

    def _open(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        table = self.folder / TABLE
        others = [entry.name for entry in self.folder.iterdir() if entry.name != TABLE]
        if not table.exists() and others:
            raise UsageError(
                explain(
                    "the output folder holds something else",
                    f"{str(self.folder)!r} with {len(others)} files and no {TABLE}",
                    "a new or empty folder, or that of a sweep",
                    "choose another with --out",
                )
            )
        self._handle = open(table, "a+", encoding="utf-8", newline="")  # noqa: SIM115  kept open, and locked
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UsageError(
                explain(
                    "another sweep is writing into this folder",
                    repr(str(self.folder)),
                    "one at a time",
                    "wait until it has finished",
                )
            ) from None
        self._handle.seek(0)
        text = self._handle.read()
        whole = text[: text.rfind("\n") + 1]
        if whole:
            self._take(whole)
        # What a kill left of a row goes, and so does the summary: from here on the sweep is not finished.
        (self.folder / SUMMARY).unlink(missing_ok=True)
        if len(whole) != len(text):
            self._handle.truncate(len(whole.encode("utf-8")))
        if not whole:
            self._write(self._head())

    def _take(self, text: str) -> None:
        """Rows that are there already; UsageError when they belong to another grid."""
        reader = csv.DictReader(io.StringIO(text))
        if tuple(reader.fieldnames or ()) != self.columns:
            raise self._other("a table with other columns")
        for row in reader:
            if row["key"] not in self._order:
                raise self._other(f"a row that is not of this grid: {row['key']}")
            self.rows[row["key"]] = dict(row)

    def _other(self, found: str) -> UsageError:
        return UsageError(
            explain(
                "the folder holds a sweep over another grid",
                f"{str(self.folder)!r} with {found}",
                "the same grid, or one that contains it with the same options",
                "choose another with --out",
            )
        )

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the folder for other sweeps."""
        if self._handle is not None:
            self._handle.close()
            self._handle = None

    def add(self, row: Row) -> None:
        """Append a finished row; RunError when it can't be written."""
        self.rows[row["key"]] = row
        self._write(row)

    def _write(self, row: Row) -> None:
        assert self._handle is not None
        try:
            self._handle.write(self._text([row]))
            self._handle.flush()
        except OSError as error:
            raise RunError(
                explain(
                    "the table could not be written",
                    f"{str(self.folder / TABLE)!r} ({error.strerror})",
                    "a disk with room",
                    "free some and start again: finished rows are kept",
                )
            ) from error

    def _head(self) -> Row:
        return dict(zip(self.columns, self.columns, strict=True))

    def _text(self, rows: Iterable[Row]) -> str:
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerows([row.get(column, "") for column in self.columns] for row in rows)
        return text.getvalue()

    def ordered(self) -> list[Row]:
        """All rows that there are, in the order of the grid."""
        return sorted(self.rows.values(), key=lambda row: self._order[row["key"]])

    def finish(self, summary: str) -> None:
        """Put the table in order and write the summary, which says that the sweep is finished."""
        write_text(self.folder / TABLE, self._text([self._head(), *self.ordered()]), durable=True)
        write_text(self.folder / SUMMARY, summary, durable=True)


def number(row: Row, column: str) -> float:
    """A number of a row, fresh or read back; NaN where there is none."""
    value = row.get(column, "")
    return float("nan") if value in ("", None) else float(value)
