"""Thousands of scenes and more: a grid or random draws of options, on all cores, ranks or an engine, in one table.

grid (which scenes) -> rungs (which of them the formula answers) -> row (one release, on the studies' pool) -> store
(the table) -> summary, pictures, table. Scenes are made, handed out and written as they come: memory does not grow with
them, but for 16 bytes a scene.
"""

from __future__ import annotations

import json
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import asdict
from typing import Any

from beadband.errors import UsageError, explain
from beadband.lammps.engine import Session
from beadband.lammps.ranks import world
from beadband.runs.clock import peak_bytes
from beadband.studies import pool
from beadband.studies.engines import PATIENCE_S
from beadband.studies.sweep import pictures
from beadband.studies.sweep.costs import MOST_BATCH_S, Estimate, estimate, seconds_of
from beadband.studies.sweep.grid import Grid, Values, grid_of
from beadband.studies.sweep.row import RELEASE, without_result
from beadband.studies.sweep.rungs import Rungs
from beadband.studies.sweep.store import Store
from beadband.studies.sweep.summary import Totals
from beadband.studies.sweep.table import Swept, require_parquet, write_parquet

__all__ = ["Swept", "run_grid", "sweep"]

_CHUNK = 48
"""Most scenes that are handed over at once, and released in batches: a tenth of a second of short releases."""
_LATE = 20.0
"""Expected times of a batch that it may take, beyond the patience, before its worker counts as hung."""

Announce = Callable[[Estimate], None]


