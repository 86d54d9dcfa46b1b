"""Thousands of scenes: a grid or random draws of options, released on all cores or ranks, in one table.

grid (which scenes) -> row (one release, on the studies' pool) -> store (the table) -> summary, pictures.
"""

from __future__ import annotations

import json
import os
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from beadband.errors import UsageError, explain
from beadband.lammps.engine import Session
from beadband.lammps.ranks import world
from beadband.studies import pool
from beadband.studies.sweep import pictures, summary
from beadband.studies.sweep.grid import Grid, grid_of
from beadband.studies.sweep.row import RELEASE, Row, key_of, without_result
from beadband.studies.sweep.store import Store

__all__ = ["Swept", "run_grid", "sweep"]

_CHUNK = 48
"""Most scenes that are handed over at once, and released in batches: a tenth of a second of short releases."""


@dataclass(frozen=True)
class Swept:
    """A finished sweep."""

    rows: tuple[Row, ...]
    """In the order of the grid; numbers are numbers in fresh rows, and text in those of an earlier sweep."""
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

    def __repr__(self) -> str:
        status = Counter(row["status"] for row in self.rows)
        return (
            f"<Sweep of {len(self)} scenes: {', '.join(f'{count} {name}' for name, count in sorted(status.items()))}>"
        )


def sweep(
    *,
    random: int | None = None,
    seed: int | None = None,
    sample: str | None = None,
    jobs: int | None = 1,
    executor: Executor | None = None,
    out: str | os.PathLike[str] | None = None,
    follow: pool.Progress | None = None,
    **options: Any,
) -> Swept:
    """Release every scene of a grid and return its table.

    Parameters
    ----------
    options
        Those of a scene, each a value, a list, or text such as "0.1:1.4:14" (both ends, 14 values). What is left out
        keeps its default, except that ``for`` is "speed": the plan gets V right, and the curvature as it comes.
    random, seed, sample
        Draw so many scenes instead of the whole grid: "random" ones, a "latin-hypercube", or Sobol' points, "sobol".
    jobs
        Number of processes; None for one per core. A script that asks for more than one needs the usual
        ``if __name__ == "__main__"``.
    executor
        Runs the scenes instead, and stays open; a :class:`concurrent.futures.Executor` of processes, local or not.
    out
        Folder of the table sweep.csv, its totals and pictures; a sweep that was killed there continues.
    follow
        Called with the number of scenes that are done, and of all.

    Raises
    ------
    UsageError
        The grid or the folder can't be used. A scene without an answer is a row that gives the reason.
    """
    return run_grid(grid_of(options, random, seed, sample), jobs=jobs, executor=executor, out=out, follow=follow)


def run_grid(
    grid: Grid,
    *,
    jobs: int | None = 1,
    executor: Executor | None = None,
    out: str | os.PathLike[str] | None = None,
    follow: pool.Progress | None = None,
) -> Swept:
    """:func:`sweep` of a grid that was built before. Under mpirun every rank calls it, and rank 0 returns the table."""
    number = pool.jobs_of(jobs)
    if world().size > 1:
        if executor is not None or jobs not in (None, 1):
            raise UsageError(
                explain(
                    "the ranks of mpirun release the scenes",
                    "an executor" if executor is not None else f"{jobs} jobs",
                    "neither jobs nor an executor under mpirun",
                    "leave out --jobs, or start without mpirun",
                )
            )
        number = world().size - 1
    if world().rank > 0:
        with pool.ranks():
            return Swept((), {})
    if out is None:
        rows: dict[str, Row] = {}
        totals = _work(grid, rows, lambda row: rows.update({row["key"]: row}), number, executor, follow)
        ordered = [rows[key_of(values)] for values in grid.scenes()]
        return Swept(tuple(ordered), _summary(grid, ordered, totals))
    with Store(out, grid) as store:
        totals = _work(grid, store.rows, store.add, number, executor, follow)
        ordered = store.ordered()
        drawn = pictures.draw(ordered, store.folder)
        found = _summary(grid, ordered, totals)
        store.finish(json.dumps(found, indent=1, allow_nan=False) + "\n")
    return Swept(tuple(ordered), found, tuple(drawn))


def _work(
    grid: Grid,
    known: dict[str, Row],
    add: Callable[[Row], None],
    jobs: int,
    executor: Executor | None,
    follow: pool.Progress | None,
) -> dict[str, Any]:
    """Release what is missing; return how long it took, and how much of that was LAMMPS."""
    scenes = {key_of(values): values for values in grid.scenes()}
    missing = [values for key, values in scenes.items() if key not in known]
    busy, inside, start = 0.0, 0.0, time.perf_counter()
    if follow:
        follow(len(known), len(scenes))
    with pool.ranks() as others:
        given = others if executor is None else executor
        for index, outcome in pool.run_tasks(RELEASE, missing, jobs=jobs, executor=given, chunk=_CHUNK):
            if isinstance(outcome, pool.Failed):
                add(without_result(missing[index], outcome))
            else:
                row, spent_s, lammps_s = outcome
                add(row)
                busy, inside = busy + spent_s, inside + lammps_s
            if follow:
                follow(len(known), len(scenes))
    wall = time.perf_counter() - start
    return {
        "jobs": world().size if world().size > 1 else None if executor is not None else jobs,
        "released": len(missing),
        "wall_s": wall,
        "scenes_per_s": len(missing) / wall if missing else None,
        "lammps_share": inside / busy if busy else None,
    }


def _summary(grid: Grid, rows: list[Row], totals: dict[str, Any]) -> dict[str, Any]:
    from beadband.runs.results import versions

    with Session() as session:
        version = session.run("", {})
    return {"grid": grid.as_dict(), **summary.summary(rows), "run": totals, "versions": versions(version)}
