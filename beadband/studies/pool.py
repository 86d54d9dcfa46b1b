"""The one pool of every study: many tasks in this process, in spawned ones, on ranks, or on an executor that is given.

A task that raises a :class:`BeadbandError` has the outcome :class:`Failed`, with the error's code; any other exception
is a fault and ends the work.
"""

from __future__ import annotations

import os
import reprlib
import signal
import threading
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from queue import SimpleQueue
from typing import Any, Generic, TypeVar

from beadband.errors import BeadbandError, RunError, UsageError, explain
from beadband.lammps.engine import Session
from beadband.lammps.ranks import world

T = TypeVar("T")
R = TypeVar("R")
Progress = Callable[[int, int], None]
"""Called with the number of tasks that are done, and of all."""

MOST_JOBS = 1024
WORKER_DIED = "worker-died"
"""Code of a task over which its process died, and of an executor that broke."""
_DEATHS_ALONE = 2
"""Deaths of a process over one task, with nothing else handed out, before the task counts as failed."""


@dataclass(frozen=True)
class Failed:
    """Outcome of a task without a result."""

    code: str
    """That of the error."""
    reason: str
    """The sentence of the error."""
    refused: bool = False
    """Whether the request had no answer (UsageError); otherwise it was sound and the run failed."""

    @classmethod
    def of(cls, error: BeadbandError) -> Failed:
        return cls(error.code, str(error), isinstance(error, UsageError))


@dataclass(frozen=True)
class Together(Generic[T, R]):
    """A function that does many tasks at once for less than one by one."""

    function: Callable[[list[T]], list[R | BeadbandError]]
    """Gives for each item its result, or the error for which it has none. No result depends on the other items."""


Task = Callable[[T], R] | Together[T, R]
Chunk = list[tuple[int, T]]
"""Tasks that are handed over at once, each with its place among the items."""
Outcomes = list[tuple[int, R | Failed]]


def jobs_of(jobs: int | None) -> int:
    """Number of processes; None is one per core that this process may use. UsageError when out of range."""
    if jobs is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if not 1 <= jobs <= MOST_JOBS:
        raise UsageError(explain("the number of jobs is out of range", jobs, f"1 to {MOST_JOBS}", "change --jobs"))
    return jobs


def run_all(function: Task[T, R], items: Sequence[T], **options: Any) -> list[R | Failed]:
    """Outcomes of :func:`run_tasks`, with its options, in the order of the items."""
    found: dict[int, R | Failed] = {}
    for index, outcome in run_tasks(function, items, **options):
        found[index] = outcome
    return [found[index] for index in range(len(items))]