def sweep(
    *,
    random: int | None = None,
    seed: int | None = None,
    sample: str | None = None,
    by: str | None = None,
    jobs: int | None = 1,
    executor: Executor | None = None,
    out: str | os.PathLike[str] | None = None,
    parquet: bool = False,
    hang_after: float = PATIENCE_S,
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
    by
        "cheapest", also None, leaves to the formula of :func:`beadband.ask` what it answers within the tolerance, and
        releases the rest. "runs" releases every scene.
    jobs
        Number of processes; None for one per core. A script that asks for more than one needs the usual
        ``if __name__ == "__main__"``.
    executor
        Runs the scenes instead, and stays open; a :class:`concurrent.futures.Executor` of processes, local or not.
        ``jobs`` then is the number of its workers, where it does not say so itself.
    out
        Folder of the table sweep.csv, its totals and pictures; a sweep that was killed there continues. Without it the
        table is kept as long as the result.
    parquet
        Write sweep.parquet too.
    hang_after
        Seconds beyond the expected ones after which a worker counts as hung; its scenes are done again elsewhere.
    follow
        Called with the number of scenes that are done, and of all.

    Raises
    ------
    UsageError
        The grid or the folder can't be used. A scene without an answer is a row that gives the reason.
    """
    grid = grid_of(options, random, seed, sample)
    return run_grid(
        grid, by=by, jobs=jobs, executor=executor, out=out, parquet=parquet, hang_after=hang_after, follow=follow
    )


def run_grid(
    grid: Grid,
    *,
    by: str | None = None,
    jobs: int | None = 1,
    executor: Executor | None = None,
    out: str | os.PathLike[str] | None = None,
    parquet: bool = False,
    hang_after: float = PATIENCE_S,
    follow: pool.Progress | None = None,
    announce: Announce | None = None,
) -> Swept:
    """:func:`sweep` of a grid that was built before. Under mpirun every rank calls it, and rank 0 returns the table.

    ``announce`` is called with what the sweep is expected to cost, before it starts.
    """
    number = pool.jobs_of(jobs)
    if not hang_after > 0.0:
        raise UsageError(explain("--hang-after is out of range", hang_after, "above 0 s", "change it"))
    if world().size > 1 and not type(executor).__module__.startswith("mpi4py"):
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
    if parquet:
        require_parquet()
    rungs = Rungs(by)
    if world().rank > 0 and executor is None:
        with pool.ranks():
            return Swept(None, (), {})
    scratch = tempfile.TemporaryDirectory(prefix="beadband-sweep-") if out is None else None
    with Store(scratch.name if scratch is not None else os.fspath(out or ""), grid) as store:
        expected = estimate(grid, store.columns, rungs, number if executor is None else jobs or 1, store.kept)
        described = {"grid": grid.as_dict(), "by": by, "columns": [asdict(column) for column in store.columns]}
        store.note(_json({**described, "estimate": expected.as_dict()}))
        if announce:
            announce(expected)
        work = _Work(grid, rungs, store, expected, follow)
        work.release(number if executor is None else jobs, executor, hang_after)
        totals = Totals(store.columns)
        store.put_in_order(rungs.blocks(grid), totals.add)
        drawn = pictures.draw(totals, store.folder) if scratch is None else []
        if parquet:
            write_parquet(store.table, store.columns)
        found = {**described, **totals.as_dict(), "estimate": expected.as_dict()}
        found |= {"run": work.as_dict(number if executor is None else None, totals), "versions": _versions()}
        store.finish(_json(found))
    return Swept(store.table, store.columns, found, tuple(drawn), scratch)


class _Work:
    """The releases of a sweep, and what they took."""

    def __init__(
        self, grid: Grid, rungs: Rungs, store: Store, expected: Estimate, follow: pool.Progress | None
    ) -> None:
        self._grid, self._rungs, self._store, self._expected = grid, rungs, store, expected
        self._follow = follow or (lambda done, total: None)
        self._start = time.perf_counter()
        self._done = self._released = self._worker_bytes = 0
        self._busy_s = self._lammps_s = self._release_s = 0.0

    def release(self, jobs: int | None, executor: Executor | None, hang_after_s: float) -> None:
        """Release what is missing, and write its rows as they come."""
        self._follow(self._store.kept, len(self._grid))
        expected = self._expected
        chunk = max(1, min(_CHUNK, round(MOST_BATCH_S / expected.run_s))) if expected.run_s else _CHUNK
        with pool.ranks() if executor is None else nullcontext(executor) as given:
            for place, values, outcome in pool.run_numbered(
                RELEASE,
                self._missing(),
                expected.runs,
                jobs=jobs,
                executor=given,
                chunk=chunk,
                forgiving=True,
                patience_s=hang_after_s,
                expected_s=lambda scenes: _LATE * sum(map(seconds_of, scenes)),
            ):
                if isinstance(outcome, pool.Failed):
                    row = without_result(values, outcome)
                else:
                    row = outcome.row
                    self._busy_s, self._lammps_s = self._busy_s + outcome.seconds, self._lammps_s + outcome.lammps_s
                    self._worker_bytes = max(self._worker_bytes, outcome.peak_bytes)
                self._store.add([(place, row)])
                self._released += 1
                self._done += 1
                self._follow(self._done, len(self._grid))
        self._release_s = time.perf_counter() - self._start

    def _missing(self) -> Iterator[tuple[int, Values]]:
        """Scenes that are to be released, each with its place."""
        for block in self._rungs.blocks(self._grid):
            for place, (values, known) in enumerate(zip(block.scenes, block.known.tolist(), strict=True), block.first):
                if known or self._store.has(place):
                    self._done += 1
                else:
                    yield place, values

    def as_dict(self, jobs: int | None, totals: Totals) -> dict[str, Any]:
        """What the sweep took, for sweep.json; ``jobs`` is None on an executor."""
        wall = time.perf_counter() - self._start
        answered = totals.models["formula"]
        new = self._released + answered
        return {
            "jobs": world().size if jobs and world().size > 1 else jobs,
            "released": self._released,
            "by_formula": answered,
            "wall_s": wall,
            "scenes_per_s": new / wall if new else None,
            "lammps_share": self._lammps_s / self._busy_s if self._busy_s else None,
            "busy_share": self._busy_s / (self._release_s * jobs) if jobs and self._busy_s else None,
            "peak_bytes": {"first_process": peak_bytes(), "largest_worker": self._worker_bytes or None},
            "disk_bytes": self._store.table.stat().st_size,
        }


def _json(values: dict[str, Any]) -> str:
    return json.dumps(values, indent=1, allow_nan=False) + "\n"


def _versions() -> dict[str, str]:
    from beadband.runs.results import versions

    with Session() as session:
        return versions(session.run("", {}))
