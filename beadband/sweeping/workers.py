"""Who does the work: this process, several on one machine, or the ranks of mpirun; all give the same rows."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import Any

from beadband.engine import Session
from beadband.errors import UsageError, explain
from beadband.parallel import world
from beadband.sweeping.grid import Values
from beadband.sweeping.row import FAILED, key_of, release

BATCH_S = 0.25
"""Aimed-at seconds of work that are handed over at once."""
_SCENE_S = 0.012
_DEATHS_ALLOWED = 2
"""Deaths of a worker over the same scenes before they are given up one by one."""

_session: Session | None = None

Batch = tuple[list[dict[str, Any]], float, float]
"""Rows, and the seconds spent on them and inside LAMMPS."""


def work(scenes: list[Values]) -> Batch:
    """Release some scenes in this process, whose LAMMPS is kept for the next ones."""
    global _session
    if _session is None:
        _session = Session()
    start, inside = time.perf_counter(), _session.runs_s
    rows = [release(values, _session) for values in scenes]
    return rows, time.perf_counter() - start, _session.runs_s - inside


def lammps_version() -> str:
    """Version of LAMMPS, as it calls itself."""
    with Session() as session:
        return session.run("", {})


def rest() -> None:
    """Close this process' LAMMPS."""
    global _session
    if _session is not None:
        _session.close()
        _session = None


def run(scenes: Sequence[Values], jobs: int) -> Iterator[Batch]:
    """Release all scenes and yield batches of rows as they finish, in no order.

    Under ``mpirun`` the first rank hands out the work and ``jobs`` is not asked; call it on every rank, the others
    yield nothing and return when the work is done.
    """
    if world().size > 1:
        yield from _with_ranks(scenes)
    elif jobs == 1:
        try:
            for batch in _batches(scenes, 1):
                yield work(batch)
        finally:
            rest()
    else:
        yield from _with_processes(scenes, jobs)


def _batches(scenes: Sequence[Values], workers: int) -> list[list[Values]]:
    """Large enough to hide the handing over, small enough that all workers end together."""
    size = max(1, min(round(BATCH_S / _SCENE_S), len(scenes) // (4 * workers)))
    return [list(scenes[i : i + size]) for i in range(0, len(scenes), size)]


def _with_ranks(scenes: Sequence[Values]) -> Iterator[Batch]:
    from mpi4py.futures import MPICommExecutor

    here = world()
    with MPICommExecutor(here.comm, root=0) as executor:
        if executor is not None:
            for future in as_completed(_hand_out(executor, _batches(scenes, here.size - 1))):
                yield future.result()


def _hand_out(executor: Any, batches: list[list[Values]]) -> dict[Future[Batch], list[Values]]:
    return {executor.submit(work, batch): batch for batch in batches}


def _with_processes(scenes: Sequence[Values], jobs: int) -> Iterator[Batch]:
    """Spawned processes, for LAMMPS and MPI do not survive a fork. A worker that dies is replaced."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    waiting = _batches(scenes, jobs)
    deaths = 0
    while waiting:
        again: list[list[Values]] = []
        pool = ProcessPoolExecutor(jobs, mp_context=get_context("spawn"))
        try:
            handed = _hand_out(pool, waiting)
            for future in as_completed(handed):
                try:
                    yield future.result()
                except BrokenProcessPool:
                    again.append(handed[future])
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
        if again:
            deaths += 1
            if deaths > _DEATHS_ALLOWED and all(len(batch) == 1 for batch in again):
                yield from _given_up(again)
                return
            # Smaller portions, so that the scene that kills its worker is found.
            again = [[values] for batch in again for values in batch] if deaths >= _DEATHS_ALLOWED else again
        waiting = again


def _given_up(batches: list[list[Values]]) -> Iterator[Batch]:
    reason = explain("the worker died over this scene", "a killed process", "memory enough for it", "run it alone")
    for (values,) in batches:
        yield [{"key": key_of(values), **values, "status": FAILED, "reason": reason}], 0.0, 0.0


def check_jobs(jobs: int | None) -> int:
    """Number of processes; one for each core that this process may use unless told."""
    if jobs is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if not 1 <= jobs <= 1024:
        raise UsageError(explain("the number of jobs is out of range", jobs, "1 to 1024", "mend --jobs"))
    return jobs