def run_tasks(
    function: Task[T, R],
    items: Sequence[T],
    *,
    jobs: int | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
    chunk: int = 1,
) -> Generator[tuple[int, R | Failed], None, None]:
    """Call a function with every item; yield (index, outcome) as the tasks are completed.

    Parameters
    ----------
    function, items
        Both can be pickled, unless everything happens in this process. A :class:`Together` is called with the items of
        a chunk.
    jobs
        Spawned processes; None for one per core. With 1 the tasks run in this process, in order.
    executor
        Runs the tasks instead of spawned processes, and is left open; ``jobs`` then is the number of its workers.
        Tasks that share a process, as on threads, take turns: LAMMPS changes the working directory.
    chunk
        Most tasks that are handed over at once.

    Raises
    ------
    RunError
        The processes do not start, or the executor broke (code "worker-died"). A spawned process that dies later is
        replaced, and only a task that kills its process again, alone, is :class:`Failed`.

    Whatever ends the work early, Ctrl-C, an exception or closing the generator, cancels the tasks that have not begun.
    """
    workers = jobs_of(jobs)
    size = max(1, min(chunk, len(items) // (4 * workers)))
    tasks = list(enumerate(items))
    chunks = deque(tasks[first : first + size] for first in range(0, len(tasks), size))
    singles = ([task] for task in tasks)
    completed: Generator[Outcomes[R], None, None]
    if executor is not None:
        completed = _on_executor(executor, function, chunks)
    elif workers == 1:
        completed = (_work(function, some) for some in (chunks if isinstance(function, Together) else singles))
    else:
        completed = _on_processes(function, chunks, workers)
    done = 0
    try:
        with closing(completed):
            for outcomes in completed:
                for index, outcome in outcomes:
                    yield index, outcome
                    done += 1
                    if progress:
                        progress(done, len(items))
    finally:
        close_session()


@contextmanager
def ranks() -> Iterator[Executor | None]:
    """Under mpirun an executor of all other ranks, on the first one; None without mpirun.

    Every rank enters. The others work inside, then get None.
    """
    if world().size == 1:
        yield None
        return
    from mpi4py.futures import MPICommExecutor

    executor: Any
    with MPICommExecutor(world().comm, root=0) as executor:
        yield executor


_turn = threading.RLock()
_session: Session | None = None


def session() -> Session:
    """LAMMPS of this process, kept from task to task; for use within a task."""
    global _session
    if _session is None:
        _session = Session()
    return _session


def close_session() -> None:
    """Close this process' LAMMPS, if a task opened it."""
    global _session
    with _turn:
        if _session is not None:
            _session.close()
            _session = None


def _work(function: Task[T, R], chunk: Chunk[T]) -> Outcomes[R]:
    """Some tasks in this process; an exception that is a fault carries a note with its item."""
    outcomes: Outcomes[R] = []
    with _turn:
        if isinstance(function, Together):
            return _work_together(function, chunk)
        for index, item in chunk:
            try:
                outcomes.append((index, function(item)))
            except BeadbandError as error:
                outcomes.append((index, Failed.of(error)))
            except Exception as error:
                error.add_note(f"in task {index}: {reprlib.repr(item)}")
                raise
    return outcomes


def _work_together(function: Together[T, R], chunk: Chunk[T]) -> Outcomes[R]:
    try:
        found = function.function([item for _, item in chunk])
    except Exception as error:
        error.add_note(f"in tasks {chunk[0][0]} to {chunk[-1][0]}, of which the first is {reprlib.repr(chunk[0][1])}")
        raise
    return [
        (index, Failed.of(one) if isinstance(one, BeadbandError) else one)
        for (index, _), one in zip(chunk, found, strict=True)
    ]


def _completed(
    executor: Executor, work: Callable[[Chunk[T]], Outcomes[R]], waiting: deque[Chunk[T]], ahead: int
) -> Generator[tuple[Chunk[T], Future[Outcomes[R]]], None, None]:
    """Chunks with their futures as they are completed; at most ``ahead`` of them are handed out at a time.

    Nothing more is handed out once the executor broke.
    """
    finished: SimpleQueue[Future[Outcomes[R]]] = SimpleQueue()
    handed: dict[Future[Outcomes[R]], Chunk[T]] = {}
    try:
        while handed or (waiting and ahead):
            while waiting and len(handed) < ahead:
                try:
                    future = executor.submit(work, waiting[0])
                except BrokenExecutor as error:
                    future = Future()
                    future.set_exception(error)
                handed[future] = waiting.popleft()
                future.add_done_callback(finished.put)
            future = finished.get()
            if not future.cancelled() and isinstance(future.exception(), BrokenExecutor):
                ahead = 0
            yield handed.pop(future), future
    finally:
        for future in handed:
            future.cancel()


def _on_executor(
    executor: Executor, function: Task[T, R], chunks: deque[Chunk[T]]
) -> Generator[Outcomes[R], None, None]:
    for _, future in _completed(executor, partial(_work, function), chunks, len(chunks)):
        try:
            yield future.result()
        except BrokenExecutor as error:
            raise RunError(
                explain("a worker of the executor died", error, "workers that live", "start again"), WORKER_DIED
            ) from error


def _on_processes(function: Task[T, R], chunks: deque[Chunk[T]], jobs: int) -> Generator[Outcomes[R], None, None]:
    """Spawned processes. The tasks that were handed out when one died are repeated one at a time, to find the cause."""
    # More threads than cores slow small systems down; a setting of the user's stays.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    suspects: deque[Chunk[T]] = deque()
    deaths: Counter[int] = Counter()
    while chunks or suspects:
        if not suspects:
            lost = yield from _until_death(function, chunks, min(jobs, len(chunks)), 2 * jobs)
            suspects.extend([task] for chunk in lost for task in chunk)
            continue
        for ((index, item),) in (yield from _until_death(function, suspects, 1, 1)):
            deaths[index] += 1
            if deaths[index] < _DEATHS_ALONE:
                suspects.appendleft([(index, item)])
                continue
            reason = explain("the process died over this task", "a killed process", "enough memory", "run it alone")
            yield [(index, Failed(WORKER_DIED, str(reason)))]


def _until_death(
    function: Task[T, R], waiting: deque[Chunk[T]], jobs: int, ahead: int
) -> Generator[Outcomes[R], None, list[Chunk[T]]]:
    """Take from what is waiting until nothing is left, or a process dies; return the chunks that this lost."""
    # Spawned, for LAMMPS and MPI do not survive a fork.
    pool = ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_watch_interrupts)
    lost = []
    try:
        started = pool.submit(_started)
        for chunk, future in _completed(pool, partial(_work_until_interrupted, function), waiting, ahead):
            try:
                yield future.result()
            except BrokenExecutor as error:
                if started.exception() is not None:
                    raise RunError(
                        explain(
                            "the worker processes did not start",
                            error,
                            'a script whose work stands under if __name__ == "__main__"',
                            "or use one job",
                        ),
                        WORKER_DIED,
                    ) from error
                lost.append(chunk)
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
    return lost


def _started() -> None:
    """The first task of a pool: it fails only where its processes can't start."""


_busy = _interrupted = False


def _watch_interrupts() -> None:
    """Ctrl-C reaches all processes of a terminal: it ends the task of this one, and an idle one stays silent."""

    def interrupt(*_: object) -> None:
        global _interrupted
        _interrupted = True
        if _busy:
            raise KeyboardInterrupt

    signal.signal(signal.SIGINT, interrupt)


def _work_until_interrupted(function: Task[T, R], chunk: Chunk[T]) -> Outcomes[R]:
    global _busy
    if _interrupted:
        raise KeyboardInterrupt
    _busy = True
    try:
        return _work(function, chunk)
    finally:
        _busy = False
