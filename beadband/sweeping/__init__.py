"""Thousands of scenes: a grid or random draws of options, released on all cores or ranks, in one table.

grid (which scenes) -> workers (who releases them) -> row (what one gave) -> store (the table) -> summary, pictures.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from beadband.parallel import world
from beadband.sweeping import pictures, summary, workers
from beadband.sweeping.grid import Grid, grid_of
from beadband.sweeping.row import key_of
from beadband.sweeping.store import Row, Store

__all__ = ["Swept", "run_grid", "sweep"]

Follow = Callable[[int, int], None]
"""Called with the scenes that are done and all."""


@dataclass(frozen=True)
class Swept:
    """A finished sweep."""

    rows: tuple[Row, ...]
    """In the order of the grid; numbers are numbers in fresh rows and texts in those read back."""
    summary: dict[str, Any]
    pictures: tuple[Path, ...] = field(default=())

    @property
    def columns(self) -> dict[str, Any]:
        """The table as arrays of shape (rows,): numbers or text; NaN and "" where there is nothing."""
        return summary.columns(self.rows)

    def __getitem__(self, name: str) -> Any:
        return self.columns[name]

    def __len__(self) -> int:
        return len(self.rows)


def sweep(
    *,
    random: int | None = None,
    seed: int = 0,
    jobs: int | None = 1,
    out: str | os.PathLike[str] | None = None,
    follow: Follow | None = None,
    **options: Any,
) -> Swept:
    """Release every scene of a grid and return its table.

    Options are those of a scene, each a value, a list or text like "0.1:1.4:14" (both ends, 14 values); those that are
    left out keep their defaults, and V alone is asked for. ``random`` draws so many scenes instead. With ``out`` the
    table stands in that folder as sweep.csv, and a sweep that was killed goes on. ``jobs`` processes work, None for one
    on each core; a script that asks for more than one needs the usual ``if __name__ == "__main__"``.
    UsageError for a grid or folder that can't be used; a scene that has no answer is a row that says why.
    """
    return run_grid(grid_of(options, random, seed), jobs=jobs, out=out, follow=follow)


def run_grid(
    grid: Grid, *, jobs: int | None = 1, out: str | os.PathLike[str] | None = None, follow: Follow | None = None
) -> Swept:
    """The like of :func:`sweep` for a grid that is there. Under mpirun every rank calls it; rank 0 has the answer."""
    jobs = workers.check_jobs(jobs)
    if world().rank > 0:
        for _ in workers.run([], jobs):
            pass
        return Swept((), {})
    if out is None:
        rows: dict[str, Row] = {}
        totals = _work(grid, rows, lambda found: rows.update((row["key"], row) for row in found), jobs, follow)
        ordered = [rows[key_of(values)] for values in grid.scenes() if key_of(values) in rows]
        return Swept(tuple(ordered), _summary(grid, ordered, totals))
    with Store(out, grid) as store:
        totals = _work(grid, store.rows, store.add, jobs, follow)
        ordered = store.ordered()
        drawn = pictures.draw(ordered, store.folder)
        found = _summary(grid, ordered, totals)
        store.finish(json.dumps(found, indent=1, allow_nan=False) + "\n")
    return Swept(tuple(ordered), found, tuple(drawn))


def _work(
    grid: Grid, known: dict[str, Row], add: Callable[[Sequence[Row]], None], jobs: int, follow: Follow | None
) -> dict[str, Any]:
    """Release what is missing; how long it took, and how much of it was LAMMPS."""
    missing = {key_of(values): values for values in grid.scenes() if key_of(values) not in known}
    total, start = len({*known, *missing}), time.perf_counter()
    busy = inside = 0.0
    if follow:
        follow(total - len(missing), total)
    for rows, spent_s, lammps_s in workers.run(list(missing.values()), jobs):
        add(rows)
        busy, inside = busy + spent_s, inside + lammps_s
        if follow:
            follow(len(known), total)
    wall = time.perf_counter() - start
    return {
        "jobs": world().size if world().size > 1 else jobs,
        "released": len(missing),
        "wall_s": wall,
        "scenes_per_s": len(missing) / wall if missing else None,
        "lammps_share": inside / busy if busy else None,
    }


def _summary(grid: Grid, rows: list[Row], totals: dict[str, Any]) -> dict[str, Any]:
    from beadband.results import versions

    return {
        "grid": grid.as_dict(),
        **summary.summary(rows),
        "run": totals,
        "versions": versions(workers.lammps_version()),
    }
