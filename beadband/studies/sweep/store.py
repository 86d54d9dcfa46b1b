"""The table of a sweep on disk: rows are appended as they finish, and a killed sweep goes on where it was.

While a sweep runs, sweep.csv holds the rows of its releases as they came, and there is no sweep.json. A kill may cut
the last row, no other. At the end the rows are copied in the order of the grid, those of the formula between them, and
sweep.json is written last. No column depends on the clock, so the same grid ends with the same bytes however it was
run. In memory there are eight bytes a scene: where its row begins.
"""

from __future__ import annotations

import csv
import fcntl
import os
from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from hashlib import blake2b
from itertools import islice
from pathlib import Path
from typing import IO, Any

import numpy as np

from beadband.errors import RunError, UsageError, explain
from beadband.observables import Column
from beadband.runs.folder import write_text
from beadband.studies.sweep.columns import columns_of
from beadband.studies.sweep.grid import Grid
from beadband.studies.sweep.row import DONE, Row, key_of
from beadband.studies.sweep.rungs import BLOCK, Block

TABLE = "sweep.csv"
SUMMARY = "sweep.json"
MANIFEST = "manifest.json"


class Store:
    """Rows of a sweep in a folder, for one process at a time; a context manager."""

    def __init__(self, folder: str | os.PathLike[str], grid: Grid) -> None:
        """Open or make the folder; UsageError when it holds something else, another grid, or a running sweep."""
        self.folder = Path(folder)
        self.columns = columns_of(grid)
        self._grid = grid
        self._starts = np.full(len(grid), -1, dtype=np.int64)
        """Where in the file the row of each scene begins."""
        self._end = 0
        self._handle: IO[bytes] | None = None
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

    @property
    def table(self) -> Path:
        """The file."""
        return self.folder / TABLE

    def _open(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        others = [entry.name for entry in self.folder.iterdir() if entry.name != TABLE]
        if not self.table.exists() and others:
            raise UsageError(
                explain(
                    "the output folder holds something else",
                    f"{str(self.folder)!r} with {len(others)} files and no {TABLE}",
                    "a new or empty folder, or that of a sweep",
                    "choose another with --out",
                )
            )
        self._handle = open(self.table, "a+b")  # noqa: SIM115  kept open, and locked
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
        marks, starts = self._scan()
        if len(marks):
            self._match(marks, starts)
        # What a kill left of a row goes, and so does the summary: from here on the sweep is not finished.
        (self.folder / SUMMARY).unlink(missing_ok=True)
        self._handle.truncate(self._end)
        if self._end == 0:
            self._write(_text([[one.name for one in self.columns]]))

    def _scan(self) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """Marks of the rows that are there already, and where those of releases begin, -1 for the others."""
        assert self._handle is not None
        self._handle.seek(0)
        marks, starts = array("Q"), array("q")
        names = [one.name for one in self.columns]
        model = names.index("model")
        for line in self._handle:
            if not line.endswith(b"\n"):
                break
            (row,) = csv.reader([line.decode("utf-8", "replace")])
            if self._end == 0 and row != names:
                raise self._other("a table with other columns")
            if len(row) != len(names):
                raise self._other(f"a row that can't be read: {row[0]}")
            if self._end:
                marks.append(_mark(row[0]))
                starts.append(-1 if row[model] == "formula" else self._end)
            self._end += len(line)
        return np.frombuffer(marks, dtype=np.uint64), np.frombuffer(starts, dtype=np.int64)

    def _match(self, marks: np.ndarray[Any, Any], starts: np.ndarray[Any, Any]) -> None:
        """Find the scenes of the rows that are there; UsageError for one of another grid."""
        order = np.lexsort((starts < 0, marks))
        known, first = np.unique(marks[order], return_index=True)
        starts, used = starts[order][first], np.zeros(len(known), dtype=bool)
        place = 0
        for keys in _in_blocks(key_of(values) for values in self._grid.scenes()):
            own = np.array([_mark(key) for key in keys], dtype=np.uint64)
            at = np.minimum(np.searchsorted(known, own), len(known) - 1)
            found = known[at] == own
            self._starts[place : place + len(keys)][found] = starts[at[found]]
            used[at[found]] = True
            place += len(keys)
        if not used.all():
            raise self._other(f"{int((~used).sum())} rows that are not of this grid")

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

    @property
    def kept(self) -> int:
        """Rows of releases that are there."""
        return int((self._starts >= 0).sum())

    def has(self, place: int) -> bool:
        """Whether the row of a scene was released and is there."""
        return bool(self._starts[place] >= 0)

    def add(self, rows: Iterable[tuple[int, Row]]) -> None:
        """Append finished rows, each with the place of its scene; RunError when they can't be written."""
        texts: list[bytes] = []
        for place, row in rows:
            key = key_of({axis.key: row[axis.key] for axis in self._grid.axes})
            self._starts[place] = self._end + sum(map(len, texts))
            texts.append(_text([[key, *(row.get(column.name, "") for column in self.columns[1:])]]))
        self._write(b"".join(texts))

    def _write(self, text: bytes) -> None:
        assert self._handle is not None
        try:
            self._handle.write(text)
            self._handle.flush()
        except OSError as error:
            raise self._full(error) from error
        self._end += len(text)

    def _full(self, error: OSError) -> RunError:
        return RunError(
            explain(
                "the table could not be written",
                f"{str(self.table)!r} ({error.strerror})",
                "a disk with room",
                "free some and start again: finished rows are kept",
            )
        )

    def note(self, manifest: str) -> None:
        """Write down what the table is of, before its first row."""
        write_text(self.folder / MANIFEST, manifest, durable=True)

    def put_in_order(self, blocks: Iterable[Block], see: Callable[[int, list[list[str]]], None]) -> None:
        """Copy the table in the order of the grid; ``see`` is shown the place of a block and its rows as texts."""
        partial = self.folder / f".{TABLE}.tmp"
        try:
            with open(partial, "wb") as out:
                out.write(_text([[one.name for one in self.columns]]))
                for block in blocks:
                    lines = list(self._lines(block))
                    out.write(b"".join(lines))
                    see(block.first, list(csv.reader(line.decode("utf-8") for line in lines)))
                out.flush()
                os.fsync(out.fileno())
            os.replace(partial, self.table)
        except OSError as error:
            raise self._full(error) from error

    def _lines(self, block: Block) -> Iterator[bytes]:
        """The rows of a block, as in the file."""
        assert self._handle is not None
        keys = [key_of(values) for values in block.scenes]
        answered = iter(_answered(self.columns, block, keys))
        for at, key in enumerate(keys):
            if block.known[at]:
                yield next(answered)
                continue
            self._handle.seek(self._starts[block.first + at])
            line = self._handle.readline()
            if not line.startswith(_text([[key]])[:-1]):
                raise RunError(explain("the table changed under the sweep", repr(key), "its row", "start again"))
            yield line

    def finish(self, summary: str) -> None:
        """Write the summary, which says that the sweep is finished."""
        write_text(self.folder / SUMMARY, summary, durable=True)


def _answered(columns: Sequence[Column], block: Block, keys: list[str]) -> list[bytes]:
    """The rows of the scenes that the formula answers, as in the file."""
    places = np.flatnonzero(block.known)
    if len(places) == 0:
        return []
    scenes = [block.scenes[at] for at in places.tolist()]
    cells: list[Iterable[Any]] = [[keys[at] for at in places.tolist()]]
    for column in columns[1:]:
        if column.name in block.columns:
            cells.append(["" if one != one else one for one in block.columns[column.name][places].tolist()])
        else:
            cells.append([one.get(column.name, "") for one in scenes])
    status = [column.name for column in columns].index("status")
    cells[status] = [DONE] * len(scenes)
    lines: list[bytes] = []
    csv.writer(_Sink(lines), lineterminator="\n").writerows(zip(*cells, strict=True))
    return lines


class _Sink:
    """A file that keeps its lines apart."""

    def __init__(self, lines: list[bytes]) -> None:
        self._lines = lines

    def write(self, text: str) -> None:
        # A row is a line, so that one which a kill has cut is known by its end.
        self._lines.append(text[:-1].replace("\n", " ").replace("\r", " ").encode("utf-8") + b"\n")


def _text(rows: Iterable[Iterable[Any]]) -> bytes:
    lines: list[bytes] = []
    csv.writer(_Sink(lines), lineterminator="\n").writerows(rows)
    return b"".join(lines)


def _mark(key: str) -> int:
    """A key as a number of 64 bits."""
    return int.from_bytes(blake2b(key.encode("utf-8"), digest_size=8).digest(), "little")


def _in_blocks(keys: Iterator[str]) -> Iterator[list[str]]:
    while some := list(islice(keys, BLOCK)):
        yield some
