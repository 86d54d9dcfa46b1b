"""The one pool of every study: many tasks in this process, in spawned ones, on ranks, or on an executor that is given.

A task that raises a :class:`BeadbandError` has the outcome :class:`Failed`, with the error's code; any other exception
is a fault and ends the work.
"""

from __future__ import annotations

import os
import reprlib
import threading
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import closing, contextmanager
from dataclasses import dataclass
from itertools import islice
from typing import Any, Generic, TypeVar

from beadband.errors import BeadbandError, UsageError, explain
from beadband.lammps.engine import Session
from beadband.lammps.ranks import world
from beadband.studies import engines
from beadband.studies.engines import Chunk, fault_of

T = TypeVar("T")
R = TypeVar("R")
Progress = Callable[[int, int], None]
"""Called with the number of tasks that are done, and of all."""

MOST_JOBS = 1024


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
    progress: Progress | None = None,
    **options: Any,
) -> Generator[tuple[int, R | Failed], None, None]:
    """Call a function with every item; yield (index, outcome) as the tasks are completed.

    ``progress`` is called with the number of tasks that are done, and of all. The rest as :func:`run_numbered`.
    """
    with closing(run_numbered(function, enumerate(items), len(items), **options)) as completed:
        for done, (index, _, outcome) in enumerate(completed, 1):
            yield index, outcome
            if progress:
                progress(done, len(items))


def run_numbered(
    function: Callable[[T], Any] | Together[T, Any],
    tasks: Iterable[tuple[int, T]],
    total: int,
    *,
    jobs: int | None = None,
    executor: Executor | None = None,
    chunk: int = 1,
    forgiving: bool = False,
    patience_s: float = engines.PATIENCE_S,
    expected_s: Callable[[list[T]], float] | None = None,
) -> Generator[tuple[int, T, Any], None, None]:
    """Call a function with every item; yield (number, item, outcome) as the tasks are completed.

    Parameters
    ----------
    function, tasks
        Tasks are numbers with items, taken one by one as there is room for them; ``total`` is about how many there
        are. Function and items can be pickled, unless everything happens in this process. A :class:`Together` is
        called with the items of a chunk.
    jobs
        Spawned processes; None for one per core. With 1 the tasks run in this process, in order.
    executor
        Runs the tasks instead of spawned processes, and is left open; ``jobs`` then is the number of its workers, None
        or 1 where it says so itself. Tasks that share a process, as on threads, take turns: LAMMPS changes the working
        directory.
    chunk
        Most tasks that are handed over at once.
    forgiving
        A task that raises is done again, at most twice, and then :class:`Failed`; otherwise its exception ends the
        work.
    patience_s, expected_s
        Seconds, beyond those expected of a list of items, after which a worker counts as hung.

    Raises
    ------
    RunError
        The processes do not start, or the executor broke (code "worker-died"). A spawned process that dies or hangs is
        replaced, and a task over which workers were lost three times, the last two alone, is :class:`Failed`.

    Whatever ends the work early, Ctrl-C, an exception or closing the generator, cancels the tasks that have not begun.
    """
    workers = jobs_of(jobs)
    if executor is not None:
        engine = engines.given(executor, None if jobs in (None, 1) else jobs)
    else:
        engine = engines.here() if workers == 1 else engines.processes(workers)
    alone = engine.ahead == 1 and not isinstance(function, Together)
    size = 1 if alone else max(1, min(chunk, total // (4 * max(workers, engine.workers))))
    ledger = engines.Ledger(_chunks(tasks, size), forgiving)
    try:
        with closing(
            engines.work_through(engine, _work, function, ledger, patience_s, expected_s or (lambda _: 0.0))
        ) as completed:
            for settled in completed:
                for number, item, outcome in settled:
                    lost = isinstance(outcome, engines.Lost)
                    yield number, item, Failed(outcome.code, outcome.reason) if lost else outcome
    finally:
        close_session()


def _chunks(tasks: Iterable[tuple[int, T]], size: int) -> Iterator[Chunk]:
    rest = iter(tasks)
    while some := list(islice(rest, size)):
        yield some


@contextmanager
def ranks() -> Iterator[Executor | None]:
    """Under mpirun an executor of all other ranks, on the first one; None without mpirun.

    Every rank enters. The others work inside, then get None. Where one of them hangs the first does not wait for it:
    all are to be ended (:func:`beadband.lammps.ranks.stop_others`).
    """
    if world().size == 1:
        yield None
        return
    from mpi4py.futures import MPICommExecutor

    context: Any = MPICommExecutor(world().comm, root=0)
    executor: Any = context.__enter__()
    try:
        yield executor
    finally:
        if not engines.left_behind():
            engines.end(lambda: context.__exit__(None, None, None))


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


def _work(function: Task[Any, Any], chunk: Chunk, lost: int) -> list[tuple[int, Any]]:
    """Some tasks in this process, each with its number; an exception that is a fault carries a note with its item.

    ``lost`` is how often they were lost: engines that know a call by its arguments see another one.
    """
    with _turn:
        if isinstance(function, Together):
            return _work_together(function, chunk)
        return [(index, _outcome(function, index, item)) for index, item in chunk]


def _outcome(function: Callable[[Any], Any], index: int, item: Any) -> Any:
    try:
        return function(item)
    except BeadbandError as error:
        return Failed.of(error)
    except Exception as error:  # noqa: BLE001  handed over: the one who asked decides
        error.add_note(f"in task {index}: {reprlib.repr(item)}")
        return fault_of(error)


def _work_together(function: Together[Any, Any], chunk: Chunk) -> list[tuple[int, Any]]:
    try:
        found = function.function([item for _, item in chunk])
    except Exception as error:  # noqa: BLE001  handed over: the one who asked decides
        error.add_note(f"in tasks {chunk[0][0]} to {chunk[-1][0]}, of which the first is {reprlib.repr(chunk[0][1])}")
        fault = fault_of(error)
        return [(index, fault) for index, _ in chunk]
    return [
        (index, Failed.of(one) if isinstance(one, BeadbandError) else one)
        for (index, _), one in zip(chunk, found, strict=True)
    ]
